"""pyvcd reads what we write: wires, whole buses, reals and strings of every family."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from vcd.reader import VarType

from .waveform import read

FAMILIES = ["cy525", "gsc", "mc1451a"]


@pytest.mark.parametrize("family", FAMILIES)
def test_every_wire_has_the_recorded_edges(family, tmp_path, request):
    bench = request.getfixturevalue(family)
    bench.save_vcd(tmp_path / "a.vcd", timescale="1 ps")
    variables, changes = read(tmp_path / "a.vcd")
    assert set(variables.values()) == {(VarType.wire, 1)}
    assert len(variables) > 25
    for name, seen in changes.items():
        times, levels = bench.edges(name, start=1)
        assert seen[1:] == [(at, "z01"[level + 1]) for at, level in zip(times.tolist(), levels.tolist(), strict=True)]


@pytest.mark.parametrize("bus", ["cy525 x.db", "mc1451a x.hostdata"])
def test_a_bus_as_a_whole_is_what_its_wires_say(bus, tmp_path, request):
    family, bus = bus.split()
    request.getfixturevalue(family).save_vcd(tmp_path / "a.vcd", timescale="1 ps", buses="both")
    variables, changes = read(tmp_path / "a.vcd")
    assert variables[bus] == (VarType.wire, 8)
    assert len(changes[bus]) > 30
    for bit in range(8):
        levels = [(at, "z" if value == "z" else str(value >> bit & 1)) for at, value in changes[bus]]
        again = [True, *(before[1] != after[1] for before, after in pairwise(levels))]
        assert changes[f"{bus}{bit}"] == [level for level, changed in zip(levels, again, strict=True) if changed]


@pytest.mark.parametrize("family", FAMILIES)
def test_values_are_those_of_the_axes_at_these_instants(family, tmp_path, request):
    bench = request.getfixturevalue(family)
    bench.save_vcd(tmp_path / "a.vcd", timescale="1 ps", values=True)
    variables, changes = read(tmp_path / "a.vcd")
    for number in (1, 2) if family == "mc1451a" else (1,):
        axis = bench["x"].axis(number)
        scope = f"x.axis{number}" if family == "mc1451a" else "x"
        for quantity in axis.quantities():
            name = f"{scope}.{quantity.name}"
            assert variables[name] == (VarType.real, 64)
            times, values = np.array([at for at, _ in changes[name]]), [value for _, value in changes[name]]
            assert len(values) > (100 if quantity.name in ("velocity", "position") else 0)
            np.testing.assert_array_equal(values, quantity.at(times))
        assert variables[f"{scope}.motion"][0] is VarType.string
        told = [(at, text.replace("\\x20", " ")) for at, text in changes[f"{scope}.motion"][1:] if text]
        assert told == [(motion.time_ps, motion.text) for motion in axis.motions(1, bench.now_ps)] != []
    assert len({text for _, text in changes["x.command"]}) > 3
