"""The EEPROM of the GS-C modules: M writes the program into it, X brings it back; it outlives the supply."""

from __future__ import annotations

import pytest
from gsc import C200, CHARACTER, MS, STR, Rig, base, both

WRITE = 1200 * MS
PROGRAM, OTHER = [*STR, "+5"], [*STR, "+9"]
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
def test_lines_behind_an_exchange_are_appended(part: str) -> None:
    rig = saved(part, *PROGRAM)
    assert rig.prg("A3", "A2") == ["Y", "Y"]
    assert rig.asks("X", "A1", "E") == ["Y", "Y", "Y"]
    rig.bench.run_until_idle()
    assert rig.listed() == [*PROGRAM, "A1"]
    assert rig.levels("uo1", "uo2", "uo3") == (1, 0, 0) and rig.moves() == [5]


# ------------------------------------------------------------------------------------------------------------ the write
@both
@pytest.mark.fact("GSC-EEPROM-4", "GSC-UND-M-REPLY", "GSC-CON-M-REPLY")
@pytest.mark.parametrize(("time", "write"), [(None, WRITE), ("5 ms", 5 * MS)])
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
    rig.bench.run("0.2 s")
    assert rig.x.answering and not rig.x.idle
    assert rig.asks("F", "E", "A1", "nonsense", "M", "V1") == ["B"] * 6
    assert rig.level("rdy") == 0 and rig.x.store.read() == b""
    rig.host.received.clear()
    rig.bench.run_until_idle("2 s")
    assert bytes(rig.host.received) == b"Y\r"
    assert rig.listed() == PROGRAM and rig.x.store.read() == rig.x.program


@both
@pytest.mark.fact("GSC-EEPROM-3")
def test_a_write_that_loses_its_supply_leaves_what_was_there(part: str) -> None:
    rig = saved(part, *PROGRAM)
    assert rig.prg(*OTHER) == ["Y"] * 4
    rig.host.received.clear()
    rig.host.write(b"M\r")
    rig.bench.run("1.2 s")
    rig.cycle()
    rig.bench.run("2 s")
    assert bytes(rig.host.received) == b""
    assert rig.asks("F", "X") == ["R", "Y"]
    assert rig.listed() == PROGRAM


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
    assert rig.ask("M") == "Y"
    assert rig.prg() == []
    assert rig.ask("X") == "Y" and rig.listed() == OTHER


@both
@pytest.mark.fact("GSC-UND-E6")
@pytest.mark.parametrize("data", [b"\xff", b"\0", b"A", b"A\1" * 60, b"S\x0a\0\0S"])
def test_what_is_no_program_is_not_recalled(part: str, data: bytes) -> None:
    store = Failing()
    store.data = data
    rig = base(part, options={"store": store})
    assert rig.prg("A1") == ["Y"]
    assert rig.ask("X") == "E6"
    assert rig.listed() == ["A1"]
