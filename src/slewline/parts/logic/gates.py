"""74-series gates, delay lines and latches.

Gates have no delay; an open input reads high, as in TTL.  The output of a gate follows from the promises
of its inputs (core/wires/views.py), so a gate makes no events of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import product
from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.datasheet.table import Pin
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...core.wires.net import Driver, Net
from ...core.wires.pin import Terminal
from ...core.wires.views import Delayed, gated, inverted
from ...core.wires.wave import Level, Promise, alike, promised
from ..base.follower import Follower, Stateless, start_rule
from ..base.part import Part

HIGH = (0, 1)  # level that an input reads
FUNCTIONS: Mapping[str, Callable[[Iterable[bool]], bool]] = MappingProxyType({  # output versus inputs, True: high
    "and": all,
    "or": any,
    "nand": lambda levels: not all(levels),
    "nor": lambda levels: not any(levels),
})  # fmt: skip


class Gate(Part):
    """A gate with inputs in1, in2 ... and the output out.

    Args:
        function: "and", "or", "nand" or "nor".
        inputs: the number of inputs, 1 to 8 (a 7430 has eight).
    """

    options = (
        Option("function", "choice", ..., "logic function of the output", choices=tuple(FUNCTIONS)),
        Option("inputs", "int", 2, "number of inputs: in1, in2 ...", low=1, high=8),
    )
    rewired = start_rule

    def __init__(self, kernel: Kernel, name: str, *, function: str, inputs: int = 2) -> None:
        super().__init__(kernel, name)
        pins = tuple(f"in{n + 1}" for n in range(inputs))
        for n, pin in enumerate(pins, 1):
            self.add_pin(pin, "in", f"input {n}")
        self.add_pin("out", "out", "output")
        high = FUNCTIONS[function]
        table = tuple(int(high(levels[::-1])) for levels in product((False, True), repeat=inputs))
        self.rule = Stateless(self, pins, {"out": partial(gated, table=table)})


class WireInverter(Part):
    """The inverter of `bench.wire(a, b, invert=True)`: drives the inverse of one net on another.

    The driven net floats while the first net floats.
    """

    rewired = start_rule

    def __init__(self, kernel: Kernel, name: str, source: Net, driven: Net) -> None:
        super().__init__(kernel, name)
        self.pins["in"] = Terminal(name, Pin(1, "in", "in", "input"), source)
        self.pins["out"] = Terminal(name, Pin(2, "out", "out", "the inverted level"), driven)
        self.drivers["out"] = Driver(driven, name)
        self.rule = Stateless(self, ("in",), {"out": lambda shown: inverted(shown[0])})


class Delay(Part):
    """A delay line: the output repeats the input, including its shortest pulses, after a delay.

    Args:
        delay: the delay, 1 ps or more.
    """

    options = (Option("delay", "time", "100 ns", "delay from the input to the output", low=1),)

    def __init__(self, kernel: Kernel, name: str, *, delay: Time = "100 ns") -> None:
        super().__init__(kernel, name)
        self._delay_ps = picoseconds(delay)
        self.add_pin("in", "in", "input")
        self.add_pin("out", "out", "the input, delayed")
        self._shown: Promise | Level = None
        self._pieces: list[tuple[int, Promise | Level]] = []  # past of the input, as far back as needed
        self._wired_ps = 0  # when the part was wired
        self.rule = Follower(self, ("in",), schedule=self._promise, react=self._drive, delay_ps=self._delay_ps)

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self._wired_ps = self.kernel.now
        self.rule.start()

    def _promise(self) -> None:
        """Promise the future levels of the output, given the promise or level of the input."""
        driver, shown = self.drivers["out"], self.rule.shown("in")
        if self._pieces and not self.rule.withdrawn and alike(shown, self._shown):
            if driver.promise is not None:
                driver.renew()
            return
        self._shown = shown
        self._follow(gated([shown], HIGH))

    def _drive(self) -> None:
        """Promise the future levels of the output, given only the present level of the input."""
        self._follow(int(self.high("in")))

    def _follow(self, shown: Promise | Level) -> None:
        """Promise the delayed output, given `shown`, the promise or level of the input that holds from now on."""
        now = self.kernel.now
        if not self._pieces or (now == self._wired_ps and not self.rule.edge_driven):  # the circuit is settling
            self._pieces = [(now - self._delay_ps, shown.level(now) if promised(shown) else shown)]
        while self._pieces[-1][0] == now:
            self._pieces.pop()
        gone = sum(since <= now - self._delay_ps for since, _ in self._pieces) - 1
        self._pieces = [*self._pieces[max(gone, 0) :], (now, shown)]
        levels = {what if not promised(what) else None for _, what in self._pieces}
        settled = len(levels) == 1 and None not in levels
        self.rule.put(self.drivers["out"], shown if settled else Delayed(self._pieces, self._delay_ps))


class Latch8(Part):
    """A 74LS373: q follows d while `enable` is high, else is latched; q floats while `output_enable` is high."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_bus("d", "data in")
        self.add_bus("q", "data out")
        self.add_pin("enable", "in", "high: transparent")
        self.add_pin("output_enable", "in", "low: q drives")
        self._latched = 0xFF

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        for name in ("d", "enable", "output_enable"):
            self.pin(name).net.watch(self._react)
        self._react()

    def _react(self, _net: Net | None = None) -> None:
        if self.high("enable"):
            self._latched = self.byte("d")
        self.drivers["q"].drive(None if self.high("output_enable") else (0xFF, self._latched))
