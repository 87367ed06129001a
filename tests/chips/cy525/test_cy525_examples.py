"""The manual's programs, as they lie in examples/programs, run through the pins."""

from __future__ import annotations

from itertools import groupby, pairwise
from pathlib import Path

import pytest

from slewline.chips.cy525.sheet import SHEET
from slewline.language.source import Statement, read

US = 1_000_000  # picoseconds
MS = 1000 * US
OUT = "programmable_output"
EXAMPLES = Path(__file__).parents[3] / "examples" / "programs"


def ascii_of(name: str, part: int = 0) -> str:
    """What a host sends for an example, up to the first directive or between two of them."""
    items = read((EXAMPLES / f"{name}.cy525").read_text(), SHEET).items
    parts = [list(group) for plain, group in groupby(items, lambda item: isinstance(item, Statement)) if plain]
    return "".join(item.text + "\r" * item.row.terminated for item in parts[part])


def binary_of(name: str) -> bytes:
    lines = (EXAMPLES / f"{name}.hex").read_text().splitlines()
    return bytes.fromhex("".join(line.partition(";")[0] for line in lines))


def ticks(times) -> list[int]:
    """Clocks between instants."""
    return [round((after - before) * 11 / US) for before, after in pairwise(map(int, times))]


def pass_motions(r, number: int) -> None:
    """Let time pass until so many motions have ended: MOTION COMPLETE falls at the end of each."""
    r.bench.run_until(r.x.pin("motion_complete").edges(2 * number - r.level("motion_complete")), "300 s")


def moves(r, since: int = 0) -> list[int]:
    """Where every motion since an instant ended."""
    return [r.x.position_at(time) for time in r.falls("motion_complete", since)]


# ----------------------------------------------------------------------------------------------- the three routes (s.5)
@pytest.mark.fact("EXAMPLE-BIN", "BIN-8", "BIN-9", "PROG-2", "PROG-3")
def test_three_routes_into_the_buffer_and_their_effects(rig):
    ascii = ascii_of("three_routes")
    separate = bytes.fromhex("45 00 52 01 7F 4E 02 2C 01 2B 00 47 00 4E 02 EE 02 2D 00 47 00 30 00 51")
    single = bytes.fromhex("45 00 52 0C 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00 51")
    assert [len(route) for route in (ascii, separate, single)] == [31, 24, 17]
    for mode, route in ((1, ascii), (0, separate), (0, single)):
        r = rig(position=0, slope=255)
        r.drive("ascii_binary", mode)
        r.send(route)
        assert r.codes == []
        assert r.host.verify(1, 14) == bytes.fromhex("52 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00 00")
        r.send("X\r" if mode else b"X\0")
        assert r.x.position == 65086 and r.level("run") == 1
        assert r.x.steps().directions.tolist() == [1] * 300 + [-1] * 750
        assert r.x.registers["rate"] == 127 and r.x.registers["number"] == 750


# ------------------------------------------------------------------------------------------- pulse, figures 7.2 to 7.6
@pytest.mark.fact("EXAMPLE-7.2", "CMD-E-2")
def test_eleven_characters_and_a_pulse(rig):
    r = rig(record=("prog", "run", OUT, "instrobe", "ready"), delay="100 us")
    stream = ascii_of("pulse")
    assert len(stream) == 11
    r.send("C\r")
    start = r.bench.now_ps
    r.send(stream)
    taken = r.rises("instrobe", start)
    assert len(taken) == 11
    # letters: 187 us each; E 400, stored B, C and 0 375, X 380 for both characters; Q 175; 100 us before each
    assert r.rises("ready", start)[-1] - start == (400 + 3 * 375 + 175 + 380 + 11 * 100) * US
    assert abs((400 + 3 * 375 + 175 + 380 + 11 * 100) - 3300) <= 0.2 * 3300
    assert [level for _, level in r.edges("prog", start)] == [0, 1]
    low, high = (time for time, _ in r.edges("prog", start))
    assert taken[1] < low < taken[2] and taken[8] < high < taken[9]
    ((fell, _), (rose, _)) = r.edges("run", start)
    assert r.edges(OUT, start) == [(fell + 60 * US, 1), (fell + 100 * US, 0)] and rose == fell + 136 * US
    assert fell == taken[10] + (10 + 150) * US
    again = r.bench.now_ps + 1
    r.execute()
    assert [level for _, level in r.edges(OUT, again)] == [1, 0] and r.codes == []


# -------------------------------------------------------------------------------------- conditional loop and jump (s.4)
@pytest.mark.fact("EXAMPLE-COND", "LABEL-3", "PROG-5")
def test_conditional_loop_inside_an_endless_program(rig):
    r = rig(record=("run", "dowhile", OUT, "motion_complete"))
    r.drive("dowhile", 0)
    r.send("C\rF 60\rS 255\rZ 1\rA 0\r")
    r.start(ascii_of("conditional_loop"))
    assert r.x.program == bytes.fromhex("4E 05 00 2B 47 2D 4E 05 00 47 54 43 42 52 3C 58")
    pass_motions(r, 6)  # three rounds at R 80
    assert moves(r) == [5, 0] * 3 and r.level(OUT) == 0
    assert r.x.program == bytes.fromhex("4E 05 00 2B 47 2D 4E 05 00 47 54 00 42 52 3C 58")
    r.drive("dowhile", 1)
    r.bench.run_until(r.x.pin(OUT).is_(1))
    first = r.bench.now_ps
    r.drive("dowhile", 0)
    pass_motions(r, 6)
    assert moves(r) == [5, 0] * (len(moves(r)) // 2)
    fast, slow = (min(ticks(r.x.steps(*span).times_ps)) for span in ((0, first), (first, None)))
    assert fast < 2140 == slow  # 5141 steps/s: R 60, which is F
    r.bench.run("2 s")
    assert [level for _, level in r.edges("run")] == [0]
    r.x.reset()
    r.bench.run("1 ms")
    assert r.level("run") == 1


@pytest.mark.fact("EXAMPLE-JUMP", "LABEL-3", "CON-LABEL-OCR")
def test_jump_goes_home_and_then_moves_on_each_signal(rig):
    r = rig(record=("run", OUT, "motion_complete", "pulse"), divisor=1)
    r.drive("wait", 0)
    r.start(ascii_of("jump"))
    assert r.x.program == bytes.fromhex("43 52 7F 50 00 00 2B 4E 4B 00 52 65 42 57 43 47 4A 41")
    assert (r.x.registers["slope"], r.x.registers["firstrate"]) == (20, 3)
    r.bench.run_until(r.x.pin(OUT).is_(0))
    r.bench.run_until(r.x.pin(OUT).is_(1))
    assert moves(r) == [0] and r.x.registers["rate"] == 101
    for count in (1, 2, 3):
        r.bench.run("1 s")
        assert r.level(OUT) == 1 and r.x.position == 75 * (count - 1)  # it waits
        r.drive("wait", 1)
        r.bench.run_until(r.x.pin(OUT).is_(0))
        r.drive("wait", 0)
        r.bench.run_until(r.x.pin(OUT).is_(1))
        assert r.x.position == 75 * count
    assert r.x.program[-2:] == bytes.fromhex("4A 0C")
    assert r.x.registers["number"] == 75 and r.level("run") == 0


@pytest.mark.fact("EXAMPLE-JUMP-2")
def test_a_level_that_stays_lets_the_next_move_follow_immediately(rig):
    r = rig(record=(OUT, "motion_complete"), divisor=1)
    r.drive("wait", 1)
    r.start(ascii_of("jump"))
    pass_motions(r, 4)
    home, *ends = r.falls("motion_complete")
    assert moves(r)[1:] == [75, 150, 225][: len(ends)] and len(ends) == 3
    ups, downs = r.rises(OUT, home), r.falls(OUT, home)
    assert [down - up for up, down in zip(ups, downs, strict=False)] == [80 * US] * 3  # W and C, 40 us each


@pytest.mark.fact("LABEL-4", "LABEL-3", "LABEL-2", "CON-GUIDE-LABELS")
def test_labels_shuttle(rig):
    r = rig(record=("motion_complete", "pulse", OUT))
    r.start(ascii_of("labels"))
    stored = bytes.fromhex("50 28 00 43 50 00 00 42 4A 41")
    assert r.x.program == stored and len(stored) == 10
    pass_motions(r, 5)
    assert moves(r) == [40, 0, 40, 0, 40]
    assert [r.x.position_at(time) for time, _ in r.edges(OUT)] == [40, 0, 40, 0]
    assert [level for _, level in r.edges(OUT)] == [0, 1, 0, 1]
    r.host.live("0", timeout="30 s")
    assert r.level("run") == 1
    assert r.host.verify(1, 10) == stored[:-1] + b"\0"


# ---------------------------------------------------------------------------------------------- welding machine (s.4)
@pytest.mark.fact("EXAMPLE-WELD-3", "LABEL-3")
def test_weld_three_workpieces(rig):
    r = rig(record=("run", OUT, "motion_complete", "ready"))
    r.drive("wait", 0)
    r.drive("dowhile", 0)
    r.send("C\r")
    r.start(ascii_of("weld"))
    assert len(r.x.program) == 20
    assert r.x.program.hex(" ").upper() == "57 2B 4E 64 00 42 44 F4 01 43 47 4C 06 43 50 00 00 54 42 00"
    places = []
    for piece in (1, 2, 3):
        r.bench.run("1 s")
        assert r.level(OUT) == 0 and r.level("run") == 0 and r.x.position == 0  # no workpiece, no weld
        start = r.bench.now_ps
        r.drive("wait", 1)
        r.bench.run_until(r.x.pin(OUT).is_(1))
        r.drive("wait", 0)
        if piece == 3:
            r.drive("dowhile", 1)
        pass_motions(r, 7)  # six moves and the way back
        assert moves(r, start) == [100, 200, 300, 400, 500, 600, 0]
        welds = list(zip(r.rises(OUT, start), r.falls(OUT, start), strict=True))
        assert [down - up for up, down in welds] == [500 * MS + 80 * US] * 6  # and the times of D and C
        assert all(r.x.position_at(up) == r.x.position_at(down) for up, down in welds)
        places += [r.x.position_at(up) for up, _ in welds]
    assert places == [0, 100, 200, 300, 400, 500] * 3
    r.bench.run_until_idle()
    assert r.level("run") == 1 and len(r.rises("run")) == 1
    assert r.host.verify(1, 20).hex(" ").upper() == "57 2B 4E 64 00 42 44 F4 01 43 47 4C 06 05 50 00 00 54 00 00"


# ---------------------------------------------------------------------------------------------------- hand-off (s.10)
@pytest.mark.fact("EXAMPLE-HANDOFF-4")
def test_handoff_reports_a_part_once_a_cycle_and_not_while_taking_one(rig):
    r = rig(record=("run", OUT, "direction", "motion_complete", "ready"), divisor=1)
    r.drive("wait", 1)
    r.drive("dowhile", 0)
    r.send("B\r")
    r.start(ascii_of("handoff"))
    r.bench.run("1 s")
    assert len(r.x.program) == 45 and r.x.program[:5].hex(" ") == "55 50 00 00 2b" and r.x.position == 14
    arrivals = []
    for cycle in (1, 2):
        start = r.bench.now_ps
        r.drive("wait", 0)
        motions = []
        for _ in range(7):
            pass_motions(r, 1)
            r.drive("wait", 1)
            motions.append((r.x.position, r.x.registers["rate"]))
        r.drive("dowhile", cycle - 1)
        r.bench.run("1 ms")  # T: back to U, or on to the stop
        assert motions == [(0, 120), (14, 120), (108, 120), (122, 120), (108, 120), (0, 20), (14, 20)]
        pauses = [ticks(pair)[0] for pair in zip(r.rises("ready", start), r.falls("ready", start)[1:], strict=False)]
        # between two motions, the second P among them, whose READY falls 10 us before its time
        instructions = [40 * 11 * number - 10 * 11 for number in (4, 2, 2, 3, 3, 1)]
        waits = [90 * 11_000 if n in (0, 1, 3, 4) else 0 for n in range(6)]
        assert pauses[:6] == [n + wait for n, wait in zip(instructions, waits, strict=True)]
        both = [(t, "direction", v) for t, v in r.edges("direction", start)]
        pins = {"direction": 1, OUT: 1}
        both = sorted(both + [(t, OUT, v) for t, v in r.edges(OUT, start)])
        for (time, pin, level), (following, _, _) in pairwise(both):
            pins[pin] = level
            if pins == {"direction": 0, OUT: 0}:
                arrivals.append(r.x.position_at(time))
                assert ticks((time, following)) == [30 * 11]  # from - to 10 us before the first step of P 122
    assert arrivals == [108, 108]
    r.bench.run_until_idle()
    assert r.level("run") == 1 and r.x.registers["rate"] == 120


# ----------------------------------------------------------------------------------- figures 10.13, 10.14, 10.15 (s.10)
@pytest.mark.fact("CMD-D-3", "CMD-L-4", "CMD-L-1", "PROG-2")
def test_two_groups_of_single_steps_twice(rig):
    r = rig(record=("run", OUT, "pulse"), position=0, slope=255, divisor=1)
    r.drive("wait", 1)
    r.drive("dowhile", 0)
    r.start(ascii_of("two_groups"))
    assert r.x.program == bytes.fromhex("42 47 44 F4 01 4C 03 01 43 55 42 47 44 4A 01 4C 03 0B 43 54 00 00")
    for cycle in (1, 2):
        start = r.bench.now_ps
        r.bench.run("3 s")
        assert r.level(OUT) == 0 and r.x.position == 6 * cycle - 3  # stopped at U
        r.drive("wait", 0)
        r.bench.run_until(r.x.pin(OUT).is_(1))
        r.drive("wait", 1)
        r.drive("dowhile", cycle - 1)
        r.bench.run_until(r.x.pin(OUT).is_(0))
        assert r.x.position == 6 * cycle
        gaps = ticks(r.falls("pulse", start))
        # delay, step of 1 ms, its 30 us (at 6 MHz) to READY, and the instructions D, L and G
        per_step = 11_000 + 30 * 6 + 3 * 40 * 11
        assert (gaps[:2], gaps[3:]) == ([500 * 11_000 + per_step] * 2, [330 * 11_000 + per_step] * 2)
        assert gaps[0] == pytest.approx(501 * 11_000, rel=0.02)
    r.bench.run_until_idle()
    assert len(r.falls("pulse")) == 12 and [level for _, level in r.edges("run")] == [0, 1]


@pytest.mark.fact("EXAMPLE-10.14")
def test_four_steps_released_by_step_inhibit(rig):
    r = rig(record=("instrobe", "pulse", "motion_complete", "ready"), divisor=1)
    r.drive("step_inhibit", 1)
    stream = ascii_of("four_steps")
    r.start(stream)
    r.bench.run("100 ms")
    assert len(r.falls("instrobe")) == len(stream) == 22
    assert not r.edges("pulse") and r.level("ready") == 0
    start = r.bench.now_ps
    r.drive("step_inhibit", 0)
    r.bench.run_until_idle()
    assert [level for _, level in r.edges("pulse", start)] == [0, 1] * 4
    (complete,) = r.falls("motion_complete")
    (busy, up), *more = r.edges("ready", start)
    assert up == 1 and not more and r.falls("pulse")[-1] < complete < busy


@pytest.mark.fact("CMD-T-1", "CMD-PLUS-1", "CMD-MINUS-1")
def test_to_and_fro_until_dowhile_is_high(rig):
    r = rig(record=("run", OUT, "pulse", "direction"), position=0, divisor=1)
    r.drive("dowhile", 0)
    r.start(ascii_of("to_and_fro"))
    assert r.x.program == bytes.fromhex("42 2B 47 43 2D 47 54 00 42 43 00")
    r.bench.run_until(lambda: len(r.x.steps()) == 3 * 6 + 2)
    r.drive("dowhile", 1)
    r.bench.run_until_idle()
    steps = r.x.steps()
    assert steps.directions.tolist() == [1, 1, 1, -1, -1, -1] * 4 and r.x.position == 0
    assert [r.bench.edges(f"x.{pin}")[1].tolist() for pin in (OUT, "direction")] == [[0] + [1, 0] * 5, [0, 1] * 3 + [0]]
    assert [level for _, level in r.edges("run")] == [0, 1]
    out = dict(r.edges(OUT))
    at = lambda time: [level for when, level in out.items() if when <= time][-1]  # noqa: E731
    assert [at(int(time)) for time in steps.times_ps] == [1, 1, 1, 0, 0, 0] * 4


# --------------------------------------------------------------------------------------------------- programs of s.11
@pytest.mark.fact("BIN-11", "EXAMPLE-11-1", "EXAMPLE-11-2")
@pytest.mark.parametrize("mode", [1, 0])
def test_five_steps_in_both_modes(rig, mode):
    r = rig(record=(OUT, "ready", "pulse", "motion_complete", "instrobe"), divisor=1, position=0)
    r.drive("ascii_binary", mode)
    stream = ascii_of("five_steps").encode() if mode else binary_of("five_steps")
    assert len(stream) == (26 if mode else 19)
    r.send(stream)
    assert len(r.falls("instrobe")) == len(stream)
    assert [level for _, level in r.edges(OUT)] == [0, 1]
    assert r.host.verify(3) == bytes.fromhex("00 05 FE 64 03 01")
    assert [level for _, level in r.edges("pulse")] == [0, 1] * 5 and r.x.position == 5
    accepted = r.rises("instrobe")[len(stream) - 1]
    complete = r.falls("motion_complete")[0]
    ready = r.edges("ready")[2 * len(stream) - 2 : 2 * len(stream)]
    assert ready == [(accepted + 10 * US, 0), (ready[1][0], 1)] and ready[1][0] > complete  # no false READY between
    assert r.codes == ["uninitialised"]  # Z


@pytest.mark.fact("BIN-5")
def test_oscilloscope_gives_the_same_picture_after_every_reset(rig):
    pins = (OUT, "ready", "pulse", "motion_complete", "direction", "phase1", "phase2", "phase3", "phase4", "slew")
    r = rig(record=pins, straps={"ascii_binary": 0}, position=0, divisor=1)
    stream, pictures = binary_of("oscilloscope"), []
    for _ in range(3):
        r.x.reset()
        r.bench.run("100 us")
        start = r.bench.now_ps
        r.send(stream)
        assert r.level("motion_complete") == 0
        pictures.append([[(ticks([start, time]), level) for time, level in r.edges(pin, start)] for pin in pins])
        r.bench.run("1 ms")
    assert pictures[0] == pictures[1] == pictures[2]
    assert [level for _, level in pictures[0][0]] == [0] and [level for _, level in pictures[0][2]] == [0, 1] * 5
    assert r.x.position == 15 and r.codes == ["uninitialised"]  # Z


# ------------------------------------------------------------------------------------- continuous motion, figure 7.9
@pytest.mark.fact("CMD-H-2", "CMD-H-1")
def test_haltmode_holds_for_one_motion(rig):
    r = rig(record=("motion_complete",))
    r.host.send("A 0\r" + ascii_of("continuous"))
    pass_motions(r, 1)
    assert r.x.travel == 1000
    r.bench.run("200 s")
    assert r.x.travel > 150_000 and r.level("slew") == 0 and r.level("ready") == 0
    r.drive("abort", 0)
    r.bench.run_until_idle()
    stopped = r.x.travel
    r.drive("abort", 1)
    r.send(ascii_of("continuous", 1))
    assert r.x.travel == stopped + 1000 and r.level("motion_complete") == 0


@pytest.mark.fact("CMD-H-1")
def test_continuous_start(rig):
    r = rig(record=("slew",))
    r.host.send("A 0\r" + ascii_of("continuous_start"))
    r.bench.run("100 s")
    steps = r.x.steps("90 s")
    assert set(ticks(steps.times_ps)) == {1840} and r.x.travel > 500_000 and r.falls("slew") and not r.rises("slew")
    r.drive("abort", 0)
    r.bench.run_until_idle()
    assert r.level("motion_complete") == 0 and r.codes == []


@pytest.mark.fact("EXAMPLE-7.9", "CMD-P-2", "CMD-P-3")
def test_directions_of_four_motions(rig):
    r = rig(record=("direction", "motion_complete"), crystal="6 MHz")
    stream = ascii_of("directions")
    assert stream.endswith("P 2\rP 0\r+\rG\r-\rG\r")
    r.send(stream)
    assert r.x.steps().directions.tolist() == [1, 1, -1, -1] * 2
    first = [int(time) for time in r.x.steps().times_ps[::2]]
    shown = [([1] + [level for time, level in r.edges("direction") if time <= begin])[-1] for begin in first]
    assert shown == [1, 0, 1, 0] and moves(r) == [2, 0, 2, 0]


# ------------------------------------------------------------------------------------------------------ control panel
@pytest.mark.fact("CMD-J-3", "PROG-5")
def test_panel_shuttles_for_ever(rig):
    r = rig(record=("run", OUT, "motion_complete"))
    r.start(ascii_of("panel"))
    assert r.x.program == bytes.fromhex("43 50 E2 04 42 50 00 00 4A 00")
    assert [r.x.registers[name] for name in ("number", "rate", "firstrate", "slope", "divisor")] == [1, 10, 3, 1, 1]
    pass_motions(r, 4)
    assert moves(r) == [1250, 0, 1250, 0]
    assert [(level, r.x.position_at(time)) for time, level in r.edges(OUT)] == [(0, 0), (1, 1250), (0, 0), (1, 1250)]
    assert [level for _, level in r.edges("run")] == [0]
