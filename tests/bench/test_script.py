"""Run scripts: every line at its instant, mistakes with their place, hosts side by side."""

from __future__ import annotations

import re

import pytest

import slewline
from slewline.bench.scripts.directives import DIRECTIVES
from slewline.bench.scripts.script import EXAMPLES, read_script, run_script
from slewline.chips.cy525.sheet import SHEET
from slewline.core.time.timebase import picoseconds
from tests.rows import rows

SET_UP = "F 3\nR 20\nS 255\nZ 1\nA 0\n"
SLEWING = SET_UP + "N 65000\nH\nG\n@until slew=0\n"
MS = 10**9


class Played:
    """A script on a bench with one chip, x: `said` is (ps, what) of every line and note."""

    def __init__(self, text, timeout="60 s", run=True, **options):
        self.bench = slewline.Bench()
        self.x = self.bench.add("cy525", name="x", **options)
        self.host = self.bench.host(self.x)
        self.said = []
        self.host.on_event.add(lambda text: self.said.append((self.bench.now_ps, text)))
        run_script(self.bench, self.host, text)
        if run:
            self.bench.run_until_idle(timeout)

    def when(self, text):
        """The only instant at which something was said."""
        (time,) = [time for time, said in self.said if said == text]
        return time


# ------------------------------------------------------------------------------------------------------------ the guide
def test_the_guide_shows_every_directive_and_each_example_can_be_read():
    assert {verb for _, verb in EXAMPLES} == set(DIRECTIVES)
    text = "\n".join(example for example, _ in EXAMPLES)
    assert len(EXAMPLES) == 22 and read_script(text).problems == ()


# ------------------------------------------------------------------------------------------------------------- commands
@rows(
    ("line", "sent"),
    [
        ("R 80", b"R 80\r"),
        ("A$P 40", b"A$P 40\r"),
        ("A$B$P 40", b"A$B$P 40\r"),
        ("A$", b"A$"),
        ("Q", b"Q"),
        ("QX", b"QX\r"),
        ("QS 20", b"QS 20\r"),
        ("A$Q", b"A$Q"),
        ("no such thing", b"no such thing\r"),
    ],
)
def test_lines_are_sent_as_by_a_host(line, sent):
    assert SHEET.dialect.sent(SHEET, line) == sent


def test_commands_take_exactly_the_time_that_a_plain_host_takes():
    text = SET_UP + "E\nA$P 40\nP 0\n0\nQX\n"
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    bench.host(x).send(text.replace("\n", "\r").replace("QX", "QX"))
    bench.run_until_idle()
    played = Played(text)
    assert played.bench.now_ps == bench.now_ps
    assert (played.x.steps().times_ps == x.steps().times_ps).all()
    assert played.x.program == x.program and played.x.findings == []


def test_while_the_mode_is_binary_commands_are_sent_in_binary():
    played = Played("@drive ascii_binary=0\nR 80\nE\nN 700\nL 3,0\nQ\nS 9")
    assert (played.x.registers["rate"], played.x.registers["slope"]) == (80, 9)
    assert (played.x.program, played.x.findings) == (bytes.fromhex("4E BC 02 4C 03 00"), [])
    assert SHEET.dialect.sent_binary(SHEET, "QX") == b"QX\0"


@pytest.mark.parametrize(("line", "found"), [("r 80", "'r 80' is not a command"), ("A$G", "found a label")])
def test_commands_without_a_binary_form_are_refused_with_their_line(line, found):
    played = Played(f"@drive ascii_binary=0\n{line}", run=False)
    with pytest.raises(slewline.ProgramError, match=rf"script, line 2, column 1: {re.escape(found)}"):
        played.bench.run_until_idle()


def test_mistakes_of_the_host_are_findings():
    assert [found.code for found in Played("R 300\nfoo\nQ").x.findings] == [
        "range",
        "unknown-command",
        "quit-outside-entry",
    ]


# ----------------------------------------------------------------------------------------------------------- directives
def test_wait_lets_exactly_that_time_pass():
    played = Played("A 0\n@note a\n@wait 20 ms\n@note b")
    assert played.when("b") - played.when("a") == 20 * MS


def test_a_directive_begins_when_the_chip_is_ready_again():
    played = Played("E\nB\n0\nQX\n@note runs\n@until run=1\n@note over")
    assert played.when("over") > played.when("runs") > played.when("QX"), "RUN is still high when X has just gone out"
    edges = []
    again = Played("E\nB\n0\nQX\n@until run=1\n@note over", run=False)
    again.x.pin("run").net.watch(lambda net: edges.append((again.bench.now_ps, net.level)))
    again.bench.run_until_idle()
    assert [level for _, level in edges] == [0, 1] and again.when("over") == edges[1][0]


def test_a_directive_after_a_motion_begins_a_millisecond_later():
    for crystal, factor in (("11 MHz", 1), ("5.5 MHz", 2)):
        played = Played(SET_UP + "N 100\nG\n@note moves", crystal=crystal)
        handed_over = played.when("moves") - factor * MS
        assert played.x.position_at(handed_over) == 0
        assert played.when("G") < handed_over < int(played.x.steps().times_ps[0]) < played.when("moves")


def test_until_a_level_and_until_it_is_there_already():
    played = Played(SET_UP + "N 400\nG\n@until slew=0\n@note slews\n@until slew=0\n@note still")
    assert played.when("still") == played.when("slews")
    assert played.x.position_at(played.when("slews")) > 0


@pytest.mark.parametrize("stepwise", [False, True])
def test_until_a_position_ends_with_that_very_step(stepwise):
    played = Played(
        SET_UP + "N 700\nG\n@until position=300\n@note there\n@until position=700\n@note end", stepwise=stepwise
    )
    times = played.x.steps().times_ps
    assert played.when("there") == times[299]
    assert played.when("end") == times[699]


def test_until_a_position_that_is_there_already():
    played = Played("A 40\n@until position=40\n@note there")
    assert played.when("there") == played.bench.now_ps


def test_until_a_position_that_a_program_sets_in_passing():
    played = Played(SET_UP + "E\nP 20\nA 500\nP 510\n0\nQX\n@until position=500\n@note there")
    steps = played.x.steps()
    assert int(steps.times_ps[19]) < played.when("there") < int(steps.times_ps[20])


def test_until_a_position_that_a_new_rate_brings_earlier():
    early = Played(SLEWING + "@rate 100\n@until position=2000\n@note there\n@drive abort=0")
    times, positions = early.x.steps().times_ps, early.x.steps().positions
    assert early.when("there") == int(times[list(positions).index(2000)])


@pytest.mark.parametrize("rate", [20, 3], ids=["with a ramp down", "at once"])
def test_until_a_position_that_an_abort_puts_out_of_reach(rate):
    text = SET_UP.replace("R 20", f"R {rate}") + "N 1000\nG\n@drive abort=0@100 ms\n@until position=900"
    with pytest.raises(slewline.Timeout, match=r"host: at '@until position=900' \(script, line 9\)"):
        Played(text, timeout="5 s")


def test_drive_acts_before_the_next_line():
    played = Played("A 0\n@drive wait=0\n@note a\n@until wait=0\n@note b\n@drive wait=1\nW\n@note c")
    assert played.when("a") == played.when("b")
    assert played.x.pin("wait").level == 1


def test_drive_and_release_at_an_instant():
    played = Played("@drive dowhile=0@5 ms\n@release dowhile@7 ms\nA 0\n@wait 10 ms", run=False)
    edges = []
    played.x.pin("dowhile").net.watch(lambda net: edges.append((played.bench.now_ps, net.level)))
    played.bench.run_until_idle()
    assert edges == [(5 * MS, 0), (7 * MS, 1)]


def test_release_lets_go_of_a_pin():
    played = Played("@drive wait=0\n@until wait=0\n@release wait\n@until wait=1\n@note free")
    assert played.when("free") == 0


def test_a_past_instant_is_refused_with_its_line():
    played = Played("@wait 2 ms\n@drive abort=0@1 ms", run=False)
    with pytest.raises(
        slewline.ProgramError, match=r"script, line 2, column 1: at: 1 ms is in the past; the time is 2 ms"
    ):
        played.bench.run_until_idle()


def test_pulse_has_its_width():
    played = Played("@wait 1 ms\n@pulse wait=0 20 us\n@note at once\n@until wait=1\n@note over")
    assert played.when("over") - played.when("at once") == picoseconds("20 us")


def test_reset_stops_a_motion():
    played = Played(SET_UP + "N 60000\nG\n@wait 10 ms\n@reset\n@wait 1 ms\nB")
    assert 0 < played.x.position < 60000 and played.x.findings == []
    assert len(played.x.steps()) == played.x.travel


def test_live_commands_go_to_a_running_program():
    played = Played(SET_UP + "E\nN 5\nG\nJ 3\nQX\n@wait 30 ms\n@live R 77 | B | 0")
    assert (played.x.registers["rate"], played.x.pin("run").level, played.x.findings) == (77, 1, [])
    assert played.when("live R 77 | B | 0") > 30 * MS


ROUND = SET_UP + "A 0\nN 50\nE\nG\nD 20\nJ 0\nQX\n"


def test_live_verify_reads_from_a_running_program():
    played = Played(ROUND + "@until position=120\n@live V 0 | R 20 | V 3\n@note on\n@live 0")
    time, at = played.when("live V 0 | R 20 | V 3"), played.said.index
    shown = [said for said in played.said if said[1].startswith("verify")]
    assert [text for _, text in shown] == ["verify 0: 00150", "verify 3: 00 32 FF 14 03 01"]
    assert time < shown[0][0] == shown[1][0] <= played.when("on") and at(shown[1]) < at((played.when("on"), "on"))
    assert played.x.findings == []


def test_verify_in_a_running_program_is_refused_with_its_line():
    with pytest.raises(slewline.ProgramError) as raised:
        Played(ROUND + "@wait 30 ms\n@verify 0")
    says = "@until run=1 waits for its end, @live V 0 reads through PROG/LIVE"
    assert f"line {ROUND.count(chr(10)) + 2}, column 1" in str(raised.value) and says in str(raised.value)


def test_until_run_is_1_waits_for_the_end_of_the_program():
    played = Played(SET_UP + "A 0\nN 50\nE\nG\n0\nQX\n@until run=1\n@verify 0\nN 7")
    assert [text for _, text in played.said if text.startswith("verify")] == ["verify 0: 00050"]
    assert played.x.registers["number"] == 7 and played.x.findings == []


def test_rate_changes_on_the_fly():
    played = Played(SLEWING + "@rate 60\n@wait 20 ms\n@drive abort=0")
    times = played.x.steps().times_ps
    assert int((times[1:] - times[:-1]).min()) == 2140 * 10**12 // 11_000_000, "5141 steps/s"
    assert played.said.count((played.when("rate 60 on the fly"), "rate 60 on the fly")) == 1


def test_read_position_on_the_fly():
    played = Played(SLEWING + "@wait 10 ms\n@read position\n@drive abort=0")
    ((time, text),) = [said for said in played.said if said[1].startswith("position")]
    position = int(text.split()[1])
    assert position == played.x.position_at(time) > 5
    assert played.host.received == position.to_bytes(2, "big")


def test_verify_shows_the_bytes_read():
    played = Played(SET_UP + "N 300\nA 12\n@verify 0\n@verify 3")
    assert [text for _, text in played.said if text.startswith("verify")] == [
        "verify 0: 00012",
        "verify 3: 01 2C FF 14 03 01",
    ]


def test_bytes_are_sent_unchanged():
    played = Played("@bytes 52 20 39 0D\n@bytes 53 20 35\n@bytes 0D")
    assert (played.x.registers["rate"], played.x.registers["slope"]) == (9, 5)


def test_to_addresses_another_chip_on_the_bus():
    bench = slewline.Bench()
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    run_script(bench, bench.host(x, y), "A 1\n@to y\nA 2\n@drive wait=0\n@to x\nR 5\n@drive y.dowhile=0")
    bench.run_until_idle()
    assert (x.position, y.position, x.registers["rate"]) == (1, 2, 5)
    assert (x.pin("wait").level, y.pin("wait").level, y.pin("dowhile").level) == (1, 0, 0)


def test_scripts_of_several_hosts_run_side_by_side():
    bench = slewline.Bench()
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    for chip in (x, y):
        run_script(bench, bench.host(chip), ["@wait 5 ms", "F 3", "R 3", "S 255", "Z 1", "N 10", "G"])
    bench.run_until_idle()
    assert (x.steps().times_ps == y.steps().times_ps).all() and len(x.steps()) == 10
    assert 5 * MS < x.steps().times_ps[0] < 15 * MS


def test_two_scripts_of_a_host_play_one_after_the_other():
    played = Played("A 1\n@wait 5 ms", run=False)
    run_script(played.bench, played.host, "A 2\n@note second")
    played.bench.run_until_idle()
    assert played.x.position == 2 and played.when("second") > 5 * MS


# ------------------------------------------------------------------------------------------------------------- mistakes
@rows(
    ("line", "found"),
    [
        ("@foo", "no directive @foo; available: @wait"),
        ("@", "no directive @; available:"),
        ("@wait", "@wait needs an argument"),
        ("@wait 0.5", "time '0.5': expected a number and a unit"),
        ("@wait -3 s", "virtual time does not run backwards"),
        ("@until run", "'run'; expected PIN=LEVEL, position=NUMBER, or ready"),
        ("@until run=2", "level '2'; allowed 0, 1"),
        ("@until position=70000", "70000: allowed 0..65535"),
        ("@until bell=0", "has no pin 'bell'"),
        ("@until z.run=0", "the bench has no 'z'"),
        ("@drive abort=0@", "'abort=0@'; expected PIN=LEVEL or PIN=LEVEL @ TIME"),
        ("@drive abort=0@soon", "time 'soon'"),
        ("@pulse wait=0", "'wait=0'; expected PIN=LEVEL WIDTH"),
        ("@reset now", "@reset takes no argument"),
        ("@live R 20 |", "an empty command"),
        ("@rate 128", "128: allowed 0..127"),
        ("@rate \u0663", "is not printable ASCII"),
        ("@read rate", "read 'rate'; allowed 'position'"),
        ("@verify 4", "4: allowed 0..3"),
        ("@bytes 4", "bytes are pairs of hexadecimal digits"),
        ("@to y", "host serves x, but not y"),
        ("R \u00e4", "'\u00e4' at character 3 is not printable ASCII"),
        ("A\u00a00", r"'\xa0' at character 2 is not printable ASCII; write a space"),
        ("A\t0", r"'\t' at character 2 is not printable ASCII; write a space"),
        ("P \u22123", "at character 3 is not printable ASCII; write -"),
        ("R\u200b 8", r"'\u200b' at character 2 is not printable ASCII; delete this invisible character"),
        ("R\t80", "'\\t' at character 2"),
        ("9" * 1001, "a line of 1001 characters; allowed up to 1000"),
    ],
)
def test_mistakes_are_reported_with_their_place_before_anything_is_queued(line, found):
    bench = slewline.Bench()
    host = bench.host(bench.add("cy525", name="x"))
    with pytest.raises(slewline.ProgramError) as raised:
        run_script(bench, host, f"A 0\n  {line}\nB", "weld.cy525")
    assert str(raised.value).startswith("weld.cy525, line 2, column 3: ") and found in str(raised.value)
    assert len(str(raised.value)) < 1000
    assert not host.queue


def test_all_mistakes_are_reported_together_with_a_picture():
    with pytest.raises(slewline.ProgramError) as raised:
        Played("@foo\nA 0\n  @drive abort=2 ; no\n@until bell=1")
    shown = str(raised.value).split("\n\n")
    assert [text.split(":")[0] for text in shown] == [
        f"script, line {n}, column {c}" for n, c in ((1, 1), (3, 3), (4, 1))
    ]
    assert "      @drive abort=2 ; no\n      ^^^^^^^^^^^^^^\n    write, for example, @drive abort=0" in shown[1]


def test_a_note_may_have_any_text():
    assert Played("@note die T\u00fcr geht auf").said == [(0, "die T\u00fcr geht auf")]


# -------------------------------------------------------------------------------------------------------------- journal
def test_a_script_is_one_entry_of_the_journal_and_is_repeated(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "j")
    x = bench.add("cy525", name="x")
    host = bench.host(x)
    run_script(
        bench,
        host,
        SLEWING + "@rate 40\n@drive abort=0\n@drive abort=1\n@drive abort=0\n@until motion_complete=0\n@verify 0",
    )
    bench.run_until_idle()
    kinds = [line.split('"do":"')[1].split('"')[0] for line in (tmp_path / "j").read_text().splitlines()]
    assert kinds == ["journal", "add", "host", "script", "run"]
    again = slewline.replay(tmp_path / "j")
    assert again.now_ps == bench.now_ps and again["host"].received == host.received
    assert (again["x"].steps().times_ps == x.steps().times_ps).all()


def test_a_run_that_timed_out_is_repeated_completely(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "j")
    run_script(bench, bench.host(bench.add("cy525", name="x")), "@until wait=0")
    with pytest.raises(slewline.Timeout):
        bench.run_until_idle("3 s")
    assert slewline.replay(tmp_path / "j").now_ps == 3 * 10**12
