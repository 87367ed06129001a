/* What the parts of a motion share: the record that plays, the last step, and how the timer gets the next one. */
#ifndef MOTION_H
#define MOTION_H

#include <stdint.h>

#include "due.h"

/* Shared with the step interrupt. */
extern int32_t add;       /* the interval changes by that, in 1/65536 tick, with each step */
extern uint32_t last;     /* tick of the last step */
extern uint16_t count;    /* steps of the record; in a pause the word with mask and value */
extern uint8_t flags;     /* of the record */
extern uint8_t stepped;   /* there is a last step that a pace may count from */
extern uint16_t way;      /* steps of a stop ramp from the first step of the record, if it has WAY */
extern int8_t way_slope;  /* and how many more from each next one: -1, 0, 1 */

extern uint8_t paced;   /* there have been two steps */
extern uint32_t pace;   /* ticks between them, as of the end of a record */
extern uint8_t overdue; /* the end of a pause has passed unnoticed */

/* All of these are called held. */
void stand(uint8_t new_state); /* no more steps */
void halt(void);               /* and forget those that wait */
void aim(uint32_t from);       /* let the next match come where `due` is, seen from a tick that is not long ago */
void look_back(void);          /* has the next match been set too late? */
void late(void);               /* it has */

#endif
