"""An 8080 at the command port: the routines of the manual, on ports wired as in the manual.

    Ppi8255    port A: data bus; port B: status of the chip; port C: inputs of the chip, each
               set or reset by a code                                          (Table IX, fig. 10.9)
    Host8080   one output port; bit 7 of the byte is I/O REQUEST               (figs. 5.3, 10.7)

A polling loop (IN, ANI, JZ) takes 27 processor states; the program samples once in each pass.
"""

from __future__ import annotations

from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Clock, hertz
from ...core.wires.net import Net
from ...core.wires.waits import first_of, until
from ...errors import UsageError
from ..base.part import Part
from ..base.request_queue import RequestQueue
from ..base.written_data import Data, as_bytes

LOOP, IN, OUT, MVI, MOVE = 27, 10, 10, 7, 5  # states
STOPPER = 0xFF
READY = "b5"  # of the 8255

# the 8255 of Table IX: addresses of its ports, and the set/reset codes of port C
DATA, STATUS, CONTROL = 0xEC, 0xED, 0xEF
PORT_B = (  # pins of the chip and their roles, from bit 0 on
    ("motion_complete", "motion_complete"), ("pulse", "step"), ("run", "running"), ("prog", "program_entry"),
    ("programmable_output", "output1"), ("ready", "ready"), ("direction", "direction"), ("slew", "slewing"),
)  # fmt: skip
IOREQ, NOIOREQ, IOSELIN, IOSELOUT, DOWHILE, NOLOOP = range(6)
ABORT, NOABORT, TRIGGER, STPINH, LOWAIT, HIWAIT, RESETLO, NORESET = range(8, 16)
PORT_C = MappingProxyType({  # bit: pin of the chip, role, active level
    0: ("io_request", "request", 0), 1: ("io_select", "select", 1), 2: ("dowhile", "input2", None),
    4: ("abort", "abort", 0), 5: ("step_inhibit", "enable", 0), 6: ("wait", "input1", None),
    7: ("reset", "reset", 0),
})  # fmt: skip
AT_REST = (NOIOREQ, IOSELIN, NOLOOP, NOABORT, TRIGGER, HIWAIT, NORESET)  # the first bytes that the program writes


class Cpu8080:
    """A processor: coroutines that sample a bit, or let time pass, on the grid of the processor's clock."""

    def __init__(self, kernel: Kernel, cpu: str | int) -> None:
        self.kernel, self.clock, self.tick = kernel, Clock(hertz(cpu)), 0

    async def states(self, number: int) -> None:
        """Let a number of processor states pass."""
        self.tick = max(self.tick, self.clock.ticks_from(self.kernel.now)) + number
        await until(self.kernel, self.clock.ps(self.tick))

    async def poll(self, net: Net, wanted: int) -> None:
        """Sample a bit every 27 states, starting at the end of the first IN, until it has the wanted level."""
        await self.states(IN)
        origin = self.tick
        while net.level != wanted:
            await first_of(self.kernel, None, (net, wanted))
            passed = self.clock.ticks_until(self.kernel.now) - origin
            self.tick = origin + (passed // LOOP + 1) * LOOP
            await until(self.kernel, self.clock.ps(self.tick))
        await self.states(LOOP - IN)


def before_stopper(owner: str, data: Data) -> bytes:
    """Return the bytes before the first FF, the stopper.

    Raises:
        UsageError: the data contain no stopper.
    """
    found, stop, _ = as_bytes(owner, data).partition(bytes([STOPPER]))
    if not stop:
        raise UsageError(f"{owner}: no end mark FF after {found!r}; the routine would run on through memory; add FF")
    return found


class Host8080(Part):
    """The smallest host: OUT 0DCH puts seven bits on the bus and bit 7 on I/O REQUEST; READY is sampled."""

    _for_users = ("send", "out", "sent")
    wiring = MappingProxyType({"port": "data", "request": "request", "ready": "ready"})

    options = (Option("cpu", "frequency", "2 MHz", "clock of the processor", low=1, unit="Hz"),)

    def __init__(self, kernel: Kernel, name: str, *, cpu: str | int) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name)
        self._cpu, self.sent = Cpu8080(kernel, cpu), 0
        self.add_bus("port", "output port DC, bits 0 to 6; bit 7 of the bus to ground")
        self.add_pin("request", "out", "output port DC, bit 7", initial=1)
        self.add_pin("ready", "in", "READY of the chip", pull=1)

    def out(self, byte: int) -> None:
        """Write a byte to the output port immediately, like the instruction OUT 0DCH."""
        self.drivers["port"].drive((0xFF, byte & 0x7F))
        self.drivers["request"].drive(byte >> 7)

    @from_outside
    def send(self, string: Data) -> None:
        """Queue the bytes of a string that ends with the stopper FF; the stopper itself is not sent."""
        data = before_stopper(self.name, string)
        self.input("send", data + bytes([STOPPER]))
        for byte in data:
            self.queue.post(f"SENDCHR {byte:#04x}", lambda byte=byte: self._sendchr(byte))  # type: ignore[misc]

    async def _sendchr(self, byte: int) -> None:
        """Send a character like the manual's routine SENDCHR (fig. 10.7).

        Wait until READY is high, output the byte with bit 7 low, wait until READY is low, set bit 7 high.
        """
        await self._cpu.poll(self.net("ready"), 1)
        await self._cpu.states(MOVE + MVI + OUT)
        self.out(byte & 0x7F)
        await self._cpu.poll(self.net("ready"), 0)
        await self._cpu.states(MVI + OUT)
        self.out(0xFF)
        self.sent += 1


class Ppi8255(Part):
    """An 8255 with an 8080, wired as in Table IX, and the routines listed in the manual.

    Port A is high-impedance while I/O SELECT (port C, bit 1) is high, so that the chip may drive the bus.
    """

    _for_users = ("out", "read", "sendparallel", "sendchar", "rcvbyte", "received", "sent")
    wiring = MappingProxyType(
        {"a": "data"}
        | {f"b{bit}": role for bit, (_, role) in enumerate(PORT_B)}
        | {f"c{bit}": role for bit, (_, role, _) in PORT_C.items()}
    )

    options = (Option("cpu", "frequency", "2.048 MHz", "clock of the processor", low=1, unit="Hz"),)

    def __init__(self, kernel: Kernel, name: str, *, cpu: str | int) -> None:
        super().__init__(kernel, name)
        self.queue: RequestQueue = RequestQueue(kernel, name)
        self._cpu, self.sent = Cpu8080(kernel, cpu), 0
        self.add_bus("a", "port A (EC): data bus")
        for bit, (pin, _) in enumerate(PORT_B):
            self.add_pin(f"b{bit}", "in", f"port B (ED): {pin}", pull=1)
        for bit, (pin, _, level) in PORT_C.items():
            self.add_pin(f"c{bit}", "out", f"port C (set and reset through EF): {pin}", active=level)
        self._latched, self._selected = 0xFF, False
        self.received = bytearray()
        self.keep_recent(self.received)
        for code in AT_REST:
            self._write(CONTROL, code)

    # -------------------------------------------------------------------------------------------------------- the ports
    def read(self, port: int) -> int:
        """Return the byte that IN reads from a port at this instant."""
        if port == DATA:
            return self.byte("a")
        if port == STATUS:
            return sum(self.high(f"b{bit}") << bit for bit in range(8))
        raise UsageError(f"{self.name}: no input port {port:#04x}; allowed 0xEC (data), 0xED (status)")

    def _checked(self, port: int, value: int) -> None:
        code = port == CONTROL and 0 <= value < 16 and value >> 1 in PORT_C
        if not code and not (port == DATA and 0 <= value < 256):
            allowed = "0xEC (data), 0xEF (codes 0 to 5 and 8 to 15)"
            raise UsageError(f"{self.name}: OUT {port:#04x}, {value:#04x}; allowed {allowed}")

    def _write(self, port: int, value: int) -> None:
        """Perform an OUT: a byte to port A, or a set/reset code for port C (2 * bit number + level) to address EF."""
        self._checked(port, value)
        if port == DATA:
            self._latched = value
        else:
            bit, level = divmod(value, 2)
            self.drivers[f"c{bit}"].drive(level)
            if PORT_C[bit][1] == "select":
                self._selected = bool(level)
        self.drivers["a"].drive(None if self._selected else (0xFF, self._latched))

    # -------------------------------------------------------------------------------------------------- calls by a user
    @from_outside
    def out(self, port: int, value: int) -> None:
        """Queue an OUT of `value` to `port`; for example, 0x0B to 0xEF sets STEP INHIBIT high."""
        self._checked(port, value)
        self.input("out", port, value)

        async def action() -> None:
            await self._output(port, value)

        self.queue.post(f"OUT {port:#04x}, {value:#04x}", action)

    @from_outside
    def sendparallel(self, buffer: Data) -> None:
        """Queue the bytes of `buffer` up to, but excluding, the stopper FF; SENDPARALLEL sends them (fig. 11.6)."""
        data = before_stopper(self.name, buffer)
        self.input("sendparallel", data + bytes([STOPPER]))
        self._queue(data)

    @from_outside
    def sendchar(self, data: Data) -> None:
        """Queue bytes, which may include FF; the inner routine of SENDPARALLEL sends them."""
        data = as_bytes(self.name, data)
        self.input("sendchar", data)
        self._queue(data)

    def _queue(self, data: bytes) -> None:
        for byte in data:
            self.queue.post(f"SENDCHAR {byte:#04x}", lambda byte=byte: self._sendchar(byte))  # type: ignore[misc]

    @from_outside
    def rcvbyte(self, number: int) -> None:
        """Queue a read-out of `number` verify bytes into `received`; the V command must be sent before (fig. 6.1)."""
        self.input("rcvbyte", number)
        self.queue.post(f"RCVBYTE, {number} bytes", lambda: self._rcvbyte(number))

    # --------------------------------------------------------------------------------------------------- the routines
    async def _output(self, port: int, value: int) -> None:
        await self._cpu.states(MVI + OUT)
        self._write(port, value)

    async def _sendchar(self, byte: int) -> None:
        await self._cpu.poll(self.net(READY), 1)
        await self._output(DATA, byte)
        await self._output(CONTROL, IOREQ)
        await self._cpu.poll(self.net(READY), 0)
        await self._output(CONTROL, NOIOREQ)
        self.sent += 1

    async def _rcvbyte(self, number: int) -> None:
        await self._cpu.poll(self.net(READY), 1)
        await self._output(CONTROL, IOSELOUT)
        for _ in range(number):
            await self._output(CONTROL, IOREQ)
            await self._cpu.poll(self.net(READY), 0)
            await self._cpu.states(IN)
            self.received.append(self.read(DATA))
            await self._output(CONTROL, NOIOREQ)
            await self._cpu.poll(self.net(READY), 1)
        await self._output(CONTROL, IOSELIN)
