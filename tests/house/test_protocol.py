"""The headers of the firmware are what the messages of the host are."""

from __future__ import annotations

import re

import pytest

from slewline.drive.board import wire
from tools import protocol

pytestmark = pytest.mark.check


FIRMWARE = protocol.ROOT / "firmware"


def names(text: str) -> set[str]:
    """What a text defines."""
    return {name for name in re.findall(r"^#define (\w+)", text, re.MULTILINE) if not name.endswith("_H")}


@pytest.mark.parametrize("path", protocol.headers(), ids=lambda path: path.name)
def test_a_header_agrees_with_the_messages(path) -> None:
    assert path.read_text("ascii") == protocol.headers()[path], "run: python tools/protocol.py"


def test_the_command_finds_nothing_wrong() -> None:
    assert protocol.main(["--check"]) == 0


def test_every_name_of_the_messages_is_in_it() -> None:
    text = protocol.headers()[protocol.MESSAGES]
    defined = dict(re.findall(r"^#define (\w+) (\w+)", text, re.MULTILINE))
    assert defined["EVENT_ESTOP"] == str(int(wire.Happening.ESTOP)) and defined["RECORD_RAMP_LEFT_BIT"] == "6"
    for prefix, kind in protocol.GROUPS:
        assert {name for name in defined if name.startswith(f"{prefix}_")} >= {f"{prefix}_{each.name}" for each in kind}


def test_no_file_of_the_firmware_gives_one_of_its_names_another_value() -> None:
    written = protocol.headers()
    known = set().union(*map(names, written.values()))
    for path in FIRMWARE.rglob("*.[chS]"):
        if path not in written:
            assert not known & names(path.read_text("ascii")), path
