"""The EEPROM of the GS-C modules: M writes the program into it, X brings it back; it outlives the supply."""

from __future__ import annotations

from pathlib import Path

import pytest
from gsc import C200, C200S, CHARACTER, MS, STR, Rig, base, both

import slewline
from slewline.core.memory.store import Memory

BYTE = 10 * MS
PROGRAM, OTHER = [*STR, "+5"], [*STR, "+9"]  # 16 locations each
WRITE = 17 * BYTE  # a check byte follows
LINE = 2 * CHARACTER  # a letter and its carriage return


class Failing:
    """An EEPROM whose reads or writes fail on demand; a write that fails leaves what was there."""

    def __init__(self) -> None:
        self.data, self.good = b"", True

    def read(self) -> bytes:
        if not self.good:
            raise OSError("no answer")
        return self.data

    def write(self, data: bytes) -> None:
        if not self.good:
            raise OSError("no acknowledge")
        self.data = data


class Forgetful(Failing):
    """An EEPROM that takes a write and keeps something else."""

    def write(self, data: bytes) -> None:
        self.data = data if self.good else data[:-1]

    def read(self) -> bytes:
        return self.data


def saved(part: str, *lines: str, **options: object) -> Rig:
    """A module that has stored a program, and holds it in both memories."""
    rig = base(part, "rdy", options=options)
    assert rig.prg(*lines) == ["Y"] * len(lines)
    assert rig.ask("M") == "Y"
    return rig


# --------------------------------------------------------------------------------------------------- memorize, exchange
@both
@pytest.mark.fact("GSC-CMD-M-1", "GSC-CMD-M-2", "GSC-EEPROM-1")
def test_a_program_in_the_eeprom_outlives_the_supply(part: str) -> None:
    rig = saved(part, *PROGRAM)
    assert rig.asks("A1", "E") == ["Y", "Y"]  # the session is still open
    rig.bench.run_until_idle()
    assert rig.moves() == [5] and rig.level("uo1") == 1
    rig.cycle()
    assert rig.asks("Q", "X") == ["END", "Y"]
    assert rig.listed() == PROGRAM
    assert rig.asks("M1", "X1") == ["E2", "E2"]


@both
@pytest.mark.fact("GSC-EEPROM-1")
def test_a_program_that_was_not_memorized_is_lost_with_the_supply(part: str) -> None:
    rig = base(part)
    rig.run(*PROGRAM)
    assert rig.listed() == PROGRAM
    rig.cycle()
    assert rig.asks("Q", "X", "Q", "E") == ["END", "Y", "END", "E4"]
    assert rig.prg("A1") == ["Y"]
    rig.cycle()
    assert rig.asks("A1", "Q") == ["E4", "END"]  # the session is over, too


@both
@pytest.mark.fact("GSC-CMD-X-1", "GSC-CMD-X-2")
def test_exchange_replaces_the_program_and_starts_nothing(part: str) -> None:
    rig = saved(part, *PROGRAM)
    rig.run(*OTHER)
    half = rig.bench.now_ps
    assert rig.ask("X") == "Y"
    assert rig.listed() == PROGRAM
    rig.bench.run("5 s")
    assert rig.pulses(half) == []
    assert rig.asks("F", "E") == ["R", "Y"]
    rig.bench.run_until_idle()
    assert rig.moves(half) == [5]


@both
@pytest.mark.fact("GSC-EEPROM-5", "GSC-CON-RECALL-ORDER")
def test_a_recall_is_x_before_e(part: str) -> None:
    rig = saved(part, *PROGRAM)
    rig.cycle()
    assert rig.asks("E", "X", "E") == ["E4", "Y", "Y"]
    assert rig.ask("X") == "B"  # as printed: E runs what is there, and X comes too late
    rig.bench.run_until_idle()
    assert rig.moves() == [5]
    assert rig.ask("G0" if part == C200 else "G+0") == "E4"  # only E starts a program


@both
@pytest.mark.fact("GSC-EEPROM-2", "GSC-UND-PERSIST")
def test_only_the_program_is_kept(part: str) -> None:
    rig = saved(part, *STR, "+77", "A1")
    assert rig.ask("E") == "Y"
    rig.bench.run_until_idle()
    assert rig.asks("M", "V2") == ["Y", "V71"] and rig.pos() == 77
    rig.cycle()
    assert rig.asks("V1", "V2", "H") == ["V0" if part == C200 else "V+0", "V70", "E4"]
    assert len(rig.x.store.read()) == 18  # locations; nothing else is in it


@both
@pytest.mark.fact("GSC-EEPROM-3")
def test_memorize_keeps_the_program_and_overwrites_the_whole_eeprom(part: str) -> None:
    rig = saved(part, *STR, *["A1", "+3"] * 6)
    assert rig.prg(*PROGRAM) == ["Y"] * 4
    assert rig.ask("M") == "Y"
    assert rig.listed() == PROGRAM
    rig.cycle()
    assert rig.ask("X") == "Y"
    assert rig.listed() == PROGRAM


@both
@pytest.mark.fact("GSC-UND-M-EMPTY", "GSC-UND-X-EMPTY")
def test_an_empty_program_may_be_kept_and_recalled(part: str) -> None:
    rig = base(part)
    assert rig.prg(*PROGRAM) == ["Y"] * 4
    assert rig.asks("X", "Q") == ["Y", "END"]  # a new module has an empty EEPROM
    rig = saved(part, *PROGRAM)
    assert rig.prg() == []
    assert rig.asks("M", "A1", "X", "Q") == ["Y", "Y", "Y", "END"]


@both
@pytest.mark.fact("GSC-UND-X-SESSION")
def test_lines_after_an_exchange_are_appended(part: str) -> None:
    rig = saved(part, *PROGRAM)
    assert rig.prg("A3", "A2") == ["Y", "Y"]
    assert rig.asks("X", "A1", "E") == ["Y", "Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.listed() == [*PROGRAM, "A1"]
    assert rig.levels("uo1", "uo2", "uo3") == (1, 0, 0) and rig.moves() == [5]


# ------------------------------------------------------------------------------------------------------------ the write
@both
@pytest.mark.fact("GSC-EEPROM-4", "GSC-UND-M-REPLY", "GSC-CON-M-REPLY")
@pytest.mark.parametrize(("time", "write"), [(None, WRITE), ("12 ms", 17 * MS // 10)])
def test_memorize_answers_when_the_write_is_verified(part: str, time: str | None, write: int) -> None:
    rig = base(part, "rdy", options={} if time is None else {"eeprom_time": time})
    assert rig.prg(*PROGRAM) == ["Y"] * 4
    start = rig.bench.now_ps
    answered = rig.obeyed("M")
    assert rig.host.answers == ["Y"]
    assert answered == start + LINE + MS + write
    falls, rises = rig.falls("rdy", start), rig.rises("rdy", start + 1)
    assert len(falls) == 1 and falls[0] < start + LINE
    assert rises == [answered]


@both
@pytest.mark.fact("GSC-EEPROM-4", "GSC-UND-M-REPLY")
def test_during_the_write_every_line_is_answered_busy(part: str) -> None:
    rig = base(part)
    assert rig.prg(*PROGRAM) == ["Y"] * 4
    rig.host.write(b"M\r")
    rig.bench.run("20 ms")
    assert rig.x.answering and not rig.x.idle
    assert rig.asks("F", "E", "A1", "nonsense", "M", "V1") == ["B"] * 6
    assert rig.level("rdy") == 0 and rig.x.store.read() == b""
    rig.host.received.clear()
    rig.bench.run_until_idle("2 s")
    assert bytes(rig.host.received) == b"Y\r"
    assert rig.listed() == PROGRAM and rig.x.store.read() == rig.x.program


@both
@pytest.mark.fact("GSC-EEPROM-4", "GSC-UND-M-REPLY")
@pytest.mark.parametrize(("lines", "locations"), [([], 0), (["A1"], 2), (["A1"] * 59, 118)])
def test_a_write_takes_ten_milliseconds_a_byte(part: str, lines: list[str], locations: int) -> None:
    rig = base(part)
    assert rig.prg(*lines) == ["Y"] * len(lines)
    start = rig.bench.now_ps
    assert rig.obeyed("M") == start + LINE + MS + (locations + 1) * BYTE


@both
@pytest.mark.fact("GSC-UND-E6", "GSC-UND-M-REPLY")
@pytest.mark.parametrize("after", range(0, 18))
def test_a_supply_that_fails_in_a_write_leaves_the_bytes_written_so_far(part: str, after: int) -> None:
    new = ["S20", "T200", "R20", "+9"]
    rig = saved(part, *PROGRAM)
    old = rig.x.program
    assert rig.prg(*new) == ["Y"] * 4
    stored = rig.x.program
    rig.host.received.clear()
    rig.host.write(b"M\r")
    rig.bench.run(LINE + MS + after * BYTE + (BYTE // 2 if after < 17 else 0))
    rig.cycle()
    rig.bench.run("2 s")
    assert bytes(rig.host.received) == b""
    left = stored[:after] + old[after:]
    if after == 17:
        assert rig.x.store.read() == stored and rig.ask("X") == "Y" and rig.listed() == new
    elif left == old:  # nothing that differs has been written
        assert rig.x.store.read() == old and rig.ask("X") == "Y" and rig.listed() == PROGRAM
    else:
        assert rig.x.store.read() == b"\xff" + left
        assert rig.asks("X", "Q") == ["E6", "END"]
        assert rig.prg(*new) == ["Y"] * 4
        assert rig.asks("M", "X") == ["Y", "Y"] and rig.listed() == new


@pytest.mark.fact("GSC-UND-E6")
def test_a_supply_that_fails_repeatedly_mixes_old_contents() -> None:
    rig = saved(C200S, "A1", "A2")
    for line, after in (("C1", 1), ("C3", 2)):
        assert rig.prg(line, line) == ["Y", "Y"]
        rig.host.write(b"M\r")
        rig.bench.run(LINE + MS + after * BYTE)
        rig.cycle()
        rig.bench.run("2 ms")
    assert rig.x.store.read() == b"\xffC\3A\2"
    assert rig.ask("X") == "E6"


@pytest.mark.fact("GSC-UND-E6")
def test_a_supply_that_fails_while_the_store_fails_makes_the_eeprom_invalid() -> None:
    store = Failing()
    rig = saved(C200S, *PROGRAM, store=store)
    assert rig.prg("A1") == ["Y"]
    rig.host.write(b"M\r")
    rig.bench.run(LINE + MS + 2 * BYTE)
    store.good = False
    rig.cycle()
    store.good = True
    assert rig.ask("X") == "E6" and "no answer" in rig.x.findings[-1].text


@pytest.mark.fact("GSC-UND-E6", "GSC-EEPROM-3")
def test_the_same_program_again_does_no_damage() -> None:
    rig = saved(C200S, *PROGRAM)
    rig.host.write(b"M\r")
    rig.bench.run(LINE + MS + 8 * BYTE)
    rig.cycle()
    assert rig.ask("X") == "Y" and rig.listed() == PROGRAM


@both
@pytest.mark.fact("GSC-UND-M-REPLY")
def test_the_answer_may_come_early_by_option(part: str) -> None:
    rig = base(part, options={"early_y": True})
    assert rig.prg(*PROGRAM) == ["Y"] * 4
    start = rig.bench.now_ps
    assert rig.obeyed("M") == start + LINE + MS
    assert rig.host.answers == ["Y"] and rig.ask("F") == "B"
    rig.bench.run_until_idle("2 s")
    assert rig.ask("F") == "R"
    rig.x.eeprom_fault = True
    assert rig.ask("M") == "Y"
    rig.bench.run_until_idle("2 s")
    assert rig.asks("F", "F") == ["E6", "R"]


# --------------------------------------------------------------------------------------------------------------- faults
@both
@pytest.mark.fact("GSC-UND-E6", "GSC-EEPROM-4")
def test_a_failed_write_is_answered_e6_and_spoils_the_eeprom(part: str) -> None:
    rig = saved(part, *PROGRAM)
    assert rig.prg(*OTHER) == ["Y"] * 4
    rig.x.eeprom_fault = True
    start = rig.bench.now_ps
    assert rig.obeyed("M") == start + LINE + MS + WRITE
    assert rig.host.answers == ["E6"] and rig.codes == ["E6"]
    assert base(part, options={"store": Memory(rig.x.store.read())}).ask("X") == "E6"  # whoever reads it
    assert rig.listed() == OTHER
    assert rig.asks("F", "X") == ["R", "E6"]
    assert rig.listed() == OTHER
    rig.cycle()
    assert rig.asks("X", "Q") == ["E6", "END"]
    rig.drive("rec", 0)
    back = rig.cycle()
    rig.bench.run("1 s")
    assert rig.pulses(back) == [] and rig.ask("F") == "R"  # and nothing starts by itself
    rig.x.eeprom_fault = False
    assert rig.prg(*OTHER) == ["Y"] * 4
    assert rig.asks("M", "X") == ["Y", "Y"]
    assert rig.listed() == OTHER


@both
@pytest.mark.fact("GSC-UND-E6")
@pytest.mark.parametrize("kind", [Failing, Forgetful])
def test_a_write_that_the_store_refuses_or_garbles_is_answered_e6(part: str, kind: type[Failing]) -> None:
    store = kind()
    rig = saved(part, *PROGRAM, store=store)
    assert rig.prg(*OTHER) == ["Y"] * 4
    store.good = False
    assert rig.asks("M", "X") == ["E6", "E6"]
    assert rig.codes == ["E6", "E6"] and rig.listed() == OTHER
    store.good = True
    assert rig.ask("X") == "E6" and rig.listed() == OTHER  # not before a write has succeeded
    assert rig.ask("M") == "Y"
    assert rig.prg() == []
    assert rig.ask("X") == "Y" and rig.listed() == OTHER


class Torn(Failing):
    """An EEPROM that takes so many bytes of a write, and then fails; it can be read all the time."""

    def __init__(self, taken: int) -> None:
        super().__init__()
        self.taken = taken

    def read(self) -> bytes:
        return self.data

    def write(self, data: bytes) -> None:
        if not self.good:
            self.data = data[: self.taken] + self.data[self.taken :]
            raise OSError(f"no acknowledge of byte {self.taken}")
        self.data = data


@pytest.mark.fact("GSC-UND-E6")
@pytest.mark.parametrize("taken", range(17))
def test_a_write_that_fails_at_any_byte_loses_nothing(taken: int) -> None:
    store = Torn(taken)
    rig = saved(C200S, *PROGRAM, store=store)
    assert rig.prg(*OTHER) == ["Y"] * 4
    store.good = False
    assert rig.asks("M", "X") == ["E6", "E6"]
    assert f"no acknowledge of byte {taken}" in rig.x.findings[-1].text
    assert rig.listed() == OTHER
    rig.drive("rec", 0)
    back = rig.cycle()
    rig.bench.run("1 s")
    assert rig.pulses(back) == [] and rig.asks("X", "Q") == ["E6", "END"]
    store.good = True
    assert rig.prg(*OTHER) == ["Y"] * 4
    assert rig.asks("M", "X") == ["Y", "Y"] and rig.listed() == OTHER


class Slow(Failing):
    """An EEPROM that is busy for so many looks after a write; it can be read all the time."""

    looks = 3

    def write(self, data: bytes) -> None:
        super().write(data)
        self.left = self.looks

    def pending(self) -> bool:
        self.left -= 1
        return self.left >= 0


@both
@pytest.mark.fact("GSC-UND-E6")
@pytest.mark.parametrize(("ms", "answer"), [(45, "E6"), (50, "Y"), (55, "Y")])
def test_completely_written_data_is_valid_after_a_failed_write(part: str, ms: int, answer: str) -> None:
    rig = base(part, options={"store": Slow(), "eeprom_fault": True})
    assert rig.prg("A1", "A2") == ["Y"] * 2
    assert rig.ask("M") == "E6"
    rig.x.eeprom_fault = False
    rig.host.write(b"M\r")
    rig.bench.run(LINE + MS + ms * MS)
    rig.cycle()
    assert rig.ask("X") == answer


@both
@pytest.mark.fact("GSC-UND-E6")
def test_the_fault_of_the_eeprom_is_an_option_and_a_switch(part: str) -> None:
    rig = base(part, options={"eeprom_fault": True})
    assert rig.x.eeprom_fault and rig.prg(*PROGRAM) == ["Y"] * 4
    assert rig.asks("M", "X") == ["E6", "E6"]
    rig.x.eeprom_fault = False
    assert rig.asks("M", "X") == ["Y", "Y"] and rig.listed() == PROGRAM
    with pytest.raises(slewline.UsageError, match="x: eeprom_fault 1; allowed True, False"):
        rig.x.eeprom_fault = 1


def test_a_journal_repeats_the_fault_of_the_eeprom(tmp_path: Path) -> None:
    bench = slewline.Bench(journal=tmp_path / "journal")
    x = bench.add(C200S, name="x", straps={"br0": 0, "br1": 0, "br2": 0, "chs": 0})
    host = bench.host(x)
    assert host.ask("F") == "R"
    x.eeprom_fault = True
    assert [host.ask("M"), host.ask("X")] == ["E6", "E6"]
    x.eeprom_fault = False
    assert [host.ask("M"), host.ask("X")] == ["Y", "Y"]
    again = slewline.replay(tmp_path / "journal")
    assert [(found.time_ps, found.code) for found in again["x"].findings] == [
        (found.time_ps, found.code) for found in x.findings
    ]
    assert not again["x"].eeprom_fault


@both
@pytest.mark.fact("GSC-UND-E6")
@pytest.mark.parametrize(
    "data", [b"\xff", b"\0", b"A", b"A\1" * 60, b"S\x0a\0\0S", b"A\4", b"S\0\0\0", b"T\xe9\3\0", b"+\0\0\0", b"x\1\0\0"]
)
def test_an_invalid_program_is_not_recalled(part: str, data: bytes) -> None:
    store = Failing()
    store.data = data
    rig = base(part, options={"store": store})
    assert rig.prg("A1") == ["Y"]
    assert rig.ask("X") == "E6"
    assert rig.listed() == ["A1"]
