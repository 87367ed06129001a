"""A drive whose bench is served: the board's crystal is the clock of the pace."""

from __future__ import annotations

import pytest

from slewline.drive.board.wire import BoardState
from slewline.links.lines.pace import Paced

from .families import furnished
from .rig import HZ, MS_NS, TwinLine, check_steps, drive_of


class Served:
    """A loop such as that of the server, in the time of a line."""

    def __init__(self, name, ppm=0, **options):
        self.bench, self.x, self.host, self.seconds = furnished(name)
        self.line = TwinLine(ppm=ppm)
        self.drive = drive_of(self.bench, self.x, self.line, **options)
        self.drive.open()
        self.pace = Paced(self.bench, 1, clock=self.drive.nanoseconds)
        self.pace.start()

    def serve(self, ms):
        end = self.line.now + ms * MS_NS
        while self.line.now < end:
            while not self.pace.pass_time():
                pass
            self.drive.turn()
            self.line.wait(min(self.drive.due(), self.pace.pause() or 1))
            self.pace.present()


@pytest.mark.parametrize("ppm", [-5000, 0, 5000])
def test_steps_are_made_a_horizon_later(ppm):
    each = Served("cy525 top", ppm)
    each.serve(2800)
    steps, made = check_steps(each.drive, each.line)
    assert len(steps) == len(made) == 20_000 and each.line.twin.state == BoardState.IDLE
    # a second of the model is one of the board
    board = (each.line.tick(each.line.now) - each.line.tick(5_000_000_000)) / HZ
    assert abs(each.bench.now_ps / 1e12 - board) < 0.05


def test_a_server_that_was_paused_is_aligned_again():
    each = Served("cy525 five steps")
    each.serve(400)
    each.pace.pause_time()
    each.serve(700)
    each.pace.go()
    each.host.send("G\r")
    each.serve(400)
    assert len(each.line.twin.steps) == 10 and not each.drive.troubles
    assert each.drive.state == "ok"


@pytest.mark.parametrize(("more_ms", "aligned"), [(20, False), (26, True), (60, True)])
def test_a_model_at_rest_that_is_late_by_more_than_a_quarter_of_the_horizon_is_aligned(more_ms, aligned):
    bench, x, _, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, horizon="100 ms") as drive:
        drive.run_until_rest()
        late = drive._path.clock.ticks(line.wall()) - (drive._path.ticks.at(bench.now_ps) >> 16)
        assert 0 <= late / (HZ / 1000) < 4
        line.pass_to(line.now + more_ms * MS_NS)  # nothing runs the bench
        drive.turn()
        assert (drive._path.ticks.at(bench.now_ps) >> 16 == drive._path.clock.ticks(line.wall())) is aligned


def test_a_drive_at_rest_has_little_to_do_and_wakes_when_its_host_speaks():
    each = Served("cy525 five steps")
    each.serve(600)
    turns, turn = [], each.drive.turn
    each.drive.turn = lambda: (turns.append(each.line.now), turn())
    woken = []
    each.drive.on_wake.add(lambda: woken.append(each.line.now))
    each.serve(5000)
    assert len(turns) < 40 and not woken and each.drive._path.link.at_rest
    each.host.send("G\r")
    assert woken and not each.drive._path.link.at_rest
    each.serve(400)
    assert len(each.line.twin.steps) == 10 and not each.drive.troubles


def test_a_drive_at_rest_whose_driver_is_on_turns_only_at_its_heartbeats():
    each = Served("cy525 five steps", enable=True, driver="A4988", enable_off="rest", enable_hold="60 s")
    each.serve(600)
    turns, turn, asked = [], each.drive.turn, []
    each.drive.turn = lambda: (turns.append(each.line.now), asked.append(each.line.twin.last_frame), turn())
    each.serve(5000)
    assert len(turns) < 400 and each.drive._path.link.at_rest
    assert len(set(asked)) > 45 and each.drive.power.on  # a message every 100 ms
    each.host.send("G\r")
    each.serve(400)
    assert len(each.line.twin.steps) == 10 and not each.drive.troubles
