"""Streams of all families through the whole chain: each step at its instant, in its direction, none lost or made up."""

from __future__ import annotations

import numpy as np
import pytest

import slewline
from slewline.drive.board.wire import BoardState
from tests.drive.families import SCRIPTS, furnished

from .chain import (
    HZ,
    TICKS_A_US,
    WITHIN_TICKS,
    EmulatedLine,
    dir_times,
    drive_of,
    off,
    phase_lags,
    pulse_widths,
    said,
)
from .emulated import PHASES_WITHIN

FASTEST = {  # steps/s that a stream must come to, by name
    "cy525 top": 9_600,
    "gs-c200s to 10 k": 9_900,
    "cy545 to 27 k": 26_900,
    "mc1451a to 45 k": 44_900,
    "mc1451a endless": 29_900,
}
SHORT = {  # part of a text, what it is instead, seconds
    "cy525 top": ("N 20000", "N 3500", 0.75),
    "gs-c200s to 10 k": ("+8000", "+4000", 0.55),
    "cy545 to 27 k": ("N 30000", "N 9000", 0.95),
    "mc1451a to 45 k": ("SET_POS 60000", "SET_POS 14000", 0.5),
}
STEP_LEAST, STEP_MOST = 80, 640  # ticks, of a pulse
DIR_LEAST = 320  # ticks: 20 us, set-up and hold
OUTPUTS_WITHIN_US = 60


def shortened(name):
    """A bench with a chip whose host has queued a short form of a stream: bench, chip, host, seconds."""
    part, options, text, _ = SCRIPTS[name]
    old, new, seconds = SHORT[name]
    text = text.replace("200000 steps/s2", "400000 steps/s2")
    assert old in text
    text = text.replace(old, new)
    bench = slewline.Bench()
    x = bench.add(part, name="x", **options)
    host = bench.host(x, over="serial") if part == "cy545" else bench.host(x)
    host.send(text)
    return bench, x, host, seconds


def check(drive, line, name=""):
    """All that must be so behind a stream."""
    assert drive.state == "ok" and not drive.troubles, drive.troubles
    worst = np.abs(off(drive, line)).max()
    assert worst <= WITHIN_TICKS, worst
    board = line.board
    assert not board.overruns
    least, most = pulse_widths(board)
    assert least >= STEP_LEAST and most <= STEP_MOST, (least, most)
    assert min(dir_times(board)) >= DIR_LEAST, dir_times(board)
    if name in FASTEST:
        fastest = HZ / np.diff(board.rises).min()
        assert fastest >= FASTEST[name], fastest
    if drive.chip.idle:
        last = said(line)
        assert len(board.rises) == len(drive.chip.steps())
        assert last.position == drive.chip.travel == sum(way for _, way in board.steps)
        assert last.state == BoardState.IDLE


QUICK = "gs-c200s to 10 k"  # the one that every run makes


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.real("emulator") if n == QUICK else pytest.mark.system) for n in SHORT]
)
def test_a_short_stream(emulator, name):
    bench, x, _, seconds = shortened(name)
    line = EmulatedLine(emulator, 1)
    with drive_of(bench, x, line) as drive:
        drive.run(f"{int(seconds * 1000) + 130} ms")
        check(drive, line, name)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", SCRIPTS)
def test_a_whole_stream_while_the_host_pauses(emulator, name, seed):
    bench, x, _, seconds = furnished(name)
    line = EmulatedLine(emulator, seed, ppm=(300, -5000, 5000)[seed], pauses=((0, 0), (0.02, 45), (0.05, 25))[seed])
    with drive_of(bench, x, line) as drive:
        drive.run(f"{int(seconds * 1000) + 150} ms")
        check(drive, line, name)


@pytest.mark.system
def test_moves_in_a_row_to_and_fro(emulator):
    bench, x, _, _ = furnished("gs-c200s moves in a row")
    line = EmulatedLine(emulator, 2, pauses=(0.02, 30))
    with drive_of(bench, x, line) as drive:
        drive.run("1500 ms")
        check(drive, line)
        assert len(line.board.directions) >= 3


@pytest.mark.system
def test_slow_steps(emulator):
    bench, x, _, _ = furnished("cy525 program of slow steps")
    line = EmulatedLine(emulator, 3, pauses=(0.02, 30))
    with drive_of(bench, x, line) as drive:
        drive.run("900 ms")
        check(drive, line)
        assert len(line.board.rises) > 5


@pytest.mark.system
def test_new_rates_of_a_cy525_on_the_fly(emulator):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    host.send("A 0\rF 40\rR 60\rS 255\rZ 1\rN 60000\rH\rG\r")
    line = EmulatedLine(emulator, 4, pauses=(0.02, 30))
    with drive_of(bench, x, line) as drive:
        for rate in (110, 75):
            drive.run("300 ms")
            host.request_rate("x", rate)
        drive.run("300 ms")
        x.pin("abort").drive(0)
        drive.run_until_rest()
        check(drive, line)
        intervals = np.diff(line.board.rises)
        assert intervals[300:].min() < 0.7 * intervals[200]  # it was faster in between


@pytest.mark.system
def test_new_velocities_of_an_mc1451a_on_the_fly(emulator):
    bench, x, host, _ = furnished("mc1451a endless")
    line = EmulatedLine(emulator, 5, pauses=(0.02, 30))
    with drive_of(bench, x, line) as drive:
        for velocity in (10_000, 20_000, 0):
            drive.run("250 ms")
            host.send(f"SET_VEL {velocity} steps/s\nUPDATE" if velocity else "SET_VEL 0\nUPDATE")
        drive.run_until_rest()
        check(drive, line)


# ------------------------------------------------------------------------------------------------------------- outputs
@pytest.mark.system
@pytest.mark.parametrize("name", ["cy525 to and fro", "gs-c200s moves in a row"])
def test_outputs_of_programs_change_in_order_with_the_steps(emulator, name):
    bench, x, _, seconds = furnished(name)
    line = EmulatedLine(emulator, 6)
    changed = []
    with drive_of(bench, x, line) as drive:
        for net, number in drive._state.nets():
            net.watch(lambda net, number=number: changed.append((bench.now_ps, number, net.level)))
        drive.run(f"{int(seconds * 1000) + 150} ms")
        check(drive, line)
        due = [
            (drive._path.ticks.at(ps) / 65536 + drive._state.horizon, number, level) for ps, number, level in changed
        ]
        in_progress = [row for row in due if line.board.rises[0] < row[0] < line.board.rises[-1]]
        assert in_progress, due
        made, before = [], 0
        for tick, value in line.board.outputs:
            made += [(tick, n, value >> n & 1) for n in range(4) if (value ^ before) >> n & 1]
            before = value
        for wanted in in_progress:
            late = min((tick - wanted[0] for tick, *rest in made if tuple(rest) == wanted[1:]), key=abs)
            assert abs(late) < OUTPUTS_WITHIN_US * TICKS_A_US, (late / TICKS_A_US, wanted)
        order = [each[1:] for each in made if each[0] >= in_progress[0][0] - 1000]
        assert order[: len(in_progress)] == [each[1:] for each in in_progress]


@pytest.mark.system
@pytest.mark.parametrize("part", ["cy525", "cy512"])
def test_phases_follow_each_step(emulator, part):
    bench = slewline.Bench()
    x = bench.add(part, name="x")
    host = bench.host(x)
    if part == "cy525":
        host.send("A 0\rF 20\rR 110\rS 255\rZ 1\rN 900\rG\r-\rN 30\rG\r")
    else:  # half steps
        host.send("A\rH\rF 1\rR 200\rS 40\rN 500\rG\r-\rN 31\rG\r")
    line = EmulatedLine(emulator, 7)
    shown = []
    for number in range(1, 5):
        x.pin(f"phase{number}").net.watch(lambda _net: shown.append((bench.now_ps, levels(x))))
    with drive_of(bench, x, line) as drive:
        drive.run("1200 ms" if part == "cy525" else "2500 ms")
        check(drive, line)
        assert x.idle and getattr(x.state, "half", False) is (part == "cy512")
        lags, values = phase_lags(line.board)
        assert lags.max() <= PHASES_WITHIN, lags.max() / TICKS_A_US
        assert lags.min() > 0
        model = last_at_each(shown, x.steps().times_ps)
        assert values == model


def levels(x):
    """The phases of a chip, the first one as bit 0."""
    return sum((x.pin(f"phase{n + 1}").net.level or 0) << n for n in range(4))


def last_at_each(shown, times):
    """What was shown last at each of some instants."""
    by_time = dict(shown)
    return [by_time[int(time)] for time in times]
