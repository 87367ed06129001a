"""The passage of time on a bench: for a duration, or until a condition is met; in a call, or in an asyncio task."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sized
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, cast

from ..core.chip import step_nets
from ..core.messages.calls import answering, misfit
from ..core.time.timebase import Time, picoseconds, readable
from ..core.wires.net import Net
from ..core.wires.pin import Condition
from ..errors import Timeout, UsageError
from ..parts.base.part import Part

if TYPE_CHECKING:
    from ..core.chip import Chip
    from .circuit import Circuit

NEVER_PS = 1 << 80
SLICE_PS = 100_000_000_000  # while a VCD file is streamed, time passes in slices of 100 ms


class TimedStream(Protocol):
    """A file that is written as time passes."""

    def check_entered(self) -> None:
        """Check that time may pass: that the stream is used in a `with` statement.

        Raises:
            UsageError: the stream is not used in a `with` statement.
        """

    def feed(self, ps: int) -> None:
        """Write all changes up to an instant (ps)."""


def _seen(_net: Net) -> None:
    """Do nothing: watching a net with this function is enough to make the run stop at each edge of the net."""


@dataclass
class Wait:
    """A wait for a condition, with a time limit.

    `done` is called with True when the condition is met, or with False when the limit is reached first.
    """

    met: Callable[[], bool]
    limit_ps: int
    done: Callable[[bool], object] = bool
    when: Callable[[], int | None] | None = None  # the instant predicted by the present promises
    nets: Iterable[Net] = ()
    pushes: bool = False  # stopped time passes for it
    renew: Callable[[], object] | None = None  # repeats the wait on the bench that has replaced this one

    def begin(self) -> None:
        """Make the run stop at each edge of the nets, so that the condition is tested there."""
        for net in self.nets:
            net.watch(_seen)

    def end(self) -> None:
        """Let the run pass over the edges of the nets again."""
        for net in self.nets:
            net.unwatch(_seen)


class FunctionCondition(Condition):
    """A condition that is met when a function returns true."""

    def __init__(self, met: Callable[[], bool], text: str, nets: Iterable[Net] = ()) -> None:
        self.met, self.text, self.nets = met, text, tuple(nets)  # type: ignore[method-assign]


NEVER = FunctionCondition(lambda: False, "")  # only a timeout ends a wait for it


class HasVirtualLoop(Protocol):
    """An asyncio loop in which virtual time passes while all tasks wait (testing/aio.py provides such a loop)."""

    async def passed(self, bench: Runner, condition: Condition, ps: int) -> bool:
        """Wait until a condition is met, for at most `ps` picoseconds of bench time; return whether it was met."""


def virtual_loop(verb: str) -> HasVirtualLoop:
    """Return the running asyncio loop, which must have virtual time.

    Raises:
        UsageError: the loop follows the wall clock.
    """
    import asyncio

    loop = asyncio.get_running_loop()
    if not hasattr(loop, "passed"):
        raise UsageError(
            f"await bench.{verb}(): this asyncio loop follows the wall clock; start the program with "
            'slewline.testing.aio.run(main()), or anyio.run(main, backend_options={"loop_factory": HasVirtualLoop})'
        )
    return cast(HasVirtualLoop, loop)


def waiting_for(chips: Iterable[Chip], parts: Iterable[Part]) -> list[str]:
    """Return lines of text that state the awaited event of each chip and part that is not idle."""
    found = [chip.waiting for chip in chips if not chip.idle or chip.unfinished]
    return found + [part.waiting for part in parts if not part.idle]


class Runner:
    """The methods that let time pass on a circuit."""

    def __init__(self, circuit: Circuit) -> None:
        self.circuit, self.kernel, self.outside = circuit, circuit.kernel, circuit.outside
        self.chips, self.parts = circuit.chips, circuit.parts
        self.streams: list[TimedStream] = []  # written as time passes
        self._idle = FunctionCondition(self._all_idle, "all queues to be empty and all chips idle")
        self._busy: Chip | Part | None = None  # the first busy one at the last check
        self._queued: Sized = ()  # its requests
        self._forget_ps = NEVER_PS if circuit.keep_ps is None else circuit.keep_ps  # when the past is dropped next

    def at(self, time: Time, function: Callable[[], object]) -> None:
        """Call a function in the first round of an instant, when all levels still read as they did before it.

        Args:
            time: the instant, counted from time 0, not in the past: "12 ms", or picoseconds (0, or at least
                1000).
            function: a function without arguments, whose result is ignored; it must not let time pass.

        Raises:
            TimeError: `time` is not a time.
            UsageError: the instant is in the past, or `function` is not a function without arguments.
        """
        ps = picoseconds(time)
        if not callable(function):
            raise UsageError(f"at {readable(ps)}: {function!r}; expected a function")
        if wrong := misfit(function):
            raise UsageError(
                f"at {readable(ps)}: {wrong}; the function must take no arguments: lambda: x.pin('abort').drive(0)"
            )
        if ps < self.kernel.now:
            raise UsageError(f"at: {readable(ps)} is in the past; the time is {readable(self.kernel.now)}")
        self.kernel.call_at(ps, function)

    # ------------------------------------------------------------------------------------------------------- durations
    @answering("run()", "; run_to(time) goes to an instant, run_until(condition) waits for one")
    def run(self, duration: Time) -> None:
        """Let virtual time pass for a duration.

        Args:
            duration: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: `duration` is not a time.
            UsageError: the call is made from within a run.
        """
        self._run_to(self.kernel.now + picoseconds(duration))

    def run_to(self, time: Time) -> None:
        """Let virtual time pass up to an instant, that instant included.

        Args:
            time: the instant, counted from time 0: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: `time` is not a time.
            UsageError: the instant is in the past, or the call is made from within a run.
        """
        ps = picoseconds(time)
        if ps < self.kernel.now:
            raise UsageError(
                f"run_to: {readable(ps)} is in the past; the time is {readable(self.kernel.now)}; "
                "run() takes a duration"
            )
        self._run_to(ps)

    def _begin(self) -> None:
        for stream in [*self.streams]:
            stream.check_entered()
        self.circuit.finish_wiring()
        self._forget_if_due()

    def _run_to(self, ps: int) -> None:
        self._begin()
        self._advance(ps)
        self.outside.record("run", to=self.kernel.now)

    def _start(self) -> None:
        self._begin()
        self.kernel.settle()

    def _advance(self, ps: int) -> None:
        """Let time pass up to an instant (ps), and feed the streams meanwhile."""
        while self.streams and self.kernel.now < ps:
            self.kernel.run(min(ps, self.kernel.now + SLICE_PS))
            for stream in self.streams:
                stream.feed(self.kernel.now)
            self._forget_if_due()
        if self._forget_ps < ps:
            self._pass(None, ps)
        self.kernel.run(ps)

    def _pass(self, over: Callable[[], bool] | None, until: int) -> bool:
        """Run like `kernel.run_while`, but during a long run drop data that is too old to be kept."""
        kernel = self.kernel
        while self._forget_ps < until:
            if not kernel.run_while(over, self._forget_ps):
                return False
            self._forget(kernel.next_time() or until)
        return kernel.run_while(over, until)

    def _forget_if_due(self) -> None:
        if self.kernel.now >= self._forget_ps:
            self._forget(self.kernel.now)

    def _forget(self, now: int) -> None:
        """Drop data that is too old to keep; the next such clean-up is due `keep_ps` after `now` (ps)."""
        self.circuit.forget()
        self._forget_ps = now + (self.circuit.keep_ps or NEVER_PS)

    # ------------------------------------------------------------------------------------------------------ conditions
    def run_until_idle(self, timeout: Time = "60 s") -> None:
        """Run until every host queue is empty and every chip is idle.

        Args:
            timeout: the longest wait, in virtual time from now.

        Raises:
            Timeout: something is not idle in time; the message lists the events awaited by chips, parts and
                hosts.
            TimeError: `timeout` is not a time.
            UsageError: the call is made from within a run.
        """
        self._until(self._idle, timeout)
        self.conclude()

    def run_until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Run until a condition is met: x.reaches(40), pin.is_(0), pin.edges(3), host.got(b"Y"); a | b for either.

        Args:
            condition: a condition, or a function without arguments that returns true when the condition is met.
                A function is called after every instant, and every step of every motor counts as an instant:
                this is exact, but slow.
            timeout: the longest wait, in virtual time from now.

        Raises:
            Timeout: the condition is not met in time; the message lists the events awaited by chips, parts and
                hosts.
            TimeError: `timeout` is not a time.
            UsageError: `condition` is neither a condition nor a function, or belongs to another bench; or the
                call is made from within a run.
        """
        self._until(self._condition("run_until", condition), timeout)

    def let_pass(self, met: Callable[[], bool], what: str, timeout: Time) -> None:
        """Run until the condition that a host's method waits for is met; `what` names the condition in messages."""
        self._until(FunctionCondition(met, what), timeout)

    def conclude(self) -> None:
        """Let chips report, as findings, commands left incomplete by hosts, such as a setting without its update.

        This method is called by `run_until_idle`, by the test fixtures, by `slewline run`, and by a server when
        its host disconnects.  Nothing is reported while a host still has data to send.
        """
        if all(part.idle for part in self.parts.values() if part.queue is not None) and any(
            [chip.conclude() for chip in self.chips.values()]  # no short circuit
        ):
            self.outside.record("conclude")

    def _all_idle(self) -> bool:
        if self._queued or (self._busy is not None and not self._busy.idle):  # check it first, after every instant
            return False
        for owner in self.circuit.owners():
            if not owner.idle:
                self._busy, queue = owner, owner.queue if isinstance(owner, Part) else None
                self._queued = () if queue is None else queue.requests
                return False
        return True

    def _condition(self, verb: str, condition: Condition | Callable[[], bool]) -> Condition:
        """Return a condition ready to be awaited; a condition made from a function is tested at every motor step."""
        if isinstance(condition, Condition):
            if not condition.belongs(self.kernel):
                raise UsageError(
                    f"{verb}({condition}): the condition belongs to another bench, which this call does not run"
                )
            condition.begin()
            return condition
        if callable(condition):
            what = getattr(condition, "__name__", "the condition")
            if wrong := misfit(condition):
                raise UsageError(
                    f"{verb}({what}): {wrong}; the function must take no arguments: lambda: x.position > 40"
                )
            return FunctionCondition(condition, what, self._instants())
        raise UsageError(f"{verb}({condition!r}): expected a condition such as x.reaches(40), or a function")

    def _instants(self) -> list[Net]:
        """Return the nets at whose edges a condition function is called.

        These are the nets that carry steps, and the nets that carry bytes which may be transferred in one event.
        """
        steps = [net for chip in self.chips.values() for net in step_nets(chip)]
        pins = [each.pins for each in self.chips.values()] + [each.pins for each in self.parts.values()]
        return steps + [pin.net for each in pins for pin in each.values() if pin.net.ends or pin.net.readers]

    def _until(self, condition: Condition, timeout: Time) -> None:
        """Run instant by instant until a condition is met; raise Timeout if it is not met in time."""
        self._start()
        kernel = self.kernel
        wait = Wait(condition.met, kernel.now + picoseconds(timeout), when=condition.foreseen, nets=condition.nets)
        wait.begin()
        try:
            reached = self._foreseen(wait, wait.when) if wait.when else not self._pass(wait.met, wait.limit_ps)
        finally:
            wait.end()
        if not reached:
            dead = kernel.next_time() is None
            self._advance(wait.limit_ps)
            reached = wait.met()
        self.outside.record("run", to=kernel.now)
        if not reached:
            raise self._timeout(condition, timeout, dead)

    def _foreseen(self, wait: Wait, when: Callable[[], int | None]) -> bool:
        """Run until a condition is met; return whether it is met within the time limit.

        The condition is tested after each event, and at the instant that `when` predicts (ps; None: no prediction).
        """
        kernel = self.kernel
        while not wait.met():
            following, early = kernel.next_time(), when()
            if early is not None and early <= wait.limit_ps and (following is None or early <= following):
                kernel.run(early)
            elif following is None or following > wait.limit_ps:
                return False
            else:
                kernel.run(following)
            self._forget_if_due()
        return True

    def _timeout(self, condition: Condition, timeout: Time, dead: bool) -> Timeout:
        lines = [f"waited {readable(picoseconds(timeout))} for {condition}; the time is {readable(self.kernel.now)}"]
        if dead and not any(chip.moving for chip in self.chips.values()):
            lines.append("deadlock: no event is pending, so the condition cannot become true")
        lines += [f"  {each}" for each in waiting_for(self.chips.values(), self.parts.values())]
        return Timeout("\n".join(lines))

    # --------------------------------------------------------------------------------------------------------- asyncio
    async def until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Wait until a condition is met, in an asyncio task: `run_until` for programs with concurrent tasks.

        The event loop must run in virtual time, as in `slewline.testing.aio.run(main())`.

        Args:
            condition: as for `run_until`.
            timeout: the longest wait, in virtual time from now.

        Raises:
            Timeout: the condition is not met in time; the message lists the events awaited by chips, parts and
                hosts.
            TimeError: `timeout` is not a time.
            UsageError: `condition` is neither a condition nor a function, or belongs to another bench; or the
                event loop follows the wall clock.
        """
        loop = virtual_loop("until")
        await self._awaited(loop, self._condition("until", condition), timeout)

    async def until_idle(self, timeout: Time = "60 s") -> None:
        """Wait, in an asyncio task, until every host queue is empty and every chip is idle; raise as `until` does."""
        await self._awaited(virtual_loop("until_idle"), self._idle, timeout)
        self.conclude()

    async def wait(self, duration: Time) -> None:
        """Wait for a duration, in an asyncio task, while other tasks continue.

        Args:
            duration: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: `duration` is not a time.
            UsageError: the event loop follows the wall clock.
        """
        loop = virtual_loop("wait")
        self._start()
        await loop.passed(self, NEVER, picoseconds(duration))

    async def _awaited(self, loop: HasVirtualLoop, condition: Condition, timeout: Time) -> None:
        self._start()
        if not await loop.passed(self, condition, picoseconds(timeout)):
            raise self._timeout(condition, timeout, self.kernel.next_time() is None)
