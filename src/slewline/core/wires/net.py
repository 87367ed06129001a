"""Nets: wires with drivers, pulls and promises.

A net is driven by levels (0, 1, or None for floating) or by promises: waveforms that a driver has planned in advance
and that hold until the driver's next decision.  A promise costs the kernel nothing while its net is not watched, and
one heap entry (the next edge) while its net is watched.

Strong drivers that disagree result in 0 (wired AND, as with open collectors) and one conflict report.  Without a strong
driver, the net takes the level of its tie (the standard wiring, which a bare part lacks); without a tie, that of its
pull; without a pull, it floats.

Nets that have been joined are one wire: they share drivers, tie and pull, while each keeps its own observers and its
own record, so that the owner of one net need not know the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from heapq import heappush
from typing import Any, Protocol

from ...errors import WiringError
from ..time.events import ask_at, earliest
from ..time.hook import Hook
from ..time.kernel import Kernel, Task
from .views import Rested, Wired
from .wave import Edges, Level, Promise, Wave, floats, promised

__all__ = ["Bus", "Driver", "Level", "Net", "Promise", "Wave"]

STALE = 64  # registrations that a net keeps without looking for ended ones
MAX_PINS = 500  # of one wire: the cost of a level grows with their number


class Driver:
    """An output on a net; a new level takes effect at the end of the round.

    Args:
        net: the net.
        name: the name of the chip or part, for messages.
    """

    __slots__ = (
        "active_level",
        "inactive_level",
        "kernel",
        "level",
        "name",
        "net",
        "next",
        "pending",
        "promise",
        "source",
    )

    def __init__(self, net: Net, name: str) -> None:
        self.net, self.kernel, self.name = net.root, net.kernel, name
        if (active := net.active_level) is not None:
            self.active_level, self.inactive_level = active, 1 - active
        self.level: Level = None
        self.promise: Promise | None = None
        self.next: Level | Promise = None
        self.pending = False
        self.source: object = None  # the part that runs ahead of time and controls this output, if any
        net.root.add_driver(self)

    def drive(self, level: Level) -> None:
        """Drive the net to 0 or 1 ((mask, value) for a bus), or to a promised waveform; None releases the net."""
        self.next = level
        if not self.pending:
            if self.promise is None and level == self.level:
                return  # nothing changes
            self.pending = True
            self.net.pending_drivers += 1
            self.kernel.pending.append(self)

    def activate(self, active: bool = True) -> None:
        """Drive the net to the active level of its pin or, with False, to the inactive level."""
        self.drive(self.active_level if active else self.inactive_level)

    def deactivate(self) -> None:
        """Drive the net to the inactive level of its pin."""
        self.drive(self.inactive_level)

    def level_when(self, active: bool) -> int:
        """Return the active level of the pin or, with False, the inactive level."""
        return self.active_level if active else self.inactive_level

    def pulses(self, *times: int) -> Edges:
        """Return the edges of pulses from the first instant (ps) to the second, from the third to the fourth ..."""
        return self.inactive_level, times, (self.active_level, self.inactive_level) * (len(times) // 2)

    def strobe(self, *times: int) -> None:
        """Promise the pulses that `pulses` returns for these instants (ps); the first pulse may begin now."""
        self.play(Wave(*self.pulses(*times)))

    def put(self, level: Level) -> None:
        """Put a level on the net immediately if no observer could see a difference; otherwise, act like `drive`.

        No difference is visible if the running task is alone in its round; the task must not read the net in
        that round.
        """
        net, kernel = self.net, self.kernel
        if not kernel.sole or net.plain is not self or self.pending or net.observers:
            self.drive(level)
            return
        if level is None and len(net.drivers) > 1:  # it no longer drives; another one may
            self.drive(level)
            return
        self.level = level
        shown = level
        if level is None:
            shown = net.tie if net.tie is not None else net.pull
        if shown != net.value:
            net.value = shown
            net.changes += 1
            net.changed_at = kernel.now
            if net.waiters:
                net.notify()

    def release(self) -> None:
        """Release the wire: immediately if its level does not change and no log is kept, else like `drive(None)`."""
        root, kernel = self.net, self.kernel
        nets = root.joined or (root,)
        rest = root.tie if root.tie is not None else root.pull
        quiet = kernel.sole and not kernel.pending and len(root.active) == 1 and root.exchange is None
        for net in nets:
            quiet = quiet and net._log is None
        if not quiet or self.at(kernel.now) != rest:
            self.drive(None)
            return
        for net in nets:
            for sampler in net.before_change:
                sampler()
            net.token += 1
            net.value = rest
            net.active, net.promise = (), None
        self.level = self.promise = None
        if not root.joined:
            root.sort_drivers()

    def play(self, promise: Promise) -> None:
        """Drive the net to a promised waveform, starting at this instant."""
        self.drive(promise)

    def wave(self, before: Level, times: tuple[int, ...], levels: tuple[Level, ...]) -> None:
        """Promise edges, all in the future, at `times` (ps) to `levels`; until then, the output is at `before`.

        The edges are not visible yet, so the promise can usually take effect immediately.
        """
        net = self.net
        promise = self.promise
        if self.pending or net._log is not None or net.before_change or net.joined or net.exchange is not None:
            self.drive(Wave(before, times, levels))
        elif type(promise) is Wave and not (net.waiters or net.observers or net.latched):
            promise.before, promise.times, promise.levels = before, times, levels  # no longer driven to the old level
        elif promise is not None and self.kernel.seen < self.kernel.now == ask_at(promise.after(self.kernel.seen)):
            self.drive(Wave(before, times, levels))  # an edge of the old one in this instant must still be reported
        else:
            self.promise = Wave(before, times, levels)
            net.sort_drivers()
            net.token += 1
            if net.waiters or net.observers or net.latched:
                net.follow()

    @property
    def watched(self) -> bool:
        """True if the net is watched or sampled, so that its watchers must be notified of a new promise."""
        net = self.net
        return bool(net.waiters or net.observers or net.latched or net.before_change or net.joined)

    def renew(self) -> None:
        """Report to all observers and samplers of the net that the end (`until`) of the present promise has moved."""
        if self.watched and not self.pending:
            self.drive(self.promise)

    def take(self) -> None:
        """Commit the pending level (called by the kernel)."""
        root, new = self.net, self.next
        nets = root.joined or (root,)
        if self.promise is None and new == self.level:
            return  # driven to another level and back
        if (exchange := root.exchange) is not None:
            self.kernel.late += exchange.changing
            exchange.withdraw()
        root.renewed = new is not None and new is self.promise
        for net in nets:
            for sampler in net.before_change:
                sampler()
        root.renewed = False
        if new is None or type(new) is int or type(new) is tuple:
            if self.promise is None and (self.level is None) is (new is None):
                self.level = new
                return
            self.level, self.promise = new, None
        else:
            self.promise = new
        self.net.sort_drivers()
        for net in nets:
            net.token += 1

    def at(self, ps: int) -> Level:
        """Return the level of this output at an instant (ps): 0, 1, or None while it floats."""
        return self.level if self.promise is None else self.promise.level(ps)


class TakesWhole(Protocol):
    """A receiver that accepts a line of characters as a whole (characters.py).

    Attributes:
        rests: True while the receiver waits for a line, with the wire at rest.
        frames: the format of the characters that it receives, a `characters.FrameTable`.
    """

    rests: bool
    frames: Any

    def take_over(self, line: Any) -> None:
        """Receive a line (`characters.Characters`) that begins now, from a sender that has promised it."""

    def one_by_one(self) -> None:
        """Take each character when it is complete, from now on for as long as the net has observers."""


class ByValue(Protocol):
    """A data transfer over wires that is made as one call, without events for its edges (exchange.py)."""

    @property
    def changing(self) -> list[Net]:
        """The nets that have an edge in the instant that is about to be committed."""

    def allows_wait(self, net: Net) -> bool:
        """Return True if a task may wait for an edge of a net, as the net has none before the next transfer."""

    def withdraw(self) -> None:
        """End the transfer as one call, and continue it edge by edge."""


def without(entries: tuple[Any, ...], entry: object) -> tuple[Any, ...]:
    """Return a tuple without the first element that is equal to `entry`.

    Raises:
        ValueError: there is none.
    """
    at = entries.index(entry)
    return entries[:at] + entries[at + 1 :]


class WiringChange:
    """An entry among the kernel's pending drivers, for a net whose wiring has changed (see `Net.join`)."""

    __slots__ = ("net", "next", "pending")

    def __init__(self, net: Net) -> None:
        self.net, self.next, self.pending = net, None, True

    def take(self) -> None:
        """Do nothing: after this call, the kernel updates the net, whose wiring has already changed."""


class Net:
    """A wire.

    Args:
        kernel: the kernel, which keeps the virtual time.
        name: the name, such as "x.slew".
        pull: the level to which a resistor pulls the net while it is not driven.
        tie: the level in the standard wiring while the net is not driven; the tie ends when the net is
            joined to another.
        active: the level at which the pin is active, from its row in the data sheet; None if the row has
            none: `is_active` and `is_inactive` then raise an AttributeError.

    Attributes:
        when_active, when_inactive: the pairs (net, active level) and (net, inactive level), for which a task
            can wait.
        changes: the number of its edges, counted while it is watched.
        changed_at: the instant of the last edge, ps.
    """

    __slots__ = (
        "_log",
        "_on_conflict",
        "active",
        "active_level",
        "before_change",
        "changed_at",
        "changes",
        "contention",
        "drivers",
        "ends",
        "exchange",
        "is_net",
        "joined",
        "kernel",
        "last_conflict_ps",
        "latched",
        "name",
        "observers",
        "pending_drivers",
        "plain",
        "promise",
        "pull",
        "readers",
        "renewed",
        "report_conflict",
        "root",
        "tie",
        "token",
        "value",
        "waiters",
        "when_active",
        "when_inactive",
    )  # fmt: skip
    width = 1

    def __init__(
        self, kernel: Kernel, name: str, pull: Level = None, tie: Level = None, active: int | None = None
    ) -> None:
        self.kernel, self.name, self.pull, self.tie, self.is_net = kernel, name, pull, tie, True
        self.active_level = active
        if active is not None:
            self.when_active, self.when_inactive = (self, active), (self, 1 - active)
        self.root: Net = self  # the net of a wire that its drivers notify
        self.joined: tuple[Net, ...] = ()  # all nets of a joined wire
        self.drivers: tuple[Driver, ...] = ()
        self.promise: Promise | None = None  # the promise of the first driver that has one
        self.value: Level = tie if tie is not None else pull
        self.waiters: list[tuple[Task, int, Level]] | None = None
        self.observers: tuple[Callable[[Net], object], ...] = ()
        self.before_change: tuple[Callable[[], object], ...] = ()  # called before a driver discards its waveform so far
        self._log: list[tuple[int, Any]] | None = None
        self._on_conflict: Hook[[Net]] | None = None
        self.report_conflict: Callable[[Net], object] | None = None  # of the first chip of a wire, in its root
        self.last_conflict_ps: int | None = None  # the last instant at which this was reported to a chip
        self.token = self.changes = self.changed_at = 0
        self.pending_drivers = 0  # the number of its drivers changed in this round
        self.contention = False  # two drivers disagree, which is reported once
        self.active: tuple[Driver, ...] = ()  # the drivers that drive; a sole driver always counts
        self.plain: Driver | None = None  # the sole driver, if a level can simply replace a level
        self.renewed = False  # samplers are called because a bound has moved: the waveform so far remains valid
        self.readers: tuple[TakesWhole, ...] = ()
        self.ends: tuple[Any, ...] = ()  # the observers that can be notified of exchanges as values
        self.exchange: ByValue | None = None  # the exchange currently made over the wire by value
        self.latched = False  # `changes` and `changed_at` count even while nothing waits for the net

    @property
    def on_conflict(self) -> Hook[[Net]]:
        """The event that two drivers begin to disagree; all nets of a wire share it."""
        root = self.root
        if root._on_conflict is None:
            root._on_conflict = Hook()
        return root._on_conflict

    @property
    def log(self) -> list[tuple[int, Any]] | None:
        """The data of a recorder: pairs (first instant in ps, level or promise); None if the net is not recorded."""
        return self._log

    @log.setter
    def log(self, log: list[tuple[int, Any]] | None) -> None:
        self._alone()
        self._log = log
        self.sort_drivers()

    def log_from(self, ps: int, what: Promise | Level) -> None:
        """Log the level or promise of the net from an instant (ps) on, replacing any that begins then or later."""
        log = self._log
        if log is None:
            return
        while log and log[-1][0] >= ps:  # an exchange that is withdrawn in the instant in which it begins
            log.pop()
        log.append((ps, what))

    def log_present(self, ps: int) -> None:
        """Log the present state of the net at `ps`: the promise if it alone determines the level, else the level."""
        alone = len(self.active) == 1 and self.promise is not None
        self.log_from(ps, self.promise if alone else self.resolve(ps))
        if self.promise is not None and not alone:
            self.schedule(ps)

    @property
    def looked_at(self) -> bool:
        """True if anything except observers and a recorder depends on the level of the net, or on when it changes."""
        if self.waiters:
            self.drop_ended()
        return bool(self.waiters or self.before_change or self.latched)

    def register(self, task: Task, wanted: Level) -> None:
        """Register a task that waits for any change (None), or for a level, 0 or 1, that the net does not have yet."""
        if not self.waiters:
            self.waiters = [(task, task.token, wanted)]
        else:
            if len(self.waiters) > STALE:
                self.drop_ended()
            self.waiters.append((task, task.token, wanted))
        if self.promise is not None and (self.exchange is None or not self.exchange.allows_wait(self)):
            self.follow()

    def drop_ended(self) -> None:
        """Drop the registrations of tasks that have since been woken by another net, an exchange or a time limit."""
        self.waiters = [entry for entry in self.waiters or () if entry[0].token == entry[1]]

    def _alone(self) -> None:
        """Make a transfer over this wire that runs without edges (`ByValue`) continue edge by edge."""
        if self.exchange is not None:
            self.exchange.withdraw()

    def sort_drivers(self) -> None:
        """Update the fields that depend on the drivers: `active`, `promise`, `contention` and `plain`.

        `plain` is the only driver of the net, if its levels can be committed by a shorter path; otherwise None.
        """
        if len(self.drivers) == 1 and not self.joined:  # most nets; every commit of a promise runs this line
            driver = self.drivers[0]
            self.active, self.promise, self.contention = (driver,), driver.promise, False
            plain = driver.promise is None and self._log is None and not self.before_change and self.exchange is None
            self.plain = driver if plain else None
            return
        active, promise = [], None
        for driver in self.drivers:
            if driver.promise is not None:
                active.append(driver)
                promise = promise or driver.promise
            elif driver.level is not None:
                active.append(driver)
        self.active, self.promise = tuple(active), promise
        self.contention &= len(active) > 1
        if self.joined:
            for net in self.joined:
                net.active, net.promise, net.plain, net.contention = self.active, self.promise, None, self.contention
            return
        single = len(self.active) == 1 and self.promise is None and self._log is None and not self.before_change
        self.plain = self.active[0] if single and self.exchange is None else None

    @property
    def level(self) -> Level:
        """The level of the net as read: 0, 1 or None; in round 1 of an instant, the level before that instant."""
        return self.value if self.promise is None else self.resolve(self.kernel.seen)

    @property
    def is_active(self) -> bool:
        """True if the pin is at its active level.  A floating pin is neither active nor inactive."""
        level = self.value if self.promise is None else self.resolve(self.kernel.seen)
        return level == self.when_active[1]  # type: ignore[no-any-return]

    @property
    def is_inactive(self) -> bool:
        """True if the pin is at its inactive level."""
        level = self.value if self.promise is None else self.resolve(self.kernel.seen)
        return level == self.when_inactive[1]  # type: ignore[no-any-return]

    @staticmethod
    def wired(levels: Iterable[Level]) -> tuple[Level, bool]:
        """Return the level that results from several outputs on one wire, and whether they disagree; a 0 wins."""
        level: Level = None
        contention = False
        for own in levels:
            if own is not None:
                if level is None:
                    level = own
                elif own != level:
                    level, contention = 0, True
        return level, contention

    def resolve(self, ps: int) -> Level:
        """Return the level at an instant (ps), from all drivers, the tie and the pull."""
        level: Level = None
        contention = False
        for driver in self.active:
            own = driver.level if driver.promise is None else driver.promise.level(ps)
            if level is None:
                level = own
            elif own is not None:
                level, differ = self.wired((level, own))
                contention |= differ
        if contention is not self.contention:
            self._report(contention)
        if level is None:
            level = self.tie if self.tie is not None else self.pull
        return level

    def shown(self) -> Promise | Level:
        """Return the waveform that the wire will have if no driver changes: a promise, or a constant level.

        The result never changes: after a driver has changed, the result remains valid for the past, and does not
        follow the driver.
        """
        rest = self.tie if self.tie is not None else self.pull
        outputs = [driver.level if driver.promise is None else driver.promise for driver in self.active]
        if not any(map(promised, outputs)):
            return rest if (level := self.wired(outputs)[0]) is None else level
        if len(outputs) > 1:
            return Wired(tuple(outputs), self.wired, rest)
        return Rested(outputs[0], rest) if rest is not None and floats(outputs[0]) else outputs[0]

    def edges_ahead(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the presently promised edges in start < t <= stop: lists, or arrays of int64 ps and int8 levels."""
        return shown.edges(start, stop) if promised(shown := self.shown()) else ([], [])

    def levels_before(self, instants: list[int]) -> list[Level]:
        """Return the levels just before each of several instants (ps), under the present promises."""
        if len(self.active) != 1 or (promise := self.active[0].promise) is None:
            return [self.resolve(ps - 1) for ps in instants]
        if type(promise) is Wave and promise.until is None:
            found = promise.levels_before(instants)
        else:
            found = [promise.level(ps - 1) for ps in instants]
        if None in found:
            rest = self.tie if self.tie is not None else self.pull
            return [rest if level is None else level for level in found]
        return found

    def _report(self, contention: bool) -> None:
        for net in self.joined or (self,):
            net.contention = contention
        if contention:
            root = self.root
            if root.report_conflict is not None:
                root.report_conflict(root)
            if root._on_conflict is not None:
                root._on_conflict(root)

    def rest(self) -> None:
        """Refresh the level of a wire without drivers after its tie or pull has changed."""
        if not self.drivers:
            self.value = self.tie if self.tie is not None else self.pull

    def update(self, ps: int) -> bool:
        """Commit the level at an instant (ps), and return whether it changed (called by the kernel)."""
        if self.exchange is not None:  # with unobserved lines; the driven level changes nothing
            return False
        active, promise = self.active, self.promise
        if len(active) == 1:
            new = active[0].level if promise is None else promise.level(ps)
            if new is None:
                new = self.tie if self.tie is not None else self.pull
        else:
            new = self.resolve(ps)
        if self._log is not None:
            self._keep(self._log, ps, new)
        alone = len(active) == 1 and self._log is None and not self.joined
        if alone and not self.before_change and type(promise) is Wave and ps >= promise.times[-1]:
            active[0].level, active[0].promise = promise.levels[-1], None  # the wave has ended
            self.promise, self.plain = None, active[0]
            if promise.levels[-1] is None:
                self.sort_drivers()
        if new == self.value:
            return False
        self.value = new
        self.changes += 1
        self.changed_at = ps
        return True

    def _keep(self, log: list[tuple[int, Any]], ps: int, level: Level) -> None:
        single = (
            self.promise is not None and sum(d.promise is not None or d.level is not None for d in self.drivers) == 1
        )
        entry = self.promise if single else level
        if log and log[-1][0] == ps and log[-1][1] is not entry:
            log[-1] = (ps, entry)
        elif not log or (log[-1][1] is not entry and log[-1][1] != entry):
            log.append((ps, entry))

    def follow(self) -> None:
        """Begin to watch a promised net: set its level to the current one, and schedule its next edge."""
        if self.exchange is not None:
            self.exchange.withdraw()
        self.value = self.resolve(self.kernel.seen)
        if self.promise is not None:
            self.schedule(self.kernel.seen)

    def schedule(self, ps: int) -> None:
        """Put the next promised edge into the heap if the net is watched."""
        if self.waiters or self.observers or self.latched or (self._log is not None and len(self.active) > 1):
            if len(self.active) == 1:
                time = ask_at(self.promise.after(ps))  # type: ignore[union-attr]
            else:
                time = earliest([driver.promise.after(ps) for driver in self.active if driver.promise is not None])
            if time is not None:
                self.token += 1
                heappush(self.kernel.heap, (time, next(self.kernel.order), self, self.token))

    def notify(self) -> None:
        """Wake the tasks that wait for the new level, and call the observers (called by the kernel)."""
        waiters = self.waiters
        if waiters:
            value = self.value
            keep = None
            for task, token, wanted in waiters:
                if task.token == token:
                    if wanted is None or wanted == value:
                        task.token = token + 1
                        task.value = self
                        self.kernel.woken.append(task)
                    elif keep is None:
                        keep = [(task, token, wanted)]
                    else:
                        keep.append((task, token, wanted))
            self.waiters = keep
        for observer in self.observers:
            observer(self)

    def watch(self, observer: Callable[[Net], object]) -> None:
        """Register a function to be called with the net after every change, before the tasks of the next round run."""
        self.observers = (*self.observers, observer)
        if self.promise is not None:
            self.follow()
        for reader in self.readers:
            reader.one_by_one()

    def unwatch(self, observer: Callable[[Net], object]) -> None:
        """Remove a function that was passed to `watch`."""
        self.observers = without(self.observers, observer)

    def sample(self, sampler: Callable[[], object]) -> None:
        """Register a function that is called just before any driver of this net changes its level or waveform."""
        self._alone()
        self.before_change = (*self.before_change, sampler)
        self.plain = None

    def unwatch_before(self, sampler: Callable[[], object]) -> None:
        """Remove a function that was passed to `sample`."""
        self.before_change = without(self.before_change, sampler)
        if not self.before_change:
            self.sort_drivers()

    def join(self, other: Net) -> None:
        """Connect two nets into one wire, at the end of this round; their ties end, since the pins are now wired.

        Raises:
            WiringError: the wire would have more than 500 pins.
        """
        one, two = self.root, other.root
        if one is two:
            return
        joined = (*(one.joined or (one,)), *(two.joined or (two,)))
        one.check_room(max(len(two.drivers), len(joined) - len(one.drivers)))
        one._alone()
        two._alone()
        for net in joined:
            for sampler in net.before_change:
                sampler()
        for driver in two.drivers:
            driver.net = one
        one.drivers += two.drivers
        one.pending_drivers += two.pending_drivers + 1  # the junction
        two.pending_drivers = 0
        one.report_conflict = one.report_conflict or two.report_conflict
        if two._on_conflict is not None:
            for listener in two._on_conflict.listeners:
                if listener not in one.on_conflict.listeners:
                    one.on_conflict.add(listener)
        pull = one.pull or (two.pull if two.pull is not None else one.pull)  # a pull-up wins over an open input
        for net in joined:
            net.root, net.joined, net.drivers, net.tie, net.pull = one, joined, one.drivers, None, pull
            net.token += 1
        one.sort_drivers()
        one.kernel.pending.append(WiringChange(one))

    def add_driver(self, driver: Driver) -> None:
        """Add a driver to the wire of which this net is the root.

        Raises:
            WiringError: the wire would have more than 500 pins.
        """
        self.check_room(1)
        drivers = (*self.drivers, driver)
        for net in self.joined or (self,):
            net.drivers = drivers
        self.sort_drivers()

    def check_room(self, more: int) -> None:
        """Check that a wire has room for `more` further pins, before the wiring is changed.

        Raises:
            WiringError: the wire would have more than 500 pins.
        """
        if len(self.drivers) + more > MAX_PINS:
            raise WiringError(f"{self.name}: {len(self.drivers) + more} pins on one wire; allowed up to {MAX_PINS}")

    def __repr__(self) -> str:
        return f"<Net {self.name}={self.level}>"


class Bus(Net):
    """A net of eight wires.  Its drivers drive (mask, value); an undriven wire reads 1, as with TTL."""

    __slots__ = ()
    width = 8

    @staticmethod
    def wired(levels: Iterable[Level]) -> tuple[Level, bool]:
        """Return the combined level of bus drivers, each driving (mask, value), and whether two of them disagree."""
        level: Level = None
        contention = False
        for own in levels:
            if own is not None:
                if level is None:
                    level = own
                else:
                    contention |= bool(level[0] & own[0] & (level[1] ^ own[1]))
                    mask = level[0] | own[0]
                    level = mask, (level[1] | ~level[0]) & (own[1] | ~own[0]) & mask
        return level, contention

    @property
    def byte(self) -> int:
        """The byte on the bus as read, 0 to 255."""
        level = self.level
        return 0xFF if level is None else int(level[1] | ~level[0] & 0xFF)

    def bit(self, number: int) -> int | None:
        """Return the level of wire `number` (0 to 7): 0, 1, or None while that wire is not driven."""
        level = self.level
        if level is None or not level[0] >> number & 1:
            return None
        return level[1] >> number & 1  # type: ignore[no-any-return]
