"""Gates, inverters and delay lines that follow every edge: the slow and obvious twins of parts/logic/gates.py.

They watch their inputs and drive a level after every change, and share nothing with views.
"""

from __future__ import annotations

from collections.abc import Callable

from slewline.parts.base.part import Part

LAWS: dict[str, Callable[[list[bool]], bool]] = {
    "and": all,
    "or": any,
    "nand": lambda levels: not all(levels),
    "nor": lambda levels: not any(levels),
    "inverter": lambda levels: not levels[0],
}


class EdgeGate(Part):
    """A gate with inputs in1, in2 ... and the output out."""

    def __init__(self, kernel, name: str, kind: str, inputs: int) -> None:
        super().__init__(kernel, name)
        self.law, self.inputs = LAWS[kind], [self.add_pin(f"in{n + 1}", "in", "") for n in range(inputs)]
        self.add_pin("out", "out", "")

    def rewired(self) -> None:
        for terminal in self.inputs:
            terminal.net.watch(self.follow)
        self.follow()

    def follow(self, _net=None) -> None:
        self.drivers["out"].drive(int(self.law([terminal.level != 0 for terminal in self.inputs])))


class EdgeDelay(Part):
    """A delay line: every level of the input, later."""

    looped = False  # it is on a circle of gates

    def __init__(self, kernel, name: str, delay_ps: int) -> None:
        super().__init__(kernel, name)
        self.delay_ps = delay_ps
        self.add_pin("in", "in", "")
        self.add_pin("out", "out", "")
        self.coming: dict[int, int] = {}  # the last level of an instant is the one that comes out

    def rewired(self) -> None:
        self.wired_ps = self.kernel.now
        self.pins["in"].net.watch(self.follow)
        self.follow()

    def follow(self, _net=None) -> None:
        level, now = int(self.high("in")), self.kernel.now
        if now == self.wired_ps and (not self.coming or not self.looped):
            self.drivers["out"].drive(level)  # the circuit is coming to rest; on a circle it need not
        if now + self.delay_ps not in self.coming:
            self.kernel.call_at(now + self.delay_ps, self.show)
        self.coming[now + self.delay_ps] = level

    def show(self) -> None:
        self.drivers["out"].drive(self.coming.pop(self.kernel.now))


def placed(bench, kind: str, name: str, *, twin: bool, inputs: int = 1, delay_ps: int = 0) -> None:
    """Put a gate or a delay line on a bench: that of the house, or its twin."""
    if kind == "delay":
        if twin:
            bench.place(EdgeDelay(bench.kernel, name, delay_ps))
        else:
            bench.part("delay", name, delay=f"{delay_ps} ps")
    elif twin:
        bench.place(EdgeGate(bench.kernel, name, kind, inputs))
    else:
        bench.part(kind, name, **({} if kind == "inverter" else {"inputs": inputs}))
