"""A software board that runs at the speed of this computer's clock; its port name is `twin`."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from time import perf_counter_ns

from ...errors import UsageError
from .boards import UNO, BoardModel
from .frames import Decoder, Frame
from .twin_board import BoardTwin
from .wire import FrameKind, check_numbers

TWIN = "twin"
KEPT_STEPS = 100_000


class TwinPort:
    """The port of a simulated board, for trials without any hardware.

    Args:
        model: the board to simulate.
        clock: a function that returns the wall-clock time in nanoseconds.
    """

    name = TWIN

    def __init__(self, model: BoardModel = UNO, clock: Callable[[], int] = perf_counter_ns) -> None:
        self.model, self.clock = model, clock
        self.began_ns = clock()
        self.twin = BoardTwin(model)
        self._decoder = Decoder()

    def _present(self) -> int:
        """Run the board and its main loop up to the present, and return its tick."""
        tick = (self.clock() - self.began_ns) * self.model.hz // 10**9
        self.twin.look_for_silence(tick)
        for past in (self.twin.steps, self.twin.pulses, self.twin.phases, self.twin.outputs, self.twin.enable):
            if len(past) > 2 * KEPT_STEPS:
                del past[:-KEPT_STEPS]
        return tick

    def set_input(self, name: str, level: int) -> None:
        """Set an input of the board, such as "A1", as a switch would: 0 is closed (to ground); 1 is open.

        Raises:
            UsageError: there is no such input or level.
        """
        printed = [pin.printed for pin in self.model.inputs]
        if name.upper() not in printed or level not in (0, 1):
            raise UsageError(f"input {name!r}, level {level!r}; allowed {', '.join(printed)}, and 0 (closed), 1 (open)")
        self.twin.set_input(printed.index(name.upper()), level, self._present())

    def close_contacts(self, numbers: Iterable[int]) -> None:
        """Close the inputs with these numbers to ground; all other inputs are unchanged."""
        for number in numbers:
            self.set_input(self.model.inputs[number].printed, 0)

    def fileno(self) -> None:
        """Return None: there is no descriptor to wait for."""

    def write(self, data: bytes) -> int:
        """Send bytes to the board and return their number; the board's STEP output is wired to its counter input."""
        tick = self._present()
        self.twin.receive(data, tick)
        for frame in self._decoder.feed(data):
            if isinstance(frame, Frame) and frame.kind == FrameKind.CHECK:
                self.twin.checked(check_numbers(frame.payload)[0], True, tick)
        return len(data)

    def read(self) -> bytes:
        """Return the bytes sent by the board since the last call."""
        self._present()
        return self.twin.take()

    def close(self) -> None:
        """Switch the board off."""
        self.twin.power_up(self._present())
