/* Shared state of the parts of a motion: the record being played, the last step, and the timer for the next one. */
#ifndef MOTION_H
#define MOTION_H

#include <stdint.h>

#include "due.h"

/* Shared with the step interrupt. */
extern int32_t add;       /* change of the interval with each step, in 1/65536 tick */
extern uint32_t last;     /* tick of the last step */
extern uint16_t count;    /* steps of the record; in a pause, the word with mask and value */
extern uint8_t flags;     /* of the record */
extern uint8_t stepped;   /* there is a last step from which a pace can be measured */
extern uint16_t ramp_left;      /* steps of a stop ramp from the first step of the record, if it has RAMP_LEFT */
extern int8_t ramp_slope;  /* and its change with each further step: -1, 0, 1 */

extern uint8_t paced;   /* there have been two steps */
extern uint32_t pace;   /* ticks between them, as of the end of a record */
extern uint8_t overdue; /* the end of a pause was missed */

/* All of these are called held. */
void stand(uint8_t new_state); /* no more steps */
void halt(void);               /* and discard the waiting records */
void aim(uint32_t from);       /* set the next match to `due`, starting from a recent tick */
void look_back(void);          /* check whether the next match was set too late */
void late(void);               /* handle that case */

#endif
