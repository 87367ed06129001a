"""What is put on a bench after time has passed works like what was there from the beginning."""

from __future__ import annotations

from random import Random

import pytest

import slewline
from slewline.chips import PARTS
from slewline.core.wires.net import Bus, Driver
from slewline.parts import KINDS, part_class
from tests.rows import rows

S, MS = 10**12, 10**9  # picoseconds; whole seconds lie on the clocks of all parts
OPTIONS = {
    "prom": {"image": bytes([65, 32, 48, 13, 255])},
    "workpieces": {"change": "20 ms"},
    "switch": {"low": 1, "high": 3},
}
CALLS = {  # what a user tells a part of a kind, where pins alone do not set it in motion
    "serial_sender": [("send", "U")],
    "serial_port": [("write", "U")],
    "rs232_line": [("send_break", "to_host", "1 ms")],
    "encoder": [("push", 5)],
    "quadrature": [("run", 1000)],
    "ppi8255": [("sendchar", "A")],
    "host8080": [("send", b"A\xff")],
    "keyboard": [("type", "A")],
    "jog_switch": [("ccw",)],
    "gpib_talker": [("send", "A")],
    "gpib_controller": [("send", "A")],
}
LAZY = ("position", "place", "state", "held", "pulses", "lost")  # what a part works out when it is asked
INSTANTS = {
    "arrives_ps",
    "pulsed_ps",
    "_braked_ps",
    "_wired_ps",
    "_read_ps",
    "_begun_ps",
    "_since",
}  # as attributes have them


def told(part, late: int) -> dict:
    """What the attributes of a part say, its instants from `late` on."""
    plain = {key: value for key, value in vars(part).items() if type(value) in (int, bool, bytes, bytearray, str)}
    state = {key: value for key, value in plain.items() if key not in ("since", "reset_until", "tick")}
    state |= {key: state[key] - late for key in INSTANTS & state.keys() if state[key]}
    state |= {key: getattr(part, key) for key in LAZY if hasattr(part, key)}
    return state | {
        "findings": [(found.time_ps - late, found.code) for found in part.findings],
        "past": [(ps - late, value) for ps, value in getattr(part, "past", [])],
    }


def stimulated(kind: str, late: int) -> tuple[list, dict, bool]:
    """A part that is put on the bench at `late`, and whose inputs then change at random: its edges, its
    state, and whether it did anything at all."""
    bench = slewline.Bench()
    if late:
        bench.run_to(late)
    carrier = bench.part("translator") if part_class(kind).sits == "must" else None
    part = bench.part(kind, on=carrier, **OPTIONS.get(kind, {}))
    drivers = {}
    for name, terminal in {**(carrier.pins if carrier else {}), **part.pins}.items():
        if terminal.row.in_out != "out":
            drivers[name] = Driver(terminal.net, "test")
    bench.run("1 us")
    before = told(part, late)
    for name in part.pins:
        bench.record(f"{part.name}.{name}")
    for verb, *args in CALLS.get(kind, ()):
        getattr(part, verb)(*args)
    chance = Random(kind)
    for _ in range(100):
        for driver in drivers.values():
            if chance.random() < 0.5:
                level = chance.choice([0, 1])
                driver.drive((255, level * chance.randrange(256)) if isinstance(driver.net, Bus) else level)
        bench.run(chance.choice([10**6, 10**8, 10**10]))
    edges = []
    for name in part.pins:
        times, levels = bench.edges(f"{part.name}.{name}")
        edges += [(name, int(ps) - late, int(level)) for ps, level in zip(times, levels, strict=True)]
    lives = told(part, late) != before or any(part.pins[name].row.in_out != "in" for name, _, _ in edges)
    return edges, told(part, late), lives


@rows("kind", KINDS)
def test_a_part_added_late_works_like_an_early_one(kind):
    early, late = stimulated(kind, 0), stimulated(kind, S)
    assert late == early
    assert early[2], "the test sees nothing of it"


# ---------------------------------------------------------------------------------------------------- chips and hosts
STRAPS = {"gs-c200": {"br0": 0, "br1": 0, "br2": 0, "chs": 0}}


def asked(host, part: str) -> list:
    """A host tells a chip to move, and reads something back."""
    if part.startswith("cy525"):
        host.send("A 0\rF 20\rR 60\rS 240\rZ 1\rN 50\rG\r")
        return [host.verify(3)]
    if part.startswith("cy5"):  # its sisters have no Z, and the CY500 no read-out
        host.send("A 0\rF 1\rR 60\rN 50\r+\rG\r")
        return []
    if part.startswith("gs"):
        program = "Po" if part == "gs-c200s" else "P"
        return [host.ask(line) for line in (program, "S50", "T500", "R20", "+40", "E", "F", "V1")]
    answers = [host.query("GET_VRSN")]
    for name, value in (("SET_POS", 40), ("SET_VEL", 265107), ("SET_ACC", 478)):
        host.command(name, value)
    host.command("UPDATE")
    return answers


def driven(part: str, chip_at: int, host_at: int, order: str = "chip first", journal=None):
    """A chip and its host, put on a bench at two instants: answers, steps and findings, from the dialogue on."""
    bench = slewline.Bench(journal=journal)
    bench.run_to(chip_at)
    x = bench.add(part, straps=STRAPS.get(part.removesuffix("s")))
    bench.run_to(host_at)
    if order == "in the run":
        bench.at(host_at + MS, lambda: bench.host(x))
        bench.run_to(host_at + 2 * MS)
        host = bench["host"]
    else:
        host = bench.host(x)
        bench.run_to(host_at + 2 * MS)
    begun = bench.now_ps
    answers = asked(host, part)
    bench.run_until_idle()
    steps = x.steps()
    return (
        answers,
        x.position,
        (steps.times_ps - begun).tolist(),
        [(found.time_ps - begun, str(found.code)) for found in bench.findings if found.time_ps > chip_at],
        bench.now_ps - begun,
    )


@rows("part", PARTS)
def test_a_chip_added_late_works_like_an_early_one(part):
    early, late = driven(part, 0, 0), driven(part, S, S)
    assert late == early
    assert len(early[2]) >= 40


@rows("how", ["between two runs", "in the run"])
@rows("part", ["cy525", "gs-c200s", "mc1151a"])
def test_a_host_added_late_works_like_an_early_one(part, how):
    early = slewline.Bench()
    x = early.add(part, straps=STRAPS.get(part.removesuffix("s")))
    host = early.host(x)
    early.run_to(S + 2 * MS)
    answers = asked(host, part)
    early.run_until_idle()
    late = driven(part, 0, S, how)
    assert (late[0], late[1], late[4]) == (answers, x.position, early.now_ps - S - 2 * MS)
    assert late[2] == (x.steps().times_ps - S - 2 * MS).tolist()


@pytest.mark.parametrize("part", ["cy525", "gs-c200s", "mc1151a"])
@pytest.mark.parametrize("how", ["between two runs", "in the run"])
def test_the_journal_adds_late_parts_at_their_instant(part, how, tmp_path):
    recorded = driven(part, 300 * MS, 500 * MS, how, tmp_path / "j")
    bench = slewline.replay(tmp_path / "j")
    x = bench[part.replace("-", "_")]
    assert (x.steps().times_ps - 502 * MS).tolist() == recorded[2]
    assert (x.position, bench.now_ps - 502 * MS) == (recorded[1], recorded[4])


@pytest.mark.parametrize("late", [False, True])
def test_an_encoder_may_come_after_the_first_commands(late):
    bench = slewline.Bench()
    x = bench.add("mc1151a-e")
    host = bench.host(x)
    if not late:
        bench.part("encoder", to=x, counts=4000, steps=4000)
    host.command("SET_VEL", 265107)
    host.command("SET_ACC", 478)
    if late:
        bench.part("encoder", to=x, counts=4000, steps=4000)
    host.command("SET_POS", 100)
    host.command("UPDATE")
    host.wait("motion_complete")
    bench.run("1 ms")
    assert (bench["encoder"].counts, host.query("GET_ACTL_POS")) == (100, 100)


def test_a_uart_a_board_and_a_memory_may_come_late():
    bench = slewline.Bench()
    x, y, z = bench.add("cy525", name="x"), bench.add("cy525", name="y"), bench.add("mc1151a", name="z")
    bench.run("20 ms")
    bench.part("uart", to=x)
    sender = bench.part("serial_sender", to="uart")
    bench.part("prom", to=y, image=b"A 7\r\xff")
    board = bench.part("isa", to=z)
    sender.send("A 5\r")
    board.out(0x342, 0x31)
    bench.run("20 ms")
    assert (x.position, y.position) == (5, 7)
    assert (board.inp(0x340), board.inp(0x340)) == (0x03, 0x00)


# -------------------------------------------------------------------------------------------------------------- wires
def test_a_late_wire_wakes_the_task_that_waits_for_its_level():
    bench = slewline.Bench()
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    host = bench.host(x, y)
    bench.record()
    host.to("x").send("E\rU\rC\r0\rQX\r")  # x waits for WAIT low, then makes PROGRAMMABLE OUTPUT another
    bench.run("20 ms")
    assert "wait" in x.waiting
    bench.wire("y.run", "x.wait")  # RUN of y is high: nothing yet
    bench.run("1 ms")
    assert "wait" in x.waiting
    host.to("y").send("E\rU\r0\rQX\r")  # RUN of y falls
    bench.run("20 ms")
    assert "wait=" not in x.waiting
    times, levels = bench.edges("x.wait")
    assert len(times) == 1 and levels.tolist() == [0]
    assert times.tolist() == [ps for ps, level in zip(*bench.edges("y.run"), strict=True) if level == 0]


def test_a_part_added_during_a_run_counts_from_that_instant():
    bench = slewline.Bench()
    x = bench.add("cy525", name="x")

    def furnish():
        bench.part("inverter", "not")
        bench.wire("x.wait", "not.in1")
        bench.record("not.out")

    bench.at("1 ms", furnish)
    x.pin("wait").drive(0, at="2 ms")
    x.pin("wait").drive(1, at="3 ms")
    bench.run("4 ms")
    times, levels = bench.edges("not.out")
    assert [(int(ps), int(level)) for ps, level in zip(times, levels, strict=True)][-2:] == [(2 * MS, 1), (3 * MS, 0)]


def test_an_inverter_between_two_pins_may_come_late():
    bench = slewline.Bench()
    x, y = bench.add("cy525", name="x"), bench.add("cy525", name="y")
    bench.run("1 ms")
    bench.wire("x.wait", "y.dowhile", invert=True)
    assert y.pin("dowhile").level == 1 - x.pin("wait").level
    x.pin("wait").drive(0)
    assert y.pin("dowhile").level == 1
