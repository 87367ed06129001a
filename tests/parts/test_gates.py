"""Gates and latches, and how parts get onto a bench."""

from __future__ import annotations

from itertools import product

import pytest

import slewline
from slewline.parts import KINDS, part_class
from tests.rows import rows

TRUTH = {  # output for (0, 0), (0, 1), (1, 0), (1, 1)
    "and": (0, 0, 0, 1),
    "or": (0, 1, 1, 1),
    "nand": (1, 1, 1, 0),
    "nor": (1, 0, 0, 0),
}


@rows("kind", TRUTH)
def test_a_gate_of_two_inputs_keeps_its_truth_table(kind):
    bench = slewline.Bench()
    bench.part(kind, "g")
    bench.run(0)
    outputs = []
    for one, two in product((0, 1), (0, 1)):
        bench.pin("g.in1").drive(one)
        bench.pin("g.in2").drive(two)
        outputs.append(bench.pin("g.out").level)
    assert tuple(outputs) == TRUTH[kind]


def test_an_open_input_of_a_gate_reads_high():
    bench = slewline.Bench()
    bench.part("and", "g", inputs=3)
    bench.part("nor", "n", inputs=3)
    bench.run(0)
    assert (bench.pin("g.out").level, bench.pin("n.out").level) == (1, 0)
    bench.pin("g.in3").drive(0)
    assert bench.pin("g.out").level == 0
    bench.pin("g.in3").release()
    assert bench.pin("g.out").level == 1


def test_gates_follow_each_other_in_the_same_instant():
    bench = slewline.Bench()
    for name in ("one", "two", "three"):
        bench.part("inverter", name)
    bench.wire("one.out", "two.in1")
    bench.wire("two.out", "three.in1")
    bench.run(0)
    assert bench.pin("three.out").level == 0
    bench.pin("one.in1").drive(0)
    assert bench.pin("three.out").level == 1
    assert bench.now_ps == 0


def test_two_crossed_nor_gates_remember():
    bench = slewline.Bench()
    for name in ("q", "nq"):
        bench.part("nor", name)
    bench.wire("q.out", "nq.in1")
    bench.wire("nq.out", "q.in1")
    reset, set_ = bench.pin("q.in2"), bench.pin("nq.in2")
    set_.drive(0)
    reset.drive(1)
    bench.run(0)
    reset.drive(0)
    assert bench.pin("q.out").level == 0
    set_.drive(1)
    set_.drive(0)
    assert bench.pin("q.out").level == 1
    reset.drive(1)
    reset.drive(0)
    assert bench.pin("q.out").level == 0


def test_a_latch_is_transparent_while_enabled_and_floats_while_its_output_is_off():
    bench = slewline.Bench()
    bench.part("prom", "source", image=bytes([0x12, 0x34]), stop="address")
    latch = bench.part("latch8", "latch")
    bench.wire("source.db", "latch.d")
    bench.pin("latch.output_enable").drive(1)
    bench.pin("latch.enable").drive(1)
    bench.pin("source.ready").drive(1)
    bench.run(0)
    assert bench.pin("latch.q").net.level is None
    bench.pin("latch.output_enable").drive(0)
    assert latch.byte("q") == 0x12
    bench.pin("source.ready").drive(0)  # the next byte
    assert latch.byte("q") == 0x34
    bench.pin("latch.enable").drive(0)
    bench.pin("source.ready").drive(1)
    bench.pin("source.ready").drive(0)
    assert latch.byte("d") == 0xFF
    assert latch.byte("q") == 0x34


# --------------------------------------------------------------------------------------------------------- the bench
def test_every_kind_of_part_can_be_placed_and_has_pins_that_its_standard_wiring_names():
    for kind in KINDS:
        bench = slewline.Bench()
        on = bench.part("motor", "turning") if part_class(kind).sits == "must" else None
        part = bench.part(kind, on=on, **{"prom": {"image": ""}, "switch": {"low": 0}}.get(kind, {}))
        assert part.name == kind
        assert isinstance(part, part_class(kind))
        assert set(part.wiring) <= set(part.pins)
        bench.run("1 ms")
        assert part.waiting.startswith(kind)


def test_the_standard_wiring_joins_the_pins_of_the_part_to_the_chip():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    latch = bench.part("position_latch", to=x)
    assert latch.pin("outstrobe").net.root is x.pin("outstrobe").net.root
    assert latch.pin("db").net.root is x.bus.root
    assert bench.part("rotor", to="x").pin("phase3").net.root is x.pin("phase3").net.root


def test_unknown_kinds_and_options_are_refused_with_what_there_is():
    bench = slewline.Bench()
    with pytest.raises(slewline.SlewlineError, match=r"no part 'modem'; available: inverter, and"):
        bench.part("modem")
    with pytest.raises(slewline.UsageError, match=r"uart: no option 'speed'; its options: baud, bits"):
        bench.part("uart", speed=9600)
    with pytest.raises(slewline.UsageError, match=r"no option 'inputs'; its options: none"):
        bench.part("inverter", inputs=2)
    with pytest.raises(slewline.UsageError, match=r"g: inputs 9; allowed 1\.\.8"):
        bench.part("and", "g", inputs=9)
    assert bench.parts == {}


def test_a_whole_bus_cannot_be_driven_to_one_level():
    bench = slewline.Bench()
    bench.part("keyboard")
    with pytest.raises(slewline.WiringError, match=r"keyboard\.db is a bus of eight wires"):
        bench.pin("keyboard.db").drive(1)


def test_a_bench_file_places_parts_and_wires_them(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text(
        """
        [[chip]]
        part = "cy525"
        name = "x"
        [[part]]
        kind = "prom"
        to = "x"
        image = "A 0\\rN 5\\rF 10\\rR 10\\rS 255\\rZ 1\\rG\\r"
        [[part]]
        kind = "translator"
        name = "motor"
        [[wire]]
        from = "x.pulse"
        to = "motor.pulse"
        [[wire]]
        from = "x.direction"
        to = "motor.direction"
        """
    )
    bench = slewline.load(path)
    bench.run_until_idle()
    assert bench["motor"].position == bench["x"].position == 5
    assert bench.findings == []


def test_parts_of_one_kind_are_numbered():
    bench = slewline.Bench()
    assert [bench.part("inverter").name for _ in range(3)] == ["inverter", "inverter_2", "inverter_3"]


def test_a_journal_repeats_a_bench_with_parts(tmp_path):
    path = tmp_path / "journal"
    bench = slewline.Bench(journal=path)
    x = bench.add("cy525", name="x", position=0)
    bench.part("uart", to=x, baud=4800, parity="even")
    pc = bench.part("serial_sender", "pc", to="uart", baud=4800, parity="even")
    bench.part("translator", to=x)
    bench.part("prom", "unused", image=bytes([0xFF, 1]))
    pc.send(b"R 30\rN 7\r")
    bench.run("20 ms")
    pc.pause("3 ms")
    pc.send("G\rQ\r")
    bench.run_until_idle()
    bench.journal.close()
    again = slewline.replay(path)
    assert again.now_ps == bench.now_ps
    assert again["translator"].position == 7
    assert again["unused"].image == bench["unused"].image
    assert again.findings == bench.findings
    assert again["x"].steps().times_ps.tolist() == x.steps().times_ps.tolist()
