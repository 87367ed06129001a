/* User outputs, ENABLE, LED, DIR, phases. */
#ifndef OUTPUTS_H
#define OUTPUTS_H

#include <stdint.h>

extern uint8_t polarity;
extern uint8_t pattern[8]; /* levels of D4..D7 by half step */
extern uint8_t phase;      /* half step of the step that is due */
extern uint8_t phases_due; /* its pattern */
extern uint8_t has_phases;

extern uint8_t fault_output; /* user outputs that show a halt, and the current of the driver; 0: none */
extern uint8_t power_output;

void set_up_outputs(void);
void configure_outputs(void);
void set_outputs(uint8_t mask, uint8_t value); /* that is, interrupts off: */
void choose_outputs(uint8_t mask, uint8_t value);
void show_outputs(void); /* interrupts may be on */
void show_direction(uint8_t is_down);
uint8_t is_enabled(void);
void refresh_lamps(void); /* for the main loop */

#endif
