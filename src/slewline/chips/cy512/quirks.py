"""Gaps in our knowledge of the CY512, whose manual is not available: the model's choice, its reason, and its test.

All choices are inferred: from remarks about the CY512 in the CY525 manual, from the CY525 itself where
these remarks are silent, and from the CY500.  Times apply at 11 MHz.  UND in an id means that no source
states the matter, CON that two passages disagree about it.  Data only.
"""

from __future__ import annotations

from ...core.datasheet.quirk import Quirk as _Q

# fmt: off
QUIRKS = (
    # ------------------------------------------------------------------------------------------------------- rates, ramps
    _Q("CY512-UND-RATE-LAW", "s.3, comparison R", "a step takes 200 µs at R 255 and 240/11 µs more for each unit below; option inferred.periods",
       "this results in 5000 and, with TERMINATE, almost 8000 steps/s; a unit is half that of the CY500", "test_the_law_is_an_option"),
    _Q("CY512-CON-SPEED", "CY512 page against s.1, guide", "5000 steps/s alone, 8000 with TERMINATE only",
       "the history distinguishes them", "test_terminate_kept_low_outputs_almost_8000_steps_a_second"),
    _Q("CY512-UND-R-256", "s.3, comparison R", "R 256 counts as 255, R 0 is a little slower than R 1; both are reported",
       "the number has one byte", "test_r_256_counts_as_255_and_r_0_is_a_little_slower_than_r_1"),
    _Q("CY512-CON-R-RANGE", "s.3, comparison R", "R goes from 1 to 255",
       "256 does not fit into a byte", "test_r_256_counts_as_255_and_r_0_is_a_little_slower_than_r_1"),
    _Q("CY512-UND-RAMP-RULE", "guide", "S is added to the rate parameter with every step, from 1 to R, and the factor becomes 1; S 0: no ramps",
       "the rule of the CY500, exponential as the guide says", "test_a_move_ramps_up_slews_and_ramps_down"),
    _Q("CY512-CON-SLOPE-GUIDE", "guide against CY512 page", "S exists, and its law is not linear",
       "the page promises ramps, the guide calls them exponential", "test_half_the_time_of_a_ramp_is_spent_below_a_tenth_of_the_rate"),
    _Q("CY512-UND-SLOWEST", "s.3, comparison, item 10", "a move is short if it has fewer steps than two ramps: all of it at parameter 1, factor 1; option inferred.ramp_start",
       "ramps begin there", "test_a_move_without_room_for_both_ramps_is_made_at_the_slowest_rate"),
    _Q("CY512-UND-FACTOR-RAMP", "s.3, comparison F", "F multiplies the time of each step; after S it counts in ramps, too, and is reported",
       "the Factor of the CY500", "test_a_factor_after_the_slope_counts_in_the_ramp_and_is_reported"),
    _Q("CY512-UND-TERMINATE", "CY512 page", "active low, a pin without a number; a step lasts for 92 machine cycles; option inferred.terminated",
       "7971 steps/s are almost 8000", "test_terminate_ends_the_running_step_but_not_before_92_cycles"),
    _Q("CY512-CON-CONTINUOUS", "guide against s.7", "there is no endless motion",
       "64K steps are its limit, which a program may repeat", "test_in_motion_no_position_is_read_and_no_motion_is_endless"),
    # ------------------------------------------------------------------------------------------------------- ends of motions
    _Q("CY512-UND-ABORT", "guide; s.3, comparison, item 9", "pin 6 low ramps down and stops; I/O REQUEST low at the end of a step stops there; options inferred.abort, .request",
       "one stop with a ramp and one without are listed", "test_abort_ramps_down_and_stops_whether_it_is_released_or_not"),
    _Q("CY512-UND-ABORT-FIRST", "s.3, comparison, item 9", "I/O REQUEST is sampled from the end of the first step on",
       "the first step may begin before it is high", "test_a_host_that_leaves_io_request_low_ends_its_motion_after_the_first_step"),
    _Q("CY512-UND-PULSE", "s.3, comparison, item 6; s.8", "PULSE is high for 16 µs at 6 MHz, within the period, and while a step is held; options inferred.pulse_high, .held_pulse",
       "longer than 2.5 µs; the 16 µs of s.8 are not the CY525's", "test_pulse_is_high_for_96_clocks_between_steps"),
    # ----------------------------------------------------------------------------------------------------- commands, programs
    _Q("CY512-UND-EXPEND", "s.3, comparison D", "X counts milliseconds at 11 MHz, up to 65535; X 0 does not wait; option inferred.millisecond",
       "the delay of the CY525 is compared with it without another unit", "test_a_delay_of_0_ends_immediately"),
    _Q("CY512-UND-OFFSET", "s.3, comparison O", "O 0 to 3 are the full steps of the CY525, O 4 to 7 the half step after each; others are ignored and reported; in full steps the next one continues from the previous full step",
       "a program for both parts means the same", "test_offset_shows_one_of_eight_patterns_and_ignores_others"),
    _Q("CY512-CON-O-MEANING", "s.3, comparison O", "O is Offset, without values that switch the coils off",
       "its former meaning is not stated", "test_offset_shows_one_of_eight_patterns_and_ignores_others"),
    _Q("CY512-UND-HALFSTEP", "s.3, comparison H", "half steps last until I or RESET, and each counts one",
       "as on the CY500", "test_h_selects_half_steps_until_i"),
    _Q("CY512-UND-L256", "guide", "L 0 and L 256 make 256 passes",
       "a byte holds 256 as 0", "test_a_loop_counts_up_to_256"),
    _Q("CY512-UND-V-END", "s.6", "past the end of a group FF is read",
       "as on the CY525", "test_program_and_status_are_read_and_ff_after_the_end"),
    _Q("CY512-UND-READY-PROGRAM", "s.3, comparison, items 4 and 7", "READY stays high while a program runs, and no request is accepted until RUN is high",
       "there are no live commands", "test_pin_31_admits_no_live_commands_and_no_request_is_taken_while_a_program_runs"),
    _Q("CY512-UND-POWERUP", "s.4", "N 0, R 1, S 0, F 1 at power-up; the use of an unset register is reported",
       "random values would not be repeatable", "test_uninitialised_registers_are_reported_at_their_first_use"),
    _Q("CY512-UND-ERRORS", "s.3", "mistakes of the host have the same effects as on the CY525",
       "commands have the same form", "test_an_unknown_command_swallows_only_its_own_line"),
    _Q("CY512-UND-TIMES", "T.V", "commands have the times of the CY525: F as Firstrate, X as Delay, D as Execute",
       "no other times are known", "test_a_command_is_taken_at_the_same_instants_by_cy512_and_cy525"),
    _Q("CY512-CON-BUFFER", "guide against s.4, s.6", "48 bytes are the CY512's, 60 the CY525's",
       "the guide has a column for each", "test_the_program_buffer_holds_the_size_in_the_sheet_and_drops_the_rest"),
)
# fmt: on
