/* What inputs, and commands that act like one, do to a motion: decisions, which inputs.c carries out. */
#ifndef REFLEXES_H
#define REFLEXES_H

#include <stdint.h>

#include "config.h"

/* What acts: bits 0..5 inputs, and two commands of the host that act as an input with that reflex does. */
#define BY_STOP 0x40
#define BY_BRAKE 0x80

void sort_reflexes(void);          /* after CONFIG */
uint8_t has_estop(uint8_t inputs); /* is an emergency stop active, with these levels? */
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
extern uint8_t may_stop[2]; /* all that takes away a step that is due */

/* Return what `cause`, a single bit, does when it becomes active now: REFLEX_ESTOP, _MARK, _STOP, _BRAKE, or _NONE. */
uint8_t reflex_of(uint8_t cause);

/* Return the inputs that act on a record that has been loaded: those that are active already. */
uint8_t acting_at_load(uint8_t at_start);

/* Is the match that is due not to come, if `causes` act now?  Held. */
uint8_t takes_away(uint8_t causes);

#endif
