"""What every chip has: a sheet, nets on its pins, a crystal, registers, findings, and one firmware task.

Reset acts through a net: when RESET has been low for long enough an inner net falls, and its change kills the
firmware after all timed work of that instant.  When RESET rises, `run()` starts anew.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..errors import UnknownName, UsageError, WiringError
from .kernel import Kernel, Task
from .net import Bus, Driver, Net
from .table import Pin, Sheet
from .timebase import Clock, picoseconds, readable
from .train import Playing
from .waits import first_of, until

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class Finding:
    """Something a host did that the manual forbids or leaves open, and what the chip made of it."""

    time_ps: int
    source: str
    code: str
    text: str

    def __str__(self) -> str:
        return f"{readable(self.time_ps)}  {self.source}  {self.code}: {self.text}"


class Terminal:
    """A pin as the outside sees it: its net, and a driver of one's own on it."""

    def __init__(self, owner: str, row: Pin, net: Net) -> None:
        self.owner, self.row, self.net = owner, row, net
        self.name = f"{owner}.{row.name}"
        self.bit: int | None = None  # of a bus
        self._driver: Driver | None = None
        self.on_input: Callable[[Terminal, int | None], object] | None = None  # the journal

    @property
    def level(self) -> int | None:
        """0, 1, or None while the pin floats."""
        net = self.net
        if isinstance(net, Bus) and self.bit is not None:
            return net.bit(self.bit)
        return net.level  # type: ignore[no-any-return]

    def drive(self, level: int, at: str | int | None = None) -> None:
        """Drive the pin to 0 or 1 from outside, now or at an instant; overrides the standard wiring of a bare part."""
        if level not in (0, 1):
            raise UsageError(f"{self.name}: level {level!r}; allowed 0, 1 (release() lets go)")
        self._put(level, at)

    def release(self, at: str | int | None = None) -> None:
        """Let go of the pin."""
        self._put(None, at)

    def pulse(self, level: int, width: str | int, at: str | int | None = None) -> None:
        """Drive the pin for a time, then let go of it."""
        kernel = self.net.kernel
        start = kernel.now if at is None else picoseconds(at)
        self.drive(level, start)
        self.release(start + picoseconds(width))

    def _put(self, level: int | None, at: str | int | None) -> None:
        kernel = self.net.kernel
        if self.row.way in ("power", "none"):
            raise WiringError(f"{self.name} (pin {self.row.number}: {self.row.says}) carries no signal")
        if isinstance(self.net, Bus) and self.bit is None:
            raise WiringError(f"{self.name} is a bus of eight wires; drive db0 to db7 of a chip that is wired to it")
        if at is not None:
            ps = picoseconds(at)
            if ps < kernel.now:
                raise UsageError(f"{self.name}: {readable(ps)} is over; it is {readable(kernel.now)}")
            if ps > kernel.now:
                kernel.call_at(ps, lambda: self._put(level, None))
                return
        if self.on_input is not None:
            self.on_input(self, level)
        if self._driver is None:
            self._driver = Driver(self.net, "outside")
        if isinstance(self.net, Bus) and self.bit is not None:
            self._driver.drive(None if level is None else (1 << self.bit, level << self.bit))
        else:
            self._driver.drive(level)
        kernel.settle()

    # conditions, for Bench.run_until
    def is_(self, level: int) -> LevelCondition:
        """Condition: the pin has this level."""
        return LevelCondition(self, level)

    def edges(self, number: int) -> EdgeCondition:
        """Condition: the pin has changed this often from now on."""
        return EdgeCondition(self, number)

    def __repr__(self) -> str:
        return f"<pin {self.name}={self.level}>"


class Condition:
    """Something Bench.run_until can wait for."""

    text = ""

    def met(self) -> bool:
        """True when it has come about."""
        raise NotImplementedError

    def when(self) -> int | None:
        """The instant at which it will come about under the present promises; None: no promise says so."""
        return None


class LevelCondition(Condition):
    def __init__(self, pin: Terminal, level: int) -> None:
        self.pin, self.wanted, self.text = pin, level, f"{pin.name}={level}"
        pin.net.watch(lambda _: None)  # so that promised edges become instants

    def met(self) -> bool:
        return self.pin.level == self.wanted


class EdgeCondition(Condition):
    def __init__(self, pin: Terminal, number: int) -> None:
        self.text = f"{number} edges of {pin.name}"
        pin.net.watch(lambda _: None)
        self.net, self.last = pin.net, pin.net.changes + number

    def met(self) -> bool:
        return self.net.changes >= self.last


class ReachesCondition(Condition):
    def __init__(self, chip: Chip, position: int) -> None:
        self.chip, self.position, self.text = chip, position, f"{chip.name} at position {position}"

    def met(self) -> bool:
        return self.chip.position == self.position

    def when(self) -> int | None:
        return self.chip.axes[0].arrives(self.position)


@dataclass(frozen=True)
class Steps:
    """Steps of a chip: instants (n,) int64 ps, directions (n,) int8 +1/-1, positions after each step (n,) int64."""

    times_ps: NDArray[np.int64]
    directions: NDArray[np.int8]
    positions: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.times_ps)


@dataclass(slots=True)
class Stretch:
    """A stretch of travel: from an instant on, `playing` moves the axis by `sign` a step, starting from `travel`."""

    start: int
    travel: int
    sign: int
    playing: Playing | None


class Chip:
    """A part on a bench.  Subclasses bring a sheet and `run()`, the firmware."""

    sheet: Sheet
    axes: tuple[Axis, ...]

    def __init__(self, kernel: Kernel, name: str, crystal_hz: int | None = None, *, bare: bool = False, straps: Mapping[str, int] | None = None) -> None:
        self.kernel, self.name = kernel, name
        self.crystal_hz = crystal_hz or self.sheet.crystal_hz
        self.clock = Clock(self.crystal_hz)
        self.tick = 0  # the chip's own count; every sleep adds to it, so nothing drifts
        self.findings: list[Finding] = []
        self.on_finding: Callable[[Finding], object] | None = None
        self.on_power: Callable[[Chip, bool], object] | None = None  # the journal
        self.task: Task | None = None
        self.idle = False
        self._waiting: tuple[str, int] = ("nothing yet", 0)
        self._build_pins(bare, straps or {})

    def _build_pins(self, bare: bool, straps: Mapping[str, int]) -> None:
        self.pins: dict[str, Terminal] = {}
        self.drivers: dict[str, Driver] = {}
        self.bus = Bus(self.kernel, f"{self.name}.db")
        self.bus.on_conflict = self._conflict
        self.bus_driver = Driver(self.bus, self.name)
        for row in self.sheet.pins:
            if row.name.startswith("db") and row.name[2:].isdigit():
                terminal = Terminal(self.name, row, self.bus)
                terminal.bit = int(row.name[2:])
            else:
                open_input = row.way == "in" and row.pull is None  # an input without pull-up reads low when left open
                net = Net(self.kernel, f"{self.name}.{row.name}", 0 if open_input else row.pull, None if bare else row.tie)
                terminal = Terminal(self.name, row, net)
                net.on_conflict = self._conflict
                if row.way in ("out", "both"):
                    self.drivers[row.name] = Driver(net, self.name)
            self.pins[row.name] = terminal
        for strap, strap_level in straps.items():
            terminal = self.pin(strap)
            terminal.net.tie = strap_level
            terminal.net.rest()

    # ------------------------------------------------------------------------------------------------- public face
    def pin(self, name: str) -> Terminal:
        """A pin by the manual's name in lower case.

        Raises:
            UnknownName: with the names there are.
        """
        try:
            return self.pins[name]
        except KeyError:
            names = ", ".join(row.name for row in self.sheet.pins if row.way not in ("power", "none"))
            raise UnknownName(f"{self.name} ({self.sheet.part}) has no pin {name!r}; its pins: {names}") from None

    @property
    def position(self) -> int:
        """The position register, exact at this instant, also in mid-move."""
        return self.axes[0].position

    @property
    def travel(self) -> int:
        """Steps clockwise minus steps counter-clockwise since the beginning, without wrap-around."""
        return self.axes[0].travel

    def steps(self, start: str | int | None = None, stop: str | int | None = None) -> Steps:
        """Steps at start <= t <= stop; from the beginning, and up to now, by default."""
        now = self.kernel.now
        return self.axes[0].steps(0 if start is None else picoseconds(start), now if stop is None else min(picoseconds(stop), now))

    def position_at(self, times_ps: Sequence[int] | NDArray[np.int64] | int) -> NDArray[np.int64] | int:
        """The position register at instants of the past: an int for one, (n,) int64 for an array of picoseconds."""
        if isinstance(times_ps, int):
            return self.axes[0].position_at(times_ps)
        return self.axes[0].positions_at(times_ps)

    def reaches(self, position: int) -> Condition:
        """Condition: the position register has this value."""
        return ReachesCondition(self, position)

    def axis(self, number: int) -> Chip:
        """Axis 1 ... of the chip; a part with one motor is its own axis 1."""
        if number != 1:
            raise UnknownName(f"{self.name} ({self.sheet.part}) has one axis, number 1; not {number}")
        return self

    @property
    def registers(self) -> dict[str, int]:
        """The manual's registers, by name in lower case."""
        raise NotImplementedError

    def parameters(self) -> tuple[dict[str, float], dict[str, object]]:
        """What a plot names: rates in steps/s ("R = 80" -> 5978.0), and further parameters ("S" -> 200)."""
        return {}, {}

    @property
    def program(self) -> bytes:
        """The program memory in use."""
        raise NotImplementedError

    def listing(self) -> str:
        """The stored program as text, with addresses."""
        raise NotImplementedError

    def power(self, on: bool) -> None:
        """Switch the supply."""
        raise NotImplementedError

    def reset(self) -> None:
        """Pulse the RESET pin for as long as the part needs."""
        raise NotImplementedError

    def rewired(self) -> None:
        """Nets of pins have changed: look them up anew."""

    def check_wiring(self) -> None:
        """The first run begins: report inputs without pull-up that nobody drives (they read low)."""
        for row in self.sheet.pins:
            net = self.pins[row.name].net
            if row.way == "in" and row.pull is None and net.tie is None and not net.drivers:
                self.finding("open-pin", f"pin {row.number} ({row.name}) is open and has no pull-up: it reads low")

    @property
    def waiting(self) -> str:
        """What the chip waits for, and since when."""
        text, since = self._waiting
        return f"{self.name}: {text} since {readable(since)}"

    def finding(self, code: str, text: str) -> None:
        """Keep what a host did wrong, or where the manual is silent."""
        found = Finding(self.kernel.now, self.name, code, text)
        self.findings.append(found)
        if self.on_finding is not None:
            self.on_finding(found)

    def _conflict(self, net: Net) -> None:
        if not self.findings or self.findings[-1].code != "conflict" or self.findings[-1].time_ps != self.kernel.now:
            self.finding("conflict", f"two outputs disagree on {net.name}; the low one wins")

    # ------------------------------------------------------------------------------------------- waits of a firmware
    def sync(self) -> None:
        """Catch up with the kernel: the next clock tick at or after this instant."""
        self.tick = self.clock.ticks_from(self.kernel.now)

    async def ticks(self, number: int) -> None:
        """Let clocks pass."""
        self.tick += number
        await until(self.kernel, self.clock.ps(self.tick))

    async def at_tick(self, tick: int) -> None:
        """Wait for a tick of the crystal; one that is over costs nothing."""
        if tick > self.tick:
            self.tick = tick
            await until(self.kernel, self.clock.ps(tick))

    async def polled(self, net: Net, wanted: int, every: int, *others: tuple[Net, int]) -> Net:
        """Look at a net every so many clocks until it has a level; the first look is now.

        `others` are further (net, level) pairs that end the wait.  Returns the net that did.  The looks lie on a grid
        counted by arithmetic; a level that is gone again before a look is not seen.
        """
        pairs = ((net, wanted), *others)
        origin = self.tick
        while True:
            for candidate, value in pairs:
                if candidate.level == value:
                    return candidate
            await first_of(self.kernel, None, *pairs)
            passed = self.clock.ticks_until(self.kernel.now) - origin
            self.tick = origin + (passed // every + 1) * every
            await until(self.kernel, self.clock.ps(self.tick))

    def waits(self, text: str) -> None:
        """Say what the firmware waits for; `waiting` shows it."""
        self._waiting = (text, self.kernel.now)

    # -------------------------------------------------------------------------------------------------- firmware task
    async def run(self) -> None:
        """The firmware, from reset on."""
        raise NotImplementedError

    def start(self) -> None:
        """Start the firmware at this instant."""
        self.sync()
        self.task = self.kernel.spawn(self.run(), self.name)

    def stop(self) -> None:
        """Kill the firmware where it is."""
        if self.task is not None:
            self.task.kill()
            self.task = None
        self.idle = False


class Axis:
    """Position of one motor: exact at every instant, through the bounded promise, and its whole past.

    `travel` counts steps without wrap-around; `position` is the register.
    """

    def __init__(self, kernel: Kernel, bits: int, position: int) -> None:
        self.kernel, self.modulus = kernel, 1 << bits
        self.offset = position  # position = offset + travel, modulo
        self.past = [Stretch(0, 0, 1, None)]
        self.offsets = [(0, position)]
        self.watchers: list[Callable[[], object]] = []  # called when a plan or the register changes

    @property
    def travel(self) -> int:
        """Steps clockwise minus steps counter-clockwise, at the last committed instant."""
        now = self.past[-1]
        return now.travel + (now.sign * now.playing.begun(self.kernel.seen) if now.playing is not None else 0)

    @property
    def position(self) -> int:
        """The position register at the last committed instant."""
        return (self.offset + self.travel) % self.modulus

    def load(self, position: int) -> None:
        """Declare the present position."""
        self.offset = (position - self.travel) % self.modulus
        if self.offsets[-1][0] == self.kernel.now:
            self.offsets[-1] = (self.kernel.now, self.offset)
        else:
            self.offsets.append((self.kernel.now, self.offset))
        for watcher in self.watchers:
            watcher()

    def follow(self, playing: Playing | None, sign: int) -> None:
        """From this instant on, the axis follows a train; what was played before stays as it is."""
        self.past.append(Stretch(self.kernel.now, self.travel, sign, playing))
        for watcher in self.watchers:
            watcher()

    def arrives(self, position: int) -> int | None:
        """When the present promise reaches a position; None if it does not."""
        time, playing = self.would_arrive(position), self.past[-1].playing
        if time is None or playing is None or (playing.until is not None and time >= playing.until):
            return None
        return time

    def would_arrive(self, position: int) -> int | None:
        """When the present train reaches a position if nothing interferes; None if it does not."""
        now = self.past[-1]
        if now.playing is None:
            return None
        train = now.playing.train
        begun = now.playing.begun(self.kernel.seen)
        missing = (position - self.position) * now.sign % self.modulus or self.modulus
        step = begun + missing - 1
        return train.clock.ps(train.begin(step)) if step < train.steps else None

    def forget(self, before: int) -> None:
        """Drop the past before an instant."""
        keep = next((i for i in range(len(self.past) - 1, 0, -1) if self.past[i].start <= before), 0)
        del self.past[:keep]

    def _windows(self, start: int, stop: int) -> Iterator[tuple[Stretch, int, int]]:
        """Stretches that overlap start <= t <= stop, with the part of the window that each covers (inclusive)."""
        for i, stretch in enumerate(self.past):
            end = self.past[i + 1].start if i + 1 < len(self.past) else stop
            if stretch.playing is not None and stretch.start <= stop and end >= start:
                bound = stretch.playing.until
                last = min(stop, bound - 1 if bound is not None else stop)
                yield stretch, start, last

    def steps(self, start: int, stop: int) -> Steps:
        """Steps at start <= t <= stop."""
        import numpy as np

        times, signs, positions = [], [], []
        for stretch, first, last in self._windows(start, stop):
            playing = stretch.playing
            assert playing is not None
            a, b = playing.train.begun(first - 1), playing.train.begun(last)
            if b > a:
                begins = playing.train.begins(a, b)
                times.append(begins)
                signs.append(np.full(b - a, stretch.sign, np.int8))
                positions.append(stretch.travel + stretch.sign * np.arange(a + 1, b + 1) + self._offsets_at(begins))
        if not times:
            return Steps(np.empty(0, np.int64), np.empty(0, np.int8), np.empty(0, np.int64))
        return Steps(np.concatenate(times), np.concatenate(signs), np.concatenate(positions) % self.modulus)

    def _offsets_at(self, times: NDArray[np.int64]) -> NDArray[np.int64]:
        import numpy as np

        since = np.array([since for since, _ in self.offsets], np.int64)
        values = np.array([value for _, value in self.offsets], np.int64)
        return values[np.maximum(np.searchsorted(since, times, side="right") - 1, 0)]

    def position_at(self, ps: int) -> int:
        """The position register at one instant of the past."""
        stretch = self.past[max(bisect_right(self.past, ps, key=lambda stretch: stretch.start) - 1, 0)]
        travel = stretch.travel + (stretch.sign * stretch.playing.begun(ps) if stretch.playing is not None else 0)
        since = max(bisect_right(self.offsets, ps, key=lambda offset: offset[0]) - 1, 0)
        return (self.offsets[since][1] + travel) % self.modulus

    def positions_at(self, times: Sequence[int] | NDArray[np.int64]) -> NDArray[np.int64]:
        """The position register at many instants of the past: (n,) int64, shape as `times`."""
        import numpy as np

        at = np.asarray(times, np.int64)
        starts = np.array([stretch.start for stretch in self.past], np.int64)
        which = np.maximum(np.searchsorted(starts, at, side="right") - 1, 0)
        out = np.empty(at.shape, np.int64)
        for index in np.unique(which):
            stretch, chosen = self.past[index], which == index
            out[chosen] = stretch.travel
            if stretch.playing is not None:
                out[chosen] += stretch.sign * stretch.playing.begun_many(at[chosen])
        return (out + self._offsets_at(at)) % self.modulus


