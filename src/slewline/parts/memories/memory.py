r"""External memory with its two address latches: RAM, EEPROM or EPROM of up to 64K bytes.

select  ----\____________________________/----    falling: latches the high byte of the address; low: enables
ale     _________/--\_______________________      falling: latches the low byte
wr      -----------------\____/-------------      rising: the byte on the bus is written
rd      -----------------\________/---------      low: the byte at the address is on the bus
db      == high ==|= low =|== data ==|

A part smaller than 64K has fewer address lines: higher addresses mirror its contents.
"""

from __future__ import annotations

from collections.abc import Callable
from types import MappingProxyType

from ...core.datasheet.option import Option
from ...core.memory.image import ERASED, SIZES, check_text, size_of
from ...core.memory.store import STORE, BufferedStore, Memory, Store
from ...core.time.inputs import from_outside
from ...core.time.kernel import Kernel
from ...core.time.timebase import Time, picoseconds, readable
from ...errors import NoSuchAttribute, UsageError
from ..base.part import Part
from ..base.written_data import Data, as_bytes
from .external import WRITE_WIRING, BusInterface, start_bus

POLLED = 0x80  # bit that reads inverted while a byte is being written
MEMORY_WIRING = MappingProxyType({**WRITE_WIRING, "select": "memory_select"})
OF_ALL = (
    Option(
        "size",
        "choice",
        None,
        "size in bytes; None: that of the image, or 65536 without an image",
        choices=SIZES,
        none=True,
    ),
    Option("image", "bytes", b"", "content from address 0 on; the rest is FF"),
)


class MemoryCore:
    """The bytes of a memory, and its bus interface.

    Args:
        part: the part, to which the pins are added.
        size: the size in bytes; None: the size of the image if memories of that size exist, else 65536.
        image: initial contents, starting at address 0; the rest is FF.
        read: a function that returns the byte at the address.
        write: a function that is called with each byte written to the address.

    Raises:
        UsageError: the image does not fit.
    """

    def __init__(
        self, part: Part, size: int | None, image: Data, read: Callable[[], int], write: Callable[[int], None]
    ) -> None:
        self.bus = BusInterface(part, "low: selected; falling: latches the high byte of the address", read, write)
        data = as_bytes(part.name, image)
        self.name, self.size = part.name, size or size_of(data)
        self._check(0, data)
        self.bytes = bytearray(data.ljust(self.size, bytes([ERASED])))

    def _check(self, at: int, data: bytes) -> None:
        if not 0 <= at <= self.size - len(data):
            raise UsageError(
                f"{self.name}: {len(data)} bytes at address {at} do not fit; the part has {self.size} bytes"
            )

    def checked(self, image: Data, at: int) -> bytes:
        """Check that an image can be stored at an address, and return the bytes of the image.

        Raises:
            UsageError: the image does not fit.
        """
        check_text(self.name, image)
        data = as_bytes(self.name, image)
        self._check(at, data)
        return data

    @property
    def address(self) -> int:
        """The present address; a small part ignores the address lines that it does not have."""
        return self.bus.address % self.size

    @property
    def byte(self) -> int:
        """Byte at the present address."""
        bus = self.bus
        return self.bytes[(bus.high << 8 | bus.low) % self.size]


class Ram(Part):
    """A memory of up to 64K bytes on the bus of a chip: a RAM, or, if not writable, an EPROM or a ROM.

    Args:
        writable: whether the chip can write to it.
        size: the size in bytes, a power of two from 2048 to 65536; None: the size of the image if memories
            of that size exist, else 65536.
        image: initial contents, starting at address 0; the rest is FF, where a real RAM has random bytes.
    """

    _for_users = ("content", "load", "size")
    wiring = MEMORY_WIRING
    options = (Option("writable", "bool", ..., "the chip can write it"), *OF_ALL)
    rewired = start_bus

    def __init__(
        self, kernel: Kernel, name: str, *, writable: bool, size: int | None = None, image: Data = b""
    ) -> None:
        super().__init__(kernel, name)
        write = self._write if writable else self._refuse
        self._core = MemoryCore(self, size, image, lambda: self._core.byte, write)
        self._bus, self.size = self._core.bus, self._core.size
        self._is_reported = False

    @property
    def content(self) -> bytes:
        """The bytes of the memory, starting at address 0."""
        return bytes(self._core.bytes)

    @content.setter
    def content(self, image: object) -> None:
        raise NoSuchAttribute(f"{self.name}: content cannot be set; use {self.name}.load(image)")

    @from_outside
    def load(self, image: Data, at: int = 0) -> None:
        """Write an image into the memory, as a device programmer does with a part taken from its socket.

        Args:
            image: bytes, or text.
            at: address of the first byte.

        Raises:
            UsageError: the image does not fit.
        """
        data = self._core.checked(image, at)
        self.input("load", data, at)
        self._bus.changes()
        self._core.bytes[at : at + len(data)] = data

    def _write(self, byte: int) -> None:
        self._core.bytes[self._core.address] = byte

    def _refuse(self, byte: int) -> None:
        """Ignore a byte that the chip writes to a read-only memory; report the first such write."""
        if not self._is_reported:
            self._is_reported = True
            text = (
                f"{byte:02X} was written to address {self._core.address:04X} of an EPROM, which is read-only: no effect"
            )
            self.finding("read-only", text)


class Eeprom(Part):
    """An EEPROM of up to 64K bytes on the bus of a chip.

    Writing a byte takes `write_time`; meanwhile a read returns that byte with bit 7 inverted (data polling).
    Written bytes are flushed to the store together, when the oldest of them is `flush` old: each flush waits
    a few milliseconds for the disk, which is about as long as the part takes to write a byte.

    Args:
        size: the size in bytes, a power of two from 2048 to 65536; None: the size of the image if memories
            of that size exist, else 65536.
        image: initial contents, starting at address 0, if the store is empty; the rest is FF.
        write_time: the time to write a byte.
        flush: the maximum time until a written byte is saved to the store.
        store: preserves the contents without power.
    """

    _for_users = ("content", "load", "size", "store", "flush", "unsaved", "writing")
    wiring = MEMORY_WIRING
    keeps = True
    options = (
        *OF_ALL,
        Option("write_time", "time", "5 ms", "time to write a byte", low=1),
        Option("flush", "time", "200 ms", "maximum time before a written byte is saved to the store", low=1),
        STORE,
    )
    rewired = start_bus

    def __init__(
        self,
        kernel: Kernel,
        name: str,
        *,
        size: int | None = None,
        image: Data = b"",
        write_time: Time = "5 ms",
        flush: Time = "200 ms",
        store: Store | None = None,
    ) -> None:
        content = b"" if store is None else store.read()
        super().__init__(kernel, name)
        size = size or (len(content) if len(content) in SIZES else None)
        self._core = MemoryCore(self, size, image, self._shown, self._write)
        self._bus, self.size = self._core.bus, self._core.size
        if content and len(content) != self.size:
            raise UsageError(
                f"{name}: the store holds {len(content)} bytes, the part {self.size}; use a store of the same size"
            )
        self._write_ps, self._flush_ps = picoseconds(write_time), picoseconds(flush)
        self.store = Memory() if store is None else store
        self._kept = BufferedStore(self.store, self.content)
        self._core.bytes = self._kept.content
        self.writing: tuple[int, int] | None = None  # address and byte being written
        self._writes = 0  # number of writes begun or abandoned
        self._flushing = False

    @property
    def content(self) -> bytes:
        """The bytes of the memory, starting at address 0."""
        return bytes(self._core.bytes)

    @from_outside
    def load(self, image: Data, at: int = 0) -> None:
        """Write an image into the memory from an address on, like `Ram.load`; flush it to the store immediately."""
        data = self._core.checked(image, at)
        self.input("load", data, at)
        self._bus.changes()
        self.writing = None
        self._writes += 1
        for address, byte in enumerate(data, at):
            self._kept.put(address, byte)
        self.flush()

    def _shown(self) -> int:
        """Return the byte at the address, or, during a write, the byte being written with its bit 7 inverted."""
        return self._core.byte if self.writing is None else self.writing[1] ^ POLLED

    def _write(self, byte: int) -> None:
        """Begin to write a byte; if another write is in progress, report that the new byte is lost."""
        address = self._core.address
        if self.writing is not None:
            busy = f"address {self.writing[0]:04X} was being written"
            self.finding("memory-busy", f"{byte:02X} for address {address:04X} arrived while {busy}, and is lost")
            return
        self.writing = address, byte
        self._writes = number = self._writes + 1
        self.kernel.call_at(self.kernel.now + self._write_ps, lambda: self._written(number))

    def _written(self, number: int) -> None:
        """Complete the write with the given number, unless `load` has abandoned it."""
        if self.writing is None or number != self._writes:
            return  # the part has been loaded by `load` meanwhile
        self._bus.changes()
        self._kept.put(*self.writing)
        self.writing = None
        self._bus.show()
        if not self._flushing:
            self._flushing = True
            self.kernel.call_at(self.kernel.now + self._flush_ps, self.flush)

    # ---------------------------------------------------------------------------------------------------------- store
    @property
    def unsaved(self) -> int:
        """Number of bytes written but not yet flushed to the store."""
        return len(self._kept.unsaved)

    def flush(self) -> None:
        """Save the written bytes to the store; a failure is a finding, and the next flush tries to save them again."""
        self._flushing = False
        try:
            if not self._kept.flush() and not self._flushing:
                self._flushing = True
                self.kernel.call_at(self.kernel.now + self._flush_ps, self.flush)
        except OSError as error:
            self.finding("not-kept", f"{self.unsaved} bytes of the memory could not be saved: {error}")

    def leave(self) -> None:
        """Flush the written bytes to the store, because the bench is being closed."""
        for _ in range(2):  # bytes that the first flush cannot save are tried once more
            self._kept.wait()
            if self.unsaved:
                self.flush()

    @property
    def idle(self) -> bool:
        """True while no byte is being written."""
        return self.writing is None

    @property
    def waiting(self) -> str:
        """Description of the current activity, such as the write in progress."""
        if self.writing is None:
            return super().waiting
        return f"{self.name}: writes address {self.writing[0]:04X}, which takes {readable(self._write_ps)}"
