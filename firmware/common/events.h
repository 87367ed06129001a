/* What the board reports by itself: a ring of the last eight events. */
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

/* Write one whose number and contents were fixed before, when its instant was. */
void write_event(uint8_t number, uint8_t kind, uint8_t which, uint8_t state_then, uint8_t inputs, int32_t position,
                 uint32_t tick);

void note(uint8_t kind, uint8_t which, uint32_t tick); /* held */

/* The same for the step interrupt, as the last thing that it does: what happened is fixed immediately, then interrupts
   are let in, for the next step may be near. */
void note_in_passing(uint8_t kind, uint8_t which, uint32_t tick);

/* Fetch an event while interrupts may write others. */
void fetch_event(uint8_t number, struct event *event);

#endif
