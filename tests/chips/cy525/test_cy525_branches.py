"""Branches, loops, waits and labels of CY525 programs."""

from __future__ import annotations

import pytest

US = 1_000_000  # picoseconds
MS = 1000 * US
OUT = "programmable_output"


def levels(edges):
    return [level for _, level in edges]


# ----------------------------------------------------------------------------------------------------------- branches
@pytest.mark.fact("CMD-J-1")
def test_jump_continues_at_a_byte_of_the_program(rig):
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
def test_jump_does_not_check_whether_its_target_begins_an_instruction(rig):
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
def test_a_loop_makes_the_counted_number_of_passes(rig, count, passes):
    r = rig(number=1, firstrate=100, rate=100)
    r.enter("G", f"L {count},0", "0")
    for run in (1, 2):  # and again in full
        r.execute()
        assert r.x.travel == run * passes
    assert ("loop-zero" in r.codes) == (count == 0)


@pytest.mark.fact("CMD-L-4")
def test_a_loop_that_has_run_out_counts_in_full_the_next_time(rig):
    r = rig(number=1, firstrate=100, rate=100)
    r.enter("G", "L 3,0", "T 0", "0")
    r.drive("dowhile", 0)
    r.start("X\r")
    r.bench.run_until(lambda: r.x.travel == 4)
    r.drive("dowhile", 1)
    r.bench.run_until_idle()
    assert r.x.travel == 6


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
    assert r.x.travel == 3 and r.x.waiting.startswith("x: waiting for wait=1 (W)")
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


@pytest.mark.fact("CMD-UW-2", "UND-UW-BYTE")
def test_a_request_that_outlasts_the_program_is_still_no_byte(rig):
    r = rig(record=("instrobe", "ready", "run"))
    r.enter("U", "0")
    r.drive("wait", 1)
    r.start("X\r")
    r.bench.run("1 ms")
    now = r.bench.now_ps
    r.pull_request("10 ms", b"K")
    r.bench.run("5 ms")
    assert r.level("run") == 1 and not r.edges("instrobe", now) and not r.edges("ready", now)
    r.bench.run("10 ms")
    r.send("C\r")
    assert r.level(OUT) == 0 and len(r.falls("instrobe", now)) == 2 and r.codes == []


@pytest.mark.fact("CMD-UW-2")
def test_a_request_from_before_the_wait_ends_it_and_is_served_after_the_program(rig):
    r = rig(record=("instrobe",))
    r.send("C\r")
    r.enter("D 20", "U", "0")
    r.drive("wait", 1)
    r.start("X\r")
    taken = len(r.falls("instrobe"))
    r.host.send("B\r")
    r.bench.run("19 ms")
    assert len(r.falls("instrobe")) == taken and r.level(OUT) == 0
    r.bench.run_until_idle()
    assert r.level("run") == 1 and r.level(OUT) == 1
    assert r.codes == ["request-while-running", "request-while-running"]  # READY was high all the time
    assert [f.text for f in r.x.findings][1] == "I/O REQUEST is still low as the program ends: it is served now"


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
def test_a_delay_ends_on_time_whatever_the_host_pulls(rig):
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
def test_a_label_names_the_instruction_after_it(rig):
    r = rig()
    r.send("E\rB\rC$C\rJ C\rQ")
    assert r.x.program == bytes.fromhex("42 43 4A 43")
    r.start("X\r")
    r.bench.run("1 ms")
    assert r.x.program == bytes.fromhex("42 43 4A 01")


@pytest.mark.fact("LABEL-6")
def test_a_label_may_follow_its_use(rig):
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
def test_an_undefined_label_leads_outside_the_program(rig, branch):
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
def test_other_letters_are_not_labels(rig, label):
    r = rig()
    r.enter(f"{label}$B", "C")
    assert r.x.program == b"C" and r.codes == ["unknown-command"]
