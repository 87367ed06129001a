#include <avr/interrupt.h>

#include "events.h"
#include "inputs.h"
#include "protocol.h"
#include "motion.h"
#include "wire.h"

struct event events[EVENTS_KEPT];
volatile uint8_t next_event;

void note(uint8_t kind, uint8_t which, uint32_t tick)
{
    struct event *event = &events[next_event % EVENTS_KEPT];

    next_event++;
    event->kind = kind;
    event->which = which;
    event->state = state;
    event->inputs = levels;
    event->position = position_now();
    event->tick = tick;
    serve_line(); /* whoever has something to note is taking his time */
}

void note_in_passing(uint8_t kind, uint8_t which, uint32_t tick)
{
    struct event *event = &events[next_event % EVENTS_KEPT];
    int32_t position = position_now();
    uint8_t inputs = levels, state_then = state;

    next_event++;
    sei();
    event->kind = kind;
    event->which = which;
    event->state = state_then;
    event->inputs = inputs;
    event->position = position;
    event->tick = tick;
}
