"""The CY545: programs as they are entered, stored and run, and what immediate commands do to one that runs."""

from __future__ import annotations

import pytest
from cy545 import CC10, MS, SHUTTLE, US, Rig545, S


@pytest.fixture
def rig() -> Rig545:
    return Rig545("pulse", "busy", "ccw", "stopped", "usrb6")


# -------------------------------------------------------------------------------------------------------------- entry
@pytest.mark.fact(
    "CY545-CMD-E-1", "CY545-CMD-Q-1", "CY545-CMD-Q-2", "CY545-XMEM-15", "CY545-XMEM-17", "CY545-EXAMPLE-CC10-1"
)
def test_a_program_is_stored_byte_for_byte_from_the_pointer_on(rig: Rig545) -> None:
    rig.send(CC10)
    assert rig.ram.content[10:33] == b"N 1\r+\rG\rD 2000\rL 50,16\r"
    assert rig.ram.content[:10] == rig.ram.content[33:43] == b"\xff" * 10
    assert not rig.falls("pulse")
    assert rig.say("? Y") == "Y=00033\r"
    rig.send("-\rG\r")
    assert len(rig.falls("pulse")) == 200  # N 1 is stored, not performed
    assert not rig.codes


@pytest.mark.fact("CY545-EXAMPLE-CC10-1", "CY545-EXAMPLE-CC10-2", "CY545-CMD-L-1", "CY545-UND-CMD-TIME")
def test_the_delay_example_steps_50_times_once_every_two_seconds(rig: Rig545) -> None:
    rig.send(CC10)
    rig.ram.load(b"0\r", at=33)
    rig.run_program(10, "200 s")
    steps = rig.x.steps()
    assert len(steps) == 50
    assert set(steps.directions.tolist()) == {1}
    apart = [b - a for a, b in zip(steps.times_ps, steps.times_ps[1:], strict=False)]
    assert all(between / S == pytest.approx(2.008, rel=0.01) for between in apart)
    assert max(apart) - min(apart) < US
    assert rig.x.registers["pointer"] == 35
    assert not rig.codes


@pytest.mark.fact("CY545-EXAMPLE-SHUTTLE", "CY545-CMD-X-1", "CY545-CMD-0-1", "CY545-CMD-L-2", "CY545-XMEM-13")
def test_a_shuttle_runs_three_times_and_stops(rig: Rig545) -> None:
    rig.send(SHUTTLE)
    rig.run_program()
    assert rig.x.steps().directions.tolist() == ([1] * 100 + [-1] * 100) * 3
    assert rig.say("? P", "? Y") == "P=00000000\rY=00018\r"
    rig.say("R 5")
    assert rig.x.registers["rate"] == 5


@pytest.mark.fact("CY545-UND-ENTRY-Q", "CY545-UND-ENTRY-Q-CR")
def test_q_ends_the_entry_as_the_first_character_of_a_line_only(rig: Rig545) -> None:
    rig.send('Y 0\rE\r"Q"\r? Q\rQ\r+\r')
    assert rig.ram.content[:8] == b'"Q"\r? Q\r'
    assert rig.level("ccw") == 0
    assert not rig.codes


@pytest.mark.fact("CY545-UND-ENTRY-NEST")
def test_e_in_a_program_and_q_outside_entry_do_nothing(rig: Rig545) -> None:
    rig.say("Q")
    assert rig.codes == ["quit-outside-entry"]
    rig.enter("E", "B 16", "E", "0")
    rig.run_program()
    assert rig.level("usrb0") == 0
    assert rig.codes == ["quit-outside-entry", "enter-while-running"]


@pytest.mark.fact("CY545-UND-ENTRY-TIME")
def test_a_stored_character_takes_100_us_and_20_before_them() -> None:
    rig = Rig545("busy")
    rig.send("E\r")
    start = rig.bench.now_ps
    rig.send("A")
    rig.bench.run("1 ms")
    fall = rig.falls("busy", start)[0]
    assert (rig.rises("busy", fall)[0] - fall) / US == pytest.approx(120, abs=1)


@pytest.mark.fact("CY545-XMEM-1")
def test_a_program_runs_at_the_top_of_the_memory_and_wraps(rig: Rig545) -> None:
    rig.ram.load(b"B 17\r0\r")
    rig.ram.load(b"B 16\r", at=65531)
    rig.run_program(65531)
    assert rig.user == "111100"
    assert rig.x.registers["pointer"] == 7


@pytest.mark.fact("CY545-UND-PAGE-CROSS")
def test_a_program_runs_across_a_page(rig: Rig545) -> None:
    rig.ram.load(b"B 16\rB 17\r0\r", at=253)
    rig.run_program(253)
    assert rig.user == "111100"


# ----------------------------------------------------------------------------------------------------------- branches
@pytest.mark.fact("CY545-CMD-J-1")
def test_j_continues_at_a_byte_of_its_page(rig: Rig545) -> None:
    rig.ram.load(b"J 8\rB 16\r0\r", at=512)
    rig.ram.load(b"B 17\r0\r", at=520)
    rig.run_program(512)
    assert rig.user == "111101"


@pytest.mark.fact("CY545-XMEM-16")
def test_the_page_of_a_branch_is_that_of_the_byte_after_it(rig: Rig545) -> None:
    rig.ram.load(b"J 10H\r", at=0x1FA)  # ends at 1FF, so the pointer is at 200
    rig.ram.load(b"B 16\r0\r", at=0x210)
    rig.ram.load(b"B 17\r0\r", at=0x110)
    rig.run_program(0x1FA)
    assert rig.user == "111110"


@pytest.mark.fact("CY545-CMD-Y-1", "CY545-CMD-Y-2")
def test_y_sets_the_pointer_for_a_host_and_jumps_in_a_program(rig: Rig545) -> None:
    rig.ram.load(b"Y 768\r")
    rig.ram.load(b"B 16\r0\r", at=768)
    rig.say("Y 768")
    assert rig.user == "111111"
    rig.run_program(0)
    assert rig.user == "111110"
    assert rig.say("? Y") == "Y=00775\r"


@pytest.mark.fact("CY545-CMD-Z-1", "CY545-CMD-L-2")
@pytest.mark.parametrize(("loop", "passes"), [("L 1,4", 1), ("L 7,4", 7), ("Z 300,4", 300)])
def test_a_loop_runs_its_body_the_stated_number_of_times(rig: Rig545, loop: str, passes: int) -> None:
    rig.enter("N 1", "G", loop, "0")
    rig.run_program()
    assert len(rig.x.steps()) == passes


@pytest.mark.fact("CY545-UND-LOOP-ZERO")
@pytest.mark.parametrize(("letter", "passes"), [("L", 256), ("Z", 65536)])
def test_a_count_of_0_runs_through(letter: str, passes: int) -> None:
    rig = Rig545(inferred={"fetch": 1, "program_command": 1})
    rig.ram.load(f"{letter} 0,0\r0\r".encode())
    seen = []
    rig.x.on_instruction.add(seen.append)
    rig.host.send("X\r")
    while len(seen) < 300 and not (seen and rig.x.idle):
        rig.bench.run("1 ms")
    left = passes - seen.count(0)
    assert left == 0 or rig.x._stored.loops[letter][1] - left in (0, 1)  # the last one may be in work


@pytest.mark.fact("CY545-UND-LOOP-NEST")
def test_z_around_l_works_and_l_around_l_takes_over_its_count(rig: Rig545) -> None:
    rig.send("+\r")
    rig.enter("N 1", "G", "L 3,4", "Z 2,4", "0")
    rig.run_program()
    assert len(rig.x.steps()) == 6
    assert not rig.codes
    rig.enter("N 1", "G", "L 3,4", "L 2,4", "0")
    rig.host.send("Y 0\rX\r")
    rig.bench.run("1 s")
    assert rig.codes == ["nested-loop"]
    assert rig.x.program_counter is not None  # the inner one uses up the count of the outer one, which begins anew
    rig.say("0")


@pytest.mark.fact("CY545-UND-LOOP-CLEAR")
def test_a_count_is_dropped_by_a_stop_and_by_x_and_kept_by_a_jump(rig: Rig545) -> None:
    rig.enter("N 1", "G", "L 3,11", "0", "0")
    rig.run_program()  # L 3,11 goes into the second half of itself: an unknown command, then 0
    assert not rig.x._stored.loops
    rig.enter("L 3,8", "J 20")
    rig.ram.load(b"J 30\r", at=8)
    rig.ram.load(b"L 2,40\r0\r", at=30)
    rig.ram.load(b"0\r", at=40)
    rig.host.send("Y 0\rX\r")
    rig.bench.run_until(rig.x.at_instruction(30), "1 s")
    assert rig.x._stored.loops["L"] == (0, 2)
    rig.bench.run_until_idle()
    assert not rig.x._stored.loops


@pytest.mark.fact("CY545-CMD-T-1")
def test_t_branches_until_the_bits_match(rig: Rig545) -> None:
    rig.enter("N 1", "G", "T 3,4", "0")
    rig.drive("usrb3", 0)
    rig.host.send("Y 0\rX\r")
    rig.bench.run("1 s")
    assert len(rig.x.steps()) > 50
    rig.x.pin("usrb3").release()
    rig.bench.run_until_idle()
    steps = len(rig.x.steps())
    rig.bench.run("1 s")
    assert len(rig.x.steps()) == steps
    assert rig.x.registers["pointer"] == 14


@pytest.mark.fact("CY545-UND-DIRECT-BRANCH")
def test_branches_of_a_host_start_the_program_in_the_page_of_the_pointer(rig: Rig545) -> None:
    rig.ram.load(b"B 16\r0\r", at=0x308)
    for line in ("J 8", "L 2,8", "Z 3,8", "T 1,8"):
        rig.say("B 0", "Y 768")
        rig.drive("usrb1", 0)
        rig.say(line)
        assert rig.user[-1] == "0"
    rig.say("B 0", "Y 768", "L 1,8", "Z 1,8")
    rig.x.pin("usrb1").release()
    rig.say("T 1,8")
    assert rig.user == "111111"
    assert rig.codes == ["loop-command", "loop-command", "til-command", "loop-command", "loop-command", "til-command"]


@pytest.mark.fact("CY545-UND-X-PROGRAM", "CY545-UND-STOP-DIRECT", "CY545-UND-STOP-POINTER")
def test_x_in_a_program_and_0_of_a_host_do_nothing_and_x_resumes_after_a_stop(rig: Rig545) -> None:
    rig.enter("X", "B 16", "0", "B 17", "0")
    rig.run_program()
    assert rig.user == "111110"
    rig.say("0")
    assert rig.x.registers["pointer"] == 9
    rig.say("X")
    assert rig.user == "111100"
    assert not rig.codes


@pytest.mark.fact("CY545-UND-MODE-IN-PROGRAM")
def test_a_program_may_change_to_binary_and_back(rig: Rig545) -> None:
    rig.ram.load(b"O 1\r\x42\x01\x10\x4f\x01\x81B 17\r0\r")
    rig.run_program()
    assert rig.user == "111100"
    assert not rig.codes


# ------------------------------------------------------------------------------------------------------ erased memory
@pytest.mark.fact("CY545-UND-MEM-FF")
def test_ff_is_skipped_and_a_memory_full_of_it_ends_the_program() -> None:
    rig = Rig545(inferred={"fetch": 1, "program_command": 1})
    rig.ram.load(b"\xff\xffB 16\r", at=65529)
    rig.ram.load(b"\xff\xff0\r")
    rig.run_program(65529)
    assert rig.user == "111110"
    assert rig.x.registers["pointer"] == 4
    assert rig.codes == ["erased-memory"]


@pytest.mark.long
@pytest.mark.fact("CY545-UND-MEM-NONE")
def test_without_a_memory_every_address_reads_as_ff() -> None:
    rig = Rig545(memory=None)
    rig.start("? M,1\r")  # no end of the line is found: the listing goes through all 65,536 addresses
    rig.bench.run_until(lambda: len(rig.host.received) >= 10)
    assert rig.answer == "Y=00000\r\xff\xff"


@pytest.mark.fact("CY545-UND-MEM-NONE")
def test_without_a_memory_nothing_reads_back_and_a_program_is_erased_memory() -> None:
    rig = Rig545(memory=None)
    rig.send("E\rA\r")
    rig.bench.run("50 ms")
    assert rig.codes == ["verify-timeout"] * 2 + ["unfinished"]
    rig.send("Q")
    rig.host.send("X\r")
    rig.bench.run("100 ms")
    assert rig.codes == ["verify-timeout"] * 2 + ["unfinished", "erased-memory"]


@pytest.mark.long
@pytest.mark.fact("CY545-UND-MEM-FF", "CY545-UND-MEM-NONE")
@pytest.mark.parametrize("memory", ["ram", None])
def test_an_empty_program_is_given_up_after_one_turn(memory: str | None) -> None:
    rig = Rig545(memory=memory)
    rig.say("X", timeout="10 s")
    assert rig.codes == ["erased-memory", "no-program"]


# ------------------------------------------------------------------------------------------------- queries of memory
@pytest.mark.fact("CY545-QUERY-5", "CY545-UND-QUERY-MEM")
def test_a_listing_shows_the_pointer_and_lines_of_the_memory(rig: Rig545) -> None:
    rig.send(CC10)
    assert rig.say("Y 10", "? M,2") == "Y=00010\rN 1\r+\r"
    assert rig.say("? M,1", "? Y") == "Y=00010\rN 1\rY=00010\r"
    rig.ram.load(b"AB", at=65534)
    assert rig.say("Y 65534", "? M,5") == "Y=65534\rAB"


# ------------------------------------------------------------------------------------------------- immediate commands
@pytest.mark.fact("CY545-IMM-1", "CY545-IMM-6", "CY545-IMM-2", "CY545-IMM-5")
def test_a_running_program_takes_commands_of_the_host_and_continues(rig: Rig545) -> None:
    rig.enter("N 50", "+", "G", "J 5")
    rig.host.send("Y 0\rX\rB 16\r")
    rig.bench.run("1 s")
    assert rig.user == "111110"
    before = len(rig.x.steps())
    rig.bench.run("1 s")
    assert len(rig.x.steps()) > before
    rig.host.send("0\r")
    rig.bench.run_until_idle()
    before = len(rig.x.steps())
    rig.bench.run("1 s")
    assert len(rig.x.steps()) == before
    assert not rig.codes
    at = rig.x.registers["pointer"]
    assert at in (5, 7, 9, 13)
    rig.host.send("X\r")
    rig.bench.run("1 s")
    assert len(rig.x.steps()) > before


@pytest.mark.fact("CY545-IMM-3")
def test_the_first_handshake_waits_for_the_current_command(rig: Rig545) -> None:
    rig.enter("D 500", "0")
    rig.host.send("Y 0\rX\r")
    rig.bench.run_until(rig.x.at_instruction(0), "1 s")
    start = rig.bench.now_ps
    rig.bench.run("100 ms")
    rig.host.send("B 16\r")
    rig.bench.run_until_idle()
    assert (rig.falls("busy", start + 50 * MS)[0] - start) / MS == pytest.approx(500, abs=1)
    assert rig.user == "111110"


@pytest.mark.fact("CY545-IMM-16", "CY545-UND-BUSY-PROGRAM", "CY545-IMM-9")
def test_busy_is_high_while_a_program_runs_on_the_cy545b_and_fpl_stays_high(rig: Rig545) -> None:
    rig.enter("N 100", "G", "D 100", "0")
    start = rig.bench.now_ps
    rig.host.send("Y 0\rX\r")
    rig.bench.run("100 ms")
    last = rig.bench.now_ps
    assert rig.level("busy") == 1
    rig.bench.run_until_idle()
    assert not rig.falls("busy", last)
    assert not rig.edges("usrb6", start)


@pytest.mark.fact("CY545-IMM-15", "CY545-UND-BUSY-PROGRAM")
def test_the_plain_cy545_is_busy_until_its_program_has_stopped() -> None:
    rig = Rig545("busy", part="cy545")
    rig.enter("N 100", "G", "0", "B 17")
    rig.host.send("Y 0\rX\rB 16\r")
    rig.bench.run("100 ms")
    assert rig.level("busy") == 0
    assert rig.user == "111111"
    rig.bench.run_until_idle()
    assert rig.user == "111110"
    assert len(rig.x.steps()) == 100


@pytest.mark.fact("CY545-UND-IMM-SET")
@pytest.mark.parametrize("line", ["E", "Q", "X", "Y 9", "J 9", "L 2,9", "T 1,9", "Z 2,9"])
def test_commands_that_would_lead_a_program_elsewhere_are_refused(rig: Rig545, line: str) -> None:
    rig.enter("N 1", "G", "J 4")
    rig.host.send(f"+\rY 0\rX\r{line}\r")
    rig.bench.run("500 ms")
    before = len(rig.x.steps())
    rig.bench.run("500 ms")
    assert len(rig.x.steps()) > before
    assert rig.codes == ["not-immediate"]


@pytest.mark.fact("CY545-UND-IMM-SET")
def test_a_motion_may_be_immediate(rig: Rig545) -> None:
    rig.enter("D 50", "J 0")
    rig.host.send("Y 0\rX\rP 30\r? P\r")
    rig.bench.run("1 s")
    assert rig.answer == "P=00000030\r"
    assert rig.x.program_counter == 0


@pytest.mark.fact("CY545-IMM-13", "CY545-IMM-14", "CY545-IMM-11", "CY545-IMM-12", "CY545-UND-IMM-POLL")
def test_a_serial_command_stops_the_program_from_its_first_letter_to_its_last() -> None:
    rig = Rig545("pulse", serial=True, fixed_baud=9600)
    rig.enter("N 1", "G", "D 10", "J 4")
    rig.host.send("+\rY 0\rX\r")
    rig.bench.run("200 ms")
    rig.serial.write(b"\xffB")
    rig.bench.run("50 ms")
    rig.bench.run("5 s")
    paused = rig.falls("pulse", rig.bench.now_ps - 5 * S)
    assert not paused
    rig.serial.write(b" 16\r")
    rig.bench.run("200 ms")
    assert rig.user == "111110"
    assert rig.falls("pulse", rig.bench.now_ps - 100 * MS)
    assert not rig.codes


@pytest.mark.fact("CY545-CMD-I-1")
def test_i_in_a_program_ends_it(rig: Rig545) -> None:
    rig.enter("R 5", "I", "B 16", "0")
    rig.host.send("Y 0\rX\r")
    rig.bench.run("100 ms")
    assert rig.x.registers["rate"] == 100
    assert rig.user == "111111"
    assert rig.x.program_counter is None


@pytest.mark.fact("CY545-UND-AUTOSTART")
def test_a_chip_may_run_the_program_at_0_by_itself() -> None:
    rig = Rig545(replies=False, autostart=True, memory=None)
    ram = rig.bench.part("ram", name="memory", to=rig.x, image="P 20\r0\r")
    rig.bench.run("1 s")
    assert rig.x.position == 20
    ram.load(b"P 30\r")
    rig.x.reset()
    rig.bench.run("1 s")
    assert rig.x.position == 30
