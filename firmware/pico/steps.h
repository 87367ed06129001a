/* CLOCK, by a state machine: one step is prepared ahead, and is made to the cycle whatever the processor does.
 *
 * ENABLE is looked at by the state machine itself, just before each step.  A step that it holds comes 5 us after the
 * release, and the length of the hold is reported.
 */
#ifndef STEPS_H
#define STEPS_H

#include <stdbool.h>
#include <stdint.h>

#include "clock.h"

enum step_state {
    STEP_NONE,     /* none is prepared */
    STEP_COMING,   /* it is prepared, and its instant has not come */
    STEP_HELD,     /* ENABLE is low at its instant */
    STEP_RELEASED, /* it was held, and comes at steps_at() */
    STEP_MADE      /* CLOCK has fallen; steps_take() */
};

void steps_start(void);

/* Prepare a step at an instant of the part, `soonest` or later: the first one of a motion makes that its origin, and a
   later one keeps the distance from it. */
void steps_arm(uint64_t instant, cycles soonest);

/* Take back the step that is prepared; return how many are made nevertheless: 0 or 1. */
unsigned steps_disarm(void);

/* The next step is the first one of a motion. */
void steps_end_motion(void);

enum step_state steps_look(void);
cycles steps_at(void);      /* of the step that is prepared, or was made last */
uint64_t steps_released_at(void); /* STEP_RELEASED: the instant of the part at which ENABLE has risen */
void steps_take(void);      /* STEP_MADE has been dealt with; so has STEP_RELEASED, by steps_go_on() */
void steps_go_on(uint64_t instant); /* the held step comes at this instant of the part */
uint32_t steps_late(void);  /* how often a word came too late for its step */

bool steps_is_news(void); /* STEP_RELEASED or STEP_MADE */

void steps_interrupt(void);
void steps_stop_now(void); /* from an interrupt: no step from here on, until steps_disarm() */
bool steps_are_stopped(void);

#endif
