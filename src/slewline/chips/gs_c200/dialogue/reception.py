"""Faults of a received line (E1), checked before its content."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ....language.lines import checksum, framed
from ....language.lines.remedies import is_command, respelled

if TYPE_CHECKING:
    from ....core.datasheet.table import Sheet
    from ....core.wires.serial import Straps
    from ...line import Line


def fault(line: Line, command: str, sheet: Sheet, straps: Straps, longest: int) -> str:
    """Return the fault of a line and its remedy, as text; "" if the line has no fault.

    Args:
        command: the line without its address, including the character in the checksum position.
    """
    if line.faulty:
        here = f"{straps.setting.in_full} ({straps.set_by})"
        remedy = "set the host to the same rate and format, or check the line for noise"
        return f"a parity or framing error: this module is set to {here}; {remedy}"
    if line.too_long:
        return f"the line has more than {longest} characters; end each command with a carriage return"
    if line.checked and line.text[-1] != checksum(line.text[:-1], straps.kept):
        return _checksum(line.text, command, sheet, straps)
    return ""


def _checksum(text: bytes, command: str, sheet: Sheet, straps: Straps) -> str:
    """Return the fault of a line whose checksum is missing or wrong, and its remedy, as text."""
    rest, kept, pin = text[:-1], straps.kept, straps.port.checksum_pin
    wrong = f"checksum {shown(text[-1])}, expected {shown(checksum(rest, kept))} after {rest!r}"
    whole = command if is_command(sheet, command) else respelled(sheet, command)
    meant = text[: len(text) - len(command)] + whole.encode() if whole else rest
    odd = "" if whole == command else ", with spaces or in a different case"
    came = f"; {command.strip()} arrived without one{odd}" if whole else ""
    rule = f"the low seven bits of the sum of its codes{', bit 4 set' * bool(kept)}"
    return (
        f"{wrong}{came}: send {framed(meant, kept=kept)!r}, whose {shown(checksum(meant, kept))} is {rule}; "
        f'or switch checksums off: --strap {pin}=0, straps={{"{pin}": 0}}'
    )


def shown(byte: int) -> str:
    """Return the code of a character, and the character itself if it is printable."""
    return f"{chr(byte)!r} ({byte:#04x})" if 0x20 < byte < 0x7F else f"{byte:#04x}"
