"""A motor record: what its fields do, in virtual time, and what clients of EPICS see of it."""

from __future__ import annotations

import asyncio
import os
import signal
import socket
import sys
import threading
import time
from contextlib import contextmanager, suppress

import pytest

import slewline.testing  # noqa: F401  # pySerial knows slewline://
from slewline.errors import UsageError
from slewline.modules.failures import PortLost, RefusedCommand
from slewline.testing.endpoints import running

pytest.importorskip("caproto")
pytest.importorskip("serial")

from slewline.labs import record as labs
from slewline.labs.channel_access import interfaces, serve
from slewline.labs.record import MotorRecord
from tests.labs.clients import Client
from tests.labs.watched import GSC, motor_at
from tests.links.conftest import PATIENCE, until
from tests.ports import free_port


# --------------------------------------------------------------------------------------------------------------- fields
def test_a_put_completes_when_the_motion_has(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 1200))
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        assert (record.get("DMOV"), put.done()) == (0, False)
        await put
        assert (record.chip.position, record.get("RBV"), record.get("DMOV")) == (1200, 1200, 1)

    record = run(play)
    assert record.of("RBV", "DMOV") == [("DMOV", 0), ("RBV", 1200), ("DMOV", 1)]
    assert record.of("TDIR", "MISS") == []  # as before
    assert [int(value) & 0x403 for key, value in record.of("MSTA")] == [0x001, 0x401, 0x001, 0x003]
    assert record.said == []


def test_a_move_to_the_present_position_is_complete_immediately_and_reported(run):
    async def play(record):
        await record.put("VAL", 0)

    assert run(play).of("RBV", "MOVN", "DMOV") == [("DMOV", 0), ("DMOV", 1)]


def test_a_part_that_is_silent_while_it_moves_has_a_record_as_well(run):
    async def play(record):
        await record.put("VAL", 4000)
        assert record.chip.position == record.get("RBV") == 4000
        with pytest.raises(UsageError, match="no homing command with a selectable direction"):
            await record.put("HOMF", 1)
        put = asyncio.create_task(record.put("VAL", 0))
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        with pytest.raises(UsageError, match="accepts no command while the motor moves"):
            await record.put("STOP", 1)
        await put
        assert record.get("RBV") == 0

    run(play, url="slewline://cy545", part="cy545", values={"F": 20, "R": 100, "S": 200})


def test_a_stop_completes_at_rest_and_forgets_what_was_to_come(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 50_000))
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        await record.put("STOP", 1)
        await put
        assert 0 <= record.get("RBV") < 1000
        assert record.get("VAL") == record.get("RBV") == record.chip.position
        assert (record.get("DMOV"), record.get("MISS")) == (1, 0)
        await record.put("STOP", 1)  # at rest it does nothing
        await record.put("VAL", 100)
        assert record.get("RBV") == 100

    run(play)


def test_a_position_that_is_put_meanwhile_is_the_next_one_and_all_puts_complete_with_it(run):
    async def play(record):
        puts = [asyncio.create_task(record.put("VAL", 50_000))]
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        for target in (40_000, 300):
            puts.append(asyncio.create_task(record.put("VAL", target)))
            await asyncio.sleep(0)
        await asyncio.gather(*puts)
        assert (record.chip.position, record.get("RBV"), record.get("VAL")) == (300, 300, 300)

        assert len(record.chip.steps()) < 5000  # none of the others was reached

    run(play)


def test_a_position_that_is_put_after_a_stop_is_reached(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 50_000))
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        stop = asyncio.create_task(record.put("STOP", 1))
        await asyncio.sleep(0)
        await record.put("VAL", 700)
        await asyncio.gather(put, stop)
        assert (record.chip.position, record.get("RBV")) == (700, 700)

    assert run(play).of("RBV", "DMOV")[-2:] == [("RBV", 700), ("DMOV", 1)]


def test_the_motion_continues_after_the_last_client_has_gone(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 600))
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        put.cancel()
        while not record.get("DMOV"):
            await asyncio.sleep(0.001)
        assert record.chip.position == record.get("RBV") == 600
        await record.put("VAL", 500)
        assert record.get("RBV") == 500

    run(play)


def test_tweaks_go_by_a_step_of_their_own(run):
    async def play(record):
        await record.put("TWV", 25)
        await record.put("TWF", 1)
        await record.put("TWF", 1)
        await record.put("TWR", 1)
        await record.put("TWR", 0)  # which is nothing
        assert record.get("RBV") == record.chip.position == 25

    run(play)


def test_a_homing_ends_where_the_switches_are(run):
    async def play(record):
        await record.put("VAL", 40)
        for switch in ("eot", "home"):
            record.chip.pin(switch).drive(0)
        await record.put("HOMR", 1)
        assert record.get("RBV") == record.get("VAL") == record.chip.position == 0

    run(play)


@pytest.mark.parametrize(("value", "within"), [(100, True), (101, False), (-1, False)])
def test_a_position_beyond_the_limits_causes_no_motion(run, value, within):
    async def play(record):
        await record.put("LLM", 0)
        await record.put("HLM", 100)
        await record.put("VAL", value)
        assert record.get("LVIO") == (not within)
        assert record.chip.position == (100 if within else 0)
        assert record.get("VAL") == (100 if within else 0)
        assert record.of("DMOV") == [("DMOV", 0), ("DMOV", 1)]  # whoever waits for it goes on

    run(play)


def test_limits_of_0_are_none_but_those_of_the_part(run):
    async def play(record):
        await record.put("LLM", 0)
        await record.put("HLM", 0)
        await record.put("VAL", 50)
        assert (record.get("RBV"), record.get("LVIO")) == (50, 0)
        await record.put("VAL", 1e7)
        assert (record.get("RBV"), record.get("LVIO")) == (50, 1)

    run(play)


def test_units_and_direction_are_those_of_the_resolution(run):
    async def play(record):
        assert [record.get(key) for key in ("MRES", "PREC", "EGU", "VELO", "VBAS")] == [-0.005, 3, "mm", 5, 0.5]
        assert (record.get("LLM"), record.get("HLM")) == pytest.approx((-41943.035, 41943.04))
        await record.put("VAL", 1)
        assert (record.chip.position, record.get("RBV"), record.get("RRBV"), record.get("TDIR")) == (-200, 1, -200, 0)
        await record.put("VELO", 10)
        assert (record.get("VELO"), record.state.ramps["move"].top) == (10, 2000)

    run(play, resolution=-0.005, units="mm")


def test_rates_are_limited_to_those_of_the_part(run):
    async def play(record):
        assert (record.get("VELO"), record.get("VBAS"), record.get("VMAX")) == (1000, 100, 10_000)
        assert record.get("ACCL") == pytest.approx(0.0961, abs=1e-4)
        await record.put("VELO", 2004)  # it counts in tens
        assert record.get("VELO") == 2000
        with pytest.raises(UsageError, match=r"allowed 1\.\.1000"):
            await record.put("VELO", 1e6)
        await record.put("VBAS", 200)
        assert (record.get("VELO"), record.get("VBAS")) == (2000, 200)

    run(play)


def test_refusals_are_reported(run):
    async def play(record):
        with pytest.raises(UsageError):
            await record.fields["VELO"].write(1e6)
        with pytest.raises(UsageError):
            await record.fields["JAR"].write(-1.0)
        for key, value, says in (
            ("TWV", float("inf"), "expected a finite number"),
            ("VAL", float("nan"), "expected a finite number"),
            ("DIR", 2, "allowed "),
            ("DIR", "Up", "allowed "),
        ):
            with pytest.raises(UsageError, match=f"{key} .*; {says}"):
                await record.fields[key].write(value)
        assert record.get("SEVR") == "NO_ALARM"

    record = run(play)
    assert [text.partition(": refused: ")[0] for text in record.said] == [
        *("m1.VELO 1000000.0", "m1.JAR -1.0", "m1.TWV inf", "m1.VAL nan", "m1.DIR 2", "m1.DIR Up")
    ]


def test_a_zero_resolution_and_an_endless_unit_are_refused():
    with pytest.raises(UsageError, match="expected units per step"):
        MotorRecord("m1", lambda: None, 0)
    for units in ("x" * 16, "\u03bcm"):
        with pytest.raises(UsageError, match="allowed up to 15 Latin-1 characters"):
            MotorRecord("m1", lambda: None, units=units)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("", "record name '': empty; allowed 1 to 55 letters, digits and _ - + : ; < > [ ] { }, without a field"),
        ("lab:m1.VAL", "record name 'lab:m1.VAL': names the field 'VAL'; allowed 1 to 55 letters"),
        ("lab:m1.VAL", "without a field name; write lab:m1"),
        ("lab:m1.", "ends in a dot; allowed 1 to 55 letters"),
        (".VAL", "'.' at character 1; "),
        ("lab m1", "' ' at character 4; allowed 1 to 55 letters"),
        ("lab m1", "without a field name; write lab_m1"),
        ("lab\tm1", "'\\t' at character 4"),
        ("lab:'m1'", "write lab:_m1_"),
        ("$(P)m1", "write _P_m1"),
        ("m\u00f6tor", "write m_tor"),
        ("m" * 56, "56 characters; allowed 1 to 55 letters"),
    ],
)
def test_a_name_that_no_record_can_have_is_refused_before_the_module_is_looked_for(name, says):
    with pytest.raises(UsageError) as raised:
        MotorRecord(name, lambda: pytest.fail("looked for"))
    assert says in str(raised.value)


@pytest.mark.parametrize("name", ["m" * 55, "XF:11{Det:1-Ax:X}Mtr", "a;b<c>[1]", "2m_1+"])
def test_a_name_that_records_have_is_taken(name):
    record = MotorRecord(name, lambda: motor_at("slewline://gs-c200s?chs=0"))
    record.close()
    assert name in record.channels and record.posted["NAME"] == name[:39]


# ------------------------------------------------------------------------------------------------------------- failures
def test_a_command_that_is_refused_fails_the_put_without_an_alarm(run):
    async def play(record):
        ramp = record.state.ramps["move"]
        ramp.values = {**ramp.values, "R": 5000}
        with pytest.raises(RefusedCommand, match="R5000"):
            await record.put("VAL", 10)
        assert (record.get("SEVR"), record.get("DMOV"), record.get("RBV")) == ("NO_ALARM", 1, 0)
        ramp.values = {**ramp.values, "R": 50}
        await record.put("VAL", 10)
        assert record.get("RBV") == 10

    run(play)


def test_a_port_that_is_gone_is_an_alarm_until_it_is_back(run, monkeypatch):
    monkeypatch.setattr(labs, "RETRY_S", 0.01)
    found = []

    def again(url, part, values):
        found.append(url)
        if 1 < len(found) < 4:
            raise PortLost("still gone")
        return motor_at(url, part, values)

    async def play(record):
        record.find = lambda: again("slewline://gs-c200s?chs=0", "gs-c200s", GSC)
        await record.put("VAL", 100)
        await record.put("VELO", 2000)
        put = asyncio.create_task(record.put("VAL", 50_000))
        while not record.get("MOVN"):
            await asyncio.sleep(0)
        record.motor.module.port.line.close()
        with pytest.raises(PortLost):
            await put
        assert (record.get("STAT"), record.get("SEVR"), record.get("DMOV")) == ("COMM", "INVALID", 1)
        assert int(record.get("MSTA")) & 0x1200 == 0x1200
        assert record.fields["VAL"].alarm.severity == 3
        with pytest.raises(UsageError, match="does not answer"):
            await record.put("VAL", 5)
        found.append("")
        while record.get("SEVR") != "NO_ALARM":
            await asyncio.sleep(0.005)
        assert not int(record.get("MSTA")) & 0x1000
        await record.put("VAL", 60)
        assert record.chip.position == record.get("RBV") == 60
        assert record.get("VELO") == 2000 == record.state.ramps["move"].top

    record = run(play)
    assert record.said[-1] == "m1: the module answers again"


@pytest.mark.system
def test_a_motor_at_rest_is_queried_for_its_position(run, monkeypatch):
    monkeypatch.setattr(labs, "RETRY_S", 10)

    async def play(record):
        looks = asyncio.create_task(record.check(0.005))
        for line in ("Po", "S10", "T100", "R50", "+20", "E"):  # by somebody else
            record.motor.module.ask(line)
        while record.get("RBV") != 20:
            await asyncio.sleep(0.005)
        assert record.get("VAL") == 20
        record.motor.module.port.line.close()
        while record.get("SEVR") != "INVALID":
            await asyncio.sleep(0.005)
        looks.cancel()

    run(play)


# ------------------------------------------------------------------------------------------------------------- clients
SCRIPT = """
import epics
LONG = {"timeout": 60, "connection_timeout": 60}
def get(name): return epics.caget(name, use_monitor=False, **LONG)
def put(name, value): return epics.caput(name, value, wait=True, **LONG)
"""


async def rest_gone(tasks):
    """What caproto leaves of clients ends."""
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    await asyncio.sleep(0.05)


@contextmanager
def served(module, monkeypatch, **more):
    """A record of a module, served in a thread."""
    port = str(free_port())
    for name in ("EPICS_CA_SERVER_PORT", "EPICS_CAS_SERVER_PORT"):
        monkeypatch.setenv(name, port)
    monkeypatch.setenv("EPICS_CA_ADDR_LIST", "127.0.0.1")
    monkeypatch.setenv("EPICS_CA_AUTO_ADDR_LIST", "NO")
    monkeypatch.setenv("EPICS_CA_REPEATER_PORT", str(free_port()))
    monkeypatch.setenv("EPICS_CAS_BEACON_ADDR_LIST", "127.0.0.1")
    monkeypatch.setenv("EPICS_CAS_AUTO_BEACON_ADDR_LIST", "NO")
    said, began, loop = [], threading.Event(), asyncio.new_event_loop()
    record = MotorRecord("m1", lambda: motor_at(module.url), say=said.append, **more)

    def begins(port):
        record.where = port
        began.set()

    record.began = begins
    task = loop.create_task(serve(record, interfaces(), record.began, 0.2))
    thread = threading.Thread(target=lambda: loop.run_until_complete(task), daemon=True)
    thread.start()
    assert began.wait(PATIENCE)
    record.said = said
    try:
        yield record
    finally:
        loop.call_soon_threadsafe(task.cancel)
        thread.join(PATIENCE)
        assert not thread.is_alive()
        loop.run_until_complete(rest_gone(asyncio.all_tasks(loop)))
        loop.close()


@pytest.fixture
def clients():
    """Start clients."""
    pytest.importorskip("epics")
    started = []

    def start(script):
        started.append(Client(SCRIPT + script, sys.executable))
        return started[-1]

    yield start
    for client in started:
        client.end()


@pytest.mark.system
def test_clients_of_epics_have_a_whole_session(clients, monkeypatch):
    """One moves, tweaks, stops; the other one watches; a third one dies in a put, and the motion goes on."""
    module = running("gs-c200s", straps={"chs": 0}, rate=20)
    with served(module, monkeypatch) as record:
        watcher = clients(
            "seen = []\n"
            "dmov = epics.PV('m1.DMOV', callback=lambda value, **_: seen.append(value))\n"
            "tell(dmov.wait_for_connection(60))\n"
            "while seen[-2:] != [0, 1]: time.sleep(0.01)\n"
            "tell(get('m1.RBV'), get('m1.RTYP'), get('m1.EGU'))\n"
            "input()\n"
            "tell(put('m1', 19_000), get('m1.RBV'))\n"
        )
        assert watcher.told() == [True]
        mover = clients(
            "val, dmov = epics.PV('m1.VAL'), epics.PV('m1.DMOV')\n"
            "tell(val.wait_for_connection(60) and dmov.wait_for_connection(60), val.units, val.upper_ctrl_limit)\n"
            "ok = val.put(3000, wait=True, timeout=60)\n"
            "tell(ok, get('m1.DMOV'), get('m1.RBV'))\n"
            "input()\n"
            "val.put(-900_000, wait=False)\n"
            "while get('m1.DMOV'): time.sleep(0.01)\n"
            "tell(put('m1.STOP', 1), get('m1.DMOV'))\n"
            "tell(put('m1.VELO', 5000), get('m1.VELO'))\n"
            "tell(epics.PV('m1.RBV').wait_for_connection(60) and epics.PV('m1.RBV').write_access)\n"
        )
        assert mover.told() == [True, "steps", 8388607.0]
        assert mover.told() == [1, 1, 3000.0]
        assert watcher.told() == [3000.0, "motor", "steps"]
        mover.go_on()
        assert mover.told() == [1, 1]
        assert -900_000 < module.position < 3000
        assert mover.told() == [1, 5000.0]
        assert mover.told() == [False]

        dying = clients("put('m1', 20_000)\n")
        until(lambda: record.fields["VAL"].value == 20_000)
        os.kill(dying.process.pid, signal.SIGKILL if hasattr(signal, "SIGKILL") else signal.SIGTERM)
        until(lambda: record.fields["RBV"].value == 20_000 and record.fields["DMOV"].value)
        assert module.position == 20_000
        watcher.go_on()
        assert watcher.told() == [1, 19_000.0]
    assert [found.code for found in module.chip.findings] == []
    module.close()


def wishes():
    """What moves the motor, if it is heard."""
    import caproto

    cid, priority, version = 0, 0, caproto.DEFAULT_PROTOCOL_VERSION
    messages = [
        caproto.VersionRequest(priority, version),
        caproto.HostNameRequest("here"),
        caproto.ClientNameRequest("me"),
        caproto.CreateChanRequest("m1", cid, version),
        caproto.WriteRequest((900,), caproto.ChannelType.DOUBLE, 1, 0, 0),
    ]
    return b"".join(bytes(message) for message in messages)


@pytest.mark.system
@pytest.mark.parametrize(
    "begins", [b"", b"POST / HTTP/1.1\r\nContent-Length: 30000\r\n\r\n"], ids=["client", "browser"]
)
def test_a_browser_moves_nothing(begins, monkeypatch):
    """Its first words are a header of Channel Access with a length, behind which a page may put what it wishes."""
    module = running("gs-c200s", straps={"chs": 0}, rate=20)
    taken = 16 + int.from_bytes(begins[2:4], "big") if begins else 0
    with served(module, monkeypatch) as record, socket.create_connection(("127.0.0.1", record.where)) as browser:
        browser.settimeout(PATIENCE)
        browser.sendall(begins.ljust(taken, b"x") + wishes())
        if begins:
            with suppress(OSError):
                while browser.recv(4096):  # until it is hung up on
                    pass
            time.sleep(0.3)
            assert not record.fields["RBV"].value and not record.fields["MOVN"].value
        else:
            until(lambda: record.fields["RBV"].value > 0)
    module.close()


def test_it_listens_on_this_machine_only_unless_configured_otherwise(monkeypatch):
    monkeypatch.delenv("EPICS_CAS_INTF_ADDR_LIST", raising=False)
    assert interfaces() == ["127.0.0.1"]
    monkeypatch.setenv("EPICS_CAS_INTF_ADDR_LIST", "10.0.0.1 127.0.0.1")
    assert interfaces() == ["10.0.0.1", "127.0.0.1"]
