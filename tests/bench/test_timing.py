"""Timing diagrams of a bench, and the times that the data sheets print, checked on recorded runs."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import slewline
from slewline.chips import PARTS, sheet_of
from slewline.errors import NotRecorded, UnknownName, UsageError
from tests.rows import rows

NS, US, MS = 1000, 10**6, 10**9
BUSES = {"cy525": "db", "mc1451a-e": "hostdata"}


def cy525() -> slewline.Bench:
    """A program, a move with a read-out on the fly, a reset."""
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    bench.record()
    bench.record("x.clk15")
    bench.run("1 ms")
    host.send("C\rE\rB\rC\r0\rQX\r")
    bench.run_until_idle()
    host.send("A 0\rF 120\rR 127\rS 255\rZ 1\rN 300\rG\r")
    bench.run_until(x.reaches(10))
    host.read_position()
    bench.run_until_idle()
    x.pin("reset").pulse(0, "9 us")
    bench.run("1 ms")
    return bench


def gs_c200s() -> slewline.Bench:
    """A short program, run once, and the counter cleared."""
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps={"br0": 0, "br1": 0, "br2": 0})
    host = bench.host(x)
    bench.record()
    for line in ("Po", "S100", "T1000", "R3", "+20", "E"):
        host.ask(line)
    bench.run_until_idle()
    host.ask("I1")
    bench.run("5 ms")
    return bench


def mc1451a() -> slewline.Bench:
    """Packets, then strobes by hand; the encoder inputs and HOME of all axes; a reset."""
    bench = slewline.Bench()
    x = bench.add("mc1451a-e", name="x")
    host = bench.host(x)
    bench.record()
    host.command("SET_POS", 12345)
    host.query("GET_POS")
    for axis in range(1, 5):
        for pin in (f"quada{axis}", f"quadb{axis}"):
            x.pin(pin).drive(1)
            bench.run("800 ns")
        for pin in (f"quada{axis}", f"quadb{axis}"):
            x.pin(pin).drive(0)
            bench.run("800 ns")
        x.pin(f"home{axis}").pulse(0, "480 ns")
        bench.run("1 us")
    x.pin("reset").pulse(0, "1 us")
    bench.run("10 us")
    return bench


RUNS = {"cy525": cy525, "gs-c200s": gs_c200s, "mc1451a-e": mc1451a}
LATE = [
    (f"host{strobe} falls", change) for strobe in ("read", "write") for change in ("hostslct falls", "hostcmd changes")
]
NOT_THERE = {
    ("mc1451a-e", *edges) for edges in LATE
}  # of a host that selects behind its strobe: see those by hand below


@cache
def recorded(part: str) -> slewline.Bench:
    """The bench of a part behind its run; nobody lets time pass on it any more."""
    return RUNS[part]()


@pytest.fixture(params=RUNS)
def run(request):
    return request.param, recorded(request.param)


# ------------------------------------------------------------------------------------------------------ printed limits
@rows("part", PARTS)
def test_every_limit_is_between_pins_of_the_part(part):
    sheet = sheet_of(part)
    names = {pin.name: pin for pin in sheet.pins if pin.in_out in ("in", "out", "both")}
    for limit in sheet.limits:
        assert limit.least or limit.typical or limit.most
        assert limit.where
        assert limit.description
        levels = (*limit.given, *limit.before)
        for edge in (limit.start, limit.end, *(f"{pin} falls" for pin, level in levels if level in (0, 1))):
            pin, change = edge.split()
            if pin == sheet.bus:
                assert change in ("changes", "appears", "vanishes")
            else:
                assert pin in names, edge
                assert change in ("falls", "rises", "changes")
        least, most = limit.least or 0, limit.most or limit.typical or 10**12
        assert most < 0 or least <= (limit.typical or most) <= most
        driver = names.get(limit.end.split()[0])
        if driver is not None:
            assert (limit.keeper == "host") == (driver.way == "in")
    assert len({(limit.start, limit.end) for limit in sheet.limits}) == len(sheet.limits)


def test_every_limit_occurs_in_a_recorded_run_and_is_kept(run):
    part, bench = run
    table = bench.check_timing()
    assert len(table) == len(sheet_of(part).limits)
    unseen = {(part, row.bound.limit.start, row.bound.limit.end) for row in table if not row.count}
    assert unseen == {which for which in NOT_THERE if which[0] == part}
    assert table.violated == ()
    assert "VIOLATED" not in str(table)


@pytest.mark.parametrize("part", ["gs-c200", "mc1151a", "mc1251a-e"])
def test_limits_of_the_sister_parts(part):
    expected = {"gs-c200": 3, "mc1151a": 23, "mc1251a-e": 32}
    assert len(sheet_of(part).limits) == expected[part]


def test_measurements_agree_with_the_edges(run):
    part, bench = run
    checked = 0
    for row in bench.check_timing():
        limit = row.bound.limit
        if limit.given or limit.start.split()[1] not in ("falls", "rises") or limit.start == limit.end:
            continue
        first, second = (edge.split() for edge in (limit.start, limit.end))
        if first[0] != second[0]:
            continue
        times, levels = bench.edges(f"x.{first[0]}")
        widths = np.diff(times)[levels[:-1] == (first[1] == "rises")]
        assert (row.count, row.shortest_ps, row.longest_ps) == (len(widths), widths.min(), widths.max())
        checked += 1
    assert checked == {"cy525": 4, "gs-c200s": 2, "mc1451a-e": 2}[part]


@rows("crystal", ["6 MHz", "11 MHz"])
@rows(("short", "kept"), [(0, True), (1, False)])
def test_a_reset_of_a_cy525_may_be_too_short(crystal, short, kept):
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", crystal=crystal)
    bench.record()
    bench.run("1 ms")
    least = {"6 MHz": 15 * US, "11 MHz": 8_181_818}[crystal]
    x.pin("reset").pulse(0, f"{least - short} ps")
    bench.run("1 ms")
    row = next(row for row in bench.check_timing() if row.bound.limit.start == "reset falls")
    assert (row.kept, row.violations) == (kept, () if kept else (MS,))


# the instants (ns) at which a byte is written: the port selected, HostCmd, data, the strobe, and all taken back
WRITE = {"hostslct": (0, 190), "hostcmd": (0, 190), "hostdata0": (0, 190), "hostwrite": (30, 110)}
READ = {"hostslct": (0, 190), "hostread": (30, 110)}


def ports(*names: str) -> slewline.Bench:
    """Chips whose host ports share all wires but HOSTSLCT, at rest."""
    bench = slewline.Bench()
    chips = [bench.add("mc1451a", name=name) for name in names]
    for name in names[1:]:
        for pin in ("hostwrite", "hostread", "hostcmd", "hostdata"):
            bench.wire(f"{names[0]}.{pin}", f"{name}.{pin}")
    bench.record()
    for chip in chips:
        chip.pin("hostslct").drive(1)
    for pin, level in ("hostwrite", 1), ("hostread", 1), ("hostcmd", 0):
        chips[0].pin(pin).drive(level)
    bench.run("10 ms")
    return bench


def play(bench: slewline.Bench, *pulses: dict[str, tuple[int, int]], chip: str = "x") -> None:
    """Make pins of a chip active from one instant (ns) to another, and wait for a slice."""
    begin, x = bench.now_ps, bench.chips["x"]
    changes = ((at, pin, end) for each in pulses for pin, ends in each.items() for end, at in enumerate(ends))
    for at, pin, end in sorted(changes):
        bench.run_to(begin + at * NS)
        if pin.startswith("hostdata"):
            x.pin(pin).release() if end else x.pin(pin).drive(1)
        else:
            owner = bench.chips[chip] if pin == "hostslct" else x
            owner.pin(pin).drive(end ^ (pin == "hostcmd"))
    bench.run("100 us")


def violated(bench: slewline.Bench) -> set[str]:
    """The symbols of what is violated."""
    return {row.bound.limit.symbol for row in bench.check_timing().violated}


def strobes(*operations: dict[str, tuple[int, int]]) -> set[str]:
    """The symbols of what operations, one slice apart, violate."""
    bench = ports("x")
    for operation in operations:
        play(bench, operation)
    return violated(bench)


@pytest.mark.fact("PMD-HOST-11")
@rows(
    ("symbol", "pin", "end", "kept", "violated"),
    [
        ("t7", "hostslct", 0, 20, 21),
        ("t7", "hostslct", 0, 20, 30),
        ("t7", "hostslct", 0, 20, 31),  # behind the begin of the strobe
        ("t8", "hostcmd", 0, 20, 21),
        ("t8", "hostcmd", 0, 20, 30),
        ("t8", "hostcmd", 0, 20, 79),
        ("t14", "hostwrite", 1, 80, 79),
        ("t15", "hostdata0", 0, 75, 76),
        ("t16", "hostdata0", 1, 140, 139),
        ("t9", "hostcmd", 1, 135, 134),
        ("t6", "hostslct", 1, 125, 124),
        ("t6", "hostslct", 1, 2110, 2111),
    ],
)
def test_a_host_that_is_too_fast_or_too_late_is_found(symbol, pin, end, kept, violated):
    def write(at):
        ends = list(WRITE[pin])
        ends[end] = at
        return {**WRITE, pin: tuple(ends)}

    assert strobes(WRITE) == strobes(write(kept)) == set()
    assert strobes(write(violated)) == {symbol}


def test_a_host_that_reads_may_select_the_port_after_its_strobe():
    late = {**READ, "hostslct": (50, 190)}
    assert strobes(WRITE, READ) == strobes(WRITE, late) == set()
    assert strobes(WRITE, {**late, "hostslct": (51, 190)}) == {"t7"}


@pytest.mark.fact("PMD-HOST-11")
@rows(("symbol", "strobe"), [("t18", "hostwrite"), ("t17", "hostread")])
@rows(("pause", "kept"), [(60, True), (59, False)])
def test_a_host_waits_between_two_strobes_of_a_word(symbol, strobe, pause, kept):
    bench = ports("x")
    play(bench, {**WRITE, "hostdata4": (0, 190)})
    play(bench, {"hostslct": (0, 390), strobe: (30, 110)}, {strobe: (110 + pause, 190 + pause)})
    assert violated(bench) == (set() if kept else {symbol})


@pytest.mark.parametrize(("lasts", "kept"), [("480 ns", True), ("479 ns", False)])
def test_a_home_level_shorter_than_480_ns_is_found_on_each_axis(lasts, kept):
    bench = slewline.Bench()
    x = bench.add("mc1451a", name="x")
    bench.record()
    bench.run("10 ms")
    for axis in range(1, 5):
        x.pin(f"home{axis}").pulse(0, lasts)
        bench.run("1 us")
    found = [row.bound.limit.end for row in bench.check_timing().violated]
    assert found == ([] if kept else [f"home{axis} changes" for axis in range(1, 5)])


def test_strobes_of_another_chip_on_the_same_wires_do_not_count():
    bench = ports("x", "y")
    for chip, strobe in (("x", "write"), ("y", "read"), ("x", "read"), ("y", "write"), ("x", "read")):
        if strobe == "write":
            play(bench, WRITE, chip=chip)
        else:
            play(bench, {"hostslct": (0, 350), "hostread": (30, 110)}, {"hostread": (190, 270)}, chip=chip)
    assert bench.check_timing().violated == ()
    play(bench, {"hostslct": (0, 124), "hostwrite": (30, 110), "hostcmd": (0, 190)}, chip="y")
    assert [row.name for row in bench.check_timing().violated] == ["y t6"]


def test_other_pulses_of_a_cy525_are_not_taken_for_steps():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    bench.record()
    host.send("E\rO 129\rO 130\rO 131\r0\rQX\r")
    bench.run_until_idle()
    assert np.diff(bench.edges("x.pulse")[0][::2]).max() < 103 * US
    assert bench.check_timing().violated == ()


def test_io_select_belongs_to_a_read_out_only_if_it_is_high_in_it():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record()
    host = bench.host(x)
    host.send("A 0\rF 3\rR 3\rZ 1\rS 1\rN 1\rG\r")
    bench.run_until_idle()
    host.send("N 50\rG\r")  # MOTION COMPLETE rises
    bench.run_until(x.reaches(10))
    bench.run("100 us")
    host.port.select.drive(1)
    bench.run("10 us")
    host.port.select.drive(0)  # between two steps: nothing was read
    bench.run_until(x.reaches(15))
    assert bench.check_timing().violated == ()
    host.port.select.drive(1)
    bench.run_until(x.reaches(16))
    bench.run("100 us")
    host.port.select.drive(0)
    bench.run("1 us")
    assert [row.bound.limit.end for row in bench.check_timing().violated] == ["io_select falls"]


def test_limits_without_recorded_pins_are_named():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    with pytest.raises(NotRecorded):
        bench.check_timing()
    bench.record("x.pulse")
    host = bench.host(x)
    host.send("N 3\rG\r")
    bench.run_until_idle()
    found = {row.bound.limit.start: row.verdict for row in bench.check_timing(["x"])}
    assert found["pulse rises"] == "met"
    assert found["reset falls"] == "reset not recorded"
    with pytest.raises(UnknownName, match="allowed x"):
        bench.check_timing(["y"])


def test_a_window_and_pins_recorded_at_different_times():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.record("x.reset")
    bench.run("1 ms")
    x.pin("reset").pulse(0, "1 us")
    bench.run("1 ms")
    bench.record("x.pulse")
    bench.run("1 ms")
    assert [row.bound.limit.start for row in bench.check_timing().violated] == ["reset falls"]
    assert bench.check_timing(start="2 ms").violated == ()
    assert bench.check_timing(stop="0.5 ms").violated == ()


# ------------------------------------------------------------------------------------------------------------ intervals
def test_a_measured_time_is_that_of_the_edges(run):
    part, bench = run
    first, second = {"cy525": ("ready", "pulse"), "gs-c200s": ("rdy", "clock"), "mc1451a-e": ("hostwrite", "hostrdy")}[
        part
    ]
    (found,) = bench.intervals([(f"{first} changes 2", f"{second} falls 2")])
    begin = bench.edges(f"x.{first}")[0][1]
    times, levels = bench.edges(f"x.{second}")
    falls = times[(levels == 0) & (times >= begin)]
    assert (found.start_ps, found.end_ps) == (begin, falls[1])
    assert found.ps == falls[1] - begin
    assert (found.start, found.end) == (f"x.{first} changes", f"x.{second} falls")


def test_an_edge_at_either_boundary_of_the_window_belongs_to_it():
    bench = recorded("cy525")
    times, levels = bench.edges("x.pulse")
    assert levels[:2].tolist() == [0, 1]
    (found,) = bench.intervals([("pulse falls", "pulse rises")], int(times[0]), int(times[1]))
    assert (found.start_ps, found.end_ps) == (times[0], times[1])
    assert labels(bench.timing_figure(["pulse"], int(times[0]), int(times[1])))
    for start, stop in ((times[0] + 1, times[1]), (times[0], times[1] - 1)):
        with pytest.raises(UsageError, match="in the window"):
            bench.intervals([("pulse falls", "pulse rises")], int(start), int(stop))


def test_a_time_carries_the_limit_that_is_printed_for_it(run):
    part, bench = run
    edges = {
        "cy525": ("pulse rises", "pulse falls"),
        "gs-c200s": ("clock falls", "clock rises"),
        "mc1451a-e": ("x.hostread falls", "x.hostdata appears"),
    }[part]
    (found,) = bench.intervals([edges])
    says = {"cy525": "t = 2.545454 µs (min. 2.5 µs: met)", "mc1451a-e": "t10 = 40 ns (max. 50 ns: met)"}
    assert str(found) == says.get(part, "tcpw = 1.7 µs (typ. 1.7 µs, max. 5 µs: met)")
    (other,) = bench.intervals([(edges[0], f"{edges[1]} 2")])
    assert other.bounds == ()  # from an edge to the one after the next is another time
    assert other.kept is None


def test_a_symbol_stands_for_the_time_that_is_nearest_to_its_limit():
    bench = recorded("mc1451a-e")
    (found,) = bench.intervals(["t18"])
    assert (found.ps, found.kept, found.symbol) == (80 * NS, True, "t18")
    assert [each.start for each in bench.intervals(["t13"])] == ["x.hostwrite rises", "x.hostread rises"]
    with pytest.raises(UsageError, match="the data sheet has no time with this symbol; its symbols: t6, t7"):
        bench.intervals(["t99"])
    with pytest.raises(UsageError, match="this time is not in the window"):
        bench.intervals(["t18"], stop="1 ms")


@rows(
    ("between", "says"),
    [
        ([("pulse falls", "run falls 9")], "no 'run falls 9' after 'pulse falls'"),
        ([("run falls 9", "pulse falls")], "there is no 'run falls 9' in the window"),
        ([("pulse falls",)], "expected two edges"),
        ("t14", "expected a list"),
        (14, "expected a list"),
        ([14], "expected two edges"),
        ([("pulse drops", "run falls")], "expected a pin, a change"),
        ([("db falls", "run falls")], "db is a bus; allowed 'changes'"),
    ],
)
def test_unmeasurable_times_are_reported(between, says):
    bench = recorded("cy525")
    with pytest.raises(UsageError, match=says):
        bench.intervals(between)


def test_names_of_chips_and_pins_come_in_lists():
    bench = recorded("cy525")
    for chips in ("x", bench.chips["x"]):
        with pytest.raises(UsageError, match=r"check_timing\(.*\): expected a list of names of chips"):
            bench.check_timing(chips)
    with pytest.raises(UnknownName, match="allowed x"):
        bench.check_timing([bench.chips["x"]])
    with pytest.raises(UsageError, match=r"such as \['x.pulse'\]"):
        bench.timing_figure("x.pulse")


# ------------------------------------------------------------------------------------------------------------- pictures
def labels(figure) -> list[str]:
    return [text.get_text() for text in figure.axes[0].texts if text.get_text()]


def test_lanes_have_the_names_of_the_data_sheet():
    bench = recorded("cy525")
    shown = labels(bench.timing_figure(["io_request", "x.ready", "db"], "1 ms", "1.2 ms", names={"db": "DATA"}))
    assert [text for text in shown if text in ("/I/O REQUEST", "READY", "DATA", "/READY", "DB")] == [
        "/I/O REQUEST",
        "READY",
        "DATA",
    ]
    assert "43 'C'" in shown


def test_a_written_command_has_its_name():
    bench = recorded("mc1451a-e")
    first = int(bench.edges("x.hostwrite")[0][0])
    pins = ["hostcmd", "hostwrite", "hostdata"]
    shown = labels(bench.timing_figure(pins, first - 100 * NS, first + US))
    assert "SET_POS" in " ".join(shown)
    words = labels(bench.timing_figure(pins, first + 50 * US, first + 100 * US))
    assert "SET_" not in " ".join(words)


def test_a_word_that_is_read_is_not_a_command():
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1151a", name="x"))
    bench.record()
    host.command("SET_POS", 0x1000)  # the code of SET_POS is 10, and GET_POS returns this
    host.command("UPDATE")
    bench.run_until_idle()
    assert host.query("GET_POS") == 0x1000
    reads = bench.edges("x.hostread", bench.now_ps - MS)[0]
    shown = " ".join(labels(bench.timing_figure(["hostread", "hostdata"], reads[0] - US, reads[-1] + US)))
    assert "10" in shown.split(), shown
    assert "SET_" not in shown


def test_characters_are_drawn_above_a_serial_line():
    bench = recorded("gs-c200s")
    shown = labels(bench.timing_figure(["rxd", "txd"], stop="20 ms", decode=True))
    assert "".join(shown).startswith("GS-C200SRXDPo")
    begin = int(bench.edges("x.rxd")[0][0])
    later = labels(bench.timing_figure(["rxd"], begin + 2 * MS, begin + 4 * MS, decode=True))
    assert "o" in later
    assert "P" not in later
    halves = labels(bench.timing_figure(["rxd"], begin + 500 * US, begin + 2 * MS, decode=True))
    assert {"P", "o"} <= set(halves)  # the window cuts both
    quiet, plain = (bench.timing_figure(["rxd"], 0, begin - US, decode=decode) for decode in (True, False))
    assert quiet.get_figheight() == plain.get_figheight()  # no room for characters that are not there


def test_a_pin_that_is_measured_gets_a_lane():
    bench = recorded("cy525")
    shown = labels(bench.timing_figure(["ready"], between=[("pulse rises", "pulse falls")], quiet="0 s"))
    assert "/PULSE" in shown


def test_the_file_is_written_and_the_times_are_returned(tmp_path, run):
    part, bench = run
    pin = {"cy525": "pulse", "gs-c200s": "clock", "mc1451a-e": "hostwrite"}[part]
    times = bench.timing(
        tmp_path / "a.svg", [pin], between=[(f"{pin} falls", f"{pin} rises")], title="Widths", dark=True
    )
    assert times == bench.intervals([(f"{pin} falls", f"{pin} rises")])
    text = (tmp_path / "a.svg").read_text("utf-8")
    assert "<title>Widths</title>" in text
    assert f"From x.{pin} falls to x.{pin} rises: {times[0]}." in text
    with pytest.raises(UsageError, match="give a name that ends in"):
        bench.timing(tmp_path / "a.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["a.svg"]


def test_names_that_are_not_recorded_or_not_clear_are_refused():
    bench = slewline.Bench()
    for name in "xy":
        bench.add("cy525", name=name)
    with pytest.raises(NotRecorded):
        bench.timing_figure(["x.ready"])
    bench.record("x.ready", "y.ready", "y.run")
    bench.run("1 ms")
    assert "y: /RUN" in labels(bench.timing_figure(["run", "x.ready"]))
    with pytest.raises(UsageError, match=r"x\.ready or y\.ready"):
        bench.timing_figure(["ready"])
    with pytest.raises(NotRecorded, match=r"x\.run is not recorded"):
        bench.timing_figure(["x.run"])
    with pytest.raises(UnknownName):
        bench.timing_figure(["nonsense"])
