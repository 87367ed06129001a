r"""A GPIB controller on a port that accepts the commands of a Prologix GPIB-ETHERNET (on a pty, GPIB-USB).

    ++addr 5\n                  commands begin with ++; the next lines are for the device at this address
    V 0\n                       other lines are data for the device, plus the terminator set by ++eos
    ++read eoi\n                reads the answer of the device
    ESC + ESC CR ESC LF ESC ESC sends +, CR, LF, ESC; without ESC, + is dropped, and CR or LF ends a line

Requests are executed one after another, at the bus pins, and answered in the same order.  ++ifc and
++rst are executed immediately: they recover the bus when a device no longer responds.

The circuit in the manual has no EOI.  The controller only knows the end of the group of data that a
command has selected for reading, and treats the last byte of the group as if it carried EOI.  A read
ends at this byte, at the byte that ++read names, or when no byte has arrived for read_tmo_ms.  If no
group has been selected, the controller reads one byte, because the chip still sends one; the chip
reports such a read as a finding.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from ...core.datasheet.channel import BusHandshake
from ...language.dialect import Command, dialect_of
from ...parts.boards.gpib_device import GO_TO_LOCAL, LOCAL_LOCKOUT, SELECTED_CLEAR
from ...parts.lines.far_end import CERTAIN, RAW, TELNET
from ...version import __version__
from ..lines.line_transcript import TranscriptFile
from ..lines.pace import Pace
from ..lines.request_line import RequestLine
from .tcp import TcpPort, TurnSession

if TYPE_CHECKING:
    from ...bench import Bench
    from ...core.chip import Chip
    from ...parts.boards.gpib_device import GpibController
    from ..lines.outlet import SentBytes

LINE = re.compile(rb"((?:[^\r\n\x1b]|\x1b.)*)[\r\n]", re.DOTALL)
ESCAPED = re.compile(rb"\x1b(.)|\+", re.DOTALL)
PLAIN_PLUS = re.compile(rb"(?:[^\x1b+]|\x1b.)*\+", re.DOTALL)
LONGEST = 4096  # bytes of a line
SHARE = 64  # bytes in a turn of the loop
MS = 10**9
ENDS = (b"\r\n", b"\r", b"\n", b"")  # by the argument of ++eos
UNKNOWN = "Unrecognized command"
VERSION = f"Prologix GPIB-ETHERNET Controller version 01.06.06.00 (slewline {__version__})"
HIGHEST = 30  # address
SECONDARY = (96, 126)
MOST_TRIGGERED = 15  # devices of one command


class Setting(NamedTuple):
    """A setting of the controller: its range, its default, and its effect."""

    low: int
    high: int
    usual: int
    description: str


SETTINGS: Mapping[str, Setting] = {
    "mode": Setting(1, 1, 1, "1: controller; there is no other mode here"),
    "auto": Setting(0, 1, 0, "1: read after each line of data"),
    "eoi": Setting(0, 1, 1, "1: EOI with the last byte of data; the circuit has no EOI"),
    "eos": Setting(0, 3, 1, "terminator of data: 0 CR LF, 1 CR, 2 LF, 3 none"),
    "eot_enable": Setting(0, 1, 0, "1: eot_char follows data that was read completely"),
    "eot_char": Setting(0, 255, 0, "code of eot_char"),
    "read_tmo_ms": Setting(1, 3000, 500, "ms without a byte that end a read or a poll"),
    "savecfg": Setting(0, 1, 1, "1: settings are stored, and restored after ++rst"),
}
COMMANDS: Mapping[str, str] = {
    "addr": "[PAD [SAD]]: address of the device, 0 to 30; a secondary address is accepted and ignored",
    "clr": "clear the device (SDC)",
    "help": "list the commands",
    "ifc": "clear the interface, immediately",
    "llo": "local lockout of the device",
    "loc": "set the device to local",
    "read": "[eoi|CODE]: read from the device, to the end of a group, a character, or a pause",
    "rst": "restart with the stored settings",
    "spoll": "[PAD [SAD]]: poll the status of the device, or of another one",
    "srq": "1 if SRQ is low, else 0",
    "trg": "[PAD ...]: trigger the device, or others",
    "ver": "the version of the controller",
}


class Selection:
    """The data selected for reading from a chip, as far as the commands sent to the chip reveal it."""

    def __init__(self, chip: Chip) -> None:
        self.decoder = dialect_of(chip.sheet).decoder(chip.sheet)
        self.sizes = chip.sheet.through(BusHandshake).verify_bytes
        self.mode = chip.sheet.role("text")
        self.entering = False
        self.left = 0  # bytes per group

    def data_received(self, chip: Chip, data: bytes) -> None:
        """Find, in bytes sent to the chip, commands that select data for reading; record the size of the data."""
        as_text = self.mode is None or chip.pins[self.mode.name].level != 0
        for byte in data:
            found = self.decoder.feed(byte, as_text, self.entering)
            if not isinstance(found, Command):
                continue
            role = found.row.role
            if role in ("enter", "leave"):
                self.entering = role == "enter"
            elif role == "read" and not self.entering and found.values[0] in self.sizes:
                group = found.values[0]
                self.left = self.sizes[group] if as_text or group else 2


class PrologixLine(RequestLine):
    """A line on which a host sends lines of text to a GPIB controller on the bench, and receives the answers.

    Args:
        controller: the controller on the bus.
        devices: the chips on the bus, keyed by the bus addresses of their devices; the first device is
            addressed initially.
    """

    share = SHARE

    def __init__(
        self, name: str, pace: Pace, log: TranscriptFile, controller: GpibController, devices: Mapping[int, Chip]
    ) -> None:
        super().__init__(name, [*devices.values()], pace, log, controller)
        self.devices = dict(devices)
        self.selected = {address: Selection(chip) for address, chip in devices.items()}
        self.usual = {name: row.usual for name, row in SETTINGS.items()} | {"addr": next(iter(devices))}
        self.secondary = ""
        self.settings, self.kept = dict(self.usual), dict(self.usual)
        self.half = b""  # an incomplete line
        self.too_long = False

    @property
    def controller(self) -> GpibController:
        """GPIB controller on the bench."""
        return cast("GpibController", self.part)

    def move(self, bench: Bench, coming: Sequence[SentBytes]) -> None:
        """Connect the line to the same controller on another bench."""
        super().move(bench, coming)
        self.devices = {address: bench.chips[chip.name] for address, chip in self.devices.items()}

    # ---------------------------------------------------------------------------------------------------------- lines
    def feed(self, data: bytes) -> None:
        """Receive bytes from the host: lines, each executed when complete."""
        data, at = self.half + data, 0
        while found := LINE.match(data, at):
            at = found.end()
            self._bound(found[1])
            if not self.too_long and found[1]:
                self._line(found[1])
            self.too_long = False
        self.half = data[at:]
        self._bound(self.half)
        if self.too_long:
            self.half = b""

    def _bound(self, line: bytes) -> None:
        """Report, once, a line that is already too long, even if its end has not arrived yet."""
        if len(line) > LONGEST and not self.too_long:
            text = f"a line has more than {LONGEST} bytes, so it is not sent; end lines with CR or LF"
            self.controller.finding("gpib-line", text)
            self.too_long = True

    def whole(self, data: bytes) -> bytes:
        """Return the complete lines received; the start of the next line is kept until its end arrives."""
        data, at = self.half + data, 0
        while found := LINE.match(data, at):
            at = found.end()
        self.half = data[at:][: LONGEST + 1]
        return data[:at]

    def forget_half(self) -> None:
        """Discard the incomplete line received so far, because the rest of it will not arrive here."""
        self.half = b""

    def sent(self) -> bool:
        return True  # the next host may want to clear the requests of the last one

    def _line(self, line: bytes) -> None:
        if line.startswith(b"++"):
            self._command(line[2:].decode("latin-1"))
        else:
            self._data(line)

    def _data(self, line: bytes) -> None:
        """Send data to the addressed device, and read its answer if ++auto is on."""
        if PLAIN_PLUS.match(line):
            self.controller.finding(
                "gpib-plus", f"{line!r}: a '+' that is not preceded by ESC is not sent; send ESC, then '+'"
            )
        if (found := TELNET.match(line)) and len(found[0]) >= CERTAIN:
            self.controller.finding("telnet", f"{RAW}; this looks like telnet: use a raw connection")
        data = ESCAPED.sub(lambda found: found[1] or b"", line) + ENDS[self.settings["eos"]]
        address = self.settings["addr"]
        if not data:
            return
        self.controller.write(address, data)
        if address in self.selected:
            self.selected[address].data_received(self.devices[address], data)
        self.answer(lambda _controller, _work: b"")
        if self.settings["auto"]:
            self._read(None)

    def _read(self, end: int | None) -> None:
        """Read from the addressed device, up to the byte `end` if one is given."""
        address, settings = self.settings["addr"], self.settings
        selection = self.selected.get(address)
        left = selection.left if selection is not None else 0
        most = max(left, 1)
        if selection is not None:
            selection.left = 0
        closed = bytes([settings["eot_char"]]) if settings["eot_enable"] else b""

        def answer(_controller: GpibController, work: Any) -> bytes:
            data: bytes = work.result
            if selection is not None and not self.silent:
                selection.left += max(left - len(data), 0)  # the device has ended earlier
            return data + closed if len(data) == most else data

        self.answer(answer, self.controller.fetch(address, most, end, settings["read_tmo_ms"] * MS))

    # ------------------------------------------------------------------------------------------------------- commands
    def _command(self, text: str) -> None:
        name, *arguments = text.lower().split() or [""]
        if name in COMMANDS:
            known = getattr(self, f"do_{name}")(arguments)
        else:
            known = name in SETTINGS and self._setting(name, arguments)
        if not known:
            allowed = f"{name} {COMMANDS[name]}" if name in COMMANDS else ", ".join(sorted({*COMMANDS, *SETTINGS}))
            if name in SETTINGS:
                allowed = f"{name} {SETTINGS[name].low} to {SETTINGS[name].high}"
            self.controller.finding("gpib-command", f"++{text}: not a command of the controller; allowed {allowed}")
            self._say(UNKNOWN)

    def _say(self, text: str) -> bool:
        """Queue a line of text as the answer to a command; return True, because the command has been accepted."""
        reply = f"{text}\r\n".encode("ascii", "replace")
        self.answer(lambda _controller, _work: reply)
        return True

    def _setting(self, name: str, arguments: Sequence[str]) -> bool:
        """Answer with the value of a setting, or set it to the argument; return False if the arguments are wrong."""
        if not arguments:
            return self._say(str(self.settings[name]))
        row = SETTINGS[name]
        value = numbers(arguments, row.low, row.high)
        if value is None or len(value) > 1:
            return False
        self._set(name, value[0])
        return True

    def _set(self, name: str, value: int) -> None:
        self.settings[name] = value
        if self.settings["savecfg"] or name == "savecfg":
            self.kept = dict(self.settings)

    def do_addr(self, arguments: Sequence[str]) -> bool:
        """Answer with the current address, or address another device; return False if the arguments are wrong."""
        if not arguments:
            return self._say(f"{self.settings['addr']}{self.secondary}")
        address = addressed(arguments)
        if address is None:
            return False
        self._look_for("addr", address)
        self._set("addr", address)
        self.secondary = f" {int(arguments[1])}" if len(arguments) > 1 else ""
        return True

    def do_read(self, arguments: Sequence[str]) -> bool:
        """Read from the addressed device; return False if the arguments are wrong."""
        if not arguments or list(arguments) == ["eoi"]:
            self._read(None)
            return True
        end = numbers(arguments, 0, 255)
        if end is None or len(end) > 1:
            return False
        self._read(end[0])
        return True

    def _look_for(self, command: str, address: int) -> None:
        """Report the address in a command, if no device has it."""
        if address not in self.selected:
            there = ", ".join(map(str, self.selected))
            message = f"++{command} {address}: no device has this address; devices are at {there}"
            self.controller.finding("gpib-address", message)

    def do_spoll(self, arguments: Sequence[str]) -> bool:
        """Poll the status of the addressed device, or of the one in the arguments; return False if they are wrong."""
        address = addressed(arguments) if arguments else self.settings["addr"]
        if address is None:
            return False
        if arguments:
            self._look_for("spoll", address)
        work = self.controller.poll(address, self.settings["read_tmo_ms"] * MS)
        self.answer(lambda _, work: b"" if work.result is None else f"{work.result}\r\n".encode(), work)
        return True

    def do_srq(self, arguments: Sequence[str]) -> bool:
        """Answer 1 if a device requests service, else 0; return False if there are arguments."""
        if not arguments:
            self.answer(lambda controller, _: f"{int(not controller.high('srq'))}\r\n".encode())
        return not arguments

    def do_trg(self, arguments: Sequence[str]) -> bool:
        """Trigger the addressed device, or the devices in the arguments; return False if the arguments are wrong."""
        addresses = numbers(arguments, 0, HIGHEST) if arguments else [self.settings["addr"]]
        if addresses is None or len(addresses) > MOST_TRIGGERED:
            return False
        for address in addresses:
            self.controller.trigger(address)
        return True

    def do_clr(self, arguments: Sequence[str]) -> bool:
        """Clear the addressed device; return False if there are arguments."""
        return self._message(SELECTED_CLEAR, arguments)

    def do_loc(self, arguments: Sequence[str]) -> bool:
        """Set the addressed device to local; return False if there are arguments."""
        return self._message(GO_TO_LOCAL, arguments)

    def do_llo(self, arguments: Sequence[str]) -> bool:
        """Lock out the front panel of the addressed device; return False if there are arguments."""
        return self._message(LOCAL_LOCKOUT, arguments)

    def _message(self, code: int, arguments: Sequence[str]) -> bool:
        if not arguments:
            self.controller.message(self.settings["addr"], code)
        return not arguments

    def do_ifc(self, arguments: Sequence[str]) -> bool:
        """Clear the interface, aborting any transfer; return False if there are arguments."""
        if not arguments:
            self._forget()
            self.controller.clear()
        return not arguments

    def do_rst(self, arguments: Sequence[str]) -> bool:
        """Restart the controller with the stored settings; return False if there are arguments."""
        if not arguments:
            self._forget()
            self.settings = dict(self.kept)
        return not arguments

    def _forget(self) -> None:
        if not self.queue.idle:
            self.controller.reset()
            self.let_in()

    def do_ver(self, arguments: Sequence[str]) -> bool:
        """Answer with the version; return False if there are arguments."""
        return not arguments and self._say(VERSION)

    def do_help(self, arguments: Sequence[str]) -> bool:
        """Answer with a list of the commands; return False if there are arguments."""
        rows = dict(COMMANDS) | {name: f"[{row.low}-{row.high}]: {row.description}" for name, row in SETTINGS.items()}
        return not arguments and all(
            [self._say(f"++{name} {description}") for name, description in sorted(rows.items())]
        )


def numbers(arguments: Sequence[str], low: int, high: int) -> list[int] | None:
    """Return the arguments as decimal numbers.

    Return None if there are no arguments, or if one is not a number in the range.
    """
    found = [int(each) if re.fullmatch("[0-9]{1,4}", each) else -1 for each in arguments]
    return found if found and all(low <= each <= high for each in found) else None


def addressed(arguments: Sequence[str]) -> int | None:
    """Return the primary bus address (PAD) in the arguments PAD [SAD]; None if the arguments are not valid."""
    primary, secondary = numbers(arguments[:1], 0, HIGHEST), arguments[1:]
    if primary is None or len(secondary) > 1 or (secondary and numbers(secondary, *SECONDARY) is None):
        return None
    return primary[0]


class PrologixPort(TcpPort):
    """A GPIB controller on a TCP port."""

    make = TurnSession
