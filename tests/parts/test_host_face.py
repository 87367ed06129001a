"""One face for every host, whatever it speaks over; what it sees of a chip, and what a journal keeps of it."""

from __future__ import annotations

import ast
import inspect
import json
from dataclasses import replace
from pathlib import Path

import pytest

import slewline
from slewline.chips import PARTS as CHIPS
from slewline.chips import chip_class, sheet_of
from slewline.core.chip import Chip
from slewline.core.datasheet.channel import BusHandshake
from slewline.core.datasheet.table import Table
from slewline.core.time.kernel import Kernel
from slewline.core.time.timebase import Seconds, Time
from slewline.core.wires.net import Bus, Driver, Net
from slewline.core.wires.pin import Terminal
from slewline.core.wires.waits import level
from slewline.links.clients.chipset_host import ChipsetHost
from slewline.parts import KINDS, part_class
from slewline.parts.hosts.bus_host import BusHost
from slewline.parts.hosts.connection import Connection
from slewline.parts.hosts.host import Host
from slewline.parts.hosts.packet_host import AxisView, PacketHost
from slewline.parts.hosts.serial_host import SerialHost
from tests.rows import rows

OLD = Path(__file__).parents[1] / "core/journal_of_a_bus_host.jsonl"
STRAPS = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}  # 9600 baud, no checksums


class Desk:
    """A bench with a chip and its host: a question that is answered, its answer, and commands that are not."""

    def __init__(self, part, journal=None):
        self.bench = slewline.Bench(journal=journal)
        options = {"cy525": {"position": 0}, "gs-c200": {"straps": STRAPS}}.get(part, {})
        self.x = self.bench.add(part, name="x", **options)
        self.host = self.bench.host(self.x, name="host")
        self.question, self.answer, self.came = {
            "cy525": ("V 0", b"00000", b"00000"),
            "gs-c200": ("V1", "V0", b"V0\r"),
            "mc1451a": ("GET_VRSN", 0x5C11, [0x5C11, 0x5C7D]),
        }[part]
        self.command = {"cy525": "A 7\r", "gs-c200": "+50\r", "mc1451a": "SET_POS 7"}[part]
        self.settings = {"cy525": "R 20\r", "gs-c200": "V1\r", "mc1451a": "SET_VEL 20"}[part]
        self.bench.run("20 ms")  # a module does not hear through its RESET pulse

    def send(self, number):
        """Queue commands, one by one."""
        for _ in range(number):
            self.host.send(self.settings)


PARTS = pytest.mark.parametrize("part", ["cy525", "gs-c200", "mc1451a"])


@pytest.fixture
def desk(part):
    return Desk(part)


@PARTS
def test_a_question_brings_its_answer_and_what_came_in_is_received(desk):
    assert desk.host.ask(desk.question) == desk.answer
    assert list(desk.host.received) == list(desk.came)
    assert desk.host.idle and desk.host.waiting == "host: nothing to send"


@PARTS
def test_sending_only_queues_and_a_run_can_wait_for_the_answer(desk):
    condition = desk.host.got(desk.came)
    before = desk.bench.now_ps
    with desk.bench.kernel.outside.queued():
        desk.host.ask(desk.question)
    assert desk.bench.now_ps == before and not desk.host.idle and "host: " in desk.host.waiting
    assert not condition.met()
    desk.bench.run_until(condition, "1 s")
    assert list(desk.host.received) == list(desk.came)
    assert not desk.host.got([*desk.came, 1]).met() and not desk.host.got([1, *desk.came]).met()


@PARTS
def test_drop_leaves_what_has_begun_to_go_out_and_takes_the_rest(desk):
    desk.send(1)
    desk.host.send(desk.command)
    desk.bench.run("50 us")  # the first of them is under way
    desk.host.drop()
    desk.bench.run_until_idle()
    assert {found.code for found in desk.bench.findings} <= {"no-update"}  # what was sent waits for one
    whole = Desk(desk.x.sheet.part)
    whole.send(1)
    whole.bench.run_until_idle()
    assert dict(desk.x.registers) == dict(whole.x.registers) and desk.x.position == 0
    assert desk.host.received == whole.host.received


@pytest.mark.parametrize("part", ["cy525", "mc1451a"])
def test_drop_takes_everything_while_the_chip_is_not_ready(desk):
    desk.send(1)
    desk.bench.run_until_idle()
    desk.x.power(False)
    desk.bench.run("1 ms")
    desk.send(2)
    desk.bench.run("1 ms")
    assert not desk.host.idle
    desk.host.drop()
    assert desk.host.idle


@PARTS
def test_clear_forgets_all_and_lets_go_of_the_lines_and_the_host_can_speak_again(desk):
    desk.send(20)
    desk.bench.run("50 us")
    desk.host.clear()
    assert desk.host.idle
    levels = {"cy525": ("io_request", 1), "gs-c200": ("rxd", 0), "mc1451a": ("hostslct", 1)}
    pin, level = levels[desk.x.sheet.part]
    assert desk.x.pin(pin).level == level
    desk.bench.run("200 ms")
    restored = {"cy525": "\r", "gs-c200": "\r", "mc1451a": ""}[desk.x.sheet.part]  # what was cut ends here
    desk.host.send(restored)
    desk.bench.run("100 ms")
    assert desk.host.ask(desk.question) == desk.answer


@pytest.mark.parametrize("part", ["cy525", "mc1451a"])  # to a module a question has gone out when ask() waits
def test_a_task_waiting_for_a_dropped_request_is_notified(desk):
    desk.send(1)
    desk.bench.at(desk.bench.now_ps + 10**7, desk.host.drop)
    with pytest.raises(slewline.UsageError, match=r"host: .*: dropped by (drop|clear)\(\)"):
        desk.host.ask(desk.question)


@PARTS
def test_nobody_answers_a_question_that_is_none(desk):
    if desk.x.sheet.part == "gs-c200":
        assert desk.host.ask("%") == "E4"  # the module says so
        return
    with pytest.raises(slewline.UsageError, match=r"has no answer|returns nothing"):
        desk.host.ask({"cy525": "R 20", "mc1451a": "UPDATE"}[desk.x.sheet.part])
    assert desk.host.idle and not desk.host.received


@PARTS
def test_a_journal_repeats_what_a_host_did(tmp_path, part):
    desk = Desk(part, journal=tmp_path / "journal")
    desk.host.ask(desk.question)
    desk.send(3)
    desk.bench.run("50 us")
    desk.host.drop()
    desk.bench.run("30 ms")
    desk.send(2)
    desk.bench.run("50 us")
    desk.host.clear()
    desk.bench.run("30 ms")
    again = slewline.replay(tmp_path / "journal")
    assert again["host"].received == desk.host.received
    assert dict(again["x"].registers) == dict(desk.x.registers) and again.findings == desk.bench.findings
    done = {json.loads(line)["do"] for line in (tmp_path / "journal").read_text().splitlines()}
    assert done == {"journal", "add", "host", "input", "run"}  # no words of its own


def test_a_journal_with_the_entries_of_before_replays():
    again = slewline.replay(OLD)
    x, y, host = again["x"], again["y"], again["host"]
    assert host.received == bytearray.fromhex("3030323030000730303230300223") and host.sent == 94
    assert (x.position, x.travel, y.position, again.now_ps) == (0, 591, 5, 205_079_545_454)
    assert x.steps().times_ps[-1] == 190_816_818_181 and x.registers["number"] == 50
    words = {entry["do"] for entry in map(json.loads, OLD.read_text().splitlines())}
    assert {"send", "call", "drop", "clear"} <= words


# ------------------------------------------------------------------------------------------------------ never the chip
@PARTS
def test_a_host_holds_wires_a_sheet_and_straps_and_never_a_chip(desk):
    host, seen = desk.host, set()

    def held(thing, path):
        if id(thing) in seen or len(path) > 5:
            return
        seen.add(id(thing))
        assert not isinstance(thing, Chip), path
        values = vars(thing) if hasattr(thing, "__dict__") else {}
        names = getattr(type(thing), "__slots__", ())
        values = dict(values) | {name: getattr(thing, name) for name in names if hasattr(thing, name)}
        if isinstance(thing, dict):
            values = thing
        elif isinstance(thing, (list, tuple, set)):
            values = dict(enumerate(thing))
        for name, value in values.items():
            if type(value).__module__.startswith("slewline.parts") or isinstance(value, (dict, list, tuple, Chip)):
                held(value, (*path, name))

    held(host, ("host",))
    assert all(type(connection) is Connection for connection in host.chips.values())
    assert len(seen) > 3


def test_a_module_that_is_switched_on_again_is_given_time():
    desk = Desk("gs-c200")
    desk.x.power(False)
    desk.bench.run("1 ms")
    desk.x.power(True)
    begun = desk.bench.now_ps
    desk.bench.record("x.rxd")
    desk.host.send("V1\r")
    desk.bench.run("5 ms")
    assert desk.bench.edges("x.rxd")[0][-1] > begun
    assert desk.bench.edges("x.rxd", start=begun)[0][0] == begun + 10**9  # not before it hears


# --------------------------------------------------------------------------------------------------------- signatures
FACE = ("send", "ask", "got", "received", "drop", "clear", "idle", "waiting")


@pytest.mark.parametrize("cls", [BusHost, SerialHost, PacketHost])
def test_every_host_has_the_face(cls):
    assert issubclass(cls, Host)
    assert [name for name in FACE if name != "received" and not hasattr(cls, name)] == []
    assert [name for name in ("send", "ask", "got") if getattr(cls, name) is getattr(Host, name)] == []
    assert [name for name in FACE if name not in (cls.__doc__ or "") + (inspect.getmodule(Host).__doc__ or "")] == []


@rows("cls", [BusHost, SerialHost, PacketHost, AxisView, ChipsetHost])
def test_a_timeout_is_a_time_everywhere(cls):
    calls = [call for _, call in inspect.getmembers(cls, inspect.isfunction)]
    told = [inspect.signature(call, eval_str=False).parameters.get("timeout") for call in calls]
    types = {parameter.annotation for parameter in told if parameter is not None}
    assert types == {"Time"} and Time == str | int | Seconds
    assert all(isinstance(p.default, str) for p in told if p is not None and p.default is not inspect.Parameter.empty)


# ---------------------------------------------------------------------------------------------------------------- names
STUB = Path(slewline.__file__).parent / "bench/by_name.pyi"


@pytest.mark.parametrize(
    ("protocol", "found"),
    [
        ("Adds", {number: chip_class(number).__name__ for number in CHIPS}),
        ("Makes", {kind: part_class(kind).__name__ for kind in KINDS}),
    ],
)
def test_the_stub_describes_every_name_of_a_bench(protocol, found):
    (body,) = [node.body for node in ast.parse(STUB.read_text()).body if getattr(node, "name", "") == protocol]
    pairs = [(case.args.args[0].annotation, ast.unparse(case.returns)) for case in body]
    told = {ast.literal_eval(given.slice): cls for given, cls in pairs if ast.unparse(given).startswith("Literal")}
    assert told == found
    assert [cls for given, cls in pairs if ast.unparse(given) == "str"] == [{"Adds": "Chip", "Makes": "Part"}[protocol]]


def test_a_decorator_for_types_leaves_the_method_unchanged():
    assert inspect.signature(slewline.Bench.add).parameters["crystal"].default is None
    assert slewline.Bench.host.__doc__.startswith("Put a host computer")


# ------------------------------------------------------------------------------------------------------ without a chip
def bare_port(*lacking):
    """A host, on wires at whose end a test stands: the wires of a CY525, except those of some roles."""
    full = sheet_of("cy525")
    rows = tuple(row for row in full.pins if row.role not in lacking)
    channels = (BusHandshake(),) if "select" in lacking else full.channels
    sheet = replace(full, pins=rows, channels=channels)
    kernel = Kernel()
    bus = Bus(kernel, "x.db")
    pins = {row.name: Terminal("x", row, Net(kernel, f"x.{row.name}", tie=row.reset)) for row in rows}
    connection = Connection(name="x", sheet=sheet, channel=sheet.channels[0], pins=pins, crystal_hz=11_000_000, bus=bus)
    return kernel, pins, bus, BusHost(kernel, "host", [connection])


def test_a_host_works_on_wires_with_nothing_but_a_sheet():
    kernel, pins, bus, host = bare_port("select", "slewing", "out_strobe")
    ready, taken = Driver(pins["ready"].net, "test"), []

    async def take():
        while True:
            await level(pins["io_request"].net, 0)
            taken.append(bus.byte)
            ready.drive(0)
            await level(pins["io_request"].net, 1)
            ready.drive(1)

    ready.drive(1)
    kernel.spawn(take, name="test")
    host.send("R 20\r")
    kernel.settle()
    assert bytes(taken) == b"R 20\r" and host.idle and host.sent == 5


@rows(
    ("call", "text"),
    [
        (lambda host: host.change_rate(9), r"host: x \(cy525\) accepts no rate on the fly: the part has no pin"),
        (lambda host: host.read_position(), "outputs no position on the fly"),
        (lambda host: host.verify(0), "the part accepts commands but cannot be read"),
        (lambda host: host.ask("V 0"), "'V 0' has no answer; the part accepts commands but cannot be read"),
        (lambda host: host.live("B"), "accepts no commands while its program runs"),
    ],
)
def test_requests_without_pins_for_them_are_refused_immediately(call, text):
    *_, host = bare_port("select", "slewing", "out_strobe", "program_entry")
    with pytest.raises(slewline.UsageError, match=text):
        call(host)
    assert host.idle


def test_the_sheet_gives_a_host_the_commands_with_several_lines_of_answer():
    ours = chip_class("gs-c200s")

    class Other(ours):
        """A module that knows the same command, but does not list its program by it."""

        sheet = replace(
            ours.sheet,
            commands=Table(*(replace(row, role=row.role * (row.role != "list")) for row in ours.sheet.commands)),
        )

    for cls, listed in ((ours, "D5\rD6\rEND"), (Other, "D5")):
        bench = slewline.Bench()
        host = bench.host(bench.add(cls, straps=STRAPS))
        for line in ("Po", "D5", "D6", "Px"):
            assert host.ask(line) == "Y"
        assert host.ask("Q") == listed


def test_a_host_takes_the_letter_that_points_at_a_group_from_the_sheet():
    ours = chip_class("cy525")
    rows = (replace(row, form="Y") if row.role == "read" else row for row in ours.sheet.commands)

    class Other(ours):
        """A chip in which another letter points at a group."""

        sheet = replace(ours.sheet, commands=Table(*rows))

    bench = slewline.Bench()
    host = bench.host(bench.add(Other, number=300))
    assert host.verify(3)[:2] == host.ask("Y 3")[:2] == bytes([1, 44])
    with pytest.raises(slewline.UsageError, match=r"'V 3' has no answer; ask\(\) is for 'Y 0', 'Y 1'"):
        host.ask("V 3")
