"""Run scripts for modules on a serial line: every line is asked, and what comes next waits for the answer."""

from __future__ import annotations

import json

import pytest

import slewline
from slewline.bench import load
from slewline.bench.scripts.script import run_script
from tests.rows import rows

MS = 10**9
FAST = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
STR = "S10\nT100\nR10\n"
PARTS = ("gs-c200", "gs-c200s")


class Played:
    """A script on a bench with one module, x: `said` is (ps, what) of every line and note."""

    def __init__(self, text, part="gs-c200s", timeout="60 s", **straps):
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", straps=FAST | straps)
        self.host = self.bench.host(self.x)
        self.said = []
        self.host.on_event.add(lambda text: self.said.append((self.bench.now_ps, text)))
        run_script(self.bench, self.host, text)
        self.bench.run_until_idle(timeout)

    @property
    def texts(self):
        return [text for _, text in self.said]

    def when(self, text):
        """The only instant at which something was said."""
        (time,) = [time for time, said in self.said if said == text]
        return time


# -------------------------------------------------------------------------------------------------------------- asking
def test_every_line_is_queried_and_its_answer_is_printed():
    played = Played("F\nPo\nS10\nA4\nx\nA1\nV2\nQ\nPx")
    assert played.texts == [
        "F -> R (ready)",
        "Po -> Y",
        "S10 -> Y",
        "A4 -> E2 (argument missing, wrong or out of range)",
        "x -> E4 (unknown, or not allowed now)",
        "A1 -> Y",
        "V2 -> V70",
        "Q -> S10 A1 END",
        "Px -> Y",
    ]
    assert [found.code for found in played.x.findings] == ["E2", "E4"]


@pytest.mark.parametrize("part", PARTS)
def test_a_script_takes_exactly_the_time_of_a_host_that_queries(part):
    enter = "P" if part == "gs-c200" else "Po"
    played = Played(f"{enter}\n{STR}+50\nE\nF", part)
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps=FAST)
    host = bench.host(x)
    for line in f"{enter}\n{STR}+50\nE\nF".splitlines():
        host.ask(line)
    assert played.when("F -> B (busy)") == bench.now_ps
    bench.run_until_idle()
    assert bytes(played.host.received) == bytes(host.received) == b"Y\rY\rY\rY\rY\rY\rB\r"
    assert (played.x.steps().times_ps == x.steps().times_ps).all() and len(x.steps()) == 50


def test_checksums_and_rate_are_those_of_the_straps():
    played = Played("Po\nT9\nQ", chs=1, br0=1, br1=1, br2=1)
    assert played.texts == ["Po -> Y", "T9 -> Y", "Q -> T9 END"]
    assert bytes(played.host.received) == b"YY\rYY\rT9\x1d\rENDW\r"
    heard = 10**12 * 19 // 2 // 110  # in the middle of the first stop bit of the carriage return
    assert 0 <= played.when("Po -> Y") - (MS + 400 * MS + MS + 200 * MS + heard) < 10**12 // 110 // 16


def test_a_silent_module_is_not_an_answer_and_the_script_continues():
    played = Played("@power off\nF\n@power on\nF")
    assert played.texts == ["power off", "F -> no answer", "power on", "F -> R (ready)"]
    assert played.when("F -> no answer") >= 5000 * MS


def test_a_slow_answer_is_waited_for():
    lines = ["A1"] * 58 + ["C1"]
    played = Played("\n".join(["Po", *lines, "M", "@power off", "@wait 1 ms", "@power on", "X", "Q"]))
    listing = f"Q -> {' '.join(lines)} END"
    assert played.texts[60:] == ["M -> Y", "power off", "power on", "X -> Y", listing]
    assert played.when("M -> Y") - played.when("C1 -> Y") > 1190 * MS


# ----------------------------------------------------------------------------------------------------------- directives
def test_until_ready_polls_until_the_program_ends():
    played = Played(f"Po\n{STR}+1000\nE\n@until ready\n@note over\nV1")
    assert played.texts[6:] == ["F -> R (ready)", "over", "V1 -> V+1000"]
    last = int(played.x.steps().times_ps[-1])
    assert last < played.when("over") < last + 100 * MS
    assert bytes(played.host.received).count(b"B\r") > 10


def test_until_ready_shows_an_overflow():
    played = Played(f"P\n{STR}-1\nE\n@until ready\nF", "gs-c200")
    assert played.texts[-2:] == ["F -> E5 (the position counter overflowed)", "F -> R (ready)"]


def test_ask_is_a_line():
    assert Played("@ask V1\nV1").texts == ["V1 -> V+0", "V1 -> V+0"]


def test_pins_positions_and_notes_as_on_a_bus():
    played = Played(
        f"@drive ui1=0\nPo\n{STR}W1\n-300\nE\n@wait 50 ms\n@drive ui1=1\n@note go\n@until mov=1\n@until position=-200\n"
        "@note there\n@drive enable=0\n@wait 20 ms\n@release enable"
    )
    times = played.x.steps().times_ps
    assert played.when("go") < times[0] and played.when("there") == times[199]
    assert times[200] > played.when("there") + 20 * MS and len(times) == 300


def test_bytes_are_sent_unchanged():
    played = Played("@bytes 56 32\n@bytes 0D\n@bytes 46 0A 0D")
    assert played.texts == [
        "bytes 56 32",
        "bytes 0D",
        "-> V70",
        "bytes 46 0A 0D",
        "-> E2 (argument missing, wrong or out of range)",
    ]


@rows(
    ("line", "found"),
    [
        ("@rate 60", "a directive for a chip on a bus; x (gs-c200s) is on a serial line"),
        ("@live B", "a directive for a chip on a bus"),
        ("@reset", "a directive for a chip on a bus"),
        ("@read position", "a directive for a chip on a bus"),
        ("@verify 0", "a directive for a chip on a bus"),
        ("@until position=8388608", "8388608: allowed -8388608..8388607"),
        ("@until run=0", "x (gs-c200s) has no pin 'run'"),
        ("@power of", "power 'of'; allowed 'on', 'off'"),
        ("@to y", "host serves x, but not y"),
    ],
)
def test_unsuitable_commands_are_refused_with_their_place_before_anything_is_sent(line, found):
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", name="x"))
    with pytest.raises(slewline.ProgramError) as raised:
        run_script(bench, host, f"F\n  {line}\nF", "x.gs-c200s")
    assert str(raised.value).startswith("x.gs-c200s, line 2, column 3: ") and found in str(raised.value)
    assert host.idle


@pytest.mark.parametrize("line", ["@ask V1", "@until ready"])
def test_serial_only_commands_are_refused_on_a_bus(line):
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    with pytest.raises(slewline.ProgramError, match=r"for a module on a serial line; x \(cy525\) has a bus"):
        run_script(bench, host, line)


def test_the_supply_of_a_chip_on_a_bus():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    run_script(bench, bench.host(x), "A 5\n@power off")
    bench.run("20 ms")
    assert not x.powered


def test_a_position_counts_in_the_range_of_the_chip():
    played = Played(f"P\n{STR}+5\nE\n@until position=5\n@note five", "gs-c200")
    assert played.when("five") == played.x.steps().times_ps[-1]
    with pytest.raises(slewline.ProgramError, match=r"-1: allowed 0\.\.9999999"):
        Played("@until position=-1", "gs-c200")


# ------------------------------------------------------------------------------------------------ several, and journals
LINE = """
[[chip]]
part = "gs-c200"
name = "a"
straps = { sel0 = 1, sel1 = 1, sel2 = 0, chs = 1 }

[[chip]]
part = "gs-c200s"
name = "b"
straps = { sel0 = 1, sel1 = 0, sel2 = 1, chs = 1 }

[[host]]
chips = ["a", "b"]
script = ["V1", "@to b", "V1", "Po", "A1", "E", "@until uo1=1", "@to a", "V2", "@to b", "V2"]
"""


def test_a_host_commands_several_modules_of_a_line(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(LINE)
    bench = load(path)
    said = []
    bench["host"].on_event.add(said.append)
    bench.run_until_idle()
    assert said == ["V1 -> V0", "V1 -> V+0", "Po -> Y", "A1 -> Y", "E -> Y", "V2 -> V70", "V2 -> V71"]
    assert bench["a"].findings == bench["b"].findings == []


def test_a_host_of_another_rate_is_not_understood(tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(LINE.replace('"b"]', '"b"]\nbaud = 300'))
    bench = load(path)
    said = []
    bench["host"].on_event.add(said.append)
    with pytest.raises(slewline.Timeout, match="@until uo1=1"):
        bench.run_until_idle("600 s")
    assert said == ["V1 -> no answer", "V1 -> no answer", "Po -> no answer", "A1 -> no answer", "E -> no answer"]


def test_a_journal_repeats_a_script_to_the_bit(tmp_path):
    path = tmp_path / "run.jsonl"
    bench = slewline.Bench(journal=path)
    x = bench.add("gs-c200s", name="x", straps=FAST)
    run_script(
        bench, bench.host(x), f"Po\n{STR}+30\nE\n@drive enable=0@55 ms\n@release enable@90 ms\n@until ready\n@power off"
    )
    bench.run_until_idle()
    again = slewline.replay(path)
    assert again.now_ps == bench.now_ps and not again["x"].powered
    assert (again["x"].steps().times_ps == x.steps().times_ps).all() and len(x.steps()) == 30
    assert bytes(again["host"].received) == bytes(bench["host"].received)
    assert path.read_text().count('"do":"script"') == 1
    assert {json.loads(line)["do"] for line in path.read_text().splitlines()} == {
        "journal",
        "add",
        "host",
        "script",
        "run",
    }
