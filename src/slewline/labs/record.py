"""A module's motor as an EPICS motor record, on Channel Access.

    field_table.py     the fields: types, access, meaning
    record_state.py    their values: positions, limits, rates, switches
    effects.py         the effects of puts
    record_motions.py  one motion after another, in the thread that communicates with the module
    fields.py          the caproto channels

A put into a field takes effect; then every field that has changed is posted, RBV before DMOV, and the put completes.
A position put completes when all motions are over.  If a client dies, the motion continues.

A module reports its position only at rest, so RBV is constant while the motor moves.
"""

from __future__ import annotations

import asyncio
import math
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from ..errors import SlewlineError, UsageError
from ..modules.failures import DamagedAnswer, EndlessInput, ModuleFailure, NoAnswer, PortLost, RefusedCommand
from .effects import LONGEST, Effects
from .field_table import FIELDS, LIMITED, ROWS, STATUS, FieldRow
from .fields import NUMBERS, TEXT_ENDS, AlarmSeverity, AlarmStatus, ChannelAlarm, bounds_of, field_of, unit_of
from .record_motions import RecordMotions
from .record_state import RecordState, digits

if TYPE_CHECKING:
    from .module_motor import ModuleMotor

LOST_BY = (PortLost, NoAnswer, EndlessInput, DamagedAnswer)
NEWS_S = 0.03  # time for caproto to send posted values to a client before its put completes
RETRY_S = 2.0  # between two attempts to find a lost module
SPEAKING = ("drive", "home", "jog", "update")  # puts that need the module
NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_:;<>\[\]{}+-]+")
LONGEST_NAME = 55  # characters: NAME_able is the name of a record as well, which has up to 60


def check_name(name: str) -> None:
    """Check that a name is allowed for a record.

    Raises:
        UsageError: the name is empty, too long, names a field, or contains a character not allowed in record names.
    """
    record, dot, field = name.partition(".")
    odd = NOT_IN_NAMES.search(name)
    if not name:
        found, remedy = "empty", "give one, such as lab:m1"
    elif odd and dot and odd.start() == len(record) > 0:
        found, remedy = f"names the field {field!r}" if field else "ends in a dot", f"write {record}"
    elif odd:
        found, remedy = f"{odd[0]!r} at character {odd.start() + 1}", f"write {NOT_IN_NAMES.sub('_', name)}"
    elif len(name) > LONGEST_NAME:
        found, remedy = f"{len(name)} characters", "shorten it"
    else:
        return
    raise UsageError(
        f"record name {name[:70]!r}: {found}; allowed 1 to {LONGEST_NAME} letters, digits and _ - + : ; < > [ ] {{ }}, "
        f"without a field name; {remedy}"
    )


class MotorRecord:
    """An EPICS motor record for the motor of a module.

    Args:
        name: the name of the record; fields are NAME.VAL and so on.
        find: finds the motor; called by the constructor, and in another thread after communication is lost.
        resolution: units per step.
        units: the name of the unit, such as "mm".
        say: is called with messages for the user.

    Raises:
        UsageError: a record cannot have this name, resolution or unit.
    """

    def __init__(
        self,
        name: str,
        find: Callable[[], ModuleMotor],
        resolution: float = 1.0,
        units: str = "steps",
        say: Callable[[str], object] = lambda _text: None,
    ) -> None:
        check_name(name)
        if not math.isfinite(resolution) or resolution == 0:
            raise UsageError(f"resolution {resolution!r}; expected units per step, such as 0.005 or -0.005, but not 0")
        if len(units) > LONGEST["EGU"] or max(map(ord, units), default=0) > 0xFF:
            raise UsageError(f"units {units!r}; allowed up to {LONGEST['EGU']} Latin-1 characters")
        self.name, self.find, self.say = name, find, say
        self.motor = motor = find()
        self.state = RecordState(resolution, motor.limits, motor.position, motor.ramp, motor.fastest)
        self.state.kept |= {"DESC": motor.module.name[:TEXT_ENDS], "EGU": units, "PREC": digits(resolution)}
        self.state.texts = {"NAME": name[:TEXT_ENDS], "OUT": f"@{motor.module.port.where}"[:TEXT_ENDS]}
        self.motions = RecordMotions(self, name)
        self.effects = Effects(self, self.motions)
        self.alarm = ChannelAlarm()
        self.search: asyncio.Task[None] | None = None  # search for a lost module
        self.posting = asyncio.Lock()
        self.posted: dict[str, Any] = {row.name: row.value for row in FIELDS} | dict(self.state.values())
        self.fields: dict[str, Any] = {}
        for row in FIELDS:
            field = field_of(row, self.posted, self.alarm)
            field.accept = partial(self._put, row) if row.put or row.fixed else None
            self.fields[row.name] = field
        self.bounds = {key: bounds_of(ROWS[key], self.posted) for key in LIMITED}

    @property
    def channels(self) -> Mapping[str, Any]:
        """The record's channels, keyed by name."""
        fields = {f"{self.name}.{key}": each for key, each in self.fields.items() if key != "_able"}
        able = dict.fromkeys((f"{self.name}_able", f"{self.name}_able.VAL"), self.fields["_able"])
        return {self.name: self.fields["VAL"]} | fields | able

    # ------------------------------------------------------------------------------------------------------------ puts
    async def _put(self, row: FieldRow, value: Any) -> None:
        """Handle a client's put into a field; report a refusal to the user as well as to the client."""
        try:
            value = self.fields[row.name].plain(value)
            if self.state.kept["DISP"] and row.name not in ("DISP", "_able"):
                raise UsageError("DISP is 1; set it to 0 first")
            if row.fixed:
                self._same(row, value)
            else:
                if row.put in SPEAKING and self.state.lost:
                    raise UsageError(
                        f"the module does not answer; wait: slewline looks for the module every {RETRY_S:.0f} s"
                    )
                await getattr(self.effects, row.put)(row.name, value)
        except UsageError as error:
            self.say(f"{self.name}.{row.name} {value}: refused: {error}")
            raise
        finally:
            await self.publish()
        await asyncio.sleep(NEWS_S)

    def _same(self, row: FieldRow, value: Any) -> None:
        """Accept a put of a field's present value, and refuse any other value."""
        has = self.posted[row.name]
        same = math.isclose(value, has, rel_tol=1e-6) if row.kind in NUMBERS else value == has
        if not same:
            allowed = row.words[has] if row.words else f"{has:g}" if row.kind in NUMBERS else repr(has)
            raise UsageError(f"allowed only {allowed} ({row.description})")

    async def publish(self) -> None:
        """Post the fields that have changed: limits first, then values in the order of `RecordState.values`."""
        async with self.posting:
            values = self.state.values()
            for key in LIMITED:
                bounds = bounds_of(ROWS[key], values)
                if bounds != self.bounds[key]:
                    self.bounds[key] = bounds
                    await self.fields[key].write_metadata(**bounds)
            for key, value in values.items():
                if value != self.posted[key]:
                    self.posted[key] = value
                    if key in ("EGU", "PREC"):
                        await self._describe()
                    await self.fields[key].post(value)

    async def _describe(self) -> None:
        """Set the unit and the number of decimals of all fields."""
        for field in self.fields.values():
            if field.row.kind in NUMBERS:
                unit = unit_of(field.row, self.posted["EGU"])
                await field.write_metadata(units=unit, precision=self.posted["PREC"])

    # ------------------------------------------------------------------------------------------------------- the module
    async def failed(self, error: Exception) -> None:
        """Report a failure; if the module does not answer, start searching for it."""
        self.say(f"{self.name}: {error}")
        if isinstance(error, LOST_BY):
            await self._alarm(AlarmStatus.COMM, AlarmSeverity.INVALID_ALARM)
            self.search = asyncio.create_task(self._look_for())

    async def _alarm(self, status: AlarmStatus, severity: AlarmSeverity) -> None:
        await self.alarm.write(status=status, severity=severity)
        self.state.alarm = STATUS.index(status.name), int(severity)
        self.state.lost = severity == AlarmSeverity.INVALID_ALARM
        self.state.homed = self.state.homed and not self.state.lost
        await self.publish()

    async def _look_for(self) -> None:
        """Search for a lost module until it answers again."""
        within = self.motions.within
        while True:
            await within(self.motor.module.port.close)
            await asyncio.sleep(RETRY_S)
            try:
                self.motor = await within(self.find)
            except (SlewlineError, OSError):
                continue
            self.say(f"{self.name}: the module answers again")
            self._here()
            await self._alarm(AlarmStatus.NO_ALARM, AlarmSeverity.NO_ALARM)
            return

    def _here(self) -> None:
        """Adopt the module's position if it has changed without a motion of this record."""
        if self.state.position != self.motor.position:
            self.state.position = self.motor.position
            self.state.settle()

    async def check(self, every_s: float) -> None:
        """Query the module's position periodically at rest, to detect a lost module or a motor moved by hand."""
        while True:
            await asyncio.sleep(every_s)
            if not self.motions.idle or self.state.lost:
                continue
            try:
                await self.motions.within(self.motor.look)
            except RefusedCommand:  # another program moves it
                continue
            except ModuleFailure as error:
                await self.failed(error)
                continue
            if self.motions.idle:
                self._here()
                await self.publish()

    def close(self) -> None:
        """Close the module's port."""
        self.motions.thread.submit(self.motor.module.port.close)
        self.motions.thread.shutdown()
