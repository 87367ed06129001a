"""Gaps in our knowledge of the CY500, whose manual is not available: the model's choice, its reason, and its test.

UND-...: no source states it; the choice is inferred.  CON-...: two sources disagree.  "CY525 s.1": section 1 of
the CY525's manual; T.1 and T.2 are tables of the article (sheet.py).  Data only.
"""

from __future__ import annotations

from ...core.datasheet.quirk import Quirk

# fmt: off
_ROWS = (
    # -------------------------------------------------------------------------------------------- rates and motions
    ("UND-RATE-LAW", "T.2 R", "the period of a step is linear in R, 78.18 µs per unit at 6 MHz; option inferred.periods", "both ends are exact, as with a preset timer; the rate equation is not printed", "test_the_period_falls_by_the_same_with_each_unit_of_the_rate"),
    ("UND-R-RANGE", "T.2 R", "R 0 continues below R 1, at 20.08 ms per step; R 254 and 255 count as 253", "one byte; the highest rate is stated", "test_rates_outside_1_to_253_are_reported_and_count_as_the_nearest"),
    ("CON-TOP-SPEED", "T.2 R against CY525 s.1, CY500 page, guide", "3350 steps/s at 6 MHz; 3360 and 3300+ are within half a percent", "the article states it with its parameter; the 2K of the guide is the same at 3.58 MHz", "test_rates_at_both_ends"),
    ("CON-SCALE", "text against T.2 R", "rates scale with f/6 MHz", "the text is garbled", "test_rates_follow_the_crystal"),
    ("UND-RAMP-START", "T.2 S", "step i of a ramp has the parameter 1 + (i - 1) * S; option inferred.ramp_start", "1 is the lowest legal one", "test_a_slope_raises_the_rate_parameter_with_each_step_and_lowers_it_alike"),
    ("UND-SHORT", "T.2 S", "a move that is too short decelerates when R is reached, and stops dead at the target; if R is never reached it ends at full speed", "the described procedure has this effect; the user must avoid it", "test_too_short_a_slope_is_cut_off_at_the_target"),
    ("CON-N-BOUND", "T.2 S", "N must be above twice the steps of the ramp; twice R is correct for S 1", "a ramp of S per step takes (R - 1) / S steps", "test_too_short_a_slope_is_cut_off_at_the_target"),
    ("UND-SLOPE-OFF", "T.2 S", "S 0, I and RESET end slopes; until then the factor is 1, whenever F was sent, and F takes effect after them", "no other end is described", "test_slopes_end_with_s_0_and_with_i"),
    ("UND-P-START", "T.1, T.2 P", "P sets the target, G starts; option p_starts", "both tables state this", "test_p_declares_and_g_starts_unless_the_option_differs"),
    ("CON-P", "T.1, T.2 P against CY525 s.1", "P sets the target, G starts; option p_starts", "the history writes the command alone", "test_p_declares_and_g_starts_unless_the_option_differs"),
    ("UND-P-WRONG", "CY525 s.1", "with the direction away from the target the motion passes the overflow of the register, modulo 65536", "a 16-bit register", "test_the_wrong_direction_travels_the_full_circle"),
    ("UND-P-N-MODE", "T.2 N, P", "the last of N and P decides what G does", "the source states that each selects its mode", "test_the_last_of_n_and_p_decides"),
    ("UND-POSITION-COUNT", "T.2 O, J, H", "every step of any kind counts one, modulo 65536", "there is one register", "test_every_kind_of_step_counts_one"),
    ("UND-N-ZERO", "T.2 N", "G with N 0 takes no step", "as the CY525", "test_n_0_takes_no_step_and_is_reported"),
    ("UND-N256", "T.2 N", "option early_part: N 256 * k takes 256 steps too few", "a faulty borrow in a counter of two bytes would have this effect; the failure is not described", "test_early_parts_lose_256_steps_at_multiples_of_256"),
    ("UND-A-RULES", "T.2 A", "A after a change of direction, and a second A, set zero all the same, with a finding", "their effect is not stated", "test_a_where_it_is_not_allowed_is_reported"),
    ("UND-A-N", "T.2 N", "one step less for N as the very next command after A, in a program too, until the next N", "read to the letter", "test_n_directly_after_a_takes_one_step_less"),
    ("UND-PULSE", "CY525 s.8", "PULSE is high for 16 µs at 6 MHz before each step, within its period", "the CY525's manual has the figure next to its own 2.5 µs", "test_pulse_is_high_for_16_us_between_steps"),
    ("UND-PHASE", "text", "full steps as the CY525, half steps between them", "no table is at hand", "test_half_steps_go_through_eight_patterns_and_full_steps_through_four"),
    ("CON-PHASES", "text", "four phases", "the same sentence names three outputs and a motor with four phases", "test_half_steps_go_through_eight_patterns_and_full_steps_through_four"),
    ("UND-HALF-OFF", "T.2 I", "I ends half steps, and the pattern pointer goes to the first row", "it is initialised", "test_i_ends_the_modes_and_keeps_the_parameters"),
    ("UND-O-PULSE", "T.2 O", "O makes one PULSE of the width of R 253, then MOTION COMPLETE falls", "it is untimed, but a pulse has a width", "test_o_takes_one_step_immediately_at_any_rate"),
    ("UND-TRIGGER", "T.2 O; CY500 page", "TRIGGER is pin 30, high delays the next step; ABORT is pin 6, low ends a motion after the current step", "the CY525's pins; the guide lists an emergency stop, no ramp down", "test_trigger_holds_the_next_step_with_pulse_high"),
    # ----------------------------------------------------------------------------------------- external lines, modes
    ("UND-JOG-COMMAND", "T.2 J", "in jog mode commands are accepted while XSS is high; low runs the motor before the next command letter", "stepping needs the processor", "test_commands_wait_while_the_motor_jogs"),
    ("CON-JOG", "T.2 J against itself", "commands are accepted while XSS is high", "low cannot both allow commands and run the motor", "test_commands_wait_while_the_motor_jogs"),
    ("UND-JOG-END", "T.2 J", "I and RESET end jog mode; G is ignored in it", "no other end is described", "test_g_is_ignored_in_jog_mode_which_i_ends"),
    ("UND-JOG-SLOPE", "T.2 J", "a jog has no ramp: R with the factor", "its end is not known beforehand", "test_a_jog_has_no_ramp"),
    ("UND-JOG-SAMPLE", "T.2 J", "XSS is sampled as a step begins", "the current step is finished", "test_xss_low_runs_the_motor_until_it_is_high"),
    ("UND-L-END", "T.2 L", "after I and RESET + and - set the direction again", "no other end is described", "test_i_ends_the_modes_and_keeps_the_parameters"),
    ("CON-I-PROGRAM", "T.1 against T.2 I", "I keeps N, P, R, F and the value of S; it erases program and modes", "the longer text names the parameters", "test_i_ends_the_modes_and_keeps_the_parameters"),
    ("CON-U", "T.1 against T.2 U", "U waits until WAIT is low", "as in its successors, whose W waits for high", "test_u_waits_until_wait_is_low"),
    # ---------------------------------------------------------------------------------------- programs, port, power
    ("UND-PROG-END", "T.2 D", "the end of the stored bytes is a 0", "D without a program is, too", "test_the_end_of_a_program_is_a_0"),
    ("UND-ZERO-CODE", "T.2 0", "0 is stored as 00", "as the CY525", "test_a_program_takes_as_many_bytes_as_its_commands"),
    ("CON-ZERO", "T.2 0", "0 is sent as 30 hex", "the table prints 40, which is not the code of a digit", "test_zero_is_the_digit"),
    ("UND-OVERFLOW", "guide", "bytes beyond 18 are dropped", "as the CY525", "test_the_program_buffer_holds_the_size_in_the_sheet_and_drops_the_rest"),
    ("UND-NESTED-E", "T.2 E, Q", "E in a program is stored and skipped; Q in command mode does nothing", "Q belongs after every program", "test_e_in_a_program_is_skipped"),
    ("UND-BINARY", "CY500 page", "letter, count, data, low byte first; Q alone", "as the CY525", "test_binary_commands_are_letter_count_data"),
    ("UND-HANDSHAKE", "CY500 page", "I/O REQUEST, READY, INSTROBE as the CY525; in programs READY is high and requests wait", "so does the CY512, whose pins agree in nine of ten", "test_ready_stays_high_while_a_program_runs"),
    ("UND-POWERUP", "-", "N 0, R 1, F 1, S 0, clockwise, any position", "as its successors", "test_register_contents_at_power_up"),
    ("UND-ERRORS", "-", "unknown letters and bad numbers as the CY525", "the commands look alike", "test_unknown_letters_take_their_line_along"),
    ("UND-TIMES", "-", "times in progress as the CY525, in clocks; 375 µs at 11 MHz for commands that the CY525 lacks", "no figures", "test_commands_take_the_clocks_of_the_cy525"),
    ("CON-INSTR-COUNT", "CY500 page, guide, T.1, T.2", "22 commands", "24 and 21 are printed elsewhere; the tables list 22", "test_there_are_22_commands"),
    ("CON-DELAY-GUIDE", "guide against T.1", "there is no delay", "no command of the tables is one", "test_there_are_22_commands"),
)
# fmt: on
QUIRKS = tuple(Quirk(f"CY500-{row[0]}", *row[1:]) for row in _ROWS)
