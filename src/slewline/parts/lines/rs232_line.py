r"""An RS-232 line with faults, between a host's connector and one or more modules.

host   txd --> host_txd | line | txd --> rxd   module
       rxd <-- host_rxd |      | rxd <-- txd

Edges pass without delay.  The line counts characters, so it must be set to their rate and format; a fault changes the
levels of some bits of a character:

    mark   ‾‾‾‾\_____/  d0 |  d1 | ... |  dn | parity | stop | stop ‾‾‾‾‾
               |<------------------- lost: mark -------------------->|
                          garbled: one inverted   ^        ^ framing: space
                                                  parity: inverted
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Clock, Time, picoseconds
from ...core.wires.net import Driver, Net
from ...core.wires.pin import Terminal
from ...core.wires.serial import BAUD, OVERSAMPLING, RS232, CharacterFormat, bit_clock, word_options
from ...errors import UsageError
from ..base.part import Part
from .noise import Noise

MARK, SPACE = RS232, 1 - RS232
INVERTED = 2  # effects of a window on the level; MARK and SPACE fix it
DIRECTIONS = ("to_module", "to_host")


class LineDirection:
    """One direction of a line.

    A window (start, stop, effect) changes the levels from the instant `start` until just before `stop` (ps).
    """

    def __init__(self, source: Terminal, driver: Driver, clock: Clock, word: CharacterFormat) -> None:
        self.source, self.driver, self.kernel = source, driver, driver.kernel
        self.clock, self.word, self.noise = clock, word, Noise(word.bits)
        self.windows: list[tuple[int, int, int]] = []
        self.free_ps = 0  # after this instant a space is the start bit of the next character
        self.characters = 0

    def changed(self, net: Net) -> None:
        """Pass on an edge; if the edge begins a character, begin the fault that is planned for it, if any."""
        now = self.kernel.now
        if net.level == SPACE and now >= self.free_ps:
            self.characters += 1
            self.free_ps = now + self.clock.ps(self.word.ticks - OVERSAMPLING // 2)
            kind, bit = self.noise.strike()
            if kind:
                self._strike(kind, bit)
        self.put()

    def _strike(self, kind: str, bit: int) -> None:
        stop = (self.word.ticks - self.word.stop_ticks) // OVERSAMPLING
        first, last, does = {
            "lost": (0, stop, MARK),
            "garbled": (1 + bit, 2 + bit, INVERTED),
            "parity": (stop - 1, stop, INVERTED),
            "framing": (stop, stop + 1, SPACE),
        }[kind]
        start, end = (self.kernel.now + self.clock.ps(OVERSAMPLING * n) for n in (first, last))
        self.bend(start, end, does)

    def bend(self, start: int, stop: int, does: int) -> None:
        """Change the levels at start <= t < stop (ps) as `does` requires: MARK, SPACE, or INVERTED (the inverse)."""
        self.windows.append((start, stop, does))
        for ps in (start, stop):
            self.kernel.call_at(ps, self._after_edges)

    def _after_edges(self) -> None:
        """Pass on the level in the next round, after all edges at this instant; otherwise a spike could occur."""
        self.kernel.call_at(self.kernel.now, self.put)

    def put(self) -> None:
        """Pass on the present level, as changed by the window that is open now, if any."""
        now = self.kernel.now
        self.windows = [window for window in self.windows if now < window[1]]
        level = int(self.source.level == SPACE)
        does = next((does for start, _, does in self.windows if start <= now), None)
        self.driver.drive({None: level, INVERTED: 1 - level}.get(does, does))


class Rs232Line(Part):
    """A line with planned faults: lost and garbled characters, wrong parity, missing stop bits, and a break.

    bench.host(x, line=line) puts the line between a host and its module x.  For a connector y that is not a
    host's, bench.part(..., to=y) wires the line to y, and bench.connect(line, [x]) wires it to module x.
    """

    _for_users = ("plan", "clear", "send_break", "way")
    wiring = MappingProxyType({"host_txd": "computer_out", "host_rxd": "computer_in"})
    options = (BAUD, *word_options(7, "odd", 2))

    def __init__(self, kernel: Kernel, name: str, *, baud: int | str, bits: int, parity: str, stop: int | str) -> None:
        super().__init__(kernel, name)
        self._word, self._clock = CharacterFormat(bits, parity, stop).checked(name), bit_clock(baud, name)
        ends = (
            self.add_pin("host_txd", "in", "from the host", pull=MARK, role="serial_in", active=SPACE),
            self.add_pin("rxd", "in", "from the module", pull=MARK, role="computer_in", active=SPACE),
        )
        self.add_pin("txd", "out", "to the module", initial=MARK, role="computer_out", active=SPACE)
        self.add_pin("host_rxd", "out", "to the host", initial=MARK, role="serial_out", active=SPACE)
        self._directions = {
            direction: LineDirection(end, self.drivers[out], self._clock, self._word)
            for direction, end, out in zip(DIRECTIONS, ends, ("txd", "host_rxd"), strict=True)
        }

    def rewired(self) -> None:
        """Start to follow the levels from both sides, now that the line is wired."""
        for direction in self._directions.values():
            direction.source.net.watch(direction.changed)
            direction.changed(direction.source.net)

    def way(self, name: str) -> LineDirection:
        """Return one direction of the line: "to_module" or "to_host"."""
        if name not in self._directions:
            raise UsageError(f"{self.name}: direction {name!r}; allowed {', '.join(DIRECTIONS)}")
        return self._directions[name]

    @from_outside
    def plan(self, way: str, kind: str, count: int = 1, chance: float = 1, seed: int = 0, after: int = 0) -> None:
        """Plan faults of future characters; the plan begins when earlier plans for this direction are completed.

        Args:
            way: "to_module" or "to_host".
            kind: "lost", "garbled" (a data bit inverted), "parity" or "framing".
            count: the number of characters with the fault.
            chance: the probability that a character is hit, until `count` have been hit.
            seed: the seed of the random numbers.
            after: the number of characters that pass before the first one that may be hit.
        """
        if kind == "parity" and self._word.parity == "none":
            raise UsageError(f"{self.name}: fault 'parity'; {self._word} has no parity bit")
        self.way(way).noise.plan(kind, count, chance, seed, after)
        self.input("plan", way, kind, count, chance, seed, after)

    @from_outside
    def send_break(self, way: str, duration: Time) -> None:
        """Hold one direction at space from now on, for a duration."""
        now, ps = self.kernel.now, picoseconds(duration)
        self.input("send_break", way, f"{ps} ps")
        self.way(way).bend(now, now + ps, SPACE)

    @from_outside
    def clear(self) -> None:
        """Cancel all planned faults; a character that has begun keeps its fault."""
        self.input("clear")
        for direction in self._directions.values():
            direction.noise.clear()
