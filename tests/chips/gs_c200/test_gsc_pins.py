"""The 38 pins: what they are, how they rest, and when each of them moves."""

from __future__ import annotations

import pytest
from gsc import C200, C200S, MS, SETUP, STR, US, WIDTH, Rig, base, both

import slewline
from slewline import UsageError
from slewline.chips import chip_class
from slewline.chips.gs_c200 import sheet
from slewline.errors import WiringError

RESET_WIDTH = 400 * US
# fmt: off
NAMES = (
    "sel0", "sel1", "sel2", "br0", "br1", "br2", "chs", "gnd8", "rec", "test", "rxd", "txd", "txpd", "rdy", "vsl_minus",
    "vsl_plus", "vs17", "vs18", "gnd19", "v5_20", "v5_21", "mov", "ramp", "enable", "nc25", "dir", "reset", "clock",
    "nc29", "home", "uo1", "eot", "uo2", "ui1", "uo3", "ui2", "ui3", "gnd38",
)
# fmt: on
OUTPUTS = {"txd", "rdy", "mov", "ramp", "dir", "reset", "clock", "uo1", "uo2", "uo3"}
NO_SIGNAL = {"gnd8", "vsl_minus", "vsl_plus", "vs17", "vs18", "gnd19", "v5_20", "v5_21", "nc25", "nc29", "gnd38"}


# ------------------------------------------------------------------------------------------------------ the sheet
@both
@pytest.mark.fact("GSC-PIN-1", "GSC-CON-PIN37")
def test_the_module_has_38_pins_in_this_order(part: str) -> None:
    rows = chip_class(part).sheet.pins
    assert [(row.number, row.name) for row in rows] == list(enumerate(NAMES, 1))
    assert {row.name for row in rows if row.in_out == "out"} == OUTPUTS
    assert {row.name for row in rows if row.in_out in ("power", "none")} == NO_SIGNAL
    assert {row.name for row in rows if row.in_out == "in"} == set(NAMES) - OUTPUTS - NO_SIGNAL
    with pytest.raises(WiringError, match=r"x\.nc25 \(pin 25: not connected\)"):
        base(part).bench.wire("x.nc25", "x.ui1")
    ui = {row.name: row for row in rows if row.name.startswith("ui")}
    assert ui["ui3"].seen == ui["ui1"].seen and ui["ui3"].pull == ui["ui1"].pull


@both
@pytest.mark.fact("GSC-PIN-1")
def test_an_open_pin_is_reported_and_changes_nothing_else(part: str) -> None:
    rig = base(part, test=1)
    assert rig.ask("F") == "R"
    assert rig.codes == ["test-pin"]
    assert base(part).ask("F") == "R"
    rig.run(*STR, "+5")
    assert rig.pos() == 5


@both
@pytest.mark.fact("GSC-PIN-2", "GSC-PIN-SUPPLY-1", "GSC-PIN-ENV-1", "GSC-UND-SUPPLY")
def test_the_sheet_lists_volts_amperes_and_limits(part: str) -> None:
    notes = chip_class(part).sheet.notes
    assert all(text in notes["logic levels"] for text in ("low up to 0.8 V, high 2 to 5 V", "low at most 0.8 V"))
    assert all(text in notes["supply"] for text in ("12 to 40 V", "42 V", "80 mA", "100 mA", "10 mA"))
    assert all(text in notes["limits"] for text in ("0 to 50", "-40 to 85", "0 to 90 %"))


@both
@pytest.mark.fact("GSC-PIN-SUPPLY-1", "GSC-UND-SUPPLY")
def test_a_supply_or_a_load_beyond_the_limits_is_a_finding_and_changes_nothing(part: str) -> None:
    def findings(**options: object) -> list[str]:
        rig = base(part, options=options)
        assert rig.asks("F") == ["R"]
        return [f"{found.code}: {found.text}" for found in rig.x.findings]

    assert findings(supply=12) == findings(supply=40) == findings(load={"v5_20": 60, "v5_21": 40, "vsl_plus": 10}) == []
    assert findings(supply=11) == ["supply: 11 V; the module needs 12 to 40 V"]
    assert findings(supply=43) == ["supply: 43 V; the module needs 12 to 40 V"]
    assert findings(load={"v5_20": 60, "v5_21": 41}) == ["load: 101 mA from v5_20 and v5_21; allowed up to 100 mA"]
    assert findings(load={"vsl_minus": 11, "vsl_plus": 11}) == [
        "load: 11 mA from vsl_plus; allowed up to 10 mA",
        "load: 11 mA from vsl_minus; allowed up to 10 mA",
    ]
    with pytest.raises(UsageError, match="load: no option 'uo1'; its options: v5_20, v5_21"):
        findings(load={"uo1": 1})


@both
@pytest.mark.fact("GSC-UND-SUPPLY", "GSC-POS-10")
def test_the_supply_is_on_or_off(part: str) -> None:
    rig = base(part, "clock", "mov")
    rig.start(*STR, "+1000")
    rig.bench.run_until(rig.x.reaches(500))
    last = rig.bench.now_ps
    rig.x.power(False)
    assert {rig.level(pin) for pin in OUTPUTS - {"txd", "rdy"}} == {None}
    rig.bench.run("1 s")
    assert rig.pulses()[-1] == last and len(rig.pulses()) == 500
    rig.x.power(True)
    assert rig.asks("F", "Q", "E") == ["R", "END", "E4"]


@pytest.mark.fact("GSC-PIN-SEQ-1")
def test_the_driver_interface_has_four_primary_signals_and_four_utilities() -> None:
    numbers = {row.name: row.number for row in sheet.PINS}
    assert {numbers[name] for name in ("reset", "clock", "dir", "enable")} == {27, 28, 26, 24}
    assert {numbers[name] for name in ("mov", "ramp", "home", "eot")} == {22, 23, 32, 30}


# ------------------------------------------------------------------------------------------------------ open inputs
@both
@pytest.mark.fact("GSC-PIN-3")
def test_open_straps_are_110_baud_point_to_point(part: str) -> None:
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps={"chs": 0})
    port = bench.part("serial_port", name="port", baud=110, to=x)
    bench.run("1 ms")
    port.write("F\r")
    bench.run("200 ms")  # two characters of 11 bits
    assert port.received == b""
    bench.run("201 ms")
    assert port.received == b"R\r" and port.faulty == 0


@both
@pytest.mark.fact("GSC-PIN-4")
def test_a_bare_module_reads_its_open_inputs_as_1(part: str) -> None:
    bench = slewline.Bench()
    x = bench.add(part, name="x", bare=True)
    host = bench.host(x)
    bench.run("1 s")
    assert {x.pin(pin).level for pin in ("enable", "eot", "home", "rec", "chs", "ui1", "ui2", "ui3")} == {1}
    host.send("V2\x18\r")
    bench.run("2 s")
    assert host.received == b"V70=\r"
    assert len(x.steps()) == 0


# ---------------------------------------------------------------------------------------------------------------- RDY
@both
@pytest.mark.fact("GSC-PIN-RDY-1")
def test_rdy_is_low_from_the_command_to_the_end_of_the_program(part: str) -> None:
    rig = base(part, "rdy")
    rig.prg("D10")
    sent = rig.bench.now_ps
    acted = rig.obeyed("E")
    rig.bench.run_until_idle()
    (low, _), (high, _) = rig.edges("rdy", sent)
    assert sent < low < acted
    assert high == acted + MS + 1000 * MS


@both
@pytest.mark.fact("GSC-PIN-RDY-1")
def test_rdy_is_an_open_collector(part: str) -> None:
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0}, bare=True)
    host = bench.host(x)
    bench.run("1 ms")
    assert x.pin("rdy").level is None
    assert [host.ask("P" if part == C200 else "Po"), host.ask("D1"), host.ask("E")] == ["Y"] * 3
    assert x.pin("rdy").level == 0
    bench.run_until_idle()
    assert x.pin("rdy").level is None


@both
@pytest.mark.fact("GSC-PIN-RDY-2")
def test_rdy_agrees_with_the_answer_to_f(part: str) -> None:
    rig = base(part)
    rig.start("D20")
    answers = []
    for _ in range(25):
        at = rig.bench.now_ps
        answers.append(rig.ask("F"))
        assert rig.level("rdy") == (answers[-1] == "R")
        rig.bench.run_to(at + 100 * MS)
    assert answers == ["B"] * 20 + ["R"] * 5


@pytest.mark.fact("GSC-PIN-RDY-2")
def test_rdy_is_high_with_e5() -> None:
    rig = base(C200)
    rig.run(*STR, "-1")
    assert rig.ask("F") == "E5" and rig.level("rdy") == 1


@both
@pytest.mark.fact("GSC-PIN-RDY-3", "GSC-UND-RDY-PROG")
def test_while_programming_rdy_is_low_only_for_the_work_on_each_line(part: str) -> None:
    rig = base(part, "rdy")
    rig.prg()
    sent = rig.bench.now_ps
    acted = rig.obeyed("S10")
    rig.bench.run("1 s")
    assert rig.x._entering
    (low, _), (high, _) = rig.edges("rdy", sent)
    assert high == acted and acted - MS - 200 * US < low < acted - MS + 200 * US
    assert rig.level("rdy") == 1 and rig.ask("F") == "R"


# ------------------------------------------------------------------------------------------------------ MOV and RAMP
@both
@pytest.mark.fact("GSC-PIN-MOV-1")
def test_mov_is_low_in_delays_and_waits(part: str) -> None:
    rig = base(part, "mov", ui2=0)
    rig.drive("ui2", 1, at=(release := 5000 * MS))
    rig.run(*STR, "D5", "+50", "D5", "W2", "+1")
    steps = rig.pulses()
    assert rig.edges("mov") == [
        (steps[0] - SETUP, 1),
        (steps[49] + WIDTH, 0),
        (steps[50] - SETUP, 1),
        (steps[50] + WIDTH, 0),
    ]
    assert release < steps[50] - SETUP < release + 3 * MS


@both
@pytest.mark.fact("GSC-PIN-MOV-2")
def test_mov_falls_between_two_moves(part: str) -> None:
    rig = base(part, "mov")
    rig.run(*STR, "+20", "-20")
    steps = rig.pulses()
    highs = list(zip(rig.rises("mov"), rig.falls("mov"), strict=True))
    assert [sum(rise <= step < fall for step in steps) for rise, fall in highs] == [20, 20]


@both
@pytest.mark.fact("GSC-PIN-RAMP-1", "GSC-PIN-RAMP-2", "GSC-PIN-MOV-3", "GSC-CON-MOV-END")
def test_mov_and_ramp_indicate_rest_ramp_and_slew(part: str) -> None:
    rig = base(part, "mov", "ramp")
    rig.run("S10", "T100", "R50", "+1000")
    steps = rig.pulses()
    assert rig.edges("mov") == [(steps[0] - SETUP, 1), (steps[-1] + WIDTH, 0)]
    assert rig.edges("ramp") == [
        (steps[0] - SETUP, 1),
        (steps[50], 0),
        (steps[949], 1),
        (steps[-1] + WIDTH, 0),
    ]


@both
@pytest.mark.fact("GSC-PIN-RAMP-3", "GSC-PIN-RAMP-2")
def test_ramp_is_never_high_without_mov(part: str) -> None:
    """Whatever happens: moves long and short, Z and K in every phase, holds, homing, power off."""
    rig = base(part)
    mov, ramp = rig.x.pin("mov").net, rig.x.pin("ramp").net
    seen: set[tuple[int, object, object]] = set()
    for net in (mov, ramp):
        net.watch(lambda _net: seen.add((rig.bench.now_ps, mov.level, ramp.level)))
    rig.run("S10", "T100", "R50", "+1000", "+60", "-7", "+1", "S100", "+20", "S10")
    run = "G+" if part == C200 else "g+"
    for command, wait in [("K", "100 ms"), ("Z", "100 ms"), ("K", "1 s"), ("Z", "1 s")]:
        rig.start("S10", "T100", "R50", run)
        rig.bench.run(wait)
        rig.drive("enable", 0)
        rig.bench.run(wait)
        rig.drive("enable", 1)
        assert rig.ask(command) == "Y"
        rig.bench.run_until_idle()
    rig.drive("eot", 0)
    rig.drive("home", 0)
    assert rig.ask("H") == "Y"
    rig.start("S10", "T100", "R50", run)
    rig.bench.run("100 ms")
    rig.x.power(False)
    last = {}  # in an instant only what it leaves behind counts
    for time, moving, ramping in sorted(seen, key=lambda entry: entry[0]):
        last[time] = (moving, ramping)
    assert set(last.values()) <= {(0, 0), (1, 0), (1, 1), (None, None)}
    assert (1, 1) in last.values() and (1, 0) in last.values()


# ------------------------------------------------------------------------------------------------------ DIR and CLOCK
@both
@pytest.mark.fact("GSC-PIN-DIR-1", "GSC-PIN-DIR-2", "GSC-UND-DIR-SETUP")
def test_dir_changes_with_clock_high_and_before_the_first_step(part: str) -> None:
    rig = base(part, "dir", "clock")
    if part == C200:
        rig.run(*STR, "+100")
    begin = rig.bench.now_ps
    rig.run(*STR, "+5", "-5", "+5")
    edges, falls = rig.edges("dir", begin), rig.falls("clock", begin)
    assert edges == [(falls[5] - SETUP, 0), (falls[10] - SETUP, 1)]
    assert {rig.x.pin("clock").net.level} == {1}
    for time, _ in edges:
        assert not any(fall <= time <= fall + WIDTH for fall in falls)


@both
@pytest.mark.fact("GSC-PIN-CLOCK-2")
def test_only_a_motion_causes_a_clock_pulse(part: str) -> None:
    rig = base(part, "clock")
    assert rig.asks("I3", "F", "V2") == ["Y", "R", "V70"]
    rig.run("A1", "C1", "D1", "W1", "L0", "L5")
    rig.run(*STR)
    rig.listed()
    rig.asks("M", "X", "K", "Z", "I1")
    rig.bench.run("10 s")
    rig.drive("enable", 0)
    rig.drive("enable", 1)
    rig.bench.run("1 s")
    assert rig.edges("clock") == []


# -------------------------------------------------------------------------------------------------------------- RESET
@both
@pytest.mark.fact("GSC-PIN-RESET-1", "GSC-TIME-2", "GSC-CON-RESET-WIDTH", "GSC-UND-POWERUP")
def test_reset_is_low_for_400_us_at_power_up(part: str) -> None:
    rig = base(part, "reset", "rdy")
    assert rig.level("reset") == 0 and rig.level("rdy") == 0
    rig.bench.run("10 s")
    assert rig.edges("reset") == [(RESET_WIDTH, 1)] == rig.edges("rdy")
    again = rig.cycle()
    rig.bench.run("10 s")
    assert rig.edges("reset", again + 1) == [(again + RESET_WIDTH, 1)]
    assert rig.levels("clock", "dir", "mov", "ramp", "rdy") == (1, 1, 0, 0, 1)


@both
@pytest.mark.fact("GSC-UND-POWERUP")
@pytest.mark.parametrize(("early", "answer"), [(0, b"R\r"), (300 * US, b"")])
def test_lines_are_taken_from_the_end_of_the_reset_pulse_on(part: str, early: int, answer: bytes) -> None:
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    port = bench.part("serial_port", name="port", to=x)
    bench.run_to(RESET_WIDTH - early)
    port.write("F\r")  # the first bits of a character that comes too early are lost, and so is the character
    bench.run("20 ms")
    assert port.received == answer


@both
@pytest.mark.fact("GSC-UND-POWERUP")
def test_after_power_up_there_is_no_program_no_speed_and_no_distance(part: str) -> None:
    rig = base(part)
    for _ in range(2):
        rig.bench.run("1 s")
        assert rig.x.program == b"" and rig.ask("Q") == "END"
        assert rig.x.registers == {
            "start_stop": 0,
            "top_speed": 0,
            "ramp": 0,
            "position": 0,
            "user_inputs": 7,
            "user_outputs": 0,
        }
        assert rig.levels("clock", "dir", "mov", "ramp", "rdy", "reset") == (1, 1, 0, 0, 1, 1)
        rig.run(*STR, "A1", "+7", "-2")
        rig.cycle()


@both
@pytest.mark.fact("GSC-PIN-RESET-2", "GSC-TIME-2", "GSC-CON-RESET-WIDTH")
@pytest.mark.parametrize("command", ["I1", "I3"])
def test_initialising_the_counter_pulses_reset(part: str, command: str) -> None:
    rig = base(part, "reset")
    rig.bench.run("1 ms")
    sent = rig.bench.now_ps
    acted = rig.obeyed(command)
    assert rig.edges("reset", sent) == [(acted - RESET_WIDTH, 0), (acted, 1)]


@both
@pytest.mark.fact("GSC-PIN-RESET-3")
def test_nothing_else_pulses_reset(part: str) -> None:
    rig = base(part, "reset", eot=0, home=0)
    rig.bench.run("1 ms")
    rig.run(*STR, "+5")
    rig.asks("I2", "M", "X", "K", "Z", "F", "V1", "Q")
    assert rig.ask("H") == "Y"
    rig.bench.run_until_idle()
    if part == C200S:
        assert rig.ask("f+5") == "Y"
        rig.run("f+7", "I2")
    assert rig.edges("reset") == [(RESET_WIDTH, 1)]


@pytest.mark.fact("GSC-UND-I-RESET-PROG", "GSC-PIN-RESET-2")
@pytest.mark.parametrize(("what", "pause"), [("I1", RESET_WIDTH), ("I2", 0), ("I3", RESET_WIDTH)])
def test_a_program_waits_for_the_reset_pulse_of_a_stored_i(what: str, pause: int) -> None:
    rig = base(C200S, "reset", "uo2")
    acted = rig.start("A1", what, "A2")
    rig.bench.run_until_idle()
    assert rig.edges("reset", acted) == ([(acted + 2 * MS, 0), (acted + 2 * MS + pause, 1)] if pause else [])
    assert rig.rises("uo2") == [acted + 3 * MS + pause]
    assert rig.level("uo1") == (what == "I1")


@pytest.mark.fact("GSC-UND-K-DETAIL")
@pytest.mark.parametrize("end", ["K", "Z"])
def test_k_and_z_let_the_reset_pulse_of_a_program_end(end: str) -> None:
    rig = base(C200S, "reset", "uo1")
    falls = rig.start("D1", "I1", "A1") + 2 * MS + 100 * MS
    rig.acts(end, falls + 100 * US)
    rig.bench.run("10 ms")
    assert rig.edges("reset", falls) == [(falls, 0), (falls + RESET_WIDTH, 1)]
    assert rig.ask("F") == "R" and rig.level("uo1") == 0


# ------------------------------------------------------------------------------------------------------ user outputs
@both
@pytest.mark.fact("GSC-PIN-UO-1", "GSC-UND-POWERUP")
def test_the_user_outputs_are_0_after_power_up(part: str) -> None:
    rig = base(part)
    assert rig.levels("uo1", "uo2", "uo3") == (0, 0, 0)
    assert rig.ask("V2") == "V70"
    rig.run("A1", "A2", "A3")
    rig.cycle()
    assert rig.ask("V2") == "V70"


@both
@pytest.mark.fact("GSC-PIN-UO-2")
def test_user_outputs_outlive_programs_k_z_and_h(part: str) -> None:
    rig = base(part, eot=0, home=0)
    rig.run("A1", "A3")
    assert rig.ask("V2") == "V75"
    for stop in ("K", "Z"):
        rig.start(*STR, "A2", "D50")
        rig.bench.run("1 s")
        assert rig.asks(stop, "V2") == ["Y", "V77"]
    assert rig.asks("H", "V2", "I1", "V2", "I2", "V2") == ["Y", "V77", "Y", "V77", "Y", "V70"]
    rig.run("A2")
    assert rig.asks("I3", "V2") == ["Y", "V70"]


# ---------------------------------------------------------------------------------------------------------- the line
@both
@pytest.mark.fact("GSC-PIN-CHS-1")
def test_chs_takes_the_checksum_from_both_directions(part: str) -> None:
    assert base(part).wire("F\r") == b"R\r"
    rig = base(part, chs=1)
    assert rig.wire("FV\r") == b"RR\r"
    assert rig.wire("F\r") == b"E1v\r"


def line(*names: str, **wires: str) -> dict[str, list[str]]:
    """Modules on one line, their pull-downs wired so; returns the codes of their findings."""
    bench = slewline.Bench()
    chips = [bench.add("gs-c200s", name=name, straps={f"sel{n}": 0}) for n, name in enumerate(names)]
    for chip, txd in wires.items():
        bench.wire(f"{chip}.txpd", f"{txd}.txd")
    bench.host(*chips)
    bench.run("1 ms")
    return {chip.name: [found.code for found in chip.findings] for chip in chips}


@pytest.mark.fact("GSC-PIN-TXPD-1")
def test_a_line_has_one_pull_down() -> None:
    assert line("x", "y", "z") == {"x": [], "y": [], "z": []}  # the host is wired to the pull-down of the last one
    assert line("x", "y", "z", x="x") == {"x": [], "y": [], "z": []}
    assert line("x", "y", x="x", y="y") == {"x": ["pull-downs"], "y": ["pull-downs"]}


@both
@pytest.mark.fact("GSC-PIN-TXPD-1")
@pytest.mark.parametrize("sel", [{}, {"sel0": 0}])
def test_a_module_without_a_pull_down_on_its_line_is_reported(part: str, sel: dict[str, int]) -> None:
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps={"test": 0, **sel}, bare=True)
    y = bench.add(part, name="y", straps={"test": 0, **sel}, bare=True)
    bench.wire("y.txd", "y.txpd")
    bench.run("1 ms")
    assert [found.code for found in x.findings] == ["no-pull-down"]
    assert y.findings == []


def test_a_rig_is_wired_as_the_sheet_requires() -> None:
    rig: Rig = base(C200)
    rig.bench.run("1 s")
    assert rig.codes == []
