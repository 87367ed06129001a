/* Records become steps. */
#ifndef STEPS_H
#define STEPS_H

#include <stdint.h>

/* All of these are called held. */
uint32_t first_due(uint32_t tick);           /* where the first match would be, if a motion began there */
void start(uint32_t tick, uint32_t present); /* let a motion begin at `tick`; the queue is not empty */
void match(void);                            /* the next match has come: called by a board's interrupt */

#endif
