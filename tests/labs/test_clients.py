"""A motor record as its clients have it: ophyd, ophyd-async, bluesky and pyepics themselves, on a served module."""

from __future__ import annotations

import os
import signal
import time
from contextlib import contextmanager

import pytest

pytest.importorskip("caproto")
pytest.importorskip("serial")

from slewline.labs.field_table import FIELDS
from slewline.testing.endpoints import running
from tests.labs.clients import ASYNC, EPICS, OPHYD, Client, need
from tests.labs.test_epics import served
from tests.links.conftest import until

pytestmark = pytest.mark.system


@pytest.fixture
def clients():
    """Start clients."""
    need()
    started = []

    def start(script):
        started.append(Client(script))
        return started[-1]

    yield start
    for client in started:
        client.end()


@pytest.fixture
def served_at(monkeypatch):
    """Serve the record of a module that is so many times as fast as real time."""

    @contextmanager
    def serve(rate=20, **more):
        module = running("gs-c200s", straps={"chs": 0}, rate=rate)
        try:
            with served(module, monkeypatch, **more) as record:
                yield record, module
        finally:
            module.close()

    return serve


def test_every_field_is_found_with_its_type(clients, served_at):
    names = ["m1_able.VAL" if row.name == "_able" else f"m1.{row.name}" for row in FIELDS]
    script = f"names = {names}\n" + (
        "pvs = [epics.PV(name) for name in names]\n"
        "tell([pv.pvname for pv in pvs if not pv.wait_for_connection(40)])\n"
        "tell([pv.type.removeprefix('time_') for pv in pvs])\n"
        "tell([pv.get() is None for pv in pvs].count(True))\n"
    )
    with served_at():
        client = clients(EPICS + script)
        assert client.told() == [[]]
        assert client.told() == [[row.kind for row in FIELDS]]
        assert client.told() == [0]


def test_ophyd_has_a_whole_session(clients, served_at):
    session = """
tell(motor.limits, motor.egu, motor.position, motor.moving, motor.precision)
done = motor.move(500, wait=True, timeout=40)
tell(done.success, motor.position, motor.read()["motor"]["value"], motor.user_setpoint.get())
tell(sorted(motor.describe()), sorted(motor.read_configuration()))
motor.set_lim(-1000, 2000)
until(lambda: motor.limits == (-1000, 2000))
try: motor.move(3000)
except Exception as refused: tell(type(refused).__name__)
motor.set_current_position(0)
until(lambda: motor.position == 0 and motor.limits == (-1500, 1500))
tell(motor.position, motor.user_offset.get(), motor.set_use_switch.get(), motor.limits)
moving = motor.move(1400, wait=False)
until(lambda: motor.moving)
motor.stop()
until(lambda: moving.done and motor.position == motor.user_setpoint.get())
tell(0 <= motor.position < 1400, motor.motor_done_move.get(use_monitor=False))
motor.velocity.put(2000, wait=True)
tell(motor.velocity.get(use_monitor=False))
"""
    with served_at() as (_, module):
        client = clients(OPHYD + session)
        assert client.told() == [[-8388608, 8388607], "steps", 0, False, 0]
        assert client.told() == [True, 500, 500, 500]
        assert client.told() == [
            ["motor", "motor_user_setpoint"],
            ["motor_acceleration", "motor_motor_egu", "motor_user_offset", "motor_user_offset_dir", "motor_velocity"],
        ]
        assert client.told() == ["LimitError"]
        assert client.told() == [0, -500, 0, [-1500, 1500]]
        assert module.position == 500
        assert client.told() == [True, 1]
        assert client.told() == [2000]


def test_ophyd_homes(clients, served_at):
    session = (
        "tell(motor.move(40, wait=True, timeout=40).success)\n"
        "input()\n"
        "tell(motor.home('reverse', wait=True, timeout=40).success)\n"
        "until(lambda: motor.position == 0 == motor.user_setpoint.get())\n"
        "tell(motor.home_reverse.get(use_monitor=False))\n"
    )
    with served_at() as (_, module):
        client = clients(OPHYD + session)
        assert client.told() == [True]
        for switch in ("eot", "home"):
            module.pin(switch).drive(0)
        client.go_on()
        assert client.told() == [True]
        assert client.told() == [0]
        assert module.position == 0


SCAN = """
from bluesky import RunEngine, plans
engine, seen = RunEngine({}), []
def note(name, document):
    if name == "event": seen.append(document["data"][motor.name])
engine.subscribe(note)
"""


def test_bluesky_scans_eleven_points(clients, served_at):
    with served_at() as (_, module):
        client = clients(OPHYD + SCAN + "engine(plans.scan([], motor, -100, 400, 11))\ntell(seen)\n")
        assert client.told() == [[float(point) for point in range(-100, 401, 50)]]
        assert module.position == 400


def test_bluesky_scans_eleven_points_by_ophyd_async(clients, served_at):
    script = SCAN + (
        "from ophyd_async.core import init_devices\n"
        "with init_devices(timeout=40): motor = Motor('ca://m1', name='motor')\n"
        "engine(plans.scan([], motor, -100, 400, 11))\n"
        "tell(seen)\n"
    )
    with served_at() as (_, module):
        assert clients(ASYNC + script).told() == [[float(point) for point in range(-100, 401, 50)]]
        assert module.position == 400


def test_ophyd_async_has_a_whole_session(clients, served_at):
    session = """
from aioca import CANothing, caput
from ophyd_async.core import FlyMotorInfo
async def session():
    await motor.connect(timeout=40)
    await motor.set(500)
    where = await motor.locate()
    tell(where["setpoint"], where["readback"], await motor.output_link.get_value() != "")
    moving = motor.set(300_000)
    while await motor.motor_done_move.get_value(): await asyncio.sleep(0.01)
    await motor.stop(success=True)
    await moving
    while not await motor.motor_done_move.get_value(): await asyncio.sleep(0.01)
    where = await motor.locate()
    tell(0 < where["readback"] < 300_000, where["setpoint"] == where["readback"])
    await motor.high_limit_travel.set(400_000)
    try: await motor.set(500_000)
    except Exception as refused: tell(type(refused).__name__)
    await motor.set_use_switch.set(UseSetMode.SET)
    await motor.user_setpoint.set(100.0)
    await motor.set_use_switch.set(UseSetMode.USE)
    tell(await motor.user_readback.get_value())
    await motor.offset_freeze_switch.set(OffsetMode.FROZEN)
    await motor.velocity.set(2000)
    try: await caput("m1.VELO", 1e9, wait=True)
    except CANothing as refused: tell(str(refused))
    tell(await motor.velocity.get_value())
    await motor.prepare(FlyMotorInfo(start_position=0, end_position=2000, time_for_move=2))
    await motor.kickoff()
    await motor.complete()
    tell(await motor.user_readback.get_value() > 2000, await motor.velocity.get_value())
asyncio.run(session())
"""
    with served_at() as (_, module):
        client = clients(ASYNC + session)
        assert client.told() == [500, 500, True]
        assert client.told() == [True, True]
        assert client.told() == ["MotorLimitsError"]
        assert client.told() == [100]
        assert client.told() == ["m1.VELO: Channel write request failed"]
        assert client.told() == [2000]
        assert client.told() == [True, 1000]
    assert [found.code for found in module.chip.findings] == []


def test_pyepics_has_a_whole_session(clients, served_at):
    session = """
begun = time.monotonic()
motor = epics.Motor("m1")
tell(motor.drive, motor.units, motor.disabled, time.monotonic() - begun)
begun = time.monotonic()
tell(motor.move(300, wait=True, timeout=40), motor.readback, time.monotonic() - begun < 15)
ways = (10, {"relative": True}), (50, {"dial": True}), (-20, {"raw": True})
tell(*(motor.move(to, wait=True, **how) for to, how in ways))
until(lambda: motor.get("RBV") == -20)
tell(motor.get_position(readback=True), motor.get_position(readback=True, raw=True))
motor.put("TWV", 25, wait=True)
tell(motor.tweak(wait=True))
until(lambda: motor.get_position(readback=True) == 5)
for field, value in (("HLM", 400), ("LLM", -400)):
    motor.put(field, value, wait=True)
    until(lambda: motor.get(field) == value)
tell(motor.within_limits(500), motor.move(500, wait=True), motor.move(500, wait=True, ignore_limits=True))
motor.set_position(0)
until(lambda: motor.get("OFF") == -5 and motor.get("RBV") == 0 and not motor.get("SET"))
tell(motor.get("RBV"), motor.get("DRBV"), motor.get("OFF"))
motor.put("HLM", 400_000, wait=True)
motor.PV("JOGF").put(1, wait=False)
until(lambda: motor.get("MOVN"))
time.sleep(0.1)
motor.PV("JOGF").put(0, wait=True, timeout=40)
until(lambda: motor.get("DMOV") and motor.get("VAL") == motor.get("RBV"))
tell(0 < motor.get("RBV") < 399_000)
motor.move(300_000)
until(lambda: motor.get("MOVN"))
motor.stop()
until(lambda: motor.get("DMOV") and motor.get("VAL") == motor.get("RBV"))
tell(0 < motor.get("RBV") < 300_000)
"""
    with served_at() as (_, module):
        client = clients(EPICS + session)
        *seen, took = client.told()
        assert seen == [0, "steps", 0]
        assert took < 20
        print(f"a motor of pyepics is there after {took:.1f} s")
        assert client.told() == [0, 300, True]
        assert client.told() == [0, 0, 0]
        assert client.told() == [-20, -20]
        assert client.told() == [0]
        assert client.told() == [False, -12, -4]
        assert client.told() == [0, 5, -5]
        assert client.told() == [True]
        assert client.told() == [True]
    assert [found.code for found in module.chip.findings] == []


def test_puts_as_spec_sends_them(clients, served_at):
    """SPG to Go, then VAL without a wait, and DMOV is watched; a pause by SPMG; the position set by SET and DVAL."""
    session = """
def get(name): return epics.caget(name, use_monitor=False, timeout=40)
def put(name, value, wait=True): return epics.caput(name, value, wait=wait, timeout=40, connection_timeout=40)
seen = []
dmov = epics.PV("m1.DMOV", callback=lambda value, **_: seen.append(value))
dmov.wait_for_connection(40)
until(lambda: seen)
put("m1.SPMG", "Go")
put("m1.VAL", 800, wait=False)
until(lambda: seen[-2:] == [0, 1])
tell(seen, get("m1.RBV"))
put("m1.VAL", 100_000, wait=False)
until(lambda: get("m1.MOVN"))
put("m1.SPMG", "Pause")
tell(get("m1.MOVN"), get("m1.DMOV"), get("m1.VAL"), get("m1.RBV") < 100_000)
put("m1.STOP", 1)
put("m1.SPMG", "Go")
put("m1.SET", "Set"); put("m1.DVAL", -50); put("m1.SET", "Use")
put("m1.DESC", "slit, top"); put("m1.EGU", "mm")
tell(get("m1.DESC"), get("m1.EGU"), epics.caget("m1.STAT", as_string=True), epics.PV("m1.VELO").get_ctrlvars()["units"])
tell(get("m1.DRBV"), get("m1.RRBV"), get("m1.DMOV"), get("m1.VAL") == get("m1.RBV"))
"""
    with served_at() as (_, module):
        client = clients(EPICS + session)
        assert client.told() == [[1, 0, 1], 800]
        assert client.told() == [0, 0, 100_000, True]
        assert client.told() == ["slit, top", "mm", "NO_ALARM", "mm/sec"]
        assert client.told() == [-50, -50, 1, True]
        assert module.position == -50


def test_a_move_takes_the_time_of_the_module_and_little_more(clients, served_at):
    """In real time; the fields that were missing have cost twenty seconds a move."""
    session = (
        "took = []\n"
        "for target in (500, 0):\n"
        "    begun = time.monotonic()\n"
        "    motor.move(target, wait=True, timeout=40)\n"
        "    took.append(time.monotonic() - begun)\n"
        "    time.sleep(0.2)\n"
        "tell(min(took))\n"
    )
    with served_at(rate=1) as (record, _):
        module_s = record.state.ramps["move"].move(500).time_ps / 1e12
        for begin in (OPHYD + "motor.settle_time = 0\n", EPICS + "motor = epics.Motor('m1')\n"):
            (took,) = clients(begin + session).told()
            print(f"the move {module_s:.3f} s, with the client {took:.3f} s")
            assert module_s <= took < module_s + 8


def test_two_clients_and_one_that_is_killed(clients, served_at):
    """One moves and dies, another one sees the end of its motion, and goes on."""
    watching = OPHYD + (
        "ends = []\n"
        "motor.subscribe(lambda **_: ends.append(motor.position), event_type='done_moving', run=False)\n"
        "tell('ready')\n"
        "until(lambda: ends)\n"
        "tell(ends)\n"
        "time.sleep(0.2)\n"
        "tell(motor.move(100, wait=True, timeout=40).success, motor.position)\n"
    )
    with served_at() as (record, module):
        watcher = clients(watching)
        assert watcher.told() == ["ready"]
        dying = clients(EPICS + "epics.caput('m1', 20_000, wait=True, timeout=60, connection_timeout=40)\n")
        until(lambda: record.fields["MOVN"].value)
        os.kill(dying.process.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
        assert watcher.told() == [[20_000]]
        assert watcher.told() == [True, 100]
        assert module.position == 100
        time.sleep(0.1)
