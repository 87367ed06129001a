r"""The receiving half of a UART: it receives a line of characters as one value, or each character individually.

    wire      ‾‾\__V__/‾‾\__1__/‾‾\__CR_/‾‾‾‾     `Characters`: one promise
    receiver    |                     |           woken when the first begins, and when the last is complete
                 plan                  take

If a receiver finds on its wire a line of characters sent in its own format, the level in the middle of
each bit can be computed in advance; so the receiver is not woken for every character, but only for those
on which its owner acts, such as a carriage return.  The characters before such a
character are taken (passed to the owner) together with it, or earlier if a caller needs them (`catch_up`).

Anything else on the wire (a break, noise, another driver, another rate) withdraws the plan: the receiver
continues character by character; samples of the present character that are already due are taken from
the old promise.  Characters that are not part of such a line are received individually, too: the
receiver sleeps until the middle of the stop bit, and then looks up the level in the middle of each bit.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from heapq import heappush
from typing import ClassVar, NamedTuple

from ..time.hook import Hook
from ..time.kernel import Task
from ..time.timebase import Clock
from .characters import Characters, frames_of
from .net import Level, Net
from .serial import OVERSAMPLING, CharacterFormat
from .waits import edge_from_rest, level, until


class Character(NamedTuple):
    """A received character: its data bits, its faults, and the instants of its start and its end."""

    byte: int
    parity_wrong: bool
    framing_wrong: bool
    start_ps: int
    end_ps: int

    @property
    def good(self) -> bool:
        """True if the character has neither a parity nor a framing fault."""
        return not (self.parity_wrong or self.framing_wrong)


class CharacterHook(Hook[[Character]]):
    """The hook called with each received character; while it has listeners, characters are taken one by one."""

    __slots__ = ("receiver",)

    def __init__(self) -> None:
        super().__init__()
        self.receiver: Receiver | None = None

    def add(self, listener: Callable[[Character], object]) -> Callable[[Character], object]:
        """Register a function that is called with every character received from now on; return it, for `remove`."""
        if self.receiver is not None:
            self.receiver.one_by_one()  # this listener does not receive earlier characters
        return super().add(listener)


class Receiver:
    """The receiving half of a UART; `receiving` is true within a character.

    The rate and the format may change between two characters.  The net may be joined to another net.

    Args:
        net: the wire, whose level is `mark` at rest.
        clock: the clock, which runs at sixteen times the baud rate.
        word: the character format.
    """

    whole_lines: ClassVar[bool] = True  # False: the twin, which takes every character individually

    def __init__(self, net: Net, clock: Clock, word: CharacterFormat, mark: int) -> None:
        self.net, self.kernel, self.mark = net, net.kernel, mark
        self.clock, self.word, self.frames = clock, word, frames_of(clock.hz, word, mark)
        self.broken = False  # the last character had no stop bit: the wire must return to rest first
        self.start = 0  # of the character being received
        self.form = self.frames  # of this character: rate and format may change meanwhile
        self.looks: list[int] = []  # sampling instants of this character; empty while none is received
        self.seen: list[Level] = []  # the samples taken so far
        self.task: Task | None = None
        self.taken: Callable[[Character], object] = lambda _character: None
        self.passed: Callable[[bytes], object] = lambda _data: None
        self.acts: Callable[[bytes, int], int] | None = None
        self.line: Characters | None = None  # the line received as a value
        self.at = 0  # the number of its next character that has not been taken
        self.acts_at = 0  # the number of its next character on which the owner acts
        self.due = 0  # the instant at which that is complete, or the line
        self.latest: tuple[Characters, int] | None = None  # the line and number of the last character taken from one
        self.rests = False
        self.acting = False  # the owner acts, in the task
        net.sample(self.before_change)
        net.readers = (*net.readers, self)

    def close(self) -> None:
        """Stop receiving."""
        self.net.unwatch_before(self.before_change)
        self.net.readers = tuple(reader for reader in self.net.readers if reader is not self)
        self.line = None

    def set_line(self, clock: Clock, word: CharacterFormat) -> None:
        """Set the clock (sixteen times the baud rate) and the format, starting with the next character."""
        self.withdraw()
        self.clock, self.word, self.frames = clock, word, frames_of(clock.hz, word, self.mark)

    @property
    def receiving(self) -> bool:
        """True while a character is being received."""
        self.catch_up()
        if self.line is not None:
            return self.line.start + self.at * self.frames.length <= self.kernel.seen
        return bool(self.looks)

    async def receive(
        self,
        taken: Callable[[Character], object],
        passed: Callable[[bytes], object] | None = None,
        acts: Callable[[bytes, int], int] | None = None,
    ) -> None:
        """Receive characters, one after another, forever.

        Args:
            taken: called with each character on which the owner acts, or which was received individually; it is
                called in the middle of the first stop bit of that character.
            passed: called with good characters on which the owner does not act, some time after their end.
            acts: called with the bytes of a line and an index; returns the index of the first byte, at
                or after that index, on which the owner acts; -1 if it acts on none.  Without this function, the
                owner acts on every character.
        """
        self.taken, self.acts, self.task = taken, acts, self.kernel.current()
        if passed is not None:
            self.passed = passed
        kernel = self.kernel
        while True:
            planned = False  # True: a sender has handed over the line, and the owner acts now
            if self.line is None and not self.looks:
                if self.broken:
                    await self._mark()
                if self.whole_lines and self._at_rest():
                    self.rests = True
                    await edge_from_rest(self.net, self.mark)
                    planned = not self.rests
                    self.rests = False
                    if not planned:
                        self._start_found()
                else:
                    await level(self.net, 1 - self.mark)
                    self._start_found()
            if (line := self.line) is not None:
                if not planned:
                    await until(kernel, self._plan(line))
                if self.line is line:
                    self._take_planned(line)
            elif self.looks and (character := await self._character()) is not None:
                taken(character)

    async def character(self) -> Character:
        """Wait for the next character, and return it in the middle of its first stop bit."""
        self.task = self.kernel.current()
        while True:
            if self.broken:
                await self._mark()
            await level(self.net, 1 - self.mark)
            self._begin(self.kernel.now)
            if (character := await self._character()) is not None:
                return character

    # ------------------------------------------------------------------------------------------ character by character
    async def _mark(self) -> None:
        """Wait until the wire is at mark again, after a character without a stop bit."""
        await level(self.net, self.mark)
        self.broken = False

    def _start_found(self) -> None:
        """Start to receive the line in which a character begins now; if there is no line, a single character."""
        now = self.kernel.now
        if self.whole_lines and (line := self._line_on_wire(now)) is not None:
            self.line, self.at = line, (now - line.start) // self.frames.length
        else:
            self._begin(now)

    def _at_rest(self) -> bool:
        """Return whether the wire is at mark without a foreseen edge, so that a sender can hand over a line."""
        net = self.net
        promise = net.promise
        if promise is None:
            return bool(net.value == self.mark)
        if type(promise) is not Characters or len(net.active) > 1:
            return False
        return promise.last <= self.kernel.seen and promise.frames.mark == self.mark

    def _begin(self, start: int) -> None:
        """Compute the sampling points of a character that begins at an instant (ps)."""
        clock, bits = self.clock, len(self.frames.times)
        self.form = self.frames
        first = clock.ticks_until(start) + 1 + OVERSAMPLING // 2  # the edge is seen at the next clock
        self.start, self.seen = start, []
        ticks = range(first, first + OVERSAMPLING * bits, OVERSAMPLING)
        self.looks = [tick * clock.n // clock.d for tick in ticks]

    async def _character(self) -> Character | None:
        """Wait for the end of the character that has begun, and return it; None if its start bit was only a spike."""
        looks, kernel, mark = self.looks, self.kernel, self.mark
        frames = self.form
        if not self.seen:
            promised = self.net.resolve(looks[0] - 1) == 1 - mark
            await until(kernel, looks[-1 if promised else 0])
            self._look()
            if self.seen[0] != 1 - mark:
                self.looks = []
                return None
        if len(self.seen) < len(looks):
            await until(kernel, looks[-1])
            self._look()
        byte, wrong, self.broken = frames.read(tuple(self.seen))
        self.looks = []
        return Character(byte, wrong, self.broken, self.start, self.start + frames.length)

    def _look(self) -> None:
        """Take the samples due up to now; each is the level just before its sampling instant."""
        looks, done = self.looks, len(self.seen)
        over = bisect_right(looks, self.kernel.now, done)
        if over > done:
            self.seen += self.net.levels_before(looks[done:over])

    def before_change(self) -> None:
        """Withdraw the plan for a line before the wire changes; if there is no plan, take the samples now due."""
        if self.line is not None:
            self.withdraw()
        elif self.looks:
            self._look()
            if not self.seen and self.task is not None:
                self.kernel.wake_at(self.looks[0], self.task)  # the change may cut the start bit short

    # -------------------------------------------------------------------------------------------------- a whole line
    def _line_on_wire(self, now: int) -> Characters | None:
        """Return the line on the wire if it has this format and a character begins at `now` (ps); else None."""
        active = self.net.active
        promise = active[0].promise if len(active) == 1 else None
        if type(promise) is not Characters or promise.frames is not self.frames:
            return None
        return promise if now < promise.end and not (now - promise.start) % self.frames.length else None

    def _complete_at(self, line: Characters, number: int) -> int:
        """Return the instant (ps) of the last sample of a character in a line."""
        clock, frames = self.clock, self.frames
        return (clock.ticks_until(line.start + number * frames.length) + frames.last_sample) * clock.n // clock.d

    @property
    def latest_ps(self) -> int:
        """The instant (ps) at which the last character that was taken as part of a line was complete."""
        return 0 if self.latest is None else self._complete_at(*self.latest)

    def _complete_by(self, line: Characters, ps: int) -> int:
        """Return the number of a line's last character that is complete by an instant (ps); -1 if none is."""
        length = self.frames.length
        number = min((ps - line.start) // length, len(line.data) - 1)
        return number if self._complete_at(line, number) <= ps else number - 1

    def _acts_next(self, line: Characters) -> int:
        if self.acts is None or self.net.observers:
            return self.at
        number = self.acts(line.data, self.at)
        return len(line.data) if number < 0 else number

    def _plan(self, line: Characters) -> int:
        """Find the next character on which the owner acts; return the instant (ps) at which it is complete.

        If the owner acts on none, find the last character of the line.
        """
        self.acts_at = number = self._acts_next(line)
        self.due = due = self._complete_at(line, min(number, len(line.data) - 1))
        return due

    def take_over(self, line: Characters) -> None:
        """Receive a line that a sender hands over at its start; plan it as if its start bit had been detected."""
        task: Task = self.task  # type: ignore[assignment]  # a receiver at rest has one
        self.line, self.at, self.rests = line, 0, False
        task.token += 1
        kernel = self.kernel
        heappush(kernel.heap, (self._plan(line), next(kernel.order), task, task.token))

    def _take_planned(self, line: Characters) -> None:
        """When woken at the planned instant, or earlier, take the characters of a line that are complete now."""
        self.acting = True
        if self.kernel.now == self.due:
            self._take(line, min(self.acts_at, len(line.data) - 1), self.acts_at)
        else:
            self._take_until(line, self.kernel.now)
        self.acting = False

    def _take(self, line: Characters, number: int, acts: int) -> None:
        """Pass the characters of a line to the owner, from the next one up to and including character `number`.

        `acts` is the number of the next character on which the owner acts.  This character is passed to
        `taken`; those before it are passed to `passed`.
        """
        at, data = self.at, line.data
        self.at, self.latest = number + 1, (line, number)
        if self.at == len(data):
            self.line = None
        if (end := min(acts, number + 1)) > at:
            self.passed(data[at:end])
        if number == acts:
            start = line.start + number * self.frames.length
            self.taken(Character(data[number], False, False, start, start + self.frames.length))

    def _take_until(self, line: Characters, ps: int) -> None:
        """Take the characters of a line that are complete by an instant (ps)."""
        number = self._complete_by(line, ps)
        while self.line is line and self.at <= number:
            acts = self.acts_at if self.acts_at >= self.at else self._acts_next(line)  # as planned, or after that
            self._take(line, min(acts, number), acts)

    def catch_up(self) -> None:
        """Take all characters that are complete now, for a caller that needs them."""
        if self.line is not None:
            self._take_until(self.line, self.kernel.seen)

    def one_by_one(self) -> None:
        """Take the characters complete now, and plan to take the next one when it is complete."""
        line, task = self.line, self.task
        if line is not None and task is not None:
            self._take_until(line, self.kernel.now)
            self.acts_at = self.due = -1  # the plan is void
            if self.line is line:
                self.kernel.wake_at(self._complete_at(line, self.at), task)

    def withdraw(self) -> None:
        """Stop receiving a whole line, and continue character by character, starting at this instant."""
        line, task, kernel = self.line, self.task, self.kernel
        if line is None or task is None:
            return
        now = kernel.now
        self._take_until(line, now)
        if self.line is not line:
            return
        self.line = None
        start = line.start + self.at * self.frames.length
        if start <= kernel.seen:  # within a character
            self._begin(start)
            levels = self.frames.levels(line.data[self.at])
            self.seen = [*levels[: bisect_right(self.looks, now)]]
            if not self.acting:
                kernel.wake_at(self.looks[-1 if self.seen else 0], task)
        elif not self.acting:
            task.token += 1
            task.value = None
            kernel.woken.append(task)
