r"""A bench in virtual time: chips, hosts and parts on one kernel, wired by nets.

bench = slewline.Bench()
x = bench.add("cy525", name="x", crystal="11 MHz")
host = bench.host(x)
host.send("R 100\r")
bench.run_until_idle()
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from ..chips import CATALOGUE as CHIPS
from ..core.messages.calls import misfit
from ..core.messages.instead import face, missing
from ..core.messages.near import hint
from ..core.time.timebase import Seconds, Time, picoseconds, readable
from ..core.wires.net import Net
from ..core.wires.pin import Condition
from ..errors import NoSuchAttribute, Timeout, UsageError
from .hosting import Hosted
from .pictures.timing import TimingDiagrams

if TYPE_CHECKING:
    from ..core.chip import Chip
    from ..parts.base.part import Part
    from .awaiting import VirtualLoop


FIXED = {  # what a bench is made with, or has of itself, and what to do instead of setting it
    "seed": "it is given where the bench is made: slewline.Bench(seed=...)",
    "journal": "it is given where the bench is made: slewline.Bench(journal=...)",
    **dict.fromkeys(("on_finding", "on_input", "on_commit"), "add a listener: .add(function)"),
    "chips": 'bench.add("PART") puts a chip on it',
    "parts": "bench.part(KIND) puts a part on it",
}


def _seen(_net: Net) -> None:
    """An observer that only makes promised edges instants."""


@face
class Bench(Hosted, TimingDiagrams):
    """Chips and the parts around them, in virtual time from 0 on.

    Args:
        seed: of every random element that is given a source of chance; a whole number.
        journal: a file that takes every input from outside, to be replayed with `slewline.replay`.
        shuffle: run the tasks of a round in random order (from this seed): results must not change.
        stores: called with the name of a chip, returns its non-volatile memory; by default it is lost with the bench.
        keep: forget where the axes have been before that, for endless runs; None keeps everything.  Of pins,
            `record(keep=)` says it.

    Raises:
        BenchFileError: the journal cannot be written, or something else than a journal stands there.
        TimeError: `keep` is no duration.
    """

    for_users: ClassVar[tuple[str, ...]] = (
        *("add", "host", "part", "wire", "pin", "chips", "parts", "run", "run_to", "run_until", "run_until_idle", "at"),
        *("now", "now_ps", "findings", "quantity", "until", "until_idle", "wait", "connect", "place", "catch_up"),
        *("conclude", "record", "edges", "plot", "figure", "show", "readings", "timing", "timing_figure", "intervals"),
        *("check_timing", "save_vcd", "save_csv", "save_steps", "save_npz", "stream_vcd", "journal", "seed", "stores"),
        *("on_finding", "on_input", "on_commit"),
    )
    to_set: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ("now", "now_ps"), 'time passes: bench.run("1 ms"), or bench.run_to("5 ms")'
    )
    _busy: Chip | Part | None = None  # who was busy when all were asked last

    def __setattr__(self, name: str, value: object) -> None:
        if name[0] != "_" and "on_commit" in vars(self):  # which is the last that it is given when it is made
            if name in FIXED and vars(self)[name] is not value:
                raise NoSuchAttribute(f"bench: {name} cannot be set; {FIXED[name]}")
            if type(self) is Bench and name not in vars(self) and not hasattr(Bench, name):
                meant = hint(name, [*self.for_users, *FIXED]) or "; keep what is yours in a variable"
                raise NoSuchAttribute(f"bench has no {name!r} that could be set{meant}")
        super().__setattr__(name, value)

    # ------------------------------------------------------------------------------------------------------ running
    @property
    def now_ps(self) -> int:
        """Virtual time now, in picoseconds since the beginning."""
        return self.kernel.now

    @property
    def now(self) -> Seconds:
        """Virtual time now, in seconds: a float that prints as "0.170768 s" and may be given wherever a time is."""
        return Seconds(self.kernel.now)

    def at(self, time: Time, function: Callable[[], object]) -> None:
        """Call a function at an instant, in its first round: everything still reads as it was before.

        Args:
            time: since the beginning, not before now: "12 ms", or picoseconds (0, or at least 1000).
            function: takes nothing; what it returns is ignored. It must not let time pass.

        Raises:
            TimeError: not a time.
            UsageError: the instant is over, or `function` is none.
        """
        ps = picoseconds(time)
        if not callable(function):
            raise UsageError(f"at {readable(ps)}: {function!r}; expected a function")
        if wrong := misfit(function):
            raise UsageError(f"at {readable(ps)}: {wrong}; the function takes nothing: lambda: x.pin('abort').drive(0)")
        if ps < self.kernel.now:
            raise UsageError(f"at {readable(ps)}: that is over; it is {readable(self.kernel.now)}")
        self.kernel.call_at(ps, function)

    def _start(self) -> None:
        self._begin()
        self.kernel.settle()

    def run(self, duration: Time) -> None:
        """Let virtual time pass.

        Args:
            duration: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: not a duration.
            UsageError: the call comes from within a run.
        """
        self._run_to(self.kernel.now + picoseconds(duration))

    def run_to(self, time: Time) -> None:
        """Let virtual time pass up to an instant, that instant included.

        Args:
            time: since the beginning: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: not a time.
            UsageError: the instant is over, or the call comes from within a run.
        """
        ps = picoseconds(time)
        if ps < self.kernel.now:
            raise UsageError(
                f"run_to {readable(ps)}: that is over; it is {readable(self.kernel.now)}, and run() takes a duration"
            )
        self._run_to(ps)

    def _run_to(self, ps: int) -> None:
        self._begin()
        self._advance(ps)
        self.outside.tell("run", to=self.kernel.now)

    def run_until_idle(self, timeout: Time = "60 s") -> None:
        """Run until every host queue is empty and every chip idle.

        Args:
            timeout: of virtual time, from now on.

        Raises:
            Timeout: something still waits; the message says what for.
            TimeError: `timeout` is no duration.
            UsageError: the call comes from within a run.
        """
        self._until(self._all_idle, None, "every queue empty and every chip idle", timeout)
        self.conclude()

    def conclude(self) -> None:
        """Let chips tell, as findings, what their hosts have begun and not gone on with: a setting without its update.

        `run_until_idle`, the fixtures of tests, `slewline run` and a server that a host leaves do so by themselves.  Of
        a host that has more to say nothing is told yet.
        """
        from ..parts.boards.board import Board  # an empty bench has no host, and does not load any
        from ..parts.hosts.host import Host

        if all(part.idle for part in self.parts.values() if isinstance(part, Host | Board)) and any(
            [chip.conclude() for chip in self.chips.values()]  # of every one
        ):
            self.outside.tell("conclude")

    def _all_idle(self) -> bool:
        if self._busy is not None and not self._busy.idle:  # ask first who was busy last time
            return False
        for owner in self._owners():
            if not owner.idle:
                self._busy = owner
                return False
        return True

    def run_until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Run until a condition is met: x.reaches(40), pin.is_(0), pin.edges(3), host.got(b"Y"), or one of two (`|`).

        Args:
            condition: or a function that returns true then. It is called after every instant, every step of every motor
                being one meanwhile: exact, and slow.
            timeout: of virtual time, from now on.

        Raises:
            Timeout: it is not met in time; the message says what everybody waits for.
            TimeError: `timeout` is no duration.
            UsageError: neither a condition nor a function, or the call comes from within a run.
        """
        self._until(*self._meant("run_until", condition, timeout))

    def _meant(self, verb: str, condition: Condition | Callable[[], bool], timeout: Time) -> tuple[Any, ...]:
        """Return what a wait for a condition needs to know: met, foreseen, in words, the timeout, its nets."""
        if isinstance(condition, Condition):
            if not condition.belongs(self.kernel):
                raise UsageError(f"{verb}({condition}): that is on another bench, whose time does not pass here")
            condition.begin()
            return condition.met, condition.foreseen, condition, timeout, condition.nets
        if callable(condition):
            what = getattr(condition, "__name__", "the condition")
            if wrong := misfit(condition):
                raise UsageError(f"{verb}({what}): {wrong}; the function takes nothing: lambda: x.position > 40")
            nets = [net for chip in self.chips.values() for net in chip.step_nets()]
            return condition, None, what, timeout, nets
        raise UsageError(f"{verb}({condition!r}): expected a condition such as x.reaches(40), or a function")

    def _wait_for(self, met: Callable[[], bool], what: str, timeout: Time) -> None:
        self._until(met, None, what, timeout)

    def _until(
        self,
        met: Callable[[], bool],
        when: Callable[[], int | None] | None,
        what: object,
        timeout: Time,
        nets: Iterable[Net] = (),
    ) -> None:
        """Instant after instant until `met`; `when` may say that it will come about between two events.

        The promised edges of `nets` are instants meanwhile.
        """
        self._start()
        kernel = self.kernel
        limit = kernel.now + picoseconds(timeout)
        for net in nets:
            net.watch(_seen)
        try:
            reached = self._predicted(met, when, limit) if when is not None else not kernel.run_while(met, limit)
        finally:
            for net in nets:
                net.unwatch(_seen)
        if not reached:
            dead = kernel.next_time() is None
            self._advance(limit)
            reached = met()
        self.outside.tell("run", to=kernel.now)
        if not reached:
            raise Timeout(self._explain(what, timeout, dead))

    # ------------------------------------------------------------------------------------------------------- asyncio
    async def until(self, condition: Condition | Callable[[], bool], timeout: Time = "60 s") -> None:
        """Wait until a condition is met, in a task of asyncio: `run_until` for a host that does several things at once.

        The loop must be one of virtual time: `slewline.testing.aio.run(main())`.

        Args:
            condition: as `run_until` takes it.
            timeout: of virtual time, from now on.

        Raises:
            Timeout: it is not met in time; the message says what everybody waits for.
            TimeError: `timeout` is no duration.
            UsageError: neither a condition nor a function, or the loop goes by the wall clock.
        """
        from .awaiting import virtual_loop

        loop = virtual_loop("until")
        await self._awaited(loop, *self._meant("until", condition, timeout))

    async def until_idle(self, timeout: Time = "60 s") -> None:
        """Wait until every host queue is empty and every chip idle, in a task of asyncio; raises as `until`."""
        from .awaiting import virtual_loop

        loop = virtual_loop("until_idle")
        await self._awaited(loop, self._all_idle, None, "every queue empty and every chip idle", timeout, ())
        self.conclude()

    async def wait(self, duration: Time) -> None:
        """Wait for a time, in a task of asyncio; others go on meanwhile.

        Args:
            duration: "12 ms", or picoseconds (0, or at least 1000).

        Raises:
            TimeError: not a duration.
            UsageError: the loop goes by the wall clock.
        """
        from .awaiting import virtual_loop

        loop = virtual_loop("wait")
        self._start()
        await loop.passed(self, lambda: False, None, (), picoseconds(duration))

    async def _awaited(
        self,
        loop: VirtualLoop,
        met: Callable[[], bool],
        when: Callable[[], int | None] | None,
        what: object,
        timeout: Time,
        nets: Iterable[Net],
    ) -> None:
        self._start()
        if not await loop.passed(self, met, when, nets, picoseconds(timeout)):
            raise Timeout(self._explain(what, timeout, self.kernel.next_time() is None))

    def _predicted(self, met: Callable[[], bool], when: Callable[[], int | None], limit: int) -> bool:
        """Like Kernel.run_while, for a condition that may come about between two events: `when` tells."""
        kernel = self.kernel
        while not met():
            following, early = kernel.next_time(), when()
            if early is not None and early <= limit and (following is None or early <= following):
                kernel.run(early)
            elif following is None or following > limit:
                return False
            else:
                kernel.run(following)
        return True

    def _explain(self, what: object, timeout: Time, dead: bool) -> str:
        lines = [f"waited {readable(picoseconds(timeout))} for {what}; it is {readable(self.kernel.now)}"]
        if dead and not any(chip.moving for chip in self.chips.values()):
            lines.append("nothing is going to happen any more")
        lines += [f"  {chip.waiting}" for chip in self.chips.values() if not chip.idle or chip.unfinished]
        lines += [f"  {part.waiting}" for part in self.parts.values() if not part.idle]
        return "\n".join(lines)


missing(
    Bench,
    **{
        name: f'chips and parts are found by their names: bench["{name}"]'
        for name in ("x", "y", "z", "motor", "driver")
    },
    **{name.replace("-", "_"): f'a chip is put on it: x = bench.add("{name}")' for name in CHIPS.ours},
    **dict.fromkeys(("send", "command", "write"), "bench.host(x).send(...), of x = bench.add(...)"),
    **dict.fromkeys(("ask", "query"), "bench.host(x).ask(...), of x = bench.add(...)"),
    **dict.fromkeys(("add_chip", "chip"), 'bench.add("PART")'),
    **dict.fromkeys(("add_part", "add_host"), "bench.part(KIND), or bench.host(x)"),
    **dict.fromkeys(("sleep", "advance", "step", "run_for"), 'bench.run("10 ms")'),
    **dict.fromkeys(
        ("wait_until", "run_idle", "until_is_idle"), "bench.run_until(x.reaches(40)) or bench.run_until_idle()"
    ),
    **dict.fromkeys(("remove", "delete", "reset", "clear"), "a bench only grows: make a new one, slewline.Bench()"),
    **dict.fromkeys(("time", "time_ps", "clock"), "bench.now, or bench.now_ps"),
    **dict.fromkeys(("save", "export", "write_vcd", "vcd"), 'bench.save_vcd("run.vcd"), save_csv or save_steps'),
    **dict.fromkeys(
        ("close", "stop", "quit", "shutdown", "exit"), "there is nothing to close; a journal: bench.journal.close()"
    ),
    save_edges='bench.save_csv("edges.csv"), or save_npz("edges.npz")',
    **dict.fromkeys(("picture", "draw", "savefig", "save_plot"), 'bench.plot("run.svg")'),
    **dict.fromkeys(("connect_pins", "join", "net"), 'bench.wire("x.run", "y.wait")'),
    **{name: f"it is a chip's: x.{name}, of x = bench.add(...)" for name in ("position", "steps", "pins")},
    **dict.fromkeys(("errors", "warnings", "log"), "bench.findings"),
)
