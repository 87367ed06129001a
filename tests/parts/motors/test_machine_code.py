"""Machine code of motors is kept between processes, in a folder of the user's own, and its loss is never an error."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from slewline.folders import cache_folder, keep_source, state_folder
from slewline.parts.motors import operations
from slewline.parts.motors.integration import numba_is_there

needs_numba = pytest.mark.skipif(not numba_is_there(), reason="Numba is not installed")
TEXTS = (
    "def after(x):\n    return minimum(x * 1.5, 4.0)",
    "def advance(x):\n    return after(x) + floor(x)",
)
# Prints what was compiled, all of it, and the result to the last bit.
PROCESS = f"""
from numba.core import event
from slewline.parts.motors.operations import machine_code
with event.install_recorder("numba:compile") as record:
    functions = machine_code({TEXTS!r})
    result = functions["advance"](2.1), functions["after"](1.1)
print(sum(each.is_start for _, each in record.buffer), *(each.hex() for each in result))
"""
RESULT = [each.hex() for each in (2.1 * 1.5 + 2.0, 1.1 * 1.5)]


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "new" / "cache"
    monkeypatch.setenv("SLEWLINE_CACHE", str(folder))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    return folder


def begin(code: str = PROCESS) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, "-W", "error", "-c", code], stdout=pipe, stderr=pipe, text=True)


def compiled(process: subprocess.Popen[str]) -> int:
    """How many functions a process has compiled; its results are right to the last bit."""
    said, complaint = process.communicate(timeout=60)
    assert not complaint
    count, *result = said.split()
    assert result == RESULT
    return int(count)


@needs_numba
@pytest.mark.check
def test_code_kept_by_two_processes_together_need_not_be_compiled_by_a_third_one(cache: Path) -> None:
    # One at least has nothing to find; the other one compiles too, or was slower and finds it.
    assert any([compiled(each) > 0 for each in [begin(), begin()]])
    assert compiled(begin()) == 0
    assert len(list(cache.glob("*.py"))) == 1 and not list(cache.glob("*.part"))


def kept(texts: tuple[str, ...] = TEXTS) -> float:
    return float(operations.machine_code(texts)["advance"](2.1))


def compilations(texts: tuple[str, ...]) -> int:
    """How many functions are compiled, with nothing but files from earlier times."""
    from numba.core import event

    with event.install_recorder("numba:compile") as record:
        kept(texts)
    return sum(each.is_start for _, each in record.buffer)


@needs_numba
@pytest.mark.parametrize("data", (None, b"of somebody else"), ids=("cut", "replaced"))
@pytest.mark.parametrize("kind", ("py", "nbi", "nbc"))
def test_a_damaged_file_costs_no_more_than_the_time(cache: Path, kind: str, data: bytes | None) -> None:
    alone = ("def advance(x):\n    return x * 1.5",)
    assert compilations(alone) == 1 and compilations(alone) == 0
    (path,) = cache.rglob(f"*.{kind}")
    path.write_bytes(path.read_bytes()[:100] if data is None else data)
    found = [compilations(alone) for _ in range(3)]
    # The text is written anew; machine code is removed, and kept again next time.
    assert found == ([0, 0, 0] if kind == "py" else [1, 1, 0])


# ------------------------------------------------------------------------------------------------ whose folder it is
@needs_numba
def test_another_text_and_another_numba_have_another_key(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import numba

    one = kept()
    assert kept((TEXTS[0].replace("1.5", "1.25"), TEXTS[1])) == 2.1 * 1.25 + 2.0
    monkeypatch.setattr(numba, "__version__", "0.0.1")
    assert kept() == one
    assert len(list(cache.glob("*.py"))) == 3


@needs_numba
def test_where_nothing_is_kept_numba_compiles_as_ever(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SLEWLINE_CACHE", "")
    assert cache_folder() is None and keep_source("") is None
    assert kept() == 2.1 * 1.5 + 2.0
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_made_keeps_nothing(cache: Path) -> None:
    cache.parent.write_text("a file")
    assert keep_source("") is None


def test_a_folder_that_cannot_be_written_keeps_nothing(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache.mkdir(parents=True, mode=0o700)
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write wherever he likes
    assert keep_source("") is None
    assert not list(cache.iterdir())


@needs_numba
def test_a_full_disk_is_tolerated(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from numba.core import caching

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(caching.IndexDataCacheFile, "_save_data", full)
    assert kept() == 2.1 * 1.5 + 2.0


@needs_numba
def test_an_error_of_a_function_is_its_own(cache: Path) -> None:
    from numba.core.errors import TypingError

    advance = operations.machine_code(TEXTS)["advance"]
    for _ in range(2):
        with pytest.raises(TypingError):
            advance("no number")
    assert advance(2.1) == 2.1 * 1.5 + 2.0


@pytest.mark.posix
def test_files_that_others_may_have_written_are_not_trusted(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache.mkdir(parents=True)
    for mode in (0o770, 0o702):
        cache.chmod(mode)
        assert keep_source("") is None
    cache.chmod(0o755)
    assert keep_source("") is not None
    monkeypatch.setattr(os, "geteuid", lambda: cache.stat().st_uid + 1)
    assert keep_source("") is None


@pytest.mark.posix
def test_the_folder_is_made_for_the_user_alone(cache: Path) -> None:
    assert keep_source("") is not None
    assert cache.stat().st_mode & 0o777 == 0o700


@pytest.mark.posix
def test_where_this_system_keeps_it(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("SLEWLINE_CACHE", raising=False)
    monkeypatch.setattr(sys, "platform", "linux")
    for variable, folder in (("XDG_STATE_HOME", state_folder), ("XDG_CACHE_HOME", cache_folder)):
        monkeypatch.setenv(variable, str(tmp_path / variable))
        assert folder() == tmp_path / variable / "slewline"
