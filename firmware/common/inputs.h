/* Sampling of the inputs, and the actions of reflexes. */
#ifndef INPUTS_H
#define INPUTS_H

#include <stdint.h>

/* As hal_enter(), and return whether `causes` cancel the match that is due; then it does not happen. */
uint8_t enter_to_stop(uint8_t causes, uint32_t *tick);

void command(uint8_t cause, uint32_t tick);        /* BY_STOP or BY_BRAKE; held */
void act_at_load(uint32_t tick, uint8_t at_start); /* held */
void look(void);                                   /* sample inputs that have changed: called by a board's interrupt */

#endif
