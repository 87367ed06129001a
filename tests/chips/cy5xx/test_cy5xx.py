"""What the CY5xx share, by a part of no maker: fewer pins, no live commands, steps at one rate, looks of its own."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import pytest

import slewline
from slewline.chips.cy5xx import firmware as family
from slewline.chips.cy5xx.firmware import Cy5xx
from slewline.chips.cy5xx.instructions import Instructions
from slewline.chips.cy5xx.sheet import PHASES
from slewline.chips.cy5xx.stepping.motion import Motion
from slewline.chips.cy5xx.supply import PowerUp
from slewline.chips.cy525 import firmware
from slewline.chips.cy525.sheet import SHEET
from slewline.core.chip import Chip
from slewline.core.datasheet.channel import BusHandshake
from slewline.core.datasheet.table import Table
from slewline.core.motion.motions import MotionParameters
from slewline.core.motion.plan import plan

STEP, LEAD, HIGH = 11_000, 110, 28  # clocks
ABSENT = ("slew", "direction", "io_select", "outstrobe", "dowhile")
LETTERS = "BCEGINQRSUWX+-0"


class Orders(Instructions):
    request_ends_wait = False

    def do_execute(self):
        self.program.begin(0)


class Moves(Motion):
    """Steps of 1 ms; ABORT low as a step begins holds it, with PULSE high."""

    def __init__(self, *given):
        super().__init__(*given)
        self.abort = self.chip.pins["abort"].net

    def parameters(self, number):
        return lambda: MotionParameters({}, {})

    def planned(self):
        return plan(("up", ((STEP, self.number),))).verified(self.number)

    def expected(self, plan):
        return lambda: None

    def watched(self):
        return [*super().watched(), (self.abort, 0)]

    async def look(self, plan, step):
        await self.chip.polled(self.abort, 1, 1)
        return plan


class Probe(Cy5xx):
    sheet = replace(
        SHEET,
        part="probe",
        pins=tuple(
            replace(pin, way="out") if pin.name == "prog" else pin for pin in SHEET.pins if pin.name not in ABSENT
        ),
        commands=Table(*(row for row in SHEET.commands if row.form in LETTERS)),
        labels="",
        channels=(BusHandshake(),),
        buffer_bytes=18,
    )
    _power_up = PowerUp(10**10, 7 * 10**10)
    _instructions_class = Orders
    _moves = lambda self, ticks: Moves(self, ticks, self.state, self._outputs, self._port, None)  # noqa: E731
    phase_patterns = lambda self: PHASES  # noqa: E731


class Lab:
    def __init__(self):
        self.bench = slewline.Bench()
        self.x = self.bench.add(Probe, "x")
        self.bench.record("x.pulse", "x.ready", "x.run")
        self.sent = 0

    def send(self, text):
        """Give bytes by the handshake; a byte and its strobe take what the chip needs."""
        x, bench = self.x, self.bench
        for byte in text.encode():
            bench.run_until(lambda: x.pin("ready").level == 1)
            for bit in range(8):
                x.pin(f"db{bit}").drive(byte >> bit & 1)
            x.pin("io_request").drive(0)
            bench.run_until(lambda: x.pin("ready").level == 0)
            x.pin("io_request").drive(1)
        bench.run_until(lambda: x.pin("ready").level == 1 or not x.idle)

    def edges(self, pin):
        times, levels = self.bench.edges(f"x.{pin}")
        return [
            (self.x.clock.ticks_until(ps), level) for ps, level in zip(times.tolist(), levels.tolist(), strict=True)
        ]


@pytest.fixture
def lab():
    return Lab()


def test_a_part_without_some_pins_steps_and_does_not_mention_them(lab):
    lab.send("N 5\rR 9\rS 1\r+\rG\r")
    lab.bench.run("10 ms")
    assert lab.x.travel == 5
    assert len([level for _, level in lab.edges("pulse") if level == 0]) == 5
    assert not set(ABSENT) & set(lab.x.pins)
    lab.send("-\rG\r")
    lab.bench.run("10 ms")
    assert lab.x.travel == 0


def test_a_sample_may_wait_and_the_steps_continue_from_there(lab):
    lab.send("N 4\rG\r")
    lab.bench.run_until(lambda: lab.x.travel == 2)
    begin = lab.x.clock.ticks_until(lab.bench.now_ps)
    lab.x.pin("abort").drive(0)
    lab.x.pin("abort").drive(1, at=lab.x.clock.ps(begin + 5 * STEP + 7))
    lab.bench.run("20 ms")
    falls = [clock - begin for clock, level in lab.edges("pulse") if level == 0][-3:]
    assert falls == [0, 5 * STEP + 8, 6 * STEP + 8]
    assert lab.x.travel == 4


def test_prog_live_is_unused_without_live_commands(lab):
    lab.send("E\rN 3\rG\rB\rQX\r")
    lab.x.pin("prog").drive(0)
    lab.bench.run("20 ms")
    assert lab.x.travel == 3
    assert lab.x.program_counter == 5
    assert lab.x.waiting.startswith("x: run mode with nothing to execute, waiting for RESET since")


def test_a_wait_that_no_request_ends(lab):
    lab.x.pin("wait").drive(1)
    lab.send("E\rU\rB\rQ")
    lab.send("C\rX\r")
    lab.bench.run("1 ms")
    lab.x.pin("io_request").drive(0)
    lab.bench.run("1 ms")
    lab.x.pin("io_request").drive(1)
    lab.bench.run("1 ms")
    assert lab.x.pin("programmable_output").level == 0
    assert [found.code for found in lab.x.findings if found.code == "request-while-running"]
    assert lab.x.findings[-1].text == "I/O REQUEST was lowered while a program was running: it is not answered"
    lab.x.pin("wait").drive(0)
    lab.bench.run("1 ms")
    assert lab.x.pin("programmable_output").level == 1


# ------------------------------------------------------------------------------------------------------- the anatomy


def test_a_chip_is_at_most_three_classes_deep():
    assert [each.__name__ for each in firmware.Cy525.__mro__[: firmware.Cy525.__mro__.index(Chip) + 1]] == [
        "Cy525",
        "Cy5xx",
        "Chip",
    ]


def test_ready_has_one_writer():
    """Nobody but the port takes hold of the driver of READY."""
    writers = set()
    for folder in (family, firmware):
        for path in sorted(Path(folder.__file__).parent.rglob("*.py")):
            text = path.read_text("utf-8")
            if any(word in text for word in (".ready.drive", ".ready.wave", ".ready.play", 'drivers["ready"]')):
                writers.add(f"{path.parent.name}/{path.name}")
    assert writers == {"interfaces/command_port.py"}


def test_the_family_imports_no_sheet_at_module_level():
    """A module of the family imports no part; what it needs of a sheet it is given."""
    for path, tree in (
        (path, ast.parse(path.read_text("utf-8"))) for path in Path(family.__file__).parent.glob("*.py")
    ):
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom):
                assert "sheet" not in (node.module or "").split("."), path.name
                assert not (node.module or "").startswith("cy5"), path.name
