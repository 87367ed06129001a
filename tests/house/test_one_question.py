"""Events in time are asked for in one vocabulary: how many by an instant, when is the k-th, all of a window."""

from __future__ import annotations

import shutil

from tests.house.vocabularies import answering, lines, vocabularies
from tests.sources import SOURCES

ALLOWED = {  # the class, its names, and why they are not those of another
    # ---- the one way: what happens has numbers, and what is shown has levels between
    "Events: count few time times": "core/time/events.py",
    "Promise: after edges level": "core/wires/wave.py: a wave",
    # ---- what these are made of
    "Train: count_many end pieces rests step_at steps_at window": "a train in ticks of its clock, before it converts",
    "StepView: rise rise_ticks": "what the views of pulse and strobe differ in, in ticks",
    "CycleClock: cycle_at cycle_at_tick ps tick": "numbers cycles from 0 on, and below before reset: a clock",
    "View: after_of edges_of level_of": "a wave that follows from others, before it is bounded",
    "ShaftMotion: level lost moved": "places of a shaft, in parts of a step",
    "Piece: levels look_after": "levels of the inputs of a stepper, all of them in one answer",
    "Net: edges_ahead levels_before resolve": "what several drivers make of a wire",
    # ---- other things that have instants
    "HandshakenBytes: current latest_edge request_of": "how far a command over a handshake has come, in bytes",
    "Axis: driven loads marks motions played position_at positions_at turns unwrapped_at": (
        "the face of an axis to users and parts: positions, several motions, turns of direction"
    ),
    "VariableSource: changes values_at": "a variable of a VCD file, whose values are of any kind",
    "Run: between comes_to_rest": "points of an integration, which are states and no edges",
}
TRAIN = '''
"""A module."""
from typing import NewType, Protocol, TypeAlias
import numpy as np
from numpy.typing import NDArray
Ps = NewType("Ps", int)
Many: TypeAlias = "NDArray[np.int64]"

class Asked(Protocol):
    def seen(self, at: Ps) -> int: ...
    def arrival(self, number: int) -> Ps | None: ...
    def span(self, first: int, last: int) -> Many: ...

class Made:
    """It has the words of the protocol without its name, and a private one."""
    def seen(self, now: int) -> int: ...
    def arrival(self, k: int) -> Ps | None: ...
    def span(self, first: int, last: int, out: Many | None = None) -> Many: ...
    def _inner(self, ps: int, k: int) -> int: ...
'''
OTHER = '''
"""A module."""
from typing import Any, Protocol

class Pulses:
    def so_many(self, ps: int) -> int: ...
    def the(self, k: int) -> "int | None": ...

class MorePulses(Pulses):
    def so_many(self, ps: int) -> int: ...

class Looking(Protocol):
    def coming(self, now: int) -> int | None: ...

class Curve:
    """A speed is no event."""
    def at(self, ps: int) -> float: ...
    def many(self, first: int, last: int) -> list[float]: ...

class Clock:
    """It converts, and answers one kind of question only."""
    def ticks(self, ps: int) -> int: ...
    def many_ticks(self, ps: list[int]) -> list[int]: ...

class Table:
    """Of neither instants nor numbers of events."""
    def row(self, code: int) -> int: ...
    def window(self, low: int, high: int) -> list[int]: ...
    def name(self, k: int) -> str: ...
'''


def test_the_sources_query_events_by_the_allowed_names():
    found = vocabularies()
    new = [each for each in found if each.title not in ALLOWED]
    assert not new, "another vocabulary for events in time; ask in the words of one that is there:\n" + "\n".join(
        lines(new)
    )
    assert ALLOWED.keys() - {each.title for each in found} == set()  # what is gone leaves the list


def test_new_words_for_the_same_questions_are_found(tmp_path):
    room = tmp_path / "sources" / "core"
    room.mkdir(parents=True)
    (room / "train.py").write_text(TRAIN, "utf-8")
    only = vocabularies(tmp_path / "sources")
    assert [each.title for each in only] == ["Asked: arrival seen span"]
    assert [one.name for one in only[0].classes] == ["Asked", "Made"]
    assert only[0].kinds == {"seen": "at", "arrival": "numbered", "span": "window"}

    (room / "other.py").write_text(OTHER, "utf-8")
    titles = [each.title for each in vocabularies(tmp_path / "sources")]
    assert titles == ["Asked: arrival seen span", "Looking: coming", "Pulses: so_many the"]


def test_a_class_planted_in_the_sources_is_another_vocabulary(tmp_path):
    planted = tmp_path / "slewline"
    shutil.copytree(SOURCES / "slewline/core", planted / "core", ignore=shutil.ignore_patterns("__pycache__"))
    before = {each.title for each in vocabularies(tmp_path)}
    (planted / "core/wires/planted.py").write_text(OTHER, "utf-8")
    assert {each.title for each in vocabularies(tmp_path)} - before == {
        "Looking: coming",
        "Pulses: so_many the",
    }


def test_other_methods_have_no_kind_of_question(tmp_path):
    (tmp_path / "other.py").write_text(OTHER, "utf-8")
    questions = {one.name: one.questions for one in answering(tmp_path)}
    assert questions["Curve"] == questions["Table"] == {}
    assert set(questions["Clock"].values()) == {"at"}


def test_additional_names_next_to_known_words_are_another_vocabulary(tmp_path):
    more = TRAIN + "    def upto(self, t: int) -> int: ...\n    def instant_of(self, n: int) -> int: ...\n"
    (tmp_path / "train.py").write_text(more, "utf-8")
    assert [each.title for each in vocabularies(tmp_path)] == ["Asked: arrival seen span", "Made: instant_of upto"]
