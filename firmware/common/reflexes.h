/* Effects of inputs, and of commands that act like one, on a motion: the decisions, which inputs.c executes. */
#ifndef REFLEXES_H
#define REFLEXES_H

#include <stdint.h>

#include "config.h"

/* Causes: bits 0..5 are inputs, the others two host commands that act like an input with that reflex. */
#define BY_STOP 0x40
#define BY_BRAKE 0x80

void sort_reflexes(void);          /* after CONFIG */
uint8_t has_estop(uint8_t inputs); /* whether an emergency stop is active at these levels */
uint8_t is_estop_active(void);

/* Return the inputs among `changed` that are active with the levels `seen`. */
static inline uint8_t becoming_active(uint8_t changed, uint8_t seen)
{
    return changed & (uint8_t)~(seen ^ config.active);
}

/* Bit n: input n has this reflex; for some by direction, up and down. */
extern uint8_t brakes[2];
extern uint8_t marks;
extern uint8_t estops;
extern uint8_t may_stop[2]; /* causes that cancel a step that is due */

/* Return the reflex of `cause`, a single bit, becoming active now: REFLEX_ESTOP, _MARK, _STOP, _BRAKE, or _NONE. */
uint8_t reflex_of(uint8_t cause);

/* Return the inputs that act on a loaded record: the inputs that are already active. */
uint8_t acting_at_load(uint8_t at_start);

/* Return whether `causes`, if they act now, cancel the match that is due.  Held. */
uint8_t takes_away(uint8_t causes);

#endif
