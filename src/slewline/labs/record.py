"""A motor behind a module as a motor record of EPICS, on Channel Access.

    VAL  TWF TWR TWV   HOMF HOMR   STOP        puts complete when the motion has
    RBV  RRBV  DMOV MOVN  MISS MSTA  TDIR      what it is: RBV before DMOV, whenever a motion is over
    VELO VBAS ACCL  HLM LLM LVIO  MRES EGU     rates, limits, units
    STAT SEVR                                  COMM and INVALID while the module does not answer

The module is spoken to in a thread of its own, one command after the other; clients are served meanwhile.  A position
that is put while the motor moves is the next one: the motion is stopped, where the part can, and all puts complete with
the last one.  A client that dies leaves the motion to go on.

A module tells its position at rest alone, so RBV stays as it is while the motor moves.  Fields that nothing would stand
behind, such as backlash or limit switches, do not exist.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from ..core.time.timebase import PS_PER_S
from ..errors import SlewlineError, UsageError
from ..modules.failures import DamagedAnswer, EndlessInput, ModuleFailure, NoAnswer, PortLost, RefusedCommand
from .fields import (
    SEVERITY,
    AlarmSeverity,
    AlarmStatus,
    ChannelAlarm,
    DoubleField,
    EnumField,
    FieldRow,
    IntegerField,
    Put,
    ShortField,
    TextField,
)

if TYPE_CHECKING:
    from .motor import ModuleMotor

Result = TypeVar("Result")
LOST_BY = (PortLost, NoAnswer, EndlessInput, DamagedAnswer)
NEWS_S = 0.03  # in which caproto sends what was posted, which a client is to have before its put completes
RETRY_S = 2.0  # between two attempts to find a module that is lost
DIRECTION, DONE, PROBLEM, MOVING, LOST = 1 << 0, 1 << 1, 1 << 9, 1 << 10, 1 << 12  # bits of MSTA


class MotorRecord:
    """The record.

    Args:
        name: of the record; fields are NAME.VAL and so on.
        find: finds the motor; called in another thread, again after it was lost.
        resolution: of a step, in units.
        units: such as "mm".
        say: tells the user what has happened.
    """

    def __init__(
        self,
        name: str,
        find: Callable[[], ModuleMotor],
        resolution: float = 1.0,
        units: str = "steps",
        say: Callable[[str], object] = lambda _text: None,
    ) -> None:
        if not math.isfinite(resolution) or resolution == 0:
            raise UsageError(f"resolution {resolution!r}; allowed units per step, such as 0.005, or below 0")
        self.name, self.find, self.resolution, self.say = name, find, resolution, say
        self.thread = ThreadPoolExecutor(1, thread_name_prefix=name)
        self.motor = find()
        self.alarm = ChannelAlarm()
        self.target: int | None = None  # the position that is wanted, when it is not the one that is moved to
        self.under_way: asyncio.Task[SlewlineError | None] | None = None  # done when all motions are
        self.search: asyncio.Task[None] | None = None  # of a module that is lost
        self.stopping = False
        self.direction = True
        self.homing = 0
        digits = max(0, -math.floor(math.log10(abs(resolution))))
        self.fields: dict[str, Any] = {}
        for key, row in self._rows(units, digits).items():
            more = {"units": units, "precision": digits} if row.kind is DoubleField else {}
            field = row.kind(value=row.value, alarm=self.alarm, reported_record_type="motor", **more)
            field.accept = None if row.accept is None else partial(self._put, key, row.accept)
            self.fields[key] = field

    def _rows(self, units: str, digits: int) -> dict[str, FieldRow]:
        """The fields of the record: kind, value at the start, and what a put to it does."""
        low, high = sorted(self.user(step) for step in self.motor.limits)
        return {
            "VAL": FieldRow(DoubleField, self.position, self.put_value),
            "RBV": FieldRow(DoubleField, self.position),
            "RRBV": FieldRow(IntegerField, self.motor.position),
            "DMOV": FieldRow(ShortField, 1),
            "MOVN": FieldRow(ShortField, 0),
            "MISS": FieldRow(ShortField, 0),
            "MSTA": FieldRow(IntegerField, DONE),
            "TDIR": FieldRow(ShortField, 1),
            "STOP": FieldRow(ShortField, 0, self.put_stop),
            "HOMF": FieldRow(ShortField, 0, partial(self.put_home, 1)),
            "HOMR": FieldRow(ShortField, 0, partial(self.put_home, -1)),
            "TWF": FieldRow(ShortField, 0, partial(self.put_tweak, 1)),
            "TWR": FieldRow(ShortField, 0, partial(self.put_tweak, -1)),
            "TWV": FieldRow(DoubleField, abs(self.resolution), partial(self.put_number, "TWV")),
            "VELO": FieldRow(DoubleField, self.rate(1), partial(self.put_rate, 1)),
            "VMAX": FieldRow(DoubleField, self.motor.fastest * abs(self.resolution)),
            "VBAS": FieldRow(DoubleField, self.rate(0), partial(self.put_rate, 0)),
            "ACCL": FieldRow(DoubleField, self.acceleration),
            "HLM": FieldRow(DoubleField, high, partial(self.put_number, "HLM")),
            "LLM": FieldRow(DoubleField, low, partial(self.put_number, "LLM")),
            "LVIO": FieldRow(ShortField, 0),
            "MRES": FieldRow(DoubleField, self.resolution),
            "OFF": FieldRow(DoubleField, 0.0),
            "DIR": FieldRow(partial(EnumField, enum_strings=["Pos", "Neg"]), "Pos"),
            "EGU": FieldRow(TextField, units),
            "PREC": FieldRow(ShortField, digits),
            "DESC": FieldRow(TextField, self.motor.module.name[:40]),
            "RTYP": FieldRow(TextField, "motor"),
            "STAT": FieldRow(TextField, AlarmStatus.NO_ALARM.name),
            "SEVR": FieldRow(partial(EnumField, enum_strings=SEVERITY), SEVERITY[0]),
        }

    @property
    def channels(self) -> Mapping[str, Any]:
        """The channels of the record, by their names."""
        return {self.name: self.fields["VAL"]} | {f"{self.name}.{key}": each for key, each in self.fields.items()}

    # ----------------------------------------------------------------------------------------------------------- units
    def user(self, steps: float) -> float:
        """Return steps in units."""
        return steps * self.resolution

    @property
    def position(self) -> float:
        """Where the motor was at rest last, in units."""
        return self.user(self.motor.position)

    def rate(self, which: int) -> float:
        """Return the first (0) or the highest (1) rate of moves, in units/s."""
        ramp = self.motor.ramp
        return (ramp.start, ramp.top)[which] * abs(self.resolution)

    @property
    def acceleration(self) -> float:
        """The time from the first to the highest rate, in s."""
        return self.motor.ramp.time_ps / PS_PER_S

    # ------------------------------------------------------------------------------------------------------------ puts
    async def _put(self, key: str, accept: Put, value: Any) -> None:
        """Take what a client puts into a field; say here, too, what is refused."""
        try:
            await accept(value)
        except UsageError as error:
            self.say(f"{self.name}.{key} {float(value):g}: refused: {error}")
            raise
        await asyncio.sleep(NEWS_S)

    async def put_value(self, value: float) -> None:
        """Move to a position; return when that is over."""
        low, high = self.fields["LLM"].value, self.fields["HLM"].value
        steps = round(value / self.resolution) if math.isfinite(value) else None
        least, most = self.motor.limits
        soft = low >= high or low <= value <= high  # equal ones switch the limits off, as in the record of EPICS
        within = steps is not None and soft and least <= steps <= most
        await self.fields["LVIO"].post(int(not within))
        if not within or steps is None:
            return
        self._check_found()
        await self.fields["VAL"].post(value)
        self.target = steps
        await self._all_done()

    async def put_tweak(self, sign: int, value: int) -> None:
        """Move by TWV."""
        if value:
            await self.put_value(self.fields["VAL"].value + sign * self.fields["TWV"].value)

    async def put_home(self, direction: int, value: int) -> None:
        """Home; return when that is over."""
        if not value:
            return
        self._check_found()
        if self.motor.homing is None:
            self.motor.home(direction)  # which says why it cannot
        if self.under_way is not None:
            raise UsageError(f"{self.name}: moves; allowed a homing at rest; stop it first")
        self.homing = direction if self.resolution > 0 else -direction
        await self._all_done()

    async def put_stop(self, value: int) -> None:
        """Stop, and forget what was to come; return when the motor is at rest."""
        if not value or self.under_way is None:
            return
        if self.motor.stopping is not None:
            self.target, self.stopping = None, True
        await self._within(self.motor.stop)  # which says why, where it cannot
        await self._all_done()

    async def put_rate(self, which: int, value: float) -> None:
        """Set the first or the highest rate of moves to come."""
        quantity = self.motor.rates[which]
        await self._within(partial(self.motor.set_rate, quantity, value / abs(self.resolution)))
        for key, found in (("VBAS", self.rate(0)), ("VELO", self.rate(1)), ("ACCL", self.acceleration)):
            await self.fields[key].post(found)

    async def put_number(self, key: str, value: float) -> None:
        """Keep a number: a limit, a tweak."""
        if not math.isfinite(value):
            raise UsageError(f"{self.name}.{key} {value}; allowed a number")
        await self.fields[key].post(value)

    def _check_found(self) -> None:
        if self.alarm.severity == AlarmSeverity.INVALID_ALARM:
            raise UsageError(f"{self.name}: the module does not answer; it is looked for every {RETRY_S:.0f} s")

    # --------------------------------------------------------------------------------------------------------- motions
    async def _within(self, call: Callable[[], Result]) -> Result:
        """Call a function of the module, in the thread that speaks to it."""
        return await asyncio.get_running_loop().run_in_executor(self.thread, call)

    async def _all_done(self) -> None:
        """Begin what is to be done, unless something is under way; wait until all of it is over.

        Raises:
            SlewlineError: it has failed.
        """
        if self.under_way is None:
            self.under_way = asyncio.create_task(self._work())
        if (failure := await asyncio.shield(self.under_way)) is not None:
            raise failure

    async def _work(self) -> SlewlineError | None:
        """Make the motions that are wanted, one after the other; return what went wrong."""
        failure = None
        while self.target is not None or self.homing:
            try:
                await self._motion()
            except SlewlineError as error:
                failure = error
                self.target, self.homing = None, 0
                await self._failed(error)
            if self.target is None:
                await self._rests()
        self.under_way = None
        return failure

    async def _motion(self) -> None:
        """Make a motion; one that is wanted meanwhile ends it, where the part can be stopped."""
        target, self.target, homing, self.homing = self.target, None, self.homing, 0
        self.stopping = False
        self.direction = homing > 0 if target is None else target >= self.motor.position
        await self._moves()
        if target is None:
            await self._within(partial(self.motor.home, homing))
        else:
            await self._within(partial(self.motor.move, target))
        stopped = self.stopping
        if stopped:  # it may have come before the move has begun
            await self._within(self.motor.stop)
        while not await self._within(self.motor.at_rest):
            if self.target is not None and not stopped and self.motor.stopping is not None:
                stopped = True
                await self._within(self.motor.stop)
        missed = target is not None and not stopped and not self.stopping and self.motor.position != target
        await self.fields["MISS"].post(int(missed))

    async def _moves(self) -> None:
        """Tell clients that the motor moves."""
        await self.fields["DMOV"].post(0)
        await self.fields["MOVN"].post(1)
        forward = self.direction == (self.resolution > 0)
        await self.fields["TDIR"].post(int(forward))
        await self.fields["MSTA"].post(MOVING | (DIRECTION if self.direction else 0))

    async def _rests(self) -> None:
        """Tell clients that it is at rest, and where: the place first."""
        lost = self.alarm.severity == AlarmSeverity.INVALID_ALARM
        status = LOST | PROBLEM if lost else 0
        await self.fields["RBV"].post(self.position)
        await self.fields["RRBV"].post(self.motor.position)
        if self.fields["VAL"].value != self.position and not self.fields["MISS"].value and self.target is None:
            await self.fields["VAL"].post(self.position)  # it was stopped, or is at home
        await self.fields["MSTA"].post(DONE | status | (DIRECTION if self.direction else 0))
        await self.fields["MOVN"].post(0)
        await self.fields["DMOV"].post(1)

    # ------------------------------------------------------------------------------------------------------- the module
    async def _failed(self, error: Exception) -> None:
        """Tell of a failure; a module that does not answer is looked for."""
        self.say(f"{self.name}: {error}")
        if isinstance(error, LOST_BY):
            await self._alarm(AlarmStatus.COMM, AlarmSeverity.INVALID_ALARM)
            self.search = asyncio.create_task(self._look_for())

    async def _alarm(self, status: AlarmStatus, severity: AlarmSeverity) -> None:
        await self.alarm.write(status=status, severity=severity)
        await self.fields["STAT"].post(status.name)
        await self.fields["SEVR"].post(SEVERITY[severity])

    async def _look_for(self) -> None:
        """Look for the module until it is there again."""
        values = self.motor.values
        while True:
            await self._within(self.motor.module.port.close)
            await asyncio.sleep(RETRY_S)
            try:
                self.motor = await self._within(self.find)
            except (SlewlineError, OSError):
                continue
            self.motor.values = values
            self.say(f"{self.name}: back")
            await self._alarm(AlarmStatus.NO_ALARM, AlarmSeverity.NO_ALARM)
            await self._rests()
            return

    async def check(self, every_s: float) -> None:
        """Ask the module at rest, over and over, where it is, so that it is known when it is gone or moved by hand."""
        while True:
            await asyncio.sleep(every_s)
            if self.under_way is not None or self.alarm.severity == AlarmSeverity.INVALID_ALARM:
                continue
            before = self.motor.position
            try:
                await self._within(self.motor.look)
            except RefusedCommand:  # somebody else lets it move
                continue
            except ModuleFailure as error:
                await self._failed(error)
                await self._rests()
                continue
            if self.motor.position != before and self.under_way is None:
                await self._rests()

    def close(self) -> None:
        """Let go of the module."""
        self.thread.submit(self.motor.module.port.close)
        self.thread.shutdown()
