"""Times between edges, printed limits, and characters read from a recording."""

from __future__ import annotations

import numpy as np
import pytest

from slewline.core.datasheet.table import Limit
from slewline.core.wires.characters import frames_of, transmit
from slewline.core.wires.serial import RS232, TTL, CharacterFormat, bit_clock
from slewline.errors import UsageError
from slewline.record.measuring.intervals import (
    Bound,
    Checked,
    Edge,
    Interval,
    SignalEdges,
    TimingTable,
    intervals,
    pairs,
)
from slewline.record.measuring.sampled_characters import characters, shown
from tests.rows import rows

NS, US = 1000, 1_000_000


def signal(*edges: tuple[int, int], level: int = 1, bus: bool = False) -> SignalEdges:
    times, levels = [at for at, _ in edges], [to for _, to in edges]
    return SignalEdges(np.array(times, np.int64), np.array(levels, np.int16 if bus else np.int8), level, bus)


def found(starts, ends, strict=False) -> list[tuple[int, int]]:
    begins, stops = pairs(np.array(starts, np.int64), np.array(ends, np.int64), strict)
    return list(zip(begins.tolist(), stops.tolist(), strict=True))


# ----------------------------------------------------------------------------------------------------------- intervals
def test_an_interval_goes_from_the_last_start_to_the_first_end():
    assert found([10, 20, 50], [5, 30, 40, 60, 70]) == [(20, 30), (50, 60)]
    assert found([], [5]) == found([5], []) == found([7], [5]) == []


def test_a_start_and_an_end_at_one_instant():
    assert found([10, 30], [30, 40]) == [(30, 30)]  # the end at 30 has taken it
    assert found([10, 30], [30, 40], strict=True) == [(10, 30), (30, 40)]


def test_an_edge_to_the_next_one_of_its_kind():
    assert found([10, 12, 17], [10, 12, 17], strict=True) == [(10, 12), (12, 17)]


def test_every_change_of_a_pin_and_of_a_bus_is_found():
    pin = signal((10, 0), (20, -1), (30, 1), (40, 0), (50, 1))
    assert {change: pin.edges(change).tolist() for change in ("falls", "rises", "appears", "vanishes")} == {
        "falls": [10, 40],
        "rises": [30, 50],
        "appears": [30],
        "vanishes": [20],
    }
    bus = signal((10, 65), (20, 0), (30, -1), (40, 1), level=-1, bus=True)
    assert bus.edges("appears").tolist() == [10, 40]
    assert bus.edges("vanishes").tolist() == [30]
    assert bus.edges("changes").tolist() == [10, 20, 30, 40]
    assert bus.levels_at([9, 10, 35]).tolist() == [-1, 65, -1]


def test_the_requested_edge():
    pin = signal((10, 0), (20, 1), (30, 0), (40, 1))
    assert Edge.read("x.a falls 2") == ("x.a", "falls", 2)
    assert Edge.read("x.a") == ("x.a", "changes", 1)
    assert Edge.read("x.a falls").find(pin, 10, include=True) == 10
    assert Edge.read("x.a falls").find(pin, 10, include=False) == 30
    assert Edge.read("x.a rises 2").find(pin, 10, include=True) == 40
    assert Edge.read("x.a rises 3").find(pin, 10, include=True) is None


@rows("text", ["", "x.a falling", "x.a falls 0", "x.a falls two", "x.a falls 1 2", 7])
def test_an_invalid_edge_is_refused(text):
    with pytest.raises(UsageError, match="expected a pin, a change"):
        Edge.read(text)


def test_a_bus_does_not_fall():
    with pytest.raises(UsageError, match="is a bus; allowed 'changes', 'appears', 'vanishes'"):
        Edge.read("x.db falls").find(signal((1, 0), bus=True), 0, include=True)


# -------------------------------------------------------------------------------------------------------------- limits
def test_a_limit_counts_only_at_the_levels_that_it_names():
    limit = Limit("a falls", "b falls", "", "", least=1, given=(("c", 0),))
    pins = {"a": signal((10, 0), (20, 1), (50, 0)), "b": signal((12, 0), (30, 1), (55, 0)), "c": signal((55, 0))}
    begins, ends = intervals(limit, pins.__getitem__)
    assert (begins.tolist(), ends.tolist()) == ([50], [55])


def test_a_limit_counts_only_from_the_levels_before_that_it_names():
    limit = Limit("a rises", "b rises", "", "", least=1, before=(("b", 0),))
    pins = {"a": signal((10, 1), (12, 0), (40, 1), level=0), "b": signal((20, 0), (40, 1), (50, 0), (60, 1))}
    begins, ends = intervals(limit, pins.__getitem__)
    assert (begins.tolist(), ends.tolist()) == ([40], [40])  # b was low when a rose


def test_a_required_predecessor_that_comes_later_is_a_violation():
    limit = Limit("a falls", "b falls", "", "", most=-10, given=(("a", 0),))
    pins = {"a": signal((10, 0), (20, 1), (40, 0), (50, 1)), "b": signal((10, 0), (30, 1), (43, 0))}
    begins, ends = intervals(limit, pins.__getitem__)
    assert (begins.tolist(), ends.tolist()) == ([40], [43])  # at one instant, the set-up time of b says so
    assert Checked.of("x", Bound.of(limit, 1), begins, ends).violations == (40,)
    assert str(Bound.of(Limit("a falls", "b falls", "", "", most=-10 * NS), 1)) == "max. −10 ns"


def test_where_only_what_is_typical_is_printed_an_answer_belongs_to_what_began_before():
    pins = {"request": signal((10, 0), (20, 1), (60, 0)), "ready": signal((30, 0), (60, 1))}
    of = {"start": "request falls", "end": "ready rises", "says": "", "where": ""}
    assert [times.tolist() for times in intervals(Limit(**of, typical=1), pins.__getitem__)] == [[10], [60]]
    assert [times.tolist() for times in intervals(Limit(**of, most=1), pins.__getitem__)] == [[60], [60]]


def test_a_limit_scales_with_the_crystal_that_it_names():
    scaled = Limit("a falls", "a rises", "", "", least=10, typical=10, most=10, mhz=6)
    assert scaled.at(6_000_000) == (10, 10, 10)
    assert scaled.at(11_000_000) == (5, 5, 6)  # 5.45, in favour of who keeps it
    assert Limit("a falls", "a rises", "", "", least=10).at(11_000_000) == (10, None, None)


@rows(("shortest", "longest", "kept"), [(50, 100, True), (49, 100, False), (50, 101, False), (75, 75, True)])
def test_the_ends_of_a_limit_belong_to_it(shortest, longest, kept):
    limit = Limit("a falls", "a rises", "", "", least=50, most=100)
    assert Bound.of(limit, 1).kept(shortest, longest) is kept


def test_an_interval_is_printed_with_its_limits():
    limit = Limit("a falls", "b rises", "width", "", least=50 * NS, most=2 * US, symbol="t6")
    bound, typical = Bound.of(limit, 1), Bound.of(Limit("a falls", "b rises", "", "", typical=US), 1)
    assert str(Interval("x.a falls", "x.b rises", 0, 80 * NS, (bound,))) == "t6 = 80 ns (min. 50 ns, max. 2 µs: met)"
    assert str(Interval("", "", 5, 5 + 49 * NS, (bound,))) == "t6 = 49 ns (min. 50 ns, max. 2 µs: VIOLATED)"
    assert str(Interval("", "", 0, 7, (typical,))) == "t = 7 ps (typ. 1 µs)"
    assert Interval("", "", 0, 7, (typical,)).kept is None
    assert Interval("", "", 0, 7, (typical, bound)).kept is False
    assert str(Interval("", "", 0, 7)) == "t = 7 ps"


def test_a_table_of_limits():
    limit = Limit("a falls", "a rises", "a low", "", least=50 * NS, symbol="t14", keeper="host")
    bound = Bound.of(limit, 1)
    begins = np.array([0, US, 2 * US], np.int64)
    row = Checked.of("x", bound, begins, begins + np.array([50, 49, 48]) * NS)
    assert (row.count, row.shortest_ps, row.longest_ps, row.kept) == (3, 48 * NS, 50 * NS, False)
    assert row.violations == (US, 2 * US)
    none = Checked.of("x", bound, begins[:0], begins[:0])
    table = TimingTable([row, none, Checked("x", bound, missing="a")])
    assert table.violated == (row,)
    assert [each.kept for each in table] == [False, None, None]
    assert str(table).splitlines() == [
        "       time   data sheet  count  shortest  longest",
        "x t14  a low  min. 50 ns      3     48 ns    50 ns  VIOLATED 2 times, first at 1 µs, by the host",
        "not seen: x t14 a low",
        "a not recorded: x t14 a low",
    ]


def test_an_excessive_duration_is_a_violation_as_well():
    bound = Bound.of(Limit("a falls", "a rises", "", "", most=50), 1)
    begins = np.array([0, 100], np.int64)
    assert Checked.of("x", bound, begins, np.array([50, 151])).violations == (100,)


# ---------------------------------------------------------------------------------------------------------- characters
@pytest.mark.parametrize("mark", [TTL, RS232])
@pytest.mark.parametrize(
    "word", [CharacterFormat(7, "odd", 2), CharacterFormat(8, "none", 1), CharacterFormat(5, "even", "1.5")], ids=str
)
def test_characters_on_a_line_are_read_as_they_were_sent(rig, word, mark):
    line = rig.net("x.line")
    driver = rig.drivers["x.line"]
    driver.drive(mark)
    rig.recorder.record(line)
    clock, sent = bit_clock(9600, "x"), bytes(range(0, 1 << word.bits, 3))
    rig.kernel.run(50 * US)
    rig.kernel.spawn(transmit, driver, frames_of(clock.hz, word, mark), sent, name="host")
    rig.kernel.run(10**12)
    read = characters(SignalEdges.of(line, rig.recorder, 0, 10**12), 10**12, clock, word, mark)
    assert bytes(character.byte for character in read) == sent
    assert all(character.good for character in read)
    assert [read[0].start_ps, read[-1].end_ps] == [50 * US, 50 * US + len(sent) * clock.ps(word.ticks)]


def test_a_character_that_is_not_over_is_left_out(rig):
    line, word = rig.net("x.line"), CharacterFormat(7, "odd", 2)
    driver, clock = rig.drivers["x.line"], bit_clock(9600, "x")
    driver.drive(RS232)
    rig.recorder.record(line)
    rig.kernel.run(1)
    rig.kernel.spawn(transmit, driver, frames_of(clock.hz, word, RS232), b"AB", name="host")
    rig.kernel.run(10**12)
    length = clock.ps(word.ticks)
    middle = 1 + length + clock.ps(8 + 16 * 9)  # of the first stop bit of the second character
    for stop, expected in ((middle - 1, "A"), (middle, "AB")):
        read = characters(SignalEdges.of(line, rig.recorder, 0, stop), stop, clock, word, RS232)
        assert "".join(shown(character.byte) for character in read) == expected
        assert all(character.good for character in read)


@pytest.mark.parametrize("fault", ["parity", "framing"])
def test_a_faulty_character_is_reported(rig, fault):
    line, word = rig.net("x.line"), CharacterFormat(7, "odd", 2)
    driver = rig.drivers["x.line"]
    driver.drive(RS232)
    rig.recorder.record(line)
    clock = bit_clock(9600, "x")
    rig.kernel.run(1)
    rig.kernel.spawn(transmit, driver, frames_of(clock.hz, word, RS232), b"A", fault, name="host")
    rig.kernel.run(10**11)
    rig.on(2 * 10**11, x_line=1)
    rig.on(2 * 10**11 + 20 * US, x_line=0)  # a spike, no start bit
    (read,) = characters(SignalEdges.of(line, rig.recorder, 0, 3 * 10**11), 3 * 10**11, clock, word, RS232)
    assert (read.byte, read.parity_wrong, read.framing_wrong) == (65, fault == "parity", fault == "framing")


def test_a_byte_in_the_displayed_form():
    assert [shown(byte) for byte in (65, 13, 32, 0, 200)] == ["A", "CR", "SP", "00", "C8"]
