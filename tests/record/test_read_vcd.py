"""The reader of VCD files: what our writer, pyvcd and sigrok write, other programs' habits, and damaged files."""

from __future__ import annotations

import io
import os
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from vcd.writer import VCDWriter

import slewline
from slewline.errors import NotRecorded, SlewlineError, TimeError, UnknownName, UsageError, WaveformError
from slewline.record.recording.recorder import real_edges
from slewline.record.waveforms import read_vcd as module
from slewline.record.waveforms.vcd import TIMESCALES, write_vcd
from tests.rows import rows

HEAD = "$timescale 1 ns $end\n$scope module x $end\n"
VARIABLES = """\
$var wire 1 ! slew $end
$var wire 8 " db [7:0] $end
$var real 64 # speed $end
$var string 1 $ text $end
$upscope $end
$enddefinitions $end
"""
SMALL = (
    HEAD
    + VARIABLES
    + """\
#1
$dumpvars
1!
bz "
r0 #
s $
$end
#5
0!
b101010 "
r-1.5e3 #
sP\\x20500\\n\\\\ $
#9
1!
b1z "
#12
"""
)


@pytest.fixture
def parse(tmp_path):
    def parse(text: str | bytes, **options):
        path = tmp_path / "a.vcd"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return slewline.read_vcd(path, **options)

    return parse


def edges(waveforms, name, *window):
    times, levels = waveforms.edges(name, *window)
    return list(zip(times.tolist(), levels.tolist(), strict=True))


# ---------------------------------------------------------------------------------------------------- what it gives
def test_small_file(parse):
    small = parse(SMALL)
    assert small.names == ("x.slew", "x.db", "x.speed", "x.text") and list(small) == list(small.names)
    assert (small.timescale_ps, small.start_ps, small.stop_ps) == (1000, 1000, 12_000)
    assert repr(small).endswith("a.vcd: 4 signals, 1 ns to 12 ns, in units of 1 ns>")
    assert edges(small, "x.slew") == [(5000, 0), (9000, 1)]
    assert edges(small, "x.db") == [(5000, 42), (9000, 0b11111111 & 3)]
    assert edges(small, "x.speed") == [(5000, -1500.0)]
    assert edges(small, "x.text") == [(5000, "P 500\n\\")]
    assert [small.level_at(name, 1000) for name in small] == [1, -1, 0.0, ""]
    assert [small.level_at("x.slew", time) for time in ("4999 ps", "5 ns", "1 s")] == [1, 0, 1]
    assert [small.width(name) for name in small] == [1, 8, 64, 0]
    assert [column.dtype for name in small for column in small.edges(name)] == [
        np.int64, np.int8, np.int64, np.int16, np.int64, np.float64, np.int64, object,
    ]  # fmt: skip


def test_windows_include_both_ends(parse):
    small = parse(SMALL)
    assert edges(small, "x.slew", "5 ns", "9 ns") == [(5000, 0), (9000, 1)]
    assert edges(small, "x.slew", 5001, 8999) == []
    with pytest.raises(TimeError):
        small.edges("x.slew", 0.5)
    with pytest.raises(NotRecorded, match="begins at 1 ns"):
        small.level_at("x.slew", 0)


def test_names(parse):
    small = parse(SMALL)
    assert "x.slew" in small and "slew" in small and "y.slew" not in small and 3 not in small
    assert edges(small, "slew") == edges(small, "x.slew")
    with pytest.raises(UnknownName, match=r"no signal 'pulse'; available: x\.slew, x\.db, x\.speed, x\.text$"):
        small.edges("pulse")
    text = "$timescale 1 ns $end $scope module a $end $var wire 1 ! d $end $upscope $end "
    text += "$scope module b $end $var wire 1 % d $end $var wire 1 ! e $end $upscope $end $enddefinitions $end\n#0 1!\n"
    several = parse(text)
    assert several.names == ("a.d", "b.d", "b.e") and several.level_at("e", 0) == 1 == several.level_at("a.d", 0)
    assert several.level_at("b.d", 0) == -2
    with pytest.raises(UnknownName, match=r"'d' matches the end of several names: a\.d, b\.d"):
        several.edges("d")
    assert "d" not in several


@pytest.mark.parametrize(("count", "more"), [(12, ""), (13, " and 1 more"), (20, " and 8 more")])
def test_of_many_names_a_message_lists_twelve(parse, count, more):
    names = [f"n{chr(ord('a') + n)}" for n in range(count)]
    wires = "".join(f"$var wire 1 {name[1]} {name} $end\n" for name in names)
    with pytest.raises(UnknownName, match=f"available: {', '.join(names[:12])}{more}$"):
        parse(f"$timescale 1 ns $end\n{wires}$enddefinitions $end\n#0\n").edges("pulse")


def test_one_name_for_several_signals(parse):
    text = "$timescale 1 ns $end $var wire 1 ! d $end $var wire 1 % d $end $var wire 4 & d [3:0] $end "
    text += "$var wire 4 ' d [7:4] $end $var wire 1 ! d $end $enddefinitions $end\n#0\n1!\n0%\nb11 &\nb100 '\n"
    several = parse(text)
    assert [(name, several.level_at(name, 0)) for name in several] == [
        ("d", 1), ("d#2", 0), ("d[3:0]", 3), ("d[7:4]", 4),
    ]  # fmt: skip


@pytest.mark.parametrize("form", ["db{}", "db[{}]", "db [{}]"])
def test_bits_are_a_bus(parse, form):
    variables = "".join(f"$var wire 1 {chr(40 + n)} {form.format(n)} $end\n" for n in range(8))
    text = (
        HEAD + variables + "$upscope $end $enddefinitions $end\n#0\n" + "".join(f"z{chr(40 + n)}\n" for n in range(8))
    )
    text += "#5\n1(\n0)\n#6\n" + "".join(f"{0x2A >> n & 1}{chr(40 + n)}\n" for n in range(8)) + "#7\nx/\n"
    bus = parse(text)
    assert "db" in bus and "x.db" not in bus.names and bus.width("x.db") == 8
    assert edges(bus, "x.db") == [(5000, 0xFD), (6000, 0x2A), (7000, -2)]
    assert bus.level_at("db", 0) == -1 and bus.edges("db")[1].dtype == np.int16
    assert "d" not in bus and "x" not in bus


def test_values_of_vectors(parse):
    values = {"b1": 1, "b00000011": 3, "bx": -2, "b1x": -2, "bz1": 0xFD | 3, "bz0": 0xFE, "bZ": -1, "BHL": 2, "b0z": 1,
              "bzzzzzzzz": -1, "b-": -2, "b0000000000001": 1}  # fmt: skip
    values["bz1"] = 0xFF  # what floats beside what is driven reads 1
    text = SMALL + "".join(f'#{20 + 2 * n}\nb10101010 "\n#{21 + 2 * n}\n{v} "\n' for n, v in enumerate(values))
    found = parse(text)
    assert [found.level_at("db", 1000 * (21 + 2 * n)) for n in range(len(values))] == list(values.values())
    assert parse(SMALL + '#20\n1"\n#21\nz"\n').level_at("db", 20_000) == 1  # a level for a bus


@rows("width", [15, 16, 62, 63])
def test_wide_vectors(parse, width):
    value = (1 << width) - 2
    text = (
        f'{HEAD}$var wire {width} " a $end $upscope $end $enddefinitions $end\n#0\nb0 "\n#1\nb{value:b} "\n#2\nbz0 "\n'
    )
    wide = parse(text + '#3\nbx "\n')
    assert edges(wide, "a") == [(1000, value), (3000, -2)]
    assert wide.edges("a")[1].dtype == (np.int16 if width < 16 else np.int64)


def test_a_vector_that_is_too_wide_is_refused_when_requested(parse):
    text = (
        f'{HEAD}$var wire 64 " a $end $var wire 1 ! b $end $upscope $end $enddefinitions $end\n#0 b{"1" * 64} "\n1!\n'
    )
    wide = parse(text)
    assert wide.level_at("b", 0) == 1
    with pytest.raises(UsageError, match="a has 64 bits; allowed up to 63"):
        wide.edges("a")


@rows(
    ("timescale", "times"),
    [("1ns", (1000, 7000)), ("1 ns", (1000, 7000)), ("\n\t10us\n", (10**7, 7 * 10**7)), ("10\nus", (10**7, 7 * 10**7)),
     ("1 fs", (0, 0)), ("100 fs", (0, 0)), ("1 PS", (1, 7)), ("100 s", (10**14, 7 * 10**14)),
     ("25 ns", (25_000, 175_000))],
)  # fmt: skip
def test_timescales(parse, timescale, times):
    text = SMALL.replace("1 ns", timescale).replace("#5\n", "#7\n")
    found = parse(text)
    assert found.start_ps == times[0]
    assert [time for time, _ in edges(found, "slew")][:1] == ([times[1]] if times[1] else [])


def test_femtoseconds_are_rounded_down(parse):
    text = (
        SMALL.replace("1 ns", "1 fs").replace("#5\n", "#1999\n").replace("#9\n", "#2000\n").replace("#12\n", "#10000")
    )
    found = parse(text + "\n")
    assert edges(found, "slew") == [(1, 0), (2, 1)] and found.timescale_ps == 1 and found.stop_ps == 10
    assert edges(parse(text.replace("#1999", "#2000") + "\n"), "slew") == []  # over within its picosecond


def test_a_file_without_timescale_needs_one_as_an_argument(parse):
    text = SMALL.replace("$timescale 1 ns $end\n", "")
    with pytest.raises(UsageError, match=r"has no \$timescale; .*timescale='1 ns'"):
        parse(text)
    assert edges(parse(text, timescale="10 us"), "slew") == [(5 * 10**7, 0), (9 * 10**7, 1)]
    with pytest.raises(UsageError, match="is 1000 ps, not the given 10000000 ps"):
        parse(SMALL, timescale="10 us")
    assert edges(parse(SMALL, timescale="1 ns"), "slew") == edges(parse(SMALL), "slew")


def test_last_value_of_an_instant_counts(parse):
    found = parse(SMALL + "#20\n0!\n1!\n#20\n0!\n#30\n1!\n0!\n")
    assert edges(found, "slew", "10 ns") == [(20_000, 0)]


def test_values_before_the_first_time(parse):
    found = parse(HEAD + VARIABLES + '$dumpvars 0! b11 " $end\n#100\n1!\n')
    assert found.start_ps == 0 and found.level_at("slew", 0) == 0 and found.level_at("db", 0) == 3
    assert edges(found, "slew") == [(100_000, 1)]


def test_a_wire_without_a_first_value_had_the_other_level(parse):
    found = parse(HEAD + VARIABLES + "#100\n#200\n1!\n")
    assert found.level_at("slew", "100 ns") == 0 and edges(found, "slew") == [(200_000, 1)]
    assert np.isnan(found.level_at("speed", "200 ns")) and found.level_at("text", "200 ns") == ""


def test_dumpoff_is_unknown(parse):
    found = parse(SMALL + '#20\n$dumpoff\nx!\nbx "\n$end\n#30\n$dumpon\n1!\nb1 "\n$end\n#40\n$dumpall\n1!\n$end\n')
    assert edges(found, "slew", "10 ns") == [(20_000, -2), (30_000, 1)]
    assert edges(found, "db", "10 ns") == [(20_000, -2), (30_000, 1)]


def test_a_file_without_changes(parse):
    found = parse(HEAD + VARIABLES)
    assert (found.start_ps, found.stop_ps) == (0, 0) and edges(found, "slew") == []
    assert found.level_at("db", 0) == -2


# ------------------------------------------------------------------------------------- habits of writers
@pytest.mark.parametrize("block", [41, 1 << 20])
def test_layout_does_not_matter(parse, block, monkeypatch):
    monkeypatch.setattr(module, "BLOCK", block)
    expected = {name: edges(parse(SMALL), name) for name in ("slew", "db", "speed", "text")}
    body = SMALL.index("#1\n")
    for text in (
        SMALL.replace("\n", "\r\n"),
        SMALL.replace("\n", "\n\n \t"),
        SMALL.replace(" $end\n", "\n$end\n"),
        SMALL[:body] + SMALL[body:].replace("\n", " ") + "\n",
        SMALL[:body] + SMALL[body:].replace(" ", "\n"),
        SMALL.replace("$enddefinitions $end\n", ""),
        SMALL.replace("$upscope", "$comment made by hand:\n0! #3 b11 $end $upscope"),
        SMALL.replace("#5\n", '#5\n$comment 1! b1 "\n#4 $dumpvars ? $end\n').replace("#9", "$comment $end\n#9"),
        SMALL.replace("bz", "bZ").replace("$scope module", "$scope\nbegin"),
        SMALL.replace("$timescale", "$date\n Sun Nov 22 12:00:00\n$end $version Icarus Verilog $end\n$timescale"),
    ):
        assert {name: edges(parse(text), name) for name in expected} == expected, text


def test_identifiers_that_look_like_values(parse):
    """The word behind a value is an identifier, whatever it looks like."""
    names = [
        "b",
        "b1",
        "r",
        "s",
        "S0",
        "#3",
        "$end",
        "0",
        "1!",
        "x",
        "$comment",
        "identifier_of_many_characters",
        "B",
        "z0",
    ]
    text = HEAD + "".join(f"$var wire 4 {name} v{n} $end\n" for n, name in enumerate(names) if name != "$end")
    names.remove("$end")
    text = text.replace("$comment", "$comments") + "$upscope $end $enddefinitions $end\n#0\n"
    names[names.index("$comment")] = "$comments"
    text += "".join(f"b{n:b} {name}\n" for n, name in enumerate(names))
    text += "#1\n" + "".join(f"b{n + 1:b} {name} " for n, name in enumerate(names)) + "\n#2\n0b 1b1 0#3 10 01!\n"
    found = parse(text)
    for n, variable in enumerate(found.names):
        assert found.level_at(variable, 0) == n and found.level_at(variable, "1 ns") == n + 1
    assert [
        found.level_at(f"x.v{names.index(name) + (names.index(name) > 5)}", "2 ns") for name in ("b", "b1", "#3")
    ] == [0, 1, 0]


SIGROK = """\
META samplerate: 1000000
$date Sun Nov 22 12:00:00 2026 $end
$version libsigrok 0.5.2 $end
$comment
  Acquisition with 3/8 channels at 1 MHz
$end
$timescale 1 us $end
$scope module libsigrok $end
$var wire 1 ! D0 $end
$var wire 1 " my pin $end
$upscope $end
$enddefinitions $end
#0 0! 1"
#17 1!
#20 0! 0"
#33
"""
MODELSIM = """\
$date
\tSun Nov 22 12:00:00 2026
$end
$version
\tModelSim Version 10.1
$end
$timescale
\t1ps
$end

$scope module tb $end

$scope module dut $end
$var wire 1 ! D0 $end
$var reg 2 " state [1:0] $end
$var integer 32 # i $end
$upscope $end
$upscope $end
$enddefinitions $end
#0
$dumpvars
0!
bx "
b0 #
$end
#17000000
1!
b1 "
#20000000
0!
#33000000
"""
VERILATOR = """\
$version Generated by VerilatedVcd $end
$timescale   1ps $end

 $scope module TOP $end
  $var wire  1 # D0 $end
  $scope module top $end
   $var wire  1 # D0 $end
   $var wire 32 $ count [31:0] $end
  $upscope $end
 $upscope $end
$enddefinitions $end


#0
0#
b00000000000000000000000000000000 $
#17000000
1#
b00000000000000000000000000000011 $
#20000000
0#
#33000000
"""
GTKWAVE = """\
$date Sun Nov 22 12:00:00 2026 $end
$version GTKWave Analyzer v3.3.118 (w)1999-2023 BSI $end
$timescale 1ns $end
$attrbegin misc 07 "" 1 $end
$scope module x $end
$var wire 1 ! D0 $end
$var string 1 " text $end
$upscope $end
$enddefinitions $end
$dumpvars
0!
sidle "
$end
#17000
1!
sgo\\040on "
#20000
0!
#33000
"""
ANALYSER = """\
$timescale 1 us $end
$scope module logic $end
$var wire 1 ! D0 $end
$upscope $end
$enddefinitions $end
#0
$dumpvars
0!
#17
1!
#20
0!
#33
"""


@rows("text", [SIGROK, MODELSIM, VERILATOR, GTKWAVE, ANALYSER])
def test_files_of_other_programs(parse, text):
    found = parse(text)
    name = "TOP.D0" if text is VERILATOR else "D0"
    assert edges(found, name) == [(17_000_000, 1), (20_000_000, 0)] and found.stop_ps == 33_000_000
    if text is SIGROK:
        assert found.names == ("libsigrok.D0", "libsigrok.my pin")
        assert edges(found, "my pin") == [(20_000_000, 0)]
    if text is MODELSIM:
        assert edges(found, "tb.dut.state") == [(17_000_000, 1)] and found.width("i") == 32
    if text is VERILATOR:
        assert found.names == ("TOP.D0", "TOP.top.D0", "TOP.top.count") and found.level_at("count", "1 s") == 3
    if text is GTKWAVE:
        assert edges(found, "text") == [(17_000_000, "go on")]


# ----------------------------------------------------------------------------------------- the same edges, as written
def rounded(rig, name, unit, stop):
    """The edges of a net as a file in this unit has them."""
    changes = {}
    for ps, level in rig.edges(name, 0, stop):
        changes[ps // unit * unit] = level
    before = rig.recorder.level(rig.nets[name], unit - 1)
    out = []
    for ps, level in changes.items():
        if ps and level != before:
            out.append((ps, level))
        before = level
    return out


@rows("timescale", TIMESCALES)
@rows("seed", range(2))
def test_edges_of_our_writer(lively, tmp_path, seed, timescale, monkeypatch):
    monkeypatch.setattr(module, "BLOCK", (1 << 20, 100)[seed])
    rig = lively(seed, events=60)
    rig.kernel.run(80_000_000)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 80_000_000, timescale)
    found = slewline.read_vcd(tmp_path / "a.vcd")
    unit = TIMESCALES[timescale]
    assert found.timescale_ps == unit
    for name in rig.nets:
        assert edges(found, name) == rounded(rig, name, unit, 80_000_000)
        assert found.level_at(name, 0) == rig.recorder.level(rig.nets[name], min(unit - 1, 80_000_000))


UNCHECKED = HealthCheck.function_scoped_fixture, HealthCheck.too_slow
changes_of = st.lists(
    st.tuples(st.integers(0, 10**7), st.integers(0, 2), st.sampled_from([0, 1, -1])), min_size=1, max_size=40
)


@given(changes=changes_of, timescale=st.sampled_from(list(TIMESCALES)[:9]), block=st.integers(1, 60))
@settings(max_examples=25, suppress_health_check=UNCHECKED)
def test_any_edges_of_our_writer(lively, changes, timescale, block, tmp_path):
    rig = lively(0, count=0, events=0)
    for number in range(3):
        rig.recorder.record(rig.net(f"x.n{number}"))
    for ps, number, level in sorted(changes, key=lambda change: change[0]):
        rig.on(ps, **{f"x_n{number}": None if level < 0 else level})
    rig.kernel.run(2 * 10**7)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 2 * 10**7, timescale)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "BLOCK", block)
        found = slewline.read_vcd(tmp_path / "a.vcd")
    for name in rig.nets:
        assert edges(found, name) == rounded(rig, name, TIMESCALES[timescale], 2 * 10**7)


def test_edges_of_pyvcd(parse):
    file, expected = io.StringIO(), {"a.bit": [], "a.b.bus": [], "a.speed": [], "a.text": []}
    with VCDWriter(file, timescale="10 us", date="today") as writer:
        bit = writer.register_var("a", "bit", "wire", size=1, init="x")
        bus = writer.register_var("a.b", "bus", "reg", size=12, init=0)
        speed = writer.register_var("a", "speed", "real", init=0.0)
        text = writer.register_var("a", "text", "string", init="idle now")
        for n in range(1, 200):
            for variable, name, value in (
                (bit, "a.bit", n & 1), (bus, "a.b.bus", n * 19), (speed, "a.speed", n / 8),
                (text, "a.text", f"\\go {n}\n"),
            ):  # fmt: skip
                writer.change(variable, n * n, value)
                expected[name].append((n * n * 10**7, value))
    found = parse(file.getvalue())
    assert {name: edges(found, name) for name in expected} == expected
    assert found.level_at("text", 0) == "idle now" and found.level_at("bit", 0) == -2


@pytest.mark.system
def test_edges_of_sigrok(lively, tmp_path):
    program = shutil.which("sigrok-cli")
    if program is None:
        assert not os.environ.get("CI"), "sigrok-cli is missing; .ci/run installs it"
        pytest.skip("sigrok-cli is not installed")
    rig = lively(3, events=60)
    rig.kernel.run(80_000_000)
    nets = {name: net for name, net in rig.nets.items() if name != "x.db"}
    ours, theirs = tmp_path / "ours.vcd", tmp_path / "theirs.vcd"
    write_vcd(ours, nets, rig.recorder, 0, 80_000_000, "1 ns")
    subprocess.run([program, "-I", "vcd", "-i", ours, "-O", "vcd", "-o", theirs], check=True, capture_output=True)
    first, second = slewline.read_vcd(ours), slewline.read_vcd(theirs)
    assert len(second) == len(nets)
    for name in nets:
        times, levels = first.edges(name)
        expected = real_edges(times, np.maximum(levels, 0), max(first.level_at(name, 0), 0))  # sigrok has two levels
        assert len(expected[0]) > 5
        assert edges(second, name.split(".")[1]) == list(zip(*(column.tolist() for column in expected), strict=True))


# ---------------------------------------------------------------------------------------------------- damaged files
@rows(
    ("old", "new", "line", "message"),
    [
        ("#9\n1!", "#9\n1(", 22, "'1(': identifier '(' is not declared; a $var has it after BITS"),
        ("#9\n1!", "#9\n1", 22, "'1': a level has no identifier"),
        ("#9\n", "#4\n", 21, "'#4': time runs backwards, from #5 to #4"),
        ("#9\n", "#9x\n", 21, "'#9x': '#9x'; a time is # and 1 to 18 digits"),
        ("#9\n", "#\n", 21, "a time is # and"),
        ("#9\n", "#-9\n", 21, "a time is # and"),
        ("#9\n", "#1234567890123456789\n", 21, "a time is # and"),
        ("b101010 ", "b101101010 ", 18, "'b101101010 \"': a value of more bits than its variable has: 8"),
        ("b101010 ", "b1010z0q ", 18, "'b1010z0q'; a value is b and bits, 0 1 x z"),
        ("b101010 ", "bq00000000000000 ", 18, "a value is b and bits"),
        ("b101010 ", "b ", 18, "'b'; a value is b and bits"),
        ("r-1.5e3", "r-1.5e", 19, "'r-1.5e'; a real is r and a number"),
        ("r-1.5e3", "sidle", 19, "'sidle'; a real is r and a number"),
        ("r-1.5e3", "b1", 19, "a value of another kind; this variable is of kind real"),
        ("r-1.5e3 #", 'r-1.5e3 "', 19, "a value of another kind; this variable is of 8 bits"),
        ("0!\n", "0!\nGood\n", 18, "'Good': 'Good' is neither a time (#) nor a value (0 1 x z b r s)"),
        ("0!\n", "0!\n$var wire 1 % a $end\n", 18, "'$var' among the changes; allowed $dumpall, $dumpoff"),
        ("0!\n", "0!\n\0\0\0\n", 18, "byte 0x00; a VCD file is text"),
        ("0!\n", "0!\n\xff\xfe\n", 18, "is neither a time"),
        ("0!\n", "0!\n$comment no end\n", 18, "the file ends within this: it was cut off"),
        ("$var wire 8", "$var wire eight", 4, "expected $var TYPE BITS IDENTIFIER NAME $end"),
        ("$var wire 8", "$var wire 0", 4, "0 bits; allowed 1 to"),
        ("$var wire 8", "$var wire 9999999", 4, "9999999 bits; allowed"),
        ('$var wire 8 "', "$var wire 8 !", 4, "identifier '!' is declared again, with another type or width"),
        ("1 ns", "1 ly", 1, "timescale '1 ly'; expected a number and one of fs, ps, ns, us, ms, s"),
        ("1 ns", "0 ns", 1, "timescale '0 ns'"),
        ("$scope module x", "$timescale 1 us $end $scope module x", 2, "a second $timescale that differs"),
        ("$scope module x $end\n", "", 6, "$upscope without an open $scope"),
        ("$enddefinitions $end", "$enddefinitions", 8, "expected $enddefinitions $end"),
        ("$upscope $end", "$upscope x $end", 7, "expected $upscope $end"),
    ],
)
def test_damage_is_reported_with_line_and_reason(parse, old, new, line, message, tmp_path, monkeypatch):
    assert old in SMALL
    text = SMALL.replace(old, new, 1).encode("latin-1")
    for block in (1 << 20, 11):
        monkeypatch.setattr(module, "BLOCK", block)
        with pytest.raises(WaveformError) as error:
            parse(text)
        assert str(error.value).startswith(f"{tmp_path}/a.vcd, line {line}: ")
        assert message in str(error.value)


@rows(
    ("begin", "message"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"\x1f\x8b\x08\x00", "not a VCD file: compressed (gzip); unpack it with gunzip"),
        (b"PK\x03\x04", "sigrok-cli -i FILE.sr -O vcd -o FILE.vcd"),
        (b"\0\0\0\0\0\0\0\x01\x49\0\0", "fst2vcd FILE.fst > FILE.vcd"),
        (b"\x13\x80\0", "lxt2vcd"),
        (b"GHDLwave\n", "--vcd=FILE.vcd"),
        (b"Time,STEP\n0,1\n", "its first line is that of a table (CSV)"),
        (b"time_ps,net,level\n0,x,1\n", "a table of the edges of many pins (save_csv); write VCD: --vcd, or save_vcd"),
        (b"time_ps,chip,axis\n0,x,1\n", "a table of steps (--steps, save_steps), without levels; write VCD"),
        (b"Hello, $you\n", "line 1: 'Hello, $you': a VCD file does not begin like this"),
        (b"0!\n1!\n", "line 1: '0!': a VCD file does not begin like this"),
        (b"$date today\n", "line 1: '$date today': $date has no $end: the file is cut off here"),
        (b"$date today $end\n", "declares no variable ($var)"),
        (b"$date today $end\n#0\n#10\n", "declares no variable ($var)"),
    ],
)
def test_invalid_vcd_files(parse, begin, message):
    with pytest.raises(WaveformError) as error:
        parse(begin)
    assert message in str(error.value)


def test_files_that_cannot_be_opened(tmp_path):
    for path in (tmp_path, tmp_path / "none.vcd"):
        with pytest.raises(UsageError, match=r"is a directory; give a regular file|cannot be read: No such file"):
            slewline.read_vcd(path)


def test_a_file_that_was_cut_off(parse):
    """At every byte: either all lines before are read, when asked to, or it is said that it was cut."""
    body = SMALL.index("#1\n")
    for cut in range(body + 1, len(SMALL), 5):
        text = SMALL[:cut]
        torn = parse(text, torn=True)
        whole = text[: text.rindex("\n") + 1]
        assert [edges(torn, name) for name in torn] == [edges(parse(whole), name) for name in torn]
        if text.endswith("\n"):
            continue
        with pytest.raises(
            WaveformError, match=r"line \d+: .*cut off; torn=True, or --torn, reads what is before the cut"
        ):
            parse(text)


def test_a_file_that_was_cut_off_among_its_declarations(parse):
    """Behind a whole declaration too: else signals would be missing, and nothing would say so."""
    first = SMALL.index("$var")
    ends = [at for at in range(first, SMALL.index("$enddefinitions")) if SMALL.startswith("$end", at)]
    assert len(ends) > 3
    for cut in (end + len(behind) for end in ends for behind in ("$end", "$end\n")):
        with pytest.raises(
            WaveformError, match=r"line \d: '\$.*\$end': the file ends among its declarations: it was cut"
        ):
            parse(SMALL[:cut])
        assert 1 <= len(parse(SMALL[:cut], torn=True).names) <= 4
    assert len(parse(SMALL[: SMALL.index("#1\n")]).names) == 4, "no changes, but all declarations"


def test_a_time_beyond_an_array_of_picoseconds(parse):
    text = SMALL.replace("1 ns", "100 s").replace("#12", "#92234")
    with pytest.raises(WaveformError, match=r"a\.vcd: a time is too large; allowed less than 2\^63 ps"):
        parse(text)
    assert parse(text.replace("#92234", "#92233")).stop_ps == 92233 * 10**14


@given(data=st.data(), count=st.integers(1, 4), block=st.sampled_from([13, 1 << 20]))
@settings(max_examples=60, suppress_health_check=UNCHECKED)
def test_damage_of_any_kind_raises_our_error_or_is_harmless(parse, data, count, block):
    text = bytearray(data.draw(st.sampled_from([SMALL, SIGROK, VERILATOR, GTKWAVE])).encode())
    for _ in range(count):
        at = data.draw(st.integers(0, len(text) - 1))
        what = data.draw(
            st.one_of(st.binary(max_size=3), st.sampled_from([b"$end", b" ", b"\n", b"#", b"b", b"s s", b"!"]))
        )
        text[at : at + data.draw(st.integers(0, 5))] = what
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "BLOCK", block)
        try:
            found = parse(bytes(text), torn=data.draw(st.booleans()))
        except SlewlineError as error:
            assert "a.vcd" in str(error)
            return
    for name in found:
        times, levels = found.edges(name)
        assert len(times) == len(levels) and (np.diff(times) > 0).all()
        assert not len(times) or (found.start_ps < times[0] and times[-1] <= found.stop_ps)


# ------------------------------------------------------------------------------------- steps and pictures
def test_steps_of_a_measured_pulse_and_direction(tmp_path):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.pulse", "x.direction")
    bench.host(x).send("A 0\rF 10\rR 60\rS 240\rZ 1\rN 40\rG\r-\rN 10\rG\r")
    bench.run_until_idle()
    bench.save_vcd(tmp_path / "a.vcd", timescale="1 ps")
    found = slewline.read_vcd(tmp_path / "a.vcd")
    steps, model = found.steps("pulse", "direction"), x.steps()
    assert len(model) == 50 and set(model.directions.tolist()) == {1, -1}
    assert steps.times_ps.tolist() == model.times_ps.tolist()
    assert steps.directions.tolist() == model.directions.tolist()
    assert steps.positions.tolist() == model.positions.tolist()
    other = found.steps("pulse", "direction", forward=0, position=100)
    assert other.positions.tolist() == [100 - position for position in steps.positions.tolist()]
    rising = found.steps("pulse", edge="rising")
    assert len(rising) == 50 and (rising.times_ps > steps.times_ps).all() and rising.positions[-1] == 50


def test_steps_begin_with_known_levels(parse):
    text = "$timescale 1 us $end $var wire 1 ! p $end $var wire 1 % d $end $enddefinitions $end\n"
    text += "#0 x%\n#1\n0!\n#2\n1!\n#3\n0!\n0%\n#4 z! #5 0! #6 1!\n#7\n0!\n1%\n"
    found = parse(text)
    with pytest.raises(UsageError, match="p is floating or unknown from 4 µs, so a step may be missed"):
        found.steps("p")
    assert found.steps("p", idle=1).times_ps.tolist() == [1_000_000, 3_000_000, 5_000_000, 7_000_000]
    assert found.steps("p", idle=0).times_ps.tolist() == [1_000_000, 3_000_000, 7_000_000]
    with pytest.raises(UsageError, match="d is floating or unknown at the step at 1 µs"):
        found.steps("p", "d", idle=0)
    known = parse(text.replace("#0 x%", "#0 1%"))
    assert known.steps("p", "d", idle=0).directions.tolist() == [1, -1, 1]  # an edge of both at once: the new direction
    with pytest.raises(UsageError, match="idle=2: allowed 0, 1 or None"):
        found.steps("p", idle=2)
    with pytest.raises(UsageError, match="edge='up', forward=1: allowed: edge 'falling', 'rising'"):
        found.steps("p", edge="up")
    with pytest.raises(UsageError, match="db has 8 bits; name one of them"):
        parse(SMALL).steps("db")
    assert len(parse(SMALL).steps("slew", edge="rising")) == 1


def test_trace_for_a_picture(parse):
    small = parse(SMALL + "#20\nx!\n")
    trace = small.trace("x.slew")
    assert (trace.name, trace.level, trace.bus) == ("slew", 1, False)
    assert (trace.times_ps.tolist(), trace.levels.tolist()) == ([5000, 9000, 20_000], [0, 1, -1])
    bus = small.trace("db", name="data", shift="-2 ns")
    assert (bus.name, bus.level, bus.bus) == ("data", -1, True)
    assert (bus.times_ps.tolist(), bus.levels.tolist()) == ([3000, 7000], [42, 3])
    assert small.trace("slew", shift=5).times_ps[0] == 5005
    with pytest.raises(UsageError, match="speed is a real variable"):
        small.trace("speed")


@pytest.mark.parametrize(
    ("begin", "says"),
    [
        (b"", "a binary file, not a readable recording; export VCD or CSV instead"),
        (b"$timescale 1 ns $end\n", r"no \$enddefinitions in the first 4194304 bytes; check that it is a VCD file"),
        (
            b"$timescale 1 ns $end\n$var wire 1 ! a $end\n$enddefinitions $end\n#0\n1!\n",
            r"line 6: .*: is longer than 4194304 bytes; check that it is a VCD file",
        ),
    ],
)
def test_a_sparse_file_is_not_read_completely(tmp_path, monkeypatch, begin, says):
    monkeypatch.setattr(module, "LONGEST", 1 << 22)
    monkeypatch.setattr(module, "WORD", 1 << 22)
    path = tmp_path / "x.vcd"
    path.write_bytes(begin)
    os.truncate(path, 1 << 26)
    with pytest.raises(WaveformError, match=says):
        slewline.read_vcd(path)


def test_a_window_that_ends_before_it_begins_is_refused_as_a_bench_refuses_it(parse):
    small = parse(SMALL)
    with pytest.raises(TimeError, match=r"from 5 ns to 1 ns: the window ends before it begins"):
        small.edges("x.slew", "5 ns", "1 ns")
