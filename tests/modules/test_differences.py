"""A dialogue against the model: what was planted is found, and nothing else."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest

from slewline.chips import sheet_of
from slewline.modules.comparing.exchanges import are_checked, commands, exchanges_of
from slewline.modules.comparing.model_differences import DialogueComparison, Tolerance, usual_tolerance
from slewline.modules.dialogue import DialogueEntry, RecordedDialogue
from slewline.modules.speech import speech_of
from tests.ensembles import few

from .recorded import CY545, GSC, GSC200, recorded

PARTS = {
    "gs-c200s": lambda: recorded("gs-c200s", GSC),
    "gs-c200s with checksums": lambda: recorded("gs-c200s", GSC, checksum=True),
    "gs-c200 of a line": lambda: recorded(
        "gs-c200", GSC200, checksum=True, address=5, straps={"sel2": 0, "sel1": 1, "sel0": 0}
    ),
    "cy545b": lambda: recorded("cy545b", CY545, pause_us=50_000),
    "cy545": lambda: recorded("cy545", CY545, pause_us=50_000),
}


@pytest.fixture(scope="module")
def dialogues():
    """Dialogues that are made once."""
    made = {}

    def give(name):
        if name not in made:
            made[name] = PARTS[name]()
        return made[name]

    return give


def speech(dialogue):
    header = dialogue.header
    return speech_of(sheet_of(header.part), header.baud, header.checksum, header.address)


def compared(dialogue, tolerance=None):
    return DialogueComparison(dialogue, speech(dialogue), tolerance).compare()


def later(dialogue, place, by_us):
    """A dialogue in which everything from an entry on comes later."""
    said = [
        replace(each, at_us=each.at_us + by_us, last_us=each.last_us + by_us) if number >= place else each
        for number, each in enumerate(dialogue.entries)
    ]
    return replace(dialogue, entries=tuple(said))


def with_answer(dialogue, place, data):
    said = list(dialogue.entries)
    said[place] = replace(said[place], data=data)
    return replace(dialogue, entries=tuple(said))


@pytest.mark.parametrize("name", PARTS)
def test_a_part_like_its_model_does_not_differ(dialogues, name):
    dialogue = dialogues(name)
    found = compared(dialogue, Tolerance(100, 0))
    assert found.agree, str(found)
    assert found.exchanges == sum(said.speaker == "host" and said.data != b"Q" for said in dialogue.entries)
    assert max(map(abs, found.delays_us)) < 10


def test_an_address_is_that_of_the_model_and_others_on_the_line_are_left_out():
    straps = {"sel2": 0, "sel1": 1, "sel0": 0}  # address 5
    own = recorded("gs-c200s", ["F", "V1"], address=5, straps=straps)
    other = recorded("gs-c200s", ["I3", "F"], address=4, straps={"sel2": 1, "sel1": 1, "sel0": 0})
    both = replace(own, header=replace(own.header, straps={}), entries=(*other.entries, *later(own, 0, 10**6).entries))
    found = compared(both)
    assert (found.exchanges, found.rows) == (2, [])


def plants(dialogue, count, seed):
    """Twenty differences in one dialogue, far enough apart: where, of which kind, and the dialogue with them."""
    draw = random.Random(seed)
    places = {id(said): number for number, said in enumerate(dialogue.entries)}
    number, told, answers = 0, [], []
    for said in dialogue.entries:
        number += said.speaker == "host" and said.data != b"Q"  # which a line follows
        if said.speaker == "module":
            answers.append((number, places[id(said)], said))
    lines = {number: sum(other == number for other, _, _ in answers) for number, _, _ in answers}
    chosen = sorted(draw.sample(sorted(lines), count))
    for number in chosen:
        own = [(place, said) for other, place, said in answers if other == number]
        place, said = draw.choice(own)
        kind = draw.choice(
            ["listing" if lines[number] > 1 else "answer", "delay", "duration" if len(own) > 1 else "delay"]
        )
        if kind == "delay":
            dialogue = later(dialogue, own[0][0], draw.randrange(30_000, 300_000))
        elif kind == "duration":
            dialogue = later(dialogue, own[-1][0], draw.randrange(60_000, 300_000))
        else:
            odd = bytes(byte ^ 1 if 0x30 <= byte <= 0x39 else 0x58 for byte in said.data[:-1])
            dialogue = with_answer(dialogue, place, odd + b"\r")
        told.append((number, kind))
    return told, dialogue


@pytest.mark.parametrize("seed", few(range(3), 1))
@pytest.mark.parametrize("name", PARTS)
def test_twenty_planted_differences_are_found_and_no_other(dialogues, name, seed):
    told, dialogue = plants(dialogues(name), 20, seed)
    found = compared(dialogue, Tolerance(20_000, 0))
    assert sorted({(row.exchange, row.kind) for row in found.rows}) == told, str(found)


@pytest.mark.parametrize("name", PARTS)
def test_a_planted_difference_of_each_kind_names_what_differs(dialogues, name):
    dialogue = dialogues(name)
    places = [number for number, said in enumerate(dialogue.entries) if said.speaker == "module"]
    found = compared(with_answer(later(dialogue, places[3], 40_000), places[0], b"X\r")).as_json()
    first, second = found["differences"]
    assert (first["kind"], first["module"].strip()) == ("answer", "X")
    assert second["kind"] == "delay"
    assert second["module"] - second["model"] == pytest.approx(40_000, abs=200)
    assert found["agree"] is False


def test_a_silent_module_differs(dialogues):
    dialogue = dialogues("gs-c200s")
    said = tuple(each for number, each in enumerate(dialogue.entries) if number != 3)
    (row,) = compared(replace(dialogue, entries=said)).rows
    assert (row.exchange, row.module, row.model) == (2, "", "V+0")
    assert str(row).endswith("V1: module no answer, model V+0")


def test_a_module_that_sends_more_than_the_model_differs(dialogues):
    dialogue = dialogues("cy545")
    place = next(number for number, each in enumerate(dialogue.entries) if each.data == b"F 10\r")
    own = dialogue.entries[place]
    more = replace(own, speaker="module", at_us=own.at_us + 10_000, last_us=own.last_us + 10_000, data=b"?\r")
    said = (*dialogue.entries[: place + 1], more, *dialogue.entries[place + 1 :])
    (row,) = compared(replace(dialogue, entries=said)).rows
    assert (row.command, row.module, row.model) == ("F 10", "?", "")


def stretched(dialogue, factor):
    """The dialogue of a module whose clock is slower than that of the model, with a host that waits as long."""
    said = [
        replace(each, at_us=round(each.at_us * factor), last_us=round(each.last_us * factor))
        for each in dialogue.entries
    ]
    return replace(dialogue, entries=tuple(said))


@pytest.mark.parametrize("name", PARTS)
def test_a_clock_within_tolerance_makes_no_difference_and_polls_may_meet_another_moment(dialogues, name):
    found = compared(stretched(dialogues(name), 1.003))
    assert found.agree, str(found)


def test_a_poll_that_meets_another_moment_counts():
    """The module is ready at the poll before the one at which the model is."""
    dialogue = recorded("gs-c200s", [*GSC[:12], *["F"] * 120], pause_us=5_000)
    place = next(number for number, each in enumerate(dialogue.entries) if each.data == b"R\r" and number > 30)
    early = with_answer(dialogue, place - 2, b"R\r")
    found = compared(early)
    assert (found.agree, found.moments) == (True, 1)
    assert "1 answer would agree if the model were queried slightly earlier or later" in str(found)
    far = with_answer(dialogue, place - 12, b"R\r")
    assert [(row.module, row.model) for row in compared(far).rows] == [("R", "B")]


def test_a_slower_motion_is_found(dialogues):
    slow = recorded("gs-c200s", ["Po", "S10", "T90", "R50", "+6000", "Px", "E", *["F"] * 4], pause_us=2_130_000)
    said = [replace(each, data=each.data.replace(b"T90", b"T100")) for each in slow.entries]
    rows = compared(replace(slow, entries=tuple(said))).rows
    assert [(row.command, row.module, row.model) for row in rows] == [("F", "B", "R")]


def test_the_clock_counts_from_the_beginning_of_a_motion():
    """A motion of 6.09 s, which a clock that is 0.4 % slow ends 24 ms later; the last poll but one falls in between."""
    lines = ["Po", "S10", "T100", "R50", "+6000", "Px", "E", *["F"] * 4]
    slow = stretched(recorded("gs-c200s", lines, pause_us=2_024_000), 1.004)
    assert (compared(slow, Tolerance(1_000, 0.005)).rows, compared(slow, Tolerance(1_000, 0.005)).moments) == ([], 1)
    assert [(row.module, row.model) for row in compared(slow, Tolerance(1_000, 0)).rows] == [("B", "R")]


def test_two_times_agree_within_a_fixed_part_and_a_share():
    tolerance = Tolerance(1_000, 0.01)
    assert tolerance.allows(100_000, 101_900) and tolerance.allows(101_900, 100_000)
    assert not tolerance.allows(100_000, 103_000)
    assert not Tolerance(1_000, 0).allows(100_000, 101_900)


def test_the_usual_tolerance_has_four_characters_and_the_clock():
    spoken = speech_of(sheet_of("gs-c200s"), 1200)
    assert usual_tolerance(spoken, None) == Tolerance(20_000 + round(4 * 11e6 / 1200), 0.005)
    assert usual_tolerance(spoken, 6_000_000).share == 0.0002


def test_lines_that_are_sent_together_share_an_exchange():
    dialogue = recorded("gs-c200s", ["F", "F"])
    first, answer, second, last = dialogue.entries
    at_once = replace(first, data=first.data + second.data)
    (found,) = exchanges_of([at_once, answer, last], speech(dialogue))
    assert (found.sent, found.answer) == (b"F\rF\r", b"R\rR\r")
    assert commands(speech(dialogue), found.sent) == ["F", "F"]


@pytest.mark.parametrize(("pause_us", "sent"), [(0, [b"F\r", b"F\r"]), (-1, [b"F\rF\r"])])
def test_a_line_sent_when_the_one_before_it_is_over_is_an_exchange_of_its_own(pause_us, sent):
    """Two characters of 11 bits at 110 baud take 200 ms."""
    spoken = speech_of(sheet_of("gs-c200s"), 110)
    at_us = 200_000 + pause_us
    said = [DialogueEntry(0, 0, "host", b"F\r"), DialogueEntry(at_us, at_us, "host", b"F\r")]
    assert [each.sent for each in exchanges_of(said, spoken)] == sent


def test_a_line_feed_belongs_to_the_line_before_it():
    dialogue = recorded("gs-c200s", ["F", "V1"])
    said = [replace(each, data=each.data + b"\n") if each.speaker == "host" else each for each in dialogue.entries]
    first, second = exchanges_of(said, speech(dialogue))
    assert (first.sent, first.answer, second.sent) == (b"F\r\n", b"R\r", b"V1\r\n")
    assert commands(speech(dialogue), first.sent) == ["F"]
    (row,) = compared(replace(dialogue, entries=tuple(said))).rows  # the module of the recording has got no line feed
    assert (row.command, row.module, row.model) == ("V1", "V+0", "E4")


def test_times_are_those_on_the_line():
    """Three characters of 11 bits at 9600 baud that a host has handed over at once."""
    (found,) = exchanges_of(recorded("gs-c200s", ["V1"]).entries, speech_of(sheet_of("gs-c200s")))
    assert found.over_us - found.at_us == pytest.approx(3 * 11e6 / 9600)
    assert 1_000 < found.delay_us < 4_000
    assert found.duration_us == pytest.approx(3 * 11e6 / 9600, abs=2)


def test_checksums_are_seen_in_what_was_sent(dialogues):
    assert are_checked(dialogues("gs-c200s with checksums").entries)
    assert not are_checked(dialogues("gs-c200s").entries)
    assert not are_checked(())


def test_silence_is_not_a_difference(dialogues):
    empty = RecordedDialogue(dialogues("gs-c200s").header)
    assert (compared(empty).exchanges, compared(empty).agree) == (0, True)
    assert compared(empty).as_json()["module_less_model_us"] == {"least": None, "median": None, "greatest": None}
