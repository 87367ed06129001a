"""What a decoder says that it only keeps: fed byte by byte, none of it ends a command, and nothing is wrong with it."""

from __future__ import annotations

from random import Random

import pytest

from slewline.chips import sheet_of
from slewline.language.dialect import spoken_as
from slewline.language.text import TextDialect

CHARACTERS = b'RNSFGQ?EA+-BLT["/$#, 0123456789H\r\r\r\n\xff\x00\x01\x02\x03'


@pytest.mark.parametrize("part", ["cy500", "cy512", "cy525", "cy545"])
@pytest.mark.parametrize("ascii", [True, False])
def test_keeping_bytes_changes_nothing_but_the_line(part: str, ascii: bool) -> None:
    sheet, rnd, kept_in_all = sheet_of(part), Random(f"kept {part} {ascii}"), 0
    dialect = spoken_as(sheet, TextDialect)
    for _ in range(400):
        one, two, at = dialect.decoder(sheet), dialect.decoder(sheet), 0
        data = bytes(rnd.choice(CHARACTERS) for _ in range(40))
        while at < len(data):
            kept = two.kept(data, at, ascii)
            for byte in data[at : at + kept]:
                assert one.feed(byte, ascii) is None and not one.notes, (data, at, kept)
            if kept:
                two.keep(data[at : at + kept], ascii)
                at, kept_in_all = at + kept, kept_in_all + kept
            else:
                assert one.feed(data[at], ascii) == two.feed(data[at], ascii)
                at += 1
            assert (one.at_letter, one.unfinished, one.take_notes()) == (
                two.at_letter,
                two.unfinished,
                two.take_notes(),
            )
    assert kept_in_all > 2000


def test_a_whole_command_is_kept_up_to_its_return() -> None:
    sheet = sheet_of("cy525")
    decoder = spoken_as(sheet, TextDialect).decoder(sheet)
    assert decoder.kept(b"R 100\rN 5\r", 0, True) == 5
    assert decoder.kept(b"R 100\rN 5\r", 6, True) == 3
    assert decoder.kept(b"A$", 0, True) == 1
    assert decoder.kept(b"\x52\x01\x64", 0, False) == 2
    assert decoder.kept(b"Q", 0, True) == 0
