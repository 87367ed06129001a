#include "config.h"
#include "events.h"
#include "hal.h"
#include "motion.h"
#include "queue.h"
#include "state.h"

volatile uint8_t mode = STILL;
struct instant due;
struct instant interval;

int32_t add;
uint32_t last;
uint16_t count;
uint8_t flags;
uint8_t stepped;
uint16_t ramp_left;
int8_t ramp_slope;

uint8_t paced;
uint32_t pace;
uint8_t overdue;

void stand(uint8_t new_state)
{
    hal_stop();
    mode = STILL;
    place(position_now());
    set_state(new_state);
}

void halt(void)
{
    stand(STATE_HALT);
    forget_queue();
}

void late(void)
{
    uint32_t tick = hal_now();

    halt();
    note(EVENT_LATE, HOST, tick);
}

/* A step that the timer has passed was output, or never will be; a missed end of a pause can be handled late. */
void look_back(void)
{
    if (!hal_is_missed())
        return;
    if (mode & PAUSE)
        overdue = 1;
    else
        late();
}

void aim(uint32_t from)
{
    if (hal_aim(from))
        look_back();
}
