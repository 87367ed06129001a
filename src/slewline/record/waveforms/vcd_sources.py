"""The contents of a value change dump: variables, and the sources of their changes.

A source is expanded once per chunk and may feed several variables: a bus feeds its wires.

    source               variables                kind      values
    net "x.slew"         x.slew                   wire      0, 1, z
    bus "x.db"           x.db0 ... x.db7          wires     0, 1, z where nothing drives
    quantity             x.velocity               real      exact; a staircase; spaces in a name as _
    texts                x.finding                string    each text until the next
    states               x.command, x.motion      string    empty while there is no state
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, TypeAlias

from ...core.wires.net import Bus
from ...core.wires.pin import Terminal
from ...errors import UsageError
from ..recording.recorder import FLOATING, Probe, Recorder, Wires, net_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Changes: TypeAlias = tuple[NDArray[np.int64], Any]  # (n,) ps, ascending; n values

Kind: TypeAlias = Literal["wire", "real", "string"]
Buses: TypeAlias = Literal["bits", "whole", "both"]
BUSES = ("bits", "whole", "both")


class Variable(NamedTuple):
    """A variable in the file.  Dots in the name separate scopes.  For a bus wire, `bus` is the name of its bus.

    If a variable has several values within one time unit of the file, only the last is written.  If `all` is
    True, as is possible for a string, all of them are written.
    """

    name: str
    kind: Kind = "wire"
    size: int = 1
    bus: str = ""
    all: bool = False


class HasValue(Protocol):
    """An object with a value at every instant, such as `slewline.core.motion.quantity.Quantity`."""

    def staircase(self, start: int, stop: int) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the value at `start` and all changes in start < t <= stop (ps); each value holds until the next.

        A value that varies continuously is approximated by steps, which are the same for every window.
        """


class VariableSource(Protocol):
    """The source of the changes of some variables."""

    variables: list[Variable]

    def values_at(self, ps: int) -> list[Any]:
        """Return the value of every variable at an instant (ps)."""

    def changes(self, start: int, stop: int) -> Changes:
        """Return the changes in start <= t <= stop (ps), with the values of all variables combined."""

    def split(self, values: Any) -> list[Any]:
        """Return the values of each variable, extracted from the combined values that `changes` returned."""


class NetSource:
    """The source of a net or a pin; a bus has a variable for each wire, one for the whole bus, or both.

    Raises:
        UsageError: `buses` is none of "bits", "whole" and "both".
    """

    def __init__(self, recorder: Recorder, name: str, probe: Probe, buses: Buses = "bits") -> None:
        if buses not in BUSES:
            raise UsageError(f"buses {buses!r}: allowed {', '.join(map(repr, BUSES))}")
        self.recorder, self.probe = recorder, probe
        self.wires = isinstance(net_of(probe), Bus) and not (isinstance(probe, Terminal) and probe.bit is not None)
        self.whole = buses != "bits"
        self.bits = range(net_of(probe).width if buses != "whole" else 0)
        self.variables = [Variable(name)]
        if self.wires:
            self.probe = Wires(net_of(probe))
            whole = [Variable(name, size=net_of(probe).width)] if self.whole else []
            self.variables = whole + [Variable(f"{name}{bit}", bus=name) for bit in self.bits]

    def values_at(self, ps: int) -> list[int]:
        """Return the levels at an instant (ps), one per variable.

        Raises:
            NotRecorded: the net is not recorded, or its past is no longer kept that far back.
        """
        import numpy as np

        return [int(levels[0]) for levels in self.split(np.array([self.recorder.level(self.probe, ps)]))]

    def changes(self, start: int, stop: int) -> Changes:
        """Return the edges in start <= t <= stop (ps); a bus has an edge whenever one of its wires changes."""
        return self.recorder.edges(self.probe, start, stop)

    def split(self, values: NDArray[Any]) -> list[NDArray[Any]]:
        """Return the levels of each variable, extracted from the levels that `changes` returned."""
        import numpy as np

        if not self.wires:
            return [values]
        floating = values == FLOATING
        driven, high = values >> 8, values & 0xFF
        whole = [np.where(floating, FLOATING, high | ~driven & 0xFF)] if self.whole else []
        return whole + [np.where(floating | (driven >> bit & 1 == 0), FLOATING, high >> bit & 1) for bit in self.bits]


def reference(owner: str, quantity: str) -> str:
    """Return a quantity's name in a file, without spaces: "m.current_1" for owner "m" and quantity "current 1"."""
    return f"{owner}.{'_'.join(quantity.split())}"


class CurveSource:
    """The source of a quantity's values, each given as the 64 bits of the number, so that NaN equals itself."""

    def __init__(self, name: str, curve: HasValue) -> None:
        self.curve, self.variables = curve, [Variable(name, "real", 64)]

    def values_at(self, ps: int) -> list[int]:
        """Return a list with the value at an instant (ps), as the 64 bits of the number."""
        return [int(self.split(self.curve.staircase(ps, ps)[1])[0][-1])]

    def changes(self, start: int, stop: int) -> Changes:
        """Return the value of the quantity at `start`, and all its changes in start < t <= stop (ps)."""
        return self.curve.staircase(start, stop)

    def split(self, values: NDArray[np.float64]) -> list[NDArray[np.int64]]:
        """Return a list with one item: the values, each as the 64 bits of the number."""
        import numpy as np

        return [(values + 0.0).view(np.int64)]  # zero has no sign


class TextSource:
    """The source of occasional texts, each of which holds until the next.

    Args:
        name: the name of the variable.
        texts: a function that returns (ps, text) for all texts in start <= t <= stop, in order.
        all: True if all texts are written, even several within one time unit of the file; False if the texts
            are states, of which only the last in each unit is written.
    """

    def __init__(self, name: str, texts: Callable[[int, int], Sequence[tuple[int, str]]], all: bool = True) -> None:
        self.texts, self.variables = texts, [Variable(name, "string", all=all)]

    def values_at(self, ps: int) -> list[str]:
        """Return a list with the last text at or before an instant (ps); "" stands for no text."""
        texts = self.texts(0, ps)
        return [texts[-1][1] if texts else ""]

    def changes(self, start: int, stop: int) -> Changes:
        """Return every text in start <= t <= stop (ps)."""
        import numpy as np

        texts = self.texts(start, stop)
        return np.array([ps for ps, _ in texts], np.int64), [text for _, text in texts]

    def split(self, values: list[str]) -> list[NDArray[Any]]:
        """Return a list with one item: the texts, unchanged."""
        import numpy as np

        return [np.array([*values, None], object)[:-1]]
