/* The law of motion: how many steps, and how long each of them lasts (commands S, T, R; ramp length selection).
 *
 *     steps/s
 *       T ..............._______________
 *                      /|               |\          the interval from step i (from 0) of n to the next is 1/rate(k),
 *                    _/ |               | \_        k = min(i, n-2-i, R): backwards they read the same
 *                  _/   |               |   \_
 *       S ........|     |               |     |     rest: the start-stop interval after the last step
 *                 | up  |     slew      | down|
 *     intervals      R    n-1-2R, or 0     R
 *
 * A move that is too short for both ramps turns round half-way.  With T not above S the whole move is made at T, without
 * ramps.  The square of the rate grows evenly with the steps (GSC-UND-RAMP-LAW, GSC-UND-RAMP-COUNT, GSC-UND-T-LE-S).
 */
#ifndef PROFILE_H
#define PROFILE_H

#include "gsc200.h"

#define OPEN UINT32_MAX /* steps of a motion without end */

/* Each of these makes the plan of a motion with the S, T and R that are in force. */
void plan_move(struct gsc *g, uint32_t steps);
void plan_endless(struct gsc *g, uint32_t limit); /* steps to the end of the position counter, or OPEN */
void plan_homing(struct gsc *g, uint16_t speed);

/* The motion shall come to rest: plan what is left of it, from the step on that comes next.  Return whether that is all
   there is before the end of the position counter. */
bool plan_stop(struct gsc *g);

bool is_ramp(const struct gsc *g);            /* belongs the step that comes next to a ramp? */
uint64_t step_interval(const struct gsc *g);  /* from the step that comes next to the one after it, ps */

#endif
