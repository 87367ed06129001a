"""What `to=` wires: pins by their roles, on the axis that is asked for, all of them or nothing."""

from __future__ import annotations

from dataclasses import replace

import pytest

import slewline
from slewline.bench.wiring import met
from slewline.chips import PARTS, chip_class, sheet_of
from slewline.core.chip import step_nets
from slewline.core.datasheet.roles import AXIS_ROLES, ROLES
from slewline.core.datasheet.table import Pin
from slewline.errors import SheetError, SlewlineError, UnknownName, UsageError, WiringError
from slewline.parts.base.part import Part
from tests.rows import rows

LINE = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}


@pytest.fixture
def bench():
    return slewline.Bench()


def one(bench, first, second):
    return bench.pin(first).net.root is bench.pin(second).net.root


# --------------------------------------------------------------------------------------------------------- the sheets
@rows("part", PARTS)
def test_no_two_pins_of_an_axis_have_the_same_role_except_on_the_data_bus(part):
    sheet = sheet_of(part)
    roles = [(pin.role, pin.axis) for pin in sheet.pins if pin.role not in ("", "data")]
    assert len(set(roles)) == len(roles)
    for role, axis in roles:
        assert sheet.role(role, axis).axis == axis
    assert {pin.axis for pin in sheet.pins if pin.role in AXIS_ROLES} == set(range(1, sheet.axes + 1))
    for axis in range(1, sheet.axes + 1):
        assert sheet.role("step", axis)
        assert (sheet.role("direction", axis) is None) is (part == "cy500")  # phases alone show it


@rows("part", PARTS)
def test_every_register_describes_its_count(part):
    assert all(register.unit for register in sheet_of(part).registers)


def test_a_role_applies_to_the_active_level_unless_the_pin_is_named_for_the_other():
    assert [sheet_of(part).role("moving").sense for part in ("gs-c200", "mc1151a")] == [1, 0]  # MOV, ATREST
    assert [sheet_of(part).role("enable").sense for part in ("gs-c200", "cy525")] == [1, 0]  # ENABLE, STEP INHIBIT
    assert [sheet_of(part).role("step").sense for part in ("cy525", "gs-c200", "mc1151a")] == [0, 1, 0]


def test_an_unknown_role_is_refused():
    with pytest.raises(SheetError, match=r"pin x: no role 'stepp'; available: step, direction"):
        Pin(1, "x", "in", "", role="stepp")


# --------------------------------------------------------------------------------------------------------------- axes
def test_a_part_is_wired_to_the_selected_axis(bench):
    bench.add("mc1451a", name="x")
    bench.part("translator", name="m", to="x", axis=3)
    assert one(bench, "m.pulse", "x.pulse3")
    assert one(bench, "m.direction", "x.dir3")
    assert not one(bench, "m.pulse", "x.pulse1")


def test_an_axis_that_the_chip_lacks_is_refused(bench):
    x = bench.add("gs-c200", name="x")
    with pytest.raises(WiringError, match=r"m: a part of kind motor needs a pin that shows every step \(axis 2\); x"):
        bench.part("motor", name="m", to=x, axis=2)
    bench.part("motor", name="m", to=x)  # the name is free still


# ------------------------------------------------------------------------------------------------------------ refusals
def test_missing_pins_are_reported_with_the_reason_and_nothing_is_put_on_the_bench(bench):
    x = bench.add("cy525", name="x")
    drivers = {name: len(pin.net.drivers) for name, pin in x.pins.items()}
    with pytest.raises(
        WiringError, match=r"a part of kind damping needs a pin that shows that the motor is moving; x \(cy525\) has"
    ):
        bench.part("damping", to=x)
    assert bench.parts == {}
    assert {name: len(pin.net.drivers) for name, pin in x.pins.items()} == drivers
    assert {len(pin.net.root.joined) for pin in x.pins.values()} == {0}


def test_a_part_without_wiring_lists_its_pins(bench):
    x = bench.add("cy525", name="x")
    with pytest.raises(
        WiringError, match=r"inverter: a part of kind inverter has no standard wiring; connect in1, out"
    ):
        bench.part("inverter", to=x)


def test_a_line_of_other_levels_is_refused(bench):
    module = bench.add("gs-c200", name="x", straps=LINE)
    with pytest.raises(WiringError, match=r"pc\.txd: x\.rxd is active high, and txd is active low: use bench\.wire"):
        bench.part("serial_sender", name="pc", to=module)
    with pytest.raises(WiringError, match=r"pc\.txd: x\.rxd is active high"):
        bench.part("serial_port", name="pc", to=module, ttl=True)


def test_an_unknown_neighbour_is_refused(bench):
    with pytest.raises(UnknownName, match="the bench has no 'y'"):
        bench.part("motor", to="y")
    with pytest.raises(UnknownName, match="7 is not a chip or part of this bench"):
        bench.part("motor", to=7)
    assert bench.parts == {}


# ------------------------------------------------------------------------------------------------------ part to part
def test_a_driver_after_a_damping_circuit_takes_its_output(bench):
    x = bench.add("gs-c200", name="x", straps=LINE)
    damping = bench.part("damping", name="damping", to=x)
    bench.part("gs_d200", name="driver", to=damping)
    assert one(bench, "driver.clock", "damping.clock_out")
    assert one(bench, "driver.direction", "damping.dir_out")
    assert not one(bench, "driver.clock", "x.clock")


def test_a_pin_is_joined_to_drivers_before_receivers_and_no_output_to_an_output(bench):
    circuit = Part(bench.kernel, "circuit")
    for name, way in (("into", "in"), ("out", "out")):
        circuit.add_pin(name, way, "", role="step")
    listener, driver = (
        Part(bench.kernel, "own").add_pin("a", "in", ""),
        Part(bench.kernel, "own").add_pin("a", "out", ""),
    )
    assert met(listener, "step", 1, circuit) is circuit.pin("out")
    assert met(driver, "step", 1, circuit) is circuit.pin("into")
    del circuit.pins["into"]
    assert met(driver, "step", 1, circuit) is None
    circuit.pins = {"into": circuit.add_pin("into", "in", "", role="step")}
    assert met(listener, "step", 1, circuit) is circuit.pin("into")  # they share a wire


def test_a_rotor_hangs_on_the_coils_of_a_latch(bench):
    x = bench.add("cy525", name="x")
    latch = bench.part("phase_latch", name="latch", to=x)
    bench.part("rotor", to=latch)
    assert all(one(bench, f"rotor.phase{n}", f"latch.coil{n}") for n in (1, 2, 3, 4))


def test_a_connector_finds_the_receiver_of_a_uart_that_never_answers(bench):
    x = bench.add("cy525", name="x")
    bench.part("uart", name="uart", to=x)
    bench.part("serial_port", name="pc", to="uart", ttl=True)
    assert one(bench, "pc.txd", "uart.rxd")
    assert bench.pin("pc.rxd").net.root.joined == ()


# ------------------------------------------------------------------------------------------------------- step edges
@pytest.mark.parametrize(("chip", "rises"), [("cy525", 0), ("gs-c200s", 1), ("mc1151a", 0)])
def test_a_motor_steps_with_the_edge_that_the_sheet_means(bench, chip, rises):
    bench.add(chip, name="x")
    for kind in ("translator", "motor"):
        assert bench.part(kind, to="x").rule.edge == rises


def test_a_journal_repeats_what_was_wired_with_its_edge(tmp_path):
    path = tmp_path / "journal"
    bench = slewline.Bench(journal=path)
    x = bench.add("gs-c200s", name="x", straps=LINE)
    bench.part("translator", name="m", to=x)
    host = bench.host(x)
    for line in ("Po", "S10", "T100", "R10", "+12", "E"):
        assert host.ask(line) == "Y"
    bench.run_until_idle()
    bench.journal.close()
    again = slewline.replay(path)
    assert again["m"].position == bench["m"].position == 12
    assert again["m"].rule.edge == 1
    assert one(again, "m.pulse", "x.clock")


# ---------------------------------------------------------------------------------------------------- who goes by roles
@pytest.mark.parametrize(("chip", "pin", "lets"), [("cy525", "step_inhibit", 0), ("gs-c200", "enable", 1)])
def test_a_step_check_inhibits_each_chip_by_its_own_pin(bench, chip, pin, lets):
    x = bench.add(chip, name="x")
    check = bench.part("step_check", to=x)
    assert x.pin(pin).level == lets
    bench.run(0)
    check.pin("x").drive(1)  # the load has turned the motor, and a step is owed
    assert (check.behind, x.pin(pin).level) == (-1, 1 - lets)
    check.pin("x").drive(0)
    assert (check.behind, x.pin(pin).level) == (0, lets)


def test_clocks_are_recorded_only_when_they_are_named(bench):
    for chip in ("cy525", "mc1151a"):
        bench.add(chip, name=chip)
    bench.record()
    assert not {"cy525.clk15", "mc1151a.clkout"} & set(bench.recorded)
    assert {"cy525.pulse", "mc1151a.pulse1"} <= set(bench.recorded)


@pytest.mark.parametrize("part", PARTS)
def test_the_nets_of_steps_are_those_of_every_axis(bench, part):
    x = bench.add(part, name="x")
    assert step_nets(x) == [x.pin(x.sheet.role("step", n).name).net for n in range(1, x.sheet.axes + 1)]


def test_every_role_of_a_part_is_one_of_the_house(bench):
    for kind in ("uart", "gpib_talker", "rs232_line", "damping", "phase_latch"):
        assert {pin.row.role for pin in bench.part(kind).pins.values()} <= {"", *ROLES}


def test_a_neighbour_of_another_bench_is_refused_even_with_a_name_that_this_one_has(bench):
    other = slewline.Bench()
    for each in (bench, other):
        each.add("cy525", name="x")
        each.part("motor", to="x")
    with pytest.raises(UnknownName, match="'x' is not a chip or part of this bench"):
        bench.part("encoder", to=other["x"])
    with pytest.raises(UnknownName, match="'motor' is not a chip or part of this bench"):
        bench.part("encoder", on=other["motor"])
    with pytest.raises(UsageError, match="host: 'x'; expected chips of this bench"):
        bench.host(other["x"])
    assert [*bench.parts] == ["motor"]


@pytest.mark.parametrize("name", [[], {}, 5])
def test_a_kind_and_a_name_are_text(bench, name):
    with pytest.raises(UnknownName, match=r"no part .*; available: inverter"):
        bench.part(name)
    for put in (bench.part, bench.add):
        with pytest.raises(UsageError, match=r"name .*: allowed letters, digits and underscores"):
            put("motor" if put == bench.part else "cy525", name)


def test_a_part_without_pins_is_wired_to_nothing(bench):
    bench.part("motor")
    with pytest.raises(WiringError, match="carriage has no standard wiring; it has no pins; leave out to="):
        bench.part("carriage", on="motor", to="motor")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"baud": "fast"}, "baud 'fast'"),
        ({"baud": 0}, "baud 0"),
        ({"line": "motor"}, "motor: a part of kind rs232_line needs a pin"),
    ],
)
def test_a_serial_host_that_is_refused_is_not_on_the_bench(tmp_path, options, says):
    bench = slewline.Bench(journal=tmp_path / "run.jsonl")
    x = bench.add("gs-c200", name="x", straps=LINE)
    bench.part("motor")
    options = {key: bench["motor"] if value == "motor" else value for key, value in options.items()}
    with pytest.raises(SlewlineError, match=says):
        bench.host(x, **options)
    assert bench.host(x).name == "host"
    assert [*slewline.replay(tmp_path / "run.jsonl").parts] == ["motor", "host"]


def test_a_bus_host_that_is_refused_leaves_the_buses_apart(bench):
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    with pytest.raises(SlewlineError, match="time 'long'"):
        bench.host(x, y, delay="long")
    assert x.bus.root is not y.bus.root


def test_a_custom_chip_on_a_serial_line_needs_pins_with_the_serial_roles(bench):
    class Deaf(chip_class("gs-c200")):
        sheet = replace(
            sheet_of("gs-c200"),
            pins=tuple(replace(pin, role="") if pin.name == "rxd" else pin for pin in sheet_of("gs-c200").pins),
        )

    x = bench.add(Deaf, name="x")
    with pytest.raises(WiringError, match="has no pin that receives characters from a computer"):
        bench.host(x)
    assert bench.parts == {}
