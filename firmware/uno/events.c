#include <avr/interrupt.h>

#include "events.h"
#include "inputs.h"
#include "protocol.h"
#include "motion.h"
#include "wire.h"

struct event events[EVENTS_KEPT];
volatile uint8_t next_event;

void write_event(uint8_t number, uint8_t kind, uint8_t which, uint8_t state_then, uint8_t inputs, int32_t position,
                 uint32_t tick)
{
    struct event *event = &events[number % EVENTS_KEPT];

    event->kind = kind;
    event->which = which;
    event->state = state_then;
    event->inputs = inputs;
    event->position = position;
    event->tick = tick;
}

void note(uint8_t kind, uint8_t which, uint32_t tick)
{
    write_event(next_event++, kind, which, state, levels, position_now(), tick);
    serve_line(); /* whoever has something to note is taking his time */
}

void note_in_passing(uint8_t kind, uint8_t which, uint32_t tick)
{
    int32_t position = position_now();
    uint8_t number = next_event++, inputs = levels, state_then = state;

    show_in_time();
    sei();
    write_event(number, kind, which, state_then, inputs, position, tick);
}
