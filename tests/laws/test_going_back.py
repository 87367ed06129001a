"""Going back is what would have been: an input put in at m, later, gives the run in which it came at m, to the bit.

Each family runs with a journal and without the input; the present is up to 100 ms behind it.  The bench that has gone
back is compared with a straight run in steps, registers, findings and what the host has got; then its journal, which is
written on, is played again.
"""

from __future__ import annotations

from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import pytest

import slewline
from slewline.bench.past import Past, driven
from tests.ensembles import members

MS = 10**9
FEW, MANY = 2, 20
AHEAD = 100 * MS  # the present is so far behind the input


class Case(NamedTuple):
    """What a family does, and where in it the edges are."""

    part: str
    text: str
    edges: tuple[tuple[str, int], ...]  # a pin and its level; one more edge comes 7 ms after the one before
    first_ms: float
    last_ms: float
    straps: dict[str, int] = {}  # noqa: RUF012
    later: str = ""  # said at 60 ms


MC = "SET_POS 60000\nSET_VEL 0x20000\nSET_ACC 0x800\nUPDATE\nwait motion_complete\nGET_TRGT_POS"
HOME = MC.replace("UPDATE\n", "UPDATE\nSET_AUTO_UPDATE_ON\nSTOP\nSET_EXT_BRK\n")
GSC = {"br0": 0, "br1": 0, "br2": 0, "chs": 0}
SET_UP = "Po\rS50\rT200\rR90\r%sE\r"  # a program, which runs at once
CASES = {
    "cy500 abort": Case("cy500", "R 200\rF 10\rS 20\rN 900\rG\r", (("abort", 0),), 20, 700),
    "cy500 trigger": Case("cy500", "R 200\rF 10\rS 20\rN 900\rG\r", (("trigger", 1), ("trigger", 0)), 20, 700),
    "cy512 abort": Case("cy512", "R 200\rF 1\rS 5\rN 900\rG\r", (("abort", 0),), 20, 300),
    "cy525 abort": Case("cy525", "A 0\rF 10\rR 120\rS 120\rZ 1\rN 4000\rG\r", (("abort", 0),), 20, 700),
    "cy525 inhibit": Case(
        "cy525", "A 0\rF 10\rR 120\rS 120\rN 4000\rG\r", (("step_inhibit", 1), ("step_inhibit", 0)), 20, 700
    ),
    "cy545 stop": Case("cy545", "F 50\rR 150\rS 150\r+\rN 900\rG\r", (("inhibit_abort", 0),), 20, 160),
    "cy545 limit": Case("cy545", "F 50\rR 150\rS 150\r+\rN 900\rG\r", (("cw_limit", 0),), 20, 160),
    "cy545 home": Case("cy545", "F 250\rH 16\r", (("usrb0", 0), ("usrb0", 1)), 20, 400),
    "gs-c200s enable": Case("gs-c200s", SET_UP % "+900\r", (("enable", 0), ("enable", 1)), 60, 600, GSC, "V1\r"),
    "gs-c200 home": Case("gs-c200", SET_UP.replace("o", "") % "", (("eot", 0), ("home", 0)), 100, 700, GSC, "H\r"),
    "gs-c200s eot": Case("gs-c200s", SET_UP % "", (("eot", 0), ("home", 0)), 100, 700, GSC, "H-\r"),
    "mc1451a limit": Case("mc1451a", MC, (("poslimit1", 1),), 8, 400),
    "mc1451a home": Case("mc1451a", HOME, (("home1", 0),), 8, 400),
}


def made(case: Case, journal: Path | None = None) -> slewline.Bench:
    """A bench at its beginning, with everything that the host will say."""
    bench = slewline.Bench(journal=journal)
    x = bench.add(case.part, "x", straps=case.straps or None)
    host = bench.host(x, name="h")
    if case.part.startswith("mc"):
        from slewline.bench.scripts.script import run_script

        run_script(bench, host, case.text)
    else:
        host.send(case.text)
    if case.later:
        bench.at("60 ms", lambda: host.send(case.later))
    return bench


def state(bench: slewline.Bench) -> tuple[Any, ...]:
    """Everything that must agree."""
    x = bench["x"]
    steps = [
        (x.axis(n).steps().times_ps.tolist(), x.axis(n).steps().positions.tolist(), dict(x.axis(n).registers))
        for n in range(1, x.sheet.axes + 1)
    ]
    host = bench["h"]
    heard = repr(getattr(host, "received", ""))
    return steps, dict(x.registers), heard, [str(found) for found in bench.findings], x.waiting, host.waiting


@members("phases", FEW, MANY)
@pytest.mark.parametrize("name", CASES)
def test_an_input_of_the_past_is_one_that_came_at_its_time(name: str, phases: range, tmp_path: Path) -> None:
    case = CASES[name]
    differing = 0
    for number in phases:
        chance = Random(f"{name} {number}")
        first = chance.randrange(int(case.first_ms * MS), int(case.last_ms * MS))
        edges = [(pin, level, first + n * 7 * MS) for n, (pin, level) in enumerate(case.edges)]
        present = edges[-1][2] + chance.randrange(1, AHEAD)
        end = present + 300 * MS

        straight = made(case)
        for pin, level, at in edges:
            straight.pin(f"x.{pin}").drive(level, at=at)
        straight.run_to(present)
        there = state(straight)
        straight.run_to(end)

        without = made(case, tmp_path / "a")
        past = Past(without, shadows=1)
        without.run_to(first - chance.randrange(1, int(2 * case.first_ms)) * MS // 2)
        past.follow(without.now_ps - 1)
        without.run_to(present)
        differing += state(without) != there
        inputs = [driven(f"x.{pin}", level, at) for pin, level, at in edges]
        new = past.at(first).rerun(inputs, present, tmp_path / "b")
        assert new.now_ps == present
        assert state(new) == there, (number, edges, present)
        past.go_on(new)
        new.run_to(end)
        assert state(new) == state(straight), (number, edges, present)
        if number % 10 == 0:
            assert state(slewline.replay(tmp_path / "a")) == state(straight)
    assert differing > len(phases) // 2
