/* CLOCK, by a state machine: one step is prepared ahead, and is output exact to the cycle, whatever the processor does.
 *
 * The state machine itself samples ENABLE just before each step.  A held step follows 5 us after the
 * release, and the length of the hold is reported.
 */
#ifndef STEPS_H
#define STEPS_H

#include <stdbool.h>
#include <stdint.h>

#include "clock.h"

enum step_state {
    STEP_NONE,     /* no step is prepared */
    STEP_COMING,   /* it is prepared, and not yet due */
    STEP_HELD,     /* ENABLE is low at its instant */
    STEP_RELEASED, /* it was held, and follows at steps_at() */
    STEP_MADE      /* CLOCK has fallen; steps_take() */
};

void steps_start(void);

/* Prepare a step at an instant of the part, `soonest` or later: the first step of a motion sets the origin, and a
   later one keeps the distance from it. */
void steps_arm(uint64_t instant, cycles soonest);

/* Cancel the prepared step; return how many are output nevertheless: 0 or 1. */
unsigned steps_disarm(void);

/* Make the next step the first one of a motion. */
void steps_end_motion(void);

enum step_state steps_look(void);
cycles steps_at(void);      /* of the prepared step, or of the last one output */
uint64_t steps_released_at(void); /* STEP_RELEASED: the instant of the part at which ENABLE rose */
void steps_take(void);      /* STEP_MADE has been processed; steps_go_on() does this for STEP_RELEASED */
void steps_go_on(uint64_t instant); /* the held step follows at this instant of the part */
uint32_t steps_late(void);  /* number of words that arrived too late for their step */

bool steps_is_news(void); /* STEP_RELEASED or STEP_MADE */

void steps_interrupt(void);
void steps_stop_now(void); /* from an interrupt: no step from here on, until steps_disarm() */
bool steps_are_stopped(void);

#endif
