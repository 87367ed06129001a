"""How far back a bench remembers where its axes have been, and what it says when somebody asks for more."""

from __future__ import annotations

import pytest

import slewline
from slewline.core.motion import kept
from slewline.errors import NotRecorded, TimeError
from slewline.links.lines.pace import Lockstep
from slewline.links.server import Server
from slewline.links.time import bench_exchange

NOW, SINCE = 3 * 10**12, 25 * 10**11
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
SHUTTLE = ("Po", "S100", "T1000", "R1", "+2", "-2", "j0", "E")  # for ever


def shuttling(**keep):
    """A module that moves to and fro for ever, some 50 stretches a second."""
    bench = slewline.Bench(**keep)
    x = bench.add("gs-c200s", name="x", straps=STRAPS)
    host = bench.host(x)
    for line in SHUTTLE:
        host.ask(line)
    return bench, x


@pytest.fixture(scope="module")
def both():
    """The same run, of which all is kept, and the last half second."""
    whole = shuttling()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kept, "FEWEST", 32)
        bounded = shuttling(keep="0.5 s")
        for bench, _ in (whole, bounded):
            bench.run_to("3 s")
    return whole, bounded


def asked(bench, x, start, stop):
    """All that can be asked of a window."""
    times = [start, (start + stop) // 2, stop]
    steps = x.steps(start, stop)
    yield from (steps.times_ps.tolist(), steps.directions.tolist(), steps.positions.tolist())
    yield [x.position_at(time) for time in times] + x.position_at(times).tolist()
    yield [x.velocity_at(time) for time in times] + x.velocity_at(times).tolist()
    yield x.motions(start, stop), x.marks(start, stop), x.phases(start, stop)
    for name in ("x.position", "x.velocity"):
        for found in (bench.quantity(name).changes(start, stop), bench.quantity(name).outline(start, stop, 50)):
            yield found.times_ps.tolist(), found.values.tolist()


def test_kept_data_equal_those_of_a_bench_without_a_bound(both):
    (whole, x), (bounded, y) = both
    assert len(y.motor.past) < 0.5 * len(x.motor.past)
    for start in (SINCE, NOW - 10**10):
        assert list(asked(whole, x, start, NOW)) == list(asked(bounded, y, start, NOW))
    assert (x.position, x.travel, x.motor.made) == (y.position, y.travel, y.motor.made)
    assert x.motor.made == x.motor.count(0, NOW) > 200


def test_by_default_it_is_what_is_kept(both):
    _, (_, y) = both
    assert y.motor.since == SINCE
    assert y.steps().times_ps[0] >= SINCE and len(y.steps()) == len(y.steps("2.5 s"))
    assert y.motions()[0].time_ps >= SINCE and len(y.motions()) == len(y.motions("2.5 s"))


QUESTIONS = {
    "steps": lambda bench, x, ps: x.steps(ps),
    "position_at": lambda bench, x, ps: x.position_at(ps),
    "positions_at": lambda bench, x, ps: x.position_at([NOW, ps]),
    "velocity_at": lambda bench, x, ps: x.velocity_at(ps),
    "velocities_at": lambda bench, x, ps: x.velocity_at([NOW, ps]),
    "motions": lambda bench, x, ps: x.motions(ps),
    "marks": lambda bench, x, ps: x.marks(ps),
    "phases": lambda bench, x, ps: x.phases(ps),
    "position": lambda bench, x, ps: bench.quantity("x.position").outline(ps, NOW, 50),
    "velocity": lambda bench, x, ps: bench.quantity("x.velocity").outline(ps, NOW, 50),
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_earlier_times_are_refused_with_the_remedy(both, question):
    _, (bounded, y) = both
    with pytest.raises(NotRecorded) as raised:
        QUESTIONS[question](bounded, y, SINCE - 1)
    assert str(raised.value).startswith("x at ") and str(raised.value).endswith(
        ": the past is kept only from 2.5 s on; make the bench with a longer keep than '500 ms'"
    )
    QUESTIONS[question](bounded, y, SINCE)


def test_files_and_pictures_begin_with_the_kept_data(both, tmp_path):
    _, (bounded, _) = both
    bounded.save_steps(tmp_path / "steps.csv")
    lines = (tmp_path / "steps.csv").read_text().splitlines()
    assert int(lines[1].split(",")[0]) >= SINCE
    bounded.plot(tmp_path / "all.svg", pins=[], ideal=False)
    for save, name in ((bounded.save_steps, "more.csv"), (bounded.plot, "more.svg")):
        with pytest.raises(NotRecorded):
            save(tmp_path / name, start="2.4 s")


def test_a_vcd_file_with_values_begins_with_the_kept_data(tmp_path):
    bench, x = shuttling(keep="100 ms")
    bench.record("x.step" if "step" in x.pins else "x.mov")
    bench.run("1 s")
    bench.save_vcd(tmp_path / "x.vcd", values=True)
    bench.save_vcd(tmp_path / "y.vcd")
    with pytest.raises(NotRecorded):
        bench.save_vcd(tmp_path / "z.vcd", start="0.1 s", values=True)


@pytest.mark.parametrize("part", ["cy525", "cy545", "mc1451a-e"])
def test_every_axis_of_every_part_has_the_bound(part):
    bench = slewline.Bench(keep="1 ms")
    x = bench.add(part, name="x")
    bench.run("10 ms")
    for number in range(1, len(x.axes) + 1):
        with pytest.raises(NotRecorded, match="from 9 ms on"):
            x.axis(number).steps(0)


@pytest.mark.parametrize("part", ["mc1451a", "mc1451a-e"])
def test_an_axis_of_cycles_forgets_in_the_midst_of_its_moves(part, monkeypatch):
    monkeypatch.setattr(kept, "FEWEST", 8)
    found = []
    for keep in (None, "1 ms"):
        bench = slewline.Bench(keep=keep)
        x = bench.add(part, name="x")
        host = bench.host(x)
        for k in range(30):
            host.send(f"SET_VEL 65536\rSET_ACC {4000 + k}\rSET_POS {k % 2 * 40}\rUPDATE\r")
            bench.run_until_idle()
        found.append((bench.now_ps, x.travel, x.registers, x.motor.made, x.velocity_at(bench.now_ps), x.findings))
        assert keep is None or len(x.motor.past) <= 16 < x.motor.made / 40
    assert found[0] == found[1]


def test_a_server_keeps_the_given_number_of_stretches_and_counts_all_steps(monkeypatch):
    monkeypatch.setattr(kept, "FEWEST", 8)
    monkeypatch.setattr(bench_exchange, "KEPT_STRETCHES", 30)
    bench, x = shuttling()
    serving = Server(bench, Lockstep(bench))
    serving.stop()
    serving.run()
    bench.run_to("3 s")
    assert 30 <= len(x.motor.past) <= 60 and serving.steps_of(x) == shuttled(3)
    with pytest.raises(NotRecorded, match="a server keeps the last 30 stretches of motion: query earlier, or replay"):
        x.steps(0)
    assert len(x.steps()) == x.motor.count(x.motor.since, bench.now_ps)


def shuttled(seconds):
    bench, x = shuttling()
    bench.run_to(f"{seconds} s")
    return len(x.steps())


def test_a_journal_does_not_record_it(tmp_path):
    path = tmp_path / "journal.jsonl"
    bench, x = shuttling(keep="10 ms", journal=path)
    bench.run("1 s")
    bench.journal.close()
    assert "keep" not in path.read_text()
    again = slewline.replay(path)
    assert len(again["x"].steps()) == x.motor.made and again["x"].position == x.position


def test_a_duration_is_required():
    with pytest.raises(TimeError):
        slewline.Bench(keep=3)
