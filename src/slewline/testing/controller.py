"""The object that a fixture returns: a running module, with a URL for programs, and queries and assertions for tests.

def test_a_feed(gs_c200s):
    feeder = Feeder(serial.serial_for_url(gs_c200s.url, 9600, 7, "O", 2, timeout=1))     the software under test
    feeder.feed(200)
    gs_c200s.until_idle()
    gs_c200s.assert_steps(200, direction=+1)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from io import StringIO
from numbers import Integral
from types import MappingProxyType
from typing import Any, ClassVar

from ..bench import Bench
from ..closing import Closing
from ..core.chip import Chip, step_nets
from ..core.messages.calls import answering
from ..core.messages.instead import face, missing
from ..core.messages.whole import counted
from ..core.motion.axis import Steps
from ..core.time.timebase import Time, moment, picoseconds, readable
from ..core.wires.pin import Condition, Terminal
from ..errors import SlewlineError, Timeout, UsageError
from .differences import difference
from .faults import Faults
from .rig import Rig, never

DIRECTIONS = MappingProxyType({1: "cw", -1: "ccw"})
LEVELS = MappingProxyType({0: "low", 1: "high", -1: "floating"})
SHOWN = 40  # lines of the transcript in a report


class KeptTranscript(StringIO):
    """A transcript that can still be read after it is closed."""

    def close(self) -> None:
        """Close the transcript, keeping its text."""


@face
class Controller(Closing):
    """A running module.

    Args:
        rig: the module on its bench, not yet started.
        label: the name of the module in the report of a failed test.
    """

    _for_users: ClassVar[tuple[str, ...]] = (
        *("url", "host", "chip", "bench", "faults", "now", "position", "pin", "advance", "until", "until_idle", "ask"),
        *("assert_reply", "assert_steps", "assert_edges", "report", "close", "closed", "label", "seed"),
    )

    def __init__(self, rig: Rig, label: str, seed: int) -> None:
        self.rig, self.label, self.seed, self.name = rig, label, seed, rig.chip.name
        self.bench: Bench = rig.bench
        self.chip: Chip = rig.chip
        rig.log.file = self._transcript = KeptTranscript()
        self.faults = Faults(rig.chip, getattr(rig, "line", None), rig.do, seed, rig.unplug, rig.plug)
        self.bench.place(self.faults)
        self.bench.record()

    def __repr__(self) -> str:
        return f"<{self.label}: {self.chip!r}>"

    @property
    def url(self) -> str:
        """The URL of the module, for serial.serial_for_url.

        Raises:
            UsageError: programs cannot reach the module, because it is on a bus or reserved for the test.
        """
        if not self.rig.url:
            name, part = self.chip.name, self.chip.sheet.part
            raise UsageError(
                f"{name} ({part}) has no url, because no program can reach it; command it through {name}.host"
            )
        return self.rig.url

    @property
    def host(self) -> Any:
        """The host computer on the bus, for a module without a serial line."""
        return self.rig.host

    @property
    def now(self) -> int:
        """The current virtual time, in picoseconds, for use as `since`."""
        return self.bench.now_ps

    @property
    def position(self) -> int:
        """The position counter."""
        return self.chip.position

    def pin(self, name: str) -> Terminal:
        """Return a pin of the module, for example to drive it: `module.pin("ui1").drive(0)`.

        Raises:
            UnknownName: there is no such pin; the message lists the existing ones.
        """
        return self.chip.pin(name)

    # ----------------------------------------------------------------------------------------------------------- time
    def advance(self, time: Time) -> None:
        """Let virtual time pass."""
        self.rig.wait(never, picoseconds(time))

    def until(self, condition: Condition | Callable[[], bool] | str, timeout: Time = "60 s") -> None:
        """Let virtual time pass until a condition is met: pin("mov").is_(0), "mov=0" for short, or any function.

        Raises:
            Timeout: the condition is not met within `timeout`.
        """
        if isinstance(condition, str):
            condition = self._level(condition)
        if isinstance(condition, Condition):
            met, text, nets, when = condition.met, condition.text, condition.nets, condition.foreseen
            self.rig.do(condition.begin)
        else:
            met, text, nets = condition, getattr(condition, "__name__", "the condition"), tuple(step_nets(self.chip))
            when = None
        if not self.rig.wait(met, picoseconds(timeout), when, nets):
            raise Timeout(f"{self.label}: waited {timeout} for {text}; {self.chip.waiting}")

    def until_idle(self, timeout: Time = "60 s") -> None:
        """Let virtual time pass until the module has executed all commands and the line is quiet."""
        self.until(self._idle, timeout)
        self.rig.do(self.bench.conclude)

    def _idle(self) -> bool:
        return self.chip.idle and self.rig.quiet()

    def _level(self, text: str) -> Condition:
        pin, equals, level = text.partition("=")
        if not equals or level.strip() not in ("0", "1"):
            raise UsageError(f"until({text!r}): expected a pin and its level, such as 'mov=0'")
        return self.chip.pin(pin.strip()).is_(int(level))

    # ------------------------------------------------------------------------------------------------------- exchange
    @answering("ask()")
    def ask(self, command: str, timeout: Time = "5 s") -> Any:
        r"""Send a command as a host would, and return the answer.

        An answer on a serial line is returned without its checksum and carriage return.  The program may have
        the line open meanwhile.  The listing that the command Q returns consists of lines separated by "\r".
        For a module with a host on its bus, this returns the result of the host's own `ask`.

        Raises:
            ChecksumError: the answer has a wrong checksum.
            Timeout: there is no complete answer within `timeout`.
            UsageError: the module has no serial line and is on a port, where only the program can command it.
        """
        rig, answer = self.rig, bytearray()
        if not hasattr(rig, "line"):
            return rig.do(lambda: rig.host.ask(command, timeout))
        if not hasattr(rig, "host"):
            raise UsageError(f'{self.label}: only the program on the port can command it; for ask(), use on="host"')

        def take(data: bytes) -> int:
            answer.extend(data)
            return 0

        before = rig.do(lambda: self._borrow(take, command))
        try:
            came = rig.wait(
                lambda: rig.host.uart.ends(command, bytes(answer)) and rig.line.quiet(), picoseconds(timeout)
            )
        finally:
            rig.do(lambda: self._give_back(*before))
        if not came:
            raise Timeout(
                f"{self.label}: {command!r}: no complete answer within {timeout}, received {bytes(answer)!r}; "
                f"{self.chip.waiting}"
            )
        return rig.host.uart.answer_in(command, bytes(answer)) or ""

    def _borrow(self, take: Callable[[bytes], int], command: str) -> tuple[Any, Callable[[], object]]:
        line, host = self.rig.line, self.rig.host
        before = line.host, host.uart.lent()
        line.host = take
        line.take(host.uart.spoken(command))
        return before

    def _give_back(self, holder: Any, restore: Callable[[], object]) -> None:
        self.rig.line.host = holder
        restore()

    # ----------------------------------------------------------------------------------------------------- assertions
    def assert_reply(self, command: str, expected: object) -> None:
        """Assert that the answer to a command is the expected one.

        Raises:
            AssertionError: the answer is not `expected`.
        """
        __tracebackhide__ = True
        answer = self.ask(command)
        if answer != expected:
            raise AssertionError(f"{command}: the answer is {answer!r}, expected {expected!r}")

    def assert_steps(
        self,
        expected: int | Sequence[Time] | Steps,
        direction: int | None = None,
        since: Time = 0,
        axis: int = 1,
    ) -> None:
        """Assert that the steps since an instant are as expected: in number, in time, or in time and direction.

        Args:
            expected: a number; times, measured from `since`; or the steps of another run.
            direction: the expected direction of all steps, +1 or -1; None for either.
            since: the instant from which steps are compared; by default 0.
            axis: the number of the axis, from 1, for a part that has several.
        """
        __tracebackhide__ = True
        if isinstance(expected, str) or not isinstance(expected, Integral | Iterable | Steps):
            raise UsageError(
                f"assert_steps({expected!r}): expected the number of steps, their instants, or the steps of another "
                "run, such as other.chip.steps()"
            )
        if direction not in (None, 1, -1):
            raise UsageError(f"assert_steps: direction {direction!r}; allowed +1 (clockwise), -1, or None for either")
        origin = moment(since)
        steps: Steps = self.rig.do(lambda: self.chip.axis(axis).steps(origin))
        found = [(int(time) - origin, int(sign)) for time, sign in zip(steps.times_ps, steps.directions, strict=True)]
        text = ""
        if isinstance(expected, Integral):
            wanted = [(time, direction or sign) for time, sign in found]
            if len(found) != expected:
                text = f"{counted(len(found), 'step')} found, expected {expected}"
                if not self.rig.host.idle:
                    text += f"; {self.rig.host.waiting}; until_idle() lets time pass"
        elif isinstance(expected, Steps):
            wanted = list(zip(map(int, expected.times_ps), map(int, expected.directions), strict=True))
        else:
            signs = [direction or sign for _, sign in found]
            wanted = [(moment(time), signs[n] if n < len(signs) else direction or 1) for n, time in enumerate(expected)]
        text = text or difference(found, wanted, "step", DIRECTIONS, self.chip.clock.hz)
        if text:
            raise AssertionError(text)

    def assert_edges(self, pin: str, expected: Sequence[tuple[Time, int]], since: Time = 0) -> None:
        """Assert that the changes of a pin since an instant are the expected ones.

        Each expected change is a pair: its time, measured from `since`, and the new level.
        """
        __tracebackhide__ = True
        origin = moment(since)
        name = f"{self.chip.name}.{self.chip.pin(pin).row.name}"
        times, levels = self.rig.do(lambda: self.bench.edges(name, origin))
        found = [(int(time) - origin, int(level)) for time, level in zip(times, levels, strict=True)]
        wanted = [self._edge(each) for each in expected]
        text = difference(found, wanted, "edge", LEVELS, self.chip.clock.hz)
        if text:
            raise AssertionError(f"{pin}: {text}")

    @staticmethod
    def _edge(expected: Any) -> tuple[int, int]:
        """Return the instant (ps) and the level of an expected edge."""
        match expected:
            case (time, (0 | 1 | -1) as level):
                return moment(time), int(level)
        raise UsageError(
            f'assert_edges: {expected!r}; expected an instant, then the level from that instant on: ("10 ms", 1)'
        )

    # --------------------------------------------------------------------------------------------------------- report
    def report(self) -> str:
        """Return a report for a failed test: the module's state, faults and findings, and the last dialogue."""
        try:
            return self.rig.do(lambda: "\n".join(self._lines()))
        except (
            SlewlineError,
            TimeoutError,
        ) as error:  # its server has ended or hangs, which may be why the test failed
            return str(error) or f"{self.rig.url}: the server does not answer"

    def _lines(self) -> Iterable[str]:
        self.bench.conclude()
        at = self.rig.url or f"a host over {self.rig.channel.description}"
        yield f"{self.chip.sheet.part} at {at}, seed {self.seed}, time {readable(self.now)}, position {self.position}"
        yield self.chip.waiting
        if self._idle():
            self.bench.conclude()
        findings = [str(found) for found in self.bench.findings]
        yield from ["", "faults and findings:", *findings] if findings else []
        if hasattr(self.rig, "line"):
            self.rig.log.end(self.rig.line.name)
        lines = self._transcript.getvalue().splitlines()
        yield f"\ntranscript (< to the module, > to the host), {min(len(lines), SHOWN)} of {len(lines)} lines:"
        yield from lines[-SHOWN:]

    def close(self) -> None:
        """Shut down the module; a program that has its port open gets an error.  A second call does nothing."""
        super().close()

    def _shut(self) -> None:
        self.rig.close()


missing(
    Controller,
    **dict.fromkeys(("sleep", "run", "wait", "step"), '{it}.advance("10 ms")'),
    **dict.fromkeys(("run_until", "wait_until"), '{it}.until("mov=0")'),
    **dict.fromkeys(("run_until_idle", "wait_idle", "wait_until_idle"), "{it}.until_idle()"),
    **dict.fromkeys(
        ("send", "write"), "{it}.ask(...) sends a command as a host, {it}.host.send(...) where there is one"
    ),
    **dict.fromkeys(("query", "command"), "{it}.ask(...), or the calls of {it}.host, where there is one"),
    **{name: f"{{it}}.chip.{name}" for name in ("findings", "steps", "registers", "velocity_at", "reaches", "idle")},
    port="{it}.url, which serial.serial_for_url opens",
    assert_position="assert {it}.position == ...",
    assert_findings="assert {it}.chip.findings == []",
)
