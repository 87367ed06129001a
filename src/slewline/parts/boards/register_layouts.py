"""Registers of interface boards: a row for each known card, and a text format for any other card.

pmd          the ISA board of the chipset's application note
pi-c842      a card of Physik Instrumente, as a host program uses it: the program polls base + 1, writes
             commands there, transfers data over base + 0, and once writes 0F to base + 2.  Bits 0 to 6
             of the card's status are unknown; they read 1 here.
data=0,command=1,status=1,reset=8,base=0x300
             a user-defined card; reset and base may be left out
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple

from ...core.messages.near import hint
from ...errors import UsageError

DATA, COMMAND, STATUS, RESET = "data", "command", "status", "reset"
OFFSETS = range(16)
BASES = range(0x100, 0x400, 0x10)
STEPS = f"{BASES[0]:#x} to {BASES[-1]:#x} in steps of 0x10"


class Layout(NamedTuple):
    """The registers of a board at the address `base`.

    `reads` (for IN) and `writes` (for OUT) map the offset of each register from `base` to its name.
    """

    base: int
    reads: Mapping[int, str]
    writes: Mapping[int, str]

    def offset(self, register: str) -> int | None:
        """Return the offset of a register; None if the board has no register with this name."""
        return next((at for each in (self.writes, self.reads) for at, name in each.items() if name == register), None)

    def listed(self, reading: bool) -> str:
        """Return a list, as text, of the registers for reading (if `reading`) or for writing: names and offsets."""
        found = self.reads if reading else self.writes
        return ", ".join(f"{name} at +{offset}" for offset, name in sorted(found.items()))


def placed(data: int, command: int, status: int, reset: int | None = None, base: int = 0x340, **more: int) -> Layout:
    """Return the layout of a board, given the offsets of its registers and its address `base`.

    `more` are the offsets of further registers, in which writes have no effect.
    """
    writes = {data: DATA, command: COMMAND} | ({} if reset is None else {reset: RESET})
    writes |= {offset: name for name, offset in more.items()}
    return Layout(base, MappingProxyType({data: DATA, status: STATUS}), MappingProxyType(writes))


PMD = placed(data=0, command=2, status=4, reset=8)
CARDS: Mapping[str, Layout] = MappingProxyType(
    {"pmd": PMD, "pi-c842": placed(data=0, command=1, status=1, base=0x210, function=2)}
)
EXAMPLE = "data=0,command=1,status=1,base=0x300"
ALLOWED = f"{', '.join(CARDS)}, or offsets such as {EXAMPLE}"


def layout_of(card: str) -> Layout:
    """Return a card's layout, given the card's name or text that lists the offsets of its registers.

    Raises:
        UsageError: no card has this name, or the text is not a layout.
    """
    if card in CARDS:
        return CARDS[card]
    if "=" not in card:
        raise UsageError(f"card {card!r}: not known; allowed {ALLOWED}{hint(card, CARDS)}")
    found: dict[str, int] = {}
    for word in card.split(","):
        key, _, value = (each.strip() for each in word.partition("="))
        try:
            number = int(value, 0)
        except ValueError:
            number = -1
        if key not in (DATA, COMMAND, STATUS, RESET, "base") or key in found:
            again = "given twice" if key in found else "not known"
            keys = (DATA, COMMAND, STATUS, RESET, "base")
            raise UsageError(f"card {card!r}: {key!r} is {again}; allowed {', '.join(keys)}, each once")
        if number not in (BASES if key == "base" else OFFSETS):
            allowed = STEPS if key == "base" else f"{OFFSETS[0]} to {OFFSETS[-1]}"
            raise UsageError(f"card {card!r}: {key}: found {value!r}; allowed {allowed}")
        found[key] = number
    if missing := [key for key in (DATA, COMMAND, STATUS) if key not in found]:
        raise UsageError(f"card {card!r}: {', '.join(missing)} missing; expected text such as {EXAMPLE}")
    written = [found[key] for key in (DATA, COMMAND, RESET) if key in found]
    if len({*written}) < len(written) or found[STATUS] == found[DATA]:
        raise UsageError(
            f"card {card!r}: two registers have the same address; only command and status may share an address, since "
            "one is written and the other is read"
        )
    return placed(**found)


def wrong(card: str) -> str:
    """Return the error in the value of the option `card`; "" if the value is valid."""
    try:
        layout_of(card)
    except UsageError as error:
        return str(error)
    return ""
