"""A drive against a board of software, in virtual time: what must be so whatever host and line do."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

import slewline
from slewline.drive.board.boards import UNO
from slewline.drive.board.wire import BoardState, Happening
from slewline.errors import Timeout, UsageError
from tests.ensembles import few

from .families import SCRIPTS, furnished
from .rig import HZ, MS_NS, TwinLine, check_steps, drive_of

MS = 10**9


def codes(x):
    return [found.code for found in x.findings]


@pytest.mark.parametrize("name", few(SCRIPTS, 4))  # the feeder alone is tried with all of them
def test_streams_of_all_families(name):
    bench, x, _, seconds = furnished(name)
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run(f"{int(seconds * 1000) + 120} ms")
        steps, made = check_steps(drive, line)
        if x.idle:
            assert len(steps) == len(made) and line.twin.state == BoardState.IDLE and not drive._path.cable.in_progress
            assert line.twin.position == x.travel
        assert drive.state == "ok" and not drive.troubles


@pytest.mark.parametrize("seed", few(range(3), 1))
@pytest.mark.parametrize(
    "name", few(["cy525 to and fro", "gs-c200s moves in a row", "mc1451a to 45 k", "cy545 to 27 k"], 2)
)
def test_pauses_of_the_host_up_to_half_the_horizon(name, seed):
    rnd = Random(f"pauses {seed}")
    bench, x, _, seconds = furnished(name)
    line = TwinLine(rnd, ppm=rnd.choice((-5000, -100, 0, 100, 5000)))
    drive = drive_of(bench, x, line)
    plain = drive._talk.wait
    drive._talk.wait = lambda s: plain(rnd.random() * 0.05 if rnd.random() < 0.05 and drive.state == "ok" else s)
    with drive:
        drive.run(f"{int(seconds * 1000) + 200} ms")
        steps, made = check_steps(drive, line)
        assert len(steps) == len(made) and not drive.troubles


def test_a_command_of_a_host_on_the_fly_and_a_motion_without_end():
    bench, x, host, _ = furnished("mc1451a endless")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("500 ms")
        host.send("SET_VEL 10000 steps/s\nUPDATE")
        drive.run("500 ms")
        host.send("SET_VEL 0\nUPDATE")
        drive.run_until_rest()
        steps, made = check_steps(drive, line)
        assert len(steps) == len(made) and not drive.troubles


def test_a_drive_describes_itself_in_a_line():
    bench, x, *_ = furnished("cy525 to and fro")
    drive = drive_of(bench, x, TwinLine())
    assert repr(drive) == f"<Drive of {x.name} axis 1, {UNO.name}: closed, a dry run>"
    drive = drive_of(bench, x, TwinLine(), enable=True, driver="A4988")
    assert repr(drive) == f"<Drive of {x.name} axis 1, {UNO.name}: closed>"


def test_a_driver_that_is_enabled_without_an_e_stop_is_reported():
    for inputs, enable, says in (
        (None, True, True),
        ({"A1": "abort"}, True, True),
        ({"A0": "estop"}, True, False),
        (None, False, False),
    ):
        bench = slewline.Bench()
        driver = "A4988" if enable else None
        drive = drive_of(bench, bench.add("cy525", "x"), TwinLine(), enable=enable, driver=driver, inputs=inputs)
        assert ("no input is an E-stop (--input A0=estop)" in drive.introduction()) == says


def test_a_live_rate_of_a_cy525():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    host.send("A 0\rF 10\rR 60\rS 200\rZ 1\rN 60000\rH\rG\r")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        x.pin("abort").drive(0)
        drive.run_until_rest()
        steps, made = check_steps(drive, line)
        assert len(steps) == len(made) > 500


@pytest.mark.parametrize("driver", [None, "A4988"])
def test_the_dry_run_has_no_edges_and_gives_the_driver_no_current(driver):
    bench, x, *_ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, driver=driver, pulses=False) as drive:
        drive.run("300 ms")
        assert not line.twin.output & 16 and not line.twin.pulses
        assert drive.count == x.position == len(line.twin.steps) == 5
    assert all(not value & 16 for _, value in line.twin.outputs) and line.closed


def test_the_driver_is_on_in_a_session_that_enables_it():
    bench, x, *_ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line, enable=True, driver="A4988", pulses=False) as drive:
        assert line.twin.output & 16 and drive.power.on and drive.power.known
        drive.run("300 ms")
        assert len(line.twin.pulses) == 5
    assert not line.twin.output & 16 and line.closed


def test_nothing_is_enabled_without_the_name_of_its_driver():
    bench, x, *_ = furnished("cy525 five steps")
    with pytest.raises(UsageError, match="enable needs the name of the driver"):
        drive_of(bench, x, TwinLine(), enable=True)


# -------------------------------------------------------------------------------------------------------------- cable
def test_outputs_come_a_horizon_later_in_motion_and_immediately_at_rest():
    bench, x, _, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        heard = []
        bench.at("1 ms", lambda: drive._path.cable.send(lambda: heard.append(("before", line.twin.now))))
        x.on_motion_end.add(lambda _end: drive._path.cable.send(lambda: heard.append(("complete", line.twin.now))))
        drive.run("2 ms")
        assert [name for name, _ in heard] == ["before"]
        drive.run_until_rest()
        assert heard[1][1] >= line.twin.steps[-1][0]  # when it has stopped, not before
        end = x.motions()[0].end.time_ps
        assert 0 <= heard[1][1] - (drive._path.ticks.at(end) >> 16) - drive._state.horizon < 6 * HZ // 1000
        drive._path.cable.send(lambda: heard.append(("after", line.twin.now)))
        assert heard[-1][0] == "after"


def test_a_byte_directly_after_a_single_step_does_not_overtake_it():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.host(x).send("A 0\rF 100\rR 100\rS 255\rZ 1\rN 1\rG\r")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        heard = []
        x.on_motion_end.add(lambda _end: drive._path.cable.send(lambda: heard.append(line.twin.now)))
        drive.run_until_rest()
        assert len(line.twin.steps) == 1 and heard[0] > line.twin.steps[0][0]


def test_outputs_change_in_the_order_of_the_steps_and_at_rest_immediately():
    bench, x, host, _ = furnished("cy525 to and fro")
    line = TwinLine()
    changed = []
    x.pin("programmable_output").net.watch(lambda net: changed.append((bench.now_ps, net.level)))
    with drive_of(bench, x, line) as drive:
        drive.run_until_rest()
        made = [(tick, value & 1) for tick, value in line.twin.outputs]
        levels = [level for _, level in changed]
        assert [value for _, value in made][-len(levels) :] == levels and levels
        for (ps, _), (tick, _) in zip(changed, made[-len(levels) :], strict=True):
            assert abs(tick - (drive._path.ticks.at(ps) >> 16) - drive._state.horizon) < 1000
        before = len(line.twin.outputs)
        host.send("B\r")
        now = bench.now_ps
        drive.run("40 ms")
        (tick, value), *_ = line.twin.outputs[before:]
        assert value & 1 and tick - (drive._path.ticks.at(now) >> 16) < 20 * HZ // 1000
        check_steps(drive, line)


# ------------------------------------------------------------------------------------------------------------ troubles
def test_a_line_that_is_dead_for_a_second_stops_the_chip_and_the_count_is_taken_over_when_it_is_back():
    bench, x, host, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        line.damage = lambda data: b""
        drive.run("800 ms")
        assert "board-silent" in codes(x) and drive.state == "halted"  # nobody is told that the motor goes on
        assert not x.motor.moving
        assert "position-taken-over" not in codes(x)  # nobody knows
        made = len(line.twin.steps)
        assert line.twin.state == BoardState.HALT
        line.damage = lambda data: data
        drive.run("500 ms")
        assert codes(x).count("position-taken-over") == 1 and codes(x).count("board-silent") == 1
        assert line.twin.position == len(line.twin.steps) == made == x.position
        drive.clear()
        host.send("N 50\rG\r")
        drive.run_until_rest()
        assert line.twin.position == made + 50 == x.position


class PulledLine(TwinLine):
    """A line whose cable can be pulled, and the port with it."""

    gone = False

    def read(self):
        if self.gone:
            raise OSError(5, "Input/output error")
        return super().read()

    def wait(self, seconds):
        if self.gone:
            self.back.clear()  # nobody can read it any more, so it ends no wait
        super().wait(seconds)

    def reopen(self):
        if self.gone:
            raise UsageError("ttyX: no such port")


def test_a_cable_that_is_pulled_and_put_back_begins_a_new_life_of_the_board():
    bench, x, host, _ = furnished("cy525 top")
    line = PulledLine()
    with drive_of(bench, x, line) as drive:
        drive.run("6 s")
        line.gone = True
        drive.run("20 ms")
        assert drive.state == "unknown" and codes(x)[0] == "port-lost" and line.closed
        with pytest.raises(UsageError, match="no such port"):
            drive.clear()
        line.gone = False
        line.reset_board()
        drive.clear()
        assert drive.state == "ok"
        # The board counts its ticks from 0 again, and the model does not wait until it has as many as before.
        assert abs(drive._path.clock.ticks(line.wall()) - line.tick(line.now)) < 5 * HZ // 1000
        before = bench.now_ps
        drive.run("50 ms")
        assert bench.now_ps == before + 50 * 10**9
        host.send("A 0\rN 7\rG\r")
        drive.run_until_rest()
        assert len(line.twin.steps) == 7 == x.position


def test_a_host_that_is_stopped_for_500_ms_causes_an_underrun_and_the_count_is_exact():
    bench, x, host, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        line.pass_to(line.now + 500 * MS_NS)  # the host is stopped
        drive.run("500 ms")
        assert drive.state == "halted" and line.twin.state == BoardState.HALT
        assert codes(x)[0] in ("underrun", "host-silent") and "position-taken-over" in codes(x)
        made = np.array(line.twin.steps)
        intervals = np.diff(made[:, 0])
        assert (intervals[-30:] > intervals[-60]).all()  # a way down
        assert line.twin.position == len(made) == x.position
        host.send("G\r")
        drive.run("300 ms")
        assert len(line.twin.steps) == len(made)  # nothing moves
        assert not x.motor.moving and x.motions()[-1].end.why == "stopped"
        drive.clear()
        assert drive.state == "ok" and line.twin.state == BoardState.IDLE
        assert x.position == len(made)
        host.send("N 50\rG\r")
        drive.run_until_rest()
        assert len(line.twin.steps) == len(made) + 50 == x.position
        assert line.twin.position == len(line.twin.steps)  # the board goes on counting


def test_after_a_halt_the_chip_continues_from_the_position_of_the_motor():
    bench, x, host, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        line.pass_to(line.now + 500 * MS_NS)
        drive.run("500 ms")
        stands = line.twin.position
        drive.clear()
        drive.run("100 ms")
        host.send("P 100\r")
        drive.run_until_rest()
        assert x.position == 100
        way = sum(direction for _, direction, _ in line.twin.steps)
        assert way == 100 and stands != 100


@pytest.mark.parametrize("name", ["cy525 five steps", "cy545 to 27 k"])  # of the second more waits than the board holds
def test_a_host_that_starts_too_late_makes_the_whole_motion_later(name):
    bench, x, _, seconds = furnished(name)
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        written = line.write

        def late(data):
            if drive._path.feeder.running and not late.done:
                late.done = True
                line.pass_to(line.now + 150 * MS_NS)
            return written(data)

        late.done = False
        line.write = late
        drive.run(f"{seconds + 1} s")
        assert codes(x) == ["late-start"] and drive.state == "ok"
        drive.run_until_rest()
        assert len(line.twin.steps) == abs(x.travel)
        made, wanted = np.array(line.twin.steps)[:, 0], drive._path.ticks.many(x.steps().times_ps) >> 16
        assert np.abs(np.diff(made) - np.diff(wanted)).max() <= 18


def test_a_board_that_is_reset_has_lost_its_count_and_reports_it():
    bench, x, host, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        line.reset_board()
        drive.run("800 ms")
        assert drive.state == "unknown" and "board-reset" in codes(x)
        assert not line.twin.steps and not x.motor.moving
        drive.clear()
        assert drive.state == "ok" and line.twin.state == BoardState.IDLE
        drive.run("50 ms")
        host.send("A 0\rN 7\rG\r")
        drive.run_until_rest()
        assert len(line.twin.steps) == 7 and x.position == 7


def test_a_board_without_supply_is_silent():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("700 ms")
        line.supplied = False
        drive.run("1 s")
        (silent,) = (found for found in x.findings if found.code == "board-silent")
        assert "has not answered for 500 ms:" in silent.text
        line.reset_board()
        line.supplied = True
        drive.run("1 s")
        assert drive.state == "unknown"


def test_an_emergency_stop_at_full_rate_leaves_the_position_uncertain():
    from slewline.drive.board.wire import BoardConfig, Reflex

    config = BoardConfig(HZ // 500, HZ // 5, reflex=(0, 0, int(Reflex.ESTOP), 0, 0, 0), active=4)
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    line.twin.inputs &= ~4
    with drive_of(bench, x, line, config=config) as drive:
        drive.run("900 ms")
        line.twin.set_input(2, 1, line.tick(line.now))
        drive.run("500 ms")
        assert codes(x) == ["e-stop", "position-uncertain", "position-taken-over"]
        assert x.position == line.twin.position == len(line.twin.steps)
        with pytest.raises(UsageError, match="emergency stop"):
            drive.clear()
        line.twin.set_input(2, 0, line.tick(line.now))
        drive.clear()
        assert drive.state == "ok"


def test_below_the_start_stop_rate_it_is_certain():
    bench, x, _, _ = furnished("gs-c200s slow")
    line = TwinLine()
    with drive_of(bench, x, line, start_stop="500 steps/s") as drive:
        drive.run("600 ms")
        drive.stop(at_once=True)
        drive.run("800 ms")
        assert codes(x) == ["board-stopped", "position-taken-over"] and drive.power.known
        assert x.position == line.twin.position


def test_steps_that_are_too_fast_for_the_board_stop_it():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine(model=UNO._replace(shortest=1700))  # 9.4 k steps/s
    with drive_of(bench, x, line) as drive:
        drive.run("1 s")
        assert codes(x) == ["too-fast", "position-taken-over"] and drive.state == "halted"
        assert x.position == line.twin.position == len(line.twin.steps) > 0


def test_a_motion_whose_first_steps_are_too_fast_is_halted_and_cleared():
    bench, x, host, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive._path.feeder.shortest = 1 << 20  # the board stands, and will tell nothing
        drive.run("200 ms")
        assert codes(x)[0] == "too-fast" and drive.state == "halted" and not line.twin.steps
        drive.run("3 s")
        assert not x.moving and not line.twin.steps
        assert "position-taken-over" in codes(x) and x.position == 0
        drive._path.feeder.shortest = UNO.shortest
        drive.clear()
        assert drive.state == "ok"
        host.send("N 40\rG\r")
        drive.run_until_rest()
        assert x.position == 40 == line.twin.position


def test_an_emergency_stop_during_deceleration_may_have_cost_steps():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    line.twin.inputs = 0x3E
    with drive_of(bench, x, line, inputs={"A0": "estop"}) as drive:
        drive.run("1 s")
        drive.stop()
        for _ in range(200):
            if line.twin.state == BoardState.BRAKE:
                break
            drive.run("100 us")
        assert line.twin.state == BoardState.BRAKE
        line.twin.set_input(0, 1, max(line.tick(line.now), line.twin.now))
        drive.run("3 s")
        assert codes(x)[:3] == ["board-stopped", "e-stop", "position-uncertain"]
        assert x.position == drive.count == len(line.twin.steps)


# ---------------------------------------------------------------------------------------------------------------- line
@pytest.mark.parametrize("seed", few(range(4), 2))
def test_a_line_that_damages_one_frame_in_a_hundred_loses_no_step(seed):
    rnd = Random(f"damage {seed}")
    bench, x, _, seconds = furnished("cy525 top")
    line = TwinLine(rnd)

    def damage(data):
        out = bytearray(data)
        for at, byte in enumerate(out):
            if byte and rnd.random() < 0.0005:
                out[at] = byte ^ (1 << rnd.randrange(8)) or 1
        return bytes(out)

    with drive_of(bench, x, line) as drive:
        line.damage = damage
        drive.run(f"{int(seconds * 1000) + 200} ms")
        steps, made = check_steps(drive, line)
        assert len(steps) == len(made) == 20_000
        assert drive._path.link.damaged or drive._path.link.resent


# ---------------------------------------------------------------------------------------------------- python, refusals
def test_until_a_condition_is_met_by_the_model():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run_until(x.reaches(4000))
        assert x.position == 4000
        with pytest.raises(Timeout, match="ok"):
            drive.run_until(x.reaches(30_000), "100 ms")
        drive.run_until(lambda: x.position > 10_000)
        drive.run_until_rest()
        check_steps(drive, line)
    with pytest.raises(UsageError, match="closed"):
        drive.run("1 s")


def test_malformed_arguments_are_refused():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    for options, says in (
        ({"horizon": "1 ms"}, "allowed 10 ms to 2 s"),
        ({"stop": "pray"}, "allowed 'abort', 'reset', 'power'"),
        ({"start_stop": "fast"}, "steps per second"),
    ):
        with pytest.raises(UsageError, match=says):
            drive_of(bench, x, line, **options)
    with pytest.raises(UsageError, match="clearing it has no effect"), drive_of(bench, x, line) as drive:
        drive.clear()


def test_a_port_without_a_board():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    line.supplied = False
    with pytest.raises(
        UsageError,
        match="no board answers within 3 s; received nothing; expected the firmware of slewline on an Arduino Uno",
    ):
        drive_of(bench, x, line).open()


def test_events_of_the_board_have_listeners():
    bench, x, _, _ = furnished("cy525 five steps")
    line = TwinLine()
    heard = []
    drive = drive_of(bench, x, line)
    drive.on_event.add(heard.append)
    with drive:
        drive.run_until_rest()
    assert [event.kind for event in heard] == [Happening.REST]


def test_a_program_that_is_busy_between_two_runs_is_not_a_silent_board():
    bench, x, host, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run_until_rest()
        now = bench.now_ps
        line.pass_to(line.now + 10_000 * MS_NS)
        host.send("G\r")
        drive.run("300 ms")
        assert bench.now_ps == now + 300 * MS  # the ten seconds have not passed here
        assert len(line.twin.steps) == 10 and not drive.troubles


def test_a_board_that_counts_wrong_is_found():
    bench, x, host, _ = furnished("cy525 five steps")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("90 ms")
        line.twin.position += 1
        drive.run_until_rest()
        assert codes(x) == ["count-differs"] and "has counted 6 steps, but was sent 5" in x.findings[0].text
        host.send("G\r")
        drive.run_until_rest()
        assert codes(x) == ["count-differs"]


def test_a_port_that_is_gone():
    bench, x, _, _ = furnished("cy525 top")
    line = TwinLine()
    with drive_of(bench, x, line) as drive:
        drive.run("500 ms")

        def gone():
            raise OSError(5, "Input/output error")

        line.read, line.supplied = gone, False
        line.back.clear()
        drive.run("500 ms")
        assert drive.state == "unknown" and codes(x) == ["port-lost"] and not x.motor.moving
