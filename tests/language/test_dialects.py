"""The decoder of the CY5xx command stream: every stream alone, with garbage around it, and drained at any point."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slewline.chips.cy525.sheet import SHEET
from slewline.language.dialect import Command, spoken_as
from slewline.language.text import Label, Letters
from tests.rows import rows

BINARY = bytes.fromhex
LETTERS = spoken_as(SHEET, Letters)


def encode_ascii(row, values=(), labels=""):
    return LETTERS.spell(row, values, labels).encode() + b"\r" * row.terminated


def encode_binary(row, values=()):
    return LETTERS.block(row, row.pack(values)[1:])


class Port:
    """A decoder, with the little that a chip adds: E and Q switch program entry."""

    def __init__(self, ascii=True):
        self.decoder = LETTERS.decoder(SHEET)
        self.ascii = ascii
        self.entering = False
        self.decoded = []
        self.codes = []
        self.buffer = b""

    def feed(self, data, drain=False):
        for byte in data:
            item = self.decoder.feed(byte, self.ascii, self.entering)
            if item is not None:
                self.take(item)
            if drain:
                self.drain()
        self.drain()
        return self

    def drain(self):
        self.codes += [note.code for note in self.decoder.take_notes()]

    def take(self, item):
        self.decoded.append(item)
        if isinstance(item, Label):
            return
        if self.entering:
            self.buffer += item.stored
        elif item.row.name == "ENTER":
            self.entering, self.buffer = True, b""
        if item.row.name == "QUIT":
            self.entering = False

    @property
    def texts(self):
        return [item.text if isinstance(item, Command) else item.letter + "$" for item in self.decoded]


def ascii_port(data, **options):
    return Port().feed(data, **options)


def binary_port(text, **options):
    return Port(ascii=False).feed(BINARY(text), **options)


ASCII_STREAMS = [  # stream, commands, notes
    (b"B\r", ["B"], []),
    (b"R 100\r", ["R 100"], []),
    (b"N 738\rG\r", ["N 738", "G"], []),
    (b"+\r-\r0\r", ["+", "-", "0"], []),
    (b"L 3,0\rL 3 0\r", ["L 3,0", "L 3,0"], []),
    (b"L 6,C\rL 6 C\rJ A\rT E\r", ["L 6,C", "L 6,C", "J A", "T E"], []),
    (b"A$C\r", ["A$", "C"], []),
    (b"C$C\rC\rA$A 5\r", ["C$", "C", "C", "A$", "A 5"], []),
    (b"A$B$C\r", ["A$", "B$", "C"], []),
    (b"QX\r", ["Q", "X"], []),
    (b"Q\rB\r", ["Q", "B"], ["q-terminated"]),
    (b"Q\r\r", ["Q"], ["q-terminated", "empty-line"]),
    (b"QB\r\r", ["Q", "B"], ["empty-line"]),
    (b"\rB\r", ["B"], ["empty-line"]),
    (b"\nB\rC\r", ["C"], ["line-feed"]),
    (b"B\r\nC\r\nG\r", ["B"], ["line-feed", "line-feed"]),
    (b"A 0\nF 5\n\rB\r", ["B"], ["line-end", "bad-number"]),
    (b"K 5\nB\n\rB\r", ["B"], ["unknown-command", "line-end"]),
    (b"K 5\rB\r", ["B"], ["unknown-command"]),
    (b"M\rY\r1\r$\r^\r", [], ["unknown-command"] * 5),
    (b"b\rr 5\rB\r", ["B"], ["unknown-command"] * 2),
    (b" B\rC\r", ["C"], ["unknown-command"]),
    (b"F$B\rC\r", ["C"], ["unknown-command"]),
    (b"A $C\rB\r", ["B"], ["unknown-command"]),
    (b"B2$C\rB\r", ["B"], ["unknown-command"]),
    (b"K$$C\rB\r", ["B"], ["unknown-command"]),
    (b"R100\rR  100\rR 100 \r", ["R 100"] * 3, ["spacing"] * 3),
    (b"B \r", ["B"], ["spacing"]),
    (b"R100 \rL3,0 \r", ["R 100", "L 3,0"], ["spacing"] * 2),
    (b"L3,0\rL 3, 0\rL 3  0\r", ["L 3,0"] * 3, ["spacing"] * 3),
    (b"N\rN \rL 3\rL 3,\rL ,3\rB\r", ["B"], ["missing-argument"] * 5),
    (b"B 5\rB5\rG x\r", ["B", "B", "G"], ["extra-argument"] * 3),
    (b"R -1\rR 1.5\rR x\rR 1 2\rR 1,2\rB\r", ["B"], ["bad-number"] * 5),
    (b"R \xb2\rR +5\rR 5\t\r", [], ["bad-number"] * 3),
    (b"J F\rJ a\rJ AB\rR A\rL B,3\rL 3,0,1\r", [], ["bad-number"] * 6),
    (b"R 127\rR 0\rF 127\rS 255\rN 65535\r", ["R 127", "R 0", "F 127", "S 255", "N 65535"], []),
    (b"P 0\rV 3\rJ 59\rL 255,59\r", ["P 0", "V 3", "J 59", "L 255,59"], []),
    (b"R 128\rS 0\rZ 0\rD 0\rN 0\r", ["R 128", "S 0", "Z 0", "D 0", "N 0"], ["range"] * 5),
    (b"L 0,60\rJ 60\rV 4\r", ["L 0,60", "J 60", "V 4"], ["range"] * 4),
    (b"R 356\rN 65541\rR 65541\rO 256\r", ["R 100", "N 5", "R 5", "O 0"], ["range"] * 4),
    (b"R 00100\r", ["R 100"], []),
]

BINARY_STREAMS = [
    ("42 00", ["B"], []),
    ("52 01 64", ["R 100"], []),
    ("4E 02 E2 02", ["N 738"], []),
    ("4C 02 03 0B", ["L 3,11"], []),
    ("51 42 00", ["Q", "B"], []),
    ("30 00", ["0"], []),
    ("4B 02 42 00 42 00", ["B"], ["unknown-command"]),
    ("4B 00 42 00", ["B"], ["unknown-command"]),
    ("62 00 0D 00 0A 00 20 01 42", [], ["unknown-command"] * 4),
    ("51 00 00 42 00", ["Q", "B"], ["unknown-command"]),
    ("24 01 42 43 00", ["C"], ["unknown-command"]),
    ("41 24 42 00" + "00" * 34, ["A 66"], ["count"]),
    ("4E 01 05", ["N 5"], ["count"]),
    ("4E 00", ["N 0"], ["count", "range"]),
    ("52 03 64 42 00 43 00", ["R 100", "C"], ["count"]),
    ("42 01 43 43 00", ["B", "C"], ["count"]),
    ("4A 01 41", ["J 65"], ["range"]),
    ("52 01 80 53 01 00 4E 02 00 00", ["R 128", "S 0", "N 0"], ["range"] * 3),
]


def around(port, stream, before, after):
    """The stream between two others, which a fresh port decodes alone."""
    alone = Port(port.ascii).feed(before)
    ahead = Port(port.ascii).feed(after)
    port.feed(before + stream + after)
    return alone, ahead


@rows(("stream", "texts", "codes"), ASCII_STREAMS)
@rows("drain", [False, True])
def test_ascii_stream(stream, texts, codes, drain):
    port = ascii_port(stream, drain=drain)
    assert (port.texts, port.codes) == (texts, codes)
    assert port.decoder.at_letter


@rows(("stream", "texts", "codes"), ASCII_STREAMS)
@rows("before", [b"K 12\r", b"B\r", b"\n\xff$\x00\r", b"N\r"])
@rows("after", [b"R 1", b"L 3", b"\n", b"A$"])
def test_ascii_stream_in_garbage(stream, texts, codes, before, after):
    port = Port()
    alone, ahead = around(port, stream, before, after)
    assert port.texts == alone.texts + texts + ahead.texts
    assert port.codes == alone.codes + codes + ahead.codes


@rows(("stream", "texts", "codes"), BINARY_STREAMS)
@rows("drain", [False, True])
def test_binary_stream(stream, texts, codes, drain):
    port = binary_port(stream, drain=drain)
    assert (port.texts, port.codes) == (texts, codes)
    assert port.decoder.at_letter


@rows(("stream", "texts", "codes"), BINARY_STREAMS)
@rows("before", ["4B 03 51 42 00", "42 00", "00 00"])
@rows("after", ["52 01", "4E", "4B 05 42 00"])
def test_binary_stream_in_garbage(stream, texts, codes, before, after):
    port = Port(ascii=False)
    alone, ahead = around(port, BINARY(stream), BINARY(before), BINARY(after))
    assert port.texts == alone.texts + texts + ahead.texts
    assert port.codes == alone.codes + codes + ahead.codes


# ---------------------------------------------------------------------------------------------- forms of commands


@pytest.mark.fact("LANG-SET-1")
def test_command_letters():
    letters = "".join(chr(byte) for byte in range(256) if "unknown-command" not in ascii_port(bytes([byte])).codes)
    assert sorted(letters) == sorted("ABCDEFGHIJLNOPQRSTUVWXZ+-0\r\n")


@pytest.mark.fact("LANG-FORM-3")
@rows("row", SHEET.commands)
def test_same_letter_in_both_modes(row):
    values = [arg.high for arg in row.args]
    ascii, binary = encode_ascii(row, values), encode_binary(row, values)
    assert ascii[0] == binary[0]
    assert ascii_port(ascii).decoded[0].row is row
    assert binary_port(binary.hex()).decoded[0].row is row


@pytest.mark.fact("LANG-FORM-1")
@rows("row", [row for row in SHEET.commands if not row.args and row.terminated])
def test_a_letter_waits_for_its_carriage_return(row):
    port = ascii_port(row.form.encode())
    assert (port.decoded, port.decoder.at_letter) == ([], False)
    assert (port.feed(b"\r").texts, port.codes) == ([row.form], [])


@pytest.mark.fact("LANG-FORM-2")
def test_a_number_waits_for_its_carriage_return():
    port = ascii_port(b"N 738")
    assert (port.decoded, port.decoder.at_letter) == ([], False)
    (command,) = port.feed(b"\r").decoded
    assert (command.row.form, command.values, port.codes) == ("N", (738,), [])


@pytest.mark.fact("CMD-L-2")
def test_two_arguments_have_a_comma_or_a_space_between_them():
    port = ascii_port(b"E\rL 3,0\rL 3 0\rQ")
    assert (port.buffer, port.codes) == (b"L\3\0L\3\0", [])


@pytest.mark.fact("LABEL-1")
def test_label_in_front_of_an_instruction():
    port = ascii_port(b"E\rB\rC$C\rJ C\rQ")
    assert (port.buffer, port.decoded[2]) == (BINARY("42 43 4A 43"), Label("C"))
    five = ascii_port(b"E\rE$B\rA$B\rD$B\rB$B\rC$B\rQ")
    assert [item.letter for item in five.decoded if isinstance(item, Label)] == list("EADBC")
    assert (five.buffer, five.codes) == (b"BBBBB", [])


@pytest.mark.fact("LABEL-5")
def test_no_labels_in_binary():
    port = binary_port("45 00 4A 01 41 51")
    assert (port.texts, port.codes, port.buffer) == (["E", "J 65", "Q"], ["range"], b"JA")


@pytest.mark.fact("BIN-2")
def test_binary_command_ends_with_its_last_byte():
    port = binary_port("42")
    assert port.decoded == []
    assert port.feed(b"\0\x4e\2\x0d").texts == ["B"]
    assert port.feed(b"\0").texts == ["B", "N 13"]


@pytest.mark.fact("BIN-3", "BIN-4", "BIN-5")
@pytest.mark.parametrize(("count", "letters"), [(0, "BCXEGHIUW+-0"), (1, "FJORSTVZ"), (2, "ALNPD")])
def test_data_counts(count, letters):
    for letter, announced in product(letters, range(4)):
        port = Port(ascii=False).feed(letter.encode() + bytes([announced]) + b"\3" * announced)
        assert [command.row.form for command in port.decoded] == [letter]
        assert ("count" in port.codes) == (announced != count)


@pytest.mark.fact("BIN-5", "BIN-6")
def test_order_of_binary_data():
    steps, loop = binary_port("4E 02 2C 01 4C 02 03 0B").decoded
    assert (steps.values, loop.values) == ((300,), (3, 11))


def test_label_is_known_at_its_mark():
    port = ascii_port(b"A")
    assert port.decoded == []
    assert port.feed(b"$").decoded == [Label("A")]
    assert port.decoder.at_letter


def test_digits_are_counted():
    commands = ascii_port(b"B\rR 7\rR 007\rL 12,34\rL 12,B\rJ A\rB 55\r").decoded
    assert [command.digits for command in commands] == [0, 1, 3, 4, 2, 0, 0]
    assert [command.digits for command in binary_port("52 01 64 4E 02 E2 02").decoded] == [0, 0]


def test_values_of_labels():
    loop, jump = ascii_port(b"L 6,C\rJ A\r").decoded
    assert (loop.values, loop.stored) == ((6, 67), b"L\x06C")
    assert (jump.values, jump.stored) == ((65,), b"JA")


def test_number_65_is_not_a_label():
    assert ascii_port(b"J 65\r").texts == ["J 65"]


def test_too_long():
    fits = b"R " + b"0" * 253 + b"7\r"
    assert (ascii_port(fits).texts, ascii_port(fits).codes) == (["R 7"], [])
    port = ascii_port(b"R " + b"0" * 254 + b"7\rB\r")
    assert (port.texts, port.codes) == (["B"], ["too-long"])


def test_notes_say_what_is_allowed():
    port = Port()
    for byte in b"R 200\r":
        port.decoder.feed(byte, True, False)
    assert [note.text for note in port.decoder.notes] == ["RATE 200: allowed 0..127"]


@pytest.mark.parametrize(("stream", "first", "text"), [(b"R 7\r", True, "R 7"), (b"R\x01\x0d", False, "R 13")])
def test_mode_counts_with_the_letter(stream, first, text):
    decoder = LETTERS.decoder(SHEET)
    modes = [first] + [not first] * (len(stream) - 1)
    *early, command = [decoder.feed(byte, ascii, False) for byte, ascii in zip(stream, modes, strict=True)]
    assert (early, command.text) == ([None] * (len(stream) - 1), text)


@rows(("half", "ascii"), [(b"R 1", True), (b"K 1", True), (b"N\x02\x05", False), (b"K\x09", False), (b"N", False)])
def test_reset_forgets_half_a_command(half, ascii):
    port = Port(ascii).feed(half)
    port.decoder.reset()
    port.ascii = True
    assert port.decoder.at_letter
    assert port.feed(b"B\r").texts == ["B"]


# ------------------------------------------------------------------------------------------------- program entry

ROUTES = {
    "ascii": (True, b"E\rR 127\rN 300\r+\rG\rN 750\r-\rG\r0\rQ"),
    "separate counts": (False, BINARY("45 00 52 01 7F 4E 02 2C 01 2B 00 47 00 4E 02 EE 02 2D 00 47 00 30 00 51")),
    "single count": (False, BINARY("45 00 52 0C 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00 51")),
}


@pytest.mark.fact("EXAMPLE-BIN", "BIN-8", "BIN-9")
@rows(("route", "length"), [("ascii", 31), ("separate counts", 24), ("single count", 17)])
@rows("before", [b"", b"K\x01\r" * 2])
def test_three_routes_into_the_buffer(route, length, before):
    ascii, stream = ROUTES[route]
    assert len(stream) == length
    port = Port(ascii).feed(before)
    port.codes.clear()
    port.feed(stream)
    assert port.buffer == BINARY("52 7F 4E 2C 01 2B 47 4E EE 02 2D 47 00")
    assert port.codes == []
    assert (port.entering, port.decoder.at_letter) == (False, True)


@pytest.mark.fact("BIN-7")
def test_data_that_looks_like_quit():
    port = binary_port("45 00 52 01 51")
    assert port.entering
    port.feed(b"Q")
    assert (port.buffer, port.entering) == (b"RQ", False)


@pytest.mark.fact("PROG-3")
@pytest.mark.parametrize(("ascii", "stream"), [(True, b"E\r0\rQ"), (False, BINARY("45 00 30 00 51"))])
def test_command_0_is_stored_as_0(ascii, stream):
    assert Port(ascii).feed(stream).buffer == b"\0"


def test_only_the_first_count_may_be_free():
    assert binary_port("45 00 42 02 43 00 51").codes == []
    port = binary_port("45 00 43 00 42 02 43 00 51")
    assert (port.codes, port.buffer) == (["count"], BINARY("43 42 43 00"))


def test_every_entry_has_its_first_command():
    port = binary_port("45 00 42 02 43 00 51 45 00 43 02 42 00 51")
    assert (port.codes, port.buffer) == ([], BINARY("43 42 00"))


def test_garbage_does_not_count_as_first_command():
    port = binary_port("45 00 4B 01 42 42 02 43 00 51")
    assert (port.codes, port.buffer) == (["unknown-command"], BINARY("42 43 00"))


def test_entry_stores_short_data_as_they_came():
    port = binary_port("45 00 43 00 4E 01 05 4E 00 51")
    assert (port.codes, port.buffer) == (["count", "count"], BINARY("43 4E 05 4E"))


def test_command_mode_counts_are_filled_and_cut():
    short, long = binary_port("4C 01 03 52 02 07 09").decoded
    assert (short.values, short.stored) == ((3, 0), b"L\x03\0")
    assert (long.values, long.stored) == ((7,), b"R\x07")


def test_a_block_is_stored_unchecked():
    port = binary_port("45 00 30 04 30 4B 52 FF 51")
    assert port.buffer == BINARY("00 30 4B 52 FF")


@pytest.mark.fact("PROG-2")
def test_stored_forms():
    port = ascii_port(b"E\rP 258\rL 3,11\rR 5\rB\rQ")
    assert port.buffer == BINARY("50 02 01 4C 03 0B 52 05 42")


@pytest.mark.fact("PROG-10")
@rows("row", [row for row in SHEET.commands if row.terminated])
def test_entry_takes_commands_as_command_mode_does(row):
    values = [arg.low for arg in row.args]
    for ascii, command in ((True, encode_ascii(row, values)), (False, encode_binary(row, values))):
        port = Port(ascii).feed(encode_ascii(SHEET.commands["E"]) if ascii else b"E\0")
        port.feed(command)
        assert (port.buffer, port.codes, port.decoder.at_letter) == (row.pack(values), [], True)


# ------------------------------------------------------------------------------------------------------- encoders


def edges(arg):
    return sorted({arg.low, arg.low + 1, arg.high - 1, arg.high, 0x0D, 0x24, 0x51} & set(range(arg.low, arg.high + 1)))


@rows("row", SHEET.commands)
def test_encoders_and_decoder_agree(row):
    for values in product(*map(edges, row.args)):
        for port in (Port().feed(encode_ascii(row, values)), Port(False).feed(encode_binary(row, values))):
            (command,) = port.decoded
            assert (command.row, command.values, port.codes) == (row, values, [])
            assert command.stored == (row.pack(values) if row.stored else b"")


def test_encoders_by_the_book():
    loop = SHEET.commands["L"]
    assert encode_ascii(loop, (6, 67)) == b"L 6,67\r"
    assert encode_ascii(loop, (6, 67), labels="ABCDE") == b"L 6,C\r"
    assert encode_ascii(loop, (66, 3), labels="ABCDE") == b"L 66,3\r"
    assert encode_ascii(SHEET.commands["Q"]) == encode_binary(SHEET.commands["Q"]) == b"Q"
    assert encode_binary(SHEET.commands["N"], (300,)) == BINARY("4E 02 2C 01")
    assert encode_binary(SHEET.commands["0"]) == b"0\0"


@given(st.binary(max_size=60), st.booleans())
def test_any_bytes_are_taken(data, ascii):
    port = Port(ascii).feed(data)
    port.feed(b"\r\r" if ascii else bytes(512))  # an end to whatever was begun
    port.codes.clear()
    before = len(port.decoded)
    port.entering = False
    port.decoder.reset()
    port.feed(b"R 5\r" if ascii else b"R\x01\x05")
    assert port.texts[before:] == ["R 5"]
    assert port.codes == []


def commands_strategy():
    """Commands with arguments in their ranges, spelled for either mode."""
    rows = [row for row in SHEET.commands if row.terminated and row.name != "ENTER"]
    return st.lists(
        st.sampled_from(rows).flatmap(
            lambda row: st.tuples(st.just(row), st.tuples(*(st.integers(arg.low, arg.high) for arg in row.args)))
        ),
        max_size=12,
    )


@given(commands_strategy(), st.booleans(), st.booleans())
def test_streams_of_commands_round_trip(commands, ascii, entering):
    encode = encode_ascii if ascii else encode_binary
    port = Port(ascii)
    port.entering = entering
    port.feed(b"".join(encode(row, values) for row, values in commands), drain=True)
    assert [(command.row, command.values) for command in port.decoded] == commands
    assert port.codes == []
    assert port.buffer == (b"".join(row.pack(values) for row, values in commands) if entering else b"")


@given(commands_strategy(), st.data())
def test_any_split_gives_the_same(commands, data):
    stream = b"".join(encode_ascii(row, values) for row, values in commands)
    cut = data.draw(st.integers(0, len(stream)))
    port = Port().feed(stream[:cut])
    assert port.feed(stream[cut:]).decoded == ascii_port(stream).decoded


def test_an_unknown_line_does_not_begin_with_the_line_before_it():
    decoder = LETTERS.decoder(SHEET)
    for byte in b"R 100\r?":
        decoder.feed(byte, True, False)
    assert (decoder.at_letter, decoder.unfinished) == (False, "")
