"""What the commands and programs of the CY512 do otherwise than those of the CY525, and what they do that it cannot."""

from __future__ import annotations

from itertools import pairwise

import pytest

import slewline
from slewline.chips import PARTS, sheet_of
from slewline.chips.cy5xx.letters import MEANS, exchanged
from slewline.chips.cy5xx.sheet import HALF_STEPS
from slewline.chips.cy5xx.stepping.sloped import half_steps
from tests.chips.conftest import Rig

SET = "R 255\rS 0\rF 1\rN 1\rA\r"
MS = 10**9
PHASES = half_steps({"phases": HALF_STEPS})


def made(**options: object) -> Rig:
    """A CY512 on a bench, whose registers have all been set."""
    r = Rig(part="cy512", **options)
    r.send(SET)
    return r


# -------------------------------------------------------------------------------------------------------------- the set
@pytest.mark.fact("CY512-SET-1", "CY512-SET-2")
def test_there_are_25_commands():
    letters = "".join(row.form for row in sheet_of("cy512").commands)
    assert letters == "ABCDEFGHIJLNOPQRSTUVWX+-0"
    r = made()
    for letter in "Z":
        r.send(f"{letter} 3\r")
        assert r.codes[-1] == "unknown-command"
    assert "unknown here" in r.x.findings[-1].text or "it is unknown" in r.x.findings[-1].text


@pytest.mark.fact("CY512-SET-3")
def test_a_command_that_the_comparison_lists_has_a_row_of_its_own():
    ours, theirs = sheet_of("cy512").commands, sheet_of("cy525").commands
    for letter in "ADFHORSTX":
        assert (ours[letter].name, ours[letter].args) != (theirs[letter].name, theirs[letter].args), letter
    assert set(exchanged("cy512")["cy525"]) == set("ADFHORSTXZ$")
    assert set(exchanged("cy525")["cy512"]) == set("ADFHORSTX")


def test_the_letters_that_are_listed_are_commands_of_the_parts_that_have_them():
    for letter, means in MEANS.items():
        for part in means.keys() & PARTS.keys():
            sheet = sheet_of(part)
            assert letter in sheet.commands.by_form or (letter == "$" and sheet.labels), (letter, part)


@pytest.mark.fact("CY512-PROG-2")
def test_there_are_no_labels():
    r = made()
    r.send("E\rA$C\r")
    assert r.codes[-2:] == ["unknown-command", "unfinished"] and r.x.program == b""
    assert "byte numbers" in sheet_of("cy512").slips["$"] or "here it is unknown" in sheet_of("cy512").slips["$"]


# ----------------------------------------------------------------------------------------------------------- parameters
@pytest.mark.fact("CY512-CMD-A-1")
def test_athome_makes_the_position_zero():
    r = made()
    r.send("P 10\rA\rP 4\r")
    assert (r.x.position, r.x.travel) == (4, 14) and "extra-argument" not in r.codes
    r.send("A 9\r")
    assert r.x.position == 0 and r.codes[-1] == "extra-argument"


@pytest.mark.fact("CY512-CMD-R-1", "CY512-UND-R-256", "CY512-CON-R-RANGE")
def test_r_256_counts_as_255_and_r_0_is_a_little_slower_than_r_1():
    r = made()
    r.send("R 256\r")
    assert r.x.registers["rate"] == 255 and r.codes[-1] == "range"
    r.send("R 257\r")
    assert r.x.registers["rate"] == 1 and r.codes.count("range") == 2
    r.send("R 0\rN 2\rG\r")
    first, second = r.x.steps().times_ps.tolist()
    assert (second - first) * 11 == pytest.approx(63400 * 10**6, abs=10**6) and r.codes.count("range") == 4


@pytest.mark.fact("CY512-UND-RAMP-RULE", "CY512-CMD-S-1")
def test_a_slope_makes_the_factor_1_and_no_slope_leaves_it():
    r = made()
    r.send("F 10\rS 0\r")
    assert r.x.registers["factor"] == 10
    r.send("S 5\r")
    assert (r.x.registers["factor"], r.x.registers["slope"]) == (1, 5)


@pytest.mark.fact("CY512-CMD-V-3", "CY512-UND-RAMP-RULE")
def test_group_3_has_number_slope_rate_and_factor():
    r = made()
    r.send("N 513\rF 9\rS 25\rR 127\r")
    assert r.host.verify(3) == bytes([2, 1, 25, 127, 1])
    assert r.host.verify(3, 6)[5] == 0xFF


@pytest.mark.fact("CY512-UND-POWERUP")
def test_uninitialised_registers_are_reported_at_their_first_use():
    r = Rig(part="cy512")
    assert r.x.registers == {"number": 0, "slope": 0, "rate": 1, "factor": 1, "position": 0xA55A}
    r.send("R 255\rG\r")
    assert r.codes == ["uninitialised"] * 3 + ["no-steps"]
    r.send(f"N 1\rG\rP {0xA55A}\r")
    found = [finding.text.split(" uses the ")[1].split()[0] for finding in r.x.findings if "uses" in finding.text]
    assert found == ["factor", "number", "slope", "position"]


# --------------------------------------------------------------------------------------------------------------- phases
@pytest.mark.fact("CY512-CMD-H-1", "CY512-CMD-H-2", "CY512-UND-HALFSTEP")
@pytest.mark.parametrize(("sign", "way"), [("+", 1), ("-", -1)])
@pytest.mark.parametrize("stepwise", [False, True])
def test_h_selects_half_steps_until_i(sign, way, stepwise):
    r = made(stepwise=stepwise)
    r.send(f"{sign}\r")

    def walked(number: int) -> list[tuple[int | None, ...]]:
        found = []
        for _ in range(number):
            r.send("G\r")
            found.append(r.phases)
        return found

    rows = [(1, 0, 0, 1), (1, 0, 1, 0), (0, 1, 1, 0), (0, 1, 0, 1)]
    full = rows if way > 0 else [rows[2], rows[1], rows[0], rows[3]]
    assert walked(4) == full
    r.send("H\r")
    halves = [PHASES[way * n % 8] for n in range(1, 9)]
    assert walked(8) == halves and set(halves[1::2]) == set(rows) and len(set(halves)) == 8
    assert r.x.travel == way * 12
    r.send(f"N 8\rG\rI\r{sign}\rN 1\r")
    assert walked(4) == full


@pytest.mark.fact("CY512-CMD-H-1")
def test_half_steps_begin_where_the_full_steps_have_ended():
    r = made()
    r.send("N 3\rG\rH\r")
    assert r.phases == PHASES[6]
    r.send("N 1\rG\r")
    assert r.phases == PHASES[7]
    r.send("H\rG\r")  # again: nothing changes
    assert r.phases == PHASES[0]


def test_a_half_step_changes_one_phase_and_full_steps_two():
    for row, after in zip(PHASES, (*PHASES[1:], PHASES[0]), strict=True):
        assert sum(a != b for a, b in zip(row, after, strict=True)) == 1
    assert all(sum(row) == 2 for row in PHASES[::2]) and all(sum(row) == 3 for row in PHASES[1::2])


@pytest.mark.fact("CY512-CMD-O-1", "CY512-UND-OFFSET", "CY512-CON-O-MEANING")
def test_offset_shows_one_of_eight_patterns_and_ignores_others():
    r = made()
    rows = {
        0: (0, 1, 0, 1),
        1: (1, 0, 0, 1),
        2: (1, 0, 1, 0),
        3: (0, 1, 1, 0),
        4: (1, 1, 0, 1),
        5: (1, 0, 1, 1),
        6: (1, 1, 1, 0),
        7: (0, 1, 1, 1),
    }
    for offset, levels in rows.items():
        r.send(f"O {offset}\r")
        assert r.phases == levels
    r.send("O 8\r")
    assert r.phases == rows[7] and r.codes[-1] == "offset"
    r.send("O 200\r")
    assert r.phases == rows[7] and len(r.x.steps()) == 0
    r.send("O 2\rG\r")
    assert r.phases == rows[3]
    r.send("H\rO 6\rG\r")
    assert r.phases == rows[3]


# ------------------------------------------------------------------------------------------------------------- programs
@pytest.mark.fact("CY512-CMD-L-2", "CY512-UND-L256")
@pytest.mark.parametrize("count", [0, 256])
def test_a_loop_counts_up_to_256(count):
    r = made()
    r.enter("G", f"L {count},0", "0")
    r.execute("D")
    assert r.x.position == 256 and not {"range", "loop-zero"} & set(r.codes)


@pytest.mark.fact("CY512-CMD-T-1")
def test_til_as_a_command_runs_the_program_while_dowhile_is_low():
    r = made()
    r.enter("G", "0")
    r.send("T\r")
    assert r.x.position == 0
    r.drive("dowhile", 0)
    r.execute("T")
    assert r.x.position == 1


@pytest.mark.fact("CY512-CMD-U-2")
@pytest.mark.parametrize("program", [True, False])
@pytest.mark.parametrize("letter", "UW")
def test_no_request_ends_a_wait(letter, program):
    r = made()
    r.drive("wait", letter == "U")
    if program:
        r.enter("C", letter, "B", "0")
        r.start("D\r")
    else:
        r.start(f"C\r{letter}\r")
    r.bench.run("20 ms")
    r.drive("io_request", 0)
    r.bench.run("1 ms")
    r.x.pin("io_request").release()
    r.bench.run("20 ms")
    assert f"({letter})" in r.x.waiting and r.level("programmable_output") == 0
    r.drive("wait", letter == "W")
    r.bench.run_until_idle()
    assert r.x.idle


@pytest.mark.fact("CY512-PROG-3", "CY512-FAM-4", "CY512-UND-READY-PROGRAM")
def test_pin_31_admits_no_live_commands_and_no_request_is_taken_while_a_program_runs():
    r = made(record=("ready", "instrobe"))
    r.enter("X 50", "L 4,0", "B", "0")
    r.send("C\r")
    r.start("D\r")
    r.bench.run("20 ms")
    since = r.bench.now_ps
    r.drive("prog", 0)
    r.drive("io_request", 0)
    r.bench.run("100 ms")
    assert not r.edges("ready", since) and not r.edges("instrobe", since) and r.level("run") == 0
    assert r.codes[-1] == "request-while-running"
    r.x.pin("io_request").release()
    r.bench.run_until_idle()
    assert r.level("programmable_output") == 1 and r.level("run") == 1


@pytest.mark.fact("CY512-HS-2")
def test_ready_stays_high_for_the_motions_of_a_program():
    r = made(record=("ready", "pulse", "run"))
    r.enter("N 30", "G", "0")
    since = r.bench.now_ps
    r.execute("D")
    pulses = r.falls("pulse", since)
    assert not r.edges("ready", pulses[0]) and len(pulses) == 30 and r.rises("run", pulses[-1])


@pytest.mark.fact("CY512-CMD-D-1", "CY512-CMD-X-1")
def test_the_loop_of_single_steps_half_a_second_apart():
    r = made(record=("programmable_output", "run"))
    r.enter("B", "G", "X 500", "L 3,1", "C", "0")
    assert r.x.program.hex(" ") == "42 47 58 f4 01 4c 03 01 43 00"
    r.execute("D")
    times = r.x.steps().times_ps
    assert len(times) == 3 and r.edges("programmable_output")[-1][1] == 0
    for gap in (times[1:] - times[:-1]).tolist():
        assert 500 * MS < gap < 502 * MS


# -------------------------------------------------------------------------------------------------------------- options
def test_a_bench_file_replaces_what_is_inferred(tmp_path):
    path = tmp_path / "lab.toml"
    periods = [20_000 - 50 * rate for rate in range(256)]
    path.write_text(
        '[[chip]]\nname = "x"\npart = "cy512"\n[chip.options.inferred]\n'
        f"periods = {periods}\nmillisecond = 22000\npulse_high = 33\nterminated = 5500\n"
        "phases = [1, 2, 3, 4, 5, 6, 7, 8]\n"
    )
    bench = slewline.load(path)
    x, host = bench["x"], bench.host(bench["x"])
    bench.record("x.pulse", "x.ready")
    host.send(SET + "R 200\rN 3\rG\r")
    bench.run_until_idle("5 s")
    times, levels = bench.edges("x.pulse")
    ticks = [x.clock.ticks_until(int(at)) for at in times]
    assert [b - a for a, b in pairwise(ticks)] == [9967, 33, 9967, 33, 9967] and levels[0] == 0
    since = bench.now_ps
    host.send("X 100\r")
    bench.run_until_idle("5 s")
    assert bench.now_ps - since > 200 * MS
    x.pin("terminate").drive(0)
    host.send("G\r")
    bench.run_until_idle("5 s")
    times = x.steps().times_ps[-3:]
    assert x.clock.ticks_until(int(times[2])) - x.clock.ticks_until(int(times[1])) == 5500
    host.send("O 0\rG\r")
    bench.run_until_idle("5 s")
    assert [x.pin(f"phase{n}").level for n in (1, 2, 3, 4)] == [0, 1, 1, 1]  # three whole steps on: the seventh row


@pytest.mark.parametrize("periods", [[2200] * 255, [2200] * 257, [100] * 256])
def test_a_table_of_periods_has_256_numbers_none_too_small(periods):
    with pytest.raises(slewline.UsageError, match="periods"):
        slewline.Bench().add("cy512", inferred={"periods": periods})


def test_inferred_facts_are_marked():
    its = sheet_of("cy512")
    assert {row.form for row in its.commands if row.trust == "inferred"} == set("AFOST")
    assert {name for name, time in its.times.items() if time.trust == "inferred"} == {
        "millisecond",
        "pulse_high",
        "terminated",
    }
    (inferred,) = (option for option in its.options if option.name == "inferred")
    assert all(row.description.startswith("inferred: ") and row.where for row in inferred.table)
