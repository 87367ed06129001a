"""A chip on a full IEEE-488 bus (s.12, figs. 12.5 to 12.9): addressed interface, controller, interrupt logic.

    controller ==== GPIB, negative logic ==== interface ---- inverting buffers ---- chip
                                                  |- CLR, TRIG -> interrupt logic -> STEP INHIBIT, SRQ

Listen: a byte is sent to the chip by the two-line handshake; NDAC follows READY.  Talk: I/O SELECT goes high, and
whenever the controller is ready for a byte, a verify byte is fetched from the chip.  Serial poll: eight pins of the
chip are read as a byte.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel, Task
from ...core.wires.net import Net
from ...core.wires.waits import first_of, level, until
from ..base.part import Part
from ..base.request_queue import Request, RequestQueue
from ..base.written_data import Data
from .gpib import (
    HANDSHAKE,
    MANAGEMENT,
    REACTION_PS,
    SETTLING_PS,
    US,
    GpibTalker,
    SourceHandshake,
    Talks,
    add_bus_lines,
    pull,
)

GO_TO_LOCAL, LOCAL_LOCKOUT = 0x01, 0x11  # has no meaning for a device without a panel
SELECTED_CLEAR, TRIGGER, DEVICE_CLEAR, POLL_ENABLE, POLL_DISABLE = 0x04, 0x08, 0x14, 0x18, 0x19
LISTEN, UNLISTEN, TALK, UNTALK = 0x20, 0x3F, 0x40, 0x5F
STATUS = ("motion_complete", "step", "running", "program_entry", "output1", "ready", "direction", "slewing")  # roles


class GpibDevice(Part):
    """The addressed interface of a chip: a 96LS488 with its handshake logic and inverting buffers."""

    _for_users = ("address",)
    wiring = MappingProxyType(
        {"db": "data", "io_request": "request", "io_select": "select", "ready": "ready"}
        | {f"s{bit}": role for bit, role in enumerate(STATUS)}
    )

    options = (Option("address", "int", 5, "address of the device on the bus", low=0, high=30),)

    def __init__(self, kernel: Kernel, name: str, *, address: int) -> None:
        super().__init__(kernel, name)
        self.address = address
        add_bus_lines(self)
        self.add_bus("db", "data bus of the chip")
        self.add_pin("io_request", "out", "I/O REQUEST of the chip", initial=1)
        self.add_pin("io_select", "out", "I/O SELECT of the chip", initial=0)
        self.add_pin("ready", "in", "READY of the chip", pull=1)
        for bit in range(8):
            self.add_pin(f"s{bit}", "in", f"status poll, bit {bit}", pull=1)
        self.add_pin("clr", "out", "a high pulse at device clear", initial=0)
        self.add_pin("trig", "out", "a high pulse at device trigger", initial=0)
        self._task: Task | None = None

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        self.pin("ifc").net.watch(self._interface_clear)
        self.pin("atn").net.watch(self._attention)
        self._begin()

    def _begin(self) -> None:
        self.listening = self.talking = self.polling = False
        self._task = self.kernel.spawn(self._run, name=self.name)

    def _interface_clear(self, net: Net) -> None:
        """Handle a change of IFC: if it is low, release all lines, and stop listening, talking and polling."""
        if net.level == 0 and self._task is not None:
            self._task.kill()
            for name in ("dio", "db", *HANDSHAKE):
                self.drivers[name].drive(None)
            self.drivers["io_request"].drive(1)
            self.drivers["io_select"].drive(0)
            self._begin()

    def _attention(self, net: Net) -> None:
        """Handle a change of ATN: if it is low, hold NRFD and NDAC low from now until the task handles ATN."""
        if net.level == 0:
            pull(self, "nrfd", True)
            pull(self, "ndac", True)

    async def _run(self) -> None:
        atn, names = self.pin("atn").net, ("nrfd", "ndac")
        while True:
            commanded = atn.level == 0
            if commanded or self.listening:
                pull(self, "ndac", True)
                await self._accept(commanded)
            elif self.talking:
                await self._talk()
            else:
                for name in names:
                    pull(self, name, False)
                await level(atn, 0)

    # ------------------------------------------------------------------------------------------------------- acceptor
    async def _accept(self, commanded: bool) -> None:
        """Receive one byte: an interface message if `commanded`, otherwise data for the chip.

        Return without a byte if ATN changes first.
        """
        atn, dav, ready = (self.pin(name).net for name in ("atn", "dav", "ready"))
        change = (atn, 1 if commanded else 0)
        if not commanded:
            pull(self, "nrfd", ready.level != 1)
            if await first_of(self.kernel, None, change, (ready, 1)) is atn:
                return
        pull(self, "nrfd", False)
        if await first_of(self.kernel, None, change, (dav, 0)) is atn:
            return
        byte = self.byte("dio") ^ 0xFF
        pull(self, "nrfd", True)
        if commanded:
            await self._message(byte & 0x7F)
        else:
            await self._to_chip(byte)
        pull(self, "ndac", False)
        await level(dav, 1)
        pull(self, "ndac", True)

    async def _to_chip(self, byte: int) -> None:
        self.drivers["db"].drive((0xFF, byte))
        self.drivers["io_request"].drive(0)
        await level(self.pin("ready").net, 0)
        self.drivers["io_request"].drive(1)
        self.drivers["db"].drive(None)

    async def _message(self, code: int) -> None:
        if code in (UNLISTEN, LISTEN + self.address):
            self.listening = code != UNLISTEN
        elif TALK <= code <= UNTALK:
            self.talking = code == TALK + self.address
        elif code in (POLL_ENABLE, POLL_DISABLE):
            self.polling = code == POLL_ENABLE
        elif code == DEVICE_CLEAR or (code == SELECTED_CLEAR and self.listening):
            await self._pulse("clr")
        elif code == TRIGGER and self.listening:
            await self._pulse("trig")

    async def _pulse(self, name: str) -> None:
        self.drivers[name].drive(1)
        await until(self.kernel, self.kernel.now + US)
        self.drivers[name].drive(0)

    # --------------------------------------------------------------------------------------------------------- source
    async def _talk(self) -> None:
        """Send a verify byte (in a serial poll: the status) whenever the controller is ready, until ATN is low."""
        atn, nrfd, ready = (self.pin(name).net for name in ("atn", "nrfd", "ready"))
        pull(self, "nrfd", False)
        pull(self, "ndac", False)
        while await first_of(self.kernel, None, (atn, 0), (nrfd, 1)) is not atn:
            if self.polling:
                await self._give(sum(self.high(f"s{bit}") << bit for bit in range(8)))
                continue
            if await first_of(self.kernel, None, (atn, 0), (ready, 1)) is atn:
                break  # the controller need not wait for a busy chip
            self.drivers["io_select"].drive(1)
            self.drivers["io_request"].drive(0)
            await level(ready, 0)
            await self._give(self.byte("db"))
            self.drivers["io_request"].drive(1)
            await level(ready, 1)
        self.drivers["io_select"].drive(0)

    async def _give(self, byte: int) -> None:
        self.drivers["dio"].drive((0xFF, byte ^ 0xFF))
        await until(self.kernel, self.kernel.now + SETTLING_PS)
        pull(self, "dav", True)
        await first_of(self.kernel, None, (self.pin("atn").net, 0), (self.pin("ndac").net, 1))
        pull(self, "dav", False)
        self.drivers["dio"].drive(None)
        await level(self.pin("dav").net, 1)


class ControllerSource(SourceHandshake):
    """The source handshake of a controller that can also receive; the data lines of the bus use negative logic."""

    negative = True

    async def talk_commands(self, data: bytes, hold: bool = False) -> None:
        """Send bytes with ATN low; if `hold`, keep NRFD and NDAC low afterwards (controller not ready for data)."""
        part = self.part
        pull(part, "atn", True)
        await until(self.kernel, self.kernel.now + SETTLING_PS)
        pull(part, "nrfd", False)
        pull(part, "ndac", False)
        await self.talk(data)
        pull(part, "nrfd", hold)
        pull(part, "ndac", hold)
        pull(part, "atn", False)
        await until(self.kernel, self.kernel.now + SETTLING_PS)

    async def accept(self, most: int, end: int | None = None, pause_ps: int | None = None) -> bytes:
        """Receive bytes from the talking device; after the last byte the controller stays not ready for data.

        Args:
            most: the maximum number of bytes.
            end: the byte that ends the read-out; None: no byte ends it.
            pause_ps: the time without a byte after which the read-out ends (ps); None: wait forever.
        """
        part, data, dav = self.part, bytearray(), self.part.net("dav")
        while len(data) < most and (not data or data[-1] != end):
            pull(part, "nrfd", False)
            limit_ps = None if pause_ps is None else self.kernel.now + pause_ps
            if await first_of(self.kernel, limit_ps, (dav, 0)) is None:
                pull(part, "nrfd", True)
                break
            await until(self.kernel, self.kernel.now + REACTION_PS)
            data.append(part.byte("dio") ^ 0xFF)
            pull(part, "nrfd", True)
            pull(part, "ndac", False)
            await level(dav, 1)
            pull(part, "ndac", True)
        await until(self.kernel, self.kernel.now + SETTLING_PS)
        return bytes(data)


class GpibController(Talks, Part):
    """A controller that addresses devices.

    `received` contains the bytes read from devices, `polled` the status bytes from serial polls.
    """

    _for_users = (
        "send",
        "command",
        "clear",
        "read",
        "poll",
        "received",
        "polled",
        "requests",
        "trigger",
        "device_clear",
        "write",
        "fetch",
        "message",
        "reset",
    )
    wiring = GpibTalker.wiring
    _source: ControllerSource

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name, rest=self._rest)
        self._source = ControllerSource(self, self.queue)
        self.received = bytearray()
        self.polled: list[int] = []
        self.keep_recent(self.received)
        self.keep_recent(self.polled)

    def write(self, address: int, data: Data) -> None:
        """Queue data to be sent to the device with this address."""
        self.command([UNLISTEN, LISTEN + address])
        self.send(data)
        self.command([UNLISTEN])

    @from_outside
    def read(self, address: int, number: int) -> None:
        """Queue a read-out of `number` bytes from the device with this address; they go to `received`."""
        self.input("read", address, number)
        self.queue.post(f"reads {number} bytes from {address}", lambda: self._fetched(address, number, None, None))

    @from_outside
    def fetch(self, address: int, most: int, end: int | None, pause: int | None) -> Request[bytes]:
        """Queue a read-out of at most `most` bytes from the device with this address; the result is the bytes read.

        Args:
            end: the byte that ends the read-out; None: no byte ends it.
            pause: the time without a byte after which the read-out ends (ps); None: wait forever.
        """
        self.input("fetch", address, most, end, pause)
        return self.queue.submit(f"reads from {address}", lambda: self._fetched(address, most, end, pause))

    async def _fetched(self, address: int, most: int, end: int | None, pause: int | None) -> bytes:
        await self._source.talk_commands(bytes([UNLISTEN, TALK + address]), hold=True)
        data = await self._source.accept(most, end, pause)
        await self._source.talk_commands(bytes([UNTALK]))
        self.received += data
        return data

    @from_outside
    def poll(self, address: int, pause: int | None = None) -> Request[int | None]:
        """Queue a serial poll of one device; the result is its status, or None if none arrives within `pause` (ps)."""
        self.input("poll", address, *([] if pause is None else [pause]))
        return self.queue.submit(f"polls {address}", lambda: self._polled(address, pause))

    async def _polled(self, address: int, pause: int | None) -> int | None:
        await self._source.talk_commands(bytes([POLL_ENABLE, TALK + address]), hold=True)
        status = await self._source.accept(1, None, pause)
        await self._source.talk_commands(bytes([POLL_DISABLE, UNTALK]))
        self.polled += status
        return status[0] if status else None

    def device_clear(self) -> None:
        """Queue a device clear for all devices."""
        self.command([DEVICE_CLEAR])

    def trigger(self, address: int) -> None:
        """Queue a device trigger for one device."""
        self.message(address, TRIGGER)

    def message(self, address: int, code: int) -> None:
        """Queue an interface message, given by its code, for one device."""
        self.command([UNLISTEN, LISTEN + address, code, UNLISTEN])

    @from_outside
    def reset(self) -> None:
        """Cancel all requests, and release the bus; a transfer under way is cut short."""
        self.input("reset")
        self.queue.cancel_after(0, "reset()")
        self.queue.halt()

    def _rest(self) -> None:
        for name in ("dio", *HANDSHAKE, *MANAGEMENT):
            self.drivers[name].drive(None)


class GpibInterrupts(Part):
    """Interrupt logic (fig. 12.9): a flip-flop on STEP INHIBIT, and service requests.

    `clear` (device clear), `reset` (master reset) and a falling edge of `limit` set STEP INHIBIT; `trigger` resets it,
    even while the limit switch is still closed, so that the motor can be driven off the switch.  SRQ is low while the
    limit switch is closed or MOTION COMPLETE is low.
    """

    wiring = MappingProxyType({"step_inhibit": "enable", "motion_complete": "motion_complete"})

    def __init__(self, kernel: Kernel, name: str) -> None:
        super().__init__(kernel, name)
        self.add_pin("clear", "in", "high: device clear", pull=0)
        self.add_pin("reset", "in", "high: master reset", pull=0)
        self.add_pin("trigger", "in", "high: device trigger", pull=0)
        self.add_pin("limit", "in", "low: a limit switch is closed", pull=1)
        self.add_pin("motion_complete", "in", "MOTION COMPLETE of the chip", pull=1, active=0)
        self.add_pin("step_inhibit", "out", "STEP INHIBIT of the chip", initial=0, active=0)
        self.add_pin("srq", "both", "SRQ of the bus, open collector", pull=1)

    def rewired(self) -> None:
        """Start to follow the pins, now that the part is wired."""
        for name, active, inhibit in (("clear", 1, 1), ("reset", 1, 1), ("limit", 0, 1), ("trigger", 1, 0)):
            self.pin(name).net.watch(
                lambda net, active=active, inhibit=inhibit: self._set(inhibit) if net.level == active else None  # type: ignore[misc]
            )
        for name in ("limit", "motion_complete"):
            self.pin(name).net.watch(lambda _: self._request())
        self._request()

    def _set(self, inhibit: int) -> None:
        self.drivers["step_inhibit"].drive(inhibit)

    def _request(self) -> None:
        pull(self, "srq", not (self.high("limit") and self.high("motion_complete")))
