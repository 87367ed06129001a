"""Parts on the front of a machine: thumbwheel switches, and a switch for jogging.

Thumbwheels are read one digit at a time, at an 8-bit address that no legible page of the documentation
gives.  The model uses this address:

    bits 7 to 3     the low five bits of the command letter; the switches set the number of this command;
                    for R = 52H: 10010
    bits 2 to 0     the digit; 0 is the most significant digit
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Any

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...errors import UsageError
from ..base.part import Part
from ..memories.external import BUS_WIRING, BusInterface, start_bus

DIGITS = "0123456789ABCDEF"
MOST = 8  # maximum number of digits in a bank: three address bits
UPPER_NIBBLE = 0xF0  # of the undriven bus, which reads high


def switch_address(letter: str, digit: int) -> int:
    """Return the address at which a chip reads one digit of the switches for a command.

    Args:
        letter: the letter of the command, A to Z.
        digit: 0 to 7; 0 is the most significant digit.
    """
    return (ord(letter) & 0x1F) << 3 | digit


def _one_letter(letter: str) -> str:
    return "" if len(letter) == 1 and "A" <= letter <= "Z" else "expected one letter, A to Z"


def _digits(value: str) -> str:
    good = 1 <= len(value) <= MOST and all(digit in DIGITS for digit in value)
    return "" if good else f"allowed 1 to {MOST} digits, such as 100 or 00000200 (A to F on hexadecimal switches)"


class Thumbwheels(Part):
    """A bank of thumbwheel switches that sets the number of one command.

    Args:
        letter: the letter of the command, which the host sends with # in place of a number.
        value: the setting, with all digits of the bank: three for an 8-bit number, five for 16 bits, eight for 24 bits.
    """

    _for_users = ("turn", "letter", "value", "picture")
    wiring = MappingProxyType({**BUS_WIRING, "select": "switch_select"})
    verbs = ("turn",)
    options = (
        Option("letter", "text", "R", "letter of the command whose number the switches set", check=_one_letter),
        Option("value", "text", "000", "initial setting, one digit per switch", check=_digits, like="'100'"),
    )
    rewired = start_bus

    def __init__(self, kernel: Kernel, name: str, *, letter: str = "R", value: str = "000") -> None:
        super().__init__(kernel, name)
        self._bus = BusInterface(
            self, "low: the switches are selected", self._shown, on_latch=self._latched, on_select=self._selected
        )
        self.letter, self.value = letter, value
        self._read = 0  # digits that the chip has read since it selected the switches
        self._is_reported = False

    def _latched(self) -> None:
        digit = self._bus.low & MOST - 1
        if self._bus.selected and self._bus.low == switch_address(self.letter, digit):
            self._read = max(self._read, digit + 1)

    def _selected(self) -> None:
        read, there = self._read, len(self.value)
        self._read = 0
        if read and read != there and not self._is_reported:
            self._is_reported = True
            became = "each missing switch reads 15" if read > there else "the other switches have no effect"
            what = f"the chip reads {read} digits for {self.letter}, but the bank has {there}: {became}"
            self.finding("digit-count", f"{what}; set the bank to a value of {read} digits")

    @from_outside
    def turn(self, to: int) -> None:
        """Turn the switches to a number, 0 or more.

        Raises:
            UsageError: the number has more digits than there are switches.
        """
        if isinstance(to, bool) or not isinstance(to, int) or not 0 <= to < 10 ** len(self.value):
            raise UsageError(f"{self.name}: turn to {to!r}; allowed 0 to {'9' * len(self.value)}, one digit per switch")
        self.input("turn", to)
        self.value = f"{to:0{len(self.value)}}"
        self._bus.show()

    def _shown(self) -> int | None:
        """Return the byte at the latched address: a digit in its low four bits; None if no digit has this address."""
        digit = self._bus.low & MOST - 1
        if self._bus.low != switch_address(self.letter, digit) or digit >= len(self.value):
            return None
        return UPPER_NIBBLE | DIGITS.index(self.value[digit])

    def shows(self) -> dict[str, Any]:
        """Return the letter of the bank's command, and the setting of the bank."""
        return {"letter": self.letter, "value": self.value}

    @property
    def picture(self) -> str:
        """The bank as text: the letter of its command, and each digit in brackets."""
        return f"{self.letter} " + "".join(f"[{digit}]" for digit in self.value)


class JogSwitch(Part):
    """A three-position jog switch: open in the middle, low for clockwise, high (+5 V) for counterclockwise.

    Args:
        position: the position at the start: off, cw or ccw.
    """

    _for_users = ("cw", "ccw", "off", "position")
    wiring = MappingProxyType({"out": "jog"})
    verbs = ("cw", "ccw", "off")
    options = (Option("position", "choice", "off", "initial position", choices=("off", "cw", "ccw")),)
    _LEVELS = MappingProxyType({"off": None, "cw": 0, "ccw": 1})

    def __init__(self, kernel: Kernel, name: str, *, position: str = "off") -> None:
        super().__init__(kernel, name)
        self.position = position
        self.add_pin(
            "out", "out", "open, low for clockwise, or high for counterclockwise", initial=self._LEVELS[position]
        )

    @from_outside
    def cw(self) -> None:
        """Push the switch to the side that jogs clockwise."""
        self.input("cw")
        self._push("cw")

    @from_outside
    def ccw(self) -> None:
        """Push the switch to the side that jogs counterclockwise."""
        self.input("ccw")
        self._push("ccw")

    @from_outside
    def off(self) -> None:
        """Return the switch to the middle."""
        self.input("off")
        self._push("off")

    def shows(self) -> dict[str, Any]:
        """Return the position of the switch: off, cw or ccw."""
        return {"position": self.position}

    def _push(self, position: str) -> None:
        self.position = position
        self.drivers["out"].drive(self._LEVELS[position])
        self.kernel.settle()
