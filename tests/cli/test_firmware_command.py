"""slewline firmware: the file of a board, from a release or a checkout, and how it gets onto the board."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.chips.gs_c200.firmware import GsC
from slewline.cli.live import ready_made as module
from slewline.cli.modules import check_board

BUSY = ("--tolerance", "20 s")  # a busy machine makes answers late, none another
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
        ["gs-c200", "--board", "pico"],
        ["uno", "--board", "uno"],
    ]


def test_it_writes_the_file_and_prints_the_next_steps(call, release: Path) -> None:
    ran = call("firmware", "gs-c200s", "--board", "pico", "--from", str(release), "-o", "mine.uf2")
    assert (ran.status, ran.err) == (0, "")
    assert Path("mine.uf2").read_bytes() == CONTENT
    assert ran.out.startswith(f"mine.uf2: 800 bytes, SHA-256 {hashlib.sha256(CONTENT).hexdigest()}\n")
    assert "BOOTSEL" in ran.out


def test_a_missing_image_is_named_with_its_remedy(call, release: Path) -> None:
    ran = call("firmware", "uno")
    assert ran.status == 2
    assert "slewline-uno.hex was not found" in ran.err and "--from" in ran.err and "make boards" in ran.err


def test_a_wrong_name_board_or_extension_is_refused(call, release: Path) -> None:
    assert "did you mean gs-c200s?" in call("firmware", "gsc200s").err
    assert "is only for the board uno" in call("firmware", "uno", "--board", "pico").err
    ran = call("firmware", "gs-c200s", "--from", str(release), "-o", "mine.hex")
    assert ran.status == 2 and "needs the extension .uf2" in ran.err
    assert not Path("mine.hex").exists()


def test_the_places_are_the_build_of_the_checkout_and_here() -> None:
    assert module.next_to_the_wheel() == []  # an editable installation has none
    assert [place.parts[-2:] for place in module.places()] == [("build", "firmware"), ("firmware",), ()]


@pytest.mark.parametrize(
    ("url", "found"),
    [
        ("file:///tmp/a%20b/slewline-1-py3-none-any.whl", ["/tmp/a b/firmware", "/tmp/a b"]),
        ("file:///tmp/slewline", []),
        ("https://host.example/slewline-1-py3-none-any.whl", []),
    ],
)
def test_firmware_is_looked_for_next_to_the_wheel(monkeypatch: pytest.MonkeyPatch, url: str, found: list[str]) -> None:
    class Installed:
        def read_text(self, name: str) -> str:
            return json.dumps({"url": url, "archive_info": {}} if name == "direct_url.json" else {})

    monkeypatch.setattr(module, "distribution", lambda _name: Installed())
    assert [place.as_posix() for place in module.next_to_the_wheel()] == found


# ---------------------------------------------------------------------------------------------------------------- check
@pytest.mark.system
@pytest.mark.parametrize(
    ("url", "more", "exchanges"),
    [
        ("gs-c200s?chs=0", (), 9),
        ("gs-c200s?chs=0", ("--replace",), 25),
        ("gs-c200s?br0=1", ("--replace", "--move"), 48),
        ("gs-c200?chs=0", ("--replace", "--move"), 47),
    ],
)
def test_the_model_passes_its_own_check(call, url: str, more: tuple[str, ...], exchanges: int) -> None:
    part = url.partition("?")[0]
    ran = call("firmware", part, "--check", f"slewline://{url}&rate=1", *more, *BUSY)
    assert ran.status == 0, ran.out + ran.err
    assert ran.out.startswith(f"{part}: {exchanges} exchanges, 0 differences;")


@pytest.mark.system
def test_a_check_twice_needs_no_new_start(call) -> None:
    for _ in range(2):
        assert (
            call(
                "firmware", "gs-c200s", "--check", "slewline://gs-c200s?rate=1&name=again", "--replace", "--move", *BUSY
            ).status
            == 0
        )


@pytest.mark.system
@pytest.mark.parametrize(
    ("line", "answer", "shown"),
    [
        ("V2", "V71", "V2: module V71, model V70"),
        ("T1001", "Y", "T1001: module Y, model E2"),
        ("E", None, "E: module no answer"),
    ],
)
def test_a_fault_of_the_board_is_found(
    call, monkeypatch: pytest.MonkeyPatch, line: str, answer: str | None, shown: str
) -> None:
    whole = GsC.obey

    async def obey(self, item):
        said = await whole(self, item)
        return said if self.name != "faulty" or line.encode() not in item.text else [answer.encode()] if answer else []

    monkeypatch.setattr(GsC, "obey", obey)
    ran = call("firmware", "gs-c200s", "--check", "slewline://gs-c200s?chs=0&rate=1&name=faulty", "--replace", "--move")
    assert ran.status == 1
    assert shown in ran.out


@pytest.mark.system
def test_another_part_is_found(call) -> None:
    ran = call("firmware", "gs-c200s", "--check", "slewline://gs-c200?rate=1&name=other")
    assert ran.status == 1
    assert "V1: module V0" in ran.out and "model V+0" in ran.out


@pytest.mark.system
def test_the_dialogue_can_be_saved(call) -> None:
    call(
        "firmware", "gs-c200s", "--check", "slewline://gs-c200s?rate=1&name=kept", *BUSY, "--dialogue", "said.dialogue"
    )
    assert call("compare", "said.dialogue", *BUSY).status == 0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("gs-c200s", "--move"), "--move: allowed only with --check PORT"),
        (("--check", "p"), "name the firmware on the board"),
        (("uno", "--check", "p"), "uno does not replace a module"),
        (("gs-c200s", "--check", "p", "-o", "x.uf2"), "does not write firmware"),
        (("gs-c200s", "--check", "p", "--move"), "--move: the motor is moved by a program"),
        (("gs-c200", "--check", "p", "--replace"), "ends program entry only with E"),
    ],
)
def test_options_that_contradict_each_other_are_refused(call, words: tuple[str, ...], says: str) -> None:
    ran = call("firmware", *words)
    assert ran.status == 2 and says in ran.err


def test_the_dialogue_leaves_the_eeprom_alone_and_ends_by_itself() -> None:
    lines = check_board.dialogue_for("gs-c200s", replace=True, move=True)
    assert not any(
        line.startswith(("M", "X", "H", "g")) for line in lines
    )  # the EEPROM, and what does not end by itself
