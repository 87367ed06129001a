"""The recorder against nets driven by hand, and against an observer that is told of every change."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from itertools import pairwise
from random import Random

import numpy as np
import pytest

from slewline.core.datasheet.table import Pin
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Driver, Net, Wave
from slewline.core.wires.pin import Terminal
from slewline.errors import NotRecorded, TimeError
from slewline.record.recording.recorder import TRIM_FROM, EdgeLog, chunks
from tests.rows import rows

MHZ = Clock(1_000_000)


def test_edges_are_the_changes_and_the_first_level_is_none(rig):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.on(5, x_slew=0)
    rig.on(9, x_slew=1)
    rig.kernel.run(20)
    assert rig.edges("x.slew") == [(5, 0), (9, 1)]
    times, levels = rig.recorder.edges(rig.nets["x.slew"], 0, 20)
    assert times.dtype == np.int64
    assert levels.dtype == np.int8


@pytest.mark.parametrize(
    ("start", "stop", "expected"),
    [(5, 9, [(5, 0), (9, 1)]), (6, 9, [(9, 1)]), (5, 8, [(5, 0)]), (6, 8, []), (9, 9, [(9, 1)]), (9, 5, [])],
)
def test_window_includes_both_ends(rig, start, stop, expected):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.on(5, x_slew=0)
    rig.on(9, x_slew=1)
    rig.kernel.run(20)
    assert rig.edges("x.slew", start, stop) == expected


def test_a_change_undone_within_an_instant_is_not_an_edge(rig):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.on(5, x_slew=0)
    rig.on(5, x_slew=1)
    rig.on(7, x_slew=0)
    rig.on(7, x_slew=1)
    rig.on(7, x_slew=0)
    assert rig.edges("x.slew") == [(7, 0)]


def test_driving_what_is_there_is_no_edge(rig):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.on(5, x_slew=1)
    rig.on(6, x_slew=None)
    rig.on(7, x_slew=0)
    rig.on(8, x_slew=0)
    assert rig.edges("x.slew") == [(7, 0)]


def test_floating_is_minus_one(rig):
    rig.recorder.record(rig.net("x.prog"))
    rig.on(3, x_prog=1)
    rig.on(4, x_prog=None)
    rig.kernel.run(5)
    assert rig.edges("x.prog") == [(3, 1), (4, -1)]
    assert [rig.recorder.level(rig.nets["x.prog"], ps) for ps in (0, 2, 3, 4, 5)] == [-1, -1, 1, -1, -1]


def test_pulse_of_a_train_to_the_picosecond(rig):
    rig.recorder.record(rig.net("x.pulse", pull=1))
    # at 11 MHz: begins at ticks 10, 110, 210 and 270, the end at 330; high for 28 ticks before each begin but the first
    rig.on(1000, x_pulse=rig.pulses(Clock(11_000_000), 10, (100, 2), (60, 2)))
    rig.kernel.run(40_000_000)
    ticks = [(10, 0), (82, 1), (110, 0), (182, 1), (210, 0), (242, 1), (270, 0), (302, 1)]
    assert rig.edges("x.pulse") == [(tick * 1_000_000 // 11, level) for tick, level in ticks]
    assert rig.recorder.level(rig.nets["x.pulse"], 909_089) == 1
    assert rig.recorder.level(rig.nets["x.pulse"], 909_090) == 0


def test_withdrawn_promise_ends_before_its_bound(rig):
    rig.recorder.record(rig.net("x.pulse", pull=1))
    view = rig.pulses(MHZ, 1, (10, 100), high=2)
    rig.on(0, x_pulse=view)
    rig.kernel.run(10_000_000)
    view.of.until = 11_000_000  # exactly at the begin of the second step, which does not come
    rig.on(30_000_000, x_pulse=1)
    rig.kernel.run(90_000_000)
    assert rig.edges("x.pulse") == [(1_000_000, 0), (9_000_000, 1)]


def test_nothing_past_the_last_committed_instant(rig):
    net = rig.net("x.pulse", pull=1)
    rig.recorder.record(net)
    rig.on(0, x_pulse=rig.pulses(MHZ, 1, (10, 100), high=2))
    rig.kernel.run(11_000_000)
    assert rig.edges("x.pulse") == [(1_000_000, 0), (9_000_000, 1), (11_000_000, 0)]
    assert rig.recorder.level(net, 1 << 60) == 0
    seen = []
    # in round 1 everything still reads as it was before the instant
    rig.at(19_000_000, lambda: seen.append((rig.edges("x.pulse")[-1], rig.recorder.level(net, 19_000_000))))
    rig.kernel.run(19_000_000)
    assert seen == [((11_000_000, 0), 0)]
    assert rig.edges("x.pulse")[-1] == (19_000_000, 1)


def test_recording_that_begins_under_a_promise(rig):
    net = rig.net("x.pulse", pull=1)
    rig.on(0, x_pulse=rig.pulses(MHZ, 1, (10, 100), high=2))
    rig.kernel.run(15_000_000)
    rig.recorder.record(net)
    rig.kernel.run(22_000_000)
    assert rig.recorder.level(net, 15_000_000) == 0
    assert rig.edges("x.pulse", 15_000_000) == [(19_000_000, 1), (21_000_000, 0)]


def test_recording_that_begins_inside_an_instant_has_the_edges_of_that_instant(rig):
    net = rig.net("x.slew", pull=1)
    rig.at(50, lambda: rig.recorder.record(net))
    rig.at(50, lambda: rig.drivers["x.slew"].drive(0))
    rig.kernel.run(60)
    assert rig.recorder.since(net) == 49
    assert rig.edges("x.slew", 49) == [(50, 0)]


def test_recording_that_begins_under_two_drivers(rig):
    net = rig.net("x.pulse", pull=1)
    second = Driver(net, "second")
    rig.on(0, x_pulse=rig.pulses(MHZ, 1, (10, 2), high=2))
    second.drive(1)
    rig.kernel.settle()
    rig.kernel.run(15_000_000)
    rig.recorder.record(net)  # the low of the first driver wins
    second.drive(None)
    rig.kernel.run(17_000_000)
    second.drive(1)
    rig.kernel.run(30_000_000)
    assert rig.edges("x.pulse", 15_000_000) == [(19_000_000, 1)]


def test_two_drivers_with_an_unreported_promise(rig):
    net = rig.net("x.pulse", pull=1)
    second = Driver(net, "second")
    rig.on(0, x_pulse=rig.pulses(MHZ, 1, (10, 3), high=2))
    second.drive(1)
    rig.kernel.settle()
    rig.kernel.run(2_000_000)
    rig.recorder.record(net)  # only now does anybody follow the promise
    rig.kernel.run(40_000_000)
    assert rig.edges("x.pulse", 2_000_000) == [(n * 1_000_000, n in (9, 19, 29)) for n in (9, 11, 19, 21, 29)]


def test_recording_that_begins_while_a_promise_is_overridden(rig):
    net = rig.net("x.pulse", pull=1)
    second = Driver(net, "second")
    rig.on(0, x_pulse=rig.pulses(MHZ, 1, (10, 3), high=2))
    second.drive(0)
    rig.kernel.settle()
    rig.kernel.run(9_500_000)  # the promise is high
    rig.recorder.record(net)
    rig.kernel.run(25_000_000)
    assert rig.edges("x.pulse", 9_500_000) == []
    assert rig.recorder.level(net, 9_500_000) == 0
    second.drive(None)
    rig.kernel.run(40_000_000)
    assert rig.edges("x.pulse", 9_500_000) == [(29_000_000, 1)]


def test_promise_that_lets_go_rests_on_the_pull(rig):
    rig.recorder.record(rig.net("x.wait", pull=1))
    rig.recorder.record(rig.net("x.prog", tie=0))
    rig.on(10, x_wait=Wave(0, (20, 30), (None, 0)), x_prog=Wave(1, (20, 30), (None, 1)))
    rig.kernel.run(40)
    assert rig.edges("x.wait") == [(10, 0), (20, 1), (30, 0)]
    assert rig.edges("x.prog") == [(10, 1), (20, 0), (30, 1)]
    assert rig.recorder.level(rig.nets["x.wait"], 25) == 1


def test_bus_and_its_wires(rig):
    bus = rig.bus("x.db")
    rig.recorder.record(bus)
    rig.on(10, x_db=(0xFF, 0x2A))
    rig.on(20, x_db=(0x0F, 0x05))
    rig.on(25, x_db=(0x0F, 0x05))
    rig.on(30, x_db=None)
    rig.on(40, x_db=Wave((0xFF, 0), (45,), (None,)))
    rig.kernel.run(50)
    assert rig.edges("x.db") == [(10, 0x2A), (20, 0xF5), (30, -1), (40, 0), (45, -1)]
    assert rig.recorder.edges(bus, 0, 50)[1].dtype == np.int16
    expected = {1: [(10, 1), (20, 0), (30, -1), (40, 0), (45, -1)], 7: [(10, 0), (20, -1), (40, 0), (45, -1)]}
    for bit, edges in expected.items():
        pin = Terminal("x", Pin(12 + bit, f"db{bit}", "both", "bus"), bus)
        pin.bit = bit
        times, levels = rig.recorder.edges(pin, 0, 50)
        assert list(zip(times.tolist(), levels.tolist(), strict=True)) == edges
        assert levels.dtype == np.int8
        assert rig.recorder.level(pin, 22) == {1: 0, 7: -1}[bit]


@rows("seed", range(40))
def test_recorder_agrees_with_an_observer(lively, seed):
    rig = lively(seed)
    watched = lively(seed)
    differences: dict[str, list[tuple[int, int]]] = {name: [] for name in watched.nets}

    def tell(net: Net) -> None:
        level = net.level
        if level is None:
            level = -1
        elif isinstance(level, tuple):
            level = (level[1] | ~level[0]) & 0xFF
        differences[net.name].append((net.kernel.now, level))

    for net in watched.nets.values():
        net.watch(tell)
    rig.kernel.run(80_000_000)
    watched.kernel.run(80_000_000)
    assert sum(map(len, differences.values())) > 30
    for name, heard in differences.items():
        last = dict(heard)  # of each instant the last one
        first = rig.recorder.level(rig.nets[name], 0)
        real, before = [], first
        for time, level in last.items():
            if level != before:
                real.append((time, level))
            before = level
        assert rig.edges(name) == [edge for edge in real if edge[0] > 0 or edge[1] != first], name


@rows("seed", range(10))
def test_windows_add_up(lively, seed):
    rig, random = lively(seed), Random(seed)
    rig.kernel.run(80_000_000)
    for name, net in rig.nets.items():
        whole = rig.edges(name)
        cuts = sorted({0, 80_000_001, *(random.randrange(80_000_000) for _ in range(20)), *(t for t, _ in whole[::3])})
        parts = [edge for a, b in pairwise(cuts) for edge in rig.edges(name, a, b - 1)]
        assert parts == whole
        level = rig.recorder.level(net, 0)
        for time, after in whole:
            assert rig.recorder.level(net, time - 1) == level
            assert rig.recorder.level(net, time) == after
            level = after


@pytest.mark.parametrize("unit", [1, 1000, 7_000_000])
def test_chunks_end_with_whole_units_and_add_up(lively, unit, monkeypatch):
    monkeypatch.setattr("slewline.record.recording.recorder.FIRST_CHUNK_PS", 100_000)
    monkeypatch.setattr("slewline.record.recording.recorder.CHUNK_EDGES", 4)
    rig = lively(3)
    rig.kernel.run(80_000_000)
    nets = list(rig.nets.values())
    asked = []
    edges = rig.recorder.edges
    monkeypatch.setattr(rig.recorder, "edges", lambda net, a, b: asked.append((a, b)) or edges(net, a, b))
    found = list(chunks([partial(rig.recorder.edges, net) for net in nets], 5, 80_000_000, unit))
    assert [sum(len(chunk[n][0]) for chunk in found) for n in range(len(nets))] == [
        len(edges(net, 5, 80_000_000)[0]) for net in nets
    ]
    windows = sorted(set(asked))
    assert len(windows) > 8
    assert windows[0][0] == 5
    assert windows[-1][1] == 80_000_000
    assert all(b + 1 == c and (b + 1) % unit == 0 for (_, b), (c, _) in pairwise(windows))


def test_unwatched_promise_costs_the_kernel_nothing(rig):
    rig.recorder.record(rig.net("x.pulse", pull=1))
    rig.on(0, x_pulse=rig.pulses(MHZ, 1, (10, 1_000_000_000), high=2))
    assert rig.kernel.next_time() is None
    rig.kernel.run(10**12)
    assert len(rig.nets["x.pulse"].log) == 1
    assert len(rig.edges("x.pulse", 10**12 - 19_999_999)) == 4


# ----------------------------------------------------------------------------------------------- keeping and forgetting
def test_not_recorded_suggests_a_remedy(rig):
    net = rig.net("x.slew", pull=1)
    for question in (
        lambda: rig.edges("x.slew"),
        lambda: rig.recorder.level(net, 0),
        lambda: rig.recorder.since(net),
    ):
        with pytest.raises(
            NotRecorded, match=r"^x\.slew is not recorded; call bench\.record\('x\.slew'\) before running$"
        ):
            question()


def test_before_the_recording_began(rig):
    net = rig.net("x.slew", pull=1)
    rig.kernel.run(3_000_000)
    rig.recorder.record(net)
    assert rig.edges("x.slew", 3_000_000) == []
    with pytest.raises(
        NotRecorded, match=r"^x\.slew at 2 µs: recorded from 3 µs on; call bench\.record\('x\.slew'\) earlier$"
    ):
        rig.edges("x.slew", 2_000_000)


def test_keep_forgets_to_the_picosecond_whenever_the_log_was_trimmed(rig):
    net = rig.net("x.slew", pull=1)
    rig.recorder.record(net, 1000)
    for n in range(1, 5001):
        rig.on(10 * n, x_slew=n % 2)
        if n > 100:
            assert rig.recorder.since(net) == 10 * n - 1000
            if n % 97 == 0:
                assert rig.edges("x.slew", 10 * n - 1000) == [(10 * m, m % 2) for m in range(n - 100, n + 1)]
                assert rig.recorder.level(net, 10 * n - 1000) == n % 2
                with pytest.raises(NotRecorded, match="or with a longer keep than '1 ns'"):
                    rig.edges("x.slew", 10 * n - 1001)
    assert len(net.log) < 2 * TRIM_FROM


@pytest.mark.parametrize("seed", range(5))
def test_keep_leaves_kept_data_unchanged(lively, seed, monkeypatch):
    monkeypatch.setattr("slewline.record.recording.recorder.TRIM_FROM", 4)
    whole, kept = lively(seed, events=300), lively(seed, events=300, keep=5_000_000)
    for now in range(1_000_000, 70_000_000, 1_000_000):
        whole.kernel.run(now)
        kept.kernel.run(now)
        for name, net in kept.nets.items():
            since = kept.recorder.since(net)
            assert since == max(0, now - 5_000_000)
            assert kept.edges(name, since) == whole.edges(name, since)
    assert any(len(kept.nets[name].log) < len(net.log) / 2 for name, net in whole.nets.items())


def test_second_call_sets_the_new_keep_and_loses_nothing(rig):
    net = rig.net("x.slew", pull=1)
    rig.recorder.record(net)
    rig.on(5, x_slew=0)
    rig.on(9, x_slew=1)
    rig.recorder.record(net, 3)
    rig.kernel.run(10)
    assert rig.edges("x.slew", 7) == [(9, 1)]
    assert rig.recorder.since(net) == 7
    rig.recorder.record(net)
    assert rig.edges("x.slew") == [(5, 0), (9, 1)]


def grown(hours: float, keep: int) -> int:
    """The longest that a log becomes when 12 entries come every 10 ms."""
    log, longest = EdgeLog(keep), 0
    for number in range(int(hours * 3600 * 100 * 12)):
        log.append((number * 10**10 // 12, number & 1))
        if len(log) > longest:
            longest = len(log)
    assert log[0][0] < log[-1][0] - keep
    return longest


def test_endless_run_does_not_eat_memory():
    assert grown(1 / 60, 10**12) < 3 * 1200 + 10


@pytest.mark.long
def test_an_hour_does_not_eat_memory():
    assert grown(1, 10**12) < 3 * 1200 + 10


def test_an_array_ends_after_106_days(rig):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.kernel.run(1 << 63)
    with pytest.raises(TimeError, match="106 days"):
        rig.edges("x.slew", 0, 1 << 64)
    assert rig.edges("x.slew", 0, (1 << 63) - 1) == []


@pytest.mark.system
def test_import_loads_neither_numpy_nor_matplotlib():
    modules = [
        *(f"recording.{name}" for name in ("recorder", "export_csv", "export_npz", "outlines")),
        *(f"pictures.{name}" for name in ("figures", "lanes", "marks", "picture_files", "cursors")),
        *("waveforms.vcd", "measuring.measure"),
    ]
    code = "import sys; " + "".join(f"import slewline.record.{m}; " for m in modules)
    code += "print([m for m in ('numpy', 'matplotlib') if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "[]\n"
