"""Effects of puts into the fields of a motor record: one method for each `put` in `field_table.py`.

Each method returns when the effect is complete.  A put that can have no effect here is an error, which
is reported to the client.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING

from ..errors import UsageError
from .field_table import PAUSE, STOP
from .record_motions import RecordMotion
from .record_state import STEPS_A_REVOLUTION

if TYPE_CHECKING:
    from ..language.ramp_answers import Ramp
    from .record_motions import Owner, RecordMotions

PRESET = {"FOF": ("FOFF", 1), "VOF": ("FOFF", 0), "SSET": ("SET", 1), "SUSE": ("SET", 0)}
REVOLUTIONS = {"S": "VELO", "SBAS": "VBAS", "SBAK": "BVEL"}
TOPS = ("VELO", "BVEL", "JVEL", "HVEL")
LONGEST = {"DESC": 39, "EGU": 15}  # characters
ALLOWED = {"IGSET": (0, 1), "DISP": (0, 1), "DLY": (0, 3600), "PREC": (0, 15)}


class Effects:
    """The effects of puts on a record and its motions."""

    def __init__(self, owner: Owner, motions: RecordMotions) -> None:
        self.owner, self.motions = owner, motions

    def at_rest(self, name: str) -> None:
        """Raise UsageError, with the field's name, while a motion is requested or in progress."""
        if not self.motions.idle:
            raise UsageError(
                f"{name}: a motion is in progress, or is waiting for SPMG; allowed only at rest; write 1 to STOP first"
            )

    # ---------------------------------------------------------------------------------------------------- positions
    async def drive(self, name: str, value: float) -> None:
        """Move to a position or, if the field SET is "Set", make it the present position; return at completion."""
        state = self.owner.state
        if name in ("TWF", "TWR") and not value:
            return
        dial = {"DVAL": value, "RVAL": value * state.resolution}.get(name)
        tweak = state.kept["TWV"]
        user = {"VAL": value, "RLV": state.val + value, "TWF": state.val + tweak, "TWR": state.val - tweak}.get(name)
        if dial is None and user is not None:
            dial = state.dial(user)
        assert dial is not None  # noqa: S101  # these are all the names that reach this method
        if state.setting:
            await self.redefine(name, state.user(dial) if user is None else user, dial)
            return
        state.violated = state.violates(dial)
        if state.violated:
            await self.pulse()
            return
        state.dval, state.val = dial, state.user(dial) if user is None else user
        state.last = state.val, state.dval
        await self.motions.begin(RecordMotion(dial))

    async def redefine(self, name: str, user: float, dial: float) -> None:
        """Give the present position a new value, by changing OFF or the module's position register."""
        state, motor = self.owner.state, self.owner.motor
        self.at_rest(name)
        frozen = bool(state.kept["FOFF"])
        if frozen or name in ("DVAL", "RVAL"):
            steps = state.raw(dial)
            await self.motions.within(lambda: motor.preset(steps))
            state.position = motor.position
            if not frozen:  # the user position is unchanged
                state.offset = state.val - dial * state.sign
            state.dval, state.val = dial, state.user(dial)
        else:
            state.offset = user - state.dval * state.sign
            state.val = user
        state.last, state.missed = (state.val, state.dval), False
        state.violated = state.beyond(state.dval)
        await self.pulse()

    async def pulse(self) -> None:
        """Post DMOV as 0 and then as 1, although nothing moves, because clients wait for this after a position put.

        If a motion is requested or in progress, post only the fields that have changed.
        """
        if self.motions.idle:
            for done in (False, True):
                self.owner.state.done = done
                await self.owner.publish()
        else:
            await self.owner.publish()

    async def sync(self, name: str, value: int) -> None:
        """Set the target position to the present position, unless `value` is 0."""
        if value:
            self.at_rest(name)
            self.owner.state.settle()

    # -------------------------------------------------------------------------------------------------- coordinates
    async def offset(self, _name: str, value: float) -> None:
        """Set OFF, which shifts the user coordinates."""
        state = self.owner.state
        state.offset = value
        state.val = state.user(state.dval)

    async def direction(self, _name: str, value: int) -> None:
        """Set DIR, the direction of the user coordinates; VAL is unchanged, unless OFF is frozen."""
        state = self.owner.state
        state.sign = -1 if value else 1
        if not state.kept["FOFF"]:
            state.offset = state.val - state.dval * state.sign
        state.val = state.user(state.dval)

    async def switch(self, name: str, value: int) -> None:
        """Store a switch that other puts and motions use."""
        self.owner.state.kept[name] = value

    async def preset_switch(self, name: str, _value: int) -> None:
        """Set a switch to the value that belongs to the field: for example, SSET sets SET to 1; SUSE sets it to 0."""
        switch, to = PRESET[name]
        self.owner.state.kept[switch] = to

    async def limit(self, name: str, value: float) -> None:
        """Set a limit; a motion to a position now beyond it is a violation, and is stopped if the part can stop."""
        state = self.owner.state
        dial = value if name.startswith("D") else state.dial(value)
        upper = name.endswith("HLM") == (name.startswith("D") or state.sign > 0)
        if upper:
            state.high = dial
        else:
            state.low = dial
        coming = [each.dial for each in (self.motions.current, self.motions.wanted) if each and not each.homing]
        state.violated = any(state.beyond(each) for each in (state.dval, state.dial_position, *coming))
        if state.violated and coming and not (state.moving and self.owner.motor.stopping is None):
            await self.motions.stop()

    # ---------------------------------------------------------------------------------------------------- rates
    async def rate(self, name: str, value: float) -> None:
        """Set a rate, or the time or acceleration of a ramp, to the nearest value that the part supports."""
        state, motor, law = self.owner.state, self.owner.motor, {**self.owner.state.law}
        if name == "HVEL" and motor.homing is None:
            motor.home(1)  # the message states why it cannot
        if name in ("JVEL", "JAR"):
            self._can_jog()
            if state.button in ("JOGF", "JOGR"):
                self.at_rest(name)
        if value < 0 or (value == 0 and name not in ("VBAS", "SBAS")):
            least = "0 or more" if name in ("VBAS", "SBAS") else "values above 0"
            raise UsageError(f"{name} {value:g}; allowed {least}")
        gain = law["VELO"] - law["VBAS"]
        accs = gain / law["ACCL"] if law["ACCL"] else 0.0
        if name in REVOLUTIONS:
            name, value = REVOLUTIONS[name], value * abs(state.resolution) * STEPS_A_REVOLUTION
        elif name == "ACCS":
            name, value = "ACCL", gain / value
        law[name] = value
        first = law["VBAS"]
        if name in TOPS and value < first:
            raise UsageError(f"{name} {value:g}; allowed VBAS ({first:g}) or more")
        law |= {top: max(law[top], first) for top in TOPS}  # a higher VBAS raises them, as in the motor record
        if name in ("VELO", "VBAS") and state.kept["ACCU"] and accs:
            law["ACCL"] = (law["VELO"] - first) / accs
        state.ramps = await self.motions.within(partial(self.fitted, law))
        state.law = law

    def fitted(self, law: Mapping[str, float]) -> dict[str, Ramp]:
        """Return the ramps nearest to the rates and times in `law`, keyed by "move", "backlash", "jog" and "home"."""
        motor, scale, first = self.owner.motor, abs(self.owner.state.resolution), law["VBAS"]
        jog_s = (law["JVEL"] - first) / law["JAR"] if law["JAR"] else law["ACCL"]
        wanted = {
            "move": (first, law["VELO"], law["ACCL"]),
            "backlash": (first, law["BVEL"], law["BACC"]),
            "jog": (first, law["JVEL"], jog_s),
            "home": (law["HVEL"], max(law["HVEL"], law["VELO"]), law["ACCL"]),
        }
        return {key: motor.fitted(start / scale, top / scale, time_s) for key, (start, top, time_s) in wanted.items()}

    # ---------------------------------------------------------------------------------------------------- numbers
    async def number(self, name: str, value: float) -> None:
        """Store a number that motions use."""
        state = self.owner.state
        if name == "RDBD":
            value = max(value, abs(state.resolution))
        low, high = ALLOWED.get(name, (value, value))
        if not low <= value <= high:
            raise UsageError(f"{name} {value:g}; allowed {low}..{high}")
        state.kept[name] = value

    async def disable(self, _name: str, value: int) -> None:
        """Set DISP: if it is 1, puts into other fields are refused; if it is 0, they are accepted again."""
        self.owner.state.kept["DISP"] = value

    async def text(self, name: str, value: str) -> None:
        """Store a text."""
        if len(value) > LONGEST[name]:
            raise UsageError(f"{name} of {len(value)} characters; allowed up to {LONGEST[name]}")
        self.owner.state.kept[name] = value

    # ---------------------------------------------------------------------------------------------------- buttons
    async def stop(self, _name: str, value: int) -> None:
        """Stop the motor, and discard requested motions, unless `value` is 0; return when the motor is at rest."""
        if value:
            await self.motions.stop()

    async def mode(self, _name: str, value: int) -> None:
        """Stop, pause, allow one motion, or continue, as SPMG says; return when all motions it allows are over."""
        state, before = self.owner.state, self.owner.state.kept["SPMG"]
        state.kept["SPMG"] = value
        try:
            if value in (STOP, PAUSE):
                await self.motions.stop(pause=value == PAUSE)
        except UsageError:
            state.kept["SPMG"] = before
            raise
        state.obeyed = value
        self.motions.changed.set()
        await self.owner.publish()
        if not state.paused:
            await self.motions.over()

    async def home(self, name: str, value: int) -> None:
        """Home the motor in the direction of the field, HOMF or HOMR; return at completion."""
        state, motor = self.owner.state, self.owner.motor
        if value != 1:
            raise UsageError(f"{name} {value}; allowed only 1; to stop a homing run, write 1 to STOP")
        self._no_setting(name)
        if motor.homing is None:
            motor.home(1)  # the message states why it cannot
        forward = (name == "HOMF") == (state.resolution > 0)
        await self.motions.begin(RecordMotion(homing=1 if forward else -1, button=name))

    async def jog(self, name: str, value: int) -> None:
        """Move towards a limit until 0 is put into the field; if `value` is 0, stop; return at completion."""
        state = self.owner.state
        if not value:
            if state.button == name or (self.motions.wanted is not None and self.motions.wanted.button == name):
                await self.motions.stop()
            return
        self._no_setting(name)
        self._can_jog()
        sign = 1 if name == "JOGF" else -1
        low, high = state.user_limits
        if state.unlimited:
            low, high = sorted(state.user(step * state.resolution) for step in state.steps)
            end = high if sign > 0 else low
        else:
            end = (high if sign > 0 else low) - sign * state.law["JVEL"]
        state.violated = (end - state.user(state.dial_position)) * sign <= 0 or state.low > state.high
        if not state.violated:
            await self.motions.begin(RecordMotion(state.dial(end), button=name))

    def _can_jog(self) -> None:
        motor = self.owner.motor
        if motor.stopping is None:
            motor.stop()  # the message states why it cannot: a jog would not end

    def _no_setting(self, name: str) -> None:
        if self.owner.state.setting:
            raise UsageError(f"{name}: the field SET is 'Set', so the motor may not move; change it to 'Use' first")

    async def update(self, name: str, value: int) -> None:
        """Query the module's position, while the motor is at rest."""
        state, motor = self.owner.state, self.owner.motor
        if value != 1:
            raise UsageError(f"STUP {value}; allowed ON")
        self.at_rest(name)
        state.updating = 2
        await self.owner.publish()
        try:
            await self.motions.within(motor.look)
        finally:
            state.updating = 0
        if state.position != motor.position:
            state.position = motor.position
            state.settle()
