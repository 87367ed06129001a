"""Breakpoints of the MC1451A family: seven conditions, when each fires, and what it brings into force."""

from __future__ import annotations

import pytest
from mc import AXES, ONE, PARTS, T1, T1_CYCLES, T4, V1, base, each, with_axes, with_encoder
from mc_motion import Look, Mover, mover

UNIT = ONE // 64  # the acceleration of T1
SHORT = (f"SET_VEL {ONE}", f"SET_ACC {ONE}", "SET_POS 10")  # ten cycles, a step in each
FIRED = 4  # bit 2 of the status word
KINDS = ("TIME", "POS", "NEG", "ACTL_POS", "ACTL_NEG", "MTN_CMPLT", "EXT")

each_kind = pytest.mark.parametrize("kind", KINDS)


def first(looks: list[Look], event: int = FIRED) -> int:
    """In which of these cycles an event stands first; it stays."""
    events = [bool(look.status & event) for look in looks]
    assert events == sorted(events) and any(events)
    return events.index(True)


def breakable(kind: str, part: str = "mc1151a-e") -> Mover:
    """An axis whose breakpoint of a kind is armed; nothing satisfies it until `satisfy` does."""
    rig = mover(part, **{"quadrature": {}} if part.endswith("-e") else {})
    value = {"TIME": rig.cycle + 100, "NEG": -5, "ACTL_NEG": -5}.get(kind, 5)
    rig.do("SET_VEL 65536", "SET_ACC 65536", f"SET_BRK_PNT {value}", f"SET_{kind}_BRK")
    return rig


def satisfy(rig: Mover, kind: str) -> None:
    """What the breakpoint waits for happens; all is quiet again afterwards."""
    if kind in ("POS", "NEG", "MTN_CMPLT"):
        rig.begin(f"SET_POS {-10 if kind == 'NEG' else 10}")
    elif kind.startswith("ACTL"):
        rig.shafts["quadrature"].push(10 if kind == "ACTL_POS" else -10)
    elif kind == "EXT":
        rig.drive("home1", 0)
    rig.next(120)


# ------------------------------------------------------------------------------------------------ all kinds alike
@each_kind
@pytest.mark.fact("PMD-BRK-12", "PMD-BRK-16", "PMD-BRK-15")
def test_every_kind_sets_bit_2_which_stays(kind: str) -> None:
    rig = breakable(kind)
    rig.next(5)
    assert rig.look().status & FIRED == 0
    satisfy(rig, kind)
    assert rig.look().status & FIRED
    rig.drive("home1", 1)
    rig.begin("SET_POS 0")
    rig.next(50)
    assert rig.look().status & FIRED
    rig.do("RST_STATUS 0xFFFB")
    rig.next(200)
    assert rig.look().status & FIRED == 0


@each_kind
@pytest.mark.fact("PMD-BRK-15", "PMD-BRK-16", "PMD-CMD-SET_BRK_OFF-1", "PMD-UND-BRK-OFF-LIST", "PMD-CON-BRK-OFF-LIST")
def test_set_brk_off_disarms_every_kind(kind: str) -> None:
    rig = breakable(kind)
    rig.says("6d > 006d")
    satisfy(rig, kind)
    assert rig.look().status & FIRED == 0


@each_kind
@pytest.mark.fact("PMD-BRK-11")
def test_a_breakpoint_fires_once(kind: str) -> None:
    rig = breakable(kind)
    rig.do("SET_AUTO_UPDATE_OFF")
    satisfy(rig, kind)
    rig.do("RST_STATUS 0xFFFB")
    for _ in range(2):
        rig.drive("home1", 1)
        rig.begin("SET_POS 0")
        rig.next(20)
        rig.do(f"SET_BRK_PNT {rig.cycle + 50 if kind == 'TIME' else 5}")
        satisfy(rig, kind)
    assert rig.look().status & FIRED == 0


@each_kind
@pytest.mark.fact("PMD-BRK-14", "PMD-UND-BRK-OFF-AUTO", "PMD-CMD-SET_AUTO_UPDATE_OFF-1")
def test_with_auto_update_off_it_fires_once_too_and_brings_nothing(kind: str) -> None:
    rig = breakable(kind)
    rig.do("SET_AUTO_UPDATE_OFF")
    satisfy(rig, kind)
    assert rig.look().status & FIRED
    position = rig.look().pos
    rig.do(f"SET_POS {position + 20}", "SET_AUTO_UPDATE_ON", "RST_STATUS 0xFFFB")
    rig.next(200)
    assert rig.look().status & FIRED == 0 and rig.look().pos == position
    rig.begin()
    rig.rest()
    assert rig.x.position == position + 20


@each_kind
@pytest.mark.fact("PMD-BRK-22")
def test_a_breakpoint_interrupts_if_its_mask_bit_is_set(kind: str) -> None:
    rig = breakable(kind)
    rig.do("SET_INTRPT_MASK 4")
    satisfy(rig, kind)
    assert rig.level("hostintrpt") == 0
    other = breakable(kind)
    other.do("SET_INTRPT_MASK 0xFA")  # all but bit 2 and motion complete
    satisfy(other, kind)
    assert other.look().status & FIRED and other.level("hostintrpt") == 1


@each_kind
@pytest.mark.fact("PMD-UND-BRK-UPDATE")
def test_an_update_leaves_a_breakpoint_armed(kind: str) -> None:
    rig = breakable(kind)
    rig.do("SET_POS 1")
    rig.begin("RST_STATUS 0") if kind == "MTN_CMPLT" else rig.begin()
    rig.next(10)
    fired = kind == "MTN_CMPLT"  # that move completes itself
    assert bool(rig.look().status & FIRED) == fired
    satisfy(rig, kind)
    assert rig.look().status & FIRED


@pytest.mark.parametrize("last", KINDS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.fact("PMD-BRK-18", "PMD-UND-BRK-REPLACE")
def test_the_kind_armed_last_replaces_the_one_before(kind: str, last: str) -> None:
    if kind == last:
        return
    rig = breakable(kind)
    value = {"TIME": rig.cycle + 300, "NEG": -15, "ACTL_NEG": -15}.get(last, 15)
    rig.do(f"SET_BRK_PNT {value}", f"SET_{last}_BRK")
    if kind != "MTN_CMPLT" and last == "MTN_CMPLT" and kind in ("POS", "NEG"):
        return  # passing a position needs a move, which completes
    satisfy(rig, kind)
    fired = last == "MTN_CMPLT" and kind in ("POS", "NEG")
    assert bool(rig.look().status & FIRED) == fired
