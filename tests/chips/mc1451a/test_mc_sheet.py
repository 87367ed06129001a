"""The data sheets of the MC1451A family against the manual's tables: commands, codes, words, pins, times."""

from __future__ import annotations

import re
from itertools import pairwise

import pytest

import slewline
from slewline.chips import PARTS, sheet_of
from slewline.chips.mc1451a.sheet import CYCLE_TICKS, HIGH_RANGE, NOTES, SLICE_TICKS, STANDARD_RANGE, TIMES
from slewline.core.datasheet.command_rows import PacketRow
from slewline.core.datasheet.table import Table
from slewline.errors import SheetError, UnknownName

SHEETS = {part: sheet_of(part) for part, row in PARTS.items() if row.folder == "mc1451a"}
AXES = {"mc1151a": 1, "mc1251a": 2, "mc1451a": 4, "mc1151a-e": 1, "mc1251a-e": 2, "mc1451a-e": 4}
FULL = SHEETS["mc1451a-e"]
each = pytest.mark.parametrize("part", SHEETS)

# The command summary: code, name, words; w: written, r: read, -: none; capitals where it is buffered.
SUMMARY = """
01 set_1 1r            02 set_2 1r           03 set_3 1r              04 set_4 1r             08 set_i 1r
0b set_prfl_s_crv -    09 set_prfl_trap -    0a set_prfl_vel -        0c set_prfl_gear -
10 set_pos 2W          11 set_vel 2W         12 set_acc 2W            15 set_max_acc 1W       13 set_jerk 2W
14 set_ratio 2W        6a set_start_vel 2w   46 stop B                4e smooth_stop B        47 synch_prfl B
4a get_pos 2r          4b get_vel 2r         4c get_acc 2r            4f get_max_acc 1r       58 get_jerk 2r
59 get_ratio 2r        6b get_start_vel 2r   1d get_trgt_pos 2r       1e get_trgt_vel 2r
17 set_time_brk -      18 set_pos_brk -      19 set_neg_brk -         1b set_actl_pos_brk -   1c set_actl_neg_brk -
35 set_mtn_cmplt_brk - 5e set_ext_brk -      6d set_brk_off -         16 set_brk_pnt 2w       1a update -
5b multi_update 1w     5c set_auto_update_on - 5d set_auto_update_off - 57 get_brk_pnt 2r
2f set_intrpt_mask 1w  30 get_intrpt 1r      32 rst_intrpt 1w         56 get_intrpt_mask 1r
33 clr_status -        34 rst_status 1w      31 get_status 1r         48 get_mode 1r
3c set_output_stndrd - 3b set_output_high -  43 mtr_on -              42 mtr_off -
37 get_actl_pos 2r     68 set_step_ratio 1w  6f get_step_ratio 1r     45 set_auto_stop_on -   44 set_auto_stop_off -
29 set_pos_err 1w      55 get_pos_err 1r     60 get_actl_pos_err 1r
4d set_actl_pos 2w     66 set_lmt_sense 1w   67 get_lmt_swtch 1r      70 lmts_on -            71 lmts_off -
05 get_home 1r         39 reset -            6c get_vrsn 1r           3e get_time 2r
64 set_capt_index -    65 set_capt_home -    36 get_capt 2r
"""
LISTED = re.findall(r"([0-9a-f]{2}) (\w+) (?:(\d)?([wWrB-]))", SUMMARY)

# The pin descriptions: package, name, numbers; names with a range stand for as many pins.
PACKAGES = """
i/o pulse1-4 28 26 40 39         i/o dir1-4 42 30 35 34         i/o home1-4 13 23 11 10     i/o cpclk 46
i/o ioclkin 52                   i/o ioclkout 45                i/o cpaddr0-3 68 27 29 12   i/o cpwrite 2
i/o cpcntrl0-3 20 36 22 63       i/o cpdata4-11 18 5 6 7 8 17 3 1                           i/o cpreset 43
i/o hostcmd 41                   i/o hostrdy 37                 i/o hostread 51             i/o hostwrite 47
i/o hostslct 48                  i/o hostintrpt 44              i/o hostdata0-7 50 61 53 65 67 62 64 60
i/o vcc 4 21 25 38 55            i/o gnd 14 15 32 49 54 66
cp atrest1-4 56 55 54 53         cp poslimit1-4 52 45 42 38     cp neglimit1-4 51 44 41 37  cp clkin 24
cp clkout 19                     cp reset 17                    cp iocntrl0-3 16 18 68 67   cp iowrite 15
cp data2-11 58 57 50 49 46 43 40 39 36 35                       cp ioaddr0-3 28 9 6 5       cp vcc 4 22 33
cp gnd 3 34
enc quada1-4 30 17 27 5          enc quadb1-4 36 18 28 29       enc cpclk 7                 enc encclkin 33
enc encclkout 6                  enc cpaddr0 24                 enc cpaddr2-3 20 23         enc cpwrite 13
enc cpcntrl0 15                  enc cpdata2-11 22 19 9 31 41 42 44 1 12 2                  enc vcc 3 14 16 25 35
enc gnd 10 21 32 34 43
"""
WHERE = {"i/o": "I/O chip", "cp": "CP chip", "enc": "ENC chip"}
OUT = ("pulse", "dir", "hostrdy", "hostintrpt", "atrest", "clkout")
IN = ("home", "hostcmd", "hostread", "hostwrite", "hostslct", "poslimit", "neglimit", "reset", "quada", "quadb")


def table_pins():
    """(package, name, number) of every pin, as the manual lists them."""
    for package, name, numbers in re.findall(r"(i/o|cp|enc) (\S+)((?: \d+)+)", PACKAGES):
        stem, first = re.fullmatch(r"([a-z]+)(\d*)(?:-\d+)?", name).groups()
        for n, number in enumerate(map(int, numbers.split())):
            yield package, stem if stem in ("vcc", "gnd") else f"{stem}{int(first) + n}" if first else stem, number


# ------------------------------------------------------------------------------------------------------------- commands
@pytest.mark.fact("PMD-CON-COMMAND-COUNT", "PMD-CON-DATALINE", "PMD-CON-JERK-LINE", "PMD-CON-BUFFER-COLUMN")
def test_every_command_of_the_summary_has_its_row_and_there_is_no_other():
    assert len(LISTED) == 74
    assert {row.form.lower() for row in FULL.commands} == {name for _, name, *_ in LISTED}
    for code, name, number, way in LISTED:
        row = FULL.commands[name.upper()]
        assert row.code == int(code, 16)
        assert sum(arg.size for arg in row.args) == 2 * int(number or 0) * (way in "wW"), name
        assert sum(arg.size for arg in row.reads) == 2 * int(number or 0) * (way == "r"), name
        assert row.buffered == (way in "WB"), name


@each
@pytest.mark.fact("PMD-CON-ILLEGAL-34")
def test_a_part_has_the_set_commands_of_its_axes_and_the_others_are_illegal(part):
    sheet, axes = SHEETS[part], AXES[part]
    assert (sheet.axes, sheet.encoder) == (axes, part.endswith("-e"))
    assert [row.code for row in sheet.commands if row.acts == "set"] == list(range(1, axes + 1))
    assert len(sheet.commands) == 70 + axes
    missing = set(range(axes + 1, 5))
    assert sheet.dialect.illegal == {0x00, 0x22, *range(0x80, 0x100)} | missing
    assert set(sheet.foreign) == {f"SET_{n}" for n in missing}


@each
@pytest.mark.fact("PMD-CON-RESERVED-4E")
def test_every_code_is_of_one_kind(part):
    sheet = SHEETS[part]
    port = sheet.dialect
    kinds = [set(sheet.commands.by_code), port.illegal, port.reserved, set(port.siblings)]
    assert sum(map(len, kinds)) == len(set().union(*kinds))
    silent = set(range(0x80)).difference(*kinds)
    assert silent == {
        *(0x0D, 0x0E, 0x1F, 0x20, 0x21, 0x23, 0x24, 0x2A, 0x2C, 0x3D, 0x3F, 0x5A, 0x5F, 0x63),
        *range(0x72, 0x80),
    }
    assert port.reserved == {0x49} and sheet.commands.by_code[0x4E].name == "SMOOTH_STOP"
    assert [code for code, found in port.siblings.items() if not found.writes + found.reads] == [0x40, 0x41]


def test_commands_are_found_by_their_codes_and_two_may_not_share_one():
    assert FULL.commands.by_code[0x10] is FULL.commands["SET_POS"] is FULL.commands.named("set_pos")
    one, two = (PacketRow(name, name, (), 82, "", "", code=0x10, acts="current") for name in ("SET_POS", "SET_VEL"))
    with pytest.raises(SheetError):
        Table(one, two)


def test_commands_for_the_encoder_are_on_every_part_and_marked():
    marked = {row.form for row in FULL.commands if row.encoder}
    assert len(marked) == 17
    assert {"SET_PRFL_GEAR", "SET_RATIO", "GET_RATIO", "SYNCH_PRFL", "GET_CAPT", "SET_CAPT_HOME"} < marked
    assert {"SET_ACTL_POS", "GET_TRGT_POS", "SET_EXT_BRK"}.isdisjoint(marked)
    for sheet in SHEETS.values():
        assert {row.form for row in sheet.commands if row.encoder} == marked


def test_a_command_acts_on_the_current_axis_except_these():
    acts = {row.form: row.acts for row in FULL.commands if row.acts != "current"}
    assert acts == {
        **dict.fromkeys(("SET_1", "SET_2", "SET_3", "SET_4"), "set"),
        **dict.fromkeys(("SET_I", "GET_INTRPT", "RST_INTRPT"), "interrupting"),
        "MULTI_UPDATE": "mask",
        **dict.fromkeys(
            ("GET_HOME", "RESET", "GET_TIME", "SET_LMT_SENSE", "GET_LMT_SWTCH", "GET_VRSN", "LMTS_ON", "LMTS_OFF"),
            "global",
        ),
    }


@pytest.mark.parametrize(
    ("command", "low", "high", "unit", "fraction"),
    [
        ("SET_POS", -1073741824, 1073741823, "steps", 0),
        ("SET_VEL", 0, 1073741823, "steps/cycle", 16),
        ("SET_ACC", -1073741824, 1073741823, "steps/cycle^2", 16),
        ("SET_MAX_ACC", 0, 32767, "steps/cycle^2", 16),
        ("SET_JERK", 0, 2147483647, "steps/cycle^3", 32),
        ("SET_RATIO", -1073741824, 1073741823, "steps/count", 16),
        ("SET_START_VEL", 0, 1073741823, "steps/cycle", 16),
        ("SET_STEP_RATIO", 0, 32767, "counts/step", 8),
        ("SET_POS_ERR", 0, 32767, "counts", 0),
    ],
)
@pytest.mark.fact("PMD-CON-PARAM-UNIT", "PMD-CON-VELOCITY-SIGN", "PMD-CON-ACC-UNIT", "PMD-CON-MAXACC-RANGE")
@pytest.mark.fact("PMD-CON-RATIO-RANGE", "PMD-CON-STARTVEL-RANGE", "PMD-CON-STEPRATIO-RANGE")
def test_contents_of_a_register(command, low, high, unit, fraction):
    (arg,) = FULL.commands[command].args
    assert (arg.low, arg.high, arg.unit, arg.fraction) == (low, high, unit, fraction)
    assert f"/cycle^{arg.cycles}" in unit or (arg.cycles < 2 and arg.cycles == unit.endswith("/cycle"))
    name = command.replace("SET_", "GET_")
    assert [(read.low, read.high) for read in FULL.commands[name].reads] == [(low, high)]


@pytest.mark.fact("PMD-CON-TIME-WRAP", "PMD-CON-VELOCITY-SIGN")
def test_read_only_registers_have_a_range_too():
    ranges = {
        "GET_TIME": (0, 4294967295),
        "GET_TRGT_VEL": (-1073741824, 1073741823),
        "GET_ACTL_POS": (-1073741824, 1073741823),
        "GET_ACTL_POS_ERR": (-32768, 32767),
    }
    for name, allowed in ranges.items():
        (read,) = FULL.commands[name].reads
        assert (read.low, read.high) == allowed
    assert FULL.commands["SET_BRK_PNT"].args[0].unit == "cycles, steps or counts"
    assert FULL.commands["GET_ACTL_POS"].reads[0].unit == "counts"


# ---------------------------------------------------------------------------------------------------------------- words
@each
@pytest.mark.fact("PMD-VRSN-1", "PMD-VRSN-4", "PMD-VRSN-5", "PMD-VRSN-6", "PMD-CON-VRSN-FAMILY")
def test_the_version_word(part):
    version = SHEETS[part].dialect.version
    assert version == {1: 0x4411, 2: 0x4C11, 4: 0x5C11}[AXES[part]]
    assert (version >> 14, (version >> 11 & 7) + 1, version >> 8 & 7) == (1, AXES[part], 4)
    assert (version >> 5 & 7, version >> 3 & 3, version & 7) == (0, 2, 1)


@pytest.mark.fact("PMD-CON-INT-BITS")
def test_the_bits_of_the_status_and_mode_words():
    status = {bits.name: bits.mask for bits in FULL.dialect.status}
    assert list(status.values()) == [*(1 << n for n in range(11)), 3 << 12]
    assert list(status)[:8] == [
        *("motion_complete", "wrap_around", "breakpoint", "capture"),
        *("motion_error", "positive_limit", "negative_limit", "command_error"),
    ]
    assert list(status)[8:] == ["motor_on", "axis_on", "in_motion", "axis"]
    assert {bits.name: bits.mask for bits in FULL.dialect.mode} == {
        **{"auto_stop": 1 << 7, "high_speed": 1 << 9, "auto_update_off": 1 << 10, "profile": 3 << 11, "phase": 7 << 13}
    }
    assert FULL.commands["SET_INTRPT_MASK"].args[0].high == 0xFF
    assert [bits.of(0x3380) for bits in FULL.dialect.status if bits.name == "axis"] == [4]


# ----------------------------------------------------------------------------------------------------------------- pins
@pytest.mark.fact("PMD-PIN-1", "PMD-CON-HEADINGS", "PMD-CON-DATA9", "PMD-CON-HOSTCMD-BAR")
def test_the_pins_of_all_three_packages():
    expected = {}
    for package, name, number in table_pins():
        signal = name.rstrip("0123456789")
        plain = signal in (*OUT, *IN, "hostdata") or name == "clkin"
        full = name if plain else f"{package.replace('/', '')}_{name}{number if signal in ('vcc', 'gnd') else ''}"
        way = "out" if signal in OUT else "in" if signal in IN else "both" if signal == "hostdata" else "none"
        expected[full] = (number, WHERE[package], "power" if signal in ("vcc", "gnd", "clkin") else way)
    found = {pin.name: (pin.number, pin.where.split(";")[0], pin.in_out) for pin in FULL.pins}
    assert found == expected
    for package in WHERE.values():
        numbers = [number for number, where, _ in found.values() if where == package]
        assert len(numbers) == len(set(numbers)), package


LOW_ACTIVE = {"home", "hostread", "hostwrite", "hostslct", "hostintrpt", "reset"}


@pytest.mark.fact("PMD-PIN-1")
def test_active_levels_and_wiring_of_a_bare_part():
    for pin in FULL.pins:
        signal = pin.name.rstrip("0123456789")
        if signal in IN or signal == "hostintrpt":
            assert (pin.active == 0) == (signal in LOW_ACTIVE), pin.name
        if signal in IN:
            assert pin.tie == (signal in LOW_ACTIVE), f"{pin.name} is tied to what does nothing"
        else:
            assert pin.tie is None
    resets = {pin.name: pin.reset for pin in FULL.pins if pin.reset is not None}
    assert resets == {
        **{f"{name}{n}": level for name, level in (("pulse", 0), ("dir", 1), ("atrest", 1)) for n in range(1, 5)},
        **{"hostrdy": 0, "hostintrpt": 1},
    }


@each
@pytest.mark.fact("PMD-PIN-2", "PMD-CON-INDEX")
def test_axes_and_encoders_that_a_part_lacks_have_no_pins(part):
    sheet, axes = SHEETS[part], AXES[part]
    names = {pin.name for pin in sheet.pins}
    for signal in ("pulse", "dir", "home", "atrest", "poslimit", "neglimit", "quada", "quadb"):
        there = axes if sheet.encoder or not signal.startswith("quad") else 0
        assert {name for name in names if re.fullmatch(signal + r"\d", name)} == {
            f"{signal}{n}" for n in range(1, there + 1)
        }
    assert any(pin.where.startswith("ENC") for pin in sheet.pins) == sheet.encoder
    assert not any("index" in name for name in names)


@pytest.mark.fact("PMD-PIN-5", "PMD-CON-ENC-CLK")
def test_the_wires_between_the_packages():
    """What goes with what, by numbers: CP chip, I/O chip, ENC chip, as the manual lists it."""
    wires = {
        *((58, 0, 22), (57, 0, 19), (50, 18, 9), (49, 5, 31), (46, 6, 41), (43, 7, 42), (40, 8, 44), (39, 17, 1)),
        *((36, 3, 12), (35, 1, 2), (28, 68, 24), (9, 27, 0), (6, 29, 20), (5, 12, 23)),
        *((16, 20, 15), (18, 36, 0), (68, 22, 0), (67, 63, 0), (15, 2, 13), (19, 46, 7), (17, 43, 0)),
    }
    numbers = [{FULL.pin(name).where[:2]: FULL.pin(name).number for name in wire} for wire in FULL.wires]
    assert {(at["CP"], at.get("I/", 0), at.get("EN", 0)) for at in numbers if "CP" in at} == wires
    assert [wire for wire, at in zip(FULL.wires, numbers, strict=True) if "CP" not in at] == [
        ("io_ioclkout", "io_ioclkin"),
        ("enc_encclkout", "enc_encclkin"),
    ]
    plain = SHEETS["mc1451a"]
    assert len(plain.wires) == 20 and all(plain.pin(name) for wire in plain.wires for name in wire)


@pytest.mark.fact("PMD-PIN-6")
def test_levels_and_supply_are_in_the_notes():
    assert NOTES["supply"].startswith("4.75 to 5.25 V")
    assert NOTES["input levels"].startswith("high from 2.0 V (CLKIN 3.0 V, RESET 4.0 V), low up to 0.8 V")


# ---------------------------------------------------------------------------------------------------- a part on a bench
@each
@pytest.mark.fact("PMD-PIN-2", "PMD-PIN-3", "PMD-PIN-4", "PMD-UND-HOME-OPEN", "PMD-VRSN-4")
def test_a_part_on_a_bench_is_that_of_its_sheet(part):
    sheet, axes = SHEETS[part], AXES[part]
    bench = slewline.Bench()
    x = bench.add(part, name="x")
    host = bench.host(x)
    assert host.query("GET_VRSN") == sheet.dialect.version
    assert host.query("GET_HOME") == (1 << axes) - 1  # open: high
    assert host.query("GET_LMT_SWTCH") == 0  # tied low
    host.command("SET_EXT_BRK")
    bench.run("5 ms")
    assert (host.query("GET_STATUS"), x.findings) == (0x0300, [])  # no breakpoint, no limit
    with pytest.raises(UnknownName, match=f"has no pin 'home{axes + 1}'"):
        x.pin(f"home{axes + 1}")


@each
def test_the_registers_of_a_part_are_those_of_its_sheet(part):
    x = slewline.Bench().add(part, name="x")
    assert x.registers == {register.name: register.default for register in SHEETS[part].registers}


# ---------------------------------------------------------------------------------------------------------------- times
@pytest.mark.fact("PMD-CON-CYCLE", "PMD-CON-BUSY", "PMD-CON-PULSE-RATES")
def test_times_are_whole_clocks():
    for name, ticks in (("cycle", 8192), ("slice", 2048), ("reset_cycles", 81920), ("reset", 25), ("filter", 12)):
        assert TIMES[name].ticks == ticks
    assert (TIMES["cycle"].us, TIMES["slice"].us) == (327.68, 81.92)
    assert all(abs(time.ticks - time.us * time.mhz) <= 0.25 for time in TIMES.values())
    assert FULL.crystal_hz * STANDARD_RANGE / CYCLE_TICKS == 48828.125
    assert FULL.crystal_hz * HIGH_RANGE / CYCLE_TICKS == 1_562_500
    assert CYCLE_TICKS == 4 * SLICE_TICKS


@each
def test_registers_are_named_like_the_commands_that_read_them(part):
    sheet = SHEETS[part]
    for register in sheet.registers:
        assert f"GET_{register.name.upper()}" in sheet.commands.by_form
        assert not register.letter or register.letter in sheet.commands.by_form


@each
def test_a_suffix_names_its_part(part):
    assert SHEETS[part].suffix == f".{part}" and SHEETS[part].title.startswith(part.upper())
    assert all(one != two for one, two in pairwise(sorted(sheet.title for sheet in SHEETS.values())))
