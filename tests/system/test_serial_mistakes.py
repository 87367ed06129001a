"""What a host does wrong on a serial line, and what it is told: where, what was found, what is allowed, what to do.

Each row is a mistake that somebody makes in the first hour, on the surface on which it is made; the words are those
that a stranger needs to go on.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest
import serial
from click.testing import CliRunner

import slewline
import slewline.testing
from slewline.cli.commands import cli
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.testing.endpoints import running
from tests.links.conftest import PATIENCE, patient, until

PLAIN = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
SEVEN = {"baudrate": 9600, "bytesize": 7, "parity": "O", "stopbits": 2}


# ------------------------------------------------------------------------------------------------------------ surfaces
def told(bench: Any) -> str:
    return "\n".join(map(str, bench.findings))


def bench(*lines: str, part: str = "gs-c200s", run: str = "200 ms", over: str | None = None, **straps: int) -> str:
    """Lines as they are, by a host of a bench."""
    stand = slewline.Bench()
    x = stand.add(part, straps=PLAIN | straps if part.startswith("gs-c") else {})
    host = stand.host(x, over=over)
    for line in lines:
        host.send(line)
        stand.run(run)
    stand.run_until_idle()
    return told(stand)


def asked(command: str, part: str = "gs-c200s", first: str = "", over: str | None = None, **host: Any) -> str:
    """A question of a host that gets no answer."""
    stand = slewline.Bench()
    x = stand.add(part, straps=PLAIN if part.startswith("gs-c") else {})
    if part == "cy545":
        stand.part("ram", to=x, image=b"D 60000\r0\r")  # a long program, for X
    computer = stand.host(x, over=over, **host)
    if first:
        computer.send(first)
        stand.run("100 ms")
    with pytest.raises(slewline.Timeout) as caught:
        computer.ask(command)
    return f"{caught.value}\n{told(stand)}"


def url(data: bytes, part: str = "gs-c200s?chs=0", **settings: Any) -> str:
    """Characters of a program on pySerial, in the process of the module."""
    with serial.serial_for_url(f"slewline://{part}", **{**SEVEN, "timeout": 0.2, **settings}) as port:
        port.write(data)
        port.read_until(b"\r")
    return told(port.bench)


def endless(data: bytes, **settings: Any) -> str:
    """The same without a timeout, which ends in an exception."""
    with serial.serial_for_url("slewline://gs-c200s?chs=0", **{**SEVEN, **settings}) as port:
        port.write(data)
        with pytest.raises(slewline.Timeout) as caught:
            port.read_until(b"\r")
    return str(caught.value)


def served(kind: str, data: bytes, part: str = "gs-c200s", options: Any = None, **settings: Any) -> str:
    """Characters of a program behind a port, which it then closes."""
    straps = {"straps": PLAIN} if part.startswith("gs-c") else {}
    module = running(part, on=kind, **straps, **(options or {}))
    try:
        with serial.serial_for_url(patient(module.url), timeout=PATIENCE, **settings) as port:
            port.write(data)
            until(lambda: module.rig.do(lambda: module.rig.line.taken) >= len(data))
        module.advance("200 ms")
    finally:
        module.close()
    return told(module.bench)


def tcp(data: bytes, part: str = "gs-c200s") -> str:
    return served("tcp", data, part)


def pty(data: bytes, **settings: Any) -> str:
    return served("pty", data, **{"baudrate": 9600, **settings})


def rfc2217(data: bytes, **settings: Any) -> str:
    return served("rfc2217", data, **{**SEVEN, **settings})


def fixture(data: bytes, **settings: Any) -> str:
    """The report of a test that has failed."""
    module = running("gs-c200s", straps=PLAIN)
    try:
        with serial.serial_for_url(module.url, **{**SEVEN, "timeout": 0.2, **settings}) as port:
            port.write(data)
            port.read_until(b"\r")
        return module.report()
    finally:
        module.close()


def deaf() -> str:
    """A read of what a receive-only UART answers."""
    stand = slewline.Bench()
    stand.part("uart", name="uart", to=stand.add("cy525"))
    port = stand.part("serial_port", name="port", ttl=True, bits=8, parity="none", stop=1)
    stand.wire("port.txd", "uart.rxd")
    port.write("V 0\r")
    with pytest.raises(slewline.Timeout) as caught:
        stand.run_until(port.got(b"0"), "1 s")
    return str(caught.value)


def start(part: str) -> str:
    """The words of a server at its start."""
    stand, said = slewline.Bench(), list[str]()
    server = Server(stand, Lockstep(stand), report=said.append)
    server.line(stand.add(part))
    server.close()
    return "\n".join(said)


def log(part: str) -> str:
    """The transcript of a server to which a host has come."""
    module = running(part, on="tcp")
    try:
        with serial.serial_for_url(module.url, timeout=PATIENCE):
            until(lambda: bool(module.rig.do(lambda: module.rig.line.host_name)))
        return module.report()
    finally:
        module.close()


def python(part: str, **options: Any) -> str:
    """Options of a chip that are none."""
    with pytest.raises(slewline.UsageError) as caught:
        slewline.Bench().add(part, **options)
    return str(caught.value)


def opened(query: str) -> str:
    """A URL that says what is no option."""
    with pytest.raises(slewline.UsageError) as caught:
        serial.serial_for_url(f"slewline://{query}")
    return str(caught.value)


def command(*arguments: str) -> str:
    """The command line, which refuses."""
    result = CliRunner().invoke(cli, ["serve", *arguments])
    assert result.exit_code
    return f"{result.output}{result.exception or ''}"


def registers(data: bytes) -> str:
    """Text to the registers of a chipset."""
    module = running("mc1151a", on="tcp")
    try:
        host, _, number = module.url.rpartition("//")[2].rpartition(":")
        with socket.create_connection((host, int(number)), PATIENCE) as port:
            port.sendall(data)
            until(lambda: bool(module.rig.do(lambda: module.bench.findings)))
    finally:
        module.close()
    return told(module.bench)


# ------------------------------------------------------------------------------------------------------------ mistakes
class Mistake(NamedTuple):
    """What is done, on which surface, and the words that must be among what is told."""

    name: str
    surface: str
    does: Callable[[], str]
    words: tuple[str, ...]


def row(name: str, surface: Callable[..., str], *data: Any, words: str, **more: Any) -> Mistake:
    """Return a row; `words` are separated by bars."""
    return Mistake(name, surface.__name__, lambda: surface(*data, **more), tuple(words.split("|")))


RATE = "9600 7O2|(br0=0, br1=0, br2=0)|set the host to 9600 baud, 7 data bits, odd parity, 2 stop bits"
CHECKED = r"""send b'V1\x17\r'|low seven bits of the sum|--strap chs=0|straps={"chs": 0}"""
ENDS = r"has arrived without its carriage return|gs-c200s is waiting for it|carriage return (\r, 0x0D)"
CASE = "gs_c200s  E4: 'v1' is not a command of the gs-c200s|write V1: no spaces, and case matters"
TEXT = "is not a command of the gs-c200s|leave out the line feed"

# fmt: off
MISTAKES = (
    # rate and format
    row("a higher rate", asked, "V1", baud=19200, words=f"host is set to 19200 7O2, and gs_c200s to {RATE}"),
    row("a lower rate", asked, "V1", baud=1200, words=f"host is set to 1200 7O2|{RATE}|or the part to 1200 baud with br0=1, br1=1"),
    row("a higher rate", url, b"V1\r", baudrate=19200, words=f"line is set to 19200 7O2|gs_c200s to {RATE}"),
    row("a lower rate", url, b"V1\r", baudrate=4800, words=f"line is set to 4800 7O2|{RATE}|or the part to 4800 baud with br0=1"),
    row("8N1, which pySerial takes by itself", url, b"V1\r", bytesize=8, parity="N", stopbits=1, words=f"is set to 9600 8N1|{RATE}"),
    row("even parity", url, b"V1\r", parity="E", words=f"is set to 9600 7E2|{RATE}"),
    row("no parity", url, b"V1\r", parity="N", words=f"is set to 9600 7N2|{RATE}"),
    row("one stop bit", url, b"V1\r", stopbits=1, words=f"is set to 9600 7O1|{RATE}"),
    row("another rate, read without timeout", endless, b"V1\r", baudrate=19200, words=f"no more can arrive|is set to 19200 7O2|{RATE}|set a timeout on the port"),
    row("another rate", fixture, b"V1\r", baudrate=19200, words=f"line is set to 19200 7O2|{RATE}"),
    row("another rate", rfc2217, b"V1\r", baudrate=4800, words=f"gs_c200s is set to 4800 7O2|{RATE}".replace("gs_c200s is set", "is set")),
    row("8N1", rfc2217, b"V1\r", bytesize=8, parity="N", stopbits=1, words=f"is set to 9600 8N1|{RATE}"),
    row("even parity", rfc2217, b"V1\r", parity="E", words=f"is set to 9600 7E2|{RATE}"),
    row("another rate in the settings", pty, b"V1\r", baudrate=19200, words=f"the program is set to 19200 baud|{RATE}|passes characters at any rate, unlike a cable"),
    row("a parity fault on the wire", url, b"V1\r", parity="E", words="gs_c200s  E1: b'V1': a parity or framing error|is set to 9600 baud, 7 data bits, odd parity, 2 stop bits|br0=0|check the line for noise"),
    row("a rate that the CY545 has not found", url, b"\r\r? P\r? P\r", part="cy545", bytesize=8, parity="E", stopbits=1, words="line is set to 9600 8E1|to 9600 8N1|two carriage returns|set the host to 9600 baud, 8 data bits, no parity, 1 stop bit"),
    row("no carriage returns first", url, b"? P\r? R\r? O\r", part="cy545", bytesize=8, parity="N", stopbits=1, words="cy545  not-adapted: characters before two carriage returns: no rate is recognised|start with \\r\\r"),
    row("line feeds while the CY545 looks for the rate", url, b"\r\n\r\n? P\r", part="cy545", bytesize=8, parity="N", stopbits=1, words=r"not-adapted: a line feed (\n) between carriage returns: no rate is recognised|start with \r\r, without \n"),
    row("a rate that is none", url, b"\r\r\r", part="cy545", baudrate=1000, bytesize=8, parity="N", stopbits=1, words="cy545  wrong-rate: two carriage returns at 1000 baud|adapts to standard rates from|set the host to one of these"),
    # ends of lines
    row("no carriage return", bench, "V1", words=f"gs_c200s  unfinished: 'V1' {ENDS}"),
    row("no carriage return", url, b"V1", words=f"'V1' {ENDS}"),
    row("no carriage return", endless, b"V1", words="'V1' has arrived without its carriage return|set a timeout on the port"
    ),
    row("no carriage return", tcp, b"V1", words=f"'V1' {ENDS}"),
    row("no carriage return", pty, b"V1", words=f"'V1' {ENDS}"),
    row("no carriage return", rfc2217, b"V1", words=f"'V1' {ENDS}"),
    row("no carriage return", fixture, b"V1", words=f"'V1' {ENDS}"),
    row("no carriage return, CY525", bench, "A 0", part="cy525", words=r"cy525  unfinished: 'A 0' has arrived without its carriage return|the cy525 is waiting for it|(\r, 0x0D)"),
    row("no carriage return, CY545", bench, "R 10", part="cy545", over="serial", words="cy545  unfinished: 'R 10' has arrived without its carriage return|end each command"),
    row("a line feed", bench, "V1\n", words=r"line-end: the host ends its lines with LF, but this part expects CR|send \r alone|unfinished: 'V1\n'|not a line feed (\n)"),
    row("a line feed", tcp, b"V1\n", words=r"ends its lines with LF, but this part expects CR|send \r alone, without \n"),
    row("a line feed, CY525", bench, "A 0\n", part="cy525", words=r"cy525  line-end: the host ends its lines with LF, but this part expects CR|send \r alone, without \n"),
    row("carriage return and line feed", bench, "V1\r\n", "V1\r\n", words=rf"ends its lines with CR LF|treats LF as part of a command|send \r alone|E4: '\nV1' {TEXT}"),
    row("carriage return and line feed", pty, b"V1\r\nV1\r\n", words=rf"ends its lines with CR LF|send \r alone|{TEXT}"
    ),
    row("carriage return and line feed, CY525", bench, "A 0\r\n", "R 10\r\n", part="cy525", words=r"line-feed: a line feed in place of a command letter|send \r alone"),
    # numbers
    row("hexadecimal as in C, CY545", bench, "R 0x40\r", part="cy545", words="RATE 0x40: not a number; ignored; a hexadecimal number|ends with H: 40H"),
    row("hexadecimal as in C, CY525", bench, "R 0x40\r", part="cy525", words="RATE 0x40: not a decimal number; ignored; write 64, in decimal"),
    row("the letter O, CY525", bench, "R 8O\r", part="cy525", words="RATE 8O: not a decimal number; ignored; write 80, in digits: the letters O and l are not digits"),
    row("the letter O, CY545", bench, "R 8O\r", part="cy545", words="write 80, in digits: the letters O and l are not digits"),
    row("the letter O", bench, "Po\r", "S1O\r", words="E2: 'S1O' does not fit S<speed>|write S10, in digits: the letters O and l are not digits"),
    row("a query in small letters", bench, "? r\r", part="cy545", words="unknown-query: ? r is not answered|write ? R: letters are upper case"),
    row("no pause between commands", url, b"\r\rD 300\rR 10\rF 1\rS 20\r? R\r", part="cy545b", bytesize=8, parity="N", stopbits=1, words="serial-overrun: 0x|is lost; pause between commands, or wait for CTS"),
    row("Ctrl-C in a motion", bench, "Po\r", "S10\r", "T20\r", "R5\r", "+900\r", "E\r", "\x03\r", "!\r", words=r"busy: '\x03', which is not a command, is answered with B|or end it with K or Z"),
    # checksums
    row("no checksum", bench, "V1\r", chs=1, words=f"E1: b'V1': checksum '1' (0x31), expected 'V' (0x56) after b'V'; V1 arrived without one|{CHECKED}"),
    row("no checksum", url, b"V1\r", part="gs-c200s", words=f"V1 arrived without one|{CHECKED}"),
    row("no checksum, a blank after the address", bench, "4 V1\r", chs=1, sel0=0, words=r"V1 arrived without one, with spaces or in a different case: send b'4V1;\r'|strap chs=0"),
    row("no checksum, small letters", bench, "v1\r", chs=1, words=r"v1 arrived without one, with spaces or in a different case: send b'V1\x17\r'|strap chs=0"),
    row("the address at the end, broadcast", bench, "V14\r", "*V1\r", sel0=0, words="a line begins with 'V'|a line begins with '*'|begin the line with 4 (gs_c200s)"),
    row("a wrong checksum", bench, "V1x\r", chs=1, words=rf"checksum 'x' (0x78), expected 0x17 after b'V1'|{CHECKED}"),
    row("a checksum where there is none", bench, "V1\x17\r", words=r"'V1\x17' does not fit V<what>|'\x17' is the checksum of V1: leave it out, or strap chs=1"),
    row("a checksum where there is none", tcp, b"A3t\r", words="'A3t' does not fit A<output>|'t' is the checksum of A3: leave it out, or strap chs=1"),
    # what a line says
    row("small letters", bench, "v1\r", words=CASE),
    row("small letters", tcp, b"v1\r", words=CASE),
    row("small letters", fixture, b"v1\r", words=CASE),
    row("small letters, CY525", bench, "a 0\r", part="cy525", words="cy525  unknown-command: a is not a command|write A: command letters are upper case"),
    row("a blank", bench, "S 10\r", words="E2: 'S 10' does not fit S<speed>|write S10: no spaces"),
    row("a command of programs", bench, "+100\r", words="E4: +100 outside a program|begin program entry with Po"),
    row("a command of programs", rfc2217, b"S10\r", words="E4: S10 outside a program|begin program entry with Po"),
    row("a command outside of programs", bench, "Po\r", "Z\r", words="E4: Z during program entry|end program entry first, with E or Px"),
    row("P for Po", bench, "P\r", words="E4: 'P' is not a command of the gs-c200s|with this letter it has Po, Px"),
    row("an unknown command", url, b"N1\r", words="E4: 'N1' is not a command of the gs-c200s|its commands begin with A C D"
    ),
    row("a number that is too large", bench, "Po\r", "R5000\r", words="E2: R5000: ramp 5000, allowed 1..999|the nearest is 999"),
    row("a number that is too small", bench, "Po\r", "S0\r", words="E2: S0: speed 0, allowed 1..1000|the nearest is 1"),
    row("a move of nothing", bench, "Po\r", "+0\r", words="E2: +0: steps 0, allowed -999999..999999 without 0|the nearest is +1"),
    row("no number", bench, "V\r", words="gs_c200s  E2: 'V' does not fit V<what>|give what 1..2"),
    row("a motion before S, T and R", bench, "Po\r", "+100\r", "E\r", words="E4: E is refused without S, T, R;|set S, T, R at the start of the program"),
    row("a run of nothing", bench, "E\r", words="E4: E is refused, because the program is empty|begin program entry with Po"),
    row("a homing without a speed", bench, "H+\r", words="E4: H is refused without a start-stop speed|set S at the start of the program"),
    row("a line that is too long", bench, "+100,+200,+300\r", words="gs_c200s  E1: |more than 11 characters|end each command with a carriage return"),
    row("a program while one runs", bench, "Po\rD9\rE\r", "Po\r", words="busy: Po is answered with B and ignored while a program runs|wait until F is answered with R, or end it with K or Z"),
    # who is spoken to
    row("no address", bench, "V1\r", sel0=0, words="host  address: a line begins with 'V', which is not the address of a module here|no module answers|begin the line with 4 (gs_c200s)|change the address straps"),
    row("a wrong address", bench, "5V1\r", sel0=0, words="a line begins with '5'|begin the line with 4 (gs_c200s)"),
    row("an address where there is none", bench, "4V1\r", words="E4: '4V1' is not a command|write V1: leave out the address"),
    # who answers
    row("a question to a running CY545", asked, "? P", part="cy545", over="serial", first="X\r", words="X has started a program|the cy545 accepts no command while one runs|wait for its end, or end it with RESET"),
    row("an answer that goes to the bus", asked, "? P", part="cy545", over="serial", first="O 129\r", words="the mode register is 129 and sends answers elsewhere|send O 128 to get them here"),
    row("an answer that goes to TXD", asked, "? P", part="cy545", over="parallel", words="the mode register is 128 and sends answers elsewhere|send O 129 to get them here"),
    row("an answer that goes to the bus", url, b"\r\rO 129\r? P\r", part="cy545", bytesize=8, parity="N", stopbits=1, words="cy545  answer-elsewhere: ? P arrived on RXD|the parallel port|O 128 sends answers to TXD"),
    row("a question to what only receives", deaf, words="port|nothing drives its rxd: the other end only receives"),
    row("what only receives", start, "cy525", words="the UART of cy525 only receives: commands are not answered|--framing|?0 to ?3 read back"),
    row("what only receives", log, "cy525", words="the chip only receives on this line: it never answers"),
    row("a rate as an option", python, "gs-c200s", baud=9600, words="gs_c200s: no option 'baud': straps set its rate|br0=0, br1=0, br2=0|--strap br0=0"),
    row("a rate that there is not", python, "gs-c200s", baud=19200, words="straps set its rate: allowed 110, 150, 300, 600, 1200, 2400, 4800, 9600|--strap br0=0"),
    row("checksums as an option", python, "gs-c200s", checksum=False, words="no option 'checksum': a strap sets it: chs=0 switches checksums off|--strap chs=0"),
    row("a rate in a URL", opened, "gs-c200s?baud=9600", words="no option 'baud': straps set its rate: br0=0, br1=0, br2=0"),
    row("a rate for the server", command, "gs-c200s", "--tcp", "127.0.0.1:0", "--baud", "9600", words="--baud 9600: straps set its rate|br0=0, br1=0, br2=0|--strap br0=0"),
    row("a port of Windows as a link", command, "gs-c200s", "--pty", "COM3", words="COM3 is the name of a port on Windows, for --serial|give the path of a link, such as /tmp/COM3"),
    row("a port of Windows", command, "gs-c200s", "--serial", "COM3", words="COM3: the name of a port on Windows; on this system a serial port is /dev/ttyUSB0"),
    row("a serial port that is not there", command, "gs-c200s", "--serial", "/dev/ttyUSB77", words="/dev/ttyUSB77: No such file or directory; name a serial port that exists"),
    row("a TCP port as a serial port", command, "gs-c200s", "--serial", "socket://127.0.0.1:4001", words="an address, not a serial port; name a device, such as /dev/ttyUSB0 or COM3; --tcp opens a TCP port"),
    row("an address as a serial port", command, "gs-c200s", "--serial", "127.0.0.1:4001", words="127.0.0.1:4001: an address, not a serial port"),
    row("text to a port of registers", registers, b"GET_VRSN\r\n", words="mc1151a_isa  no-request: |b'GE' (text, it seems) is not a request|a port for registers, with two bytes per request|docs/howto/serve_registers.md"),
)
# fmt: on
SERVED = ("tcp", "rfc2217", "pty", "log", "registers")  # by a thread, on a socket or a terminal
ON_POSIX = ("pty", "command")


def told_what_it_takes(mistake: Mistake) -> None:
    text = mistake.does()
    missing = [word for word in mistake.words if word not in text]
    assert not missing, f"{missing} not in:\n{text}"


def test_a_mistake_is_reported_with_its_place_and_its_remedy(subtests: pytest.Subtests) -> None:
    for mistake in MISTAKES:
        if mistake.surface not in SERVED and (mistake.surface not in ON_POSIX or hasattr(os, "openpty")):
            with subtests.test(f"{mistake.name}, {mistake.surface}"):
                told_what_it_takes(mistake)


ROWS = [
    pytest.param(each, marks=pytest.mark.posix) if each.surface in ON_POSIX else each
    for each in MISTAKES
    if each.surface in SERVED
]


@pytest.mark.system
@pytest.mark.parametrize("mistake", ROWS, ids=lambda mistake: f"{mistake.name}, {mistake.surface}".replace(" ", "_"))
@pytest.mark.filterwarnings("ignore:set(Daemon|Name)\\(\\) is deprecated:DeprecationWarning")
def test_a_mistake_through_a_port_is_reported_with_its_place_and_its_remedy(mistake: Mistake) -> None:
    told_what_it_takes(mistake)
