"""RFC 2217: rate and parity that a host asks for are those of the line."""

from __future__ import annotations

import asyncio
import random

import pytest
import serial
import serialx

import slewline
from slewline.links.serving import NOT_RECEIVING
from tests.ensembles import in_long_runs

from .conftest import PATIENCE, Threaded, patient

IAC, SB, SE, COM = 255, 250, 240, 44
WILL, WONT = 251, 252

# the client of pySerial 3.5 names its thread in a way that Python 3.10 calls deprecated
pytestmark = pytest.mark.filterwarnings("ignore:set(Daemon|Name)\\(\\) is deprecated:DeprecationWarning")


@pytest.fixture
def port(lockstep):
    server, line = lockstep()
    port = server.rfc2217(line, "127.0.0.1:0")
    with Threaded(server) as running:
        yield running, line, port


def opened(port, **settings):
    settings = {"baudrate": 9600, "bytesize": 7, "parity": "O", "stopbits": 2, "timeout": PATIENCE} | settings
    return serial.serial_for_url(patient(port[2].where), **settings)


@pytest.mark.system
def test_a_module_answers(port):
    with opened(port) as host:
        host.write(b"V1\r")
        assert host.read_until(b"\r") == b"V+0\r"


@pytest.mark.system
@pytest.mark.parametrize("setting", [{"parity": "E"}, {"parity": "N", "bytesize": 8}])
def test_another_parity_gives_what_it_gives_on_a_wire(port, setting):
    with opened(port, **setting) as host:
        host.write(b"V1\r")
        assert host.read_until(b"\r") == b"E1\r"


@pytest.mark.system
def test_another_rate_gives_what_it_gives_on_a_wire(port):
    running, line, _ = port
    with opened(port, baudrate=4800) as host:
        host.write(b"F\r")
        running.until(lambda: line.taken == 2)
        assert running.do(lambda: (line.port.baud, str(line.port.word))) == (4800, "7O2")
    assert b"R\r" not in bytes(line.port.received)


@pytest.mark.system
def test_settings_may_change_and_the_next_host_finds_those_of_the_module(port):
    running, line, _ = port
    with opened(port) as host:
        host.baudrate, host.parity = 1200, "E"
        running.until(lambda: (line.port.baud, str(line.port.word)) == (1200, "7E2"))
        host.baudrate, host.parity = 9600, "O"
        host.write(b"F\r")
        assert host.read_until(b"\r") == b"R\r"
        host.baudrate = 300
    running.until(lambda: line.host is None)
    assert (line.port.baud, str(line.port.word)) == (9600, "7O2")


@pytest.mark.system
def test_a_session_with_changing_settings_replays(lockstep, tmp_path):
    server, line = lockstep(journal=tmp_path / "journal")
    port = server.rfc2217(line, "127.0.0.1:0")
    with Threaded(server), opened((None, None, port), parity="E") as host:
        host.write(b"V1\r")
        assert host.read_until(b"\r") == b"E1\r"
        host.parity = "O"
        host.write(b"V1\r")
        assert host.read_until(b"\r") == b"V+0\r"
    again = slewline.replay(tmp_path / "journal")
    assert bytes(again["x_line"].received) == b"E1\rV+0\r"
    assert again.now_ps == server.bench.now_ps


@pytest.mark.system
def test_a_malformed_rate_is_not_taken(port):
    _, line, _ = port
    with opened(port) as host, pytest.raises(ValueError, match="rejected"):
        host.baudrate = 3_000_000
    assert line.port.baud == 9600


@pytest.mark.system
def test_modem_lines_and_break_are_accepted(port):
    running, line, _ = port
    with opened(port) as host:
        host.dtr = host.rts = False
        assert host.cts and host.dsr and host.cd
        host.break_condition = True
        running.until(lambda: line.port.pin("txd").level == 1)
        host.break_condition = False
        running.until(lambda: line.port.pin("txd").level == 0)
        host.rts = True
        host.write(b"\r\r")
        host.write(b"F\r")
        assert b"R\r" in host.read_until(b"R\r")


@pytest.mark.system
def test_every_byte_gets_through(port):
    """255 begins the commands of the protocol; as a character it is doubled on the way."""
    running, line, _ = port
    with opened(port, bytesize=8, parity="N") as host:
        running.do(lambda: line.give(bytes(range(256))))
        assert host.read(256) == bytes(range(256))
        host.write(bytes([IAC]))
        running.until(lambda: line.taken == 1)


@pytest.mark.system
def test_garbage_does_not_stop_the_server(port, client):
    running, line, tcp = port
    chance = random.Random(7)
    host = client(tcp.where)
    pieces = [
        chance.randbytes(50),
        bytes([IAC, SB, COM, 1, 0, IAC, SE]),
        bytes([IAC, SE]),
        bytes([IAC, SB, COM, 3, 77, IAC, SE]),
    ]
    for _ in range(200):
        host.send(chance.choice(pieces) + bytes([IAC, SE]))
    host.close()
    running.until(lambda: line.host is None)
    with opened(port) as good:
        taken = line.taken
        good.write(b"\r")
        running.until(lambda: line.taken == taken + 1 and line.quiet())
        good.write(b"F\r")
        assert good.read_until(b"R\r").endswith(b"R\r")


def test_an_endless_option_is_disconnected(port, client):
    running, line, tcp = port
    host = client(tcp.where)
    running.until(lambda: line.host is not None)
    host.send(bytes([IAC, SB, COM]) + bytes(10_000))
    running.until(lambda: line.host is None)


@pytest.mark.system
def test_the_next_host_is_refused(port, client):
    with opened(port) as first:
        assert b"one host at a time" in client(port[2].where).read(end=b"")
        first.write(b"F\r")
        assert first.read_until(b"\r") == b"R\r"


# ------------------------------------------------------------------------------------------------------- other clients
SERIALX = {"baudrate": 9600, "byte_size": 7, "parity": serialx.Parity.ODD, "stopbits": serialx.StopBits.TWO}


def test_serialx_opens_the_port(port):
    with serialx.serial_for_url(port[2].where, read_timeout=PATIENCE, **SERIALX) as host:
        host.write(b"V1\r")
        assert host.read_until(b"\r") == b"V+0\r"


def test_serialx_opens_it_in_asyncio(port):
    async def ask():
        reader, writer = await serialx.open_serial_connection(port[2].where, **SERIALX)
        writer.write(b"V1\r")
        answer = await reader.readuntil(b"\r")
        writer.close()
        await writer.wait_closed()
        return answer

    assert asyncio.run(ask()) == b"V+0\r"


@pytest.mark.parametrize("count", [20, in_long_runs(100)])
@pytest.mark.parametrize("kind", ["sync", "async"])
def test_serialx_opens_exchanges_and_closes_again_and_again(port, kind, count):
    """One host behind the other, none of which waits before it opens."""
    running, line, net = port

    def exchange(number):
        with serialx.serial_for_url(net.where, read_timeout=PATIENCE, **SERIALX) as host:
            host.write(f"D{number}\r".encode() if number % 2 else b"V1\r")
            return host.read_until(b"\r")

    async def exchange_async(number):
        async with serialx.async_serial_for_url(net.where, **SERIALX) as host:
            await host.write(f"D{number}\r".encode() if number % 2 else b"V1\r")
            return await host.readuntil(b"\r")

    async def all_async():
        return [await exchange_async(number) for number in range(count)]

    answers = asyncio.run(all_async()) if kind == "async" else [exchange(number) for number in range(count)]
    half = count // 2
    assert answers == [b"V+0\r", b"E4\r"] * half
    assert running.do(lambda: (line.taken, line.given)) == (half * 3 + 5 * 3 + (half - 5) * 4, half * 4 + half * 3)


@pytest.mark.parametrize(("option", "mask"), [(10, b"\x00"), (10, b"\x70"), (11, b"\x0f"), (11, b"\xff\xff")])
def test_the_masks_of_line_and_modem_state_are_acknowledged(port, client, option, mask):
    """Code + 100, and the same mask; 255 is doubled, as every 255 is."""
    host = client(port[2].where)
    host.send(bytes([IAC, SB, COM, option]) + mask + bytes([IAC, SE]))
    answer = bytes([IAC, SB, COM, option + 100]) + mask + bytes([IAC, SE])
    assert host.read(answer).endswith(answer)


def test_the_settings_that_the_line_needs_are_reported_at_the_start(lockstep):
    server, line = lockstep()
    told = []
    server.report = told.append
    where = server.rfc2217(line, "127.0.0.1:0").where
    assert told == [
        f"{where}: the line has 9600 baud, 7 data bits, odd parity, 2 stop bits; "
        "a host that sets another format, such as 8N1, gets E1 or no answer"
    ]
    server.close()


def test_a_line_of_eight_bits_needs_no_such_word(lockstep):
    server, _ = lockstep()
    told = []
    server.report = told.append
    server.rfc2217(server.line(server.bench.add("cy525")), "127.0.0.1:0")
    server.close()
    assert told == [NOT_RECEIVING.format(chip="cy525")]


@pytest.mark.system
@pytest.mark.parametrize(
    ("agrees", "answer"),
    [(b"", b"V+0\r"), (bytes([IAC, WONT, 0]), b"V+0\r"), (bytes([IAC, WILL, 0]), b"E4\r")],
)
def test_a_return_of_telnet_is_a_carriage_return(port, client, agrees, answer):
    """Without the option BINARY a terminal program sends CR NUL; its NUL would begin the next command."""
    host = client(port[2].where)
    host.send(agrees)
    for byte in b"F\r\0V1\r\0":
        host.send(bytes([byte]))
    assert host.read(b"R\r").endswith(b"R\r") and host.read() == answer
