/* The law of motion: the number of steps, and the length of each (commands S, T, R; ramp length selection).
 *
 *     steps/s
 *       T ..............._______________
 *                      /|               |\          the interval from step i (from 0) of n to the next is 1/rate(k),
 *                    _/ |               | \_        k = min(i, n-2-i, R): symmetrical
 *                  _/   |               |   \_
 *       S ........|     |               |     |     rest: the start-stop interval after the last step
 *                 | up  |     slew      | down|
 *     intervals      R    n-1-2R, or 0     R
 *
 * A move too short for both ramps decelerates from half-way.  With T not above S the whole move is made at T, without
 * ramps.  The square of the rate grows linearly with the steps (GSC-UND-RAMP-LAW, GSC-UND-RAMP-COUNT, GSC-UND-T-LE-S).
 */
#ifndef PROFILE_H
#define PROFILE_H

#include "gsc200.h"

#define OPEN UINT32_MAX /* steps of an endless motion */

/* Each of these plans a motion with the present S, T and R. */
void plan_move(struct gsc *g, uint32_t steps);
void plan_endless(struct gsc *g, uint32_t limit); /* steps to the end of the position counter, or OPEN */
void plan_homing(struct gsc *g, uint16_t speed);

/* Stop the motion: plan its remaining steps, from the next one on.  Return whether it can stop
   before the end of the position counter. */
bool plan_stop(struct gsc *g);

bool is_ramp(const struct gsc *g);            /* whether the next step belongs to a ramp */
uint64_t step_interval(const struct gsc *g);  /* from the next step to the one after it, ps */

#endif
