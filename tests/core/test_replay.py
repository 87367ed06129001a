"""The journal: the same inputs at the same instants give the same run, to the bit, in any order inside a round."""

from __future__ import annotations

import gc
import json
import os
import random

import pytest

import slewline
from slewline.chips import PARTS, sheet_of
from slewline.core.datasheet.table import Sheet, Table
from slewline.errors import BenchFileError, OtherLaws, TornJournal


def story(bench: slewline.Bench) -> dict[str, object]:
    """Everything that a bench tells about its run."""
    bench.run("50 ms")
    chips = {
        name: (
            chip.position,
            chip.travel,
            dict(chip.registers),
            bytes(chip.program),
            chip.steps().times_ps.tolist(),
            chip.waiting,
            [pin.level for pin in chip.pins.values()],
        )
        for name, chip in bench.chips.items()
    }
    return {
        "now": bench.now_ps,
        "chips": chips,
        "findings": [str(found) for found in bench.findings],
        "received": bench["host"].received.hex(),
        "sent": bench["host"].sent,
    }


def busy_run(path) -> dict[str, object]:
    """Two chips; inputs of every kind, before a run, between two runs and in the first round of an instant."""
    bench = slewline.Bench(seed=3, journal=path)
    x = bench.add("cy525", name="x", crystal="11 MHz", rate=40, firstrate=20, slope=250, number=300, position=10)
    y = bench.add("cy525", name="y", crystal="3.579545 MHz", straps={"dowhile": 0}, number=3, firstrate=9, rate=9)
    bench.wire("x.programmable_output", "y.wait", invert=True)
    host = bench.host(x, y, delay="7 us")

    def after(us):
        return bench.now_ps + us * 1_000_000

    # a program on each chip, held in the middle of a step, aborted, given live commands
    assert host.verify(3) == bytes([1, 44, 250, 40, 20, 1])
    host.to("y").send("E\rU\rG\rT 0\r0\rQX\r")
    host.to("x").send("E\rC\rD 2\rB\rG\rX\rQX\r")
    bench.at(after(9000), lambda: x.pin("step_inhibit").drive(1))
    x.pin("step_inhibit").drive(0, at=after(11_000))
    bench.run("20 ms")
    x.pin("abort").pulse(0, "300 us")
    host.live("B", "R 60")
    host.live("V 0")
    # the supply fails in the first round of an instant and comes back between two runs
    bench.at(after(3000), lambda: x.power(False))
    bench.run("5 ms")
    x.power(True)
    x.pin("reset").drive(0, at=after(1000))
    x.pin("reset").drive(1, at=after(11_000))
    bench.run("15 ms")
    # an endless motion with a new rate, a read-out and an abort, and a reset of the other chip
    host.send("R 60\rN 64000\rH\rG\r")
    bench.run_until(x.pin("slew").is_(0))
    host.change_rate(70)
    host.read_position()
    x.pin("abort").drive(0)
    bench.run_until(x.pin("motion_complete").is_(0))
    x.pin("abort").release()
    y.reset()
    bench.run("3 ms")
    bench.at(after(5), lambda: host.to("y").send("A 0\rP 7\r"))
    return story(bench)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    path = tmp_path_factory.mktemp("journal") / "run.jsonl"
    return path, busy_run(path)


def test_the_recorded_run_has_inputs_of_every_kind(recorded):
    path, told = recorded
    entries = [json.loads(line) for line in path.read_text().splitlines()]
    assert {entry["do"] for entry in entries} == {
        "journal",
        "add",
        "host",
        "wire",
        "drive",
        "power",
        "input",
        "run",
    }
    early = [entry["do"] for entry in entries if entry.get("round") == 1]
    assert {"drive", "power", "input"} <= set(early)
    assert told["chips"]["x"][1] != 0
    assert told["chips"]["y"][0] == 7


def test_levels_driven_in_round_one_are_driven_in_round_one_again(tmp_path):
    path = tmp_path / "journal"
    bench = slewline.Bench(journal=path)
    x = bench.add("cy525", name="x")
    for pin, level in (("io_request", 0), ("io_select", 1)):  # seen together: a read-out, not a byte
        bench.at("1 ms", lambda pin=pin, level=level: x.pin(pin).drive(level))
    bench.run("2 ms")
    assert [found.code for found in x.findings] == ["verify-without-v"]
    assert slewline.replay(path)["x"].findings == x.findings


@pytest.mark.parametrize("shuffle", [None, 1, 2, 3, 4])
def test_a_replayed_journal_gives_the_same_run(recorded, shuffle):
    path, told = recorded
    bench = slewline.replay(path, shuffle=shuffle)
    assert story(bench) != told  # it goes on from where the journal ended
    again = slewline.replay(path, shuffle=shuffle)
    again.run = lambda _: None  # the journal has the last stretch already
    assert story(again) == told


def test_a_journal_of_a_replayed_run_is_the_same_journal(recorded, tmp_path):
    path, _ = recorded
    copy = tmp_path / "again.jsonl"
    busy_run(copy)
    assert copy.read_text() == path.read_text()


def test_a_journal_that_was_cut_off_is_good_up_to_its_last_whole_line(recorded, tmp_path):
    path, told = recorded
    lines = path.read_text().splitlines(keepends=True)
    cut = tmp_path / "cut.jsonl"
    cut.write_text("".join(lines[:-1]) + lines[-1][:9])
    with pytest.warns(TornJournal, match=f"line {len(lines)}: cut off; the replay ends before it") as seen:
        bench = slewline.replay(cut)
    assert seen[0].filename == __file__
    bench.run_to(told["now"])
    bench.run = lambda _: None
    assert story(bench) == told


# ------------------------------------------------------------------------------------------------- up to an instant
WATCHED = [f"{name}.{pin}" for name in "xy" for pin in ("ready", "prog", "abort", "pulse", "slew", "phase1", "run")]


def up_to(path, until, **options):
    return slewline.replay(path, until=until, prepare=lambda bench: bench.record(*WATCHED), **options)


def instants(path) -> list[int]:
    """The instants of the inputs of a journal, those just before and behind them, and some between them."""
    at = sorted({json.loads(line)["t"] for line in path.read_text().splitlines()})
    near = {ps + d for ps in at[:: len(at) // 7] for d in (-1, 0, 1)} | {random.Random(5).randrange(at[-1])}
    return sorted(ps for ps in near if ps >= 0)


def test_a_replay_stops_at_an_instant_exactly_as_the_run_was(recorded):
    path, _ = recorded
    whole = up_to(path, None)
    for ps in instants(path):
        part = up_to(path, ps)
        assert part.now_ps == ps
        for pin in WATCHED:
            times, levels = whole.edges(pin, 0, f"{min(ps, whole.now_ps)} ps")
            assert [list(column) for column in part.edges(pin)] == [list(times), list(levels)], (ps, pin)
        assert part.findings == [found for found in whole.findings if found.time_ps <= ps]


def test_a_stopped_replay_is_continued_by_hand(recorded, tmp_path):
    """Back to an instant of an undisturbed run, and from there on another way, or the same."""
    bench = slewline.Bench(journal=tmp_path / "journal")
    x = bench.add("cy525", name="x", firstrate=9, rate=60, slope=250, number=900)
    bench.host(x, name="host").send("A 0\rG\r")
    bench.run("2 s")
    assert x.position == 900
    same, other = (slewline.replay(tmp_path / "journal", until="60 ms") for _ in range(2))
    assert same["x"].moving and same["x"].position == other["x"].position > 0
    other["x"].pin("abort").drive(0)
    for again in (same, other):
        again.run_to("2 s")
    assert list(same["x"].steps().times_ps) == list(x.steps().times_ps)
    assert other["x"].position < 900
    assert same["host"].verify(0) == b"00900"


@pytest.mark.parametrize("shuffle", [None, 1, 2])
def test_inputs_at_the_last_instant_are_put_in_whenever_they_came(tmp_path, shuffle):
    path = tmp_path / "journal"
    bench = slewline.Bench(journal=path)
    x = bench.add("cy525", name="x")
    bench.at("1 ms", lambda: x.pin("abort").drive(0))  # in the first round
    bench.run("1 ms")
    x.pin("wait").drive(0)  # behind the instant
    bench.run("1 ms")

    def levels(until):
        again = slewline.replay(path, until=until, shuffle=shuffle)
        return [again["x"].pin(name).level for name in ("abort", "wait")]

    assert levels("1 ms") == levels(10**9) == [0, 0]
    assert levels(10**9 - 1) == [1, 1]
    assert slewline.replay(path, until=0).now_ps == 0


def test_after_the_end_of_a_journal_time_passes_without_inputs(recorded):
    path, told = recorded
    assert slewline.replay(path, until=told["now"] + 1).now_ps == told["now"] + 1
    with pytest.raises(slewline.errors.TimeError, match="does not run backwards"):
        slewline.replay(path, until="-1 s")


def test_a_journal_that_ends_in_the_first_round_of_an_instant_is_played_to_that_instant(tmp_path):
    path = tmp_path / "journal"
    bench = slewline.Bench(journal=path)
    x = bench.add("cy525", name="x")
    bench.at("1 ms", lambda: x.pin("abort").drive(0))
    bench.run("1 ms")
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))  # killed before the run was over
    again = slewline.replay(path)
    assert (again.now_ps, again["x"].pin("abort").level) == (10**9, 0)


def test_a_furnished_bench_is_prepared_even_if_no_time_passes(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "journal")
    bench.add("cy525", name="x")
    prepared = []
    slewline.replay(tmp_path / "journal", prepare=lambda bench: prepared.append(list(bench.chips)))
    assert prepared == [["x"]]


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "the first line is not the header of a journal"),
        ('{"do":"journal","t":0,"version":99,"seed":0}\n', "the first line is not the header of a journal"),
        (
            '{"do":"journal","t":0,"version":1,"seed":0}\nnonsense\n{"do":"run","t":0,"to":5}\n',
            "line 2: not a journal entry",
        ),
        (
            '{"do":"journal","t":0,"version":1,"seed":0}\n{"do":"drive","t":0,"pin":"x.abort","level":0}\n',
            "line 2: .*no 'x'",
        ),
        ('{"do":"journal","t":0,"version":1,"seed":0}\n{"do":"dance","t":0}\n', "unknown entry 'dance'"),
    ],
)
def test_an_invalid_journal_is_refused_with_its_line(tmp_path, text, match):
    path = tmp_path / "bad.jsonl"
    path.write_text(text)
    with pytest.raises(BenchFileError, match=match):
        slewline.replay(path)


def test_a_journal_that_is_not_there_is_refused():
    with pytest.raises(BenchFileError, match="No such file"):
        slewline.replay("nowhere/run.jsonl")
    with pytest.raises(BenchFileError, match="give a file that can be written"):
        slewline.Bench(journal="nowhere/run.jsonl")


def test_a_journal_that_cannot_be_written_is_named_each_time(tmp_path):
    with pytest.raises(BenchFileError, match="journal /dev/full: No space left on device; give a file"):
        slewline.Bench(journal="/dev/full")
    bench = slewline.Bench(journal=tmp_path / "journal")
    bench.add("cy525", name="x")
    bench.journal.close()
    bench.journal.file = open("/dev/full", "w", buffering=1)  # noqa: SIM115
    for _ in range(2):
        with pytest.raises(BenchFileError, match="journal: No space left on device"):
            bench.run("1 ms")
    del bench
    gc.collect()  # nothing is left to be flushed


# ------------------------------------------------------------------------------------------ by which laws it was made
def short_run(path):
    bench = slewline.Bench(journal=path)
    x = bench.add("cy525", name="x")
    bench.add("gs-c200s", name="y")
    bench.host(x).send("A 0\r")
    bench.run("2 ms")
    return [json.loads(line) for line in path.read_text().splitlines()]


def rewritten(path, entries):
    path.write_text("".join(json.dumps(entry, separators=(",", ":")) + "\n" for entry in entries))
    return path


def test_a_journal_names_the_laws_of_its_run(tmp_path):
    first, *others = short_run(tmp_path / "j")
    assert first["slewline"] == slewline.__version__
    assert [(e["part"], e["behaviour"]) for e in others if e["do"] == "add"] == [("cy525", 2), ("gs-c200s", 2)]
    assert {sheet_of(part).behaviour for part in PARTS} == {1, 2}
    assert [part for part in PARTS if sheet_of(part).behaviour == 1] == ["cy500", "cy512"]


def test_a_custom_chip_has_behaviour_1():
    assert Sheet("mine", "a chip", "none", (), Table()).behaviour == 1


def test_a_journal_of_other_laws_is_replayed_only_on_demand(tmp_path):
    entries = short_run(tmp_path / "j")
    entries[1]["behaviour"] = 3
    entries[0]["slewline"] = "7.0"
    path = rewritten(tmp_path / "other", entries)
    says = f"made by slewline 7.0, this is {slewline.__version__}: cy525 had behaviour 3 and now has 2; the run"
    with pytest.raises(
        BenchFileError,
        match=says
        + r" would differ: replay the journal with the version that made it.*other_laws=True \(--other-laws\)",
    ):
        slewline.replay(path)
    with pytest.warns(OtherLaws, match=says + " may differ"):
        assert slewline.replay(path, other_laws=True).now_ps == 2 * 10**9


def test_a_journal_from_before_there_were_laws_counts_as_behaviour_1(tmp_path):
    entries = short_run(tmp_path / "j")
    del entries[0]["slewline"]
    for entry in entries:
        entry.pop("behaviour", None)
    path = rewritten(tmp_path / "old", entries)
    parts = "cy525 had behaviour 1 and now has 2, gs-c200s had behaviour 1 and now has 2"
    both = f"made by slewline up to 0.1.0, .*: {parts}"
    with pytest.raises(BenchFileError, match=both):
        slewline.replay(path)
    with pytest.warns(OtherLaws, match=both):
        slewline.replay(path, other_laws=True)


def test_another_version_with_the_same_laws_replays_silently(tmp_path):
    entries = short_run(tmp_path / "j")
    entries[0]["slewline"] = "0.9.9"
    slewline.replay(rewritten(tmp_path / "other", entries))


# ---------------------------------------------------------------------------------------------------- what it replaces
def test_a_journal_replaces_a_journal_and_nothing_else(tmp_path):
    path = tmp_path / "j"
    short_run(path)
    slewline.Bench(journal=path)
    assert len(path.read_text().splitlines()) == 1
    for text in ("Dear diary\n", '{"do":"run"}\n'):
        path.write_text(text)
        with pytest.raises(BenchFileError, match="this file exists and is not a journal; name a new file"):
            slewline.Bench(journal=path)
        assert path.read_text() == text
    path.write_text("")
    slewline.Bench(journal=path)


def test_an_instant_below_a_nanosecond_is_replayed(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "j")
    x = bench.add("cy525", name="x")
    x.pin("wait").drive(0, at="5 ps")
    bench.run("7 ps")
    x.pin("wait").drive(1)
    bench.run("2 ps")
    again = slewline.replay(tmp_path / "j")
    assert (again.now_ps, again["x"].pin("wait").level, again["x"].pin("wait").net.changes) == (9, 1, 2)


@pytest.mark.posix
def test_a_journal_does_not_wait_for_the_reader_of_a_fifo(tmp_path):
    os.mkfifo(tmp_path / "fifo")
    with pytest.raises(BenchFileError, match="is a FIFO"):
        slewline.Bench(journal=tmp_path / "fifo")


# ------------------------------------------------------------------------------------------- listeners that interfere
def test_inputs_of_a_listener_precede_their_cause_in_the_journal(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "j")
    x = bench.add("cy525", name="x")
    host = bench.host(x, name="host")

    def answer(do, what):
        if do == "input" and what["args"][1] == list(b"A 5\r"):
            host.send("A 7\r")
            bench.run("1 ms")

    bench.on_input.add(answer)
    host.send("A 5\r")
    bench.run("10 ms")
    again = slewline.replay(tmp_path / "j")
    assert (again.now_ps, again["x"].position) == (bench.now_ps, x.position) == (11 * 10**9, 5)


def test_an_input_that_a_listener_refuses_is_not_in_the_journal(tmp_path):
    bench = slewline.Bench(journal=tmp_path / "j")
    x = bench.add("cy525", name="x")
    bench.on_input.add(lambda do, what: 1 // (do != "drive"))
    with pytest.raises(ZeroDivisionError):
        x.pin("abort").drive(0)
    bench.run("1 ms")
    assert x.pin("abort").level == slewline.replay(tmp_path / "j")["x"].pin("abort").level == 1


@pytest.mark.parametrize("shuffle", [None, 1, 2, 3])
def test_messages_sent_in_one_round_are_sent_in_their_order_again(tmp_path, shuffle):
    bench = slewline.Bench(journal=tmp_path / "j")
    x = bench.add("cy525", name="x")
    host = bench.host(x, name="host")
    bench.at("1 ms", lambda: [host.send(f"{command}\r") for command in ("A 5", "A 6", "A 7", "A 8")])
    bench.run("20 ms")
    assert slewline.replay(tmp_path / "j", shuffle=shuffle)["x"].position == x.position == 8
