"""Motions of the CY545, jog and HOME: what no readable page tells, or two tell differently.  Data only."""

from __future__ import annotations

from ...core.datasheet.quirk import Quirk as _Q

# fmt: off
MOTION = (
    # ------------------------------------------------------------------------------------------------------ rates and ramps
    _Q("CY545-CON-RATE-TOP", "guide against ch.16, JOG", "20,000 steps/s at index 255, and so 27K with 16 MHz; option rate_table = \"27k\" has 27,027 with 12 MHz",
       "a twentieth is about 1000 at 12 MHz; 27 to 20 is 16 to 12 within 1.3 %; the guide names no crystal", "test_the_top_rate_is_20000_or_27000_as_the_option_says"),
    _Q("CY545-UND-RAMP-RULE", "2002 p.77", "an index lasts 256 * (256 - S) machine cycles from the first step on; a step takes all that are due as it begins, the way down mirrors the way up; options ramp_jumps, inferred.ramp_unit",
       "the formula to the letter; the CY525, whose manual prints measured times, takes one a step, which is the option here", "test_a_ramp_takes_the_rates_that_are_due_all_at_once_or_one_a_step"),
    _Q("CY545-UND-R-BELOW-F", "not mentioned", "the whole motion at F, with SLEW low; it is told",
       "as the CY525", "test_r_below_f_makes_the_whole_motion_at_f_with_slew_low"),
    _Q("CY545-UND-S-ZERO", "ch.5", "256 - S is 256; it is told",
       "as the CY525", "test_s_0_counts_as_256_less_0"),
    # -------------------------------------------------------------------------------------------------------- begin and end
    _Q("CY545-UND-FIRST-STEP", "not mentioned", "100 us behind the command, 25 us behind INHIBIT_ABORT high; options inferred.first_step, .inhibit_release",
       "so that it is always the same", "test_a_motion_begins_100_us_behind_its_command_and_ccw_comes_well_before"),
    _Q("CY545-UND-CCW-SETUP", "not mentioned", "CCW is set 20 us before the first PULSE at the latest; option inferred.ccw_lead",
       "drivers need it", "test_a_motion_begins_100_us_behind_its_command_and_ccw_comes_well_before"),
    _Q("CY545-UND-PULSE-WIDTH", "ch.16, PULSE and CCW", "PULSE is low for 5 us; option inferred.pulse_low",
       "five machine cycles, less than half of the shortest step", "test_pulse_is_low_at_the_begin_of_a_step_for_a_time_that_only_the_crystal_changes"),
    _Q("CY545-UND-PERIOD-FIRST", "ch.16, PULSE and CCW", "a step begins with PULSE low, when the position changes, and its period follows",
       "low at the beginning of a step, the text says", "test_a_period_lies_between_two_falls_and_is_one_over_the_rate"),
    _Q("CY545-UND-STOPPED-REF", "ch.16, STOPPED", "5 ms from the end of the last period, by the crystal",
       "as D counts", "test_stopped_is_low_throughout_and_rises_5_ms_behind_the_last_step"),
    _Q("CY545-UND-STOPPED-OTHER", "ch.16, STOPPED", "STOPPED is high while INHIBIT_ABORT holds a motion and where a limit refuses one, low in HOME and from the first step of jog to 5 ms behind the last one",
       "it tells whether the motor steps", "test_stopped_is_low_from_the_first_jog_step_until_5_ms_behind_the_last_one"),
    _Q("CY545-CON-SLEW-TIME", "ch.16, SLEW against STOPPED", "from SLEW high to STOPPED high it takes the ramp and 5 ms",
       "the 5 ms are added behind the last step", "test_slew_is_low_exactly_while_steps_are_made_at_the_rate_of_r"),
    # ---------------------------------------------------------------------------------------------------------- continuous
    _Q("CY545-UND-CONT-P", "ch.16, SLEW", "P takes its direction from the target, and runs on without end",
       "a continuous motion has no target", "test_p_in_continuous_mode_takes_its_direction_from_the_target_and_runs_on"),
    _Q("CY545-UND-CONT-LASTS", "ch.16, SLEW", "C lasts until a G or P has ended, with or without a step; jog and HOME in between leave it",
       "the text has it followed by G, and calls what G and P begin a motion", "test_c_lasts_through_jog_and_home_to_the_end_of_the_next_motion"),
    _Q("CY545-UND-CONT-RELEASE", "ch.16, SLEW, INHIBIT_ABORT", "INHIBIT_ABORT high again at the first rate: on at it, until the line is low",
       "there is no target to run to", "test_a_continuous_motion_whose_abort_is_taken_back_goes_on_at_the_first_rate_until_the_line_is_low"),
    _Q("CY545-UND-SLEW-INPUT", "ch.16, SLEW", "SLEW reads low as long as it is pulled low",
       "its high level is a pull-up", "test_slew_pulled_low_before_the_first_step_makes_a_motion_continuous_and_later_does_not"),
    # ------------------------------------------------------------------------------------------------------- INHIBIT_ABORT
    _Q("CY545-UND-INHIB-SAMPLE", "ch.16, INHIBIT_ABORT", "it is looked at as each step ends; on the way up the motion turns at once and comes down as far as it went up, to its first step at F",
       "symmetric, the text says; at F it is tested step by step", "test_on_the_way_up_it_turns_at_once_and_comes_back_down_as_far_as_it_went_up"),
    _Q("CY545-UND-INHIB-NORAMP", "ch.16, INHIBIT_ABORT", "low at the end of a step at F it ends the motion there",
       "it is at the first rate already", "test_low_in_a_motion_at_the_first_rate_it_ends_with_the_step_in_progress"),
    _Q("CY545-UND-INHIB-TARGET", "ch.16, INHIBIT_ABORT", "the target ends a motion on its way down, too",
       "the position counts", "test_the_target_ends_a_motion_that_inhibit_abort_slows_down"),
    _Q("CY545-UND-INHIB-JOG", "ch.16, INHIBIT_ABORT", "it says nothing to jog and HOME",
       "the text names G and P", "test_a_limit_ends_jog_in_its_direction_and_inhibit_abort_does_not"),
    # -------------------------------------------------------------------------------------------------------------- limits
    _Q("CY545-UND-LIMIT-SAMPLE", "ch.16, CW_LIMIT and CCW_LIMIT", "limits are looked at before each step, at the begin behind INHIBIT_ABORT; the step in progress is made",
       "nothing ends the wait for INHIBIT_ABORT", "test_a_limit_ends_a_motion_with_the_step_in_progress"),
    _Q("CY545-UND-LIMIT-JOG", "ch.16, CW_LIMIT and CCW_LIMIT", "jog makes no step into the limit of the direction that CCW would show, which may be pulled low",
       "limits stop motions in their direction, and CCW as an input says which that is", "test_jog_goes_by_the_limit_of_the_direction_to_which_ccw_is_forced"),
    _Q("CY545-UND-LIMIT-HOME", "ch.16, Home Signal", "the limit of the present direction alone ends HOME",
       "as in motions", "test_a_limit_of_its_direction_ends_home_without_setting_the_position"),
    _Q("CY545-UND-LIMIT-PROGRAM", "not mentioned", "a program goes on behind a limit",
       "there is no state of error", "test_a_program_goes_on_behind_a_limit"),
    # ---------------------------------------------------------------------------------------------------------- jog and HOME
    _Q("CY545-UND-JOG-PROGRAM", "ch.16, JOG", "JOG is not looked at while a program runs",
       "a command is in work then", "test_jog_waits_for_the_end_of_a_program"),
    _Q("CY545-UND-JOG-SETTLE", "ch.16, JOG", "looked at 100 us behind the end of a command, and as each step's period ends; option inferred.jog_test; CCW goes back 20 us before that",
       "so that it is always the same", "test_ccw_shows_the_direction_of_jog_in_each_step_and_the_programmed_one_between_and_after"),
    _Q("CY545-UND-HOME-DIRECTION", "ch.16, Home Signal", "HOME leaves the direction in which it stepped last",
       "only jog puts it back", "test_home_leaves_a_match_counter_clockwise_first_and_comes_back_clockwise"),
    _Q("CY545-UND-HOME-ENDLESS", "ch.16, Home Signal", "HOME steps on without end until the sensor, a limit or RESET ends it",
       "no other end is told", "test_with_a_sensor_that_does_not_tell_the_side_home_is_found_from_one_side_only"),
)
