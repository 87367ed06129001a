#include "inputs.h"

#include "clock.h"
#include "gsc200.h"
#include "pins.h"
#include "registers.h"
#include "steps.h"

#define EDGES_WAITING 8

static struct edge edges[EDGES_WAITING];
static volatile uint8_t came, taken;
static volatile uint32_t fatal;

uint32_t inputs_of(uint32_t pins)
{
    return ((pins ^ GSC_RXD) & OF_THE_PART) & ~(uint32_t)GSC_ENABLE;
}

bool inputs_are_waiting(void)
{
    return taken != came;
}

struct edge inputs_first(void)
{
    return edges[taken % EDGES_WAITING];
}

void inputs_take(void)
{
    taken++;
}

void inputs_set_fatal(uint32_t pins)
{
    fatal = pins;
}

uint32_t inputs_fatal(void)
{
    return fatal;
}

/* If the queue is full, its last edge gets the newest levels. */
void inputs_interrupt(void)
{
    const uint32_t stamp = clock_stamp(), pins = SIO_IN;
    GPIO_INTR(PIN_HOME) = 0xFFFFFFFFu;
    if (~pins & fatal)
        steps_stop_now();
    const uint8_t place = (uint8_t)(came - taken) < EDGES_WAITING ? came++ : (uint8_t)(came - 1);
    edges[place % EDGES_WAITING] = (struct edge){stamp, pins};
}
