/* Records become steps. */
#ifndef STEPS_H
#define STEPS_H

#include <stdint.h>

/* All of these are called held. */
uint32_t first_due(uint32_t tick);           /* return the tick of the first match of a motion that begins at `tick` */
void start(uint32_t tick, uint32_t present); /* begin a motion at `tick`; the queue is not empty */
void match(void);                            /* process a match: called by a board's interrupt */

#endif
