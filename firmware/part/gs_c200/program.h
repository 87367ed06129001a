/* Execution of the program or a homing (delayed execution commands).
 *
 * An instruction takes its time before its effect, so there is a pulse between two instructions (GSC-UND-INSTR-TIME).
 */
#ifndef PROGRAM_H
#define PROGRAM_H

#include "gsc200.h"

bool is_running(const struct gsc *g);
void run_program(struct gsc *g);                                          /* E */
void run_homing(struct gsc *g, int8_t direction, bool runs_program_after); /* H, or a stand-alone start */
void come_to_rest(struct gsc *g);                                         /* Z in a motion */

/* K: end the run.  Return the end of the pulse in progress, at which end_run() follows. */
gsc_time kill_run(struct gsc *g);
void end_run(struct gsc *g);

/* Process a timer of the run; another event of the same instant may have changed an input for which a motion waits. */
void run_timed(struct gsc *g);
void watch_timed(struct gsc *g);
void run_settled(struct gsc *g);

/* I, also outside a program.  Return whether the RESET pulse has begun, for which the caller waits. */
bool initialize_module(struct gsc *g, int32_t what);

#endif
