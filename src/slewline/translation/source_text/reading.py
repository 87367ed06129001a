"""Converts a text in the dialect of a part to its effect (meaning.py), by the roles of the part's commands.

Labels keep their source names; a branch target without a name is named after its line.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...chips import sheet_of
from ...language.assemble import RefusedProgram, link
from ...language.lint import branches, targets
from ...language.source import mended, read
from ...language.statements import Directive, Source
from ..host_directives import PROGRAM_OVER, waits_for_end
from ..meaning import OF_AN_AXIS, Action, Assumed, HostDirective, Label, Line, Program, Special
from ..profiles import profiles_of
from ..rows_of_roles import leads, rows_by_role
from ..special_commands import ADD_IT, ELSEWHERE, NO_AXIS, SELECT_IT, SWITCHED, WRITE_IT
from .bits import Numbers
from .role_reader import RoleReader
from .source_registers import UNKNOWN, KnownRegisterValues, from_switches

ASTRAY = ("branch-middle", "branch-outside")  # the part then runs a number as a command; other parts do not
ACTING = ("delay", "wait_high", "wait_low", "wait_bits", "output_high", "output_low", "bits", "home")  # besides motions
WIRES = (
    "step",
    "direction",
    *(f"output{n}" for n in (1, 2, 3)),
    *(f"input{n}" for n in (1, 2, 3)),
    "enable",
    "abort",
    "home",
    "end",
    "moving",
)


def read_program(
    text: str, part: str, where: str = "<text>", crystal_hz: int | None = None, interrupted: bool = False
) -> Program:
    """Return the effect of a program.

    Args:
        text: the commands that a host sends, one per line.
        part: the part that the program is for.
        where: the name of the text in messages.
        crystal_hz: the crystal of the part, Hz; None: its usual crystal.
        interrupted: whether the surroundings may end a motion early, as limit switches do.

    Raises:
        RefusedProgram: the part does not accept some lines; the errors in all of them are in `.problems`.
        UnknownName: the part does not exist.
    """
    sheet = sheet_of(part)
    source = read(text, sheet)
    link(source)
    targets(source)
    ends = {(goal.line, goal.column) for _, goal, block in branches(source) if block.address_of(goal) == block.end}
    errors = sorted(
        problem
        for problem in mended(source.problems, text)
        if problem.severity == "error" or (problem.code in ASTRAY and (problem.line, problem.column) not in ends)
    )
    if errors:
        raise RefusedProgram(errors, text, where)
    return ActionReader(text, source, part, where, crystal_hz, interrupted).program()


class ActionReader:
    """A converter of the statements of a text to actions."""

    def __init__(
        self, text: str, source: Source, part: str, where: str, crystal_hz: int | None, interrupted: bool
    ) -> None:
        self.text, self.source, self.sheet, self.where = text, source, source.sheet, where
        self.interrupted = interrupted
        self.hz = crystal_hz or self.sheet.crystal_hz
        self.stated = crystal_hz is not None
        profiles = profiles_of(part, self.hz)
        self.bits = Numbers(self.sheet, source)
        self.roles = RoleReader(
            source,
            self.hz,
            profiles,
            KnownRegisterValues(source, None if profiles is None else profiles.calculator, {}, interrupted),
            self.bits,
        )

    def program(self) -> Program:
        """Return the effect of the text: the actions of each line, the assumptions, and the wiring."""
        actions: dict[int, list[Action]] = {}
        entered = False  # a program
        for item in self.source.items:
            found = actions.setdefault(item.line, [])
            if isinstance(item, Directive):
                found.append(HostDirective(line=item.line, text=item.text))
                continue
            entered = entered or item.row.role in ("enter", "recall")
            if item.block < 0 and leads(item.row) and not entered:
                found.append(Special.of(Action(line=item.line, text=item.text), ELSEWHERE, ADD_IT))
                continue
            its = self.roles.statement(item)
            if from_switches(item):
                its = [each if isinstance(each, Label) else Special.of(each, SWITCHED, WRITE_IT) for each in its[:2]]
            found += [
                Special.of(each, NO_AXIS, SELECT_IT) if each.axis == UNKNOWN and isinstance(each, OF_AN_AXIS) else each
                for each in its
            ]
        for number, block in enumerate(self.source.blocks):  # a label at the end leads out of the program
            if (number, block.end) in self.roles.labels and block.statements:
                last = block.statements[-1].line
                actions[last].append(Label(name=self.roles.labels[number, block.end], line=last, block=number))
        lines = []
        for number, line in enumerate(self.text.splitlines(), 1):
            code, mark, comment = line.partition(";")
            lines.append(Line(number, code.strip(), comment.strip() if mark else "", tuple(actions.get(number, ()))))
        half = any(statement.row.role == "half_steps" for statement in self.source.statements)
        assumed, wiring = tuple(self.assumed()), self.wiring()
        return Program(self.sheet.part, self.where, tuple(lines), assumed, wiring, half, self.interrupted)

    # ----------------------------------------------------------------------------------------------------- assumptions
    def assumed(self) -> Iterable[Assumed]:
        """Yield the assumptions about facts missing from the text."""
        if self.sheet.crystal_high_hz and not self.stated:
            yield Assumed(
                "crystal", f"{self.hz / 1e6:g} MHz, as usual for the {self.sheet.part}", "set it with --crystal"
            )
        if self.sends_while_running():
            yield Assumed(
                "commands after the start of a program", "sent after its end, which the text does not wait for"
            )
        roles = {statement.row.role for statement in self.source.statements}
        if {"target", "plus"} <= {*rows_by_role(self.sheet)} and "target" in roles:
            yield Assumed("targets whose direction the text does not show", "in the set direction")
        wires = self.wiring()
        for name, wire in wires.items():
            pin = next(pin for pin in self.sheet.pins if pin.name == wire)
            if name.startswith("output") and pin.reset is not None:
                yield Assumed(f"output {name[-1]} ({wire})", f"{'high' if pin.reset else 'low'} after reset")

    def sends_while_running(self) -> bool:
        """Return whether the host sends a command with an effect while a program that it has started may still run.

        Such commands are motions, delays, waits, outputs and homing.
        """
        running = False
        for item in self.source.items:
            if isinstance(item, Directive):
                running = running and not waits_for_end(item.text, self.sheet, PROGRAM_OVER)
            elif item.block < 0 and (item.row.starts or item.row.role == "run"):
                running = True
            elif item.block < 0 and running and (item.row.motion or item.row.role in ACTING):
                return True
        return False

    def wiring(self) -> dict[str, str]:
        """Return the names of the part's pins by their purpose, such as "step" or "output1"."""
        found = {}
        for role in WIRES:
            pin = self.sheet.role(role)
            if pin is not None:
                found[role] = pin.name
        return found | self.bits.wiring()
