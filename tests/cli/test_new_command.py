"""slewline new-chip and new-part: what they write works as it is, or nothing is written."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from slewline.cli.packages import new_package as module
from slewline.cli.packages.new_package import LONGEST

KINDS = ("chip", "part")


def tool(*words, folder):
    """What a tool says of a package, alone: without the plugins that only happen to be installed here."""
    alone = os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    call = [sys.executable, "-m", *words]
    ran = subprocess.run(call, cwd=folder, env=alone, capture_output=True, text=True, check=False)
    return ran.returncode, ran.stdout + ran.stderr


@pytest.mark.system
@pytest.mark.parametrize("kind", KINDS)
def test_the_tests_of_a_package_pass_and_its_style_is_clean_whatever_its_name(call, kind):
    for name in ("x", "my-own", "a" * (LONGEST // 2) + "-" + "b" * (LONGEST - LONGEST // 2 - 1)):
        ran = call(f"new-{kind}", name)
        assert (ran.status, ran.err) == (0, "")
        assert tool("ruff", "check", "--no-cache", folder=name) == (0, "All checks passed!\n")
        status, said = tool("ruff", "format", "--check", "--no-cache", folder=name)
        assert status == 0, said
    status, said = tool("pytest", "-p", "no:cacheprovider", folder="my-own")
    assert status == 0 and re.search(r"^[4-9] passed", said, re.MULTILINE), said


@pytest.mark.parametrize("kind", KINDS)
def test_every_file_is_named_and_no_word_of_the_template_is_left(call, kind):
    ran = call(f"new-{kind}", "pump-2", "--output", "deep/down")
    place = Path("deep/down/pump-2")
    files = sorted(path for path in place.rglob("*") if path.is_file())
    listed = [Path(line.split("  ")[0]) for line in ran.out.split("\n\n")[0].splitlines()]
    assert sorted(listed) == files and len(files) >= 10
    assert ran.out.endswith(
        f"\nThe generated package passes its tests: pytest {place}\n{place}/README.md has the next steps.\n"
    )
    for path in files:
        text = path.read_text("utf-8")
        assert not re.search(r"new[-_]?(name|kind)", f"{path}\n{text}", re.IGNORECASE), path
        assert {*re.findall(r"^(?:from|import) (slewline\S*)", text, re.MULTILINE)} <= {"slewline", "slewline.build"}
    project = (place / "pyproject.toml").read_text("utf-8")
    assert f'[project.entry-points."slewline.{kind}s"]\npump-2 = "pump_2:Pump2"\n' in project
    assert sorted(os.listdir("deep/down")) == ["pump-2"]


def test_a_fact_without_a_test_and_a_test_without_a_fact_are_found(call):
    call("new-chip", "x")
    table = Path("x/conformance.toml")
    rows = table.read_text("utf-8")
    wrong = {
        rows.replace('id = "LINE"', 'id = "LINES"'): "LINE: a test names it, but no row has it",
        rows + '\n[[fact]]\nid = "N"\nkind = "pin"\nsays = "p. 3"\n': "N: no test proves it",
        rows + '\n[[fact]]\nid = "P"\nid2 = ""\n': "P: no test proves it",
        rows.replace('id = "BUSY"', 'id = "BUSY"\nopen = "later"'): "BUSY: open, but a test proves it",
        rows.replace('id = "CMD-V"', 'id = "LINE"'): "two rows have the same id",
    }
    check = compile(Path("x/tests/test_conformance.py").read_text("utf-8"), "x/tests/test_conformance.py", "exec")
    for text, says in wrong.items():
        table.write_text(text, "utf-8")
        names = {"__file__": str(Path("x/tests/test_conformance.py").resolve()), "__name__": "test_conformance"}
        exec(check, names)
        with pytest.raises(AssertionError, match=re.escape(says)):
            names["test_facts_and_tests_agree"]()


# ---------------------------------------------------------------------------------------------------------- refusals
SHAPE = (
    "expected lower-case letters, digits and single hyphens, beginning with a letter, at most 30 characters, such as "
    "mx10"
)


REFUSED = [
    ("chip", "MX10", f"{SHAPE}; did you mean mx10?"),
    ("chip", "mx_10", f"{SHAPE}; did you mean mx-10?"),
    ("part", "two  lamps", f"{SHAPE}; did you mean two-lamps?"),
    ("chip", "7400", SHAPE),
    ("chip", "", SHAPE),
    ("chip", "../up", f"{SHAPE}; did you mean up?"),
    ("chip", "mx10\n", f"{SHAPE}; did you mean mx10?"),
    ("chip", "a" * 31, f"{SHAPE}; did you mean {'a' * 30}?"),
    ("chip", "cy525", "is a chip that exists already; give another name, such as my-cy525"),
    ("part", "two-clocks", "is a part that exists already; give another name, such as my-two-clocks"),
    ("part", "lambda", "is a keyword of Python; give another name, such as my-lambda"),
    ("part", "none", "is a keyword of Python; give another name, such as my-none"),
    ("chip", "line-chip", "would have the class LineChip, a name in use by Python or slewline.build; give another"),
    ("part", "value-error", "would have the class ValueError, a name in use by Python or slewline.build; give"),
    ("chip", "numpy", "would be the module numpy, whose name is in use; give another name"),
    ("chip", "src", "would be the module src, whose name is in use; give another name"),
    ("chip", "tests", "would be the module tests, whose name is in use; give another name"),
    ("chip", "toml", "would have programs that end in .toml, like other kinds of files; give another name"),
    ("part", "com1", "is a reserved device name of Windows; give another name"),
]


def test_a_name_that_cannot_be_is_refused_with_the_reason(call, folder, subtests):
    for kind, name, says in REFUSED:
        with subtests.test(kind=kind, name=name):
            ran = call(f"new-{kind}", name)
            assert ran.status == 2 and ran.err.startswith(f"slewline: new-{kind} {name!r}: {says}"), ran.err
            assert os.listdir(folder) == []


@pytest.mark.parametrize("made", [os.mkdir, lambda name: Path(name).touch(), lambda name: os.symlink("nowhere", name)])
def test_existing_files_are_left_unchanged(call, folder, made):
    made("x")
    before = Path("x").lstat()
    ran = call("new-part", "x")
    assert (ran.status, ran.out) == (2, "")
    assert ran.err == "slewline: x exists already; give another name, or another folder with --output\n"
    assert os.listdir(folder) == ["x"] and Path("x").lstat() == before


@pytest.mark.parametrize("method", ["write_bytes", "mkdir", "rename"])
@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_where_writing_fails_nothing_is_left(call, folder, monkeypatch, method, error):
    real, calls = getattr(Path, method), []

    def fails(path, *arguments, **options):
        if ".slewline-" in str(path):
            calls.append(path)
            if len(calls) == (1 if method == "rename" else 4):
                raise error
        return real(path, *arguments, **options)

    monkeypatch.setattr(Path, method, fails)
    if isinstance(error, OSError):
        ran = call("new-chip", "x")
        why = "cannot be written (No space left on device); give another folder with --output"
        assert (ran.status, ran.out, ran.err) == (2, "", f"slewline: x {why}\n")
    else:
        with pytest.raises(KeyboardInterrupt):
            module.new("chip", "x", ".")
    assert calls and os.listdir(folder) == []


def test_a_link_in_the_place_of_a_file_being_written_is_not_followed(call):
    Path("elsewhere").mkdir()
    os.symlink("elsewhere", f".slewline-{os.getpid()}.part")
    ran = call("new-chip", "x")
    assert ran.status == 2 and ran.err.startswith("slewline: x cannot be written (File exists); give another folder")
    assert os.listdir("elsewhere") == [] and not os.path.lexists("x")


@pytest.mark.posix
def test_a_folder_that_cannot_be_written_is_named(call):
    Path("file").touch()
    for place, says in (("/proc", "/proc/x cannot be written ("), ("file", "file: cannot create this folder (")):
        ran = call("new-chip", "x", "-o", place)
        assert ran.status == 2 and ran.err.startswith(f"slewline: {says}"), ran.err
        assert ran.err.rstrip().endswith("with --output")
