/* User outputs, including lamps, ENABLE, DIR and phases. */
#ifndef OUTPUTS_H
#define OUTPUTS_H

#include <stdint.h>

extern volatile uint8_t power; /* flags of ANSWER, except POWER_ESTOP */

extern uint8_t pattern[8]; /* levels of the phases by half step, in the format of hal_set_phases() */
extern uint8_t phase;      /* half step of the step that is due */
extern uint8_t phase_step; /* half steps per step, modulo 8 */
extern uint8_t phases_due; /* pattern of the step that is due */
extern uint8_t has_phases;

void configure_outputs(void);                      /* after CONFIG */
void choose_outputs(uint8_t mask, uint8_t value);  /* held; call show_outputs() afterwards */
void show_outputs(void);
void set_outputs(uint8_t mask, uint8_t value); /* both, held */
uint8_t is_enabled(void);
void show_direction(void);
void set_phase_step(uint8_t flags); /* of the record */
void refresh_lamps(void);           /* for the main loop */

#endif
