"""The register values at every command of a program, as far as its text determines them.

All paths through the program are followed.  If a command is reached on two paths with different values
of a register, the value is not known there.  Likewise, a position set before a loop is not known in the
loop if the loop changes it.  The role of a command determines its effect.  A command that has the name
of a quantity in the part's ramp calculator sets a ramp parameter.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ...core.datasheet.table import Row
from ...language.lint import explored
from ...language.ramp_answers import Calculator
from ...language.statements import Block, Directive, Source, Statement
from ..host_directives import ends_motion
from ..rows_of_roles import after_reset, rows_by_role, takes_part, waits_for_update

Key = tuple[int, str]  # axis (0: the whole part), name
State = frozenset[tuple[Key, int]]

SWITCHES = "#"  # in place of a number
INTERRUPTING = "SET_I"  # selects an axis that the text does not show
UNKNOWN = 0  # axis
STOPS = ("stop", "brake")  # of a command that acts at the next update


class KnownRegisterValues:
    """The known register values of a program, before and after each of its statements."""

    def __init__(
        self, source: Source, calculator: Calculator | None, preset: Mapping[str, int | str], interrupted: bool = False
    ) -> None:
        self.source, self.sheet, self.interrupted = source, source.sheet, interrupted
        self.parameters = {each.name for each in calculator.quantities} if calculator is not None else set()
        self.preset = preset
        self._seen: dict[int, set[State]] = {}
        self._follow()

    def before(self, statement: Statement) -> dict[Key, int]:
        """Return the register values that are known before a statement."""
        return merged(self._seen.get(id(statement), ()))

    def after(self, statement: Statement) -> dict[Key, int]:
        """Return the register values that are known after a statement."""
        return merged(self._step(statement, state) for state in self._seen.get(id(statement), ()))

    # ----------------------------------------------------------------------------------------------------- following
    def initial(self) -> State:
        """Return the registers after a reset, from the data sheet; a rate of 0 counts as unset."""
        found: dict[Key, int] = {(0, "axis"): 1}
        for register in self.sheet.registers:
            row = self.sheet.commands.by_form.get(register.letter)
            if row is None or not takes_part(row, self.parameters) or not register.default:
                continue
            if row.args[0].allows(register.default):
                found |= {(axis, row.form): register.default for axis in range(1, self.sheet.axes + 1)}
        place = next((each for each in self.sheet.registers if each.name in ("position", "trgt_pos")), None)
        if place is not None and not place.default:  # otherwise it is undefined
            found |= {(axis, "position"): 0 for axis in range(1, self.sheet.axes + 1)}
        if "plus" in rows_by_role(self.sheet):
            found[1, "sign"] = after_reset(self.sheet)
        for name, value in self.preset.items():
            found[1, name] = int(value)
        return frozenset(found.items())

    def _follow(self) -> None:
        """Find the register values at each command: follow the commands in the order in which the host sends them.

        A stored program is followed at the host command that runs it.  A program that is never run is followed
        from its start, once its entry has ended.
        """
        states: list[State] = [self.initial()]
        blocks, block, ran = iter(self.source.blocks), None, True

        def step(statement: Statement, state: State) -> State:
            self._seen.setdefault(id(statement), set()).add(state)
            return self._step(statement, state)

        for statement in self.source.items:
            if isinstance(statement, Directive):
                if ends_motion(statement.text, self.sheet):
                    states = list(dict.fromkeys(map(nowhere, states)))
                continue
            if statement.block >= 0:
                continue
            row = statement.row
            states = list(dict.fromkeys(step(statement, state) for state in states))
            if row.role == "enter":
                if block is not None and not ran:
                    explored(block, block.base, states, step)
                block, ran = next(blocks, None), False
            elif block is not None and runs(row, statement, block):
                states, ran = explored(block, start_of(statement, block), states, step), True
        if block is not None and not ran:
            explored(block, block.base, states, step)

    def _step(self, statement: Statement, before: State) -> State:
        """Return the register values after a statement, given the values `before` it."""
        row, values, state = statement.row, statement.values, dict(before)
        axis = state.get((0, "axis"), UNKNOWN)
        if from_switches(statement):
            unknown = {row.form, row.role, "position", "sign" if row.motion else ""}
            return frozenset((key, number) for key, number in state.items() if key[1] not in unknown)
        value = values[0] if values else 0
        if takes_part(row, self.parameters):
            state[axis, row.form] = value
            if row.role == "ramp" and value:  # S above 0 makes the factor 1
                state |= {(axis, each.form): 1 for each in self.sheet.acting("rate_divisor")}
        elif row.role in ("distance", "target"):
            state[axis, row.role] = value
            state.pop((axis, "distance" if row.role == "target" else "target"), None)
        elif row.role in ("plus", "minus"):
            state[axis, "sign"] = 1 if row.role == "plus" else -1
        elif row.role in ("endless_next", "half_steps"):
            state[axis, row.role] = 1
        elif row.role == "axis":
            state[0, "axis"] = int(row.form[-1])
        elif row.form == INTERRUPTING:
            state = {}
        elif row.role == "erase":
            return self.initial()
        else:
            self._moved(row, value, axis, state)
        if row.stored and row.flow != "n" and statement.block >= 0:  # a repeated section moves again
            return nowhere(state.items())
        return nowhere(state.items()) if self.interrupted and row.motion else frozenset(state.items())

    def _moved(self, row: Row, value: int, axis: int, state: dict[Key, int]) -> None:
        """Apply a command to `state`: its effect on the position, and the expiry of single-motion settings."""
        here, place = state.get((axis, "position")), (axis, "position")
        if waits_for_update(row):
            state[axis, "stop"] = STOPS.index(row.at_once)
        elif row.at_once or (row.role == "update" and state.pop((axis, "stop"), None) is not None):
            state.pop(place, None)
        elif row.role == "preset":
            state[place] = value
        elif row.role == "home" or (row.role == "clear" and value & 1):
            state[place] = 0
        elif row.role in ("absolute", "goto"):
            self._reach(value, axis, state)
        elif row.role in ("move", "single", "update"):
            endless, target = state.pop((axis, "endless_next"), 0), state.get((axis, "target"))
            steps = value if row.args else 1 if row.role == "single" else state.get((axis, "distance"))
            sign = 1 if row.args else state.get((axis, "sign"))
            if endless:
                state.pop(place, None)
            elif target is not None and row.role != "single":
                if overflows(state, axis):
                    state.pop(place, None)
                else:
                    state[place] = target
            elif here is not None and steps is not None and sign is not None:
                state[place] = here + steps * sign
            else:
                state.pop(place, None)
        elif row.motion:
            state.pop(place, None)

    def _reach(self, position: int, axis: int, state: dict[Key, int]) -> None:
        """Update `state` for a motion that ends at `position`: set the position, and the direction of the motion.

        The direction stays in effect after the motion.  It becomes unknown if the position before the motion is
        not known.
        """
        here = state.get((axis, "position"))
        if here is None:
            state.pop((axis, "sign"), None)
        else:
            state[axis, "sign"] = 1 if position >= here else -1
        state[axis, "position"] = position


def nowhere(state: Iterable[tuple[Key, int]]) -> State:
    """Return the register values without the positions of the axes."""
    return frozenset((key, number) for key, number in state if key[1] != "position")


def overflows(state: Mapping[Key, int], axis: int) -> bool:
    """Return whether a motion to the target of an axis makes the position register overflow.

    It does if the target would be reached only by a motion opposite to the set direction.
    """
    here, sign = state.get((axis, "position")), state.get((axis, "sign"))
    return here is not None and sign is not None and (state[axis, "target"] - here) * sign < 0


def runs(row: Row, statement: Statement, block: Block) -> bool:
    """Return whether a host command runs the entered program, from its start or from another address."""
    return row.role == "run" or (row.role == "leave" and row.starts) or statement.target is not None


def from_switches(statement: Statement) -> bool:
    """Return whether the part reads the argument of a command from switches."""
    return bool(statement.row.args) and SWITCHES in statement.text


def start_of(statement: Statement, block: Block) -> int:
    """Return the address from which a host command runs the entered program."""
    target = statement.target
    address = None if target is None or statement.row.role == "run" else block.address_of(target)
    return block.base if address is None else address


def merged(states: Iterable[State]) -> dict[Key, int]:
    """Return the register values that all states have in common."""
    found = list(states)
    return dict(frozenset.intersection(*found)) if found else {}
