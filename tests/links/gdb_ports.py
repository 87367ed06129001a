"""IN and OUT of a program in QEMU, done at the registers of a served chipset: breakpoints over QEMU's own gdb stub.

QEMU stops the processor before each IN AL, DX and OUT DX, AL of the program.  The access is done here, and the program
goes on after it.  Nothing of the program or of QEMU is changed: its breakpoints are not in the memory of the guest.
"""

from __future__ import annotations

import socket
import time

IN, OUT = 0xEC, 0xEE  # IN AL, DX and OUT DX, AL
EAX, EDX, EIP, CS = 0, 2, 8, 10  # places of 32 bits in the answer to g


class GdbStub:
    """The stub of QEMU on a Unix socket."""

    def __init__(self, path: str, timeout: float) -> None:
        self.came, end = b"", time.monotonic() + timeout
        while True:  # its name is there before QEMU listens
            self.socket = socket.socket(socket.AF_UNIX)
            self.socket.settimeout(timeout)
            try:
                self.socket.connect(path)
                return
            except ConnectionRefusedError:
                self.socket.close()
                if time.monotonic() > end:
                    raise
                time.sleep(0.01)

    def __enter__(self) -> GdbStub:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def ask(self, packet: str) -> str:
        """Send a packet; return the answer, "" where QEMU has ended."""
        data = packet.encode()
        self.socket.sendall(b"$" + data + b"#" + f"{sum(data) & 0xFF:02x}".encode())
        while True:
            begin, end = self.came.find(b"$"), self.came.find(b"#")
            if 0 <= begin < end and len(self.came) >= end + 3:
                found, self.came = self.came[begin + 1 : end], self.came[end + 3 :]
                self.socket.sendall(b"+")
                return found.decode()
            more = self.socket.recv(4096)
            if not more:
                return ""
            self.came += more

    def registers(self) -> bytearray:
        """Return all registers, as the stub has them."""
        return bytearray.fromhex(self.ask("g"))

    def put(self, registers: bytearray) -> None:
        """Write all registers."""
        assert self.ask(f"G{registers.hex()}") == "OK"


def value(registers: bytearray, number: int) -> int:
    """Return a register of 32 bits."""
    return int.from_bytes(registers[4 * number : 4 * number + 4], "little")


def run(stub: GdbStub, image: bytes, base: int, ports: range, card) -> int:
    """Run a program at the address `base`; return the number of its accesses to these ports, which the card gets."""
    for at, byte in enumerate(image):
        if byte in (IN, OUT):  # in data as well, where nothing is executed
            assert stub.ask(f"Z0,{base + at:x},1") == "OK"
    done, answer = 0, stub.ask("c")
    while answer[:1] in ("T", "S"):
        found = stub.registers()
        at = value(found, EIP)
        opcode, port = image[16 * value(found, CS) + at - base], value(found, EDX) & 0xFFFF
        if port in ports:
            if opcode == IN:
                found[4 * EAX] = card.inp(port)
            else:
                card.out(port, found[4 * EAX])
            found[4 * EIP : 4 * EIP + 4] = (at + 1).to_bytes(4, "little")
            stub.put(found)
            done += 1
        elif not stub.ask("s"):
            break
        answer = stub.ask("c")
    return done
