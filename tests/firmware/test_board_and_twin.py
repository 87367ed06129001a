"""The board's firmware, in the emulator, against its Python twin: every edge to the cycle, every frame to the byte.

A third one is a witness: that of the firmware which boards have in common, compiled for this machine.

A twin cannot know when the main loop takes a frame or when the processor looks at an input; that it is told, by the
ticks that the board itself names.  How late those may be has bounds of its own.
"""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import pytest

from slewline.drive.board import wire
from slewline.drive.board.frames import decode
from slewline.drive.board.wire import Answer, BoardEvent, Happening

from .dialogue import (
    FILTERED_WITHIN,
    LAMPS_WITHIN,
    MOMENT,
    PULSE_LEAST,
    SEEN_WITHIN,
    SHOWN_WITHIN,
    TAKEN_WITHIN,
    Dialogue,
    told_to_twin,
)
from .witness import last_of_each_tick, witnessed

pytestmark = pytest.mark.system

SOME, ALL, MOST = 40, 1_000, 3_000
FASTEST = (640, 700, 900, 1_500)  # ticks between steps, by seed; test_brakes.py has the faster ones


LOST = "a byte lost as a brake began"
LOST_WITHIN = 4_000  # ticks of the begin of a brake
BRAKES = (Happening.BRAKED, Happening.UNDERRUN, Happening.WATCHDOG)
SWITCHED = (  # how the driver is: by a frame, an input or a round of the main loop, in which state before
    "on by frame, IDLE",
    "off by frame, IDLE",
    "off by frame, HALT",
    "off by input, IDLE, locked",
    "off by input, RUN, locked",
    "off by round, IDLE",
    "off by round, IDLE, locked",
    "off by round, HALT, locked",
)


def compare(emulator, program, seed):
    """Play a dialogue, and compare what came of it; return how often what happened."""
    dialogue = Dialogue(emulator, seed, fastest=FASTEST[seed % len(FASTEST)])
    board = dialogue.play()
    if board.lost:
        only_as_a_brake_begins(board, f"seed {seed}")
        return Counter({LOST: 1}), 0
    power = Counter()
    twin = told_to_twin(board, dialogue.chunks, power)
    bear_witness(witnessed(program, board, dialogue.chunks), twin, f"seed {seed}")
    end = dialogue.end  # what is near the end may be on the way

    frames = [wire.read(decode(frame[:-1])) for _, frame in board.frames]
    expected = [wire.read(decode(chunk)) for chunk in bytes(twin.sent).split(b"\0")[:-1]]
    sent = [chunk + b"\0" for chunk in bytes(twin.sent).split(b"\0")[:-1]]
    at, skipped = 0, 0
    while at < min(len(frames), len(expected)):
        one, other = frames[at], expected[at]
        # with a filter the main loop may be late, and of many events only the last eight are kept
        gone = one != other and dialogue.filter and isinstance(one, BoardEvent) and isinstance(other, BoardEvent)
        if gone and one.number != other.number:
            skipped += 1
            del expected[at], sent[at]
            continue
        assert one == other, f"seed {seed}, frame {at}"
        at += 1
    assert skipped <= 4, f"seed {seed}: {skipped} events"
    assert all(said.tick >= end for said in expected[len(frames) :]), f"seed {seed}"
    assert b"".join(sent).startswith(b"".join(frame for _, frame in board.frames))

    edges = set(twin.pulses)
    steps = [(tick, way) for tick, way, _ in twin.steps if tick < end and tick in edges]
    assert [step for step in board.steps if step[0] < end] == steps, f"seed {seed}"
    for rise, fall in zip(board.rises, board.falls, strict=False):
        assert fall - rise >= PULSE_LEAST, f"seed {seed}: a pulse of {fall - rise} ticks at {rise}"

    shown(board.phases, twin.phases, end, f"seed {seed}: phases")
    lamps = sum(1 << number - 1 for number in set(dialogue.lamps) if number)
    later = 2 * FILTERED_WITHIN * dialogue.filter  # of the main loop, while looks are taken
    for bits, within in ((15 & ~lamps, SHOWN_WITHIN + later), (lamps, LAMPS_WITHIN)):
        shown(only(bits, board.outputs), only(bits, twin.outputs), end, f"seed {seed}: outputs {bits}", within)
    shown(board.enable, twin.enable, end, f"seed {seed}: ENABLE", SHOWN_WITHIN + later, first=None)
    undriven(board, f"seed {seed}")
    in_time(dialogue, board)
    kinds = Counter(Happening(said.kind) for said in frames if isinstance(said, BoardEvent))
    power["steps of dry runs"] += len(twin.steps) - len(twin.pulses)
    return kinds + power, len(steps)


def bear_witness(witness, twin, what):
    """The C that boards have in common, on this machine, makes of the same what the twin does: to the byte and tick."""
    assert bytes(witness.sent) == bytes(twin.sent), f"{what}: frames"
    assert [step[:2] for step in witness.steps] == [step[:2] for step in twin.steps], f"{what}: steps"
    assert [tick for tick, _, edge in witness.steps if edge] == list(twin.pulses), f"{what}: edges"
    assert witness.changes("phases") == last_of_each_tick(twin.phases, 0), f"{what}: phases"
    assert witness.changes("outputs") == last_of_each_tick(only(15, twin.outputs), 0), f"{what}: outputs"
    assert witness.changes("enable") == last_of_each_tick(twin.enable, None), f"{what}: ENABLE"


def only_as_a_brake_begins(board, what):
    """Bytes are lost where fast steps begin a way down and nowhere else: the next step is more urgent."""
    begins = [said.tick for said in map(read, board.frames) if isinstance(said, BoardEvent) and said.kind in BRAKES]
    for tick in board.lost:
        assert any(begin <= tick < begin + LOST_WITHIN for begin in begins), f"{what}: a byte lost at {tick}"


def only(bits, changes):
    """Some bits of outputs: tick and value of each change."""
    out, before = [], 0
    for tick, value in changes:
        if value & bits != before:
            out.append((tick, before := value & bits))
    return out


def undriven(board, what):
    """Pins of phases that are no outputs have no pull-up, but for the moment before they become outputs."""
    rows = [*board.ports, (board.now, 0, 0, 0, 0xF0)]
    for (tick, _, _, portd, ddrd), (until, *_) in pairwise(rows):
        assert ddrd & 0xF0 in (0, 0xF0) and (ddrd & 0xF0 or not portd & 0xF0 or until - tick < MOMENT), (what, tick)


def shown(found, expected, end, what, within=SHOWN_WITHIN, first=0):
    """Values, in their order, each within its bound; in between one pin may be before the other."""
    for at, (tick, value) in enumerate(expected):
        if tick >= end:
            break
        later = expected[at + 1][0] if at + 1 < len(expected) else end + within
        if later - tick > within:
            now = [each for when, each in found if when <= tick + within]
            assert (now[-1] if now else first) == value, f"{what}, from {tick} on"
    instants = [tick for tick, _ in expected]
    for tick, _ in found:
        if tick < end:
            assert any(each <= tick <= each + within for each in instants), f"{what}: something at {tick}"


def in_time(dialogue, board):
    """A frame is taken soon behind its last byte or the answer before it, an edge is seen soon."""
    answers = [said for said in map(read, board.frames) if isinstance(said, Answer)]
    before = 0
    for answer, (tick, _) in zip(answers, [chunk for chunk in dialogue.chunks if chunk[1]], strict=False):
        assert tick <= answer.tick <= max(tick, before) + TAKEN_WITHIN * (2 if dialogue.filter else 1)
        before = answer.tick
    levels, looks, within = 0x3F, [], SEEN_WITHIN + FILTERED_WITHIN * dialogue.filter
    for tick, after in board.looks:
        looks.append((tick, (levels ^ after).bit_length() - 1))
        levels = after
    for number in range(6):
        edges = [tick for tick, each in dialogue.edges if each == number]
        seen = [tick for tick, each in looks if each == number]
        for edge in edges:
            alone = sum(abs(each - edge) <= 2 * within for each in edges) == 1
            assert not alone or any(edge <= look <= edge + within for look in seen), (number, edge)


def read(row):
    return wire.read(decode(row[1][:-1]))


def enough(kinds, steps, runs):
    """A law about things that never happen would say nothing."""
    for happening in Happening:
        if happening not in (Happening.LATE, Happening.CHECKED):
            assert kinds[happening] >= runs // 200, happening
    assert kinds[Happening.LATE] == 0 and kinds[LOST] <= runs // 200
    assert steps > 40 * runs and kinds["steps of dry runs"] > 2 * runs
    for switched in SWITCHED:
        assert kinds[switched] >= runs // 200, switched


def test_some_dialogues(emulator, script):
    kinds, steps = Counter(), 0
    for seed in range(SOME):
        more, made = compare(emulator, script, seed)
        kinds += more
        steps += made
    assert kinds[Happening.LATE] == 0
    assert steps > 40 * SOME


@pytest.mark.long
@pytest.mark.timeout(900)
def test_a_thousand_dialogues(emulator, script):
    """What is rare in them is looked for in more of them."""
    kinds, steps = Counter(), 0
    for seed in range(SOME, SOME + MOST):
        if seed >= SOME + ALL and min(kinds[switched] for switched in SWITCHED) >= ALL // 200:
            break
        more, made = compare(emulator, script, seed)
        kinds += more
        steps += made
    enough(kinds, steps, ALL)
