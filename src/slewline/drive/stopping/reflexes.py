"""Board inputs that act as pins of a chip: the board reacts immediately, as the chip would.

    inputs = inputs_of(board, x, {"A0": "abort", "A1": "!home", "A5": "estop"})
    config = configured(config, inputs)

Inputs have the names printed next to the pins of the board, A0 to A5 on an Uno.  A pin of the chip has
the level of its input or, with "!" before the name of the pin, the opposite level.  An emergency stop
has a normally closed contact, so it is also active when its wire breaks.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple, Self

from ...core.messages.near import hint
from ...errors import UsageError
from ..board.wire import INPUTS, BoardConfig, Reflex
from ..terminals import exchanged

if TYPE_CHECKING:
    from ...core.chip import Chip
    from ...core.motion.axis import Axis
    from ..board.boards import BoardModel

ESTOP = "estop"
REFLEX: Mapping[str, int] = {  # reflex codes of a board, by the reflex of a pin
    "": Reflex.NONE,
    "stop": Reflex.STOP,
    "stop up": Reflex.STOP | Reflex.UPWARDS,
    "stop down": Reflex.STOP | Reflex.DOWNWARDS,
    "brake": Reflex.BRAKE,
    "brake back": Reflex.BRAKE,
    "hold": Reflex.STOP,  # the model then holds the motor by its own law
    "mark": Reflex.MARK,
}
HOMING = {"stop out": 1, "stop back": -1, "stop sought": 1}  # in a homing; direction relative to its outward motion
SOUGHT = "stop sought"


class Homing(NamedTuple):
    """The current homing run, if any: outward direction (1 or -1), and the pin and level sought, if any.

    The direction is 0 if no homing run is in progress.
    """

    direction: int = 0
    pin: str = ""
    level: int = 0

    @classmethod
    def of(cls, axis: Axis) -> Self:
        """Return the homing run of an axis, with direction 0 if none is in progress."""
        return cls(axis.homing, *axis.sought or ())


NO_HOMING = Homing()


class BoardInput(NamedTuple):
    """An input of a board.

    `pin`: the chip's pin, "" for an emergency stop; `reflex`: a word from the reflex column of the pin's row;
    `acts`: the level at which the pin acts; `inverted`: the pin has the opposite level of the input.
    """

    number: int
    pin: str
    reflex: str
    acts: int
    inverted: bool

    def level(self, inputs: int) -> int:
        """Return the level of the pin, given the levels of all inputs of the board: bit n is input n."""
        return (inputs >> self.number & 1) ^ self.inverted

    def code(self, homing: Homing) -> int:
        """Return the board's reflex code (`Reflex`) for the input; for some pins it depends on the homing run."""
        if not self.pin:
            return Reflex.ESTOP
        if self.reflex in HOMING:
            direction = (
                0 if self.reflex == SOUGHT and self.pin != homing.pin else homing.direction * HOMING[self.reflex]
            )
            return 0 if not direction else Reflex.STOP | (Reflex.UPWARDS if direction > 0 else Reflex.DOWNWARDS)
        return REFLEX[self.reflex]


def inputs_of(board: BoardModel, chip: Chip, wiring: Mapping[str, str]) -> tuple[BoardInput, ...]:
    """Return the wired inputs of a board: each acts as a pin of the chip, or as an emergency stop.

    Args:
        wiring: pins of the chip, or "estop", keyed by the printed names of the board's inputs, or by their
            numbers: {"A0": "abort"}.

    Raises:
        UsageError: there is no such input or pin, a pin is not an input of the chip, or an input or pin is
            wired twice.
    """
    found: dict[int, BoardInput] = {}
    printed = [pin.printed for pin in board.inputs]
    names = {name: number for number, pin in enumerate(printed) for name in (pin, str(number))}
    for name, wired in wiring.items():
        number = names.get(str(name).upper())
        if number is None:
            raise UsageError(
                f"input {name!r} of the board; allowed {', '.join(printed)}{exchanged(name, wired, names)}"
            )
        if number in found:
            raise UsageError(f"input {name}: {printed[number]} is given twice; leave one out")
        pin = wired.removeprefix("!")
        rows = {row.name: row for row in chip.sheet.pins if row.in_out in ("in", "both")}
        if wired == f"!{ESTOP}":
            raise UsageError(
                f"input {name}: an E-stop is active while its contact is open, so that a broken wire stops the motor; "
                f"wire a normally closed contact, and give {name}={ESTOP}"
            )
        if any(row.name == pin for row in chip.sheet.pins if row.in_out == "out"):
            raise UsageError(
                f"input {name}: {pin} is an output of {chip.name}; show it on an output of the board: "
                f"outputs={{'D2': '{pin}'}} (--output D2={pin})"
            )
        if pin != ESTOP and pin not in rows:
            raise UsageError(
                f"input {name}: {pin!r} is not an input of {chip.name}; allowed {ESTOP}, {', '.join(rows)}"
                f"{hint(pin, rows)}"
            )
        if any(other.pin == pin or (not other.pin and pin == ESTOP) for other in found.values()):
            raise UsageError(f"input {name}: {pin} has another input already; wire each pin to one input")
        row = rows.get(pin)
        acts = 1 if row is None or row.acts is None else row.acts
        reflex = "" if row is None or row.acts is None else row.reflex
        found[number] = BoardInput(number, pin * (pin != ESTOP), reflex, acts, wired.startswith("!"))
    return tuple(found[number] for number in sorted(found))


def configured(config: BoardConfig, inputs: Iterable[BoardInput], homing: Homing = NO_HOMING) -> BoardConfig:
    """Return `config`, changed so that the board acts on its inputs as the chip would, and reports their edges."""
    active, report, reflex = 0, 0, [0] * INPUTS
    for each in inputs:
        acts = homing.level if each.pin and each.pin == homing.pin else each.acts
        active |= (acts ^ each.inverted) << each.number
        report |= 1 << each.number
        reflex[each.number] = each.code(homing)
    return replace(config, active=active, report=report, reflex=tuple(map(int, reflex)))
