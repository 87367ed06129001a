"""The header of the firmware is what the messages of the host are."""

from __future__ import annotations

import re

import pytest

from slewline.drive.board import wire
from tools import protocol

pytestmark = pytest.mark.check


def test_the_header_is_what_the_messages_are() -> None:
    assert protocol.HEADER.read_text("ascii") == protocol.header(), "run: python tools/protocol.py"
    assert protocol.main(["--check"]) == 0


def test_every_name_of_the_messages_is_in_it() -> None:
    defined = dict(re.findall(r"^#define (\w+) (\w+)", protocol.header(), re.MULTILINE))
    assert defined["EVENT_ESTOP"] == str(int(wire.Happening.ESTOP)) and defined["RECORD_WAY_BIT"] == "6"
    for prefix, kind in protocol.GROUPS:
        assert {name for name in defined if name.startswith(f"{prefix}_")} >= {f"{prefix}_{each.name}" for each in kind}


def test_no_file_of_the_firmware_gives_one_of_its_names_another_value() -> None:
    names = set(re.findall(r"^#define (\w+)", protocol.header(), re.MULTILINE)) - {"PROTOCOL_H"}
    for path in (protocol.HEADER.parent).iterdir():
        if path != protocol.HEADER:
            assert not names & set(re.findall(r"^#define (\w+)", path.read_text("ascii"), re.MULTILINE)), path
