/* The inputs, except the characters on RXD: edges of HOME to UI3 are queued, each with its time stamp. */
#ifndef INPUTS_H
#define INPUTS_H

#include <stdbool.h>
#include <stdint.h>

struct edge {
    uint32_t stamp, pins;
};

uint32_t inputs_of(uint32_t pins); /* levels as bits of enum gsc_input, without ENABLE */
bool inputs_are_waiting(void);
struct edge inputs_first(void); /* the oldest in the queue */
void inputs_take(void);         /* removes it */

void inputs_set_fatal(uint32_t pins); /* a low level of one of them ends the homing immediately */
uint32_t inputs_fatal(void);

void inputs_interrupt(void);

#endif
