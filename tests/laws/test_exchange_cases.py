"""Exchanges that are disturbed at each edge of one of them, and a picosecond beside it; and what the law has found."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

import slewline
from tests.ensembles import few

from . import exchange_cy545, exchange_mc
from .exchange_cy545 import Remembering
from .exchange_mc import Spoken
from .exchanges import MS, NS, US, Act, Dialogue, World, differences, edges_of, played


def agree(make: type[World], dialogue: Dialogue) -> None:
    """Compare a dialogue with both of its twins."""
    fast = played(make, dialogue)
    for twin in ("recorded", "played"):
        found = differences(fast, played(make, dialogue, twin, dialogue.seed))
        assert not found, f"{twin}: {found[:3]}\n  {dialogue.acts}"


# ------------------------------------------------------------------------------------------------------ edge after edge
def memory(kind: str = "ram", crystal: str = "12 MHz", display: bool = False, **options: Any) -> dict[str, Any]:
    chip = {name: options.pop(name) for name in ("inferred",) if name in options}
    return {
        "crystal": crystal,
        "of the chip": chip,
        "memory": kind,
        "of the memory": options,
        "display": display,
    }


def host(crystal: int = 25_000_000, other: str = "", delay: int = 0, first: str = "sent") -> dict[str, Any]:
    return {"crystal": crystal, "other": other, "delay": delay, "first": first}


READS = Dialogue(1, "cy545b", "Y 250\rX\r", memory(image=b"\xff" * 250 + b"A 77\rN 2\r0\r"), 3 * MS)
KEEPS = Dialogue(1, "cy545b", READS.sent, READS.options | {"memory": "eeprom"}, 3 * MS)
WRITES = Dialogue(1, "cy545b", "Y 5\rE\rN 2\rQ\r", memory("eeprom", write_time=150 * US), 9 * MS)
SPEAKS = Dialogue(1, "mc1151a", "SET_POS 0x12345\nGET_POS\nGET_VRSN", host(), 4_400 * US)
AT_ONE: dict[str, list[tuple[int, str, tuple[Any, ...]]]] = {  # so long behind the instant, what is done
    "record": [(0, "record", ("RD",))],
    "record the bus": [(0, "record", ("DB",))],
    "drive the bus": [(0, "drive", ("DB0",)), (7 * NS, "release", ("DB0",))],
    "drive a strobe": [(0, "drive", ("RD",)), (9 * NS, "release", ("RD",))],
    "wait": [(0, "edges", ("RD", 2, 100 * US))],
    "reset": [(2, "pulse", ("x.reset", "RESET", 5 * US))],
    "power": [(1, "power", ("x", False)), (3 * US, "power", ("x", True))],
    "load": [(0, "load", (b"B 0\rB 0\r" * 3, 250))],
    "halt": [(0, "halt", ()), (1, "send", (b"\x6c",)), (40 * NS, "word", (300 * US,))],
    "listen": [(0, "listen", ())],
    "look": [(0, "look", ())],
}
ALONE = {"record", "edges", "power", "halt", "send", "word", "listen"}  # never done within a run
ONLY = {"load": ("reads", "writes", "keeps"), "halt": ("speaks",)}
NAMES = {
    "reads": {"RD": "x.rd", "DB": "memory.db", "DB0": "x.db0", "RESET": 1},
    "keeps": {},
    "writes": {"RD": "x.rd", "DB": "memory.db", "DB0": "x.db0", "RESET": 1},
    "speaks": {"RD": "x.hostread", "DB": "x.hostdata3", "DB0": "x.hostdata0", "RESET": 0},
}
OF = {
    "reads": (Remembering, READS),
    "keeps": (Remembering, KEEPS),
    "writes": (Remembering, WRITES),
    "speaks": (Spoken, SPEAKS),
}


@cache
def instants(what: str) -> list[int]:
    """The edges of a few exchanges, and what lies beside and between them."""
    make, dialogue = OF[what]
    world = played(make, dialogue, "recorded", 1)
    wires = exchange_mc.CONTROLS if make is Spoken else exchange_cy545.CONTROLS
    marks = edges_of(world, tuple(f"x.{name}" for name in wires), 1000)
    start = {"reads": 0, "keeps": 0, "writes": 4, "speaks": 8}[what]
    found = marks[start : start + 14]
    if what == "speaks":
        found += [mark for mark in marks if mark > edges_of(world, ("x.hostread",), 1000)[0] - 50 * NS][:7]
    return sorted({at + beside for at in found for beside in (-1, 0, 1, 20 * NS)})


@pytest.mark.parametrize("every", few((15, 1), 1))  # every so many instants
@pytest.mark.parametrize(
    ("what", "how", "within"),
    [
        (what, how, within)
        for what in OF
        for how, does in AT_ONE.items()
        for within in ((False,) if ALONE.issuperset(act[1] for act in does) else (False, True))
        if what in ONLY.get(how, ("reads", "writes", "speaks"))
    ],
)
def test_a_disturbance_at_any_edge_has_the_same_effect_as_edge_by_edge(
    what: str, how: str, within: bool, every: int
) -> None:
    """From another instant on for each way to disturb it."""
    make, quiet = OF[what]
    for at in instants(what)[(list(AT_ONE).index(how) + 9) % every :: every]:
        acts = []
        for late, does, args in AT_ONE[how]:
            named = tuple(NAMES[what].get(arg, arg) if isinstance(arg, str) else arg for arg in args)
            if does == "drive":
                named = (*named, 0)
            acts.append(Act(at + late, does, named, within and does not in ALONE))
        dialogue = Dialogue(at, quiet.part, quiet.sent, quiet.options, max(at + 130 * US, quiet.until_ps // 2), acts)
        fast = played(make, dialogue)
        found = differences(fast, played(make, dialogue, "recorded" if at % 3 else "played", at))
        assert not found, f"{found[:3]}\n  {acts}"


def at_any_edge(make: type[World], quiet: Dialogue, first: int, last: int) -> list[int]:
    """The edges of a quiet dialogue, by number, and what lies beside and between them."""
    world = played(make, quiet, "recorded", 1)
    wires = exchange_mc.CONTROLS if make is Spoken else exchange_cy545.CONTROLS
    marks = edges_of(world, tuple(f"x.{name}" for name in wires), 1000)[first:last]
    return [at + beside for at in marks for beside in (-1, 0, 1, 600 * NS)]


@pytest.mark.parametrize(
    ("display", "every"),
    [(True, 5), pytest.param(True, 1, marks=pytest.mark.long), pytest.param(False, 1, marks=pytest.mark.long)],
)
def test_an_address_is_in_every_latch_in_its_time_and_in_none_before(display: bool, every: int) -> None:
    """The first read is the first one by value; the others go on behind the end of a page."""
    options = memory(image=b"\xff" * 253 + b"A 77\rN 2\r0\r", display=display)
    quiet = Dialogue(1, "cy545b", "Y 253\rX\r", options, 3 * MS)
    for at in [*at_any_edge(Remembering, quiet, 0, 14), *at_any_edge(Remembering, quiet, 17, 29)][::every]:
        agree(Remembering, Dialogue(1, quiet.part, quiet.sent, options, at))


@pytest.mark.parametrize("every", few((13, 1), 1))
def test_a_bit_of_the_bus_is_taken_back_by_the_read_after_it(every: int) -> None:
    options = memory(image=b"B 8\rB 0\r? B\rB 24\rB 8\rT 8,0\r0\r")
    quiet = Dialogue(1, "cy545b", "O 81H\rY 0\rX\r", options, 6 * MS)
    agree(Remembering, quiet)
    for at in at_any_edge(Remembering, quiet, 20, 60)[::every]:
        agree(Remembering, Dialogue(1, quiet.part, quiet.sent, options, at))


def test_two_memories_on_one_select_line_disagree_edge_by_edge() -> None:
    acts = [Act(100 * US, "add", ("ram", 1))]
    agree(Remembering, Dialogue(1, "cy545b", "Y 250\rX\r", READS.options, 3 * MS, acts))


@pytest.mark.parametrize("every", few((5, 1), 1))
def test_the_end_of_a_write_may_come_at_any_edge_of_a_poll(every: int) -> None:
    world = played(Remembering, WRITES, "recorded", 1)
    begin = next(time for time, level in world.recorded("x.wr", 0) if level == 1)
    polls = [at for at in at_any_edge(Remembering, WRITES, 0, 40) if at > begin + 1000]
    for at in polls[::every]:
        options = memory("eeprom", write_time=at - begin)
        agree(Remembering, Dialogue(1, "cy545b", WRITES.sent, options, begin + 700 * US))


def test_half_a_word_is_written_or_read_and_the_rest_after_it() -> None:
    soon = 300 * US
    for acts in (
        [("send", (b"\x10",)), ("write", (0x12, soon)), ("write", (0x1345, soon)), ("write", (0x34, soon))],
        [("send", (b"\x6c",)), ("byte", (soon,)), ("word", (soon,)), ("byte", (soon,))],
        [("send", (b"\x6c",)), ("byte", (soon,)), ("write", (0x12, soon)), ("write", (0x1345, soon))],
    ):
        done = [Act(4_400 * US + number, what, args) for number, (what, args) in enumerate(acts)]
        agree(Spoken, Dialogue(1, "mc1151a", SPEAKS.sent, SPEAKS.options, 6_000 * US, done))


def test_a_word_is_read_too_early() -> None:
    done = [Act(4_400 * US, "send", (b"\x10\x12\x34",)), Act(4_400 * US + 1, "word", (300 * US,))]
    agree(Spoken, Dialogue(1, "mc1151a", SPEAKS.sent, SPEAKS.options, 6_000 * US, done))
    done = [Act(4_400 * US, "packet", (2, 0x10, 0x1234)), Act(4_401 * US, "packet", (1, 0x6C))]
    agree(Spoken, Dialogue(1, "mc1151a", SPEAKS.sent, SPEAKS.options, 6_000 * US, done))


def test_the_port_is_made_busy_by_another_task_while_the_host_thinks() -> None:
    options = host(delay=7 * US)
    quiet = Dialogue(1, "mc1151a", SPEAKS.sent, options, 4_400 * US)
    world = played(Spoken, quiet, "recorded", 1)
    for ready in [time for time, level in world.recorded("x.hostrdy", 0) if level == 1][:6]:
        done = [
            Act(ready + 2 * US, "drive", ("x.hostslct", 0)),
            Act(ready + 2 * US + 50 * NS, "pulse", ("x.hostwrite", 0, 80 * NS)),
            Act(ready + 2 * US + 250 * NS, "pulse", ("x.hostwrite", 0, 80 * NS)),
            Act(ready + 3 * US, "release", ("x.hostslct",)),
        ]
        agree(Spoken, Dialogue(1, "mc1151a", quiet.sent, options, ready + 400 * US, done))


def test_a_foreign_strobe_comes_soon_after_an_operation() -> None:
    world = played(Spoken, SPEAKS, "recorded", 1)
    ends = [time for time, level in world.recorded("x.hostslct", 0) if level == 1]
    for end in ends[:5]:
        done = [Act(end - 75 * NS, "drive", ("x.hostread", 0)), Act(end - 30 * NS, "release", ("x.hostread",))]
        agree(Spoken, Dialogue(1, "mc1151a", SPEAKS.sent, SPEAKS.options, end + 400 * US, done))


# ---------------------------------------------------------------------------------------------- what has been found
CASES: dict[str, tuple[type[World], Dialogue]] = {
    "an EEPROM has written its byte as it is read": (
        Remembering,
        Dialogue(
            5902,
            "cy545b",
            "Y 250\rE\rI\rJ 0\r0\rQY 250\rX\r",
            memory("eeprom", crystal="3.579545 MHz", write_time=73_752_391),
            14_626_058_619,
            [
                Act(6_446_629_390, "gate", ("memory.rd", 1)),
                Act(6_453_334_151, "drive", ("x.rd", 0)),
                Act(6_453_374_151, "release", ("x.rd",)),
            ],
        ),
    ),
    "somebody else strobes WR": (
        Remembering,
        Dialogue(
            2600,
            "cy545",
            "O 81H\rY 250\rX\r",
            memory("ram", image=b"\xff" * 250 + b"[1,1,2\rB 0\rG\rA 77\rA 77\rL 2,0\r0\r\xb1", size=2048),
            1_574_000_000,
            [
                Act(1_330_999_000, "drive", ("x.wr", 0), within=True),
                Act(1_331_000_000, "release", ("x.wr",)),
                Act(1_466_382_801, "gate", ("x.wr", 1)),
                Act(1_560_999_999, "record", ("x.busy",)),
            ],
        ),
    ),
    "a select line was pulled low before": (
        Remembering,
        Dialogue(
            21804,
            "cy545b",
            "Y 0\rE\rN #\r0\rQY 0\rX\r",
            memory("ram", crystal="11 MHz", display=True),
            2_606_090_909,
            [Act(1_531_848_267, "pulse", ("x.xmem_sel", 0, 1000), within=True)],
        ),
    ),
    "RD falls from outside as ALE falls": (
        Remembering,
        Dialogue(
            39803,
            "cy545b",
            "Y 0\rE\r+\r+\rB 16\rT 24,0\r0\rQY 0\rX\r",
            memory("ram"),
            9_376_000_000,
            [Act(4_436_000_000, "pulse", ("memory.rd", 0, 256_040_333), within=True)],
        ),
    ),
    "a function looks at the strobes": (
        Remembering,
        Dialogue(
            2403,
            "cy545",
            "Y 0\rE\rB 16\rB 16\rB 0\rA 77\r+\rT 16,0\r0\rQY 0\rX\r",
            memory("ram"),
            12_000_000_000,
            [Act(8_444_001_000, "function", ("x.ale", 0, 1_000_000_000))],
        ),
    ),
    "HostWrite is held low as it would rise": (
        Spoken,
        Dialogue(
            17703,
            "mc1151a",
            "SET_POS 1000",
            host(crystal=20_000_000, first="last"),
            4_607_900_000,
            [
                Act(4_302_780_000, "halt", ()),
                Act(4_302_780_000, "drive", ("x.hostwrite", 0), within=True),
                Act(4_302_820_000, "release", ("x.hostwrite",), within=True),
                Act(4_405_480_000, "record", ("x.hostdata3",)),
            ],
        ),
    ),
    "HostRead is held high as it would rise": (
        Spoken,
        Dialogue(
            303,
            "mc1151a",
            "SET_1\nGET_TIME\nUPDATE\nSET_ACC 1024",
            host(crystal=20_000_000, first="last"),
            5_531_750_000,
            [
                Act(5_329_330_000, "drive", ("x.hostread", 1), within=True),
                Act(5_330_330_000, "release", ("x.hostread",)),
            ],
        ),
    ),
    "the host is broken off in a word, and goes on": (
        Spoken,
        Dialogue(
            11000,
            "mc1151a",
            "SET_PRFL_VEL\nGET_HOME",
            host(crystal=20_000_000),
            4_611_450_000,
            [
                Act(4_507_990_000, "halt", ()),
                Act(4_507_990_001, "send", (b"\x10\x00\x01\x00",)),
                Act(4_508_021_523, "write", (295, 300_000_000)),
                Act(4_508_109_000, "drive", ("x.hostslct", 0)),
                Act(4_508_110_000, "release", ("x.hostslct",)),
            ],
        ),
    ),
    "HostRead is held low between two words": (
        Spoken,
        Dialogue(
            125901,
            "mc1251a",
            "GET_HOME\nGET_STATUS",
            host(crystal=20_000_000),
            5_713_150_000,
            [
                Act(4_405_201_000, "gate", ("x.hostcmd", 1)),
                Act(4_405_208_489, "send", ("GET_HOME",)),
                Act(4_507_760_000, "drive", ("x.hostread", 0)),
                Act(4_554_274_191, "gate", ("x.hostrdy", 2)),
                Act(4_561_978_876, "release", ("x.hostread",), within=True),
            ],
        ),
    ),
    "HostWrite falls as HostRead rises": (
        Spoken,
        Dialogue(
            208703,
            "mc1451a-e",
            "GET_VRSN\nSET_PRFL_VEL\nSET_VEL 65536\nSET_PRFL_VEL",
            host(delay=1_000),
            4_100_881_000,
            [
                Act(3_935_521_000, "pulse", ("x.hostwrite", 0, 40000), within=True),
                Act(4_017_481_000, "send", ("SET_VEL 65536",)),
                Act(4_017_490_000, "edges", ("x.hostread", 30, 1_000_000_000)),
                Act(4_058_620_500, "function", ("x.hostwrite", 0, 200_000_000)),
            ],
        ),
    ),
    "HostRdy is held low as it would fall": (
        Spoken,
        Dialogue(
            29304,
            "mc1151a-e",
            "SET_POS -9\nGET_STATUS\nSET_1\nUPDATE",
            host(delay=7_000_000, first="last"),
            4_348_560_000,
            [Act(4_265_640_000, "drive", ("x.hostrdy", 0), within=True), Act(4_265_641_000, "release", ("x.hostrdy",))],
        ),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_past_findings_of_the_law(name: str) -> None:
    agree(*CASES[name])


def broken_off(at: int, recorded: bool) -> tuple[Any, ...]:
    """What a host reads that is broken off in the first word of GET_VRSN, at an instant, and then asks for a byte."""
    bench = slewline.Bench()
    host = bench.host(bench.add("mc1151a", name="x"))
    if recorded:
        bench.record("x.hostread")
    host.command("CLR_STATUS")
    host.send("GET_VRSN")
    if not at:
        bench.run_until_idle()
        times, _ = bench.edges("x.hostread")
        return (times[4],)  # behind the checksum of CLR_STATUS
    bench.run_to(at)
    host.queue.requests.clear()
    host.queue.halt()
    return host.read_byte(), host.read_byte(), list(host.received), list(map(str, bench.findings)), bench.now_ps


@pytest.mark.parametrize("later", [81, 105, 110, 130, 159])
def test_a_host_that_is_aborted_leaves_no_watch_on_the_bus(later: int) -> None:
    at = int(broken_off(0, True)[0]) + later * 1000
    assert broken_off(at, False) == broken_off(at, True)
