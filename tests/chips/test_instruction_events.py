"""Instructions of the stored program are events with an address; what a chip works on is told as text."""

from __future__ import annotations

from typing import Any

import pytest

import slewline

SLOW = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
ENTER = {"gs-c200": "P", "gs-c200s": "Po"}


def heard(x: Any) -> tuple[list[int], list[tuple[int, str]]]:
    """Addresses of the instructions that begin from now on, and what the chip works on since when."""
    addresses: list[int] = []
    texts: list[tuple[int, str]] = []
    x.on_instruction.add(addresses.append)
    x.on_command.add(lambda text: texts.append((x.kernel.now, text)))
    return addresses, texts


def cy525(program: str, after: str = "", **options: Any) -> Any:
    bench = slewline.Bench()
    x = bench.add("cy525", name="x", **options)
    host = bench.host(x)
    host.send(f"E\r{program}\rQ")
    bench.run_until_idle()
    return bench, x, host


def gsc(*lines: str, part: str = "gs-c200s", **options: Any) -> tuple[Any, Any, Any]:
    bench = slewline.Bench()
    x = bench.add(part, name="x", straps=SLOW, **options)
    host = bench.host(x)
    host.uart.follow_straps()
    for line in (ENTER[part], *lines):
        assert host.ask(line) == "Y", line
    return bench, x, host


def texts_of(texts: list[tuple[int, str]]) -> list[str]:
    """What was told: the last word of each instant, without what is repeated."""
    last = [text for n, (at, text) in enumerate(texts) if n + 1 == len(texts) or texts[n + 1][0] != at]
    return [text for n, text in enumerate(last) if not n or last[n - 1] != text]


# ------------------------------------------------------------------------------------------------------------ CY525
def test_instructions_begin_at_their_bytes_and_branches_lead_elsewhere():
    bench, x, host = cy525("N 3\rB\rL 3,3\rC\r0")
    rows = x.program_rows()
    assert [(row.address, row.text) for row in rows] == [(0, "N 3"), (3, "B"), (4, "L 3,3"), (7, "C"), (8, "0")]
    assert b"".join(row.data for row in rows) == x.program
    addresses, texts = heard(x)
    host.send("X\r")
    bench.run_until_idle()
    assert addresses == [0, 3, 4, 3, 4, 3, 4, 7, 8]
    assert texts_of(texts) == ["X", "N 3", "B", "L 3,3", "B", "L 3,3", "B", "L 3,3", "C", "0", ""]


def test_the_program_counter_is_the_current_instruction_and_none_without_a_program():
    bench, x, host = cy525("B\rW\rC\r0")
    x.pin("wait").drive(0)
    assert x.program_counter is None
    host.send("X\r")
    bench.run("5 ms")
    assert x.program_counter == 1
    x.pin("wait").drive(1)
    bench.run_until_idle()
    assert x.program_counter is None


def test_the_event_comes_when_an_instruction_is_fetched_before_it_acts():
    bench, x, host = cy525("B\rC\r0")
    bench.record("x.programmable_output")
    seen: list[tuple[int, int, int | None]] = []
    x.on_instruction.add(lambda at: seen.append((bench.now_ps, at, x.program_counter)))
    host.send("C\rX\r")
    bench.run_until_idle()
    assert [entry[1:] for entry in seen] == [(0, 0), (1, 1), (2, 2)]
    _, rise, fall = bench.edges("x.programmable_output")[0].tolist()
    assert [at for at, *_ in seen][1:] == [rise, fall], "an instruction is fetched when the one before has acted"


def test_live_commands_are_not_instructions():
    bench, x, host = cy525("B\rD 50\rC\rJ 0")
    addresses, texts = heard(x)
    host.send("X\r")
    bench.run("20 ms")
    host.live("R 20", "0")
    bench.run_until_idle()
    assert addresses == [0, 1]
    assert texts_of(texts)[-6:] == ["D 50", "", "R 20", "", "0", ""]


def test_a_command_of_a_host_is_current_until_its_handshake_ends():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    _, texts = heard(x)
    bench.record("x.ready")
    bench.host(x).send("F 30\rR 80\rS 250\rZ 1\rN 40\rG\r")
    bench.run_until_idle()
    assert texts_of(texts) == ["F 30", "", "R 80", "", "S 250", "", "Z 1", "", "N 40", "", "G", ""]
    times, levels = bench.edges("x.ready")
    assert texts[-1][0] == times[-1] and levels[-1] == 1


def test_the_instruction_in_program_entry_is_the_stored_one_and_none_in_reset():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")
    addresses, texts = heard(x)
    host = bench.host(x)
    host.send("E\rW\r0\rQX\r")
    x.pin("wait").drive(0)
    bench.run("20 ms")
    assert texts_of(texts) == ["E", "", "W", "", "0", "", "Q", "", "X", "W"] and addresses == [0]
    x.reset()
    bench.run("1 ms")
    assert texts[-1][1] == "" and x.program_counter is None


# ------------------------------------------------------------------------------------------------------------- GS-C
def test_instructions_of_a_gs_c_begin_at_their_locations():
    bench, x, host = gsc("S10", "T100", "R5", "L0", "+5", "A1", "L2")
    rows = x.program_rows()
    assert [row.text for row in rows] == ["S10", "T100", "R5", "L0", "+5", "A1", "L2"]
    assert x.listing().splitlines() == [f"{row.address:3}  {row.text}" for row in rows]
    where = {row.text: row.address for row in rows}
    addresses, texts = heard(x)
    assert x.program_counter is None
    assert host.ask("E") == "Y"
    bench.run_until_idle()
    again = [where[text] for text in ("+5", "A1", "L2")]
    assert addresses == [row.address for row in rows] + again
    assert texts_of(texts)[0] == "E" and texts_of(texts)[-4:] == ["+5", "A1", "L2", ""]
    assert x.program_counter is None


def test_a_question_during_a_program_is_current_and_then_the_instruction_again():
    bench, x, host = gsc("S10", "T100", "R5", "D20")
    assert host.ask("E") == "Y"
    bench.run("100 ms")
    _, texts = heard(x)
    assert x.program_rows()[-1].address == x.program_counter
    host.ask("V1")
    assert [text for _, text in texts] == ["V1", "D20"]
    host.ask("K")
    assert texts_of(texts) == ["V1", "D20", "K", ""] and x.program_counter is None


def test_lines_for_another_address_are_ignored():
    bench = slewline.Bench()
    x = bench.add("gs-c200s", name="x", straps=SLOW, address=3)
    host = bench.host(x)
    host.uart.follow_straps()
    _, texts = heard(x)
    host.write("4V1\r")
    bench.run("50 ms")
    assert texts_of(texts) in ([], [""])
    host.write("3V1\r")
    bench.run("50 ms")
    assert texts_of(texts)[-2:] == ["V1", ""]


def test_homing_and_the_eeprom_are_work():
    bench, x, host = gsc("S10")
    assert host.ask("E") == "Y"
    bench.run("50 ms")
    _, texts = heard(x)
    assert host.ask("M") == "Y"
    x.pin("eot").drive(0)
    x.pin("home").drive(0)
    host.ask("H+")
    bench.run("100 ms")
    assert texts_of(texts) == ["M", "", "H+", ""]


# ---------------------------------------------------------------------------------------------------- MC1451A family
def test_a_packet_is_current_from_its_command_byte_until_it_acts():
    bench = slewline.Bench()
    x: Any = bench.add("mc1151a", name="x")
    host = bench.host(x)
    host.query("GET_TIME")
    addresses, texts = heard(x)
    begun = bench.now_ps
    host.command("SET_POS", 100)
    host.query("GET_POS")
    host.packet(0x8A, checksum=False)
    told = [(at, text) for n, (at, text) in enumerate(texts) if not n or texts[n - 1][1] != text]
    assert [text for _, text in told] == ["SET_POS", "", "GET_POS", "", "8A", ""]
    assert told[1][0] - told[0][0] > 3 * 81_920_000, "three slices: the command byte and two words"
    assert told[0][0] > begun and not addresses and x.program_counter is None and x.program_rows() == []


def test_listeners_may_change_or_be_absent():
    bench, x, host = cy525("B\rC\r0")
    one: list[int] = []
    two: list[int] = []
    x.on_instruction.add(one.append)
    last = x.on_instruction.add(two.append)
    host.send("X\r")
    bench.run_until_idle()
    x.on_instruction.remove(last)
    host.send("X\r")
    bench.run_until_idle()
    assert one == [0, 1, 2] * 2 and two == [0, 1, 2]


def test_a_run_stops_where_an_instruction_begins():
    bench, x, host = cy525("N 5\rG\rB\rL 2,3\rC\r0")
    host.send("A 0\rF 30\rR 80\r")
    host.send("X\r")
    bench.run_until(x.at_instruction(4))
    assert x.program_counter == 4 and x.position == 5
    bench.run_until(x.at_instruction())
    assert x.program_counter == 5, "the next one"
    again = x.at_instruction(4)
    bench.run_until(again)
    with pytest.raises(slewline.Timeout, match="x at instruction 4"):
        bench.run_until(again, timeout="1 s")
    assert not x.on_instruction or len(x.on_instruction.listeners) == 1
    assert x.program_counter is None


@pytest.mark.parametrize("address", [-1, "A", 1.5, True])
def test_an_instruction_is_named_by_its_address(address):
    _, x, _ = cy525("B\r0")
    with pytest.raises(slewline.UsageError, match=r"x: instruction at .*; allowed 0\.\.59, the addresses of a program"):
        x.at_instruction(address)


@pytest.mark.parametrize("part", ["cy525", "gs-c200", "mc1451a"])
def test_without_a_program_there_are_no_rows(part):
    x = slewline.Bench().add(part)
    assert x.program_rows() == [] and x.program_counter is None and x.listing() == ""
