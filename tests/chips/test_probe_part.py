"""A part that takes letters over a bus and over a serial line, both at once: what is spoken, and over what, are values.

The part is made up, and known to this file alone: whatever works here works because the sheet says so.
"""

import dataclasses
import json
import re

import pytest

import slewline
from slewline import chips
from slewline.bench.file import BenchFile
from slewline.bench.scripts.script import run_script
from slewline.core.chip import Chip
from slewline.core.datasheet.channel import BusHandshake, HostPort, SerialLine
from slewline.core.datasheet.command_rows import LineRow, PacketRow, TextRow, row_object
from slewline.core.datasheet.table import Arg, Pin, Row, Sheet, Table
from slewline.core.motion.axis import Axis
from slewline.core.motion.step_views import StrobeView
from slewline.core.motion.train import Playing, StepTrain
from slewline.core.wires.characters import frames_of, transmit
from slewline.core.wires.receiver import Receiver
from slewline.core.wires.serial import RS232, CharacterFormat, bit_clock
from slewline.core.wires.waits import level, until
from slewline.errors import BenchFileError, ProgramError, SheetError, UsageError
from slewline.language.assemble import assemble, to_ascii
from slewline.language.describe import describe
from slewline.language.dialect import Command, dialect_of, spoken_as
from slewline.language.lines import Lines
from slewline.language.lint import lint
from slewline.language.text import Letters
from slewline.links.lines.framing import FramedLine
from slewline.links.lines.pace import Lockstep
from slewline.links.lines.served_line import ConnectorLine as ServedLine
from slewline.links.server import Server

US = 1_000_000
SERIAL = SerialLine(bits=8, parity="none", stop=1, bauds={(): 9600})
TARGET = Arg("target", 1, 0, 99, label=True)


def row(form, name, *args, **more):
    return TextRow(form, name, args, 100, name.lower(), "p. 1", **more)


# fmt: off
PROBE = Sheet(
    part="probe", title="a probe", manual="none", buffer_bytes=100, labels="ST", suffix=".probe",
    pins=(
        Pin(1, "io_request", "in", "byte strobe", active=0, tie=1, role="request"),
        Pin(2, "io_select", "in", "who writes", active=1, tie=0, role="select"),
        Pin(3, "ready", "out", "ready", active=1, reset=1, role="ready"),
        Pin(4, "prog", "both", "program entry", active=0, pull=1, reset=1, role="program_entry"),
        Pin(5, "slew", "out", "steady rate", active=0, reset=1, role="slewing"),
        Pin(6, "ascii_binary", "in", "text or binary", active=1, pull=1, role="text"),
        Pin(7, "outstrobe", "out", "byte out", active=0, reset=1, role="out_strobe"),
        Pin(8, "motion_complete", "out", "at rest", active=0, reset=1, role="motion_complete"),
        Pin(9, "run", "out", "runs", active=0, reset=1, role="running"),
        *(Pin(10 + bit, f"d{bit}", "both", f"bit {bit}", active=1, role="data") for bit in range(8)),
        Pin(18, "sin", "in", "serial in", pull=0, role="serial_in"),
        Pin(19, "sout", "out", "serial out", reset=0, role="serial_out"),
        Pin(20, "step", "out", "a step", active=0, reset=1, role="step"),
    ),
    commands=Table(
        row("P", "NUMBER", Arg("steps", 2, 1, 60000)),
        row("M", "MOVE", motion=True),
        row("W", "WHERE", stored=False),
        row("B", "BEGIN", stored=False, role="enter"),
        row("K", "KEEP", stored=False, role="leave", terminated=False),
        row("H", "HALT", flow="", role="stop"),
        row("A", "AGAIN", TARGET, flow="t"),
        row("D", "DO", flow="0", role="run", stored=False),
        row("R", "ROUND", Arg("count", 1, 1, 9), TARGET, flow="nt", role="loop"),
    ),
    dialect=Letters(mark=":"),
    channels=(BusHandshake(), SERIAL),
)
# fmt: on


class Probe(Chip):
    """Obeys letters from wherever they come; over the serial line it answers each command."""

    sheet = PROBE
    baud, kept, up_ps = 9600, 0, 0

    def __init__(self, *args, **options):
        super().__init__(*args, **options)
        self.axes = (Axis(self.kernel, range(1 << 16), 0),)
        self.number, self.obeyed, self.on_bus, self.on_line = 1, [], False, False
        self.start()

    def strapped_address(self):
        return 0

    @property
    def registers(self):
        return {"number": self.number}

    async def run(self):
        self.outputs_reset()
        self.kernel.spawn(self.take_bytes, name="probe: bus")
        self.kernel.spawn(self.take_characters, name="probe: line")

    def obey(self, command, over):
        self.obeyed.append((self.kernel.now, over, command.text))
        if command.row.name == "NUMBER":
            (self.number,) = command.values
        elif command.row.name == "MOVE":
            playing = Playing(StepTrain(self.clock, self.tick, [(10**9, self.number)]))
            self.axes[0].follow(playing, 1)
            self.drivers["step"].play(StrobeView(playing, 2 * US))
        return str(self.position) if command.row.name == "WHERE" else "Y"

    async def take_bytes(self):
        request, ready = self.pins["io_request"].net, self.drivers["ready"]
        decoder = dialect_of(self.sheet).decoder(self.sheet)
        while True:
            self.idle = not self.on_line
            await level(request, 0)
            self.on_bus, self.idle = True, False
            found = decoder.feed(self.bus.byte, self.pin("ascii_binary").level == 1, False)
            ready.drive(0)
            await until(self.kernel, self.kernel.now + 50 * US)
            self.sync()
            if isinstance(found, Command):
                self.obey(found, "bus")
            await level(request, 1)
            self.on_bus = False
            ready.drive(1)

    async def take_characters(self):
        word, clock = CharacterFormat(8, "none", 1), bit_clock(9600, self.name)
        receiver = Receiver(self.pins["sin"].net, clock, word, RS232)
        decoder = dialect_of(self.sheet).decoder(self.sheet)
        while True:
            self.on_line, self.idle = False, not self.on_bus
            found = decoder.feed((await receiver.character()).byte, True, False)
            if isinstance(found, Command):
                self.on_line, self.idle = True, False
                self.sync()
                answer = self.obey(found, "serial").encode() + b"\r"
                self.kernel.spawn(
                    transmit, self.drivers["sout"], frames_of(clock.hz, word, RS232), answer, name="probe: answer"
                )


def furnished(journal=None):
    bench = slewline.Bench(journal=journal)
    x = bench.add(Probe, name="x")
    return bench, x


def run(bench):
    bench.run("1 ms")
    return bench


def test_both_channels_work_at_the_same_time():
    bench, x = furnished()
    bus, line = bench.host(x), bench.host(x, over="serial")
    bus.send("P 7\r" * 100 + "P 40\rM\r")
    assert line.ask("W") == "0"  # the answer comes while the bus is at work
    assert not bus.idle
    assert line.ask("P 3") == "Y"
    bench.run_until_idle()
    bench.run("100 ms")
    assert line.ask("W") == str(x.position) == str(x.number)
    ways = [over for _, over, _ in x.obeyed]
    first = ways.index("serial")
    assert "bus" in ways[:first] and "bus" in ways[first:]
    assert ways.count("bus") == 102 and ways.count("serial") == 3
    assert len(x.steps()) == x.position
    assert not bench.findings


def test_a_command_that_comes_over_one_channel_does_not_cut_into_the_other():
    bench, x = furnished()
    bus, line = bench.host(x, over="bus"), bench.host(x, over="serial")
    line.send("P 12")  # no carriage return yet
    bench.run("10 ms")
    bus.send("P 9\r")
    bench.run_until_idle()
    assert x.number == 9
    line.send("34\r")
    bench.run_until_idle()
    assert [text for *_, text in x.obeyed] == ["P 9", "P 1234"]


def test_the_first_channel_is_the_default_and_others_are_selected():
    bench, x = furnished()
    assert bench.host(x).channel is PROBE.channels[0]
    assert bench.host(x, over="serial").channel is SERIAL
    with pytest.raises(UsageError, match=r"over='port'; x \(probe\) has these channels: bus, serial"):
        bench.host(x, over="port")
    with pytest.raises(UsageError, match="baud 300; x has no serial line"):
        bench.host(x, baud=300)


def test_two_chips_share_a_channel_that_both_have():
    bench, x = furnished()
    y = bench.add("gs-c200s", straps={"sel0": 0})
    with pytest.raises(UsageError, match="some of these chips have a bus, some a serial line; use one host"):
        bench.host(x, y)


def test_a_script_uses_the_channel_of_its_host():
    bench, x = furnished()
    bus, line = bench.host(x, name="b"), bench.host(x, name="l", over="serial")
    told = []
    for host in (bus, line):
        host.on_event.add(told.append)
    run_script(bench, bus, "P 5\nM\n@wait 20 ms\n@note done")
    run_script(bench, line, "P 6\n@ask W")
    bench.run_until_idle()
    assert {"P 5", "M", "done", "P 6 -> Y"} <= set(told)
    assert any(text.startswith("W -> ") for text in told)
    for host, text, found in (
        (bus, "@ask W", "a directive for a module on a serial line; x (probe) has a bus"),
        (line, "@rate 5", "a directive for a chip on a bus; x (probe) is on a serial line"),
        (bus, "@expect 3", "for a chipset that takes packets; x (probe) takes none"),
        (line, "@until ready", "x (probe) has no command to query its busy state"),
    ):
        with pytest.raises(ProgramError) as error:
            run_script(bench, host, text)
        assert found in str(error.value)


def test_a_journal_records_the_channel(tmp_path):
    bench, x = furnished(tmp_path / "probe.journal")
    bench.host(x, over="serial")
    bench.host(x)
    bench.run("1 ms")
    kept = [json.loads(line) for line in (tmp_path / "probe.journal").read_text().splitlines()]
    assert [entry.get("over") for entry in kept if entry.get("do") == "host"] == ["serial", None]


def test_a_bench_file_selects_the_channel(tmp_path, monkeypatch):
    monkeypatch.setitem(chips.CATALOGUE.ours, "probe", f"{__name__}:Probe")
    file = tmp_path / "probe.toml"
    tables = (
        "[[chip]]",
        'part = "probe"',
        'name = "x"',
        "[[host]]",
        'script = ["P 4", "M"]',
        "[[host]]",
        'over = "serial"',
        'script = ["@ask W"]',
    )
    file.write_text("\n".join(tables))
    bench = slewline.load(file)
    bench.run("100 ms")
    assert {over for _, over, _ in bench["x"].obeyed} == {"bus", "serial"}
    for over, found in (("serial", "x has a host or a port already"), ("port", "x (probe) has these channels")):
        file.write_text("\n".join([*tables, "[[serve]]", f'over = "{over}"', 'tcp = "127.0.0.1:0"']))
        with pytest.raises(BenchFileError, match=re.escape(found)):
            BenchFile(file).served(run(slewline.load(file)))
    file.write_text("\n".join([*tables[:5], "[[serve]]", 'over = "serial"', 'tcp = "127.0.0.1:0"']))
    assert [port.over for port in BenchFile(file).served(run(slewline.load(file)))] == ["serial"]


def test_each_channel_is_served_by_its_own_line():
    bench, x = furnished()
    server = Server(bench, Lockstep(bench))
    bus, line = server.line(x, framing=True), server.line(x, over="serial")
    assert (type(bus), type(line)) == (FramedLine, ServedLine)
    assert sorted(server.lines) == ["x", "x_serial"]
    with pytest.raises(UsageError, match="already has a serial line, which needs no framing; leave out framing"):
        server.line(x, framing=True, over="serial")
    line.take(b"P 8\r")
    bus.take(b"P 9\rM\r")
    bench.run("100 ms")
    assert [text for *_, text in x.obeyed if text != "M"] in (["P 8", "P 9"], ["P 9", "P 8"])
    assert x.position > 0
    server.close()


# ------------------------------------------------------------------------------------------------- words of its own
def test_rules_and_texts_name_the_commands_of_the_part():
    found = {problem.code: problem for problem in lint("B\nS:P 5\nR 1,S", PROBE)}
    assert found["no-quit"].found == "a program without K: all lines after it are stored"
    assert found["no-end"].remedy == "end with H, or repeat with A"
    assert found["loop-once"].where == "PROBE manual, p. 1 R"
    (outside,) = (problem for problem in lint("T:P 5", PROBE) if problem.code == "label-outside")
    assert outside.remedy == "labels name instructions of a program, between B and K"
    (twice,) = (problem for problem in lint("B\nS:P 5\nS:A S\nK", PROBE) if problem.code == "label-twice")
    assert twice.found.startswith("label S: is defined twice")
    (early,) = (problem for problem in lint("D", PROBE) if problem.code == "no-program")
    assert early.remedy == "enter a program first, between B and K" and early.found.endswith("or a live H")
    assert "`S:`, `T:`" in describe(PROBE) and "CY5" not in describe(PROBE)


# -------------------------------------------------------------------------------------------- a program kept as text
class Text(Letters):
    """The same letters, but a program is kept as it was written: an instruction has no size but that of its text."""

    def stored(self, statement):
        return f"{statement.text}\r".encode()


TEXT = dataclasses.replace(PROBE, dialect=Text(mark=":"))


def test_sizes_of_instructions_are_those_of_the_dialect():
    program = "B\nP 500\nS:M\nA S\nK"
    tokens, text = assemble(program, PROBE), assemble(program, TEXT)
    assert [line.address for line in tokens.lines] == [0, 3, 4]
    assert [line.address for line in text.lines] == [0, 6, 10]
    assert (tokens.labels, text.labels) == ({"S": 3}, {"S": 6})
    assert text.stored == b"P 500\rS:M\rA S\r"
    assert to_ascii(tokens) == to_ascii(text)
    problem = next(p for p in lint("B\n" + "P 500\n" * 17 + "H\nK", TEXT) if p.code == "overflow")
    assert (problem.line, problem.allowed) == (18, "100")
    assert not any(p.code == "overflow" for p in lint("B\n" + "P 500\n" * 17 + "H\nK", PROBE))


def test_a_sheet_with_a_missing_or_wrong_dialect_is_reported():
    mute = dataclasses.replace(PROBE, dialect=None)
    with pytest.raises(SheetError, match="probe: no dialect"):
        dialect_of(mute)
    with pytest.raises(SheetError, match="probe: the dialect letters; expected a Lines"):
        spoken_as(PROBE, Lines)
    assert PROBE.channel(HostPort) is None
    with pytest.raises(SheetError, match="command LOOP: no role 'lop'"):
        row("L", "LOOP", role="lop")


def test_the_opcode_of_a_form_of_several_letters_is_its_first_letter():
    assert Row("AB", "ABSOLUTE", (), 0, "move to a position", "s.1").code == ord("A")


# ------------------------------------------------------------------------------------------- columns of a dialect
PLAIN = Row("V", "VERIFY", (), 1, "position", "p. 1", stored=False)


def test_a_plain_row_has_the_columns_of_its_dialect_in_the_sheet():
    lines = Sheet("mine", "mine", "none", (), Table(PLAIN), dialect=Lines())
    (row,) = lines.rows(LineRow)
    assert lines.commands["V"] is row and type(row) is LineRow
    assert (row.head, row.room, row.tail, row.name, row.stored) == ("V", 0, (), "VERIFY", False)
    again = dataclasses.replace(lines, part="other")
    assert again.commands is lines.commands and again.rows(LineRow) is again.rows(LineRow)
    assert lines.rows(Row) is lines.commands


def test_a_row_of_another_family_is_refused():
    with pytest.raises(SheetError, match="command KEEP: a TextRow; expected a LineRow"):
        dataclasses.replace(PROBE, commands=Table(PROBE.commands["K"]), dialect=Lines())
    with pytest.raises(SheetError, match="command NUMBER: a TextRow; expected a PacketRow"):
        PROBE.rows(PacketRow)


def test_json_has_the_columns_of_every_dialect():
    row, line = row_object(PROBE.commands["K"]), row_object(LineRow("G+", "GO", (), 1, "go", "p. 1", head="G"))
    assert set(row) == set(line)
    assert (row["terminated"], row["head"], row["acts"], row["reads"]) == (False, "K", "", ())
    assert (line["terminated"], line["head"]) == (True, "G")
