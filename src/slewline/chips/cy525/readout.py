"""The verify groups (Table VI): what the chip tells about itself, byte by byte."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import sheet

if TYPE_CHECKING:
    from .state import State


def group_bytes(chip: State, group: int, ascii: bool) -> bytes:
    """All bytes of a group as they stand now: position, program, status, parameters.

    The position has the form of the mode in which V was given; the other groups are binary in both modes (s.6).
    """
    if group == 0:
        return b"%05d" % chip.position if ascii else chip.position.to_bytes(2, "big")
    if group == 1:
        return bytes(chip.buffer).ljust(sheet.BUFFER_BYTES, b"\0")
    if group == 2:
        return bytes([0, 0, 0, 0, 0, 0x00 if chip.clockwise else 0x10])
    reg = chip.reg
    return reg["number"].to_bytes(2, "big") + bytes([reg["slope"], reg["rate"], reg["firstrate"], reg["divisor"]])
