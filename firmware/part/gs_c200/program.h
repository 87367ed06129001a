/* What runs: the program, a homing (delayed execution commands).
 *
 * An instruction takes its time first and then acts, so that a pulse between two instructions exists (GSC-UND-INSTR-TIME).
 */
#ifndef PROGRAM_H
#define PROGRAM_H

#include "gsc200.h"

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
