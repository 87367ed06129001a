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
    assert r.codes == []


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
def test_what_does_not_fit_is_dropped_and_a_cut_instruction_is_filled_with_zeros(rig):
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
    r.enter("A 258", "B", "D 258", "F 3", "H", "I", "J 59", "L 3,11", "L 3 11", "N 258", "O 200", "P 258", "R 100", "T 7")
    stored = "41 02 01 42 44 02 01 46 03 48 49 4A 3B 4C 03 0B 4C 03 0B 4E 02 01 4F C8 50 02 01 52 64 54 07"
    assert r.host.verify(1, 32) == bytes.fromhex(stored) + b"\0"
    r.enter("C", "G", "S 9", "U", "V 3", "W", "X", "Z 4", "+", "-", "0")
    assert r.host.verify(1, 15) == bytes.fromhex("43 47 53 09 55 56 03 57 58 5A 04 2B 2D 00 00")
    assert r.codes == []


# ---------------------------------------------------------------------------------------------------------- execution
@pytest.mark.fact("CMD-X-1", "PROG-8", "UND-PROG-TIME", "PROG-4")
def test_a_program_runs_fast_and_as_often_as_one_likes(rig):
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
def test_reset_breaks_an_endless_program_off(rig):
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


# ----------------------------------------------------------------------------------------------------------- branches
@pytest.mark.fact("CMD-J-1")
def test_jump_goes_on_at_a_byte_of_the_program(rig):
    r = rig(record=(OUT,))
    r.enter("C", "J 4", "B", "0")
    assert r.x.program == bytes.fromhex("43 4A 04 42 00")
    r.execute()
    assert levels(r.edges(OUT)) == [0]


@pytest.mark.fact("CMD-J-2")
def test_jump_as_a_command_starts_the_program_in_the_middle(rig):
    r = rig(record=("run", OUT))
    r.enter("C", "B", "0")
    r.execute("J 1")
    assert levels(r.edges("run")) == [0, 1] and not r.edges(OUT) and r.level(OUT) == 1


@pytest.mark.fact("CMD-J-4", "UND-JUMP-MID")
def test_jump_does_not_ask_whether_its_target_begins_an_instruction(rig):
    r = rig(record=("run", OUT))
    r.send("C\rR 10\r")
    r.enter("R 66", "0")
    r.execute("J 1")
    assert r.level(OUT) == 1 and levels(r.edges("run")) == [0, 1]
    assert r.x.registers["rate"] == 10 and r.codes == []
    r.enter("N 17152", "0")  # 4E 00 43: byte 1 is the stop
    r.execute("J 1")
    assert r.level(OUT) == 1
    r.enter("N 17153", "0")  # 4E 01 43: byte 1 is no opcode, byte 2 is C
    r.execute("J 1")
    assert r.level(OUT) == 0 and r.codes == ["unknown-opcode"]


@pytest.mark.fact("UND-JUMP-RANGE")
@pytest.mark.parametrize("target", [60, 200])
def test_a_target_outside_the_buffer_leaves_the_chip_in_run_mode(rig, target):
    r = rig()
    r.send("C\r")
    r.enter(f"J {target}", "B", "0")
    r.start("X\r")
    r.bench.run("1 s")
    assert r.level("run") == 0 and r.level(OUT) == 0
    assert r.codes == ["range", "bad-target"]
    r.host.live("J 2")
    r.bench.run_until_idle()
    assert r.level("run") == 1 and r.level(OUT) == 1


@pytest.mark.fact("CMD-T-1")
def test_til_branches_while_dowhile_is_low(rig):
    r = rig(number=1, firstrate=10)
    r.drive("dowhile", 0)
    r.enter("G", "T 0", "0")
    r.start("X\r")
    r.bench.run_until(lambda: r.x.travel == 20)
    assert r.level("run") == 0
    r.drive("dowhile", 1)
    r.bench.run_until_idle()
    assert r.level("run") == 1 and r.x.travel == 20


@pytest.mark.fact("CMD-L-1", "UND-L0")
@pytest.mark.parametrize(("count", "passes"), [(1, 1), (3, 3), (255, 255), (0, 256)])
def test_a_loop_makes_as_many_passes_as_it_counts(rig, count, passes):
    r = rig(number=1, firstrate=100, rate=100)
    r.enter("G", f"L {count},0", "0")
    for run in (1, 2):  # and again in full
        r.execute()
        assert r.x.travel == run * passes
    assert ("loop-zero" in r.codes) == (count == 0)


@pytest.mark.fact("CMD-L-3", "UND-LOOP-NEST")
def test_there_is_one_loop_counter_and_another_loop_takes_it_over(rig):
    r = rig()
    r.send("A 0\rN 1\rS 9\rR 10\rF 3\rZ 1\r")
    r.enter("L 3,6", "B", "B", "0", "G", "L 9,6", "0")
    for run in (1, 2):
        r.execute()
        assert r.x.position == 2 * run  # two passes are left of the three
        assert r.codes == ["nested-loop"]
    r.execute("J 6")
    assert r.x.position == 4 + 9  # the counter was free


@pytest.mark.fact("UND-LOOP-EXIT")
@pytest.mark.parametrize("back", ["J 0", "X"])
def test_a_loop_that_is_left_keeps_its_count(rig, back):
    r = rig(record=("ready",), number=1, firstrate=10, rate=10)
    r.drive("wait", 0)
    r.enter("G", "D 20", "T 10", "L 5,0", "0", "W", back)
    r.start("X\r")
    r.bench.run("50 ms")  # in the third delay: three passes are left
    assert r.x.travel == 3
    r.drive("dowhile", 0)
    r.bench.run("50 ms")
    assert r.x.travel == 3 and r.x.waiting.startswith("x: W")
    r.drive("dowhile", 1)
    r.drive("wait", 1)
    r.bench.run_until_idle()
    assert r.x.travel == 3 + 3


@pytest.mark.fact("UND-LOOP-EXIT")
@pytest.mark.parametrize("restart", ["0 X", "0 J 0", "live X", "live J 0", "0 I", "reset"])
def test_a_stop_and_a_start_from_outside_clear_the_count(rig, restart):
    r = rig(number=1, firstrate=10, rate=10)
    program = ("G", "D 20", "L 3,0", "0")
    r.enter(*program)
    r.start("X\r")
    r.bench.run("30 ms")
    assert r.x.travel == 2
    word, _, rest = restart.partition(" ")
    if word == "reset":
        r.x.reset()
        r.bench.run("1 ms")
    else:
        r.host.live(rest if word == "live" else word)
    if word == "live":
        r.bench.run_until_idle()
    else:
        if rest == "I" or word == "reset":
            r.send("I\r")
            r.enter(*program)
        r.execute(rest if rest[:1] == "J" else "X")
    assert r.x.travel == 2 + 3


# -------------------------------------------------------------------------------------------------------------- waits
@pytest.mark.fact("CMD-U-1", "CMD-W-1")
@pytest.mark.parametrize(("letter", "held", "wanted"), [("U", 1, 0), ("W", 0, 1)])
def test_until_and_wait_hold_the_program_for_a_level(rig, letter, held, wanted):
    r = rig(record=(OUT, "run"))
    r.send("C\r")
    r.enter(letter, "B", "0")
    r.drive("wait", held)
    r.start("X\r")
    r.bench.run("2 s")
    assert r.level(OUT) == 0 and r.level("run") == 0
    now = r.bench.now_ps
    r.drive("wait", wanted)
    r.bench.run_until_idle()
    ((set_at, _),) = r.edges(OUT, now)
    assert set_at - now <= (8 + 40) * US  # the next look, and one instruction
    start = r.bench.now_ps + 1
    r.execute()  # the level is there already
    (fell, _), (rose, _) = r.edges("run", start)
    assert rose - fell == (60 + 40 + 36) * US


@pytest.mark.fact("CMD-UW-1")
@pytest.mark.parametrize(("first", "second", "idle"), [("U", "W", 1), ("W", "U", 0)])
def test_a_pair_of_waits_finds_an_edge(rig, first, second, idle):
    r = rig()
    r.send("C\r")
    r.enter(first, second, "B", "0")
    r.drive("wait", idle)
    r.start("X\r")
    r.bench.run("1 s")
    r.drive("wait", 1 - idle)
    r.bench.run("1 s")
    assert r.level(OUT) == 0 and r.level("run") == 0
    r.drive("wait", idle)
    r.bench.run("1 ms")
    assert r.level(OUT) == 1 and r.level("run") == 1


@pytest.mark.fact("CMD-UW-2", "UND-UW-BYTE")
@pytest.mark.parametrize(("letter", "held"), [("U", 1), ("W", 0)])
def test_a_request_ends_a_wait_and_carries_no_byte(rig, letter, held):
    r = rig(record=("instrobe", "ready", "pulse"), number=1, firstrate=10, rate=10)
    r.send("C\r")
    r.enter(letter, "B", "D 5", "G", "0")
    r.drive("wait", held)
    r.start("X\r")
    r.bench.run("1 s")
    assert r.level(OUT) == 0
    now = r.bench.now_ps
    r.pull_request("20 ms", b"C")
    r.bench.run("10 ms")
    assert r.level(OUT) == 1 and not r.edges("instrobe", now)
    assert r.x.travel == 0 and not r.falls("pulse")  # the motion waits for the end of the request
    r.bench.run("15 ms")
    assert r.x.travel == 1 and r.level("run") == 1 and r.level(OUT) == 1 and not r.edges("instrobe", now)
    assert r.codes == ["uninitialised"] * 5


@pytest.mark.fact("UND-UW-BYTE")
def test_with_prog_live_low_the_request_that_ends_a_wait_is_the_first_live_byte(rig):
    r = rig(record=("instrobe",))
    r.send("B\r")
    r.enter("U", "D 500", "0")
    r.drive("wait", 1)
    r.start("X\r")
    r.bench.run("10 ms")
    r.drive("prog", 0)
    now = r.bench.now_ps
    r.host.send("C\r")
    r.bench.run("1 ms")
    assert r.level(OUT) == 0 and r.level("run") == 0 and len(r.falls("instrobe", now)) == 2


@pytest.mark.fact("UND-D-LIVE")
def test_a_delay_runs_to_its_end_whatever_the_host_pulls(rig):
    r = rig(record=("run",))
    r.enter("D 100", "0")
    r.start("X\r")
    r.pull_request("20 ms")
    r.bench.run("30 ms")
    r.drive("prog", 0)
    r.bench.run("30 ms")
    r.x.pin("prog").release()
    r.bench.run_until_idle()
    (fell, _), (rose, _) = r.edges("run")
    assert rose - fell == 100 * MS + (60 + 36) * US


# ------------------------------------------------------------------------------------------------------------- labels
@pytest.mark.fact("LABEL-1", "LABEL-2", "LABEL-4", "LABEL-6", "CON-VERIFY-BYTES")
def test_five_labels_in_any_order_take_no_room_and_become_addresses_when_executed(rig):
    r = rig(record=("run",))
    r.enter("J E", "A$0", "B$J A", "C$J B", "D$J C", "E$J D")
    letters = "4A 45 00 4A 41 4A 42 4A 43 4A 44 00"
    assert r.host.verify(1, 12) == bytes.fromhex(letters)
    r.execute()
    assert r.host.verify(1, 12) == bytes.fromhex("4A 09 00 4A 02 4A 03 4A 05 4A 07 00")
    for _ in range(2):  # the second time on addresses
        (fell, _), (rose, _) = r.edges("run")[-2:]
        assert rose - fell == (60 + 4 * 40 + 36) * US
        r.execute()
    assert r.codes == []


@pytest.mark.fact("LABEL-1")
def test_a_label_names_the_instruction_behind_it(rig):
    r = rig()
    r.send("E\rB\rC$C\rJ C\rQ")
    assert r.x.program == bytes.fromhex("42 43 4A 43")
    r.start("X\r")
    r.bench.run("1 ms")
    assert r.x.program == bytes.fromhex("42 43 4A 01")


@pytest.mark.fact("LABEL-6")
def test_a_label_may_stand_behind_its_use(rig):
    r = rig(record=(OUT,))
    r.enter("J B", "C", "B$B", "0")
    r.execute()
    assert r.level(OUT) == 1 and not r.edges(OUT)


@pytest.mark.fact("LABEL-7")
def test_a_letter_is_a_label_only_with_its_mark(rig):
    r = rig()
    r.enter("C$C", "C")
    assert r.x.program == b"CC"
    r.enter("A$A 5")
    assert r.x.program == bytes.fromhex("41 05 00")
    r.enter("B$D 1", "E$E")
    assert r.x.program == bytes.fromhex("44 01 00 45") and r.codes == []


@pytest.mark.fact("LABEL-3", "CON-T-LABEL", "LABEL-4", "UND-LABEL-LIFE")
def test_each_branch_is_replaced_the_first_time_it_is_executed(rig):
    r = rig()
    r.enter("T C", "L 1,B", "A$0", "B$J A", "C$J B")
    letters = bytes.fromhex("54 43 4C 01 42 00 4A 41 4A 42")
    assert r.x.program == letters
    r.execute("J C")  # in command mode the label is known too
    assert r.x.program == bytes.fromhex("54 43 4C 01 42 00 4A 05 4A 06")  # T and L were not executed
    r.execute()  # T does not branch, nor does L, and both are replaced all the same
    assert r.x.program == bytes.fromhex("54 08 4C 01 06 00 4A 05 4A 06")
    assert r.codes == []


@pytest.mark.fact("UND-LABEL-LIFE")
@pytest.mark.parametrize("clear", ["E", "I", "RESET"])
def test_labels_live_until_enter_initialize_or_reset(rig, clear):
    r = rig()
    r.enter("A$B", "0")
    r.execute("J A")
    assert r.codes == []
    if clear == "RESET":
        r.x.reset()
        r.bench.run("1 ms")
    else:
        r.send("E\rQ" if clear == "E" else "I\r")
    r.start("J A\r")
    r.bench.run("1 ms")
    assert r.codes == ["missing-label", "bad-target"] and r.level("run") == 0


@pytest.mark.fact("UND-LABEL-MISSING")
@pytest.mark.parametrize("branch", ["J B", "L 3,B", "T B"])
def test_a_label_that_is_nowhere_leads_outside_the_program(rig, branch):
    r = rig()
    r.drive("dowhile", 0)
    r.send("C\r")
    r.enter(branch, "B", "0")
    stored = r.x.program
    r.start("X\r")
    r.bench.run("1 s")
    assert r.x.program == stored and stored.count(b"B") == 2
    assert r.level("run") == 0 and r.level(OUT) == 0 and r.codes == ["missing-label", "bad-target"]


@pytest.mark.fact("UND-LABEL-TWICE")
def test_the_last_definition_of_a_label_wins(rig):
    r = rig(record=(OUT,))
    r.enter("J A", "A$C", "A$B", "0")
    assert r.codes == ["label-twice"]
    r.execute()
    assert r.x.program == bytes.fromhex("4A 03 43 42 00") and not r.edges(OUT)


@pytest.mark.fact("UND-LABEL-COMMAND")
def test_a_label_outside_program_entry_is_ignored(rig):
    r = rig()
    r.send("A$C\r")
    assert r.level(OUT) == 0 and r.codes == ["label-outside-program"]
    r.enter("0", "B")
    r.start("J A\r")
    r.bench.run("1 ms")
    assert r.codes[1:] == ["missing-label", "bad-target"]


@pytest.mark.fact("UND-LABEL-LETTER")
@pytest.mark.parametrize("label", ["F", "J", "Z", "A "])
def test_other_letters_are_no_labels(rig, label):
    r = rig()
    r.enter(f"{label}$B", "C")
    assert r.x.program == b"C" and r.codes == ["unknown-command"]


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
    r.host.do(lambda port: r.host.fetch(port, 2))
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
