"""Text files as editors of other systems write them: every reader takes a byte order mark, and any line end."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mutated import READERS, Samples

pytestmark = pytest.mark.system
BOM = b"\xef\xbb\xbf"
OURS = ("black box", "tune log")  # which only our own code writes, and goes on with: nothing that is edited
VARIANTS = {
    "mark": lambda data: BOM + data,
    "returns": lambda data: data.replace(b"\n", b"\r\n"),
    "both": lambda data: BOM + data.replace(b"\n", b"\r\n"),
    "blank lines at the end": lambda data: data + b"\n\r\n",
}


@pytest.fixture(scope="module")
def samples(tmp_path_factory: pytest.TempPathFactory) -> Samples:
    return Samples(tmp_path_factory.mktemp("samples"))


@pytest.mark.parametrize("kind", [kind for kind in READERS if kind not in OURS])
def test_a_text_file_is_read_however_it_was_saved(samples: Samples, subtests: pytest.Subtests, kind: str) -> None:
    texts = [path for path in samples.paths[kind] if path.suffix not in (".bin", ".eeprom")]
    assert texts
    for path in texts:
        for name, change in VARIANTS.items():
            with subtests.test(file=path.name, variant=name):
                assert isinstance(path, Path) and samples.read(kind, path, change(samples.data[path])) == "read"
