/* The program memory, and what runs: the program, a homing (the program storage area; delayed execution commands).
 *
 * An instruction takes its time first and then acts, so that a pulse between two instructions exists (GSC-UND-INSTR-TIME).
 */
#ifndef PROGRAM_H
#define PROGRAM_H

#include "gsc200.h"
#include "language.h"

/* --------------------------------------------------------------------------------------------------- program memory */
void begin_program_entry(struct gsc *g);                                   /* Po, P */
bool store_instruction(struct gsc *g, const struct command_line *command); /* return whether it fits */
bool load_program(struct gsc *g, const uint8_t *program, int size);        /* return whether it is a program */
bool is_speed_missing(const struct gsc *g); /* would a motion of the program lack S, T or R (GSC-UND-DEFAULTS)? */
uint16_t homing_speed(const struct gsc *g); /* in units of 10 steps/s; 0: there is none (GSC-UND-H-NO-S) */
bool begins_with_start_stop(const struct gsc *g);

/* ------------------------------------------------------------------------------------------------------------- runs */
bool is_running(const struct gsc *g);
void run_program(struct gsc *g);                                          /* E */
void run_homing(struct gsc *g, int8_t direction, bool runs_program_after); /* H, or a stand-alone start */
void come_to_rest(struct gsc *g);                                         /* Z in a motion */

/* K: end what runs.  Return when the pulse in progress is over; end_run() follows then. */
gsc_time kill_run(struct gsc *g);
void end_run(struct gsc *g);

/* A timer of the run has come; something else of its instant may have changed what a motion waits for. */
void run_timed(struct gsc *g);
void watch_timed(struct gsc *g);
void run_settled(struct gsc *g);

/* I, also outside a program.  Return whether the RESET pulse has begun, for which whatever executes it waits. */
bool initialize_module(struct gsc *g, int32_t what);

#endif
