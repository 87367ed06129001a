"""Whatever a part reports as an error to its host is a finding, too: what each part reports, and what provokes it."""

from __future__ import annotations

import pytest
from gsc import C200, C200S, FAST
from gsc import base as module
from mc import ENCODERS, S1, T1, V1
from mc import PARTS as CHIPSETS
from mc_motion import Mover, mover

from slewline.chips import CATALOGUE, checks_of, sheet_of
from slewline.language.lint import lint
from tests.rows import rows

ANSWERS = {"E1", "E2", "E3", "E4", "E5", "E6"}  # of a GS-C
BITS = {"motion_error", "command_error"}  # of the status word of an MC1451A; a checksum of 0 is in test_mc_port.py
SILENT = {"cy500", "cy512", "cy525", "cy545", "cy545b"}  # neither pins, registers nor commands that report an error

both = pytest.mark.parametrize("stepwise", [False, True], ids=["blocks", "stepwise"])


def test_every_part_is_here_and_these_are_the_errors_it_reports():
    assert SILENT | {C200, C200S} | set(CHIPSETS) == set(CATALOGUE.ours)
    for part in CATALOGUE.ours:
        sheet = sheet_of(part)
        names = [row.name for row in (*sheet.pins, *sheet.registers, *sheet.commands)]
        reporting = {bit.name for bit in getattr(sheet.dialect, "status", ()) if "error" in bit.name} | {
            name for name in names if "error" in name.lower() or "fault" in name.lower()
        }
        assert reporting == (BITS if part in CHIPSETS else set()), part


# ------------------------------------------------------------------------------------------------------------ GS-C
def provoked(rig, error):
    """What the module answers."""
    if error == "E1":
        return rig.wire("F\r", "parity").decode().strip()
    if error == "E2":
        return rig.prg("S0")[-1]
    if error == "E3":
        return rig.prg(*["A1"] * 120)[-1]
    if error == "E4":
        return rig.ask("y")
    if error == "E5":
        rig.run(*FAST, "-1")
        return rig.ask("F")
    rig.x.fail_eeprom(True)
    return rig.ask("M")


@rows("part", [C200, C200S])
@rows("error", sorted(ANSWERS))
def test_an_error_that_a_module_answers_is_a_finding(part, error):
    rig = module(part)
    if (part, error) != (C200S, "E5"):  # its counter wraps
        assert provoked(rig, error) == error
        assert error in [found.code for found in rig.x.findings]


# ------------------------------------------------------------------------------------------------ the MC1451A family
def moved(part: str, setup: tuple[str, ...], *commands: str, stepwise: bool = False) -> Mover:
    """An axis that gets commands and an update a hundred cycles after it has set out."""
    rig = mover(part, options={"stepwise": stepwise})
    begun = rig.begin(*setup)
    rig.heeds(begun + 100, *commands, "UPDATE")
    return rig


REFUSED = [
    (T1, ("SET_ACC 0x200",)),
    (T1, ("SET_ACC 0x200", "SET_POS 500")),
    (S1, ("SET_VEL 0x8000",)),
    (S1, ("SET_MAX_ACC 0x200",)),
    (S1, ("SET_JERK 0x100000",)),
]
TAKEN = [
    (T1, ("SET_ACC 0x400",)),
    (T1, ("SET_VEL 0x8000",)),
    (T1, ("SET_POS 500",)),
    (S1, ("SET_POS 500",)),
    (V1, ("SET_ACC 0x200",)),
]


def linted(setup: tuple[str, ...], commands: tuple[str, ...], between: str) -> list[str]:
    text = "\n".join((*setup, "UPDATE", between, *commands, "UPDATE"))
    return [problem.code for problem in lint(text, sheet_of("mc1451a"), checks_of("mc1451a"))]


@both
@pytest.mark.parametrize("part", [CHIPSETS[0], CHIPSETS[-1]])
def test_an_update_that_is_not_allowed_in_motion_is_a_finding_in_lint_and_run(part, stepwise):
    for setup, commands in REFUSED:
        rig = moved(part, setup, *commands, stepwise=stepwise)
        assert rig.shows("status") & 0x80
        assert rig.codes == ["command-error"], commands
        assert linted(setup, commands, "@wait 30 ms") == ["command-error"]
    for setup, commands in TAKEN:
        rig = moved(part, setup, *commands, stepwise=stepwise)
        assert not rig.shows("status") & 0x80
        assert rig.codes == [], commands
        assert linted(setup, commands, "@wait 30 ms") == []


@rows("between", ["wait motion_complete", "wait !in_motion", "@wait 10 s", "@until atrest1=1", "STOP\nUPDATE", "RESET"])
@rows(("setup", "commands"), REFUSED)
def test_at_rest_lint_accepts_it(setup, commands, between):
    assert "command-error" not in linted(setup, commands, between)


@both
@pytest.mark.parametrize("mode", [T1, S1, V1], ids=["trapezoid", "s-curve", "velocity"])
def test_a_move_into_a_switch_is_a_finding_in_every_profile_mode(mode, stepwise):
    rig = mover("mc1451a", options={"stepwise": stepwise})
    rig.drive("poslimit1", 1)
    rig.next(2)
    rig.begin(*mode)
    assert rig.shows("status") & 0x80 == (0 if mode is V1 else 0x80)
    assert rig.codes == ["no-start" if mode is V1 else "command-error"]


@both
@pytest.mark.parametrize(("setup", "told"), [(T1, True), (V1, True), (S1, False)], ids=["trapezoid", "velocity", "s"])
def test_a_start_velocity_in_motion_is_a_finding_in_lint_and_run(setup, told, stepwise):
    rig = moved("mc1451a", setup, "SET_START_VEL 9", stepwise=stepwise)
    assert rig.codes == ["start-velocity"] * told
    rig.do("SET_START_VEL 9")
    assert rig.codes == ["start-velocity"] * told  # it is that already
    assert linted(setup, ("SET_START_VEL 9",), "@wait 30 ms") == ["start-velocity"] * told
    assert linted(setup, ("SET_START_VEL 9",), "wait motion_complete" if setup is T1 else "STOP\nUPDATE") == []


@both
@pytest.mark.parametrize("part", [ENCODERS[0], ENCODERS[-1]])
def test_a_stall_is_a_finding_once_and_again_after_a_recovery(part, stepwise):
    rig = mover(part, encoder={"counts": 400, "steps": 400}, options={"stepwise": stepwise})
    rig.shafts["encoder"].block()
    rig.begin("SET_STEP_RATIO 256", "SET_POS_ERR 100", *T1)
    rig.rest()
    assert rig.shows("status") & 0x10
    assert rig.codes == ["motion-error"]
    rig.begin("SYNCH_PRFL")
    rig.begin("SET_POS 3000")
    rig.rest()
    assert rig.codes == ["motion-error"] * 2


@rows("profile", ["SET_PRFL_TRAP", "SET_PRFL_S_CRV"])
def test_a_profile_mode_that_changes_in_motion_is_a_finding_in_lint_and_run(profile):
    setup = S1 if profile == "SET_PRFL_TRAP" else T1
    rig = mover("mc1451a")
    rig.begin(*setup)
    rig.next(100)
    rig.do(profile)
    rig.next(2)
    assert rig.codes == ["mode-in-motion"]
    assert linted(setup, (profile,), "@wait 30 ms")[0] == "mode-in-motion"
    assert "mode-in-motion" not in linted(setup, (profile,), "wait motion_complete")
