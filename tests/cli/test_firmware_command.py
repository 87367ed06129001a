"""slewline firmware: the file of a board, from a release or a checkout, and how it gets onto the board."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from slewline.cli.live import ready_made as module

CONTENT = b"\x55\x46\x32\x0a" * 200


@pytest.fixture
def release(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a release; nothing is found elsewhere."""
    monkeypatch.setattr(module, "places", list)
    folder = tmp_path / "release"
    folder.mkdir()
    (folder / "slewline-gs-c200s.uf2").write_bytes(CONTENT)
    return folder


def test_without_a_name_it_lists_what_there_is(call) -> None:
    ran = call("firmware")
    assert ran.status == 0
    assert [line.split()[:3] for line in ran.out.splitlines()] == [
        ["gs-c200s", "--board", "pico"],
        ["uno", "--board", "uno"],
    ]


def test_it_writes_the_file_and_says_what_to_do(call, release: Path) -> None:
    ran = call("firmware", "gs-c200s", "--board", "pico", "--from", str(release), "-o", "mine.uf2")
    assert (ran.status, ran.err) == (0, "")
    assert Path("mine.uf2").read_bytes() == CONTENT
    assert ran.out.startswith(f"mine.uf2: 800 bytes, SHA-256 {hashlib.sha256(CONTENT).hexdigest()}\n")
    assert "BOOTSEL" in ran.out


def test_what_is_not_here_is_named_with_its_remedy(call, release: Path) -> None:
    ran = call("firmware", "uno")
    assert ran.status == 2
    assert "slewline-uno.hex is not here" in ran.err and "--from" in ran.err and "make boards" in ran.err


def test_a_wrong_name_board_or_ending_is_refused(call, release: Path) -> None:
    assert "did you mean gs-c200s?" in call("firmware", "gsc200s").err
    assert "is for the board uno alone" in call("firmware", "uno", "--board", "pico").err
    ran = call("firmware", "gs-c200s", "--from", str(release), "-o", "mine.hex")
    assert ran.status == 2 and "needs the ending .uf2" in ran.err
    assert not Path("mine.hex").exists()


def test_the_places_are_the_package_the_checkout_and_here() -> None:
    assert [place.parts[-2:] for place in module.places()] == [("slewline", "firmware"), ("build", "firmware"), ()]
