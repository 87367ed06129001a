"""The welding machine of section 4: chip, workpieces, carriage and torch."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline

SET_UP = "C\rA 0\rF 3\rR 80\rS 200\rZ 1\r"
WELD = "E\rB$W\r+\rN 100\rC$B\rD 500\rC\rG\rL 6,C\rP 0\rT B\r0\rQX\r"
US, MS = 10**6, 10**9


def machine(circuit, *recorded, pieces=3, **options):
    c = circuit(*recorded, **options)
    c.pieces = c.part("workpieces", to="x", pieces=pieces)
    c.welder = c.part("welder", to="x")
    c.bench.host(c.x).send(SET_UP + WELD)
    return c


@pytest.mark.fact("EXAMPLE-WELD-1", "DER-WELD")
def test_every_workpiece_gets_six_spots_of_equal_pitch_and_the_carriage_returns(circuit):
    c = machine(circuit, "x.pulse", "x.programmable_output", "x.wait")
    c.finish()
    assert c.x.program[:2] == b"W+"
    assert len(c.x.program) == 20
    assert [spot.position for spot in c.welder.spots[-18:]] == [0, 100, 200, 300, 400, 500] * 3
    assert c.x.position == 0
    assert {spot.duration_ps for spot in c.welder.spots[-18:]} == {500 * MS + 2 * 40 * US}  # D itself, and C
    for spot in c.welder.spots[-18:]:
        end = spot.start_ps + spot.duration_ps
        assert c.edges("x.pulse", spot.start_ps, end) == []
    assert c.bench.findings == []


@pytest.mark.fact("EXAMPLE-WELD-2")
def test_the_machine_waits_for_each_workpiece_and_stops_after_the_last(circuit):
    c = machine(circuit, "x.run", "x.wait", "x.dowhile", "x.programmable_output", "x.motion_complete")
    c.finish()
    assert c.pieces.finished == 3
    assert len(c.welder.spots) == 19  # the torch is on from reset to the first C
    assert [level for _, level in c.edges("x.run")] == [0, 1]
    ended = c.rises("x.run")[0]
    assert c.x.position_at(ended) == 0
    arrivals = c.rises("x.wait")
    assert len(arrivals) == 3
    starts = [t for t in c.rises("x.programmable_output") if t > arrivals[0]][::6]
    for arrival, start in zip(arrivals, starts, strict=True):
        assert 0 < start - arrival < MS  # W looks every 8 us; two instructions and B
    assert c.edges("x.dowhile") == [(arrivals[2], 1)]  # low until the last one lies there
    returns = [t for t in c.falls("x.motion_complete") if c.x.position_at(t) == 0]
    assert ended - returns[-1] < MS  # T and 0


@pytest.mark.fact("EXAMPLE-WELD-2")
@pytest.mark.parametrize("pieces", [1, 2])
def test_a_shorter_row_of_workpieces_ends_earlier(circuit, pieces):
    c = machine(circuit, "x.run", pieces=pieces)
    c.finish()
    assert c.pieces.finished == pieces
    assert len(c.welder.spots) == 1 + 6 * pieces
    assert len(c.rises("x.run")) == 1


@pytest.mark.fact("EXAMPLE-WELD-2", "DER-WELD")
def test_without_workpieces_the_machine_waits_for_ever(circuit):
    c = machine(circuit, pieces=0)
    with pytest.raises(slewline.Timeout, match=r"waiting for wait=1 \(W\)"):
        c.finish("10 s")
    assert len(c.welder.spots) == 1


@pytest.mark.fact("DER-WELD")
def test_without_the_plus_the_second_workpiece_would_be_welded_backwards(circuit):
    c = circuit()
    c.part("workpieces", to="x", pieces=2)
    welder = c.part("welder", to="x")
    c.bench.host(c.x).send(SET_UP + WELD.replace("+\r", ""))
    c.finish()
    assert [spot.position for spot in welder.spots[7:]] == [0, -100, -200, -300, -400, -500]


def test_a_weld_is_smeared_when_the_carriage_moves_with_the_torch_on(circuit):
    c = circuit(rate=3, firstrate=3, slope=255, divisor=1)
    welder = c.part("welder", to="x")
    c.bench.host(c.x).send("N 2\rG\rC\r")
    c.finish()
    assert c.codes("welder") == ["smeared", "smeared"]
    (spot,) = welder.spots
    assert spot.position == 0
    assert str(spot).split()[:2] == ["0", "from"]


def test_the_spots_of_the_slow_twin_are_the_same(circuit):
    runs = []
    for stepwise, shuffle in ((False, None), (True, None), (False, 4)):
        c = machine(circuit, pieces=2, stepwise=stepwise, shuffle=shuffle)
        c.finish()
        runs.append(c.welder.spots)
    assert runs[0] == runs[1] == runs[2]
    starts = [spot.start_ps for spot in runs[0][1:7]]
    assert len({after - before for before, after in pairwise(starts)}) == 1


def test_only_welds_on_a_present_workpiece_count():
    bench = slewline.Bench()
    pieces = bench.part("workpieces", pieces=2, welds=3, change="10 ms")
    torch = bench.pin("workpieces.torch")
    torch.drive(0)

    def weld(number: int) -> None:
        for _ in range(number):
            torch.drive(1)
            torch.drive(0)

    bench.run("1 ms")
    weld(4)
    assert pieces.finished == 0
    bench.run("9 ms")
    weld(3)
    assert (pieces.finished, bench.pin("workpieces.in_place").level) == (1, 0)
    weld(7)
    bench.run("9 ms")
    assert (pieces.finished, bench.pin("workpieces.in_place").level) == (1, 0)
    bench.run("1 ms")
    weld(2)
    assert (pieces.finished, bench.pin("workpieces.in_place").level) == (1, 1)
    weld(1)
    assert pieces.finished == 2
    weld(5)
    bench.run("1 s")
    assert (pieces.finished, bench.pin("workpieces.last").level) == (2, 1)
