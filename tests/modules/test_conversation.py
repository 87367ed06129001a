"""A person's conversation with a module: answers and their meanings, findings, the manual's words."""

from __future__ import annotations

import pytest

from slewline.modules.comparing.model import ModelLine
from slewline.modules.conversation import LONGEST_S, VERBS, Conversation, ShadowModel
from slewline.modules.dialogue import DialogueHeader

from .conftest import chip_of

GSC = "gs-c200s?chs=0"


class Clock:
    """Seconds of a wall clock that a test lets pass."""

    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def talk(module):
    """A conversation with a module, whose model may find things."""

    def make(url=GSC, shadow=True):
        one = module(url, may_move=True)
        header = DialogueHeader(url.partition("?")[0])
        made = ShadowModel(ModelLine(header, one.speech), Clock()) if shadow else None
        return Conversation(one, made)

    return make


def test_a_line_its_answer_and_its_meaning(talk):
    talk = talk()
    found = talk.say("F")
    assert (found.lines, found.meaning, found.findings, found.failure) == (("R",), "ready", [], "")
    assert found.answered_ms > 0
    assert talk.say("V1").lines == ("V+0",)
    assert talk.say(" Po ").meaning == "accepted"
    assert talk.module.transcript.sent == b"F\rV1\rPo\r"


def test_oddities_are_next_to_their_line(talk):
    talk = talk()
    found = talk.say("S0")
    assert (found.lines, found.meaning) == (("E2",), "argument missing, wrong or out of range")
    assert found.findings == ["E2: S0: speed 0, allowed 1..1000; the nearest is 1"]
    assert talk.say("F").findings == []
    assert talk.say("+250").findings == ["E4: +250 outside a program; begin program entry with Po"]


def test_oddities_since_the_last_line_are_kept_apart(talk):
    talk = talk()
    talk.shadow.line.chip.finding("E5", "something on its way")
    found = talk.say("F")
    assert found.since == ["E5: something on its way"]
    assert found.findings == []


def test_the_model_keeps_the_time(talk):
    talk = talk()
    for line in ("Po", "S10", "T100", "R50", "+60", "E"):
        talk.say(line)
    moving = talk.shadow.line.chip
    talk.shadow.clock.now += 5
    talk.shadow.catch_up()
    assert len(moving.steps()) == 60
    assert talk.shadow.line.kernel.now == pytest.approx(talk.shadow.began_ps + 5 * 10**12, rel=0.01)


def test_after_a_long_silence_the_model_leaves_time_out(talk):
    talk = talk()
    began_ps = talk.shadow.line.kernel.now
    talk.shadow.clock.now += 10**6
    talk.shadow.catch_up()
    assert talk.shadow.line.kernel.now == began_ps + LONGEST_S * 10**12
    talk.shadow.clock.now += 1
    talk.shadow.catch_up()
    assert talk.shadow.line.kernel.now == began_ps + (LONGEST_S + 1) * 10**12


def test_without_a_model_nothing_is_found(talk):
    assert talk(shadow=False).say("S0").findings == []


def test_a_command_that_is_not_answered(talk):
    talk = talk("cy545")
    found = talk.say("R 300")
    assert (found.lines, found.answered_ms) == ((), None)
    assert found.findings[0].startswith("range: RATE 300: allowed 0..255")
    assert talk.say("? R").lines == ("R=00044",)


def test_moves_are_left_to_the_user(talk):
    talk = talk()
    for line in ("Po", "S10", "T100", "R50", "+60", "E"):
        talk.say(line)
    talk.module.port.pause(2)
    assert len(chip_of(talk.module).steps()) == 60


def test_an_answer_that_does_not_come(talk):
    talk = talk()
    talk.module.port.line.rig.line.to_host.plan("lost", count=2)
    found = talk.say("F")
    assert (found.lines, found.findings) == ((), [])
    assert "no answer to F within 1.0 s, at 9600 baud" in found.failure


def test_characters_without_change(talk):
    talk = talk()
    assert talk.say(":send F\\rV1\\r").lines == ["R", "V+0"]
    assert talk.module.transcript.sent == b"F\rV1\r"
    assert "allowed ASCII" in talk.say(":send µ").failure


def test_all_values(talk):
    assert talk().say(":values").text == "position: +0\ninputs and outputs: 70"


def test_forbidden_lines(talk):
    talk = talk()
    assert "expected one line of ASCII" in talk.say("µ").failure
    assert talk.say(":halp").failure == f":halp: there is no such verb; allowed {', '.join(VERBS)}"
    assert talk.say("").lines == ()
    assert talk.say(":quit").over
    assert talk.module.transcript.sent == b""


@pytest.mark.parametrize("line", ["quit", "exit", "help R", "HELP", "values"])
def test_a_verb_without_its_colon_is_not_sent(talk, line):
    talk = talk()
    found = talk.say(line)
    assert "is not a command of a part; :" in found.failure
    assert talk.module.transcript.sent == b""


def test_the_manuals_words(talk):
    talk = talk()
    assert "START_STOP" in talk.say(":help S").text
    assert "has no command 'nope'" in talk.say(":help nope").text
    every = talk.say(":help").text
    assert "A <output>" in every
    assert ":quit" in every
    assert talk.hint("S1") == "S <speed>: start-stop speed"
    assert talk.hint("Po").startswith("Po: begin programming")
    assert talk.hint("-25") == "± <steps>: move by a number of steps"
    assert talk.hint("V1") == "queries position"
    assert talk.hint(":help x") == VERBS[":help"]
    assert talk.hint("") == talk.hint("?") == ""


def test_completion(talk):
    gsc, cy545 = talk(), talk("cy545")
    assert [each.text for each in gsc.suggestions("p")] == ["Po", "Px"]
    assert [each.text for each in gsc.suggestions("V")] == ["V", "V1", "V2"]
    assert [each.text for each in gsc.suggestions(":he")] == [":help"]
    assert [each.text for each in gsc.suggestions(":help J")] == [":help j", ":help jc"]
    assert gsc.suggestions(":quit x") == []
    assert ("? P", "queries position") in cy545.suggestions("?")


def test_unsolicited_characters(talk):
    talk = talk()
    talk.module.port.line.write(b"F\r")
    talk.module.port.pause(0.1)
    assert talk.unasked() == "R\r"
    assert talk.unasked() == ""
