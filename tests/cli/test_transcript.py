"""The transcript: every event with its instant, in order, and no influence on what it tells about."""

from __future__ import annotations

from contextlib import suppress

import pytest

import slewline
from slewline.bench.scripts.script import run_script
from slewline.cli.transcript import MOST, Transcript, counted, seconds

SET_UP = "F 3\nR 40\nS 255\nZ 1\nA 0\n"


def told(script, drive=(), timeout="60 s", **options):
    """The events (ps, who, kind, text) of a script, and the chip."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", **options)
    events = []
    for pin, level, at in drive:
        x.pin(pin).drive(level, at)
    Transcript(bench, lambda *event: events.append(event)).attach()
    run_script(bench, bench.host(x), script)
    host = bench["host"]
    host.on_event.add(lambda text: events.append((bench.now_ps, "host", "host", text)))
    with suppress(slewline.Timeout):
        bench.run_until_idle(timeout)
    return events, x


def texts(events, *kinds):
    return [text for _, _, kind, text in events if kind in kinds]


def test_a_motion_is_reported_at_its_start_and_at_its_end():
    events, x = told(SET_UP + "N 300\nG\n-\nN 1\nG\n")
    motions = [event for event in events if event[2] == "motion"]
    times = [int(time) for time in x.steps().times_ps]
    assert [text.split(":")[0] for _, _, _, text in motions] == [
        "steps cw from 0",
        "MOTION COMPLETE at 300",
        "steps ccw from 300",
        "MOTION COMPLETE at 299",
    ]
    assert [motions[0][0], motions[2][0]] == [times[0], times[300]]
    assert "300 steps cw in" in motions[1][3] and "1 step ccw in 3.333363 ms" in motions[3][3]
    assert [time for time, *_ in events] == sorted(time for time, *_ in events)


def test_pins_are_reported_with_their_meaning():
    events, _ = told("E\nC\nB\n0\nQX\n")
    assert texts(events, "pin") == [
        "PROG low: program entry, or live commands",
        "PROG high",
        "RUN low: the program runs",
        "PROGRAMMABLE OUTPUT low",
        "PROGRAMMABLE OUTPUT high",
        "RUN high: the program has ended",
    ]


def test_slew_is_reported_once_at_each_end():
    events, _ = told(SET_UP + "N 1000\nG\n")
    assert texts(events, "pin") == ["SLEW low: at a steady rate", "SLEW high"]


def test_the_awaited_pin_of_a_waiting_chip_is_reported_when_it_changes():
    events, _ = told("W\n", drive=[("wait", 0, None), ("abort", 0, "3 ms"), ("wait", 1, "5 ms")])
    assert [event for event in events if event[2] == "pin"] == [
        (3 * 10**9, "x", "pin", "ABORT low: stop the motion"),
        (5 * 10**9, "x", "pin", "WAIT high (waiting for wait=1 (W) since 380 µs)"),
    ]


def test_a_pulse_without_a_step_is_not_a_motion():
    events, x = told("O 255\n" + SET_UP + "N 2\nG\n")
    assert [text.split(":")[0] for text in texts(events, "motion")] == ["steps cw from 0", "MOTION COMPLETE at 2"]
    assert x.travel == 2


def test_a_motion_that_reset_cuts_off_is_not_complete():
    events, x = told(SET_UP + "N 3000\nG\n@wait 50 ms\n@reset\n")
    (text,) = [text for text in texts(events, "motion") if "from" not in text]
    steps = x.travel
    assert 0 < steps < 3000 and text.startswith(f"cut off at {steps}: {steps} steps cw in")


ONCE = ["steps cw", "MOTION COMPLETE"]


@pytest.mark.parametrize(
    "directives",
    [
        "@read position\n",  # MOTION COMPLETE low for 10 us, within a step
        "@rate 0\n@wait 5 ms\n@rate 50\n",  # no further step, MOTION COMPLETE low, until a rate comes
        "@rate 0\n",  # or until ABORT ends it
    ],
)
def test_a_motion_is_one_whatever_motion_complete_does_in_it(directives):
    script = SET_UP + f"N 60000\nH\nG\n@until slew=0\n{directives}@wait 5 ms\n@drive abort=0\n"
    events, x = told(script)
    assert [text.split(" at")[0].split(" from")[0] for text in texts(events, "motion")] == ONCE
    assert f"MOTION COMPLETE at {x.position}" in texts(events, "motion")[-1]


def followed(part, *lines, axes=(), before=(), **options):
    """The transcript's lines about motions on a part that is spoken to in lines or packets."""
    bench = slewline.Bench()
    x = bench.add(part, name="x", **options)
    events = []
    Transcript(bench, lambda *event: events.append(event)).attach()
    run_script(bench, bench.host(x), "\n".join(lines) + "\n")
    bench.run_until_idle()
    return texts(events, "motion"), x


def test_an_update_in_motion_is_reported_as_one_motion():
    lines = ("SET_1", "SET_VEL 0x20000", "SET_ACC 800", "SET_POS 300", "UPDATE", "SET_POS 500", "UPDATE")
    motions, x = followed("mc1251a", *lines, "@until atrest1=1")
    assert len(x.axis(1).motions()) == 2
    assert motions[0] == "axis 1 moves from 0" and motions[1].startswith("axis 1 at rest at 500: 500 steps in ")
    assert len(motions) == 2


def test_a_motion_without_a_step_is_not_reported_for_a_part_without_a_pin_for_it():
    events, _ = told(SET_UP + "N 0\nG\n")
    assert texts(events, "motion") == []


def test_switching_the_motor_off_cuts_a_motion_off():
    lines = ("SET_VEL 0x20000", "SET_ACC 800", "SET_POS 30000", "UPDATE", "@wait 100 ms", "MTR_OFF")
    motions, x = followed("mc1151a", *lines)
    assert motions == ["moves from 0", motions[1]] and motions[1].startswith(f"cut off at {x.position}: ")


def test_the_meaning_of_pins_is_in_the_sheet():
    bench = slewline.Bench()
    x = bench.add("mc1451a", name="x")
    events = []
    Transcript(bench, lambda *event: events.append(event)).attach()
    bench.run("10 ms")
    x.pin("home3").drive(0)
    bench.run("1 ms")
    assert texts(events, "pin")[-1] == "HOME3 low: axis 3 at its home position"


def test_motion_complete_is_reported_at_the_edge_of_its_pin_before_the_next_act_of_the_host():
    script = "A 0\nF 10\nR 10\nS 255\nZ 1\nP 50\nB\n"
    events, _ = told(script)
    (begun, _, _, first), (over, _, _, last) = (event for event in events if event[2] == "motion")
    assert (first, last) == ("steps cw from 0", "MOTION COMPLETE at 50: 50 steps cw in 50 ms")
    assert over == begun + 50 * 10**9
    after = [text for time, _, kind, text in events if kind == "host" and time > begun]
    assert after == ["B"] and events.index((over, "x", "motion", last)) < [text for *_, text in events].index("B")
    assert [time for time, *_ in events] == sorted(time for time, *_ in events)


def test_findings_are_reported_including_earlier_ones():
    events, _ = told("R 200\n", crystal="12 MHz")
    assert [text.split(":")[0] for text in texts(events, "finding")] == ["crystal", "range"]


def test_an_endless_program_comes_to_an_end_in_the_transcript():
    events, _ = told("E\nC\nB\nJ 0\nQX\n", timeout="100 ms")
    output = [text for text in texts(events, "pin") if "output" in text.lower()]
    assert len(output) == MOST + 1
    assert output[-1] == "x.programmable_output continues like this; further lines are not shown"


def test_a_transcript_changes_nothing():
    script = SET_UP + "E\nN 300\nG\n-\nN 100\nG\n0\nQX\n@until run=1\nO 200\nN 20\nG\n"
    quiet = slewline.Bench()
    x = quiet.add("cy525", name="x")
    run_script(quiet, quiet.host(x), script)
    quiet.run_until_idle()
    _, y = told(script)
    assert quiet.now_ps == y.kernel.now
    assert (x.steps().times_ps == y.steps().times_ps).all()


def test_columns():
    assert seconds(12_000_345_999_999) == "12.000345"
    assert [counted(number, "step") for number in (0, 1, 2)] == ["0 steps", "1 step", "2 steps"]
