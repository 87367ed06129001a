#include "events.h"
#include "hal.h"
#include "outputs.h"
#include "state.h"

static struct event events[EVENTS_KEPT];
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
    hal_serve_line(); /* this takes long */
}

void note_in_passing(uint8_t kind, uint8_t which, uint32_t tick)
{
    int32_t position = position_now();
    uint8_t number = next_event++, inputs = levels, state_then = state;

    hal_show_in_time(phases_due);
    hal_leave();
    write_event(number, kind, which, state_then, inputs, position, tick);
}

void fetch_event(uint8_t number, struct event *event)
{
    *event = events[number % EVENTS_KEPT];
    __asm__ volatile("" : : : "memory"); /* written completely, before any other variable is read */
}
