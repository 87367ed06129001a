"""A host that stops or dies, a line that damages, a board that loses its count: what the emulated board and all say."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

import slewline
from slewline.drive.board.wire import BoardState, Happening
from tests.drive.families import SCRIPTS, furnished
from tests.ensembles import few, members

from .chain import WITHIN_TICKS, EmulatedLine, drive_of, events, off, said, unharmed, wanted

pytestmark = pytest.mark.system

AGAIN = {  # what a host sends for 50 more steps, by part
    "cy525": "N 50\rG\r",
    "gs-c200s": "I3\rPo\rS100\rT200\rR255\r+50\rPx\rE\r",
    "cy545": "N 50\rG\r",
    "mc1451a": "SET_VEL 1000 steps/s\nSET_ACC 20000 steps/s2\nSET_POS 50\nUPDATE",
}
STREAMS = ["cy525 top", "gs-c200s to 10 k", "cy545 to 27 k", "mc1451a to 45 k"]
GUESS = ("mc1451a",)  # its supply has stopped it: what it had is lost


def codes(x):
    """The findings of a chip."""
    return [found.code for found in x.findings]


def kinds(line):
    """What the board told, in order."""
    return [each.kind for each in events(line)]


def damaged(seed, chance):
    """A line that hits a byte now and then: it is lost, doubled, or another one."""
    random = Random(f"damage {seed}")

    def damage(data):
        out = bytearray()
        for byte in data:
            if random.random() >= chance:
                out.append(byte)
                continue
            what = random.randrange(4)
            if what == 0:
                continue
            if what == 1:
                out.append(byte)
            out.append((byte ^ 1 << random.randrange(8)) if what == 2 else random.choice((0, 255, byte ^ 85)))
        return bytes(out)

    return damage


@pytest.mark.parametrize("name", few(STREAMS, 2))
def test_a_host_that_is_stopped_for_500_ms(emulator, name):
    bench, x, host, _ = furnished(name)
    line = EmulatedLine(emulator, 11)
    with drive_of(bench, x, line) as drive:
        drive.run("450 ms")
        due, _ = wanted(drive)
        line.stop_host(500)
        board, made = line.board, np.array(line.board.rises)
        dry, halted = [each for each in events(line) if each.kind not in (Happening.BOOT, Happening.REST)]
        assert (dry.kind, halted.kind) == (Happening.UNDERRUN, Happening.HALTED)
        # up to the instant at which it ran dry each step is the model's; behind it is a way down, down to the halt
        until = int((made <= dry.tick).sum())
        assert dry.position == until and np.abs(made[:until] - due[:until]).max() <= WITHIN_TICKS
        way_down = np.diff(made[until - 2 :])
        assert (np.diff(way_down) >= -1).all() and len(way_down) > 5  # -1: fractions of a tick
        stands = min(drive._state.config.start_stop, made[1] - made[0])
        assert way_down[-1] > 0.8 * stands  # as slow as it began
        assert halted.tick == made[-1]
        assert halted.position == len(made)
        assert 1.18e6 < dry.tick - line.tick(line.now - 500_000_000) < 1.7e6  # a horizon later
        drive.run("400 ms")
        assert drive.state == "halted" and "underrun" in codes(x)
        assert len(board.rises) == len(made) == said(line).position
        assert ("position-uncertain" in codes(x)) == (x.sheet.part in GUESS)
        host.send(AGAIN[x.sheet.part])
        drive.run("200 ms")
        assert len(board.rises) == len(made)  # nothing moves
        drive.clear()
        assert drive.state == "ok" and said(line).state == BoardState.IDLE
        goes_on(drive, line, host)


def goes_on(drive, line, host, steps=50):
    """The host moves on, and chip and motor agree."""
    x, before = drive.chip, sum(way for _, way in line.board.steps)
    travel, count = drive._state.axis.travel, len(line.board.rises)
    drive.run("100 ms")
    if drive._state.axis.travel == travel:
        host.send(AGAIN[x.sheet.part])
        drive.run("1 s")
    drive.run_until_rest()
    moved = drive._state.axis.travel - travel
    assert moved and sum(way for _, way in line.board.steps) - before == moved
    assert len(line.board.rises) - count == abs(moved)
    position = said(line).position
    assert (position - drive._state.count_origin - drive._state.axis.travel) % 2**32 == 0


@pytest.mark.parametrize("name", few(STREAMS, 2))
def test_a_line_that_damages_one_frame_in_a_hundred_loses_no_step(emulator, name):
    bench, x, _, _ = furnished(name)
    line = EmulatedLine(emulator, 12)
    with drive_of(bench, x, line) as drive:
        line.damage = damaged(name, 0.01 / 30)  # frames have some 30 bytes
        drive.run("900 ms")
        assert drive.state == "ok" and not drive.troubles, drive.troubles
        assert np.abs(off(drive, line)).max() <= WITHIN_TICKS
        line.damage = unharmed


@members("seeds", 1, 12)
@pytest.mark.parametrize("name", few(STREAMS, 2))
def test_a_line_that_damages_one_byte_in_a_hundred_is_slow_or_dry_and_the_count_is_exact(emulator, name, seeds):
    dry = 0
    for seed in seeds:
        bench, x, host, _ = furnished(name)
        line = EmulatedLine(emulator, seed)
        with drive_of(bench, x, line, horizon="250 ms") as drive:
            line.damage = damaged(f"{name} {seed}", 0.01)
            drive.run("800 ms")
            line.damage = unharmed
            assert drive._path.link.damaged and drive._path.link.resent
            if drive.state == "ok":
                if drive.troubles:  # its first frames were damaged, again and again: all of it is made, later
                    assert [each.split(":")[0] for each in drive.troubles] == ["late-start"]
                    drive.run("600 ms")
                    assert drive.state == "ok"
                assert np.abs(off(drive, line)).max() <= WITHIN_TICKS
                continue
            dry += 1
            drive.run("600 ms")
            assert next(code for code in codes(x) if code != "late-start") == "underrun" and drive.state == "halted"
            assert said(line).position == len(line.board.rises) and said(line).state == BoardState.HALT
            due, _ = wanted(drive)
            until = events(line)[1]
            made = np.array(line.board.rises)
            made = made[made <= until.tick]
            assert until.kind == Happening.UNDERRUN and np.abs(made - due[: len(made)]).max() <= WITHIN_TICKS
            drive.clear()
            goes_on(drive, line, host)
    print(f"{name}: {dry} of {len(seeds)} dry")


@members("seeds", 3, 203)
def test_a_host_that_is_killed_at_any_instant(emulator, seeds):
    for seed in seeds:
        random = Random(f"killed {seed}")
        name = random.choice(STREAMS)
        bench, x, _, seconds = furnished(name)
        line = EmulatedLine(emulator, seed)
        drive = drive_of(bench, x, line)
        drive.open()
        drive.run(int(random.uniform(0.01, min(seconds, 1.2)) * 1e12))
        line.stop_host(2_500)  # nobody says anything any more, and a way down may be long
        made = np.array(line.board.rises)
        last = said(line)
        assert last.position == len(made)
        moved = Happening.UNDERRUN in kinds(line)
        assert last.state == (BoardState.HALT if moved else BoardState.IDLE)
        if moved and len(made) > 2:
            assert np.diff(made)[-1] > 14_000 or len(made) < 60  # it came down before it stood
        line.stop_host(300)
        assert len(line.board.rises) == len(made)
        # the next one opens the port without a reset, and is told how it is
        again = slewline.Bench()
        part, options, text, _ = SCRIPTS[name]
        y = again.add(part, name="x", **options)
        host = again.host(y, over="serial") if part == "cy545" else again.host(y)
        with drive_of(again, y, line) as drive:
            assert said(line).state == BoardState.IDLE
            host.send(text)
            drive.run("60 ms")
            drive.run("150 ms")
            found = ["board-went-on"] * bool(last.position)  # one that was killed before a step has left nothing
            assert drive.state == "ok" and [each.split(":")[0] for each in drive.troubles] == found
            assert len(line.board.rises) > len(made)


@pytest.mark.parametrize("name", few(STREAMS, 2))
def test_a_board_that_is_reset_has_lost_its_count_and_reports_it(emulator, name):
    bench, x, host, _ = furnished(name)
    line = EmulatedLine(emulator, 13)
    with drive_of(bench, x, line) as drive:
        drive.run("450 ms")
        line.reset()
        drive.run("700 ms")
        assert not line.board.rises  # nothing moves
        assert not drive._state.axis.moving
        assert drive.state == "unknown" and codes(x)[0] == "board-reset"
        host.send(AGAIN[x.sheet.part])
        drive.run("200 ms")
        assert not line.board.rises and said(line).state != BoardState.RUN
        drive.clear()
        assert drive.state == "ok" and said(line).state == BoardState.IDLE
        goes_on(drive, line, host)


@pytest.mark.parametrize("off_ms", [150, 1900])
def test_a_board_whose_supply_is_pulled(emulator, off_ms):
    bench, x, host, _ = furnished("cy525 top")
    line = EmulatedLine(emulator, 14)
    with drive_of(bench, x, line) as drive:
        drive.run("450 ms")
        line.pull()
        drive.run(f"{off_ms} ms")
        assert drive.state in ("ok", "halted") or "board-reset" in codes(x)
        line.supply()
        drive.run("700 ms")
        assert not line.board.rises and not drive._state.axis.moving
        assert drive.state == "unknown" and "board-reset" in codes(x)
        if off_ms > 500:
            assert codes(x).count("board-silent") == 1
        drive.clear()
        goes_on(drive, line, host)
