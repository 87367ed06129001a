"""A dialogue that is played to a module now: the same commands, and none that moves unless that is allowed."""

from __future__ import annotations

import pytest

from slewline.modules.comparing.exchanges import exchanges_of
from slewline.modules.comparing.playing import hazards, play
from slewline.modules.failures import MotionRefused, ReplacementRefused

from .conftest import chip_of, noise
from .recorded import CY545, GSC, recorded

STILL = ["F", "V1", "Po", "S10", "+600", "Px", "Q", "V2"]  # +600 is stored


def exchanges(module, part, lines):
    return exchanges_of(recorded(part, lines).entries, module.speech)


def test_commands_that_move_are_found_before_anything_is_sent(module):
    one = module("gs-c200s?chs=0")
    with pytest.raises(
        MotionRefused, match=r"E, \+5 may step the motor; no command was sent; allow motion with --move"
    ):
        play(exchanges(one, "gs-c200s", [*STILL, "E", "+5", "F"]), one)
    assert one.transcript.sent == b""


def test_stored_commands_do_not_move(module):
    one = module("gs-c200s?chs=0")
    assert hazards(exchanges(one, "gs-c200s", STILL), one.speech) == ([], ["Po"])
    other = module("cy545")
    assert hazards(exchanges(other, "cy545", ["E", "G", "Q", "Y 0"]), other.speech) == ([], ["E"])
    assert hazards(exchanges(other, "cy545", CY545), other.speech) == (["G"], ["E"])


@pytest.mark.parametrize("line", ["Po", "X", "M"])
def test_the_program_of_a_module_is_not_replaced(module, line):
    one = module("gs-c200s?chs=0")
    with pytest.raises(
        ReplacementRefused, match=f"{line} would replace the module's program.*no command was sent.*slewline pull"
    ):
        play(exchanges(one, "gs-c200s", ["F", line]), one)
    assert one.transcript.sent == b""


def test_a_dialogue_without_motion_is_played(module):
    one = module("gs-c200s?chs=0")
    play(exchanges(one, "gs-c200s", STILL), one, may_replace=True)
    asked = [said for who, said in one.transcript.entries if who == "host"]
    assert asked == [f"{line}\r".encode() for line in STILL]
    answers = b"".join(said for who, said in one.transcript.entries if who == "module")
    assert answers == b"R\rV+0\rY\rY\rY\rY\rS10\r+600\rEND\rV70\r"
    assert not chip_of(one).steps()


def test_motion_that_is_allowed_is_played(module):
    one = module("gs-c200s?chs=0", may_move=True)
    play(exchanges(one, "gs-c200s", GSC), one, may_replace=True)
    assert len(chip_of(one).steps()) == 120


def test_a_damaged_answer_is_noted_and_the_dialogue_continues(module):
    one = module("gs-c200s?chs=1", checked=True)
    noise(one).plan("parity", count=1, after=3)
    play(exchanges_of(recorded("gs-c200s", ["F", "V1", "F"], checksum=True).entries, one.speech), one)
    assert len([1 for who, _ in one.transcript.entries if who == "host"]) == 3


def test_pauses_are_those_of_the_dialogue(module):
    one = module("gs-c200s?chs=0")
    paused = []
    one.port.pause = paused.append
    play(exchanges_of(recorded("gs-c200s", ["F", "F", "F"], pause_us=250_000).entries, one.speech), one)
    assert paused == [pytest.approx(0.25, abs=0.002)] * 2


def test_a_longer_timeout_than_that_of_the_part_is_used(module, monkeypatch):
    one, waits = module("gs-c200s?chs=0"), []
    chunks = one.chunks
    monkeypatch.setattr(
        one, "chunks", lambda answer_timeout, *more: waits.append(answer_timeout) or chunks(answer_timeout, *more)
    )
    play(exchanges(one, "gs-c200s", ["F"]), one)
    play(exchanges(one, "gs-c200s", ["F"]), one, wait_s=30.0)
    usual = one.speech.answer_timeout("F")
    assert waits == [usual, 30.0] and usual < 30.0
