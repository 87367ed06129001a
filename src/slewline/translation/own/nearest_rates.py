"""The target's rates and ramps: consecutive settings form a group, which sets one profile.

A parameter of the source need not have a counterpart in the target: R and S of the CY512 also determine
a start rate, which the CY525 sets with F.  So a group is processed as a whole: the profile after its
last setting is fitted, each command becomes the target's command for the same quantity, and any further
values that change are set after the last command.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from ...core.datasheet.table import Row
from ...core.time.timebase import readable
from ..meaning import Motion, MoveBy, MoveTo, Profile, RunEndless, SetProfile
from ..profiles import Fitted, Profiles
from ..translation_report import LineKind, LineVerdict
from .limits import no_command, out_of
from .line_stream import SETTINGS, StreamStep

ROLES = {"start rate": "start_rate", "top rate": "top_rate", "ramp": "ramp"}
FAR_OFF = 0.1  # relative error of a rate or a ramp time that is not even nearly the same
EXACT = 1e-6
CLOSE = 1e-3  # relative error of the time of a move that counts as the same
FAR_MOVE = 1.0  # relative error of the time of a move: twice as long is not even nearly the same
JUST_LONGER = (0, 1, 64, 128, 192, 254, 255, 256)  # steps beyond both ramps
SHORTER = (0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875)  # fraction of both ramps: a motion that does not complete them
SAMPLES = tuple(dict.fromkeys(int(2 * 1.15**n) for n in range(57)))  # steps of moves of unknown length, to 5013


@dataclass(slots=True)
class Group:
    """Settings of a profile without a motion, label or host command between them."""

    actions: list[SetProfile] = field(default_factory=list)

    @property
    def profile(self) -> Profile | None:
        """The profile after the last setting, or None if it is not known."""
        return self.actions[-1].profile


class Rates:
    """The rates and ramps of a translated program."""

    def __init__(self, steps: Sequence[StreamStep], source: Profiles | None, target: Profiles | None) -> None:
        self.source, self.target = source, target
        self.groups: dict[int, Group] = {}
        for group in groups(steps):
            self.groups |= {id(action): group for action in group.actions}
        self.forms = {row.form: row for row in target.rows.values()} if target is not None else {}
        self.reset = self._defaults()
        self.known_values: dict[str, int] = dict(self.reset)
        self.constant = self._constants()
        self.emitted: dict[int, set[str]] = {}  # forms, by group

    def _defaults(self) -> dict[str, int]:
        """Return the target's parameter values after a reset, keyed by command form; zeros are omitted."""
        if self.target is None:
            return {}
        sheet = self.target.sheet
        letters = {register.letter: register.default for register in sheet.registers}
        return {form: letters[form] for form in self.forms if letters.get(form)}

    def _constants(self) -> dict[str, int]:
        """Return the target's parameters that have the same value in all groups, keyed by command form."""
        values: dict[str, set[int]] = {}
        for group in {id(each): each for each in self.groups.values()}.values():
            if group.profile is not None and self.target is not None:
                for form, value in self.target.fit(group.profile).values.items():
                    values.setdefault(form, set()).add(value)
        return {form: next(iter(found)) for form, found in values.items() if len(found) == 1}

    def joined(self) -> None:
        """Forget the parameter values that may differ between the paths that meet at this point of the program."""
        self.known_values = {
            form: value for form, value in self.known_values.items() if self.constant.get(form) == value
        }

    def restarted(self) -> None:
        """Set the known parameter values to those after a reset."""
        self.known_values = dict(self.reset)

    # ------------------------------------------------------------------------------------------------------- settings
    def setting(self, action: SetProfile) -> tuple[list[tuple[Row, int]], list[LineVerdict]]:
        """Return the target's commands for a setting, each with its value, and the verdicts on the setting."""
        group = self.groups[id(action)]
        if self.source is not None and self.target is not None and self.source.sheet is self.target.sheet:
            row = self.target.sheet.commands.by_form[action.command]
            self.known_values[row.form] = action.values[0]
            return [(row, action.values[0])], [LineVerdict(action.line, LineKind.SAME)]
        if self.target is None or group.profile is None:
            if (sister := self._sister(action)) is not None:
                self.known_values[sister.form] = action.values[0]
                return [(sister, action.values[0])], [LineVerdict(action.line, LineKind.SAME)]
            if self.target is not None and any(each.profile is not None for each in self._all()):
                return [], [LineVerdict(action.line, LineKind.SAME, "set together with the other values of the ramp")]
            return [], [
                LineVerdict(action.line, LineKind.IMPOSSIBLE, "the ramp depends on values that the text does not set")
            ]
        fitted = self.target.fit(group.profile)
        done = self.emitted.setdefault(id(group), set())
        forms = list(self._forms(action, fitted, done))
        if action is group.actions[-1]:
            forms += [
                form
                for form in self.forms
                if form in fitted.values
                and form not in (*forms, *done)
                and self.known_values.get(form) != fitted.values[form]
            ]
        done |= set(forms)
        self.known_values |= {form: fitted.values[form] for form in forms}
        commands = [(self.forms[form], fitted.values[form]) for form in forms]
        return commands, [self._verdict(action, group.profile, fitted)]

    def _all(self) -> Iterator[Group]:
        return iter(self.groups.values())

    def _forms(self, action: SetProfile, fitted: Fitted, done: set[str]) -> Iterator[str]:
        """Yield the forms of the target's commands for a setting, except those already written for its group."""
        assert self.target is not None  # noqa: S101
        role = ROLES[action.sets]
        same = next((row for name, row in self.target.rows.items() if row.form == action.command), None)
        if same is not None and same.role.removesuffix("_divisor") == role and same.form in fitted.values:
            if same.form not in done:
                yield same.form
            return
        row = self.target.rows.get(role)
        if row is not None and row.form in fitted.values and row.form not in done:
            yield row.form

    def _verdict(self, action: SetProfile, wanted: Profile, fitted: Fitted) -> LineVerdict:
        """Return the verdict on the setting of a rate or a ramp."""
        assert self.target is not None  # noqa: S101
        sheet, got = self.target.sheet, fitted.profile
        role = ROLES[action.sets]
        row = self.target.rows.get(role)
        if action.sets == "ramp":
            return self._ramp(action, wanted, got, row)
        rate, found = (wanted.start, got.start) if action.sets == "start rate" else (wanted.top, got.top)
        off = abs(found - rate) / rate if rate else 0.0
        description = f"{found:.6g} steps/s instead of {rate:.6g}, {percent(off)}"
        if off <= EXACT:
            return LineVerdict(action.line, LineKind.SAME)
        if off <= FAR_OFF:
            return LineVerdict(action.line, LineKind.NEARLY, description, off=off)
        limit = no_command(sheet, role) if row is None else f"{out_of(sheet, row, row.args[0])} is {self.span(role)}"
        remedy = (
            "check that the motor starts at this rate"
            if action.sets == "start rate"
            else "moves take longer; or choose a faster part"
        )
        if found > rate and action.sets == "top rate":
            remedy = "a slower crystal of the target lowers all of its rates"
        return LineVerdict(action.line, LineKind.IMPOSSIBLE, description, limit, remedy, off=off)

    def _ramp(self, action: SetProfile, wanted: Profile, got: Profile, row: Row | None) -> LineVerdict:
        assert self.target is not None  # noqa: S101
        if not wanted.ramped:
            if not got.ramped:
                return LineVerdict(action.line, LineKind.SAME)
            limit = "every motion of the target has a ramp"
            description = f"a ramp of {readable(got.time_ps)} instead of none"
            return LineVerdict(action.line, LineKind.IMPOSSIBLE, description, limit)
        difference = got.time_ps - wanted.time_ps
        off = abs(difference) / wanted.time_ps
        differ = round(got.steps) != round(wanted.steps)
        steps = f", {got.steps:.0f} steps instead of {wanted.steps:.0f}" if differ else ""
        times = f"{readable(round(got.time_ps, -6))} instead of {readable(round(wanted.time_ps, -6))}"
        description = f"ramp {times}, {percent(off)}{steps}"
        if off <= EXACT and not steps:
            return LineVerdict(action.line, LineKind.SAME)
        if off <= FAR_OFF:
            return LineVerdict(action.line, LineKind.NEARLY, description, off=off, off_ps=difference)
        sheet = self.target.sheet
        limit = no_command(sheet, "ramp") if row is None else out_of(sheet, row, row.args[0])
        remedy = (
            "a shorter ramp is steeper: lower the top rate"
            if difference < 0
            else "a longer ramp is gentler; moves take longer"
        )
        return LineVerdict(action.line, LineKind.IMPOSSIBLE, description, limit, remedy, off=off, off_ps=difference)

    def span(self, role: str) -> str:
        """Return a text that states the range of rates that the target's command with the given role can set."""
        assert self.target is not None  # noqa: S101
        low, high = self.target.ends(role)
        return f"{low:.0f} to {high:.0f} steps/s"

    # -------------------------------------------------------------------------------------------------------- motions
    def motion(self, action: Motion) -> LineVerdict:
        """Return the verdict on a motion, based on its time from the first step to the last.

        If the profile or the number of steps depends on the path, this is the worst verdict over all profiles that the
        program sets, or over moves of various lengths.
        """
        steps = action.steps if isinstance(action, MoveBy | MoveTo) else None
        if isinstance(action, MoveBy) and steps is None:
            steps = action.distance
        profiles = [action.profile] if action.profile is not None else self._profiles()
        if self.source is None or self.target is None or not profiles or steps == 0 or isinstance(action, RunEndless):
            return LineVerdict(action.line, LineKind.SAME)
        found = [self._off(profile, length) for profile in profiles for length in self._lengths(profile, steps)]
        off, before, after = max(found, key=lambda each: each[0])
        kind = LineKind.SAME if off <= CLOSE else LineKind.NEARLY if off <= FAR_MOVE else LineKind.IMPOSSIBLE
        upto = "" if len(found) == 1 else "up to "
        description = (
            f"{readable(round(after, -6))} instead of {readable(round(before, -6))}, {upto}{percent(off)}"
            if after != before
            else ""
        )
        if upto and description:
            description = f"time differs by up to {percent(off)}, depending on the number of steps"
        if kind is not LineKind.IMPOSSIBLE:
            return LineVerdict(action.line, kind, description, off=off, off_ps=after - before)
        top = self.target.rows["top_rate"]
        span = f"{out_of(self.target.sheet, top, top.args[0])} is {self.span('top_rate')}"
        limit = f"{span}; the target's ramps have a different shape"
        remedy = "the steps are correct: check any wait for the end of the move"
        return LineVerdict(action.line, kind, description, limit, remedy, off=off, off_ps=after - before)

    def _sister(self, action: SetProfile) -> Row | None:
        """Return the target's command for a setting if it is identical to the source's command, else None.

        The result is also None if the crystals or the ramp laws of the two parts differ.
        """
        if self.source is None or self.target is None or self.source.hz != self.target.hz:
            return None
        if type(self.source.calculator) is not type(self.target.calculator):
            return None
        theirs, mine = (each.sheet.commands.by_form.get(action.command) for each in (self.source, self.target))
        return mine if mine == theirs else None

    def _lengths(self, profile: Profile, steps: int | None) -> Sequence[int]:
        """Return the lengths to compare, in steps: that of the motion or, if it is unknown, a variety of lengths.

        The variety includes lengths just longer than both ramps, because a part that would slew for only a few
        steps may instead make them at its start rate.
        """
        if steps:
            return (steps,)
        assert self.target is not None  # noqa: S101
        ramps = [2 * int(each.steps) for each in (profile, self.target.fit(profile).profile)]
        longer = [length + more for length in ramps for more in JUST_LONGER]
        shorter = [int(length * part) for length in ramps for part in SHORTER]
        return [*SAMPLES, *(length for length in (*longer, *shorter) if length > 1)]

    def _profiles(self) -> list[Profile]:
        """Return the different profiles that the program sets."""
        found = {
            (each.start, each.top, each.time_ps): each for group in self._all() if (each := group.profile) is not None
        }
        return list(found.values())

    def _off(self, profile: Profile, steps: int) -> tuple[float, int, int]:
        """Return the relative error in a move's time, and the times in source and target, ps; zeros if unknown."""
        assert self.source is not None and self.target is not None  # noqa: S101
        before = self.source.move_ps(profile, steps)
        after = self.target.move_ps(self.target.fit(profile).profile, steps)
        if not before or after is None:
            return 0.0, 0, 0
        return abs(after - before) / before, before, after

    def first(self, profile: Profile) -> list[tuple[Row, int]]:
        """Return the commands that set `profile`, the source's reset profile, before a motion that relies on it."""
        if self.target is None:
            return []
        values = self.target.fit(profile).values
        forms = [form for form in self.forms if form in values and self.known_values.get(form) != values[form]]
        self.known_values |= {form: values[form] for form in forms}
        return [(self.forms[form], values[form]) for form in forms]


def groups(steps: Sequence[StreamStep]) -> Iterator[Group]:
    """Yield the groups of consecutive profile settings."""
    group = Group()
    for step in steps:
        action = step.action
        if action is None:
            continue
        if isinstance(action, SetProfile):
            if group.actions and group.actions[-1].block != action.block:
                yield group
                group = Group()
            group.actions.append(action)
        elif not isinstance(action, SETTINGS) and group.actions:
            yield group
            group = Group()
    if group.actions:
        yield group


def percent(off: float) -> str:
    """Return a fraction as a percentage, in text form."""
    return f"{100 * off:.2g} %" if off < 1 else f"{100 * off:.0f} %"
