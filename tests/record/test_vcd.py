"""VCD files: exact bytes, pyvcd as oracle, a tiny reader, streams, and files that are whole or not there."""

from __future__ import annotations

import io
import tracemalloc

import numpy as np
import pytest
from vcd.reader import TokenKind, tokenize
from vcd.writer import VCDWriter

from slewline.core.datasheet.table import Pin
from slewline.core.time.timebase import Clock
from slewline.core.wires.net import Net
from slewline.core.wires.pin import Terminal
from slewline.errors import NotRecorded, UsageError
from slewline.record.recording.recorder import FLOATING, width_of
from slewline.record.waveforms.vcd import TIMESCALES, VcdStream, identifier, write_vcd
from tests.ensembles import few
from tests.rows import rows

SMALL = b"""\
$timescale 1 ns $end
$version slewline $end
$scope module x $end
$var wire 1 ! slew $end
$var wire 8 " db $end
$upscope $end
$scope module y $end
$var wire 1 # wait $end
$upscope $end
$enddefinitions $end
#1
$dumpvars
1!
bz "
z#
$end
#5
0!
b101010 "
#9
b0 "
1#
#10
1!
#12
"""


def small(rig):
    for net in (rig.net("x.slew", pull=1), rig.bus("x.db"), rig.net("y.wait")):
        rig.recorder.record(net)
    rig.on(5_000, x_slew=0, x_db=(255, 42))
    rig.on(9_000, x_db=(255, 0), y_wait=1)
    rig.on(10_999, x_slew=1)
    rig.kernel.run(20_000)
    return rig


def test_small_file_to_the_byte(rig, tmp_path):
    small(rig)
    path = tmp_path / "small.vcd"
    write_vcd(path, rig.nets, rig.recorder, 1_000, 12_000, buses="whole")
    assert path.read_bytes() == SMALL
    assert list(tmp_path.iterdir()) == [path]


def test_window_ends_now_at_the_latest(rig, tmp_path):
    small(rig)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 1_000, 1 << 70, buses="whole")
    assert (tmp_path / "a.vcd").read_bytes() == SMALL.replace(b"#12\n", b"#20\n")


def test_last_change_of_a_unit_counts(rig, tmp_path):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.recorder.record(rig.net("x.run", pull=1))
    for ps, level in ((3_100, 0), (3_200, 1), (7_000, 0), (7_500, 1), (7_999, 0), (8_000, 1)):
        rig.on(ps, x_slew=level)
    rig.on(8_500, x_run=0)
    rig.kernel.run(9_000)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 9_000)
    assert body(tmp_path / "a.vcd") == '#0\n$dumpvars\n1!\n1"\n$end\n#7\n0!\n#8\n1!\n0"\n#9\n'


def test_levels_at_the_start_are_those_at_the_end_of_its_unit(rig, tmp_path):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.on(2_300, x_slew=0)
    rig.on(2_600, x_slew=1)
    rig.on(2_900, x_slew=0)
    rig.on(3_000, x_slew=1)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 2_400, 3_000)
    assert body(tmp_path / "a.vcd") == "#2\n$dumpvars\n0!\n$end\n#3\n1!\n"
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 2_400, 2_800)
    assert body(tmp_path / "a.vcd") == "#2\n$dumpvars\n1!\n$end\n"


def test_wire_of_a_bus(rig, tmp_path):
    small(rig)
    pin = Terminal("x", Pin(15, "db3", "both", "bus"), rig.nets["x.db"])
    pin.bit = 3
    write_vcd(tmp_path / "a.vcd", {"x.db3": pin}, rig.recorder, 0, 20_000)
    assert body(tmp_path / "a.vcd") == "#0\n$dumpvars\nz!\n$end\n#5\n1!\n#9\n0!\n#20\n"


def body(path) -> str:
    return path.read_text().split("$enddefinitions $end\n")[1]


# --------------------------------------------------------------------------------------------------------- oracles
def shown(rig, buses: str) -> dict[str, Net | Terminal]:
    """What the variables of the file are: of a bus every wire, each a pin of its own that is asked for alone."""
    probes = {}
    for name, net in rig.nets.items():
        if net.width == 1 or buses != "bits":
            probes[name] = net
        if net.width == 8 and buses != "whole":
            for bit in range(8):
                probes[f"{name}{bit}"] = pin = Terminal("x", Pin(bit, f"db{bit}", "both", "bus"), net)
                pin.bit = bit
    return probes


def by_pyvcd(rig, start: int, stop: int, timescale: str, buses: str = "bits") -> bytes:
    """What pyvcd writes for the same nets; it is told every change, one at a time."""
    unit, nets = TIMESCALES[timescale], shown(rig, buses)

    def value(net, level):
        return "z" if level == FLOATING else level

    first = min((start // unit + 1) * unit - 1, stop)
    changes = {}
    for order, net in enumerate(nets.values()):
        times, levels = rig.recorder.edges(net, start, stop)
        for ps, level in zip(times.tolist(), levels.tolist(), strict=True):
            if ps > first:
                changes[ps // unit, order] = value(net, level)  # the last of a unit stays
    file = io.StringIO()
    with VCDWriter(file, timescale=timescale, version="slewline", date="", init_timestamp=start // unit) as writer:
        variables = []
        for name, net in nets.items():
            init = value(net, rig.recorder.level(net, first))
            variables.append(writer.register_var(*name.rsplit(".", 1), "wire", size=width_of(net), init=init))
        for (at, order), level in sorted(changes.items()):
            writer.change(variables[order], at, level)
        writer.close(stop // unit)
    return file.getvalue().encode()


def read(data: bytes) -> tuple[dict[str, str], list[tuple[int, str, str]]]:
    """A reader of a few lines: names by identifier, and (time, name, value) in order."""
    names: dict[str, str] = {}
    changes, scopes, now = [], [], -1
    for line in data.decode().splitlines():
        word = line.split()
        if word[0] == "$scope":
            scopes.append(word[2])
        elif word[0] == "$upscope":
            scopes.pop()
        elif word[0] == "$var":
            names[word[3]] = ".".join([*scopes, word[4]])
        elif word[0][0] == "#":
            assert int(word[0][1:]) > now, "times ascend, each is named once"
            now = int(word[0][1:])
        elif word[0][0] == "b":
            changes.append((now, names[word[1]], word[0][1:]))
        elif word[0][0] in "01z":
            changes.append((now, names[word[0][1:]], word[0][0]))
    return names, changes


@rows("timescale", ["1 ps", "10 ps", "1 ns", "100 ns", "1 us", "10 us"])
@rows("seed", range(6))
def test_same_bytes_as_pyvcd(lively, tmp_path, seed, timescale):
    rig = lively(seed, events=80)
    rig.kernel.run(80_000_000)
    start = (0, 12_345_678)[seed % 2]
    buses = ("bits", "whole", "both")[seed % 3]
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, start, 70_000_000)
    write_vcd(tmp_path / "b.vcd", rig.nets, rig.recorder, start, 70_000_000, timescale, buses=buses)
    assert (tmp_path / "b.vcd").read_bytes() == by_pyvcd(rig, start, 70_000_000, timescale, buses)
    assert (tmp_path / "a.vcd").read_bytes() == by_pyvcd(rig, start, 70_000_000, "1 ns")


def test_read_back_in_picoseconds_gives_the_recorded_edges(lively, tmp_path):
    rig = lively(11, events=80)
    rig.kernel.run(80_000_000)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 80_000_000, "1 ps", buses="whole")
    names, changes = read((tmp_path / "a.vcd").read_bytes())
    assert list(names.values()) == list(rig.nets)
    for name in rig.nets:
        values = [(at, -1 if v == "z" else int(v, 2)) for at, what, v in changes if what == name]
        assert values[1:] == rig.edges(name, 1)
        assert values[0] == (0, rig.recorder.level(rig.nets[name], 0))


def test_pyvcd_can_read_it(rig, tmp_path):
    small(rig)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 12_000, buses="whole")
    with open(tmp_path / "a.vcd", "rb") as file:
        tokens = list(tokenize(file))
    assert [t.var.reference for t in tokens if t.kind is TokenKind.VAR] == ["slew", "db", "wait"]
    assert [t.time_change for t in tokens if t.kind is TokenKind.CHANGE_TIME] == [0, 5, 9, 10, 12]
    assert [t.vector_change.value for t in tokens if t.kind is TokenKind.CHANGE_VECTOR] == ["z", 42, 0]


def test_more_nets_than_characters(rig, tmp_path):
    for number in range(200):
        rig.recorder.record(rig.net(f"c{number % 7}.n{number}", pull=number & 1))
    for number, driver in enumerate(rig.drivers.values()):
        rig.kernel.run(rig.kernel.now + (number % 3) * 1000)
        driver.drive(number + 1 & 1)
        rig.kernel.settle()
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 300_000)
    names, changes = read((tmp_path / "a.vcd").read_bytes())
    assert len(names) == 200
    for name in rig.nets:
        assert [(at * 1000, int(v)) for at, what, v in changes if what == name][1:] == rig.edges(name, 1)


def test_identifiers_are_those_of_pyvcd():
    from vcd.writer import _encode_identifier

    numbers = [0, 1, 93, 94, 95, 187, 188, 94 + 94**2 - 1, 94 + 94**2]
    assert [identifier(n) for n in numbers] == ["!", '"', "~", "!!", '"!', "~!", '!"', "~~", "!!!"]
    assert [identifier(n) for n in range(20_000)] == [_encode_identifier(n + 1) for n in range(20_000)]


@pytest.mark.parametrize("unit", ["1 ps", "1 ns", "1 us"])
def test_times_of_all_lengths(rig, tmp_path, unit):
    """Rows are as wide as their times have digits, and change where a digit is added."""
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.recorder.record(rig.net("x.run", pull=1))
    at = [10**n + d for n in range(17) for d in (-1, 0, 1) if 10**n + d > 0]
    for number, ps in enumerate(sorted(set(at))):
        rig.on(ps, x_slew=number & 1, **({"x_run": number >> 1 & 1} if number % 3 else {}))
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 10**17, unit)
    assert (tmp_path / "a.vcd").read_bytes() == by_pyvcd(rig, 0, rig.kernel.now, unit)


# --------------------------------------------------------------------------------------------------------- streams
@pytest.mark.parametrize("timescale", ["1 ps", "1 ns", "1 us"])
@pytest.mark.parametrize("seed", few(range(4), 2))
def test_stream_writes_the_same_bytes_whatever_the_calls(lively, tmp_path, seed, timescale):
    rig, bounded = lively(seed, events=100), lively(seed, events=100, keep=2_000_000)
    with VcdStream(tmp_path / "b.vcd", bounded.nets, bounded.recorder, timescale) as stream:
        for now in range(0, 70_000_001, 437_501):
            bounded.kernel.run(now)
            stream.write_until(now)
            if now % 3 == 0:
                stream.write_until(now - 1000)
        bounded.kernel.run(70_000_000)
        stream.write_until(1 << 62)
    rig.kernel.run(70_000_000)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 70_000_000, timescale)
    assert (tmp_path / "b.vcd").read_bytes() == (tmp_path / "a.vcd").read_bytes()


def test_stream_that_is_closed_immediately_has_the_levels(rig, tmp_path):
    rig.recorder.record(rig.net("x.slew", pull=1))
    rig.kernel.run(7_777)
    VcdStream(tmp_path / "a.vcd", rig.nets, rig.recorder).close()
    assert body(tmp_path / "a.vcd") == "#7\n$dumpvars\n1!\n$end\n"


def test_stream_that_comes_too_late_is_refused_and_leaves_nothing(rig, tmp_path):
    net = rig.net("x.slew", pull=1)
    rig.recorder.record(net, 1_000_000)
    with (
        pytest.raises(NotRecorded, match="recorded from 4 µs on"),
        VcdStream(tmp_path / "a.vcd", rig.nets, rig.recorder) as s,
    ):
        rig.kernel.run(1_000_000)
        s.write_until(1_000_000)
        rig.kernel.run(5_000_000)
        s.write_until(5_000_000)
    assert list(tmp_path.iterdir()) == []


def test_stream_may_be_closed_twice_and_checks_its_nets_immediately(rig, tmp_path):
    small(rig)
    with VcdStream(tmp_path / "a.vcd", rig.nets, rig.recorder, start=1_000, buses="whole") as stream:
        stream.write_until(12_000)
        stream.close()
        assert (tmp_path / "a.vcd").read_bytes() == SMALL
    assert (tmp_path / "a.vcd").read_bytes() == SMALL
    with pytest.raises(NotRecorded):
        VcdStream(tmp_path / "b.vcd", {"x.run": rig.net("x.run")}, rig.recorder)
    assert list(tmp_path.iterdir()) == [tmp_path / "a.vcd"]


def test_stream_that_is_dropped_leaves_nothing(rig, tmp_path):
    rig.recorder.record(rig.net("x.slew", pull=1))
    stream = VcdStream(tmp_path / "a.vcd", rig.nets, rig.recorder)
    assert len(list(tmp_path.iterdir())) == 1
    del stream
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------------------------------------------------- errors
def test_errors_are_clear_and_leave_what_was_there(rig, tmp_path):
    small(rig)
    good = tmp_path / "good.vcd"
    good.write_text("precious")
    pin = rig.nets["x.slew"]
    other = rig.net("x.run")
    cases = [
        (dict(timescale="2 ns"), UsageError, r"timescale '2 ns': allowed 1 ps, 10 ps, 100 ps, 1 ns, "),
        (dict(nets={}), UsageError, "no nets to write"),
        (dict(buses="bytes"), UsageError, "buses 'bytes': allowed 'bits', 'whole', 'both'"),
        (
            dict(nets={"x.slew": pin, "x.db": rig.nets["x.db"], "x.db3": pin}, buses="both"),
            UsageError,
            "'db3' is already the nam",
        ),
        (dict(nets={"x.run": other}), NotRecorded, "x.run is not recorded"),
        (dict(nets={"x.a b": pin}), UsageError, "not a name for a signal in a VCD file"),
        (dict(nets={"x.": pin}), UsageError, "not a name for a signal in a VCD file"),
        (dict(nets={"µ.a": pin}), UsageError, "not a name for a signal in a VCD file"),
        (dict(nets={"x": pin, "slewline.x.y": pin}), UsageError, "'x' is already the name of a variable"),
        (dict(nets={"slewline.x.y": pin, "x": pin}), UsageError, "'x' is already the name of a scope"),
        (dict(start=5, stop=4), UsageError, "ends at 4 ps, before it begins at 5 ps"),
        (dict(path=tmp_path), UsageError, "is a directory"),
        (dict(path=tmp_path / "no" / "a.vcd"), UsageError, "there is no directory '.*no'"),
        (dict(path=good / "a.vcd"), UsageError, "there is no directory '.*good.vcd'"),
        (dict(path=tmp_path / ("n" * 300)), UsageError, "cannot be written: File name too long"),
    ]
    rig.recorder.record(pin)
    nets = {name: net for name, net in rig.nets.items() if name != "x.run"}
    for changed, error, message in cases:
        arguments = dict(path=good, nets=nets, recorder=rig.recorder, start=0, stop=12_000, buses="whole") | changed
        with pytest.raises(error, match=message):
            write_vcd(**arguments)
    assert good.read_text() == "precious"
    assert list(tmp_path.iterdir()) == [good]
    write_vcd(good, nets, rig.recorder, 1_000, 12_000, buses="whole")
    assert good.read_bytes() == SMALL


# ------------------------------------------------------------------------------------------------- memory and speed
class Points:
    """A promise of given edges, as arrays: (n,) int64 ps and (n,) int8."""

    until = None

    def __init__(self, times, levels) -> None:
        self.times, self.levels = times, levels

    def level(self, ps):
        index = int(np.searchsorted(self.times, ps, side="right"))
        return int(self.levels[index - 1]) if index else 1 - int(self.levels[0])

    def after(self, ps):
        index = int(np.searchsorted(self.times, ps, side="right"))
        return int(self.times[index]) if index < len(self.times) else None

    def edges(self, start, stop):
        window = slice(*np.searchsorted(self.times, [start, stop], side="right"))
        return self.times[window], self.levels[window]


def busy(rig, edges: int, span: int, shared: bool):
    """Eight nets of one bit, with so many edges in all; `shared`: those of two nets fall together."""
    random = np.random.default_rng(1)
    for number in range(8):
        rig.recorder.record(rig.net(f"x.n{number}", pull=1))
        if not (shared and number % 2):
            times = np.unique(random.integers(1, span // 1000, edges // 8)) * 1000
        rig.drivers[f"x.n{number}"].play(Points(times, (np.arange(len(times)) % 2).astype(np.int8)))
    rig.kernel.settle()
    rig.kernel.run(span)
    return rig


@pytest.mark.parametrize("shared", [False, True])
def test_many_edges_are_those_of_pyvcd(rig, tmp_path, shared):
    busy(rig, 100_000, 10**10, shared)
    write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, 10**10)
    assert (tmp_path / "a.vcd").read_bytes() == by_pyvcd(rig, 0, 10**10, "1 ns")


def test_long_window_needs_no_more_memory(rig, tmp_path):
    net = rig.net("x.pulse", pull=1)
    rig.recorder.record(net)
    rig.on(0, x_pulse=rig.pulses(Clock(11_000_000), 10, (1137, 1 << 62)))
    rig.kernel.run(300 * 10**12)
    peaks = []
    for seconds in (20, 120):
        tracemalloc.start()
        write_vcd(tmp_path / "a.vcd", rig.nets, rig.recorder, 0, seconds * 10**12)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert (tmp_path / "a.vcd").stat().st_size > 30_000_000
    assert peaks[1] < 1.2 * peaks[0] < 40_000_000
