"""Programs on serialx, sync and async, that open slewline://."""

from __future__ import annotations

import asyncio
import contextlib
import time

import anyio
import pytest
import serial
import serialx

from slewline.errors import Timeout, UsageError
from slewline.language.lines import framed
from slewline.testing import aio, for_serialx, rig

SETTINGS = {"baudrate": 9600, "byte_size": 7, "parity": "O", "stopbits": 2}
URL = "slewline://gs-c200s?chs=0"
PROGRAM = ("Po", "S10", "T100", "R50")
CHARACTER_PS = 11 * 10**12 // 9600


def opened(url=URL, **changes):
    return serialx.serial_for_url(url, **{**SETTINGS, "read_timeout": 2, **changes})


def ask(port, command):
    port.write(command.encode() + b"\r")
    return port.read_until(b"\r").decode().rstrip()


# ----------------------------------------------------------------------------------------------------------------- sync
def test_a_program_is_entered_run_and_polled():
    with opened() as port:
        assert [ask(port, command) for command in (*PROGRAM, "+200", "E")] == ["Y"] * 6
        while ask(port, "F") == "B":
            port.sleep(0.1)
        assert ask(port, "V1") == "V+200"
        assert (port.chip.position, len(port.chip.steps())) == (200, 200)
        assert port.bench.findings == []


def test_an_exchange_takes_the_time_of_the_line_and_no_other():
    with opened() as port:
        ask(port, "F")
        began = port.bench.now_ps
        assert ask(port, "F") == "R"
        assert port.bench.now_ps - began == pytest.approx(4 * CHARACTER_PS + 10**9, abs=10)


def test_a_read_returns_the_available_bytes_and_waits_for_the_first():
    with opened() as port:
        port.write(b"V1\rF\r")
        assert port.read(100) == b"V"
        port.sleep(0.1)
        assert port.num_unread_bytes() == 5
        assert port.read(3) == b"+0\r"
        assert port.readexactly(2) == b"R\r"
        now = port.bench.now_ps
        assert port.read(1) == b"" and port.bench.now_ps - now == 2 * 10**12
        assert port.readinto(bytearray(1), timeout=0) == 0


def test_a_read_without_timeout_reports_that_nothing_is_coming():
    with opened(read_timeout=None) as port, pytest.raises(Timeout, match="no more can arrive"):
        port.read(1)


def test_buffers_pins_and_settings():
    with opened() as port:
        port.write(b"V1\r")
        assert port.num_unwritten_bytes() == 3
        port.reset_write_buffer()
        port.flush()
        port.sleep(0.1)
        port.write(b"\r")
        port.sleep(0.1)
        assert port.num_unread_bytes() > 0
        port.reset_read_buffer()
        assert ask(port, "F") == "R"
        assert (port.rts, port.cts, port.dtr) == (True, True, True)
        port.set_modem_pins(rts=False)
        assert (port.rts, port.cts) == (False, False)
        port.reconfigure_port(parity="E")
        assert ask(port, "F") == "E1"
        port.reconfigure_port(parity="O")
        assert ask(port, "F") == "R"


def test_opening_again_finds_the_module_by_name_or_by_the_object():
    port = opened()
    for steps in (5, 10):
        with port:
            assert [ask(port, command) for command in (*PROGRAM, "+5", "E")] == ["Y"] * 6
            port.sleep(1)
            assert ask(port, "V1") == f"V+{steps}"
    with opened(f"{URL}&name=left") as first:
        ask(first, "Po"), ask(first, "S44")
    with opened("slewline://gs-c200s?name=left") as second:
        assert second.chip is first.chip and ask(second, "Q") == "S44" and port.chip is not first.chip


def test_a_module_of_a_name_is_the_same_for_both_libraries():
    with opened(f"{URL}&name=left") as first:
        assert ask(first, "F") == "R"
    with serial.serial_for_url("slewline://gs-c200s?name=left", 9600, 7, "O", 2, timeout=1) as second:
        assert second.chip is first.chip
        with pytest.raises(serialx.SerialException, match="it is open in another program"):
            opened("slewline://gs-c200s?name=left").open()


@pytest.mark.parametrize(
    ("url", "changes", "error", "says"),
    [
        (URL, {"parity": "M"}, UsageError, "parity 'M'; allowed N"),
        (URL, {"xonxoff": True}, UsageError, "xonxoff=True"),
        ("slewline://gs-c900", {}, UsageError, "no chip 'gs-c900'"),
        ("slewline://tests.testing.guest:Guest", {}, UsageError, "allow_code"),
    ],
)
def test_a_mistake_is_reported_and_nothing_is_open(url, changes, error, says):
    port = opened(url, **changes)
    with pytest.raises(error, match=says):
        port.open()
    assert not port.is_open


# ---------------------------------------------------------------------------------------------------------------- async
class Host:
    """A host program on streams."""

    def __init__(self, reader, writer):
        self.reader, self.writer = reader, writer

    @classmethod
    async def open(cls, url=URL):
        return cls(*await serialx.open_serial_connection(url, **SETTINGS))

    async def ask(self, command):
        self.writer.write(command.encode() + b"\r")
        return (await self.reader.readuntil(b"\r")).decode().rstrip()

    async def feed(self, steps, poll=0.05):
        for command in (*PROGRAM, f"+{steps}", "E"):
            assert await self.ask(command) == "Y"
        polls = 0
        while await self.ask("F") == "B":
            await asyncio.sleep(poll)
            polls += 1
        return polls, await self.ask("V1")

    async def close(self):
        self.writer.close()
        await self.writer.wait_closed()

    @property
    def bench(self):
        return self.writer.transport.serial.bench


async def two_at_once():
    left, right = await Host.open(), await Host.open()
    try:
        return await asyncio.gather(left.feed(800), right.feed(100)), (left.bench.now_ps, right.bench.now_ps)
    finally:
        await left.close()
        await right.close()


def in_anyio(main):
    return anyio.run(lambda: main, backend_options={"loop_factory": aio.VirtualLoop})


@pytest.mark.parametrize("run", [aio.run, in_anyio], ids=["asyncio", "anyio"])
def test_one_host_runs_two_modules_at_the_same_time_in_virtual_time(run):
    """The polls are 50 ms of virtual time apart, and both modules keep one time: the same in every run."""
    ((far, near), times), again = run(two_at_once()), run(two_at_once())
    assert (far, near) == ((17, "V+800"), (4, "V+100"))
    assert times[0] == times[1]
    assert again == ([far, near], times)


@pytest.mark.slewline(straps={"chs": 0})
def test_a_test_watches_the_pins_while_its_host_works(gs_c200s):
    """The host program opens the URL of a fixture; another task waits for the bench."""
    bench, module = gs_c200s.bench, gs_c200s.chip

    async def watch():
        await bench.until(module.reaches(40))
        gs_c200s.pin("enable").drive(0)  # holds the next step
        await bench.wait("500 ms")
        gs_c200s.pin("enable").drive(1)
        return bench.now_ps

    async def main():
        watching = asyncio.create_task(watch())
        host = await Host.open(gs_c200s.url)
        _, answer = await host.feed(200)
        await host.close()
        return watching.result(), answer

    released, answer = aio.run(main())
    times = module.steps().times_ps.tolist()
    assert times[39] == released - 500 * 10**9 and times[40] > released
    assert (answer, module.position) == ("V+200", 200)


@pytest.mark.system
def test_in_the_loop_of_the_wall_clock_time_passes_as_far_as_the_line_needs():
    async def main():
        host = await Host.open()
        assert await host.ask("F") == "R"
        before = host.bench.now_ps
        await asyncio.sleep(0.05)
        assert host.bench.now_ps == before
        polls, answer = await host.feed(100, poll=0)
        assert (polls > 20, answer) == (True, "V+100")
        await host.close()

    asyncio.run(main())


@pytest.mark.system
def test_with_a_rate_time_follows_the_wall_clock():
    async def main():
        host = await Host.open(f"{URL}&rate=20")
        rig = host.writer.transport.serial.rig
        moments = [time.perf_counter(), rig.present(), time.perf_counter()]
        assert (await host.feed(100, poll=0.01))[1] == "V+100"
        await asyncio.sleep(0.02)
        moments += [time.perf_counter(), rig.present(), time.perf_counter()]
        virtual = (moments[4] - moments[1]) / 10**12
        assert 20 * (moments[3] - moments[2]) - 0.001 < virtual < 20 * (moments[5] - moments[0]) + 0.001
        await host.close()

    asyncio.run(main())


@pytest.mark.parametrize("run", [asyncio.run, aio.run], ids=["wall clock", "virtual"])
def test_closing_lets_out_what_was_written_and_aborting_does_not(run):
    async def main():
        host = await Host.open(f"{URL}&name=left")
        host.writer.write(b"Po\r" + b"T55\r" * 10 + b"S44\r")  # more than is on the line at once
        await host.close()
        host = await Host.open("slewline://gs-c200s?name=left")
        while "S44" not in host.writer.transport.serial.chip.listing():
            with contextlib.suppress(TimeoutError):  # the answer to it may come to this host, as on a wire
                async with asyncio.timeout(0.05):
                    await host.reader.read(100)
        host.writer.write(b"T55\r" * 10 + b"T77\r")
        host.writer.transport.abort()
        await host.writer.wait_closed()
        host = await Host.open("slewline://gs-c200s?name=left")
        host.writer.write(b"\r")
        await asyncio.sleep(0.05)
        await host.ask("F")
        await host.ask("Q")
        assert "T77" not in host.writer.transport.serial.chip.listing()
        await host.close()

    run(main())


def test_async_serial_has_all_that_serialx_gives_it():
    async def main():
        async with serialx.async_serial_for_url(URL, **SETTINGS) as port:
            await port.write(b"V1\r")
            await port.flush()
            assert await port.readuntil(b"\r") == b"V+0\r"
            port.transport.pause_reading()
            await port.write(b"V1\r")
            with pytest.raises(TimeoutError):
                async with asyncio.timeout(1):
                    await port.readexactly(1)
            port.transport.resume_reading()
            assert await port.readexactly(4) == b"V+0\r"
            await port.set_modem_pins(rts=False)
            assert (await port.get_modem_pins()).cts == serialx.PinState.LOW
            await port.reconfigure_port(parity="E")
            await port.write(b"F\r")
            assert await port.readuntil(b"\r") == b"E1\r"
            assert port.transport.serial.is_open
        assert not port.is_open

    aio.run(main())


@pytest.mark.parametrize("run", [asyncio.run, aio.run], ids=["wall clock", "virtual"])
def test_a_hundred_openings_in_a_row(run):
    async def main():
        for number in range(100):
            host = await Host.open("slewline://gs-c200s?name=left" + "&chs=0" * (number == 0))
            assert await host.ask("V1") == "V+0"
            await host.close()

    run(main())
    assert rig.NAMED["left"].line.host is None


def test_a_mistake_in_async_is_reported_and_nothing_is_open():
    async def main():
        host = await Host.open(f"{URL}&name=left")
        with pytest.raises(serialx.SerialException, match="it is open in another program"):
            await Host.open("slewline://gs-c200s?name=left")
        with pytest.raises(UsageError, match="no chip 'gs-c900'"):
            await Host.open("slewline://gs-c900")
        assert await host.ask("F") == "R"
        await host.close()

    aio.run(main())


def test_with_checksums_as_the_module_is_made():
    async def main():
        host = await Host.open("slewline://gs-c200s")
        host.writer.write(framed("V1"))
        assert await host.reader.readuntil(b"\r") == framed("V+0")
        await host.close()

    aio.run(main())


def test_the_classes_are_those_of_the_scheme():
    assert serialx.get_serial_classes(URL) == (for_serialx.Serial, for_serialx.Transport)
