"""The commands of the CY500: what each does, in ASCII and in binary, by itself and in programs."""

from __future__ import annotations

import pytest
from cy500 import FULL, Rig500, made

from slewline.chips import sheet_of
from slewline.core.datasheet.channel import BusHandshake

SHEET = sheet_of("cy500")
ONE_BYTE = "ABCDEGHIJLOTU+-0"


# ------------------------------------------------------------------------------------------------ forms, sizes, numbers
@pytest.mark.fact("CY500-FORM-1", "CY500-CMD-G-1")
def test_a_command_is_a_letter_or_a_letter_and_a_number() -> None:
    rig = made("C")
    assert rig.level("programmable_output") == 0
    rig.say("B", "R 253", "N 5", "G")
    assert rig.level("programmable_output") == 1
    assert len(rig.times) == 5
    assert rig.codes == []


@pytest.mark.fact("CY500-SET-1", "CY500-CON-INSTR-COUNT", "CY500-CON-DELAY-GUIDE")
def test_there_are_22_commands() -> None:
    assert "".join(row.form for row in SHEET.commands) == "ABCDEFGHIJLNOPQRSTU+-0"
    assert [row.name for row in SHEET.commands if row.stored] == [
        *("ATHOME", "BITSET", "CLEARBIT", "DOITNOW", "ENTER", "FACTOR", "GOSTEP", "HALFSTEP", "INITIALIZE", "JOG"),
        *("LEFTRIGHT", "NUMBER", "ONESTEP", "POSITION", "RATE", "SLOPE", "TIL", "UNTIL", "CW", "CCW", "COMMAND"),
    ]


@pytest.mark.fact("CY500-SET-1")
@pytest.mark.parametrize("letter", "KMVWXYZ")
def test_other_letters_are_unknown(letter: str) -> None:
    assert made(letter).codes == ["unknown-command"]


@pytest.mark.fact("CY500-UND-ERRORS")
def test_unknown_letters_take_their_line_along() -> None:
    rig = made("Z 7", "N x", "C", "b", "G 3")
    assert rig.codes == ["unknown-command", "bad-number", "unknown-command", "extra-argument", "no-steps"]
    assert rig.level("programmable_output") == 0
    assert rig.x.registers["number"] == 0


@pytest.mark.fact("CY500-SIZE-1", "CY500-UND-ZERO-CODE")
def test_a_program_takes_as_many_bytes_as_its_commands() -> None:
    rig = Rig500()
    rig.enter("R 200", "N 300", "G", "0")
    assert rig.x.program.hex(" ") == "52 c8 4e 2c 01 47 00"
    for letter, size in [*((letter, 1) for letter in ONE_BYTE), ("F 2", 2), ("R 2", 2), ("S 2", 2), ("P 2", 3)]:
        rig.enter(letter)
        assert len(rig.x.program) == size, letter


@pytest.mark.fact("CY500-CON-ZERO", "CY500-CMD-0-1")
def test_zero_is_the_digit() -> None:
    rig = made("@")
    assert rig.codes == ["unknown-command"]
    rig.enter("B", "0", "C")
    rig.say("C")
    rig.execute()
    assert rig.level("programmable_output") == 1
    assert rig.level("run") == 1


@pytest.mark.fact("CY500-RANGE-1")
def test_numbers_and_positions_go_to_64k() -> None:
    rig = made("P 36003", "N 65535", "P 0")
    assert rig.codes == ["no-go"]
    assert rig.x.registers["number"] == 65535


@pytest.mark.fact("CY500-CMD-R-1", "CY500-UND-R-RANGE")
def test_rates_outside_1_to_253_are_reported_and_count_as_the_nearest() -> None:
    assert made("R 1", "R 253").codes == []
    for rate, clocks in ((0, 120_469), (254, 1791), (255, 1791)):
        rig = made(f"R {rate}", "N 2", "G")
        assert rig.codes == ["range"]
        assert rig.gaps == [clocks]


@pytest.mark.fact("CY500-BIN-1", "CY500-UND-BINARY")
def test_binary_commands_are_letter_count_data() -> None:
    rig = Rig500(straps={"ascii_binary": 0})
    rig.send(bytes.fromhex("52 01 FD 4E 02 07 00 2B 00 47 00"))
    assert rig.signs == [1] * 7
    rig.send(bytes.fromhex("45 00 4E 02 2C 01 30 00 51 42 00"))
    assert rig.x.program.hex() == "4e2c0100"
    assert rig.codes == []


# --------------------------------------------------------------------------------------------------- single commands
@pytest.mark.fact("CY500-CMD-A-1")
def test_a_makes_the_present_position_zero() -> None:
    rig = made("R 253", "N 7", "-", "G", "A", "+", "P 10", "G")
    assert rig.signs == [-1] * 7 + [1] * 10
    assert rig.x.position == 10


@pytest.mark.fact("CY500-CMD-A-2", "CY500-CMD-A-3", "CY500-UND-A-RULES")
def test_a_where_it_is_not_allowed_is_reported() -> None:
    assert made("-", "A").codes == ["a-after-direction"]
    assert made("+", "A").codes == ["a-after-direction"]
    assert made("A", "A").codes == ["a-twice"]
    rig = made("R 253", "A", "N 4", "G", "A")
    assert rig.x.position == 0
    assert made("A", "I", "A").codes == []
    rig = made("A")
    rig.x.reset()
    rig.bench.run("1 ms")
    assert rig.say("A").codes == []
    assert made("-", "B", "A").codes == []


@pytest.mark.fact("CY500-CMD-B-1", "CY500-PIN-1")
def test_b_and_c_switch_pin_34() -> None:
    rig = Rig500(record=("programmable_output",))
    rig.say("C", "B", "C")
    assert [level for _, level in rig.edges("programmable_output")] == [0, 1, 0]
    numbers = {pin.name: pin.number for pin in SHEET.pins}
    assert [numbers[name] for name in ("programmable_output", "xss", "xdir")] == [34, 28, 29]


@pytest.mark.fact("CY500-CMD-N-2", "CY500-UND-A-N")
def test_n_directly_after_a_takes_one_step_less() -> None:
    rig = made("R 253", "A", "N 10", "+", "G", "G")
    assert len(rig.times) == 18
    assert rig.x.registers["number"] == 9
    assert rig.codes == ["n-after-a"]
    rig.say("N 10", "G")
    assert len(rig.times) == 28
    assert len(made("R 253", "A", "B", "N 10", "G").times) == 10


@pytest.mark.fact("CY500-UND-A-N")
def test_n_directly_after_a_in_a_program_takes_one_step_less_too() -> None:
    rig = made("R 253")
    rig.enter("A", "N 10", "G", "0")
    rig.execute()
    assert len(rig.times) == 9
    rig.enter("N 10", "G", "0")
    rig.say("A")
    rig.execute()
    assert len(rig.times) == 19  # D is between


@pytest.mark.fact("CY500-CMD-N-3", "CY500-UND-N256")
def test_early_parts_lose_256_steps_at_multiples_of_256() -> None:
    assert len(made("R 253", "N 512", "G").times) == 512
    for number, steps in ((512, 256), (256, 0), (255, 255), (257, 257)):
        rig = made("R 253", f"N {number}", "G", early_part=True)
        assert len(rig.times) == steps
        assert ("early-part" in rig.codes) == (number % 256 == 0)
    assert len(made("R 253", "A", "P 512", "G", early_part=True).times) == 512


@pytest.mark.fact("CY500-CMD-P-1", "CY500-UND-P-START", "CY500-CON-P")
def test_p_declares_and_g_starts_unless_the_option_differs() -> None:
    rig = made("R 253", "A", "+", "P 25")
    assert rig.times == []
    assert rig.say("G").x.position == 25
    rig = made("R 253", "A", "+", "P 25", p_starts=True)
    assert rig.x.position == 25
    assert len(rig.times) == 25


@pytest.mark.fact("CY500-CMD-P-2", "CY500-UND-P-WRONG")
def test_the_wrong_direction_travels_the_full_circle() -> None:
    rig = made("R 253", "A", "N 100", "+", "G")
    assert rig.x.position == 99
    rig.say("P 40", "G")
    assert (len(rig.times), rig.x.position) == (99 + 65536 - 59, 40)
    assert rig.codes == ["n-after-a", "wrong-way"]
    rig.say("-", "P 10", "G")
    assert rig.x.position == 10
    assert rig.codes == ["n-after-a", "wrong-way"]
    assert rig.signs[-30:] == [-1] * 30


@pytest.mark.fact("CY500-UND-P-N-MODE")
def test_the_last_of_n_and_p_decides() -> None:
    rig = made("R 253", "A", "B", "N 5", "P 8", "G", "G")
    assert rig.x.position == 8
    rig.say("N 5", "G")
    assert rig.x.position == 13
    rig.say("P 20", "I", "G")
    assert rig.x.position == 20


@pytest.mark.fact("CY500-CMD-I-1", "CY500-CMD-I-3", "CY500-CON-I-PROGRAM", "CY500-UND-L-END", "CY500-UND-HALF-OFF")
def test_i_ends_the_modes_and_keeps_the_parameters() -> None:
    rig = Rig500()
    rig.drive("xdir", 0)
    rig.enter("B", "0")
    rig.say("R 253", "N 7", "F 2", "S 3", "H", "L", "J", "I")
    assert rig.phases == (1, 1, 1, 1)
    assert rig.x.program == b""
    assert {**rig.x.registers, "position": 0} == dict(number=7, rate=253, factor=2, slope=3, position=0)
    rig.say("G")
    assert rig.signs == [1] * 7
    assert rig.gaps == [2 * 1791] * 6
    assert rig.phases == FULL[7 % 4]


# ------------------------------------------------------------------------------------------------------------- programs
@pytest.mark.fact("CY500-CMD-Q-2")
def test_q_is_accepted_after_a_program() -> None:
    rig = Rig500()
    rig.enter("B", "0")
    rig.execute()
    rig.send("QR 100\r")
    assert rig.x.registers["rate"] == 100
    assert rig.codes == []


@pytest.mark.fact("CY500-CMD-D-2")
def test_d_without_a_program_returns_to_command_mode() -> None:
    rig = made("C", "D", "B")
    assert rig.level("programmable_output") == 1
    assert rig.level("run") == 1
    assert rig.codes == ["empty-program"]


@pytest.mark.fact("CY500-CMD-D-3")
def test_d_in_a_program_restarts_it_with_the_latest_parameters() -> None:
    rig = made("R 200", "N 2", "F 1")
    rig.enter("G", "R 100", "D")
    rig.start("D\r")
    rig.bench.run("200 ms")
    gaps = rig.gaps
    assert gaps[0] == 26_652
    assert {gap for gap in gaps[2::2]} == {73_561}
    assert len(gaps) > 10
    assert rig.level("run") == 0


@pytest.mark.fact("CY500-UND-PROG-END")
def test_the_end_of_a_program_is_a_0() -> None:
    rig = made("C")
    rig.enter("B")
    rig.execute()
    rig.say("C")
    assert rig.level("programmable_output") == 0
    assert rig.codes == ["end-of-program"]


@pytest.mark.fact("CY500-UND-NESTED-E")
def test_e_in_a_program_is_skipped() -> None:
    rig = made("C")
    rig.enter("E", "B", "0")
    rig.execute()
    assert rig.level("programmable_output") == 1
    assert rig.x.program.hex() == "454200"
    assert rig.codes == ["enter-while-running"]


@pytest.mark.fact("CY500-CMD-T-1")
def test_t_repeats_the_program_while_xss_is_low() -> None:
    rig = made("C", "R 253", "N 5")
    rig.drive("xss", 0)
    rig.enter("+", "G", "-", "G", "T", "B", "0")
    assert rig.x.program.hex(" ") == "2b 47 2d 47 54 42 00"
    rig.start("D\r")
    rig.bench.run("40 ms")
    assert rig.level("programmable_output") == 0
    rig.drive("xss", 1)
    rig.bench.run_until_idle("1 s")
    assert rig.level("programmable_output") == 1
    signs = rig.signs
    assert len(signs) % 10 == 0
    assert len(signs) > 20
    assert signs == ([1] * 5 + [-1] * 5) * (len(signs) // 10)


@pytest.mark.fact("CY500-FAM-3")
def test_a_coil_is_wound_layer_by_layer_until_a_line_ends_it() -> None:
    rig = made("R 225")
    rig.drive("xss", 0)
    rig.enter("+", "N 300", "G", "-", "G", "T", "0")
    assert rig.x.program.hex(" ") == "2b 4e 2c 01 47 2d 47 54 00"
    rig.start("D\r")
    rig.bench.run("2 s")
    rig.drive("xss", 1)
    rig.bench.run_until_idle("5 s")
    assert rig.signs == ([1] * 300 + [-1] * 300) * 2
    assert rig.gaps[0] == 14_925  # 402 steps/s


@pytest.mark.fact("CY500-CMD-U-1", "CY500-CON-U")
def test_u_waits_until_wait_is_low() -> None:
    rig = made("C")
    rig.drive("wait", 1)
    rig.enter("U", "B", "0")
    rig.start("D\r")
    rig.bench.run("5 ms")
    assert rig.level("programmable_output") == 0
    rig.pull_request("100 us")
    rig.bench.run("5 ms")
    assert rig.level("programmable_output") == 0  # the host does not end it
    rig.drive("wait", 0)
    rig.bench.run("1 ms")
    assert rig.level("programmable_output") == 1


# ------------------------------------------------------------------------------------------------------ port and power
@pytest.mark.fact("CY500-UND-HANDSHAKE")
def test_ready_stays_high_while_a_program_runs() -> None:
    rig = Rig500(record=("ready", "run", "pulse"))
    rig.say("R 253", "N 20")
    rig.enter("G", "C", "0")
    rig.host.send("D\r")
    rig.bench.run_until(rig.x.pin("run").is_(0), "1 s")
    began = rig.bench.now_ps
    rig.bench.run("3 ms")
    assert rig.falls("ready", began) == []
    assert len(rig.times) > 5
    rig.send("B\r")
    assert rig.falls("ready", began)[0] > rig.rises("run", began)[0]
    assert rig.level("programmable_output") == 1


@pytest.mark.fact("CY500-UND-HANDSHAKE")
def test_ready_is_low_for_the_motion_of_a_command_which_does_not_wait_for_the_host() -> None:
    rig = Rig500(record=("ready", "pulse", "io_request", "motion_complete"))
    rig.say("R 253", "N 3")
    began = rig.bench.now_ps
    rig.host.send("G")
    rig.pull_request("8 ms", b"\r", ready=True)
    rig.bench.run_until_idle("1 s")
    steps = rig.falls("pulse", began)
    assert len(steps) == 3
    assert rig.rises("io_request", began)[-1] > steps[-1]
    assert rig.falls("ready", began)[-1] < steps[0]
    assert rig.rises("ready", began)[-1] > steps[-1]


@pytest.mark.fact("CY500-UND-POWERUP")
def test_register_contents_at_power_up() -> None:
    rig = Rig500()
    assert rig.x.registers == dict(number=0, slope=0, rate=1, factor=1, position=0xA55A)
    outputs = [pin.name for pin in SHEET.pins if pin.in_out == "out" and pin.name != "clk15"]
    assert set(rig.levels(*outputs)) == {1}
    rig.say("P 0xA", "P 42331", "G")
    assert "uninitialised" in rig.codes
    assert rig.signs[0] == 1


@pytest.mark.fact("CY500-UND-TIMES")
def test_commands_take_the_clocks_of_the_cy525() -> None:
    rig = Rig500(record=("ready",))
    rig.host.send("C\r")
    rig.bench.run_until_idle("1 s")
    falls, rises = rig.falls("ready"), rig.rises("ready")
    for busy, clocks in ((rises[0] - falls[0], 187 * 11 - 26 * 11), (rises[1] - falls[1], 297 * 6)):
        assert round(busy * 6 / 10**6) == clocks


@pytest.mark.fact("CY500-PIN-3")
def test_run_and_motion_complete_inform_a_host() -> None:
    rig = Rig500(record=("run", "motion_complete", "pulse"))
    rig.say("R 253", "N 3")
    rig.enter("G", "0")
    rig.execute()
    assert [level for _, level in rig.edges("run")] == [0, 1]
    assert rig.rises("pulse")[-1] < rig.falls("motion_complete")[-1] < rig.rises("run")[-1]


@pytest.mark.fact("CY500-PIN-4", "CY500-FAM-1")
def test_there_is_no_direction_no_slewing_and_no_read_out() -> None:
    roles = {pin.role for pin in SHEET.pins}
    assert not roles & {"direction", "slewing", "select", "out_strobe"}
    assert not SHEET.through(BusHandshake).verify_bytes
    assert not SHEET.labels
    assert all(arg.name != "target" for row in SHEET.commands for arg in row.args)


@pytest.mark.fact("CY500-CLOCK-1")
@pytest.mark.parametrize(
    ("crystal", "told"), [("1 MHz", []), ("3.579545 MHz", []), ("6 MHz", []), ("6.1 MHz", ["crystal"])]
)
def test_crystals_from_1_to_6_mhz_fit(crystal: str, told: list[str]) -> None:
    assert made("C", crystal=crystal).codes == told
