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
