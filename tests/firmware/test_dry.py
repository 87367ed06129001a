"""A dry run: the board counts every step, and neither STEP nor a phase moves."""

from __future__ import annotations

from dataclasses import replace

import pytest

from slewline.drive.board.records import HALF, PAUSE, REST, Record
from slewline.drive.board.wire import BoardState, DriverFlag, FrameKind, Happening, Reflex
from tests.ensembles import members

from .dialogue import told_to_twin
from .talk import LONG, Talk
from .test_brakes import braked
from .test_rates import HALVES, HZ, Host, RestlessHost, constant, events, ramp

pytestmark = pytest.mark.system

DRY = [DriverFlag.DRY, DriverFlag.DRY | DriverFlag.ENABLE]
PHASE_PINS = 0xF0
END = Record(PAUSE | REST, 0, 300)


def nothing_moves(board):
    """STEP has no edge; pins of phases are inputs, without a pull-up; ENABLE is never on."""
    assert board.rises == board.falls == []
    assert not any((portd | ddrd) & PHASE_PINS for _, _, _, portd, ddrd in board.ports)
    assert len(board.enable) <= 1 and all(level == 0 for _, level in board.enable)


@pytest.mark.parametrize("driver", DRY)
@pytest.mark.parametrize("busy", [False, True])
@pytest.mark.parametrize("rate, steps", [(45_000, 2_000), (27_000, 800), (1_000, 40)])
def test_a_ramp_is_counted(emulator, driver, busy, rate, steps):
    records = [*ramp(HZ / rate, steps), Record(PAUSE | REST, 0, 16_000)]
    kind = (lambda *words, **more: RestlessHost(*words, seed=rate, **more)) if busy else Host
    host = kind(emulator, records, driver=driver, pattern=HALVES)
    host.start((sum(record.length for record in records) >> 16) + 100_000)
    told = [event for event in events(host.board) if event.kind not in (Happening.MARK, Happening.INPUT)]
    assert [(each.kind, each.position) for each in told] == [(Happening.REST, 2 * steps)] and not host.board.overruns
    nothing_moves(host.board)


def test_seventy_thousand_steps_a_second_are_counted(emulator):
    records = [*constant(HZ // 70_000, 0.2), Record(PAUSE | REST, 0, 16_000)]
    host = Host(emulator, records, driver=DriverFlag.DRY)
    host.start(HZ * 2 // 10 + 100_000)
    last = events(host.board)[-1]
    assert (last.kind, last.position) == (Happening.REST, sum(record.count for record in records[:-1]))
    nothing_moves(host.board)


@pytest.mark.parametrize("cause", ["underrun", "stop", "input", "watchdog", "emergency stop"])
@pytest.mark.parametrize("rate, way", [(27_000, None), (45_000, 40), (10_000, 30)])
@members("phases", 3, 100, at_once=100)
def test_a_stop_ramp_is_counted_as_the_twin_counts_it(emulator, rate, cause, way, phases):
    for phase in phases:
        length = 100 if phase % 2 else 23
        host = braked(emulator, rate, cause, phase, way, length, HALVES, driver=DRY[phase % 2])
        board = host.board
        last = {"emergency stop": Happening.ESTOP}.get(cause, Happening.HALTED)
        assert events(board)[-1].kind == last and events(board)[-1].position > 40
        twin = told_to_twin(board, host.chunks)
        assert bytes(twin.sent) == b"".join(frame for _, frame in board.frames)
        nothing_moves(board)


def test_steps_of_all_kinds_are_counted(emulator):
    talk = Talk(emulator, driver=DriverFlag.DRY, pattern=HALVES)
    talk.play(
        [Record(0, 7, 1_300), Record(1, 3, 70_000), Record(PAUSE, 0, 900), Record(HALF, 5, 1_500, 0, 99_999), END]
    )
    talk.board.run(talk.board.now + 400_000)
    assert (talk.events[-1].kind, talk.events[-1].position) == (Happening.REST, 7 - 3 + 5)
    nothing_moves(talk.board)
    assert told_to_twin(talk.board, talk.chunks).position == 9


def test_steps_are_real_again_after_a_dry_run(emulator):
    talk = Talk(emulator, driver=DriverFlag.ENABLE, pattern=HALVES, reflex=(Reflex.STOP, 0, 0, 0, 0, 0))
    for driver, rises in ((DriverFlag.ENABLE, 9), (DriverFlag.DRY, 9), (DriverFlag.ENABLE, 18)):
        talk.say(FrameKind.CONFIG, replace(talk.config, driver=driver).pack())
        talk.play([Record(0, 9, LONG), END])
        talk.board.run(talk.board.now + 12 * LONG)
        assert talk.events[-1].state == BoardState.IDLE and len(talk.board.rises) == rises
        _, _, _, portd, ddrd = talk.board.ports[-1]
        assert bool(ddrd & PHASE_PINS) == bool(portd & PHASE_PINS) == (driver == DriverFlag.ENABLE)
    assert talk.events[-1].position == 27
