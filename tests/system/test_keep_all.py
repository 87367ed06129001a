"""What else a bench forgets with `keep`: the past of parts, findings, recorded pins, what hosts have received."""

from __future__ import annotations

import pytest

import slewline
from slewline.core.motion import kept
from slewline.errors import NotRecorded, Timeout
from slewline.parts.base.recent import Recent
from slewline.record.recording import recorder
from slewline.testing import aio

MS, SECOND = 10**9, 10**12
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
SHUTTLE = ("Po", "S100", "T1000", "R1", "+2", "-2", "j0", "E")  # for ever


@pytest.fixture(autouse=True)
def few(monkeypatch):
    """Short lists are trimmed as well."""
    monkeypatch.setattr(kept, "FEWEST", 32)
    monkeypatch.setattr(recorder, "TRIM_FROM", 32)


def shuttling(**options):
    """A module that moves a motor to and fro for ever, with the current of its driver."""
    bench = slewline.Bench(**options)
    x = bench.add("gs-c200s", name="x", straps=STRAPS)
    motor = bench.part("translator", "motor", to=x)
    current = bench.part("phase_current", "current", to=x)
    current.quantities()
    host = bench.host(x)
    for line in SHUTTLE:
        host.ask(line)
    return bench, motor, current


# ---------------------------------------------------------------------------------------------------------------- parts
@pytest.fixture(scope="module")
def both():
    """The same run in one call, of which all is kept, and the last half second."""
    runs = shuttling(), shuttling(keep="0.5 s")
    for bench, *_ in runs:
        bench.run_to("3 s")
    return runs


def test_one_long_run_forgets_the_old_displays_of_parts(both):
    (_, motor, current), (_, bounded, brief) = both
    assert len(bounded.shaft.past) < len(motor.shaft.past) / 2
    assert len(brief.past) < len(current.past) / 2


def test_data_kept_by_parts_equal_those_without_a_bound(both):
    (whole, motor, current), (bounded, same, brief) = both
    times = [2_500 * MS + n * 7_919 * 10**6 for n in range(60)]
    for name in ("motor.position", "current.current"):
        assert whole.quantity(name).at(times).tolist() == bounded.quantity(name).at(times).tolist()
    assert current.currents_at(times).tolist() == brief.currents_at(times).tolist()
    assert motor.shaft.place == same.shaft.place


PARTS = {
    "position": lambda bench, current, ps: bench.quantity("motor.position").at(ps),
    "positions": lambda bench, current, ps: bench.quantity("motor.position").at([ps, 3 * SECOND]),
    "quantity": lambda bench, current, ps: bench.quantity("current.current").at(ps),
    "current_at": lambda bench, current, ps: current.current_at(ps),
    "currents_at": lambda bench, current, ps: current.currents_at([3 * SECOND, ps]),
}


@pytest.mark.parametrize("question", PARTS)
def test_a_part_refuses_earlier_times_with_the_remedy(both, question):
    _, (bounded, _, current) = both
    name = "motor" if question.startswith("position") else "current"
    with pytest.raises(NotRecorded) as raised:
        PARTS[question](bounded, current, 2_500 * MS - 1)
    assert str(raised.value).startswith(f"{name} at ") and str(raised.value).endswith(
        ": the past is kept only from 2.5 s on; make the bench with a longer keep than '500 ms'"
    )
    PARTS[question](bounded, current, 2_500 * MS)


def test_the_instants_reported_to_listeners_are_the_same():
    heard = []
    for options in ({}, {"keep": "70 ms"}):
        bench, *_ = shuttling(**options)
        instants = []
        bench.on_commit.add(instants.append)
        bench.run("1 s")
        heard.append(instants)
    assert heard[0] == heard[1]


def test_a_wait_for_a_foreseen_event_forgets_meanwhile():
    bench, motor, _ = shuttling(keep="0.1 s")
    other = bench.add("cy525", "y")
    longest = []
    bench.on_commit.add(lambda _: longest.append(len(motor.shaft.past)))
    with pytest.raises(Timeout):
        bench.run_until(other.reaches(1), timeout="3 s")
    assert max(longest) < 200  # of 1,800 motions


def test_a_wait_of_asyncio_forgets_when_it_begins():
    bench, motor, _ = shuttling(keep="0.1 s")
    longest = []

    async def main():
        for _ in range(60):
            await bench.wait("50 ms")
            longest.append(len(motor.shaft.past))

    aio.run(main())
    assert max(longest) < 200


def test_a_picture_without_an_axis_begins_with_the_kept_data(tmp_path):
    bench = slewline.Bench(keep="1 ms")
    master = bench.part("quadrature", "master")
    bench.record("master.a")
    master.run(40_000)
    bench.run("50 ms")
    assert bench.edges("master.a")[0][0] >= 49 * MS
    bench.save_vcd(tmp_path / "m.vcd", values=True)
    assert (tmp_path / "m.vcd").read_text().split("$enddefinitions $end\n")[1].startswith("#49000000\n")


# ----------------------------------------------------------------------------------------------------------------- axes
@pytest.fixture(scope="module")
def turned():
    """A chipset whose encoder somebody else turns, after an S-curve, with a bench that keeps 10 ms."""
    bench = slewline.Bench(keep="10 ms")
    m = bench.add("mc1451a-e", "m")
    host = bench.host(m)
    master = bench.part("quadrature", "master", to=m)
    for line in ("SET_PRFL_S_CRV", "SET_VEL 65536", "SET_MAX_ACC 32767", "SET_JERK 4000000", "SET_POS 400", "UPDATE"):
        host.send(line)
    bench.run_until_idle()
    master.run(100_000)
    for _ in range(40):
        host.ask("GET_ACTL_POS")
        bench.run("50 ms")
    return bench, m


def test_an_axis_at_rest_forgets_how_its_encoder_was_turned(turned):
    _, m = turned
    history = m._motion.trajectories[0].feedback.encoder._history
    assert 1000 <= len(history) <= 20_000  # of 200,000 counts


CYCLES = {
    "cycles": lambda bench, axis, ps: axis.cycles(ps),
    "phases": lambda bench, axis, ps: axis.phases(ps),
    "acceleration": lambda bench, axis, ps: bench.quantity("m.acceleration").at(ps),
    "actual": lambda bench, axis, ps: bench.quantity("m.actual_position").at(ps),
    "actual_changes": lambda bench, axis, ps: bench.quantity("m.actual_position").changes(ps, bench.now_ps),
}


@pytest.mark.parametrize("question", CYCLES)
def test_cycles_and_derived_values_are_refused_before_that(turned, question):
    bench, m = turned
    since = bench.now_ps - 10 * MS
    with pytest.raises(NotRecorded, match="the past is kept only from"):
        CYCLES[question](bench, m.axis(1), since - 1)
    CYCLES[question](bench, m.axis(1), since)


def test_by_default_cycles_begin_with_the_kept_data(turned):
    bench, m = turned
    assert m.axis(1).cycles().times_ps[0] >= bench.now_ps - 10 * MS


# ------------------------------------------------------------------------------------------------------------- findings
def mistaken(times, **options):
    """A host that sends lower-case letters, which are no commands, and once a number that is none."""
    bench = slewline.Bench(**options)
    x = bench.add("cy525", "x")
    host, heard = bench.host(x), []
    bench.on_finding.add(heard.append)
    host.send("R abc\r")
    for _ in range(times):
        host.send("x\r")
        bench.run("1 ms")
    return bench, x, heard


def test_findings_that_are_forgotten_are_counted_by_one_that_stays():
    whole, _, all_of_them = mistaken(100)
    bench, x, heard = mistaken(100, keep="10 ms")
    assert heard == all_of_them == whole.findings  # listeners hear what they would
    first, *rest = bench.findings
    assert rest == all_of_them[-len(rest) :] and 10 <= len(rest) <= 21
    gone = all_of_them[: -len(rest)]
    assert (first.code, first.source, first.time_ps) == ("forgotten", "x", gone[-1].time_ps)
    assert f"{len(gone)} up to " in first.text and f"unknown-command {len(gone) - 1}" in first.text
    assert "bad-number 1" in first.text and first.text.endswith("make the bench with a longer keep than '10 ms'")
    for _ in range(2):  # the past is dropped when a run begins, or in the midst of a long one
        bench.run("1 s")
    (last,) = x.findings
    assert last.code == "forgotten" and last.text.startswith("101 up to ") and "unknown-command 100" in last.text


def test_without_keep_every_finding_stays():
    bench, *_ = mistaken(100)
    assert len(bench.findings) == 101


# ------------------------------------------------------------------------------------------------------- recorded pins
def test_recorded_pins_and_commands_are_kept_for_the_time_set_on_the_bench():
    bench, *_ = shuttling(keep="100 ms")
    bench.record("x.mov")
    bench.run("2 s")
    with pytest.raises(NotRecorded, match="or with a longer keep than '100 ms'"):
        bench.edges("x.mov", start="1 s")
    assert bench.edges("x.mov")[0][0] >= bench.now_ps - 100 * MS


def test_record_may_say_otherwise():
    bench, *_ = shuttling(keep="100 ms")
    begun = bench.now_ps
    bench.record("x.mov", keep="1 h")
    bench.run("2 s")
    assert len(bench.edges("x.mov", start=begun)[0]) > 50


# ----------------------------------------------------------------------------------------------------- what has come in
def exchanged(part, command, times=60, **options):
    """A host that asks the same over and over, a question every 10 ms at least."""
    bench = slewline.Bench(**options)
    x = bench.add(part, "x", **({"straps": STRAPS} if part == "gs-c200s" else {}))
    host = bench.host(x)
    if part == "cy545":
        host.send("O 129\r")  # answers on the bus
    answers = []
    for _ in range(times):
        answers.append(host.ask(command) if part != "cy525" else host.verify(0))
        bench.run("10 ms")
    return bench, host, answers


ASKED = {"cy525": "V", "gs-c200s": "V1", "cy545": "? P", "mc1451a": "GET_STATUS"}


@pytest.mark.parametrize("part", ASKED)
def test_a_host_forgets_what_it_has_received(part):
    _, host, answers = exchanged(part, ASKED[part], keep="40 ms")
    _, whole, same = exchanged(part, ASKED[part])
    assert answers == same
    assert 0 < len(host.received) < len(whole.received) / 4
    assert host.received == whole.received[-len(host.received) :]


def test_a_question_is_answered_although_much_has_been_forgotten_meanwhile():
    bench = slewline.Bench(keep="1 ms")
    x = bench.add("cy545", "x")
    host = bench.host(x)
    host.send("O 129\r")
    for _ in range(20):
        assert host.ask("? P") == host.ask("? P") != ""
        bench.run("5 ms")
    assert len(host.received) <= 33 < 40 * 11


def test_answers_that_are_never_requested_are_forgotten():
    bench = slewline.Bench(keep="1 s")
    host = bench.host(bench.add("gs-c200s", "x", straps=STRAPS))
    for _ in range(100):
        host.send("V1\r")
        bench.run("100 ms")
    assert 10 <= len(host.answers) <= 21


def test_results_of_a_script_are_forgotten():
    from slewline.bench.scripts.script import run_script

    bench = slewline.Bench(keep="10 ms")
    host = bench.host(bench.add("mc1451a", "m"))
    run_script(bench, host, ["GET_POS", "expect 0", "@wait 1 ms"] * 100)
    bench.run_until_idle()
    bench.run("1 ms")
    assert 5 <= len(host.results) <= 50


# ----------------------------------------------------------------------------------------------------------- by itself
def test_data_before_the_last_mark_are_dropped_when_the_mark_is_old():
    what = bytearray(b"abc")
    recent = Recent(what)
    recent.forget(0, 10)  # a mark
    assert what == b"abc" and recent.total == 3
    what += b"de"
    recent.forget(9, 19)  # too early
    assert what == b"abcde"
    recent.forget(10, 20)
    assert what == b"de" and recent.total == 5
    assert (recent.place(4), recent.place(1)) == (1, 0)
    recent.clear()
    assert what == b"" and recent.total == 5
    what += b"f"
    recent.forget(20, 30)
    assert what == b"f"  # it came after the mark
