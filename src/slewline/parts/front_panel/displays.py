"""Displays that a controller writes to: an eight-character LED display, and a serial LCD.

The LED display is an HDSP-211x type.  It has six address lines:

    38 ... 3F   the characters, left to right          30   control word: brightness, flash, blink, clear
    28 ... 2F   rows of the user-defined character     20   number of that character
    00 ... 07   flash: bit 0, one byte per character   all remaining addresses repeat these

The LCD shows text on its right, and the queried parameters on its left, each parameter on its own line.
No legible page documents how a CY325 selects the side of the display for its output; here the output itself
determines the side: `X=00123` CR is a parameter, and anything else is text.
"""

from __future__ import annotations

import re
from copy import deepcopy
from types import MappingProxyType
from typing import Any

from ...core.datasheet.option import Option
from ...core.time.hook import Hook
from ...core.time.kernel import Kernel
from ...core.wires.receiver import Character, Receiver
from ...core.wires.serial import BAUD, TTL, CharacterFormat, bit_clock
from ..base.part import Part
from ..memories.external import WRITE_WIRING, BusInterface, start_bus

CHARACTERS, FIRST, CONTROL = 8, 0x38, 0x30
LINES = 0x3F  # six address lines
BRIGHTNESS = (100, 80, 53, 40, 27, 20, 13, 0)  # percent, selected by the low three bits of the control word
FLASHES, BLINKS, CLEAR = 0x08, 0x10, 0x80  # further bits of the control word
OF_OWN = "\u25a1"  # replaces a user-defined character
PARAMETER = re.compile(rb"([A-Z])=([0-9]{5}|[0-9]{8})\r")
CR, LF, BLANK = 0x0D, 0x0A, " "


def framed(rows: list[str]) -> str:
    """Return rows of equal length as text, with a frame around them."""
    edge = "-" * len(rows[0])
    return "\n".join((f"+{edge}+", *(f"|{row}|" for row in rows), f"+{edge}+"))


class Shows:
    """Mixin for parts that show lines of text."""

    name: str

    @property
    def rows(self) -> list[str]:
        """Lines of the display."""
        raise NotImplementedError

    @property
    def picture(self) -> str:
        """The display with a frame, as text."""
        return framed(self.rows)

    def shows(self) -> dict[str, Any]:
        """Return the state of the part: the lines of the display, under the name "text"."""
        return {"text": self.rows}

    @property
    def waiting(self) -> str:
        """The name of the part and the text that it shows, in one line."""
        return f"{self.name}: {self.said}"

    @property
    def said(self) -> str:
        """The text that the display shows, in one line that begins with "shows"."""
        return "shows " + " | ".join(row.rstrip() for row in self.rows).rstrip(" |")


class HpDisplay(Shows, Part):
    """An eight-character LED display, HDSP-211x, with its address latch and the gates that enable it."""

    _for_users = ("text", "brightness", "flashing", "rows", "picture", "said", "on_change")
    wiring = MappingProxyType({**WRITE_WIRING, "select": "display_select"})
    rewired = start_bus

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.on_change: Hook[[]] = Hook()  # called when the display has changed
        selects = "low: the display is selected, and enabled while rd or wr is low"
        self._bus = BusInterface(self, selects, self._shown, self._take)
        self._cells = bytearray(LINES + 1)
        self._clear()

    def _clear(self) -> None:
        """Blank all characters, and stop all flashing."""
        self._cells[FIRST:] = BLANK.encode() * CHARACTERS
        self._cells[:CHARACTERS] = bytes(CHARACTERS)

    def _place(self) -> int:
        """Return the number of the memory cell at the address in the latch."""
        address = self._bus.low & LINES
        if address < 0x20:
            return address % CHARACTERS
        return address if address & 0x08 else address & ~0x07

    def _shown(self) -> int:
        """Return the byte in the cell at the latched address."""
        return self._cells[self._place()]

    def _take(self, byte: int) -> None:
        """Store a byte at the latched address, such as a character, a flash bit, or the control word."""
        before, place = self.text, self._place()
        self._cells[place] = byte
        if place == CONTROL and self._cells[CONTROL] & CLEAR:
            self._clear()
            self._cells[CONTROL] &= ~CLEAR
        if self.text != before:
            self.on_change()

    # -------------------------------------------------------------------------------------------------------- display
    @property
    def text(self) -> str:
        """The eight characters, all blank at brightness 0; a small box stands for a user-defined character."""
        if not self.brightness:
            return BLANK * CHARACTERS
        return "".join(_glyph(byte) for byte in self._cells[FIRST:])

    def shows(self) -> dict[str, Any]:
        """Return the line of text, the brightness in percent, and the positions of characters that flash or blink."""
        return {"text": self.rows, "brightness": self.brightness, "flashing": list(self.flashing)}

    @property
    def brightness(self) -> int:
        """Brightness, in percent."""
        return BRIGHTNESS[self._cells[CONTROL] & 0x07]

    @property
    def flashing(self) -> tuple[int, ...]:
        """Positions, 0 to 7, of the characters that flash or blink."""
        control = self._cells[CONTROL]
        return tuple(n for n in range(CHARACTERS) if control & BLINKS or (control & FLASHES and self._cells[n] & 1))

    @property
    def rows(self) -> list[str]:
        """The only line of the display, in a list."""
        return [self.text]


def _glyph(byte: int) -> str:
    if byte & 0x80:
        return OF_OWN
    return chr(byte) if 0x20 <= byte < 0x7F else BLANK


class Text:
    """Lines of continuous text: a CR or a full line moves on to the next line, from the last to the first."""

    def __init__(self, rows: int, width: int) -> None:
        self.lines, self.width, self.row = [""] * rows, width, 0

    def write(self, byte: int) -> None:
        """Append a character; CR begins the next line, and LF is ignored."""
        if byte == CR or len(self.lines[self.row]) == self.width:
            self.row = (self.row + 1) % len(self.lines)
            self.lines[self.row] = ""
        if byte not in (CR, LF):
            self.lines[self.row] += _glyph(byte)


class Lcd(Shows, Part):
    """A serial LCD of several lines: parameters on the left, text on the right.

    A text continues where the preceding text ended; CR begins the next line; after the last line comes
    the first.

    Args:
        baud: the rate of the serial line.
        rows: the number of lines.
        columns: the characters per line; the left part takes 11: a letter, "=", eight digits and a space.
    """

    _for_users = ("parameters", "left", "right", "rows", "picture", "said", "on_change")
    wiring = MappingProxyType({"rxd": "serial_out"})
    options = (
        BAUD,
        Option("rows", "int", 4, "number of lines", low=1, high=8),
        Option("columns", "int", 40, "characters per line, of which the left part takes 11", low=16, high=80),
    )
    _LEFT = 11

    def __init__(self, kernel: Kernel, name: str, *, baud: int | str = 9600, rows: int = 4, columns: int = 40) -> None:
        super().__init__(kernel, name)
        self.on_change: Hook[[]] = Hook()  # called when the display has changed
        self._clock = bit_clock(baud, name)
        self.add_pin("rxd", "in", "characters, TTL level", pull=1, active=0)
        self.parameters: dict[str, str] = {}  # by letter, in the order of their first arrival
        self.text = Text(rows, columns - self._LEFT)  # on the right
        self._pending = bytearray()  # text that may become a parameter

    def rewired(self) -> None:
        """Start to receive, now that the part is wired."""
        self.kernel.spawn(self._listen, name=self.name)

    async def _listen(self) -> None:
        receiver = Receiver(self.pin("rxd").net, self._clock, CharacterFormat(8, "none", 1), TTL)
        await receiver.receive(self._receive)

    def _receive(self, character: Character) -> None:
        if character.good:
            self._take(character.byte)
        else:
            self.finding("display-garbled", f"{character.byte:#04x} has no stop bit; check the baud rates")

    def _take(self, byte: int) -> None:
        """Process a character; characters that may begin a parameter are shown as text until it is complete."""
        self._pending.append(byte)
        if match := PARAMETER.fullmatch(self._pending):
            self.parameters[match[1].decode()] = match[2].decode()
            self._pending.clear()
        while self._pending and not _begins_parameter(bytes(self._pending)):
            self.text.write(self._pending.pop(0))
        self.on_change()

    # -------------------------------------------------------------------------------------------------------- display
    @property
    def left(self) -> list[str]:
        """Left parts of the lines, with the parameters; parameters beyond the last line replace earlier ones."""
        lines = [""] * len(self.text.lines)
        for n, (letter, digits) in enumerate(self.parameters.items()):
            lines[n % len(lines)] = f"{letter}={digits}"
        return lines

    @property
    def right(self) -> list[str]:
        """Right parts of the lines, with the text."""
        text = deepcopy(self.text)
        for byte in self._pending:
            text.write(byte)
        return text.lines

    @property
    def rows(self) -> list[str]:
        """The complete lines, each with its left and right parts."""
        halves = zip(self.left, self.right, strict=True)
        return [f"{left:<{self._LEFT}}{right:<{self.text.width}}" for left, right in halves]


def _begins_parameter(text: bytes) -> bool:
    """Return whether a text may be the beginning of a parameter."""
    return re.fullmatch(rb"[A-Z](=[0-9]{0,8})?", text) is not None and len(text) <= 10
