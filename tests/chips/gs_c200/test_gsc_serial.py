"""The line of a GS-C module: characters, rates, straps, strings and their ends.

    start   d0 ... d6   odd parity   two stop bits        eleven bits; RS-232: a 1 is the negative voltage, level 0

The tests draw the waveform bit by bit from frames written as "0 0100101 0 11".
"""

from __future__ import annotations

import pytest
from gsc import C200, C200S, MS, NINE_SIX, STR, Rig, base, both

import slewline
from slewline.core.memory.store import Memory
from slewline.core.wires.serial import CharacterFormat

BAUDS = {"000": 9600, "100": 4800, "010": 2400, "110": 1200, "001": 600, "101": 300, "011": 150, "111": 110}
BITS = 11  # of a character
UP = MS  # when the host begins: a millisecond after power-up
FRAMES = {
    "F": "0 0110001 0 11",
    "R": "0 0100101 0 11",
    "E": "0 1010001 0 11",
    "1": "0 1000110 0 11",
    "2": "0 0100110 0 11",
    "4": "0 0010110 0 11",
    "\r": "0 1011000 0 11",
}


def time_of(bits: int, baud: int = 9600) -> int:
    """How long bits last, rounded down."""
    return bits * 10**12 // baud


def drawn(text: str, start: int, baud: int = 9600, bits: int = BITS) -> list[tuple[int, int]]:
    """(instant, level) of every change that characters make on a line at rest, one behind the other."""
    changes, before = [], 0
    for character in text:
        for bit, value in enumerate(FRAMES[character].replace(" ", "")[:bits]):
            if (level := 1 - int(value)) != before:
                changes.append((start + time_of(bit, baud), level))
                before = level
        start += time_of(bits, baud)
    return changes


def sent(text: str, baud: int = 9600, start: int = UP) -> int:
    """When a host has sent characters."""
    return start + len(text) * time_of(BITS, baud)


def pieces(rig: Rig, text: str, at: int, fault: str) -> bytes:
    """What comes back for a string of which one character is faulty."""
    for n, character in enumerate(text):
        rig.host.write(character, fault if n == at else "")
    return rig.wire("")


class Alone:
    """A module whose line is drawn by hand."""

    def __init__(self, part: str) -> None:
        self.bench = slewline.Bench()
        self.x = self.bench.add(part, name="x", straps={**NINE_SIX, "chs": 0})
        self.bench.record("x.txd")

    def draw(self, *changes: tuple[int, int]) -> None:
        for time, level in changes:
            self.x.pin("rxd").drive(level, at=time)

    def answer(self) -> list[tuple[int, int]]:
        """Every change on TXD, half a second on."""
        self.bench.run("500 ms")
        times, levels = self.bench.edges("x.txd")
        return list(zip(times.tolist(), levels.tolist(), strict=True))


# ------------------------------------------------------------------------------------------------ characters and rates
@both
@pytest.mark.fact("GSC-SER-1", "GSC-SER-7", "GSC-SER-11", "GSC-UND-TURNAROUND")
def test_the_form_and_delay_of_an_answer_after_the_return(part: str) -> None:
    module = Alone(part)
    module.draw(*drawn("F\r", UP))
    assert module.x.pin("txd").level == 0  # mark: the negative voltage
    assert module.answer() == drawn("R\r", sent("F\r") + MS)


@both
@pytest.mark.parametrize("turnround", ["0 us", "250 us", "20 ms"])
@pytest.mark.fact("GSC-UND-TURNAROUND")
def test_the_time_before_an_answer_can_be_chosen(part: str, turnround: str) -> None:
    rig = base(part, options={"turnround": turnround})
    rig.wire("F\r")
    assert rig.edges("txd") == drawn("R\r", sent("F\r") + slewline.core.time.timebase.picoseconds(turnround))


@both
@pytest.mark.parametrize("straps", BAUDS)
@pytest.mark.fact("GSC-SER-2", "GSC-SER-3")
def test_the_rate_is_strapped(part: str, straps: str) -> None:
    baud = BAUDS[straps]
    pins = {f"br{n}": int(level) for n, level in enumerate(straps)}
    rig = base(part, baud=baud, **pins)
    assert rig.wire("2\r", wait="1 s") == b"E4\r"
    assert rig.edges("txd") == drawn("E4\r", sent("2\r", baud) + MS, baud)
    assert rig.bench.now_ps == sent("2\r", baud) + MS + 3 * time_of(BITS, baud) + 10**12


@both
@pytest.mark.fact("GSC-UND-STRAPS")
def test_rate_address_and_recall_are_read_at_power_up(part: str) -> None:
    rig = base(part)
    rig.bench.run_to(UP)
    for pin, level in (("br0", 1), ("sel0", 0), ("rec", 0)):
        rig.drive(pin, level)
    assert rig.wire("F\r", wait="1 s") == b"R\r"
    rig.x.power(False)
    rig.x.power(True)
    rig.host.uart.set_line(4800, rig.host.word)
    assert rig.wire("F\r4F\r", wait="1 s") == b"R\r"  # the one with the address


@both
@pytest.mark.fact("GSC-UND-STRAPS")
def test_chs_is_read_at_each_return_and_rules_the_answer_too(part: str) -> None:
    rig = base(part)
    assert rig.wire("F\r") == b"R\r"
    rig.drive("chs", 1)
    assert rig.wire("FV\r") == b"RR\r"
    rig.host.write("FV\r")
    rig.bench.run_until(rig.x.pin("rdy").is_(0))
    rig.drive("chs", 0)  # behind the carriage return, before the answer
    assert rig.wire("") == b"RR\r"
    assert rig.wire("F\r") == b"R\r"


@both
@pytest.mark.fact("GSC-UND-STRAPS")
def test_the_late_answer_to_m_is_written_as_its_own_string(part: str) -> None:
    rig = base(part)
    rig.prg(*["A1"] * 9)
    rig.host.received.clear()
    rig.host.write("M\r")
    rig.bench.run("100 ms")
    rig.drive("chs", 1)
    before = len(rig.host.received)
    rig.host.write("FV\r")
    rig.bench.run("2 s")
    assert bytes(rig.host.received[before:]) == b"BR\rY\r"


# ------------------------------------------------------------------------------------------------------------ dialogue
@both
@pytest.mark.fact("GSC-SER-4", "GSC-UND-RX-WHILE-TX")
def test_without_handshake_an_answer_comes_while_the_host_is_still_sending(part: str) -> None:
    rig = base(part)
    assert set(rig.host.pins) == {"txd", "rxd"}
    assert not {"rts", "cts", "dtr", "dsr", "dcd"} & set(rig.x.pins)
    rig.host.write("F\rFFFFFFFFFF")
    rig.bench.run_until(lambda: rig.host.idle)
    assert rig.edges("txd") == drawn("R\r", sent("F\r") + MS)


@both
@pytest.mark.fact("GSC-SER-5", "GSC-CHK-10")
def test_xon_and_xoff_are_checksums_and_nothing_else(part: str) -> None:
    rig = base(part, chs=1)
    rig.prg("S10")
    for line in (b"L7\x13\r", b"L5\x11\r", b"R1\x13\r", b"L4\x10\r"):
        start = rig.bench.now_ps
        assert rig.wire(line) == b"YY\r"
        assert rig.edges("txd", start)[0][0] == sent(line.decode(), start=start) + MS
    assert rig.wire(b"V1\x17\r")[:1] == b"V"


@both
@pytest.mark.fact("GSC-SER-6")
def test_a_module_never_sends_first(part: str) -> None:
    store = Memory()
    writer = base(part, options={"store": store})
    writer.prg(*STR, "A1", "-5", "+2")
    assert writer.ask("M") == "Y"
    rig = base(part, "clock", options={"store": store}, rec=0, eot=0, home=0)
    rig.bench.run("1 s")
    for pin in ("enable", "eot", "home", "ui1", "ui2", "ui3", "chs", "rec", "sel0", "br2"):
        rig.drive(pin, 1 - rig.level(pin))
    rig.bench.run("1 s")
    assert rig.x.idle and rig.level("uo1") == 1  # the program has run to its end
    assert len(rig.pulses()) == (0 if part == C200 else 7)
    assert rig.codes == (["E5"] if part == C200 else [])
    assert rig.edges("txd") == [] and rig.host.received == b""


@both
@pytest.mark.fact("GSC-SER-7", "GSC-SER-8")
def test_strings_end_with_a_carriage_return_alone_and_there_is_no_echo(part: str) -> None:
    rig = base(part)
    assert rig.wire("F\r", wait="1 s") == b"\x52\x0d"
    assert rig.wire("V2\r", wait="1 s") == b"\x56\x37\x30\x0d"


@both
@pytest.mark.fact("GSC-SER-8", "GSC-SER-12")
def test_nothing_happens_before_the_return_however_long_that_takes(part: str) -> None:
    rig = base(part, "rdy")
    assert rig.wire("F", wait="60 s") == b""
    assert rig.edges("txd") == [] and rig.falls("rdy") == []
    assert rig.wire("\r") == b"R\r"


@both
@pytest.mark.fact("GSC-SER-9", "GSC-ERR-1")
def test_a_parity_fault_in_any_character_spoils_its_string(part: str) -> None:
    rig = base(part)
    rig.prg()
    for at in range(3):
        assert pieces(rig, "A3\r", at, "parity") == b"E1\r"
    assert rig.listed() == []
    assert rig.wire("A3\r") == b"Y\r"
    assert rig.listed() == ["A3"]


@both
@pytest.mark.fact("GSC-SER-10")
def test_answers_have_odd_parity_the_return_included(part: str) -> None:
    module = Alone(part)
    port = module.bench.part("serial_port", to=module.x, bits=8, parity="none")  # it makes and sees parity as bit 7
    module.bench.run_to(UP)
    for line, answer in (
        (b"\x49\xb3\x0d", b"\xd9\x0d"),  # I3, Y
        (b"\xd6\x32\x0d", b"\xd6\x37\xb0\x0d"),  # V2, V70
        (b"\xd6\xb9\x0d", b"\x45\x32\x0d"),  # V9, E2
    ):
        port.received.clear()
        port.write(line)
        module.bench.run("1 s")
        assert bytes(port.received) == answer


# --------------------------------------------------------------------------------------------- what does not fit
@both
@pytest.mark.fact("GSC-SER-13", "GSC-UND-STOPBITS")
def test_another_format_gives_e1_where_parity_or_stop_bit_are_wrong(part: str) -> None:
    rig = base(part)
    rig.host.uart.set_line(9600, CharacterFormat(7, "even", 2))
    assert rig.wire("F\r") == b"E1\r"
    rig.host.uart.set_line(9600, CharacterFormat(8, "none", 1))
    assert rig.wire("V1\r") == b"E1\r"  # the parity bit is always 0: right for the 1, wrong for the V
    rig.host.uart.set_line(9600, CharacterFormat(7, "odd", 1))
    assert rig.wire("F\r") == b"R\r"  # one stop bit will do


@both
@pytest.mark.fact("GSC-UND-STOPBITS")
def test_one_stop_bit_will_do_and_two_are_sent(part: str) -> None:
    module = Alone(part)
    module.draw(*drawn("F\r", UP, bits=BITS - 1))
    end = UP + time_of(BITS - 1) + time_of(BITS)  # the answer leaves room for a second one behind the return
    assert module.answer() == drawn("R\r", end + MS)


@both
@pytest.mark.fact("GSC-SER-13")
def test_no_dialogue_at_another_rate(part: str) -> None:
    pins = ("clock", "mov", "dir", "uo1", "uo2", "uo3")
    slow = base(part, *pins, baud=4800)
    assert slow.wire("+12345678\r", wait="1 s") == b""
    fast = base(part, *pins, baud=9600, br0=1)  # strapped for 4800
    fast.wire("]`3H2L1n8\r", wait="1 s")  # among other things it looks like a return
    answer = fast.edges("txd")
    assert fast.codes == ["E1"] and answer == drawn("E1\r", answer[0][0], 4800)
    assert [rig.edges(pin) for rig in (slow, fast) for pin in pins] == [[]] * 12


@both
@pytest.mark.fact("GSC-UND-FRAMING")
def test_a_framing_fault_spoils_its_string_like_a_parity_fault(part: str) -> None:
    rig = base(part)
    rig.prg()
    for at in range(3):
        assert pieces(rig, "A3\r", at, "framing") == b"E1\r"
    assert rig.listed() == []


@both
@pytest.mark.fact("GSC-UND-FRAMING")
def test_a_break_spoils_the_string_that_it_opens(part: str) -> None:
    module = Alone(part)
    module.draw((UP, 1), (UP + 50 * MS, 0))
    start = UP + 60 * MS
    module.draw(*drawn("F\rF\r", start))
    first = sent("F\r", start=start) + MS
    assert module.answer() == drawn("E1\rR\r", first)  # the second string had been waiting


@both
@pytest.mark.fact("GSC-UND-EMPTY")
def test_a_lone_return_is_dropped(part: str) -> None:
    rig = base(part)
    assert rig.wire("\r\r\rF\r\r", wait="1 s") == b"R\r"
    assert rig.codes == []


@both
@pytest.mark.fact("GSC-UND-EMPTY")
def test_with_checksums_a_lone_character_is_the_checksum_of_nothing(part: str) -> None:
    rig = base(part, chs=1)
    assert rig.wire("\r", wait="1 s") == b""
    assert rig.wire("F\r") == b"E1v\r"
    assert rig.wire(b"\x10\r") == b"E4y\r"


@both
@pytest.mark.fact("GSC-UND-LF")
def test_a_line_feed_is_a_character_unless_it_is_tolerated(part: str) -> None:
    rig = base(part)
    assert rig.wire("F\r\n") == b"R\r"
    assert rig.wire("F\r") == b"E4\r"
    assert rig.wire("F\n\r") == b"E2\r"
    rig = base(part, options={"lenient": True})
    assert rig.wire("\n\nF\r\n") == b"R\r"
    assert rig.wire("F\r") == b"R\r"
    assert rig.wire("F\n\r") == b"E2\r"


@both
@pytest.mark.fact("GSC-UND-LF")
@pytest.mark.parametrize("chs", [0, 1])
def test_a_host_that_ends_its_lines_with_a_line_feed_is_reported_once(part: str, chs: int) -> None:
    rig = base(part, chs=chs)
    line = b"FV\n" if chs else b"F\n"
    assert rig.wire(line * 2, wait="1 s") == b""
    assert [(found.code, found.text) for found in rig.x.findings] == [
        ("line-end", r"the host ends its lines with LF, but this part expects CR: send \r alone, without \n")
    ]
    assert rig.x.waiting.endswith(f"{(line * 2).decode()!r} has arrived without its carriage return")
    assert rig.x.idle
    with pytest.raises(slewline.Timeout, match="has arrived without its carriage return"):
        rig.bench.run_until(rig.host.got(b"R"), "1 s")
    rig.cycle()
    assert "return" not in rig.x.waiting


@both
@pytest.mark.fact("GSC-UND-LF")
def test_a_host_that_ends_its_lines_with_both_is_reported_once(part: str) -> None:
    rig = base(part)
    assert rig.wire("F\r\nF\r\nF\r\n") == b"R\rE4\rE4\r"
    assert rig.codes == ["line-end", "E4", "E4"]
    assert rig.x.findings[0].text.startswith(
        "the host ends its lines with CR LF, but this part expects CR and treats LF"
    )
    rig = base(part, options={"lenient": True})
    assert rig.wire("F\r\nF\r\n") == b"R\rR\r" and rig.codes == []
    assert rig.wire("F\n", wait="1 s") == b"" and rig.codes == ["line-end"]


def test_a_line_feed_that_may_be_a_checksum_is_not_reported() -> None:
    rig = base(C200, chs=1, options={"firmware": "2.1"})
    assert rig.wire(b"FF\r") == b"RR\r"
    assert rig.wire(b"F\n\r") == b"E1v\r" and rig.codes == ["E1"]


@both
@pytest.mark.fact("GSC-UND-RX-WHILE-TX")
def test_one_string_waits_while_an_answer_goes_out_and_the_next_is_lost(part: str) -> None:
    rig = base(part)
    rig.prg(*STR)
    assert rig.wire("Q\rF\rV2\r") == b"S10\rT100\rR10\rEND\rR\r"
    assert rig.codes == ["line-lost"]
    assert "b'V2'" in rig.x.findings[0].text
    assert rig.wire("V2\r") == b"V70\r"


# --------------------------------------------------------------------------------------------------------------- length
@both
@pytest.mark.fact("GSC-ERR-2", "GSC-UND-MAXLEN")
def test_eleven_characters_pass_and_twelve_are_too_many(part: str) -> None:
    rig = base(part)
    rig.prg()
    assert rig.wire("+0000000005\r") == b"Y\r"
    assert rig.wire("+00000000005\r") == b"E1\r"
    assert rig.listed() == ["+5"]
    assert rig.wire("F" * 200 + "\r", wait="1 s") == b"E1\r"
    assert rig.wire("F\r") == b"R\r"


@pytest.mark.parametrize(("line", "answer"), [("+0000000005", "E4"), ("+00000000005", "E1"), ("F" * 40, "E1")])
def test_the_characters_of_a_line_that_is_taken_whole_are_counted(line: str, answer: str) -> None:
    bench = slewline.Bench()
    host = bench.host(bench.add("gs-c200s", "x", straps={"chs": 0}))
    assert host.ask(line) == answer and host.ask("F") == "R"


@pytest.mark.fact("GSC-UND-MAXLEN", "GSC-CON-V-LENGTH")
def test_the_longest_string_has_address_command_and_checksum() -> None:
    rig = base(C200S, chs=1, sel0=0)
    assert rig.wire(b"4f-8388608P\r") == b"YY\r"
    assert rig.wire(b"4f-08388608p\r") == b"E1v\r"
    assert rig.ask("V1") == "V-8388608"
