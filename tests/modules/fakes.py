r"""Fake modules on a pty, written from the data sheets and not from the models, which may deviate from the sheet.

    with FakeGsc("no end", program=["S10", "+5"]) as fake:
        invoke(["pull", fake.port, "-o", "saved.gs-c200s"])
        assert fake.steps == [] and fake.eeprom == []

GS-C200S: data sheet of June 1994, "Data exchange protocol" and the table of commands; CHS at ground, no address.
CY545: chapter 16, "The Serial Interface", and the summary of its commands; answers go out on TXD.
"""

from __future__ import annotations

import os
import re
import select
import threading
import time
import tty
from contextlib import suppress

DEVIATIONS = {  # of what goes out, an answer of whole lines
    "cr lf": lambda data: data.replace(b"\r", b"\r\n"),
    "lf": lambda data: data.replace(b"\r", b"\n"),
    "lf cr": lambda data: data.replace(b"\r", b"\n\r"),
    "no cr": lambda data: data.removesuffix(b"\r"),
    "empty lines": lambda data: data.replace(b"\r", b"\r\r"),
    "blank behind": lambda data: data.replace(b"\r", b" \r"),
    "blank inside": lambda data: re.sub(rb"(?m)([A-Z=])([0-9+-])", rb"\1 \2", data),
    "small letters": lambda data: data.lower(),
    "bit 7": lambda data: bytes(each | 0x80 for each in data),
    "prompt": lambda data: data + b"> ",
    "banner": lambda data: b"MODULE 2.1\r" + data,
    "echo": lambda data: data,  # see `Fake.take`
    "checksums": lambda data: b"".join(checked(line) for line in data.split(b"\r")[:-1]),
    "address": lambda data: re.sub(rb"(?m)^(?=.)", b"3", data.replace(b"\r", b"\n")).replace(b"\n", b"\r"),
    "no V": lambda data: data.removeprefix(b"V"),
    "digits": lambda data: re.sub(rb"([VPNRFSOYB][=+-])0*([0-9]+)\r", rb"\g<1>000000000\2\r", data),
    "no end": lambda data: data.removesuffix(b"END\r"),
    "wrapped": lambda data: re.sub(rb"([A-Z+-][0-9])([0-9]+\r)", rb"\1\r\2", data) if b"END" in data else data,
}


def checked(line: bytes) -> bytes:
    """Return a line with its checksum: the sum of its characters, seven bits of it, bit 4 always 1."""
    return line + bytes([sum(line) & 0x7F | 0x10]) + b"\r"


class Fake:
    """A module on a pty; `port` is its name, `steps` lists the commands that made it step."""

    def __init__(self, deviation: str = "", delay_s: float = 0.0, deaf_s: float = 0.0) -> None:
        self.deviation, self.delay_s = deviation, delay_s
        self.hears_s = time.monotonic() + deaf_s  # a module that DTR resets, as Arduinos do
        self.steps: list[str] = []
        self.answered = b""
        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.port = os.ttyname(slave)
        self.slave = slave  # kept open: a tool that is killed must not hang the line up
        self.over, wake = os.pipe()
        self.wake = wake
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self) -> None:
        with suppress(OSError):
            while True:
                ready, _, _ = select.select([self.master, self.over], [], [])
                if self.over in ready:
                    break
                for byte in os.read(self.master, 4096):
                    if time.monotonic() > self.hears_s:
                        self.character(byte)

    def unplug(self) -> None:
        """Take the cable off; what the module holds stays."""
        wake, self.wake = self.wake, -1
        if wake >= 0:
            os.write(wake, b".")
            self.thread.join()
            for each in (self.master, self.slave, self.over, wake):
                os.close(each)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.unplug()

    def say(self, data: bytes) -> None:
        if self.delay_s:
            threading.Event().wait(self.delay_s)
        if self.deviation:
            data = DEVIATIONS[self.deviation](data)
        self.answered += data
        os.write(self.master, data)

    def character(self, byte: int) -> None:
        raise NotImplementedError


class FakeGsc(Fake):
    """A GS-C200S."""

    STORED = (  # instructions that are stored, with the locations that they take
        (r"S(?:[1-9][0-9]{0,2}|1000)|T(?:[1-9][0-9]{0,2}|1000)|R[1-9][0-9]{0,2}|[+-][0-9]{1,6}", 4),
        (r"[Ggf][+-][0-9]{1,7}|G[+-]|[Gg][+-][1-3]?", 4),
        (r"[ACWUI][1-3]|D[0-9]{1,3}|Lo|L[0-9]{1,3}|j[0-9]{1,3}|jc[0-7],[0-9]{1,3}", 2),
    )
    LOCATIONS = 119

    def __init__(self, deviation="", program=(), eeprom=(), *, unended=0, delay_s=0.0, deaf_s=0.0) -> None:
        self.ram, self.eeprom, self.entering = list(program), list(eeprom), False
        self.unended = unended  # listings without END, after X
        self.recalled = False
        self.line = b""
        super().__init__(deviation, delay_s, deaf_s)

    def character(self, byte):
        if byte != 0x0D:
            self.line += bytes([byte])
            return
        line, self.line = self.line, b""
        if self.deviation == "echo":
            self.say(line + b"\r")
        self.say(self.answer(line.decode("latin-1")))

    def size(self, text):
        return next((size for shape, size in self.STORED if re.fullmatch(shape, text)), 0)

    def answer(self, text: str) -> bytes:
        if text == "F":
            return b"R\r"
        if text == "V1":
            return b"V+0\r"
        if text == "V2":
            return b"V70\r"
        if text == "Q":
            listing = "".join(f"{line}\r" for line in self.ram).encode()
            if self.recalled and self.unended:
                self.unended -= 1
                return listing
            return listing + b"END\r"
        if text == "Po":
            self.ram, self.entering = [], True
        elif text == "Px":
            self.entering = False
        elif text == "M":
            self.eeprom = list(self.ram)
        elif text == "X":
            self.ram, self.recalled = list(self.eeprom), True
        elif self.entering and self.size(text):
            if sum(map(self.size, [*self.ram, text])) > self.LOCATIONS:
                return b"E3\r"
            self.ram.append(text)
        elif text in ("E", "H", "H+", "H-"):
            self.steps.append(text)
        else:
            return b"E4\r"
        return b"Y\r"


class FakeCy545(Fake):
    """A CY545 with 64K of memory, which has taken the rate already."""

    def __init__(self, deviation="", program=(), *, delay_s=0.0, deaf_s=0.0) -> None:
        self.memory = bytearray(b"\xff" * 65536)
        image = b"".join(line.encode() + b"\r" for line in program)
        self.memory[: len(image)] = image
        self.values = {"R": 120, "F": 25, "S": 50, "O": 0, "B": 0, "P": 0, "N": 0, "Y": 0}
        self.entering, self.line = False, b""
        super().__init__(deviation, delay_s, deaf_s)

    def character(self, byte):
        if self.entering:
            if byte == ord("Q") and not self.line:
                self.entering = False
                return
            self.memory[self.values["Y"]] = byte
            self.values["Y"] = (self.values["Y"] + 1) % 65536
            self.line = b"" if byte == 0x0D else self.line + bytes([byte])
        elif byte == 0x0D:
            line, self.line = self.line, b""
            if line:
                if self.deviation == "echo":
                    self.say(line + b"\r")
                self.obey(line.decode("latin-1").strip())
        else:
            self.line += bytes([byte])

    def obey(self, text: str) -> None:
        if found := re.fullmatch(r"\? ?M[ ,]+([0-9]+)", text):
            self.say(self.lines(int(found[1])))
        elif found := re.fullmatch(r"\? ?([PNRFSOYB])", text):
            digits = 8 if found[1] in "PN" else 5
            self.say(f"{found[1]}={self.values[found[1]]:0{digits}}\r".encode())
        elif text == "E":
            self.entering = True
        elif found := re.fullmatch(r"([ANRFSOYB]) ?([0-9]+)", text):
            self.values["P" if found[1] == "A" else found[1]] = int(found[2])
        elif re.fullmatch(r"[GXJH+-].*|P ?[0-9]+", text) and text not in "+-":
            self.steps.append(text)

    def lines(self, number: int) -> bytes:
        """What is stored from the pointer on, up to so many carriage returns, or to the end of the memory."""
        found = f"Y={self.values['Y']:05}\r".encode()
        at = self.values["Y"]
        for _ in range(number):
            end = self.memory.find(b"\r", at)
            end = len(self.memory) if end < 0 else end + 1
            found += self.memory[at:end]
            at = end
        return found

    @property
    def program(self) -> list[str]:
        return self.memory.partition(b"\xff")[0].decode("latin-1").split("\r")[:-1]
