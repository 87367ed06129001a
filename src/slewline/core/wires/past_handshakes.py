r"""Past handshakes: the edges of all commands in a window are computed together, when they are requested.

    commands    R 5 \r      N 100 \r        G \r         the recorded commands
    requests    | | |  |    | | | | |  |    | |          one array: the clock tick of each request
    a wire      each edge a few ticks after a request    one array: the instant of each edge

A saved dialogue has thousands of commands, and a chip takes the same time for every byte that it only
stores; so a few operations on arrays give all the edges of a wire.  They are the same edges that
handshaken_bytes.py computes for each command separately.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

from ..time.events import When
from .exchange import PastExchanges
from .handshaken_bytes import HandshakenBytes
from .wave import FLOATING, Level

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Edges: TypeAlias = tuple[NDArray[np.int64], NDArray[Any]]

Drawn: TypeAlias = Callable[[Sequence[HandshakenBytes]], "ManyCommands"]  # a class that draws many commands


class ManyCommands:
    """The bytes of consecutive commands; each method returns the edges of one wire during all the commands.

    Args:
        commands: the commands, at least one, in their order, all from one host to one chip.

    Attributes:
        requests: the instants at which I/O REQUEST falls, one for each byte, (n,) int64 ps.
        ends: for each command, the number of bytes in it and in all commands before it.
    """

    def __init__(self, commands: Sequence[HandshakenBytes]) -> None:
        import numpy as np

        self.commands, self.times, self.clock = commands, commands[0].times, commands[0].clock
        counts = [len(command.data) for command in commands]
        self.ends = np.cumsum(counts)
        first = self.ends - counts  # the number of each command's first byte
        self.origin = commands[0].tick
        begun = np.array([command.tick - self.origin for command in commands])
        self.ticks = np.repeat(begun - first * self.times.kept, counts) + np.arange(self.ends[-1]) * self.times.kept
        self.requests = self._instants(0)
        self.requests[first] = [command.start for command in commands]

    def _instants(self, clocks: int) -> NDArray[np.int64]:
        """Return, for each byte, the instant (ps) that is `clocks` clock ticks after its request."""
        return self.clock.ps_array(self.ticks + clocks, self.origin)

    def request(self) -> Edges:
        """Return the edges of I/O REQUEST."""
        return _alternating(self.requests, self._instants(self.times.busy), 0)

    def bus(self) -> Edges:
        """Return the edges of the host's output on the bus; a level is 256 * (mask of driven wires) + value."""
        import numpy as np

        ends = self.ends[[command.released for command in self.commands]]
        last = [command.last for command in self.commands if command.released]
        return np.insert(self.requests, ends, last), np.insert(self.driven, ends, FLOATING)

    @property
    def driven(self) -> NDArray[np.int32]:
        """The bus level that the host drives during each byte, (n,) int32; all eight wires are driven."""
        import numpy as np

        return np.frombuffer(b"".join([command.data for command in self.commands]), np.uint8) | np.int32(0xFF00)

    def strobe(self, active: int) -> Edges:
        """Return the edges of INSTROBE, given the active level of INSTROBE."""
        return _alternating(self._instants(self.times.strobe), self._instants(self.times.sample), active)

    def ready(self) -> Edges:
        """Return the edges of READY."""
        import numpy as np

        opened = [command.opened for command in self.commands]
        rises = np.append(self.requests[1:], 0)
        rises[self.ends - 1] = [-1 if at is None else at for at in opened]
        times, levels = _alternating(self._instants(self.times.busy), rises, 0)
        if None not in opened:
            return times, levels
        return times[times >= 0], levels[times >= 0]


def _alternating(first: NDArray[np.int64], second: NDArray[np.int64], level: int) -> Edges:
    import numpy as np

    times = np.stack((first, second), axis=1).ravel()
    return times, np.tile(np.array((level, 1 - level), np.int8), len(first))


@lru_cache(maxsize=4)
def drawn(kind: Drawn, commands: tuple[HandshakenBytes, ...]) -> ManyCommands:
    """Return `kind(commands)` from a cache, because several wires are computed from the same commands in turn."""
    return kind(commands)


class PastHandshakes:
    """The waveform of a net over consecutive commands, each of which ends before the next begins.

    Args:
        each: the same commands as a `PastExchanges`, which computes their edges command by command.
        kind: the class that draws many commands.
    """

    __slots__ = ("each", "kind")
    until: int | None = None
    floats = True  # possibly at times, as for `PastExchanges`

    def __init__(self, each: PastExchanges, kind: Drawn) -> None:
        self.each, self.kind = each, kind

    def level(self, ps: int) -> Level:
        """Return the level at an instant (ps), after any edge at that instant."""
        return self.each.level(ps)

    def after(self, ps: int) -> When:
        """Return the instant (ps) of the first edge strictly after the instant `ps`; None if there was none."""
        return self.each.after(ps)

    def edges(self, start: int, stop: int) -> tuple[Any, Any]:
        """Return the edges in start < t <= stop: times (ps) and levels, in arrays or, with several drivers, lists."""
        starts, states, shown = self.each.starts, self.each.states, self.each.shown
        if len(shown) > 1:
            return self.each.edges(start, stop)
        first, over = max(bisect_right(starts, start) - 1, 0), max(bisect_right(starts, stop), 1)
        edges: Any = shown[0](drawn(self.kind, tuple(states[first:over])))
        times, levels = edges
        window = slice(bisect_right(times, start), bisect_right(times, stop))
        return times[window], levels[window]
