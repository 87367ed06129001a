"""The CY545: sixteen million steps at the top rate, planned and run unwatched; and its buses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import profiled
from rows import REAL, Row, best, best_of, prepared_by_turns

import slewline
from slewline.chips import sheet_of
from slewline.chips.cy545 import profile
from slewline.core.motion.train import StepTrain
from slewline.core.time.timebase import Clock

NUMBER, FIRST, RATE, SLOPE = 16_000_000, 14, 255, 220
POLLING = "ram", "Y 0\rE\rT 3,0\r0\rQ", "Y 0\rX\r"


def prepared() -> Callable[[], Any]:
    """Return a chip that is ready to begin the motion."""
    bench = slewline.Bench()
    chip = bench.add("cy545", "x")
    host = bench.host(chip)
    host.send(f"+\rF {FIRST}\rR {RATE}\rS {SLOPE}\rN {NUMBER}\r")
    bench.run_until_idle()

    def run() -> Any:
        host.send("G\r")
        bench.run_until_idle("1000 s")
        return chip

    return run


def spoken(
    memory: str, entered: str, sent: str, time: str = "", pins: tuple[str, ...] = ()
) -> Callable[[], Callable[[], float]]:
    """Return a workload of a chip, with a memory or none: initial input, then timed input, until idle or for a time."""

    def prepare() -> Callable[[], float]:
        bench = slewline.Bench()
        chip = bench.add("cy545b", "x")
        if memory:
            bench.part(memory, "memory", to=chip)
        chip.pin("usrb3").drive(0)
        if pins:
            bench.record(*pins)
        host = bench.host(chip)
        host.send(f"O 81H\r{entered}")
        bench.run_until_idle("100 s")
        host.send(sent)

        def run() -> float:
            begin = bench.now_ps
            if time:
                bench.run(time)
            else:
                bench.run_until_idle("100 s")
            assert not bench.findings
            return (bench.now_ps - begin) / 1e12

        return run

    return prepare


def talking() -> list[Row]:
    """Return the rows of a program that polls, of commands over the bus, and of a program entered into an EEPROM."""
    commands = "".join(f"N {n}\rR {n % 200 + 10}\r" for n in range(1000))
    program = "".join(f"N {n}\r" for n in range(60))
    cases = (
        ("a program that polls", spoken(*POLLING, "400 ms"), 400, "per virtual millisecond"),
        ("2,000 commands over the bus", spoken("", "", commands), 2000, "per command"),
        ("entry of a program into an EEPROM", spoken("eeprom", "", f"Y 0\rE\r{program}Q"), 60, "per instruction"),
    )
    found = []
    for what, prepare, items, item in cases:
        wall, virtual = best_of(prepare)
        name = f"CY545: {what}"
        bound = profiled.bound(name, prepare, items, item)
        found.append(Row(name, virtual / wall, REAL, None, True, bound))
    return found


def recorded() -> list[Row]:
    """Return the row of the polling program with its local bus recorded, compared with the same unrecorded."""
    name = "CY545: a program that polls, its local bus recorded"
    watched = spoken(*POLLING, "100 ms", tuple(f"x.{pin}" for pin in ("xmem_sel", "ale", "rd", "wr", "db")))
    bound = profiled.bound(name, watched, 100, "per virtual millisecond")
    sides = prepared_by_turns(spoken(*POLLING, "100 ms"), watched)
    return [Row(name, None, "x the speed without recording", 0.8, True, bound, sides)]


def planning() -> list[Row]:
    """Return the rows of the plan, and of the motion."""
    law, clock = profile.law_of(sheet_of("cy545")), Clock(12_000_000)

    def planned() -> StepTrain:
        return StepTrain(clock, 0, profile.move(NUMBER, FIRST, RATE, SLOPE, law).runs)

    assert planned().steps == NUMBER
    wall, chip = best_of(prepared)
    assert chip.position == NUMBER and len(chip.motor.past) == 2
    return [
        Row("move of 16,000,000 steps: plan", best(planned, 20) * 1e3, "ms", 1, False, "500 runs of equal intervals"),
        Row(
            "move of 16,000,000 steps: the whole move, unobserved",
            chip.kernel.now / 1e12 / wall,
            REAL,
            20_000,
            True,
            "a few events",
        ),
    ]
