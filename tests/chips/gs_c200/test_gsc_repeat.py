"""Where U stands in a program that a GS-C module starts by itself, and what it repeats."""

from __future__ import annotations

import pytest
from gsc import STR, base, both

from slewline.chips import checks_of, sheet_of
from slewline.language.lint import lint


@both
@pytest.mark.parametrize(
    ("program", "moves_while_high", "moves_after", "told"),
    [
        (("U3", *STR, "+50"), 0, 0, "no-autorun"),
        (("S10", "U3", *STR, "+50"), 0, 1, "until-early"),
        ((*STR, "+50", "U3"), 5, 0, None),
    ],
)
def test_only_as_the_last_line_until_repeats_a_program_that_starts_without_a_host(
    part: str, program: tuple[str, ...], moves_while_high: int, moves_after: int, told: str | None
) -> None:
    first = base(part)
    assert first.prg(*program) == ["Y"] * len(program) and first.ask("M") == "Y"
    rig = base(part, "mov", "clock", "rdy", options={"store": first.x.store}, rec=0, eot=0, home=0)
    rig.bench.run("0.5 s")
    homed = len(rig.rises("mov"))  # whatever the homing takes
    rig.bench.run("5 s")
    assert len(rig.rises("mov")) - homed >= moves_while_high
    assert moves_while_high or len(rig.rises("mov")) == homed
    high = len(rig.rises("mov"))
    rig.drive("ui3", 0)
    rig.bench.run_until_idle("5 s")
    assert len(rig.rises("mov")) - high == moves_after
    text = "\n".join([{"gs-c200": "P", "gs-c200s": "Po"}[part], *program, "M", "E"])
    codes = {problem.code for problem in lint(text, sheet_of(part), checks_of(part))}
    assert codes & {"no-autorun", "until-early"} == ({told} if told else set())
