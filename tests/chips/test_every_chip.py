"""What every part on the list has to do, whatever it is: a suite over PARTS, in which no part has a test of its own.

Each family has one short dialogue, a run script; everything else is asked of the chip's public face.
"""

from __future__ import annotations

import re

import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.chips import PARTS, sheet_of
from slewline.core.datasheet.option import checked, read
from slewline.core.memory.store import Memory
from slewline.parts.hosts.bus_host import BusHost
from slewline.parts.hosts.flow_host import FlowHost
from slewline.parts.hosts.packet_host import PacketHost
from tests.ensembles import in_long_runs
from tests.options import wrong_options

DIALOGUES = {
    "letters": "A 0\nF 20\nR 60\nS 250\nZ 1\nE\nN 30\nG\nD 3\nB\nP 0\n0\nQX\n",
    "verbatim": "A 0\nF 20\nR 60\nS 250\nN 30\n+\nG\nD 3\nB 16\nP 5\nL 1,9\nN 12\nG\n",
    "lines": "{enter}\nS20\nT100\nR5\nA1\n+30\nD1\n-12\nE\n",
    "packets": "SET_VEL 0x10000\nSET_ACC 0x800\nSET_POS 40\nUPDATE\nSET_BRK_PNT 20\nGET_POS\nGET_STATUS\n",
}
OWN = {  # of parts whose letters differ from those of their family
    "cy500": "A\nF 2\nR 253\nS 20\nH\nL\nE\nN 30\nG\nB\nO\nP 0\nC\nN 12\nG\n0\nQD\n",
    "cy512": "A\nR 250\nS 20\nH\nE\nN 30\nG\nX 3\nB\nP 0\nO 5\nN 3\nG\n0\nQD\n",
}
ENTER = {"gs-c200": "P", "gs-c200s": "Po"}
FAST_LINE = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
CLOCKS = ("clk15", "clkout")
LONG = "3 s"  # every dialogue is over by then
SHORT_FORM = 2  # instants of a dialogue at which `make test` resets and cuts the power


def family(part):
    sheet = sheet_of(part)
    return sheet.dialect.name


def dialogue(part):
    return OWN.get(part, DIALOGUES[family(part)]).format(enter=ENTER.get(part, ""))


def furnished(part, journal=None, **options):
    """A bench with one chip, x."""
    bench = slewline.Bench(journal=journal)
    bench.add(part, name="x", straps=FAST_LINE if family(part) == "lines" else None, **options)
    return bench


def played(part, journal=None, **options):
    """The same behind its dialogue."""
    bench = furnished(part, journal, **options)
    run_script(bench, bench.host(bench["x"]), dialogue(part))
    bench.run(LONG)
    return bench


def told(bench, since=0):
    """What a bench tells of x; times count from `since`."""
    x = bench["x"]
    axes = [x.axis(number) for number in range(1, len(x.axes) + 1)]
    steps = [axis.steps(since) for axis in axes]
    return {
        "times": [(one.times_ps - since).tolist() for one in steps],
        "directions": [one.directions.tolist() for one in steps],
        "positions": [one.positions.tolist() for one in steps],
        "registers": dict(x.registers),
        "program": bytes(x.program),
        "levels": {name: pin.level for name, pin in x.pins.items() if name not in CLOCKS},
        "findings": [(found.time_ps - since, found.code) for found in x.findings if found.time_ps >= since],
        "idle": x.idle,
    }


def stack(task):
    """Where a task waits: every function of its chain of awaits, with its line."""
    found, frame = [], task.coroutine if task is not None else None
    while frame is not None and getattr(frame, "cr_frame", None) is not None:
        found.append((frame.cr_code.co_qualname, frame.cr_frame.f_lineno))
        frame = frame.cr_await
    return tuple(found)


def places(part):
    """The first instant of each place at which the chip waits in its dialogue: where its task awaits, what it says."""
    bench = furnished(part)
    x = bench["x"]
    run_script(bench, bench.host(x), dialogue(part))
    seen = {}

    def look():
        text = re.sub(r"[\d.]+ ?(ps|ns|us|ms|s)\b|\d+", "#", x.waiting.split("; ")[0])
        where = stack(x.task) if x.task is not None else tuple(pin.level for pin in x.pins.values())  # calls, no task
        seen.setdefault((where, text), bench.now_ps)
        return bench.now_ps > 10**12 and x.idle

    bench.run_until(look, timeout=LONG)
    return sorted(seen.values())


def fall_silent(host):
    """End the host's program: it lets go of its lines and forgets what it still had to say."""
    if isinstance(host, (FlowHost, BusHost)):
        host.clear()
        return
    host.queue.requests.clear()
    if host.queue.task is not None:
        host.queue.task.kill()
    for driver in host.drivers.values():
        driver.drive(None)
    if isinstance(host, PacketHost):
        host._rest()
    else:
        host.uart.outgoing.clear()


def restart(bench, how):
    """Reset x, or switch its supply off and on; a part without a reset input has its supply switched."""
    x = bench["x"]
    if how == "reset" and family(x.sheet.part) != "lines":
        x.reset()
    else:
        x.power(False)
        bench.run("1 ms")
        x.power(True)
    bench.run("100 ms")


def second_dialogue(part, how, first=None):
    """The dialogue after a restart of a part at rest; `first`: another dialogue was restarted in there before that."""
    bench = furnished(part)
    host = bench.host(bench["x"])
    if first is not None:
        run_script(bench, host, dialogue(part))
        bench.run_to(f"{first} ps")
        fall_silent(host)
        restart(bench, how)
    bench.run_to("5 s")
    restart(bench, how)
    since = bench.now_ps
    x = bench["x"]
    at_rest = bytes(x.program), {name: pin.level for name, pin in x.pins.items() if name not in CLOCKS}, x.idle
    run_script(bench, host, dialogue(part))
    bench.run(LONG)
    return told(bench, since) | {"at rest": at_rest}


every_part = pytest.mark.parametrize("part", PARTS)
FIRST = {row.folder: part for part, row in reversed(PARTS.items())}.values()  # of those that share a folder
every_kind = pytest.mark.parametrize("part", [part if part in FIRST else in_long_runs(part) for part in PARTS])


@every_part
def test_registers_are_the_rows_of_the_sheet(part):
    x = furnished(part)["x"]
    assert list(x.registers) == [row.name for row in x.sheet.registers]


@every_part
def test_options_are_the_rows_of_the_sheet_and_hold_what_is_given(part):
    rows = sheet_of(part).options
    x = furnished(part)["x"]
    assert vars(x.options) == checked("x", rows, {})
    assert {row.name for row in rows} >= {"stepwise", "cold"}
    assert furnished(part, cold=True)["x"].options.cold is True


@every_part
def test_unknown_and_ill_typed_options_are_refused_without_a_trace(part, tmp_path):
    path = tmp_path / "x.jsonl"
    bench = slewline.Bench(journal=path)
    for options, says in wrong_options(sheet_of(part).options):
        with pytest.raises(slewline.UsageError, match=f"x: {says}"):
            bench.add(part, name="x", **options)
    assert not bench.chips
    bench.add(part, name="x")
    bench.run("1 us")
    assert [chip.name for chip in slewline.replay(path).chips.values()] == ["x"]


def other(row):
    """A whole number that is allowed and not the default."""
    return row.low if row.low != row.default else row.default + 1


@every_part
def test_options_come_as_text_and_from_a_bench_file_as_from_python(part, tmp_path):
    rows = [row for row in sheet_of(part).options if row.kind in ("bool", "int")]
    given = {row.name: not row.default if row.kind == "bool" else other(row) for row in rows}
    assert read(rows, [(name, str(value)) for name, value in given.items()]) == given
    path = tmp_path / "x.toml"
    told = ", ".join(f"{name} = {str(value).lower()}" for name, value in given.items())
    path.write_text(f'[[chip]]\npart = "{part}"\noptions = {{ {told} }}\n')
    (x,) = slewline.load(path).chips.values()
    assert vars(x.options) | given == vars(x.options)


@every_part
def test_memory_kept_without_power_is_an_option(part):
    stores = []
    bench = slewline.Bench(stores=lambda name: stores.append(Memory(b"")) or stores[-1])
    x = bench.add(part, name="x")
    assert sheet_of(part).keeps == hasattr(x.options, "store") == bool(stores)
    assert not stores or x.store is stores[0]


@every_part
def test_the_dialogue_moves_the_motor_and_ends_idle(part):
    bench = played(part)
    assert len(bench["x"].steps()) >= 40 and bench["x"].idle, told(bench)


@every_kind
def test_fast_path_and_twin_agree_on_the_dialogue(part):
    fast, slow = told(played(part)), told(played(part, stepwise=True))
    assert fast == slow


@every_kind
def test_a_journal_replays(part, tmp_path):
    path = tmp_path / "x.jsonl"
    recorded = told(played(part, path))
    assert told(slewline.replay(path)) == recorded


@every_part
def test_axis_1_is_the_axis(part):
    x = played(part)["x"]
    one = x.axis(1)
    assert one.position == x.position and one.travel == x.travel
    assert one.steps().times_ps.tolist() == x.steps().times_ps.tolist()
    assert one.position_at(x.kernel.now) == x.position_at(x.kernel.now)
    with pytest.raises(slewline.errors.UnknownName):
        x.axis(len(x.axes) + 1)


@every_kind
def test_a_host_that_connects_late_is_served(part):
    bench = furnished(part)
    bench.run("400 ms")
    since = bench.now_ps
    run_script(bench, bench.host(bench["x"]), dialogue(part))
    bench.run(LONG)
    late = told(bench, since)
    early = furnished(part)
    host = early.host(early["x"])
    early.run("400 ms")
    run_script(early, host, dialogue(part))
    early.run(LONG)
    assert late == told(early, since) and len(bench["x"].steps()) >= 40


@every_part
def test_waiting_has_the_task_and_its_start_time_and_a_timeout_repeats_it(part):
    bench = furnished(part)
    x = bench["x"]
    run_script(bench, bench.host(x), dialogue(part))
    bench.run_until(lambda: len(x.steps()) >= 10)
    assert re.fullmatch(r"x: .+ since [\d.]+ (us|ms|s)( .*)?", x.waiting), x.waiting
    with pytest.raises(slewline.Timeout) as caught:
        bench.run_until(lambda: False, timeout="1 us")
    assert x.waiting in str(caught.value)


@pytest.mark.parametrize("how", ["reset", "power"])
@every_kind
def test_a_restart_in_the_dialogue_leaves_no_trace(part, how):
    found = places(part)
    expected = second_dialogue(part, how)
    assert sum(map(len, expected["times"])) >= 40
    for first in found[:: -(-len(found) // SHORT_FORM)]:
        assert second_dialogue(part, how, first) == expected, first


@pytest.mark.long
@pytest.mark.parametrize("how", ["reset", "power"])
@every_part
def test_a_restart_at_every_await_of_the_dialogue_leaves_no_trace(part, how):
    expected = second_dialogue(part, how)
    for first in places(part):
        for after in (0, 1):
            assert second_dialogue(part, how, first + after) == expected, (first, after)
