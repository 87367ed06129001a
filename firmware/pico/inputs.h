/* The inputs but RXD's characters: edges of HOME to UI3 wait in a queue, each with its stamp. */
#ifndef INPUTS_H
#define INPUTS_H

#include <stdbool.h>
#include <stdint.h>

struct edge {
    uint32_t stamp, pins;
};

uint32_t inputs_of(uint32_t pins); /* what the pins say, as bits of enum gsc_input, but for ENABLE */
bool inputs_are_waiting(void);
struct edge inputs_first(void); /* of those that wait */
void inputs_take(void);         /* it waits no longer */

void inputs_set_fatal(uint32_t pins); /* those of which a low level ends the homing immediately */
uint32_t inputs_fatal(void);

void inputs_interrupt(void);

#endif
