"""CY525 stored programs: entry, labels, branches, loops and waits, and where a program that is not one ends up."""

from __future__ import annotations

import pytest

US = 1_000_000  # picoseconds
MS = 1000 * US
OUT = "programmable_output"


def levels(edges):
    return [level for _, level in edges]


# -------------------------------------------------------------------------------------------------------------- entry
@pytest.mark.fact("CMD-E-1", "PROG-10")
def test_commands_between_enter_and_quit_are_stored_and_not_executed(rig):
    r = rig(record=(OUT, "prog", "ready"))
    r.send("C\r")
    start = r.bench.now_ps
    r.send("E\r")
    assert levels(r.edges("prog")) == [0] and r.edges("prog")[0][0] < r.rises("ready", start)[-1]
    r.send("B\rC\r")
    assert not r.edges(OUT, start) and r.level("prog") == 0
    r.send("Q")
    assert r.level("prog") == 1
    assert r.host.verify(1, 3) == b"BC\0"  # no carriage return in it
    assert r.codes == ["unfinished"]  # before the Q


@pytest.mark.fact("CMD-E-2", "UND-PROG-STALE", "CMD-E-1")
def test_a_program_stays_until_the_next_one_replaces_it(rig):
    r = rig(record=(OUT,))
    r.enter("B", "N 5", "0")
    for _ in range(2):
        r.execute()
        assert r.level(OUT) == 1
        r.send("C\r")
    r.send("B\r")
    r.enter("C", "0")
    r.execute()
    assert r.level(OUT) == 0
    assert r.host.verify(1) == b"C".ljust(48, b"\0")  # nothing of the longer one shows behind it


@pytest.mark.fact("PROG-1", "CON-BUFFER-48")
def test_the_buffer_holds_60_bytes_and_a_jump_reaches_the_last(rig):
    r = rig(record=("run", OUT))
    r.send("C\r")
    r.enter("J 59", *"B" * 57, "0")
    assert len(r.x.program) == 60 and r.codes == []
    assert r.host.verify(1, 60) == b"J\x3b" + b"B" * 57 + b"\0"
    assert r.codes == ["verify-48"]
    start = r.bench.now_ps
    r.execute()
    assert not r.edges(OUT, start)
    (fell, _), (rose, _) = r.edges("run", start)
    assert rose - fell == (60 + 36) * US  # the jump, then the stop
    start = r.bench.now_ps + 1
    r.execute("J 2")
    assert r.level(OUT) == 1
    (fell, _), (rose, _) = r.edges("run", start)
    assert rose - fell == (60 + 56 * 40 + 36) * US  # every one of the 57 is performed


@pytest.mark.fact("UND-OVERFLOW", "UND-PROG-END")
def test_surplus_bytes_are_dropped_and_a_cut_instruction_is_filled_with_zeros(rig):
    r = rig(record=("run", "prog"))
    r.send("N 1000\r")
    r.enter(*"B" * 58, "N 300", "C", "0")
    assert r.codes == ["overflow"] and r.level("prog") == 1
    assert r.x.program == b"B" * 58 + b"N\x2c"
    r.start("X\r")
    r.bench.run("1 s")
    assert r.x.registers["number"] == 0x2C
    assert r.level("run") == 0 and r.level(OUT) == 1 and r.codes[1:] == ["end-of-program"]


@pytest.mark.fact("PROG-2", "CMD-L-2")
def test_the_stored_form_of_every_command(rig):
    r = rig()
    r.enter(
        "A 258", "B", "D 258", "F 3", "H", "I", "J 59", "L 3,11", "L 3 11", "N 258", "O 200", "P 258", "R 100", "T 7"
    )
    stored = "41 02 01 42 44 02 01 46 03 48 49 4A 3B 4C 03 0B 4C 03 0B 4E 02 01 4F C8 50 02 01 52 64 54 07"
    assert r.host.verify(1, 32) == bytes.fromhex(stored) + b"\0"
    r.enter("C", "G", "S 9", "U", "V 3", "W", "X", "Z 4", "+", "-", "0")
    assert r.host.verify(1, 15) == bytes.fromhex("43 47 53 09 55 56 03 57 58 5A 04 2B 2D 00 00")
    assert r.codes == []


# ---------------------------------------------------------------------------------------------------------- execution
@pytest.mark.fact("CMD-X-1", "PROG-8", "UND-PROG-TIME", "PROG-4")
def test_a_program_runs_fast_and_any_number_of_times(rig):
    r = rig(record=("ready", "run", OUT))
    r.send("C\r")
    r.enter("B", "C", "0")
    for _ in range(3):
        start = r.bench.now_ps + 1
        r.execute()
        taken = r.falls("ready", start)[1]  # the carriage return of X
        assert r.edges("run", start) == [(taken + 150 * US, 0), (taken + (150 + 60 + 40 + 36) * US, 1)]
        assert r.edges(OUT, start) == [(taken + 210 * US, 1), (taken + 250 * US, 0)]
    assert r.host.verify(1, 4) == b"BC\0\0"


@pytest.mark.fact("CMD-X-2", "PROG-5")
def test_execute_in_a_program_starts_it_again_with_the_parameters_of_then(rig):
    r = rig(record=("run", "motion_complete"))
    r.send("F 3\rS 255\rZ 1\rN 1000\rR 80\r")
    r.enter("G", "R 60", "X")
    r.start("X\r")
    r.bench.run_until(r.x.pin("motion_complete").edges(6))  # three motions
    ends = r.falls("motion_complete")
    shortest = []
    for begin, end in zip([0, *ends], ends, strict=False):
        times = r.x.steps(begin, end).times_ps
        assert len(times) == 1000
        shortest.append(round(int((times[1:] - times[:-1]).min()) * 11 / US))
    assert shortest == [1840, 2140, 2140]  # 5978, then 5141 steps/s
    assert levels(r.edges("run")) == [0]


@pytest.mark.fact("CMD-X-3", "UND-PROG-END", "CON-IDLE-X")
@pytest.mark.parametrize("lines", [None, (), ("B",)])
def test_without_a_stop_the_chip_stays_in_run_mode_until_a_live_0(rig, lines):
    r = rig(record=("run", "instrobe"))
    r.send("C\r")
    if lines is None:
        r.send("I\r")
    else:
        r.enter(*lines)
    r.start("X\r")
    r.bench.run("10 s")
    assert r.level("run") == 0 and r.level(OUT) == (1 if lines else 0) and r.codes == ["end-of-program"]
    r.host.live("0")
    assert r.level("run") == 1
    r.send("B\r")
    assert r.level(OUT) == 1


@pytest.mark.fact("PROG-6")
def test_a_command_without_prog_live_is_not_taken_while_a_program_runs(rig):
    r = rig(record=("instrobe", OUT))
    r.send("C\r")
    r.enter("D 100", "0")
    r.start("X\r")
    start = r.bench.now_ps
    r.host.send("B\r")
    r.bench.run("90 ms")
    assert r.level("run") == 0 and not r.falls("instrobe", start) and not r.edges(OUT, start)
    assert r.codes == ["request-while-running"]


@pytest.mark.fact("CMD-0-1", "PROG-5", "CMD-J-3")
@pytest.mark.parametrize("start", ["X", "J 0"])
def test_the_0_command_ends_the_program(rig, start):
    r = rig(record=("run", OUT))
    r.send("C\r")
    r.enter("B", "0", "C")
    assert r.host.verify(1, 3) == bytes.fromhex("42 00 43")
    begin = r.bench.now_ps
    r.execute(start)
    (fell, low), (rose, high) = r.edges("run", begin)
    assert (low, high) == (0, 1)
    assert r.edges(OUT, begin) == [(fell + 60 * US, 1)] and rose == fell + 96 * US


@pytest.mark.fact("CMD-I-3", "PROG-5")
def test_initialize_in_a_program_ends_and_erases_it(rig):
    r = rig(record=("run",))
    r.send("C\rO 1\r-\rN 9\r")
    r.enter("B", "I", "C", "0")
    r.execute()
    assert (r.level(OUT), r.level("run"), r.level("direction")) == (1, 1, 1)
    assert r.phases == (1, 1, 1, 1) and r.x.program == b"" and r.x.registers["number"] == 9
    r.send("C\r")
    r.start("X\r")
    r.bench.run("1 s")
    assert r.level("run") == 0 and r.level(OUT) == 0


@pytest.mark.fact("PROG-7", "PROG-5")
def test_reset_aborts_an_endless_program(rig):
    r = rig(record=("run", "pulse"), crystal="6 MHz")
    r.send("A 0\rO 1\rF 10\rR 10\rN 500\r")
    r.enter("G", "J 0")
    r.start("X\r")
    r.bench.run("2 s")
    assert levels(r.edges("run")) == [0] and r.level("ready") == 0
    now = r.bench.now_ps
    r.x.pin("reset").pulse(0, "20 us")
    r.bench.run("100 us")
    assert r.levels("run", "pulse", "ready") == (1, 1, 1) and r.phases == (1, 1, 1, 1)
    moved = r.x.travel
    r.bench.run("1 s")
    assert r.x.travel == moved and not r.falls("pulse", now + 20 * US)


# ------------------------------------------------------------------------------- commands that are odd in a program
@pytest.mark.fact("UND-PROG-E")
def test_enter_inside_a_program_is_stored_and_skipped(rig):
    r = rig(record=("prog", OUT))
    r.enter("B", "E", "C", "0")
    assert r.x.program == bytes.fromhex("42 45 43 00") and r.codes == []
    start = r.bench.now_ps
    r.execute()
    assert r.level(OUT) == 0 and r.codes == ["enter-while-running"]
    assert r.x.program == bytes.fromhex("42 45 43 00") and not r.edges("prog", start)


@pytest.mark.fact("UND-PROG-E")
def test_enter_as_a_live_command_is_refused(rig):
    r = rig()
    r.enter("D 50", "C", "0")
    r.start("X\r")
    r.host.live("E", "B")
    assert r.codes == ["enter-while-running"] and r.level(OUT) == 1
    r.bench.run_until_idle()
    assert r.x.program == bytes.fromhex("44 32 00 43 00") and r.level(OUT) == 0


@pytest.mark.fact("UND-PROG-V")
def test_verify_in_a_program_only_points(rig):
    r = rig(record=("outstrobe", "ready"))
    r.send("N 513\rV 0\r")
    r.enter("V 3", "0")
    start = r.bench.now_ps
    r.execute()
    assert not r.edges("outstrobe", start) and r.codes == ["verify-in-program"]
    r.host.do(lambda port: port.fetch(2))
    r.bench.run_until_idle()
    assert bytes(r.host.received) == bytes.fromhex("02 01")


@pytest.mark.fact("UND-LIVE-QEX")
@pytest.mark.parametrize(
    ("live", "out", "run", "travel", "codes"),
    [
        (["X"], 1, 0, 1, []),  # starts again: B, G, and in the delay
        (["J 6"], 0, 1, 0, []),
        (["I"], 1, 1, 0, []),
        (["Q", "R 20"], 0, 1, 0, ["quit-outside-entry"]),
        (["G"], 0, 1, 1, []),
        (["P 44"], 0, 1, 3, []),
        (["H"], 0, 1, 0, []),
    ],
)
def test_live_commands_that_touch_the_program_or_the_motor(rig, live, out, run, travel, codes):
    r = rig(record=("run", "pulse"))
    r.send("F 10\rR 20\rS 255\rZ 1\rN 1\rA 40\r")
    r.enter("B", "G", "D 20", "B", "C", "0")
    r.start("X\r")
    r.bench.run("10 ms")
    assert r.x.travel == 1
    r.host.live(*live)
    r.bench.run("10 ms")
    assert (r.level(OUT), r.level("run"), r.x.travel - 1) == (out, run, travel)
    assert r.codes == codes
    if live == ["I"]:
        assert r.x.program == b""
    if live == ["H"]:  # the next motion has no end
        r.send("N 1000\r")
        r.start("G\r")
        r.bench.run("2 s")
        assert r.x.travel > 2000 and r.level("slew") == 0
