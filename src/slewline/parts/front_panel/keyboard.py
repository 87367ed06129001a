r"""A keyboard without a strobe of its own: a generator derives I/O REQUEST from the byte (s.10, fig. 10.8).

One strobe is generated per key, and only while READY is high:

    key       ____/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\____      the byte is on the bus while the key is down
    REQUEST   ‾‾‾‾\______/‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾      READY low ends the strobe,
    READY     ‾‾‾‾‾‾‾‾‾‾‾\___________/‾‾‾‾‾‾‾‾‾‾‾      and READY high does not start another one
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds
from ...core.wires.waits import first_of, until
from ..base.part import Part
from ..base.request_queue import RequestQueue
from ..base.written_data import Data, as_bytes


class Keyboard(Part):
    """A keyboard, with the typist who presses its keys."""

    _for_users = ("type",)
    wiring = MappingProxyType({"db": "data", "request": "request", "ready": "ready"})

    options = (
        Option("down", "time", "80 ms", "duration of a key press"),
        Option("apart", "time", "120 ms", "time from the release of one key to the next key press"),
    )

    def __init__(self, kernel: Kernel, name: str, *, down: Time, apart: Time) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name)
        self._down_ps, self._apart_ps = picoseconds(down), picoseconds(apart)
        self.add_bus("db", "the byte of the key that is down")
        self.add_pin("ready", "in", "READY of the chip", pull=1)
        self.add_pin("request", "out", "I/O REQUEST", initial=1)

    @from_outside
    def type(self, keys: Data) -> None:
        r"""Press one key after another; "\r" is RETURN."""
        data = as_bytes(self.name, keys)
        self.input("type", data)
        for byte in data:
            self.queue.post(f"types {byte:#04x}", lambda byte=byte: self._press(byte))  # type: ignore[misc]

    async def _press(self, byte: int) -> None:
        kernel, ready, request = self.kernel, self.net("ready"), self.drivers["request"]
        up = kernel.now + self._down_ps
        self.drivers["db"].drive((0xFF, byte))
        if await first_of(kernel, up, (ready, 1)) is None:
            self.finding("key-lost", f"key {byte:#04x} was pressed and released while READY was low")
        else:
            request.drive(0)
            taken = await first_of(kernel, up, (ready, 0))
            request.drive(1)
            if taken is None:
                self.finding("key-lost", f"key {byte:#04x} was released before the chip read it")
        await until(kernel, up)
        self.drivers["db"].drive(None)
        await until(kernel, up + self._apart_ps)
