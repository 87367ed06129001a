/* Inputs A0..A5 and their reflexes. */
#ifndef INPUTS_H
#define INPUTS_H

#include <stdint.h>

/* What acts: bits 0..5 inputs, and two commands of the host that act as an input with that reflex does. */
#define BY_STOP 0x40
#define BY_BRAKE 0x80

extern volatile uint8_t levels; /* as of the last look */
extern uint8_t active;    /* bit n: input n is active when high */
extern uint8_t reported;  /* bit n: each edge of input n is told */
extern uint8_t reflexes[6];
extern uint8_t filter; /* looks at an input that has changed, before it counts; not of an emergency stop */

void set_up_inputs(void);
void sort_reflexes(void);                                     /* after `reflexes` or `active` have changed */
uint8_t has_estop(uint8_t inputs); /* is an emergency stop active, with these levels? */
uint8_t is_estop_active(void);
/* As enter(), and return whether `causes` take the match away that is due; then it does not come. */
uint8_t enter_to_stop(uint8_t causes, uint32_t *tick);
uint8_t takes_away(uint8_t causes);
void act_at_load(uint32_t tick, uint8_t at_start);            /* interrupts are off */
uint8_t acts_at_load(uint8_t at_start);
void command(uint8_t bit, uint32_t tick);                      /* BY_STOP or BY_BRAKE; interrupts are off */
void look(void);                                              /* called by interrupts.S */

#endif
