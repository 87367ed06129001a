"""How the tools speak to a module: frames, answers, what is asked again, and what is never sent."""

from __future__ import annotations

import pytest

from slewline.chips import sheet_of
from slewline.errors import UsageError
from slewline.modules.failures import DamagedAnswer, MotionRefused, NoAnswer, PortLost, RefusedCommand
from slewline.modules.speech import speech_of

from .conftest import chip_of, noise

GSC = "gs-c200s?chs=0"


@pytest.mark.parametrize(
    ("part", "steps", "harmless"),
    [
        ("gs-c200", "E H H+ H- +250 -1 G500 G+ G+2", "F I1 K M P Q V1 V2 X Z S10 T100 R50 A1 C1 D5 L0 L10 U1 W1"),
        ("gs-c200s", "E H+ +250 G+5 g+ g-1", "F f+5 I1 K M Po Px Q V1 V2 X Z S10 T100 R50 j5 jc1,5 L0 L10"),
        (
            "cy545",
            "G|H 1|P 300|X|J 5|L 2,0|T 1,0|Z 2,0",
            "A 5|B 1|C|D 10|E|F 10|I|N 5|O 128|Q|R 5|S 5|W 1|Y 0|? M,3|0",
        ),
        ("cy545b", "G|/H 1|P 300", '/B 1|"text"|+|-'),
    ],
)
def test_whether_it_may_cause_a_step_is_known_of_every_command(part, steps, harmless):
    speech = speech_of(sheet_of(part))
    split = "|" if "|" in steps else None
    assert [each for each in steps.split(split) if not speech.moves(each)] == []
    assert [each for each in harmless.split(split) if speech.moves(each)] == []
    assert {speech.row(each) for each in (*steps.split(split), *harmless.split(split))} <= {*speech.sheet.commands}


@pytest.mark.parametrize("part", ["gs-c200", "gs-c200s", "cy545", "cy545b"])
@pytest.mark.parametrize("command", ["foo", "g", "k", "% 3"])
def test_an_unknown_command_may_cause_a_step(part, command):
    assert speech_of(sheet_of(part)).moves(command)


def test_a_command_that_may_cause_a_step_is_not_sent(module):
    x = module(GSC)
    for line in ("Po", "S10", "T100", "R5", "+50"):  # in program entry a move is only stored
        x.ask(line)
    assert x.ask("Px").lines == ("Y",)
    with pytest.raises(MotionRefused, match=r"E may step the motor: run the program.*not sent.*--move"):
        x.ask("E")
    with pytest.raises(MotionRefused, match=r"'\+50,' is not a command of the GS-C200S"):
        x.ask("+50,")
    with pytest.raises(MotionRefused):
        x.ask("+50")  # outside program entry
    assert x.transcript.sent == b"Po\rS10\rT100\rR5\r+50\rPx\r"
    assert not chip_of(x).steps()


def test_with_leave_it_is_sent(module):
    x = module(GSC, may_move=True)
    for line in ("Po", "S10", "T100", "R5", "+50", "E"):
        assert x.ask(line).lines == ("Y",)
    x.port.pause(1)
    assert len(chip_of(x).steps()) == 50


@pytest.mark.parametrize("url", ["gs-c200s", "gs-c200s?sel2=0&sel1=0&sel0=1"])
def test_lines_carry_checksum_and_address_as_the_sheet_has_them(module, url):
    address = 3 if "sel" in url else None
    x = module(url, checked=True, address=address)
    for line in ("Po", "S10", "+50"):
        assert x.ask(line).lines == ("Y",)
    assert x.ask("Q").lines == ("S10", "+50", "END")
    first = b"3Por\r" if address else b"Po?\r"
    assert x.transcript.sent.startswith(first)


def test_a_query_is_answered_and_other_commands_are_not(module):
    x = module("cy545")
    assert x.ask("R 50").lines == ()
    assert x.ask("? R").lines == ("R=00050",)
    assert x.value("rate") == "00050"
    assert x.value("position") == "00000000"


def test_a_question_with_a_damaged_answer_is_repeated(module):
    x = module(GSC)
    noise(x).plan("parity", 1)
    assert x.ask("V1").lines == ("V+0",)
    assert x.transcript.sent == b"V1\rV1\r"
    assert "parity or framing error" in x.transcript.notes[0]


def test_a_question_without_answer_is_repeated(module):
    x = module("cy545")
    x.ask("? P")
    noise(x, "chip").plan("lost", 1, after=3)  # the carriage return
    assert x.ask("? P").lines == ("P=00000000",)
    assert x.transcript.sent == b"? P\r? P\r\r? P\r"


def test_a_command_that_came_damaged_to_the_module_is_sent_again_for_nothing_was_done(module):
    x = module(GSC)
    x.ask("Po")
    noise(x, "chip").plan("parity", 1)
    assert x.ask("S10").lines == ("Y",)
    assert x.ask("Q").lines == ("S10", "END")
    assert x.transcript.notes == ["sent again: S10 was answered with E1"]


def test_a_command_whose_answer_came_damaged_is_not_sent_again(module):
    x = module(GSC)
    x.ask("Po")
    noise(x).plan("parity", 1)
    with pytest.raises(DamagedAnswer, match="answer to S10 is damaged"):
        x.ask("S10")
    assert x.ask("Q").lines == ("S10", "END")


def test_a_damaged_checksum_is_found(module):
    x = module("gs-c200s", checked=True)
    for after in (0, 4, 4, 4):  # the first of five characters, as often as it is asked
        noise(x).plan("garbled", 1, after=after)
    with pytest.raises(DamagedAnswer, match=r"is not its checksum.*check cable, rate and format"):
        x.ask("V1")


def test_a_refusal_has_its_code_and_its_meaning_in_the_sheet(module):
    x = module(GSC)
    with pytest.raises(RefusedCommand, match="X was answered with E6: the EEPROM failed") as refused:
        chip_of(x).store.write(b"\xff")
        x.ask("X")
    assert (refused.value.code, refused.value.description) == ("E6", "the EEPROM failed")


def test_silence_names_rate_and_format(module):
    x = module("gs-c200s?chs=0&br0=1")  # 4800 baud
    with pytest.raises(NoAnswer, match=r"no answer to V1 within 1.0 s, at 9600 baud, 7 data bits, odd parity, "):
        x.ask("V1")


def test_a_port_that_goes_away_is_reported(module):
    x = module(GSC)
    x.port.line.close()
    with pytest.raises(PortLost, match=r"the port is gone .*plug it in"):
        x.ask("V1")


def test_unsolicited_text_is_noted_and_not_taken_for_an_answer(module):
    x = module(GSC)
    x.send(b"V1\r")
    x.port.pause(0.1)
    assert x.ask("V2").lines == ("V70",)
    assert x.transcript.notes == ["unsolicited"]
    assert x.transcript.entries[1:3] == [("module", b"V+0\r"), ("host", b"V2\r")]


@pytest.mark.parametrize(
    ("part", "given", "says"),
    [
        ("gs-c200s", {"baud": 19200}, r"--baud 19200: not a rate of the GS-C200S; allowed 9600, 4800,"),
        ("gs-c200s", {"address": 8}, r"--address 8: allowed 0, 1, 2"),
        ("cy545", {"checked": True}, r"--checksum: not supported by the CY545"),
        ("cy545", {"address": 2}, r"--address: not supported by the CY545"),
        ("cy525", {"checked": True}, r"--checksum: not supported by the CY525"),
        ("cy525", {"baud": 300}, r"--baud 300: not a rate of the CY525; allowed 115200, 57600,"),
        ("cy500", {}, r"cy500 is on a bus and cannot be read back"),
        ("mc1451a", {}, r"mc1451a has a port for packets, but no serial line"),
    ],
)
def test_missing_commands_of_the_part_are_refused(part, given, says):
    with pytest.raises(UsageError, match=says):
        speech_of(sheet_of(part), **given)
