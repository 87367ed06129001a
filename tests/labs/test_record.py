"""The fields of a motor record, each as the record reference has it; in virtual time, without a client."""

from __future__ import annotations

import asyncio
from itertools import pairwise

import pytest

pytest.importorskip("caproto")
pytest.importorskip("serial")

from caproto import ChannelType

from slewline.errors import UsageError
from slewline.labs.effects import Effects
from slewline.labs.field_table import FIELDS, ROWS
from tests.rows import rows

CY545 = {"url": "slewline://cy545", "part": "cy545", "values": {"F": 20, "R": 100, "S": 200}}


def steps(record):
    """How many steps the motor has made."""
    return len(record.chip.steps().times_ps)


def here(record, *keys):
    return tuple(record.get(key) for key in keys)


# ------------------------------------------------------------------------------------------------------ lists of fields
# Fields that programs of others read and write: lists of names, which are facts.
CLIENTS = {
    "ophyd EpicsMotor": ("RBV VAL OFF DIR FOFF SET VELO ACCL EGU MOVN DMOV HLS LLS HLM LLM TDIR STOP HOMF HOMR"),
    "ophyd-async Motor": (
        "EGU MRES SREV UREV ERES VELO OFF RBV VAL VMAX ACCL PREC RDBD DMOV LLM HLM DLLM DHLM FOFF HLS LLS OUT SET STOP"
    ),
    "pyepics Motor": (
        "ACCL BACC BDST BVEL CARD DHLM DIR DLLM DLY DMOV DRBV DESC DVAL EGU ERES FOFF FRAC HHSV HIGH HIHI HLM "
        "HLS HLSV HOMF HOMR HOPR HSV ICOF JAR JOGF JOGR JVEL LDVL LLM LLS LLSV LOLO LOPR LOW LRLV LRVL LSPG "
        "LSV LVAL LVIO MIP MISS MOVN MRES MSTA OFF OMSL OUT PCOF PREC RBV RTRY RCNT RDBD RDIF REP RHLS RLLS "
        "RLV RMP RRBV RRES RVAL RVEL S SBAK SBAS SMAX SET SPMG SREV STOP TDIR TWF TWR TWV UEIP UREV URIP VAL "
        "VBAS VELO VERS VMAX ATHM DCOF CNEN DTYP RTYP STAT"
    ),
    "MEDM and Phoebus screens": (
        "ACCL ATHM BACC BDST BVEL CARD CNEN DCOF DESC DHLM DIFF DIR DLLM DLY DMOV DRBV DTYP DVAL EGU ERES "
        "FLNK FOFF FRAC HLM HLS HOMF HOMR HVEL ICOF JAR JOGF JOGR JVEL LLM LLS LVIO MIP MOVN MRES MSTA NAME "
        "NTM NTMF OFF PCOF POST PREC PREM RBV RCNT RDBD RDBL REP RLV RMP RRBV RRES RTRY RVAL S SBAK SBAS SET "
        "SMAX SPMG SREV SSET STAT STOP STUP SUSE SYNC TDIR TWF TWR TWV UEIP UREV URIP VAL VBAS VELO VERS VMAX "
        "_able"
    ),
}
AUTOSAVE = (  # what it restores, in its order: settings, then the position
    "DIR DHLM DLLM TWV SREV MRES ERES RRES VBAS VELO ACCL ACCU BDST BVEL BACC RDBD SPDB DESC EGU RTRY UEIP "
    "URIP DLY RDBL PREC DISA DISP FOFF OFF FRAC OMSL JVEL JAR VMAX PCOF ICOF DCOF HVEL NTM NTMF INIT PREM "
    "POST FLNK RMOD RSTM _able DVAL"
)
TYPES = {  # of the record, as Channel Access has them
    "VAL": "DOUBLE", "RVAL": "LONG", "MSTA": "DOUBLE", "DMOV": "INT", "SREV": "LONG", "PREC": "INT", "FRAC": "FLOAT",
    "DIR": "ENUM", "SPMG": "ENUM", "STAT": "ENUM", "OUT": "STRING", "EGU": "STRING", "RDIF": "LONG", "MIP": "LONG",
    "RTRY": "INT", "CARD": "INT", "FLNK": "STRING", "RHLM": "DOUBLE", "STUP": "ENUM", "NTMF": "LONG",
}  # fmt: skip
WORDS = {
    "DIR": "Pos Neg", "FOFF": "Variable Frozen", "SET": "Use Set", "SPMG": "Stop Pause Move Go", "STUP": "OFF ON BUSY",
    "UEIP": "No Yes", "RMOD": "Default Arithmetic Geometric In-Position", "NTM": "NO YES", "CNEN": "Disable Enable",
    "RSTM": "Never Always NearZero Conditional", "SEVR": "NO_ALARM MINOR MAJOR INVALID",
    "OMSL": "supervisory closed_loop",
}  # fmt: skip


@rows("fields", [*CLIENTS.values(), AUTOSAVE])
def test_programs_of_others_find_all_their_fields(fields):
    assert sorted(set(fields.split()) - {*ROWS}) == []


def test_a_field_is_written_by_an_effect_or_is_constant():
    assert {row.put for row in FIELDS if row.put} == {name for name in vars(Effects) if name[0] != "_"} - {
        "at_rest", "redefine", "pulse", "fitted"
    }  # fmt: skip
    assert len(ROWS) == len(FIELDS)
    assert all(row.description for row in FIELDS)


def test_types_and_words_are_those_of_the_record(run):
    async def play(record):
        for name, kind in TYPES.items():
            assert record.fields[name].data_type.name == kind, name
        for name, words in WORDS.items():
            assert " ".join(record.fields[name].enum_strings) == words, name

    run(play)


def test_every_field_is_read_as_every_kind_of_value(run):
    """With its limits and its unit, which may be longer than Channel Access has room for."""

    async def play(record):
        await record.publish()
        for name, field in record.fields.items():
            for about in ("", "STS_", "TIME_", "CTRL_"):
                if about != "CTRL_" or field.data_type.name != "STRING":
                    await field.read(ChannelType[about + field.data_type.name])
            assert len(field._data.get("units", "")) < 8, name

    run(play, units="kilometres", url="slewline://gs-c200s?chs=0")


@pytest.mark.parametrize("more", [{}, CY545 | {"resolution": -0.005, "units": "mm"}], ids=["gs-c200s", "cy545"])
def test_autosave_can_restore_its_saved_values(run, more):
    async def play(record):
        before = {name: record.get(name) for name in AUTOSAVE.split()}
        for name, value in before.items():
            if not record.motor.stopping and name in ("JVEL", "JAR", "HVEL"):
                continue  # a CY545 has neither jog nor homing
            await record.put(name, float(f"{value:.14g}") if isinstance(value, float) else value)
        assert {name: record.get(name) for name in AUTOSAVE.split()} == before
        assert steps(record) == 0

    run(play, **more)


def test_a_constant_is_refused_if_it_is_another_one(run):
    async def play(record):
        for row in (row for row in FIELDS if row.fixed):
            other = "x" if row.kind == "string" else 1 if row.words else row.value + 7
            with pytest.raises(UsageError, match="allowed"):
                await record.put(row.name, other)
        with pytest.raises(UsageError, match=r"^allowed only 1 \(units per step: `--resolution`\)$"):
            await record.put("MRES", 0.5)

    run(play)


# ---------------------------------------------------------------------------------------------------------- coordinates
def test_user_dial_and_raw_positions_follow_each_other(run):
    async def play(record):
        await record.put("OFF", 10.0)
        await record.put("DIR", 1)  # OFF changes, VAL stays
        assert here(record, "VAL", "OFF", "RBV", "DVAL") == (10, 10, 10, 0)
        await record.put("VAL", 4)
        assert here(record, "VAL", "DVAL", "RVAL", "RBV", "DRBV", "RRBV", "RMP") == (4, 6, 12, 4, 6, 12, 12)
        await record.put("DVAL", -1)
        assert here(record, "VAL", "RBV", "RVAL", "TDIR") == (11, 11, -2, 0)
        await record.put("RVAL", 8)
        assert here(record, "VAL", "RBV", "DRBV", "TDIR") == (6, 6, 4, 1)
        await record.put("RLV", -2.5)
        assert here(record, "VAL", "RBV", "RLV", "DRBV") == (3.5, 3.5, 0, 6.5)
        await record.put("TWV", 0.5)
        await record.put("TWR", 1)
        assert here(record, "VAL", "RRBV", "TWR", "DIFF", "RDIF") == (3, 14, 0, 0, 0)
        await record.put("FOFF", 1)
        await record.put("DIR", 0)  # VAL changes, OFF stays
        assert here(record, "OFF", "VAL", "RBV", "DVAL") == (10, 17, 17, 7)
        assert record.chip.position == 14

    run(play, resolution=0.5, units="mm")


def test_a_position_between_steps_stays_as_it_was_put(run):
    async def play(record):
        await record.put("VAL", 1.2)
        assert here(record, "VAL", "RBV", "RRBV", "MISS") == (1.2, 1, 2, 0)
        assert record.get("DIFF") == pytest.approx(0.2)
        await record.put("SYNC", 1)
        assert here(record, "VAL", "DVAL", "RVAL", "DIFF", "SYNC") == (1, 1, 2, 0, 0)

    run(play, resolution=0.5)


@pytest.mark.parametrize(
    ("frozen", "field", "value", "gives"),  # VAL, OFF, DVAL, RRBV; before: 100 0 100 100
    [
        (0, "VAL", 5, (5, -95, 100, 100)),
        (0, "RLV", 5, (105, 5, 100, 100)),
        (0, "TWF", 1, (101, 1, 100, 100)),
        (0, "DVAL", 7, (100, 93, 7, 7)),
        (0, "RVAL", 7, (100, 93, 7, 7)),
        (1, "VAL", 5, (5, 0, 5, 5)),
        (1, "DVAL", 7, (7, 0, 7, 7)),
        (1, "RVAL", -7, (-7, 0, -7, -7)),
    ],
)
def test_set_defines_the_position_and_moves_nothing(run, frozen, field, value, gives):
    async def play(record):
        await record.put("VAL", 100)
        await record.put("FOFF", frozen)
        await record.put("SET", 1)
        record.told.clear()
        await record.put(field, value)
        assert here(record, "VAL", "OFF", "DVAL", "RRBV") == gives
        assert (record.get("RBV"), record.chip.position) == (gives[0], gives[3])
        assert here(record, "HLM", "DHLM") == (8388607 + gives[1], 8388607)
        assert record.of("DMOV") == [("DMOV", 0), ("DMOV", 1)]
        for button in ("JOGF", "JOGR", "HOMF", "HOMR"):
            with pytest.raises(UsageError, match="the motor may not move"):
                await record.put(button, 1)
        assert steps(record) == 100
        await record.put("SUSE", 1)
        await record.put("RLV", 3)
        assert (steps(record), record.get("VAL")) == (103, gives[0] + 3)

    run(play)


def test_switches_have_fields_of_their_own_and_may_be_ignored(run):
    async def play(record):
        for field, of, value in (("SSET", "SET", 1), ("FOF", "FOFF", 1), ("SUSE", "SET", 0), ("VOF", "FOFF", 0)):
            await record.put(field, 1)
            assert record.fields[of].raw_value == value, field
        await record.put("SET", "Set")
        await record.put("IGSET", 1)
        await record.put("VAL", 20)
        assert steps(record) == 20

    run(play)


def test_a_part_without_a_command_for_it_gives_its_position_by_the_offset_only(run):
    async def play(record):
        await record.put("SET", 1)
        with pytest.raises(UsageError, match=r"no command that sets the position; change the offset \(OFF\)"):
            await record.put("DVAL", 5)
        assert here(record, "VAL", "DVAL", "OFF") == (0, 0, 0)
        await record.put("VAL", 5)
        assert here(record, "VAL", "RBV", "OFF") == (5, 5, 5)

    run(play, url="slewline://gs-c200?chs=0", part="gs-c200")


# --------------------------------------------------------------------------------------------------------------- limits
def limits(record, key):
    data = record.fields[key]
    return data.lower_ctrl_limit, data.upper_ctrl_limit, data.lower_disp_limit, data.upper_disp_limit


def test_limits_follow_each_other_and_are_the_control_limits(run):
    async def play(record):
        assert limits(record, "RVAL") == (-8388608, 8388607, -8388608, 8388607)  # before any put
        assert limits(record, "VAL") == (-4194304, 4194303.5, -4194304, 4194303.5)
        await record.put("HLM", 30)
        await record.put("LLM", -20)
        assert here(record, "DHLM", "DLLM", "RHLM", "RLLM") == (30, -20, 60, -40)
        for key in ("VAL", "RBV", "DVAL", "DRBV"):
            assert limits(record, key) == (-20, 30, -20, 30), key
        assert limits(record, "RVAL") == (-40, 60, -40, 60)
        assert limits(record, "VELO") == (50, 5000, 50, 5000)
        await record.put("OFF", 5)
        await record.put("FOFF", 1)
        await record.put("DIR", 1)
        assert here(record, "HLM", "LLM", "DHLM", "DLLM") == (25, -25, 30, -20)
        assert limits(record, "VAL") == (-25, 25, -25, 25)
        await record.put("HLM", 20)
        assert here(record, "DHLM", "DLLM") == (30, -15)
        await record.put("DHLM", 40)
        assert here(record, "HLM", "LLM") == (20, -35)

    run(play, resolution=0.5)


def test_a_limit_below_the_position_is_a_violation_and_the_return_is_not(run):
    async def play(record):
        await record.put("VAL", 100)
        await record.put("HLM", 50)
        assert here(record, "LVIO", "VAL") == (1, 100)
        await record.put("VAL", 110)
        assert (record.get("LVIO"), steps(record)) == (1, 100)
        await record.put("VAL", 80)  # towards the range
        assert here(record, "LVIO", "RBV") == (0, 80)
        await record.put("HLM", 90)
        assert record.get("LVIO") == 0
        await record.put("LLM", 95)  # no position is within
        await record.put("VAL", 70)
        assert here(record, "LVIO", "RBV") == (1, 80)

    run(play)


def test_a_limit_on_a_step_is_not_a_violation(run):
    async def play(record):
        await record.put("HLM", 0.3)
        await record.put("VAL", 0.3)
        await record.put("LLM", -0.7)
        assert (record.get("RBV") > 0.3, record.get("LVIO"), steps(record)) == (True, 0, 3)  # 3 * 0.1

    run(play, resolution=0.1)


def test_a_limit_that_is_put_meanwhile_stops_what_goes_beyond_it(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 50_000))
        await record.moving()
        await record.put("HLM", 20_000)
        await put
        assert 0 <= record.get("RBV") < 1000
        assert record.get("LVIO") == 1

    run(play)


# ---------------------------------------------------------------------------------------------------------------- rates
def test_a_rate_keeps_the_time_of_the_ramp_or_its_acceleration(run):
    async def play(record):
        before, accs = here(record, "ACCL", "ACCS")
        assert accs == pytest.approx(900 / before)
        await record.put("VELO", 4000)
        assert here(record, "ACCL", "S") == (pytest.approx(before, rel=0.01), 20)
        await record.put("ACCL", 0.2)
        assert here(record, "VELO", "VBAS", "ACCL") == (4000, 100, pytest.approx(0.2, rel=0.01))
        await record.put("ACCS", 10_000)
        assert record.get("ACCL") == pytest.approx(0.39, rel=0.01)
        await record.put("ACCU", 1)
        await record.put("S", 10)
        assert here(record, "VELO", "ACCS", "ACCL") == (
            2000,
            pytest.approx(1e4, rel=0.02),
            pytest.approx(0.19, rel=0.02),
        )
        await record.put("VAL", 5000)
        times = record.chip.steps().times_ps
        assert min(b - a for a, b in pairwise(times)) == pytest.approx(5e8, rel=0.01)

    run(play)


def test_rates_of_a_cy545_are_indices_and_a_slope(run):
    async def play(record):
        await record.put("VBAS", 200)
        await record.put("VELO", 3000)
        await record.put("ACCL", 0.1)
        assert here(record, "VBAS", "VELO", "ACCL") == pytest.approx((195, 3020, 0.0911), rel=0.01)
        await record.put("VAL", 3000)
        times = record.chip.steps().times_ps
        assert min(b - a for a, b in pairwise(times)) == pytest.approx(1e12 / record.get("VELO"), rel=0.01)

    run(play, **CY545)


def test_a_first_rate_raises_the_rates_below_it(run):
    async def play(record):
        await record.put("VBAS", 1500)
        assert here(record, "VELO", "VBAS", "BVEL", "JVEL", "SBAS") == (1500, 1500, 1500, 1500, 7.5)
        with pytest.raises(UsageError, match=r"VELO 1000; allowed VBAS \(1500\) or more"):
            await record.put("VELO", 1000)
        await record.put("VBAS", 100)
        await record.put("VELO", 1000)
        assert record.get("ACCL") == pytest.approx(0.0961, rel=0.02)  # as it was

    run(play)


def test_backlash_is_taken_up_by_a_second_move(run):
    async def play(record):
        await record.put("BDST", 50)
        await record.put("BVEL", 500)
        await record.put("BACC", 0.01)
        assert here(record, "BVEL", "SBAK", "BACC") == (500, 2.5, pytest.approx(0.01, rel=0.2))
        for target, more in ((1000, 1000), (300, 800), (310, 10)):
            before = steps(record)
            await record.put("VAL", target)
            assert (record.get("RBV"), steps(record) - before) == (target, more)
            assert set(record.chip.steps().directions[-10:].tolist()) == {1}
        times = record.chip.steps().times_ps
        assert min(b - a for a, b in pairwise(times[-50:])) > 1.9e9
        assert record.of("DMOV") == [("DMOV", 0), ("DMOV", 1)] * 3
        await record.put("HLM", 400)
        await record.put("BDST", -50)
        await record.put("VAL", 360)  # from 410
        assert here(record, "LVIO", "RBV") == (1, 310)

    run(play)


# -------------------------------------------------------------------------------------------------------------- buttons
def test_a_jog_continues_until_its_field_is_0(run):
    async def play(record):
        await record.put("JVEL", 2000)
        for button, sign in (("JOGF", 1), ("JOGR", -1)):
            before = record.get("RBV")
            jog = asyncio.create_task(record.put(button, 1))
            await record.moving()
            assert here(record, button, "DMOV") == (1, 0)
            with pytest.raises(UsageError, match="allowed only at rest"):
                await record.put("JVEL", 100)
            await record.put(button, 0)
            await jog
            assert 0 < (record.get("RBV") - before) * sign < 8000
            assert here(record, button, "DMOV", "LVIO") == (0, 1, 0)
            assert record.get("VAL") == record.get("RBV") == record.chip.position

    run(play)


def test_a_jog_ends_a_second_before_the_limit(run):
    async def play(record):
        await record.put("HLM", 3000)
        await record.put("LLM", -3000)
        await record.put("JOGF", 1)
        assert here(record, "RBV", "VAL", "LVIO", "JOGF") == (2000, 2000, 1, 0)
        await record.put("JOGF", 1)
        assert (record.get("LVIO"), steps(record)) == (1, 2000)
        await record.put("JOGR", 1)
        assert here(record, "RBV", "LVIO") == (-2000, 1)

    run(play)


def test_homing_is_at_its_own_rate_and_leaves_what_is_wanted_there(run):
    async def play(record):
        for switch in ("eot", "home"):
            record.chip.pin(switch).drive(0)
        with pytest.raises(UsageError, match="HOMF 0; allowed only 1"):
            await record.put("HOMF", 0)
        await record.put("HVEL", 300)
        module, sent = record.motor.module, []
        ask = module.ask
        module.ask = lambda command: sent.append(command) or ask(command)
        await record.put("HOMR", 1)  # with no move before
        assert [command for command in sent if command[0] in "SH"] == ["S30", "H-"]  # in tens
        assert here(record, "RBV", "VAL", "HOMR", "HVEL", "VELO") == (0, 0, 0, 300, 1000)
        assert int(record.get("MSTA")) & 0x4000
        assert record.of("HOMR") == [("HOMR", 1), ("HOMR", 0)]

    run(play)


def test_a_pause_keeps_the_target_and_go_resumes(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 4000))
        await record.moving()
        await record.put("SPMG", 1)
        assert here(record, "MOVN", "DMOV", "VAL", "LSPG") == (0, 0, 4000, "Pause")
        assert record.chip.position < 4000
        assert not put.done()
        await record.put("SPMG", "Go")
        await put
        assert here(record, "RBV", "DMOV", "SPMG") == (4000, 1, "Go")

    run(play)


def test_a_position_that_is_put_in_a_pause_waits(run):
    async def play(record):
        await record.put("SPMG", 1)
        put = asyncio.create_task(record.put("VAL", 400))
        for _ in range(20):
            await asyncio.sleep(0)
        assert (here(record, "VAL", "DMOV"), steps(record)) == ((400, 0), 0)
        await record.put("SPMG", 2)  # Move
        await put
        assert here(record, "RBV", "SPMG", "LSPG") == (400, "Pause", "Pause")
        put = asyncio.create_task(record.put("VAL", 500))
        for _ in range(20):
            await asyncio.sleep(0)
        await record.put("STOP", 1)
        await put
        assert here(record, "VAL", "RBV", "DMOV") == (400, 400, 1)
        await record.put("SPMG", 3)
        assert steps(record) == 400

    run(play)


def test_a_stop_by_spmg_ends_the_motion_for_good(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 40_000))
        await record.moving()
        await record.put("SPMG", 0)
        await put
        assert here(record, "SPMG", "DMOV") == ("Stop", 1)
        assert record.get("VAL") == record.get("RBV") == record.chip.position < 1000
        await record.put("SPMG", 3)
        assert record.get("RBV") == record.chip.position < 1000

    run(play)


@pytest.mark.parametrize(
    ("ntm", "target", "least", "most"),
    [(1, 8000, 8000, 8000), (1, 500, 500, 4000), (1, -500, 500, 4000), (0, 500, 11_500, 11_500)],
)
def test_a_new_position_stops_the_motion_unless_it_leads_on_or_ntm_is_no(run, ntm, target, least, most):
    async def play(record):
        await record.put("NTM", ntm)
        first = asyncio.create_task(record.put("VAL", 6000))
        await record.moving()
        await record.put("VAL", target)
        await first
        assert record.get("RBV") == record.chip.position == target
        assert least <= steps(record) <= most

    run(play)


def test_deadband_and_settling(run):
    async def play(record):
        await record.put("RDBD", 0.1)
        assert record.get("RDBD") == 0.5  # a step
        await record.put("DLY", 0.01)
        await record.put("VAL", 5)
        assert record.of("MOVN", "DMOV")[-2:] == [("MOVN", 0), ("DMOV", 1)]
        for field, value in (("DLY", -1), ("PREC", 16), ("IGSET", 2), ("DISP", 2)):
            with pytest.raises(UsageError, match="allowed"):
                await record.put(field, value)
        with pytest.raises(UsageError, match="TWV nan; expected a finite number"):
            await record.put("TWV", float("nan"))

    run(play, resolution=0.5)


def test_a_move_that_ends_elsewhere_is_missed_until_the_next_one(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 50_000))
        await record.moving()
        for _ in range(3):
            await record.motions.within(record.motor.at_rest)
        await record.motions.within(lambda: record.motor.module.ask("K"))  # by somebody else
        await put
        assert here(record, "MISS", "VAL", "DMOV") == (1, 50_000, 1)
        assert 0 < record.get("RBV") == record.chip.position < 50_000
        assert record.get("DIFF") == 50_000 - record.get("RBV")
        await record.put("VAL", 10)
        assert here(record, "MISS", "RBV") == (0, 10)

    run(play)


def test_an_update_queries_the_position_of_the_module(run):
    async def play(record):
        for line in ("Po", "S10", "T100", "R50", "+20", "E"):  # by somebody else
            record.motor.module.ask(line)
        while not record.motor.at_rest():
            pass
        assert record.get("RBV") == 0
        await record.put("STUP", 1)
        assert here(record, "RBV", "VAL", "STUP") == (20, 20, "OFF")
        assert record.of("STUP") == [("STUP", 2), ("STUP", 0)]

    run(play)


def test_a_record_that_is_disabled_refuses_puts(run):
    async def play(record):
        await record.put("_able", 1)
        assert record.get("DISP") == 1
        with pytest.raises(UsageError, match="DISP is 1"):
            await record.put("VAL", 5)
        await record.put("DISP", 0)
        assert record.get("_able") == "Enable"
        await record.put("VAL", 5)
        assert record.get("RBV") == 5

    run(play)


def test_texts_are_those_of_clients(run):
    async def play(record):
        await record.put("EGU", "mm")
        await record.put("PREC", 4)
        await record.put("DESC", "slit, top")
        assert here(record, "EGU", "PREC", "DESC", "NAME") == ("mm", 4, "slit, top", "m1")
        assert (record.fields["VAL"].units, record.fields["VELO"].units, record.fields["VAL"].precision) == (
            "mm",
            "mm/sec",
            4,
        )
        assert record.fields["JAR"].units == "mm/s/s"
        with pytest.raises(UsageError, match="EGU of 20 characters; allowed up to 15"):
            await record.put("EGU", "x" * 20)

    run(play)


def test_a_part_that_takes_no_command_in_motion_refuses_what_it_cannot_do(run):
    async def play(record):
        put = asyncio.create_task(record.put("VAL", 4000))
        await record.moving()
        for field, value in (("STOP", 1), ("SPMG", 1), ("SPMG", 0), ("JOGF", 1), ("JVEL", 100), ("HVEL", 100)):
            with pytest.raises(UsageError):
                await record.put(field, value)
        assert record.get("SPMG") == "Go"
        await put
        assert record.get("RBV") == record.chip.position == 4000
        await record.put("SPMG", 1)  # at rest
        assert record.get("SPMG") == "Pause"

    run(play, **CY545)
