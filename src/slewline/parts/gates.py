"""Gates and latches of the 74 series: edge driven, without delay.  An open input reads high, as in TTL."""

from __future__ import annotations

from collections.abc import Iterable

from ..core.kernel import Kernel
from ..core.net import Net
from ..errors import UsageError
from .part import Part


class Gate(Part):
    """A gate with inputs in1, in2 ... and the output out.

    Args:
        inputs: how many, 1 to 8 (a 7430 has eight).
    """

    def __init__(self, kernel: Kernel, name: str, *, inputs: int = 2) -> None:
        super().__init__(kernel, name)
        if not 1 <= inputs <= 8:
            raise UsageError(f"{name}: {inputs} inputs; allowed 1 to 8")
        self.inputs = [self.add_pin(f"in{n + 1}", "in", f"input {n + 1}") for n in range(inputs)]
        self.add_pin("out", "out", "output")

    def law(self, levels: Iterable[bool]) -> bool:
        """The output for the levels of the inputs."""
        raise NotImplementedError

    def rewired(self) -> None:
        for terminal in self.inputs:
            terminal.net.watch(self._react)
        self._react()

    def _react(self, _net: Net | None = None) -> None:
        self.drivers["out"].drive(int(self.law(terminal.level != 0 for terminal in self.inputs)))


class And(Gate):
    """High while all inputs are high."""

    def law(self, levels: Iterable[bool]) -> bool:
        return all(levels)


class Or(Gate):
    """Low while all inputs are low."""

    def law(self, levels: Iterable[bool]) -> bool:
        return any(levels)


class Nand(Gate):
    """Low while all inputs are high."""

    def law(self, levels: Iterable[bool]) -> bool:
        return not all(levels)


class Nor(Gate):
    """High while all inputs are low."""

    def law(self, levels: Iterable[bool]) -> bool:
        return not any(levels)


class Inverter(Nand):
    """A NAND of one input: in1, out."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name, inputs=1)


class Latch8(Part):
    """74LS373: q follows d while `enable` is high and keeps it while low; q floats while `output_enable` is high."""

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_bus("d", "data in")
        self.add_bus("q", "data out")
        self.add_pin("enable", "in", "high: transparent")
        self.add_pin("output_enable", "in", "low: q drives")
        self.held = 0xFF

    def rewired(self) -> None:
        for name in ("d", "enable", "output_enable"):
            self.pin(name).net.watch(self._react)
        self._react()

    def _react(self, _net: Net | None = None) -> None:
        if self.high("enable"):
            self.held = self.byte("d")
        self.drivers["q"].drive(None if self.high("output_enable") else (0xFF, self.held))
