"""What a fixture gives: time, questions, assertions with readable differences, faults."""

from __future__ import annotations

import numpy as np
import pytest
import serial

import slewline
from slewline.core.messages.instead import Instead
from slewline.core.time.timebase import readable
from slewline.errors import ChecksumError, Timeout, UnknownName, UsageError
from slewline.testing.endpoints import running

SETUP = ("Po", "S10", "T100", "R50")


@pytest.fixture
def moving(gs_c200s):
    """A module at the begin of +200."""
    start(gs_c200s, "+200")
    gs_c200s.until("mov=1")
    return gs_c200s


def start(module, *program):
    for command in (*SETUP, *program, "E"):
        module.assert_reply(command, "Y")


def differs(says, assertion, *arguments, **more):
    with pytest.raises(AssertionError) as failed:
        assertion(*arguments, **more)
    assert str(failed.value) == says


# ---------------------------------------------------------------------------------------------------------------- time
def test_time_advances_by_the_steps_of_the_test_and_no_further(gs_c200s):
    began = gs_c200s.now
    gs_c200s.advance("250 ms")
    assert gs_c200s.now - began == 250 * 10**9


def test_until_a_level_a_condition_or_a_function(moving):
    assert moving.pin("mov").level == 1
    moving.until(moving.chip.reaches(40))
    assert moving.position == 40
    moving.until(moving.pin("ramp").is_(0) | moving.pin("mov").is_(0))
    assert moving.position == 51
    moving.until(lambda: moving.position > 60)
    assert moving.position == 61
    moving.until(moving.pin("clock").edges(4))
    assert moving.position == 63
    moving.until(moving.pin("clock").edges(3))
    assert moving.position == 64
    moving.until("mov=0")
    assert moving.position == 200
    moving.until_idle()


def test_a_timeout_names_the_awaited_level_and_the_waiting_chip(gs_c200s):
    start(gs_c200s, "W1")
    gs_c200s.pin("ui1").drive(0)
    start_again = gs_c200s.ask("K"), gs_c200s.ask("E")
    assert start_again == ("Y", "Y")
    with pytest.raises(Timeout, match=r"gs-c200s on url: waited 2 s for gs_c200s\.mov=1; gs_c200s: .*ui1"):
        gs_c200s.until("mov=1", timeout="2 s")


@pytest.mark.parametrize("text", ["mov", "mov=2", "mov=x"])
def test_a_condition_in_text_is_a_pin_and_its_level(gs_c200s, text):
    with pytest.raises(UsageError, match="expected a pin and its level"):
        gs_c200s.until(text)


def test_a_pin_that_does_not_exist(gs_c200s):
    with pytest.raises(UnknownName, match="its pins: sel0"):
        gs_c200s.until("move=1")


# ------------------------------------------------------------------------------------------------------------ questions
def test_answers_come_without_checksum_and_carriage_return(gs_c200s):
    assert gs_c200s.ask("F") == "R"
    start(gs_c200s, "+5")
    gs_c200s.until_idle()
    assert gs_c200s.ask("Q") == "S10\rT100\rR50\r+5\rEND"
    assert gs_c200s.ask("M") == "Y"


def test_a_question_borrows_the_line_of_a_program(gs_c200s):
    with serial.serial_for_url(gs_c200s.url, baudrate=1200, timeout=1) as port:
        assert gs_c200s.ask("F") == "R"
        assert (port.read(1), gs_c200s.rig.host.baud, gs_c200s.rig.host.word.bits) == (b"", 1200, 8)
        port.apply_settings({"baudrate": 9600, "bytesize": 7, "parity": "O", "stopbits": 2})
        port.write(b"FV\r")
        assert port.read(3) == b"RR\r"


@pytest.mark.slewline(straps={"sel0": 0, "sel2": 0, "chs": 0})
def test_straps_decide_on_address_and_checksum(gs_c200s):
    assert gs_c200s.ask("F") == "R"
    assert "< 2F\\r" not in gs_c200s.report()
    assert "< 5F\\r" in gs_c200s.report()


def test_no_answer(gs_c200s):
    gs_c200s.chip.power(False)
    with pytest.raises(
        Timeout, match=r"'F': no complete answer within 5 s, received b''; gs_c200s: waiting for its supply"
    ):
        gs_c200s.ask("F")


# ----------------------------------------------------------------------------------------------------------- assertions
def test_a_wrong_answer(gs_c200s):
    differs("V1: the answer is 'V+0', expected 'V+1'", gs_c200s.assert_reply, "V1", "V+1")


def test_the_number_of_steps_and_their_direction(moving):
    moving.until_idle()
    moving.assert_steps(200, direction=+1)
    moving.assert_steps(200)
    differs("200 steps found, expected 199", moving.assert_steps, 199)
    first = readable(int(moving.chip.steps().times_ps[0]))
    said = f"step 1 is cw at {first}, expected ccw; 199 more errors"
    differs(said, moving.assert_steps, 200, direction=-1)


def test_the_instants_of_steps(gs_c200s):
    start(gs_c200s, "+3")
    gs_c200s.until("mov=1")
    since = gs_c200s.now
    gs_c200s.until_idle()
    times = gs_c200s.chip.steps(since).times_ps - since
    gs_c200s.assert_steps([int(time) for time in times], direction=1, since=since)
    late = [int(times[0]), int(times[1]) - 2_000_000, int(times[2])]
    with pytest.raises(AssertionError, match=r"^step 2 is 2 µs late: cw at"):
        gs_c200s.assert_steps(late, since=since)
    with pytest.raises(AssertionError, match=r"^step 2 is one too many: "):
        gs_c200s.assert_steps([late[0], late[2]], since=since)


def test_the_steps_of_another_run(gs_c200s, slewline_module):
    other = slewline_module("gs-c200s")
    for module, steps in ((gs_c200s, "+2"), (other, "+3")):
        start(module, steps)
        module.until_idle()
    gs_c200s.assert_steps(gs_c200s.chip.steps())
    with pytest.raises(AssertionError, match="1 step missing at the end: 2 found, expected 3; the first is cw at 79"):
        gs_c200s.assert_steps(other.chip.steps())


def test_numbers_and_instants_may_come_out_of_arrays(moving):
    moving.until_idle()
    steps, since = moving.chip.steps(), moving.chip.steps().times_ps[0]
    moving.assert_steps(np.int64(200), direction=+1)
    moving.assert_steps(steps.times_ps)
    moving.assert_steps(list(steps.times_ps - since), since=since)
    differs("200 steps found, expected 199", moving.assert_steps, np.int64(199))
    with pytest.raises(UsageError, match="a float would be rounded"):
        moving.assert_steps(steps.times_ps / 1)
    times, levels = moving.bench.edges("gs_c200s.ramp")
    moving.assert_edges("ramp", list(zip(times, levels, strict=True)))


@pytest.mark.parametrize("what", [None, "200", 200.0], ids=repr)
def test_objects_that_steps_cannot_be_compared_with(gs_c200s, what):
    with pytest.raises(UsageError, match="expected the number of steps, their instants, or the steps of another run"):
        gs_c200s.assert_steps(what)
    with pytest.raises(UsageError, match=r"assert_steps\(<gs-c200s on url: .*such as other\.chip\.steps\(\)"):
        gs_c200s.assert_steps(gs_c200s)


def test_the_edges_of_a_pin(gs_c200s):
    start(gs_c200s, "D1", "A2", "D1", "C2")
    gs_c200s.until("uo2=1")
    since = gs_c200s.now
    gs_c200s.until_idle()
    # the instruction D1, 0.1 s, the instruction C2
    gs_c200s.assert_edges("uo2", [(0, 1), ("102 ms", 0)], since=since)
    said = "uo2: edge 2 is 2 ms late: low at 102 ms, expected low at 100 ms"
    differs(said, gs_c200s.assert_edges, "uo2", [(0, 1), ("100 ms", 0)], since=since)
    differs("uo2: edge 1 is high at 0 ps, expected low", gs_c200s.assert_edges, "uo2", [(0, 0), ("102 ms", 0)], since)
    gs_c200s.assert_edges("reset", [("400 us", 1)])


# --------------------------------------------------------------------------------------------------------------- faults
def told(module):
    return [found.text for found in module.bench.findings if found.code == "fault"]


def test_a_lost_byte_to_the_module(gs_c200s):
    gs_c200s.faults.lost_byte()
    gs_c200s.assert_reply("F", "E1")  # the checksum is a command without one
    assert told(gs_c200s) == [
        "lost byte: the next character to the module (seed 0)",
        "0x46 to the module is lost (seed 0)",
    ]
    gs_c200s.assert_reply("F", "R")


def test_a_lost_byte_to_the_host(gs_c200s):
    gs_c200s.faults.lost_byte(to="host", count=3)
    with pytest.raises(
        Timeout, match="'F': no complete answer within 5 s, received b''; gs_c200s: waiting for a command"
    ):
        gs_c200s.ask("F")
    gs_c200s.assert_reply("F", "R")


@pytest.mark.slewline(seed=3)
def test_a_garbled_byte_is_found_out_by_the_checksum(gs_c200s):
    gs_c200s.faults.garbled_byte(to="host")
    with pytest.raises(ChecksumError):
        gs_c200s.ask("F")
    assert told(gs_c200s)[1].startswith("0x52 to the host has become 0x")
    assert told(gs_c200s)[1].endswith("(seed 3)")


def test_no_garbled_byte_escapes_the_checksum(gs_c200s):
    noise, hits = gs_c200s.faults.noises["module"], set()
    for seed in range(100):
        noise.plan("garbled", seed=seed)
        hits.add(noise.hit(0x46)[0] ^ 0x46)
    assert hits == {0x01, 0x02, 0x04, 0x08, 0x20, 0x40}  # F with 0x10 is V, and V has the checksum of F


def test_a_garbled_byte_depends_on_the_seed_alone(slewline_module):
    def garbled(seed):
        module = slewline_module("gs-c200s", seed=seed)
        module.faults.garbled_byte(count=3)
        module.assert_reply("V1", "E1")
        return told(module)[1:]

    assert garbled(1) == garbled(1)
    assert len({tuple(line.partition("(")[0] for line in garbled(seed)) for seed in range(4)}) > 1


def test_a_wrong_parity(gs_c200s):
    gs_c200s.faults.wrong_parity()
    gs_c200s.assert_reply("F", "E1")
    assert gs_c200s.bench.findings[-1].text.startswith("b'FV': a parity or framing error: this module is set to")


@pytest.mark.parametrize("to", ["module", "host"])
def test_a_late_byte_and_those_after_it(gs_c200s, to):
    gs_c200s.ask("F")
    began = gs_c200s.now
    gs_c200s.ask("F")
    usual = gs_c200s.now - began
    gs_c200s.faults.late_byte(to)
    began = gs_c200s.now
    gs_c200s.assert_reply("F", "R")
    # those to the host come together with the late one, as one burst
    assert gs_c200s.now - began == pytest.approx(usual + 10**11, abs=3 * 10**9)


def test_a_fault_of_characters_ends_with_its_block(gs_c200s):
    with gs_c200s.faults.lost_byte(count=5):
        gs_c200s.advance("1 ms")
    gs_c200s.assert_reply("F", "R")
    assert told(gs_c200s)[-1] == "lost byte: over (seed 0)"


def test_one_fault_that_ends_leaves_the_others(gs_c200s):
    gs_c200s.faults.wrong_parity()
    with gs_c200s.faults.lost_byte(count=5):
        pass
    gs_c200s.assert_reply("F", "E1")


def test_a_stuck_switch(gs_c200s):
    start(gs_c200s, "W1", "+5")
    with gs_c200s.faults.stuck_switch("ui1", 0):
        gs_c200s.assert_reply("K", "Y")
        gs_c200s.assert_reply("E", "Y")
        gs_c200s.advance("5 s")
    began = gs_c200s.now
    gs_c200s.until_idle()
    gs_c200s.assert_steps(5, since=began)


def test_a_limit_that_bounces_at_instants_of_the_seed(slewline_module):
    def edges(seed):
        module = slewline_module("gs-c200s", seed=seed)
        module.faults.bouncing_limit("eot", bounces=3, within="2 ms", at="10 ms", lasting="20 ms")
        module.advance("50 ms")
        times, levels = module.bench.edges("gs_c200s.eot", "10 ms")
        assert levels.tolist() == [0, 1, 0, 1, 0, 1, 0, 1]
        assert times[0] == 10 * 10**9
        assert times[6] < 12 * 10**9
        assert times[7] == 30 * 10**9
        return times.tolist()

    assert edges(1) == edges(1) != edges(2)


def test_enable_kept_low_at_an_instant_for_a_time(moving):
    begin = moving.now + 50 * 10**9
    moving.faults.enable_held_low(at=begin, lasting="200 ms")
    moving.until_idle()
    moving.assert_steps(200, direction=1)
    gap = max(
        later - earlier for earlier, later in zip(*[moving.chip.steps().times_ps[n:] for n in (0, 1)], strict=False)
    )
    assert 200 * 10**9 < gap < 210 * 10**9


def test_a_power_cut(moving):
    with moving.faults.power_cut():
        moving.advance("10 ms")
    moving.assert_reply("V1", "V+0")
    moving.assert_reply("Q", "END")
    assert told(moving) == ["power cut: the supply is off (seed 0)", "power cut: over (seed 0)"]


def test_an_eeprom_that_takes_no_program(moving):
    moving.until_idle()
    with moving.faults.eeprom_fault():
        moving.assert_reply("M", "E6")
    moving.assert_reply("X", "E6")
    moving.assert_reply("M", "Y")
    assert told(moving) == ["EEPROM fault: programming the EEPROM fails (seed 0)", "EEPROM fault: over (seed 0)"]


def test_a_fault_that_is_over_before_it_begins_never_comes(gs_c200s):
    with gs_c200s.faults.power_cut(at="1 s"):
        gs_c200s.advance("10 ms")
    gs_c200s.advance("2 s")
    assert told(gs_c200s) == []


def test_faults_that_cannot_be(gs_c200s):
    gs_c200s.advance("1 s")
    with pytest.raises(UsageError, match=r"power cut: 500 ms is in the past; the time is 1.001 s"):
        gs_c200s.faults.power_cut(at="500 ms")
    with pytest.raises(UsageError, match="lost byte: to='chip'; allowed module, host"):
        gs_c200s.faults.lost_byte(to="chip")
    with pytest.raises(UnknownName):
        gs_c200s.faults.stuck_switch("limit", 0)


def test_a_face_that_is_not_there():
    with pytest.raises(UsageError, match="on='usb'; allowed url, host, tcp, pty, rfc2217"):
        running("gs-c200s", on="usb")


def test_the_report_names_a_server_that_has_ended(slewline_module):
    module = slewline_module("gs-c200s", on="tcp")
    module.rig.server.stop()
    module.rig.thread.join()
    assert module.report() == f"{module.url}: the server of the module has ended unexpectedly"


def test_a_long_transcript_is_cut(gs_c200s):
    for _ in range(30):
        gs_c200s.ask("F")
    report = gs_c200s.report().splitlines()
    begin = report.index("transcript (< to the module, > to the host), 40 of 60 lines:")
    assert len(report) == begin + 41


def test_no_attribute_of_an_object_hides_what_to_write_instead(gs_c200s):
    line = gs_c200s
    bench = slewline.Bench()
    chip = bench.add("cy525")
    for one in (line.faults, line.host, line.chip, line.pin("mov"), bench, chip, bench.host(chip)):
        remedies = {name for base in type(one).__mro__ for name, of in vars(base).items() if isinstance(of, Instead)}
        assert remedies - {"velocity"}, one
        assert not remedies & {*getattr(one, "__dict__", {})}, one
