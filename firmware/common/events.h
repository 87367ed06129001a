/* Events that the board reports: a ring of the last eight. */
#ifndef EVENTS_H
#define EVENTS_H

#include <stdint.h>

#define EVENTS_KEPT 8

struct event {
    uint8_t kind;
    uint8_t which;
    uint8_t state;
    uint8_t inputs;
    int32_t position;
    uint32_t tick;
};

extern volatile uint8_t next_event; /* its number */

/* Write an event whose number and content were fixed at its instant. */
void write_event(uint8_t number, uint8_t kind, uint8_t which, uint8_t state_then, uint8_t inputs, int32_t position,
                 uint32_t tick);

void note(uint8_t kind, uint8_t which, uint32_t tick); /* held */

/* The same for the step interrupt, as its last action: the content is fixed immediately, then interrupts
   are enabled, because the next step may be near. */
void note_in_passing(uint8_t kind, uint8_t which, uint32_t tick);

/* Fetch an event while interrupts may write others. */
void fetch_event(uint8_t number, struct event *event);

#endif
