"""slewline run: what it prints and writes, how it ends, and that a journal repeats it."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from itertools import count, pairwise
from pathlib import Path

import pytest

import slewline
from slewline.cli.main import invoke
from slewline.record import whole_file

KEYS = ["chip", "crystal_hz", "time_ps", "ended", "position", "registers", "pins", "program", "steps"]
KEYS += ["received", "findings"]
BENCH = """
[[chip]]
part = "cy525"
name = "x"

[[chip]]
part = "cy525"
name = "y"
crystal = "6 MHz"

[[host]]
chips = ["x"]
script = ["A 0", "F 3", "R 100", "S 254", "Z 1", "N 5", "G"]
"""


@pytest.fixture
def bench(folder):
    """A bench file with a chip that moves and a chip that does not."""
    Path("bench.toml").write_text(BENCH)
    return "bench.toml"


def by_hand(text, crystal=None):
    """The same program without the command line."""
    bench = slewline.Bench()
    chip = bench.add("cy525", crystal=crystal)
    bench.host(chip).send(text)
    bench.run_until_idle()
    return bench, chip


FIVE = "F 3\rR 100\rS 254\rZ 1\rA 0\rN 5\rG\r"


# ----------------------------------------------------------------------------------------------------------------- JSON
def test_json_is_one_object_with_exactly_the_agreed_keys(call, five):
    ran = call("run", five, "--json", "-")
    bench, chip = by_hand(FIVE)
    times = [int(time) for time in chip.steps().times_ps]
    assert (ran.status, ran.err, list(ran.json)) == (0, "", KEYS)
    assert ran.json == {
        "chip": "cy525",
        "crystal_hz": 11_000_000,
        "time_ps": bench.now_ps,
        "ended": "idle",
        "position": 5,
        "registers": {"number": 5, "slope": 254, "rate": 100, "firstrate": 3, "divisor": 1, "position": 5},
        "pins": {row.name: chip.pin(row.name).level for row in chip.sheet.pins if row.in_out not in ("power", "none")},
        "program": "",
        "steps": {
            "count": 5,
            "first_ps": times[0],
            "last_ps": times[-1],
            "min_interval_ps": min(b - a for a, b in pairwise(times)),
        },
        "received": "",
        "findings": [],
    }
    assert ran.json["pins"]["motion_complete"] == 0
    assert ran.json["pins"]["db0"] is None, "nothing drives the bus"


def test_json_shows_program_read_outs_and_findings(call, write):
    program = write("p.cy525", "A 700", "E", "C", "0", "Q", "R 200", "V 0", "@verify 0", "@verify 1")
    found = call("run", program, "--json", "-").json
    assert found["program"] == "4300"
    assert bytes.fromhex(found["received"]) == b"00700" + bytes([0x43]) + bytes(47)
    assert [(one["source"], one["code"]) for one in found["findings"]] == [("cy525", "range")]
    assert found["findings"][0]["time_ps"] > 0 and "200" in found["findings"][0]["text"]


def test_no_step_has_no_times(call, write):
    assert call("run", write("p.cy525", "A 0"), "--json", "-").json["steps"] == {
        "count": 0,
        "first_ps": None,
        "last_ps": None,
        "min_interval_ps": None,
    }


@pytest.mark.parametrize("window", [10**8, 3_333_363_636, 10**10])
def test_steps_are_counted_across_windows(call, write, monkeypatch, window):
    program = write("p.cy525", "A 0", "F 3", "R 40", "S 250", "Z 1", "N 30", "G")
    whole = call("run", program, "--json", "-").json["steps"]
    monkeypatch.setattr("slewline.cli.report.WINDOW_PS", window)
    assert whole["count"] == 30 and whole["min_interval_ps"] < 3 * 10**9
    assert call("run", program, "--json", "-").json["steps"] == whole


def test_json_goes_to_a_file_in_addition_to_the_transcript(call, five):
    ran = call("run", five, "--json", "x.json")
    assert "MOTION COMPLETE at 5" in ran.out and ran.out.endswith("wrote x.json\n")
    assert json.loads(Path("x.json").read_text()) == call("run", five, "--json").json


def test_json_of_a_bench_has_an_object_for_every_chip(call, bench):
    found = call("run", bench, "--json", "-").json
    assert {name: list(chip) for name, chip in found["chips"].items()} == {"x": KEYS, "y": KEYS}
    assert [chip["position"] for chip in found["chips"].values()] == [5, 42330]
    assert [chip["crystal_hz"] for chip in found["chips"].values()] == [11_000_000, 6_000_000]


# ---------------------------------------------------------------------------------------------------------- how it ends
def test_until_stops_at_that_very_instant(call, endless):
    ran = call("run", endless, "--until", "50.000001 ms", "--json", "-")
    assert (ran.status, ran.json["ended"], ran.json["time_ps"]) == (0, "until", 50_000_001_000)


def test_until_zero_is_an_instant_too(call, five):
    assert call("run", five, "--until", "0 s", "--json", "-").json["time_ps"] == 0


def test_a_time_out_names_the_waiting_task_and_still_writes_the_result(call, write):
    program = write("p.cy525", "A 0", "W", "B")
    ran = call("run", program, "--timeout", "2 s", "--drive", "wait=0", "--json", "-")
    assert (ran.status, ran.json["ended"], ran.json["time_ps"]) == (1, "timeout", 2 * 10**12)
    assert "slewline: timed out: waited 2 s for all queues to be empty and all chips idle" in ran.err
    assert "cy525: waiting for wait=1 (W) since" in ran.err


def test_the_time_out_is_sixty_seconds(call, write):
    endless = write("endless.cy525", "E", "D 60000", "J 0", "QX")
    assert call("run", endless, "--json", "-").json["time_ps"] == 60 * 10**12


@pytest.mark.parametrize(("options", "status"), [([], 0), (["--strict"], 1)])
def test_findings_are_a_problem_if_strict(call, write, options, status):
    ran = call("run", write("p.cy525", "R 200"), *options)
    assert ran.status == status
    assert "! range: RATE 200: allowed 0..127" in ran.out


def test_strict_and_quiet_still_report_the_findings(call, write):
    ran = call("run", write("p.cy525", "R 200"), "-q", "--strict")
    assert (ran.status, ran.out) == (1, "")
    assert "cy525  range: RATE 200" in ran.err


@pytest.mark.parametrize(
    ("lines", "said"), [(("R 200",), "1 finding;"), (("R 200", "R 201"), "2 findings;"), (("R 5",), "")]
)
def test_quiet_counts_the_findings(call, write, lines, said):
    ran = call("run", write("p.cy525", *lines), "-q")
    assert (ran.status, ran.out) == (0, "")
    assert ran.err.startswith(f"slewline: {said} the transcript without -q shows them") if said else ran.err == ""


def test_strict_is_content_without_findings(call, five):
    assert call("run", five, "--strict").status == 0


def test_a_bench_file_sets_the_duration(call, bench):
    for line, ended, time_ps in (("until", "until", 3 * 10**9), ("timeout", "timeout", 3 * 10**9)):
        Path(bench).write_text(f'[bench]\n{line} = "3 ms"\n{BENCH}')
        found = call("run", bench, "--json", "-").json["chips"]["x"]
        assert (found["ended"], found["time_ps"]) == (ended, time_ps)
    assert call("run", bench, "--timeout", "1 s", "--json", "-").json["chips"]["x"]["ended"] == "idle"


def test_loops_without_time_are_a_problem_of_the_run(call, write, monkeypatch):
    monkeypatch.setattr("slewline.core.time.kernel.ROUNDS_LIMIT", 1000)
    write("b.toml", "[[chip]]", 'part = "cy525"', 'name = "x"', "[[part]]", 'kind = "inverter"', 'name = "i"')
    with open("b.toml", "a") as file:
        file.write('[[wire]]\nfrom = "i.out"\nto = "i.in1"\n')
    ran = call("run", "b.toml")
    assert (ran.status, ran.err.startswith("slewline: ")) == (1, True)
    assert "in a loop without delay" in ran.err


# -------------------------------------------------------------------------------------------------------------- options
def test_drive_puts_levels_on_pins(call, five):
    held = call("run", five, "--drive", "step_inhibit=1", "--drive", "step_inhibit=0@30 ms", "--json", "-").json
    assert 30 * 10**9 < held["steps"]["first_ps"] <= 30 * 10**9 + 3 * 10**6, "the chip looks every 3 us"
    assert held["steps"]["count"] == 5


def test_a_pin_of_a_bench_needs_its_chip(call, bench):
    assert call("run", bench, "--drive", "x.step_inhibit=1", "--timeout", "1 s").status == 1
    ran = call("run", bench, "--drive", "step_inhibit=1")
    assert (ran.status, "give owner and pin" in ran.err) == (2, True)


def test_the_crystal_sets_every_time(call, five):
    fast, slow = (call("run", five, "--crystal", crystal, "--json").json for crystal in ("11 MHz", "5.5 MHz"))
    assert (fast["crystal_hz"], slow["crystal_hz"]) == (11_000_000, 5_500_000)
    assert slow["steps"]["min_interval_ps"] == 2 * fast["steps"]["min_interval_ps"]


def test_a_bench_file_has_its_own_chips_and_crystals(call, bench):
    for option in (["--chip", "cy525"], ["--crystal", "5 MHz"]):
        ran = call("run", bench, *option)
        assert (ran.status, "a bench file names its chips" in ran.err) == (2, True)


def test_the_chip_may_be_named_in_either_form(call, write):
    write("p.CY525", "A 7")
    write("p.txt", "A 7")
    for arguments in (["p.CY525"], ["p.txt", "--chip", "CY525"]):
        assert call("run", *arguments, "--json").json["position"] == 7


def test_a_hex_file_goes_to_a_chip_in_binary_mode(call, five, write):
    write(
        "five.hex", "; the same", "46 01 03", "52 0164", "53 01 FE ; steep", "5A 01 01", "41 02 00 00 4E 02 05 00 47 00"
    )
    ascii, binary = call("run", five, "--json").json, call("run", "five.hex", "--chip", "cy525", "--json").json
    assert (ascii["pins"]["ascii_binary"], binary["pins"]["ascii_binary"]) == (1, 0)
    assert binary["registers"] == ascii["registers"]
    assert binary["steps"]["min_interval_ps"] == ascii["steps"]["min_interval_ps"]
    assert binary["time_ps"] < ascii["time_ps"], "fewer bytes, and no digits to convert"


def test_a_program_may_come_from_the_standard_input(call, monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"A 12\n")))
    assert call("run", "-", "--chip", "cy525", "--json").json["position"] == 12


# -------------------------------------------------------------------------------------------------------------- journal
@pytest.mark.parametrize(
    ("ending", "options"), [("idle", []), ("until", ["--until", "40 ms"]), ("timeout", ["--timeout", "40 ms"])]
)
def test_a_journal_repeats_the_run_to_the_bit(call, write, ending, options):
    program = write("p.cy525", "F 3", "R 20", "S 255", "Z 1", "A 0", "N 65000", "H", "G", "@until slew=0", "@rate 30")
    with open(program, "a") as file:
        file.write("@until position=60\n@drive abort=0\n@until motion_complete=0\n@verify 0\n@pulse wait=0 20 us\nB\n")
    more = ["--drive", "dowhile=0@5.000001 ms"]
    ran = call(
        "run", program, *more, *options, "--journal", "j", "--json", "a.json", "--steps", "a.csv", "--vcd", "a.vcd"
    )
    again = call("run", "--replay", "j", "--json", "b.json", "--steps", "b.csv", "--vcd", "b.vcd")
    assert (ran.status, again.status) == (int(ending == "timeout"), 0)
    first, second = (json.loads(Path(name).read_text()) for name in ("a.json", "b.json"))
    assert first["ended"] == ending and first["steps"]["count"] > 30
    assert second | {"ended": ending} == first
    for kind in ("csv", "vcd"):
        assert Path(f"a.{kind}").read_bytes() == Path(f"b.{kind}").read_bytes()
    shown, repeated = (re.split(r"\n(?:idle|until|timeout) at", called.out)[0] for called in (ran, again))
    assert shown == repeated, "the transcript too"


def test_a_journal_is_repeated_up_to_an_instant(call, write):
    program = write(
        "p.cy525", "A 0", "F 9", "R 60", "S 250", "Z 1", "N 900", "G", "@until motion_complete=0", "@note x"
    )
    call("run", program, "--journal", "j", "--json", "a.json", "--steps", "a.csv")
    again = call("run", "--replay", "j", "--until", "60 ms", "--json", "b.json", "--steps", "b.csv")
    first, second = (json.loads(Path(name).read_text()) for name in ("a.json", "b.json"))
    assert again.status == 0 and "MOTION COMPLETE" not in again.out
    assert (second["ended"], second["time_ps"]) == ("until", 6 * 10**10)
    assert first["position"] == 900 > second["position"] > 0
    whole, part = (Path(name).read_text().splitlines() for name in ("a.csv", "b.csv"))
    assert part == [whole[0], *(line for line in whole[1:] if int(line.split(",")[0]) <= 6 * 10**10)]


def test_a_bench_with_parts_and_two_hosts_is_repeated(call):
    Path("b.toml").write_text("""
[[chip]]
part = "cy525"
name = "x"
[[chip]]
part = "cy525"
name = "y"
[[part]]
kind = "inverter"
name = "not"
[[wire]]
from = "x.programmable_output"
to = "not.in1"
[[wire]]
from = "not.out"
to = "y.wait"
[[host]]
chips = ["x"]
script = ["@wait 20 ms", "C"]
[[host]]
chips = ["y"]
script = ["N 3", "W", "G"]
delay = "100 us"
""")
    ran = call("run", "b.toml", "--journal", "j", "--json", "a.json")
    call("run", "--replay", "j", "--json", "b.json")
    first, second = (json.loads(Path(name).read_text()) for name in ("a.json", "b.json"))
    assert ran.status == 0 and first == second
    assert first["chips"]["y"]["steps"]["first_ps"] > 20 * 10**9, "y waited for x"


# -------------------------------------------------------------------------------------------------------- written files
def test_the_csv_of_steps(call, five):
    call("run", five, "--steps", "x.csv")
    rows = list(csv.reader(Path("x.csv").read_text().splitlines()))
    _, chip = by_hand(FIVE)
    assert rows[0] == ["time_ps", "chip", "axis", "direction", "position"]
    assert rows[1:] == [
        [str(time), "cy525", "1", "1", str(position)]
        for time, position in zip(chip.steps().times_ps, range(1, 6), strict=True)
    ]


def test_a_waveform_has_all_pins_and_every_step(call, five):
    call("run", five, "--vcd", "x.vcd")
    text = Path("x.vcd").read_text()
    name = next(line.split()[3] for line in text.splitlines() if line.startswith("$var") and " pulse " in line)
    lows = [line for line in text.split("$enddefinitions")[1].splitlines() if line == f"0{name}"]
    assert len(lows) == 5
    _, chip = by_hand(FIVE)
    pins = {
        row.name for row in chip.sheet.pins if row.in_out not in ("power", "none") and not row.name.startswith("db")
    }
    named = {line.split()[4] for line in text.splitlines() if line.startswith("$var")}
    wires = {f"db{bit}" for bit in range(8)}
    assert named == pins - {"clk15"} | wires, "the bus as its wires; the clock only when it is asked for"


def variables(path: str) -> list[str]:
    return [line.split()[4] for line in Path(path).read_text().splitlines() if line.startswith("$var")]


def test_a_waveform_of_some_pins(call, five):
    assert (
        call("run", five, "--vcd", "x.vcd", "--pins", "pulse, cy525.db3,direction", "--timescale", "100 ns").status == 0
    )
    assert variables("x.vcd") == ["pulse", "db3", "direction"]
    assert "$timescale 100 ns $end" in Path("x.vcd").read_text()


def test_a_waveform_with_values_buses_and_layouts(call, five):
    ran = call("run", five, "--vcd", "x.vcd", "--vcd-values", "--vcd-buses", "both", "--layout")
    assert (ran.status, ran.err) == (0, "")
    assert {"db", "db0", "velocity", "position", "command", "finding"} <= set(variables("x.vcd"))
    assert all(f"wrote x.{ending}\n" in ran.out for ending in ("vcd", "gtkw", "sucl"))
    assert '[dumpfile] "x.vcd"' in Path("x.gtkw").read_text()


def test_edges_hidden_by_a_timescale_are_reported(call, five):
    ran = call("run", five, "--vcd", "x.vcd", "--pins", "pulse", "--timescale", "100 ms", "-q")
    assert (ran.status, ran.out) == (0, "")
    says = "10 changes of level last less than 100 ms and are not in the file; a finer --timescale shows them"
    assert ran.err == f"slewline: x.vcd: {says}\n"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ("--pins pulse", "--pins: needs --vcd FILE"),
        ("--vcd-values --layout", "--vcd-values, --layout: needs --vcd FILE"),
        ("--vcd x.vcd --timescale 5ns", "timescale '5ns': allowed 1 ps, 10 ps"),
        ("--vcd x.vcd --pins a,,b", "give names of pins separated by commas"),
        ("--vcd x.vcd --pins puls", "has no pin 'puls'; its pins: "),
        ("--vcd x.gtkw --layout", "x.gtkw: give a name that ends in .vcd"),
        ("--vcd x.vcd --layout --json x.sucl", "x.sucl: this command already uses the file"),
        ("--vcd x.vcd --vcd-buses bytes", "'bytes' is not one of"),
    ],
)
def test_waveform_options_that_cannot_be(call, five, options, says):
    ran = call("run", five, *options.split())
    assert ran.status == 2
    assert says in ran.err
    assert not list(Path().glob("x.*"))


def test_a_waveform_of_a_bench_has_what_the_file_records(call, bench):
    Path(bench).write_text(BENCH + '[[record]]\npins = ["x.slew", "x.pulse"]\n')
    call("run", bench, "--vcd", "x.vcd")
    assert Path("x.vcd").read_text().count("$var") == 2


@pytest.mark.parametrize(("name", "magic"), [("x.svg", b"<?xml"), ("x.png", b"\x89PNG")])
def test_plots(call, five, name, magic):
    assert call("run", five, "--plot", name).status == 0
    assert Path(name).read_bytes().startswith(magic)


def test_an_old_file_is_replaced_whole_or_kept(call, five, folder, monkeypatch):
    old = '{"do":"journal","old"'
    for name in ("x.json", "x.csv", "j"):
        Path(name).write_text(old)
    arguments = ["run", five, "--json", "x.json", "--steps", "x.csv", "--journal", "j"]
    assert call(*arguments, "--crystal", "99 MHz").status == 2
    assert {Path(name).read_text() for name in ("x.json", "x.csv", "j")} == {old}
    assert call(*arguments).status == 0
    assert all(Path(name).read_text() != old for name in ("x.json", "x.csv", "j"))
    assert sorted(path.name for path in folder.iterdir()) == ["five.cy525", "j", "x.csv", "x.json"]


def test_a_link_stays_a_link(call, five):
    Path("real.json").write_text("old")
    Path("link.json").symlink_to("real.json")
    call("run", five, "--json", "link.json", "--journal", "j")
    assert Path("link.json").is_symlink() and json.loads(Path("real.json").read_text())["position"] == 5


# ------------------------------------------------------------------------------------------------------------- progress
def test_progress_is_drawn_on_a_terminal_and_changes_nothing(monkeypatch, five, capsys):
    plain = invoke(["run", five, "-q", "--json", "plain.json"])
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("TERM", "xterm")
    assert invoke(["run", five, "-q", "--json", "drawn.json"]) == plain == 0
    assert " of 60 s" in capsys.readouterr().err
    assert Path("plain.json").read_bytes() == Path("drawn.json").read_bytes()


def test_a_torn_journal_is_reported_and_counts_as_a_problem(call, five):
    call("run", five, "--journal", "j")
    whole = Path("j").read_text()
    Path("j").write_text(whole[:-9])
    ran = call("run", "--replay", "j", "-q")
    assert (ran.status, ran.err) == (
        1,
        f"slewline: journal j, line {len(whole.splitlines())}: cut off; the replay ends before it\n",
    )


def test_a_journal_of_other_laws_is_replayed_only_on_demand(call, five):
    call("run", five, "--journal", "j")
    Path("j").write_text(Path("j").read_text().replace('"behaviour":2', '"behaviour":1'))
    refused = call("run", "--replay", "j")
    assert (refused.status, refused.out) == (2, "")
    assert "cy525 had behaviour 1 and now has 2; the run would differ" in refused.err
    played = call("run", "--replay", "j", "--other-laws")
    assert played.status == 0 and "MOTION COMPLETE at 5" in played.out
    assert played.err.startswith("slewline: journal j: made by slewline")
    assert call("run", five, "--other-laws").status == 2


def test_a_journal_replaces_only_a_journal_and_reports_it(call, five):
    call("run", five, "--journal", "j", "-q")
    again = call("run", five, "--journal", "j", "-q")
    assert (again.status, again.err) == (0, "slewline: j: the existing journal is replaced\n")
    Path("j").write_text("my notes\n")
    refused = call("run", five, "--journal", "j")
    assert refused.status == 2 and "is not a journal" in refused.err
    assert Path("j").read_text() == "my notes\n"


def test_links_in_the_place_of_temporary_files_are_not_followed(call, five, monkeypatch):
    """Names of temporary files can be guessed."""
    monkeypatch.setattr(whole_file, "_NUMBERS", count(1))
    for ahead in range(1, 6):
        Path(f".slewline-{os.getpid()}-{ahead}.part").symlink_to("victim")
    assert call("run", five, "--journal", "j", "--vcd", "x.vcd", "-q").status == 0
    assert Path("j").is_file() and Path("x.vcd").is_file()
    assert not Path("victim").exists()


@pytest.mark.parametrize("name", ["x.gtkw", "x.sucl"])
def test_a_link_in_the_place_of_a_layout_is_not_followed(call, five, name):
    Path(name).symlink_to("victim")
    ran = call("run", five, "--vcd", "x.vcd", "--layout")
    assert ran.status == 2 and f"{name} is a symbolic link, which is not followed here" in ran.err
    assert not Path("victim").exists() and not Path("x.vcd").exists()


def test_a_link_that_the_user_names_stays(call, five):
    Path("x.vcd").symlink_to("elsewhere.vcd")
    assert call("run", five, "--vcd", "x.vcd", "-q").status == 0
    assert Path("x.vcd").is_symlink() and Path("elsewhere.vcd").read_text().startswith("$")


def test_a_bench_file_reads_outside_its_folder_only_with_anywhere(call, write, folder):
    (folder / "sub").mkdir()
    write("five.cy525", "A 5")
    write("sub/b.toml", "[[chip]]", 'part = "cy525"', "[[host]]", 'file = "../five.cy525"')
    refused = call("run", "sub/b.toml")
    assert refused.status == 2 and "outside the folder of the bench file" in refused.err
    played = call("run", "sub/b.toml", "--anywhere", "--json", "-")
    assert (
        played.status,
        played.json["chips"]["cy525"]["position"] if "chips" in played.json else played.json["position"],
    ) == (0, 5)
    assert call("run", "five.cy525", "--anywhere").status == 2


@pytest.mark.posix
@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "fifo", "--chip", "cy525"],
        ["run", "--replay", "fifo"],
        ["run", "fifo.toml"],
        ["dis", "fifo", "--chip", "cy525"],
        ["lint", "fifo.cy525"],
        ["asm", "fifo.cy525"],
    ],
)
def test_an_input_is_a_regular_file(call, arguments):
    for name in ("fifo", "fifo.toml", "fifo.cy525"):
        os.mkfifo(name)
    called = call(*arguments)
    assert called.status == 2 and "is a FIFO; give a regular file" in called.err


# -------------------------------------------------------------------------------------------------------------- signals
SIGNALS = ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGKILL"]


@pytest.mark.posix
@pytest.mark.system
@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_leaves_no_part_of_a_file_and_after_a_kill_the_next_run_removes_it(call, five, endless, folder, name):
    words = [sys.executable, "-m", "slewline", "run", endless, "--vcd", "x.vcd", "--journal", "j", "--until", "9999 s"]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    try:
        deadline = time.monotonic() + 20
        while not list(folder.glob(".*.part")):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.01)
        assert call("run", five, "--vcd", "y.vcd", "-q").status == 0  # another process leaves it alone
        assert list(folder.glob(".*.part"))
        process.send_signal(getattr(signal, name))
        _, told = process.communicate(timeout=20)
    finally:
        process.kill()
        process.communicate()
    if name == "SIGKILL":
        assert list(folder.glob(".*.part"))
        assert call("run", five, "--vcd", "y.vcd", "-q").status == 0
    else:
        assert (process.returncode, "Traceback" in told) == (1, False), told
        assert told.splitlines()[-1] == "slewline: interrupted; unfinished files are unchanged"
    assert sorted(path.name for path in folder.iterdir()) == sorted([five, endless, "y.vcd"])


@pytest.mark.posix
@pytest.mark.system
def test_a_hangup_that_is_ignored_stays_so(five):
    code = f"""
import signal, sys
signal.signal(signal.SIGHUP, signal.SIG_IGN)
from slewline.cli import main
invoke = main.invoke
main.invoke = lambda words: (signal.raise_signal(signal.SIGHUP), invoke(words))[1]
sys.argv = ["slewline", "run", {five!r}, "-q"]
main.main()
"""
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
