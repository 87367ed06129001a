#include "config.h"
#include "hal.h"
#include "reflexes.h"
#include "state.h"

uint8_t brakes[2] = {BY_BRAKE, BY_BRAKE};
uint8_t marks;
uint8_t estops;
uint8_t may_stop[2] = {BY_STOP, BY_STOP};

static uint8_t stops[2] = {BY_STOP, BY_STOP}; /* without emergency stops */

void sort_reflexes(void)
{
    uint8_t i, bit;

    stops[0] = stops[1] = BY_STOP;
    brakes[0] = brakes[1] = BY_BRAKE;
    marks = estops = 0;
    for (i = 0, bit = 1; i < INPUTS; i++, bit = (uint8_t)(bit << 1)) {
        uint8_t reflex = config.reflex[i];
        uint8_t up = reflex & REFLEX_DOWNWARDS ? 0 : bit, downwards = reflex & REFLEX_UPWARDS ? 0 : bit;

        hal_serve_line();
        switch (reflex & 15) {
        case REFLEX_STOP:
            stops[0] |= up;
            stops[1] |= downwards;
            break;
        case REFLEX_BRAKE:
            brakes[0] |= up;
            brakes[1] |= downwards;
            break;
        case REFLEX_MARK:
            marks |= bit;
            break;
        case REFLEX_ESTOP:
            estops |= bit;
            break;
        }
    }
    may_stop[0] = stops[0] | estops;
    may_stop[1] = stops[1] | estops;
}

uint8_t has_estop(uint8_t inputs)
{
    return becoming_active(estops, inputs);
}

uint8_t is_estop_active(void)
{
    return has_estop(levels);
}

uint8_t reflex_of(uint8_t cause)
{
    if (cause & estops)
        return REFLEX_ESTOP;
    if (cause & marks)
        return REFLEX_MARK;
    if (cause & stops[down])
        return state == STATE_RUN || state == STATE_BRAKE ? REFLEX_STOP : REFLEX_NONE;
    return cause & brakes[down] && state == STATE_RUN ? REFLEX_BRAKE : REFLEX_NONE;
}

uint8_t acting_at_load(uint8_t at_start)
{
    uint8_t active = becoming_active(INPUTS_MASK, levels);

    return active & (stops[down] | brakes[down] | (at_start ? estops : 0));
}

uint8_t takes_away(uint8_t causes)
{
    if (causes & may_stop[down])
        return 1;
    /* A brake does not cancel a step that is due. */
    return state == STATE_RUN && causes & brakes[down] && is_in_pause();
}
