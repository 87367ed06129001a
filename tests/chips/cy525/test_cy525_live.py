"""Live commands: PROG/LIVE low stops a program between two instructions.  Clocks count from the fall of RUN.

RUN         ‾‾\\______________________________________________
looks          |187     |660      |660+...        (PROG/LIVE: before the first instruction, then behind each)
program        |        first instruction acts
"""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline

US, MS = 11, 11_000
STROBE, SAMPLE, BUSY, LETTER = 165, 176, 286, 2057
FIRST, NEXT = 60 * US, 40 * US  # a program's first instruction acts 60 us after RUN fell, each later one takes 40 us
ACCEPTED = 187  # READY returns behind the terminator of X, and the program begins
KNOWN = {"rate": 10, "firstrate": 10, "slope": 250, "divisor": 1, "position": 0}
STEP = 11_000  # clocks of a step at rate 10
WATCHED = ("run", "ready", "instrobe", "pulse", "programmable_output", "prog", "io_request")


class Program:
    """A chip whose program runs, and which has told its clock of the fall of RUN."""

    def __init__(self, hand, *lines, prog=None, **options):
        self.h = hand(*WATCHED, **KNOWN, **options)
        self.h.send("E\r" + "".join(line + "\r" for line in lines) + "QC\r")
        if prog is not None:
            self.put(0, "prog", prog)
        self.h.send("X")
        start = self.h.now
        self.h.strobe(start, 0x0D, up=start + 300)
        self.h.until(run=0)
        self.start = self.h.now

    def put(self, clock, pin, level):
        self.h.put(getattr(self, "start", self.h.now) + clock, pin, level)

    def run_to(self, clock):
        self.h.run_to(self.start + clock)

    def edges(self, pin):
        return [(clock, level) for clock, level in self.h.edges(pin, self.start) if clock > 0]

    def falls(self, pin):
        return [clock for clock, level in self.edges(pin) if level == 0]

    def send(self, data):
        self.h.send(data)
        return self.h.now - self.start

    def send_last(self, data, release=None):
        """The last live command; PROG/LIVE rises so many clocks after the request of its last byte, or before it."""
        self.h.send(data[:-1])
        start = self.h.now
        self.h.put(start + (release or 0), "prog", None)
        self.h.strobe(start, data[-1] if isinstance(data, bytes) else ord(data[-1]), up=start + 300)
        self.h.run(1)
        self.h.until(ready=0)
        self.h.until(ready=1)
        return self.h.now - self.start

    @property
    def waiting(self):
        return self.h.x.waiting.removeprefix("x: ").split(" since ")[0]

    @property
    def mistakes(self):
        return [code for code in self.h.codes if code != "uninitialised"]


# ----------------------------------------------------------------------------------------------- between instructions


@pytest.mark.fact("LIVE-1", "UND-D-LIVE")
@pytest.mark.parametrize(
    ("low", "acts"),
    [
        (20_000, []),  # in the middle of D, which runs to its end
        (FIRST + 5 * MS - 1, []),
        (FIRST + 5 * MS, [FIRST + 5 * MS + NEXT]),  # exactly at the look: B acts, then the program stops
        (FIRST + 5 * MS + NEXT - 1, [FIRST + 5 * MS + NEXT]),
    ],
)
def test_the_program_stops_after_the_running_instruction(hand, low, acts):
    p = Program(hand, "D 5", "B", "C", "0")
    p.put(low, "prog", 0)
    p.run_to(3_000_000)
    assert [clock for clock, _ in p.edges("programmable_output")] == acts
    assert p.h.x.pin("run").level == 0
    assert p.h.x.pin("ready").level == 1
    assert p.waiting == "waiting for a live command"
    assert p.edges("instrobe") == []


@pytest.mark.fact("LIVE-2")
@pytest.mark.parametrize("released", [FIRST + 5 * MS, FIRST + 5 * MS + 1, 100_000])
def test_once_seen_low_one_command_must_come(hand, released):
    p = Program(hand, "D 5", "B", "C", "0")
    p.put(FIRST + 5 * MS - 1, "prog", 0)
    p.put(released, "prog", None)
    p.run_to(3_000_000)
    assert p.edges("programmable_output") == []
    ready = p.send("Z 1\r")
    p.run_to(3_100_000)
    assert p.edges("programmable_output") == [(ready + NEXT, 1), (ready + 2 * NEXT, 0)]
    assert p.mistakes == []


@pytest.mark.fact("LIVE-2")
@pytest.mark.parametrize(("low", "high"), [(FIRST + 5 * MS, FIRST + 5 * MS + NEXT - 1), (1000, FIRST + 5 * MS - 1)])
def test_a_low_between_two_samples_is_missed(hand, low, high):
    p = Program(hand, "D 5", "B", "C", "0")
    p.put(low, "prog", 0)
    p.put(high, "prog", None)
    p.run_to(200_000)
    acts = FIRST + 5 * MS
    assert p.edges("programmable_output") == [(acts + NEXT, 1), (acts + 2 * NEXT, 0)]
    assert p.edges("run") == [(acts + 2 * NEXT + 36 * US, 1)]


@pytest.mark.fact("LIVE-3", "UND-LIVE-BINARY")
@pytest.mark.parametrize(
    ("ascii_binary", "first", "last"),
    [(1, "C\rB\rR 50\r", "Z 1\r"), (0, bytes.fromhex("43 00 42 00 52 01 32"), b"Z\x01\x01")],
)
@pytest.mark.parametrize("late", [-1, 0])
def test_the_line_is_sampled_again_as_ready_returns_after_each_command(hand, ascii_binary, first, last, late):
    p = Program(hand, "D 5", "B", "D 5", "C", "0")
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    p.put(100_000, "ascii_binary", ascii_binary)
    p.send(first)
    p.run_to(400_000)
    assert p.h.x.registers["rate"] == 50
    assert [level for _, level in p.edges("programmable_output")] == [1]  # C changed nothing, B did
    assert p.waiting == "waiting for a live command"
    # released one clock before READY returns, or in that very clock, which is too late
    busy = (180 * US + 40 * US * ascii_binary) + BUSY
    ready = p.send_last(last, release=busy + late)
    p.run_to(1_000_000)
    if late < 0:
        acts = ready + 2 * NEXT + 5 * MS + NEXT
        assert p.edges("programmable_output")[1:] == [(acts, 0)]
        assert p.h.x.pin("run").level == 1
    else:
        assert p.edges("programmable_output")[1:] == []
        assert p.waiting == "waiting for a live command"
    assert p.mistakes == []


@pytest.mark.fact("LIVE-4")
def test_released_before_the_last_terminator_the_program_resumes_after_the_command(hand):
    p = Program(hand, "D 5", "B", "0")
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    ready = p.send_last("R 50\r")
    p.run_to(ready + 5000)
    assert p.h.x.registers["rate"] == 50
    assert p.edges("programmable_output") == [(ready + NEXT, 1)]
    assert p.edges("run") == [(ready + NEXT + 36 * US, 1)]


@pytest.mark.fact("CON-READY-RUN", "LIVE-1", "LIVE-8")
def test_a_request_that_is_there_when_the_instruction_ends_is_served_then(hand):
    p = Program(hand, "D 5", "B", "0")
    p.put(1000, "prog", 0)
    p.h.strobe(p.start + 2000, ord("R"), up=p.start + 80_000)
    end = FIRST + 5 * MS
    p.run_to(end + 1000)
    assert p.edges("instrobe") == [(end + STROBE, 0), (end + SAMPLE, 1)]
    assert p.edges("ready")[1:] == [(end + BUSY, 0)]
    p.run_to(100_000)
    ready = p.send_last(" 50\r")
    p.run_to(ready + NEXT)
    assert p.h.x.registers["rate"] == 50
    assert p.edges("programmable_output") == [(ready + NEXT, 1)]
    assert p.mistakes == []


@pytest.mark.fact("LIVE-10", "LIVE-1", "HS-12")
def test_a_motion_completes_before_the_program_stops(hand):
    p = Program(hand, "G", "G", "0", number=5)
    p.put(FIRST + STEP, "prog", 0)
    p.run_to(100 * STEP)
    assert p.falls("pulse") == [FIRST + n * STEP for n in range(5)]
    assert p.waiting == "waiting for a live command"
    ready = p.send_last("R 20\r")
    p.run_to(ready + 20 * STEP)
    assert len(p.falls("pulse")) == 10


@pytest.mark.fact("UND-UW-BYTE")
def test_the_request_that_ends_u_is_served_as_the_first_live_byte(hand):
    p = Program(hand, "U", "B", "0", straps={"wait": 1})
    p.put(20_000, "prog", 0)
    p.run_to(50_000)
    assert p.waiting == "waiting for wait=0 (U)"  # U goes on waiting
    p.h.strobe(p.start + 50_000, ord("R"), up=p.start + 60_000)
    p.run_to(60_000)
    look = FIRST + -(-(50_001 - FIRST) // (8 * US)) * 8 * US
    assert p.edges("instrobe") == [(look + STROBE, 0), (look + SAMPLE, 1)]
    p.send_last(" 77\r")
    p.run_to(200_000)
    assert p.h.x.registers["rate"] == 77
    assert [level for _, level in p.edges("programmable_output")] == [1]


@pytest.mark.fact("UND-LIVE-IDLE")
def test_without_a_program_the_line_means_nothing(hand):
    h = hand("programmable_output")
    h.put(0, "prog", 0)
    h.run_to(1000)
    h.send("C\rR 9\r")
    assert h.x.pin("programmable_output").level == 0
    assert h.x.registers["rate"] == 9
    assert h.x.waiting.startswith("x: waiting for a command since ")
    assert h.x.idle
    assert h.codes == []


@pytest.mark.fact("UND-LIVE-IDLE", "LIVE-2")
def test_a_program_that_starts_with_the_line_low_stops_before_its_first_instruction(hand):
    p = Program(hand, "B", "0", prog=0)
    p.run_to(100_000)
    assert p.edges("programmable_output") == []
    assert p.waiting == "waiting for a live command"
    ready = p.send_last("R 50\r")
    p.run_to(ready + 1000)
    assert p.edges("programmable_output") == [(ready + NEXT, 1)]


# -------------------------------------------------------------------------------------------------- what can be given


@pytest.mark.fact("LIVE-5")
def test_parameters_given_live_count_for_the_next_motion(hand):
    p = Program(hand, "G", "D 20", "X", number=3)
    p.run_to(FIRST + 4 * STEP)
    p.put(FIRST + 4 * STEP, "prog", 0)
    p.run_to(FIRST + 40 * STEP)
    p.send("F 20\r")
    p.send_last("R 20\r")
    p.run_to(FIRST + 80 * STEP)
    begins = p.falls("pulse")
    periods = [after - before for before, after in pairwise(begins)]
    assert periods[:2] == [STEP, STEP]
    assert periods[3:5] == [5500, 5500]


@pytest.mark.fact("LIVE-6", "CMD-0-1")
def test_a_live_0_ends_the_program(hand):
    p = Program(hand, "G", "X", number=3)
    p.put(FIRST + STEP, "prog", 0)
    p.run_to(20 * STEP)
    assert p.h.x.pin("run").level == 0
    ready = p.send("0\r")
    assert p.edges("run") == [(ready - 17 * US, 1)]
    assert p.waiting == "waiting for a command"
    p.put(ready, "prog", None)
    p.run_to(ready + 20 * STEP)
    p.send("B\r")
    assert p.h.x.pin("programmable_output").level == 1
    assert len(p.falls("pulse")) == 3


@pytest.mark.fact("LIVE-9", "CMD-V-2")
def test_v_may_be_given_live(hand):
    p = Program(hand, "G", "D 5", "X", number=3)
    p.put(FIRST + 4 * STEP, "prog", 0)
    p.run_to(20 * STEP)
    p.send("V 0\r")
    p.h.put(p.h.now, "io_select", 1)
    assert p.h.fetch(5) == b"00003"
    p.h.put(p.h.now, "io_select", 0)
    p.h.run(200 * STEP)
    assert len(p.falls("pulse")) == 3  # a read-out is no command: still halted
    p.send_last("R 10\r")
    p.h.run(20 * STEP)
    assert len(p.falls("pulse")) > 3
    assert p.mistakes == []


@pytest.mark.fact("LIVE-8", "LIVE-10", "FLY-RATE-1")
def test_in_a_slewing_motion_a_request_changes_the_rate_at_any_level_of_the_live_line(hand):
    p = Program(hand, "H", "G", "B", "0", number=64_000)
    p.h.until(slew=0)
    p.put(10 * STEP, "prog", 0)
    p.h.strobe(p.start + 20 * STEP, 20, up=p.start + 23 * STEP)
    p.run_to(80 * STEP)
    begins = p.falls("pulse")
    assert {b - a for a, b in zip(begins[-5:], begins[-4:], strict=False)} == {5500}
    assert len(p.falls("instrobe")) == 1
    assert p.edges("programmable_output") == []  # no live command was taken
    assert p.h.x.pin("ready").level == 0
    assert p.waiting == "G in motion (until abort=0)"


@pytest.mark.fact("UND-LIVE-QEX")
@pytest.mark.parametrize(
    ("command", "edges"),
    [
        ("X\r", [(5 * MS + 2 * NEXT, 1), (5 * MS + 3 * NEXT, 0), (5 * MS + 4 * NEXT, 1)]),
        ("J 3\r", [(NEXT, 1), (2 * NEXT, 0), (3 * NEXT, 1)]),
        ("J 5\r", [(NEXT, 1)]),
    ],
)
def test_live_x_and_j_send_the_program_elsewhere(hand, command, edges):
    p = Program(hand, "D 5", "B", "C", "B", "0")
    assert p.h.x.program == bytes.fromhex("44 05 00 42 43 42 00")
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    ready = p.send_last(command)
    p.run_to(ready + 200_000)
    assert p.edges("programmable_output") == [(ready + clock, level) for clock, level in edges]
    assert p.edges("run") == [(ready + edges[-1][0] + 36 * US, 1)]  # low all the time before
    assert p.mistakes == []


@pytest.mark.fact("UND-LIVE-QEX")
def test_a_live_i_stops_and_erases(hand):
    p = Program(hand, "D 5", "B", "0")
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    ready = p.send_last("I\r")
    p.run_to(ready + 100_000)
    assert p.edges("run") == [(ready - 17 * US, 1)]
    assert p.h.x.program == b""
    assert p.edges("programmable_output") == []
    assert p.waiting == "waiting for a command"


@pytest.mark.fact("UND-LIVE-QEX", "HS-11")
@pytest.mark.parametrize("command", ["G\r", "P 3\r"])
def test_a_live_motion_completes_before_the_program_continues(hand, command):
    p = Program(hand, "D 5", "B", "0", number=3)
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    ready = p.send_last(command)
    p.run_to(ready + 5000)
    steps = p.falls("pulse")
    assert len(steps) == 3
    assert ready == steps[-1] + STEP + 180
    assert p.edges("programmable_output") == [(ready + NEXT, 1)]


@pytest.mark.fact("UND-LIVE-QEX")
def test_a_live_h_counts_for_the_next_motion_of_the_program(hand):
    p = Program(hand, "D 5", "G", "0", number=300)
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    ready = p.send_last("H\r")
    p.run_to(ready + 400 * STEP)
    assert len(p.falls("pulse")) > 390


@pytest.mark.fact("UND-LIVE-QEX", "UND-PROG-E", "UND-Q-COMMAND")
@pytest.mark.parametrize(("command", "code"), [("Q", "quit-outside-entry"), ("E\r", "enter-while-running")])
def test_live_q_and_e_change_nothing_and_are_reported(hand, command, code):
    p = Program(hand, "D 5", "B", "0")
    program = p.h.x.program
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    ready = p.send_last(command)
    p.run_to(ready + 1000)
    assert p.mistakes == [code]
    assert p.h.x.program == program
    assert p.edges("programmable_output") == [(ready + NEXT, 1)]
    assert p.h.x.pin("prog").level == 1


@pytest.mark.fact("LIVE-3")
def test_an_unknown_live_command_has_no_effect(hand):
    p = Program(hand, "D 5", "B", "0")
    p.put(1000, "prog", 0)
    p.run_to(100_000)
    p.send_last("K 5\r")
    p.run_to(1_000_000)
    assert p.mistakes == ["unknown-command"]
    assert p.edges("programmable_output") == []
    ready = p.send("R 50\r")
    p.run_to(ready + 1000)
    assert p.edges("programmable_output") == [(ready + NEXT, 1)]


# --------------------------------------------------------------------------------------------------- the line itself


@pytest.mark.fact("LIVE-7", "PIN-31")
def test_during_program_entry_the_chip_holds_the_line_low_whatever_the_host_does(hand):
    h = hand("prog")
    h.send("E\r")
    assert h.x.pin("prog").level == 0
    h.put(h.now, "prog", 0)  # an open collector does no harm
    h.put(h.now, "prog", None)
    h.run(100)
    assert h.codes == []
    h.put(h.now, "prog", 1)
    h.run(100)
    assert h.x.pin("prog").level == 0
    assert h.codes == ["conflict"]
    h.send("B\rQ")
    assert h.x.pin("prog").level == 1
    assert h.codes == ["conflict"]
    assert h.x.program == b"B"
    assert [level for _, level in h.edges("prog")] == [0, 1]


@pytest.mark.fact("LIVE-7")
def test_after_q_a_host_may_keep_the_line_low(hand):
    h = hand("prog")
    h.send("E\rB\r")
    h.put(h.now, "prog", 0)
    h.send("Q")
    assert h.x.pin("prog").level == 0
    h.put(h.now, "prog", None)
    assert h.x.pin("prog").level == 1
    assert h.codes == []


@pytest.mark.fact("CON-IDLE-X", "CMD-X-3", "LIVE-6", "UND-PROG-END")
def test_run_mode_without_a_program_takes_only_live_commands(hand):
    h = hand("run", "instrobe", "ready")
    h.send("X\r")
    start = h.now
    h.run(110_000_000)
    assert h.x.pin("run").level == 0
    assert h.x.waiting.startswith("x: run mode with nothing to execute, waiting for a live 0 or RESET since ")
    assert h.codes == ["end-of-program"]
    h.strobe(h.now, ord("0"), up=h.now + 50_000)
    h.run(100_000)
    assert h.edges("instrobe", start) == []
    assert h.codes == ["end-of-program", "request-while-running"]
    low = h.now
    h.put(low, "prog", 0)
    h.run(1000)
    h.send("0")
    h.put(h.now, "prog", None)
    h.send("\r")
    assert h.x.pin("run").level == 1
    h.send("B\r")
    assert h.codes == ["end-of-program", "request-while-running"]


@pytest.mark.fact("LIVE-1", "UND-PROG-TIME")
@pytest.mark.parametrize(("low", "look"), [(88_000 - 1, 88_000), (88_000, 88_088), (88_001, 88_088)])
def test_in_an_empty_run_mode_the_line_is_sampled_every_8_us(hand, low, look):
    h = hand("run", "instrobe")
    h.send("X\r")
    begin = h.now  # READY has returned: the first look
    h.put(begin + low, "prog", 0)
    h.strobe(begin + low, ord("0"), up=begin + low + 1000)
    h.run(100_000)
    assert h.falls("instrobe")[-1] == begin + look + STROBE


@pytest.mark.fact("LIVE-4", "LIVE-5")
def test_a_host_gives_live_commands(rig):
    r = rig(number=3, record=("programmable_output", "run"), **KNOWN)
    r.send("C\rE\rG\rD 5\rX\rQ")
    r.start("X\r")
    r.bench.run("20 ms")
    sent = r.host.sent
    assert r.host.live("B", "R 20", "F 20") == b""
    assert r.host.sent - sent == len("B\rR 20\rF 20\r")
    assert r.level("programmable_output") == 1
    assert r.level("prog") == 1
    r.bench.run("40 ms")
    gaps = [int(b - a) for a, b in zip(r.x.steps().times_ps[-6:], r.x.steps().times_ps[-5:], strict=False)]
    assert gaps.count(500_000_000) >= 3
    r.host.live("0")
    assert r.level("run") == 1
    assert [code for code in r.codes if code != "uninitialised"] == []


# -------------------------------------------------------------------------------------- verify while a program runs
WALK = "A 0\rF 10\rR 10\rS 255\rZ 1\rN 50\rE\rG\rD 20\rJ 0\rQ"


@pytest.mark.fact("LIVE-9")
@pytest.mark.parametrize("ascii_binary", [1, 0])
def test_a_group_is_read_between_two_instructions_of_a_running_program(rig, ascii_binary):
    r = rig(position=0)
    r.send(WALK)
    r.host.run_program()
    r.bench.run("120 ms")  # in the second motion
    r.drive("ascii_binary", ascii_binary)
    assert r.host.verify(0, live=True) == (b"00100" if ascii_binary else bytes([0, 100]))
    assert r.level("prog") == 1 and r.level("run") == 0
    assert r.host.live("R 20", "V 3", "V 1") == bytes.fromhex("00 32 FF 14 0A 01") + b"GD\x14\0J\0".ljust(48, b"\0")
    assert r.x.position == 100  # nothing has moved meanwhile
    r.bench.run_until(r.x.reaches(160))  # the program goes on
    r.host.live("0")
    assert [code for code in r.codes if code != "uninitialised"] == []
    assert r.host.verify(0) == (b"00200" if ascii_binary else bytes([0, 200]))


@pytest.mark.fact("LIVE-9")
def test_the_requested_number_of_bytes_is_read_live(rig):
    r = rig(position=0)
    r.send(WALK)
    r.host.run_program()
    assert r.host.verify(1, 3, live=True) == b"GD\x14"
    assert r.host.received == b"GD\x14"


def test_verify_in_a_running_program_is_refused_and_changes_nothing(rig):
    r, undisturbed = rig(position=0), rig(position=0)
    for each in (r, undisturbed):
        each.send(WALK)
        each.host.run_program()
        each.bench.run("120 ms")
    remedy = r"host: x accepts no command while its program runs; verify\(0, live=True\) reads through PROG/LIVE"
    with pytest.raises(slewline.UsageError, match=remedy):
        r.host.verify(0)
    with pytest.raises(slewline.UsageError, match="wait until RUN is high, or use live commands"):
        r.host.run_program()
    assert r.codes == [] and r.host.idle and r.host.received == b""
    for each in (r, undisturbed):
        each.bench.run_to("1 s")
    assert r.x.steps().times_ps.tolist() == undisturbed.x.steps().times_ps.tolist()


@pytest.mark.fact("CMD-X-1")
def test_run_program_ends_when_run_is_low(rig):
    r = rig(position=0, record=("run",))
    r.send("A 0\rF 10\rR 10\rS 255\rZ 1\rN 5\rE\rG\r0\rQ")
    r.host.run_program()
    assert r.falls("run") == [r.bench.now_ps]
    r.bench.run_until_idle()
    assert r.x.position == 5 and r.codes == []
    r.host.send("J 0\r")  # queued in front of it
    r.bench.run("1 ms")
    with pytest.raises(slewline.UsageError, match="accepts no command while its program runs"):
        r.host.run_program()


@pytest.mark.parametrize("commands", [(), ("",), (5,), ("R é",)])
def test_live_commands_are_text(rig, commands):
    r = rig()
    with pytest.raises(slewline.UsageError, match=r"live command .*; expected text such as 'R 20'"):
        r.host.live(*commands)
    assert r.level("prog") == 1
