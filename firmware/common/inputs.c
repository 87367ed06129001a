/* Sampling of the inputs, and the actions of reflexes.
 *
 * An interrupt that masks itself and lets steps continue samples the inputs.  All its actions take effect at one
 * instant: first the levels, then the tick, then the consequences.
 */
#include "inputs.h"
#include "config.h"
#include "events.h"
#include "hal.h"
#include "motion.h"
#include "outputs.h"
#include "power.h"
#include "reflexes.h"
#include "state.h"
#include "stop_ramp.h"

uint8_t enter_to_stop(uint8_t causes, uint32_t *tick)
{
    for (;;) {
        *tick = hal_enter();
        /* The quick decisions first, because steps wait meanwhile. */
        if (!(causes & may_stop[down])) {
            if (!is_in_pause())
                return 0;
            if (!takes_away(causes)) {
                hal_show_in_time(phases_due);
                return 0;
            }
        }
        if (!hal_disarm())
            return 1;
        hal_leave(); /* its interrupt counts the step and arms the next */
    }
}

/* Perform the action of `cause` becoming active; return 0 if it has none. */
static uint8_t act(uint8_t cause, uint8_t which, uint32_t tick)
{
    switch (reflex_of(cause)) {
    case REFLEX_ESTOP:
        cut_power(state == STATE_RUN || state == STATE_BRAKE);
        halt();
        note(EVENT_ESTOP, which, tick);
        return 1;
    case REFLEX_MARK:
        note(EVENT_MARK, which, tick);
        return 1;
    case REFLEX_STOP:
        halt();
        note(EVENT_STOPPED, which, tick);
        return 1;
    case REFLEX_BRAKE:
        brake(EVENT_BRAKED, which, tick);
        return 1;
    }
    return 0;
}

void command(uint8_t cause, uint32_t tick)
{
    act(cause, HOST, tick);
}

void act_at_load(uint32_t tick, uint8_t at_start)
{
    uint8_t causes = acting_at_load(at_start), i, bit;

    for (i = 0, bit = 1; i < INPUTS; i++, bit = (uint8_t)(bit << 1))
        if (causes & bit) {
            hal_serve_line();
            act(bit, i, tick);
        }
}

/* Process `changed` inputs, in ascending order, when no step waits: after the inputs that stop the motor. */
static void act_uninterrupted(uint8_t changed, uint8_t becoming, uint32_t tick)
{
    uint8_t i, bit;

    for (i = 0, bit = 1; i < INPUTS; i++, bit = (uint8_t)(bit << 1)) {
        if (!(changed & bit))
            continue;
        hal_serve_line();
        levels ^= bit;
        if (becoming & bit && act(bit, i, tick))
            continue;
        if (bit & config.report)
            note(EVENT_INPUT, i, tick);
    }
}

static uint8_t bits_of(uint8_t set)
{
    uint8_t number = 0;

    for (; set; set &= (uint8_t)(set - 1))
        number++;
    return number;
}

/* Return the inputs.  A changed emergency stop takes effect immediately, and before the others.  An input that
   changes again within the samples of the filter keeps its former level; its edge triggers another sample. */
static __attribute__((noinline)) uint8_t steady(void)
{
    uint8_t seen = hal_levels(), doubtful = 0, n;

    for (n = config.filter; n && !((seen ^ levels) & estops) && seen != levels; n--) {
        uint8_t now;

        hal_wait_between_looks();
        now = hal_levels();
        doubtful |= (uint8_t)((now ^ seen) & ~estops);
        seen ^= (now ^ seen) & estops;
    }
    if ((seen ^ levels) & estops)
        return levels ^ ((seen ^ levels) & estops);
    return (uint8_t)((seen & ~doubtful) | (levels & doubtful));
}

/* Inputs that stop the motor: with fast steps there is no time for more before the next one. */
static __attribute__((noinline)) void stop_by(uint8_t changed, uint8_t becoming)
{
    uint32_t tick;

    if (enter_to_stop(becoming, &tick))
        act_uninterrupted(changed, becoming, tick);
    hal_leave();
}

/* Steps continue while inputs only cause events or begin a brake, which the first of several does.  Then interrupts are
   off only while the content of the events is fixed; they are written after that. */
static __attribute__((noinline)) void act_on(uint8_t seen, uint8_t changed, uint8_t becoming)
{
    uint8_t inputs = levels, marking = becoming & marks, noted = (changed & config.report) | marking;
    uint8_t many = bits_of(noted), braking = 0, number, state_then, i, bit;
    int32_t position;
    uint32_t tick;

    if (enter_to_stop(becoming, &tick)) {
        act_uninterrupted(changed, becoming, tick);
        hal_leave();
        return;
    }
    state_then = state;
    braking = becoming & brakes[down];
    if (braking && begins_brake()) {
        braking &= (uint8_t)-braking;
        if (!(noted & braking))
            many++;
    } else {
        braking = 0;
    }
    levels = seen;
    number = next_event;
    next_event = (uint8_t)(number + many);
    position = position_now();
    hal_leave();
    for (i = 0, bit = 1; i < INPUTS; i++, bit = (uint8_t)(bit << 1)) {
        uint8_t kind = marking & bit ? EVENT_MARK : EVENT_INPUT;

        inputs ^= changed & bit;
        if (bit == braking) {
            state_then = STATE_BRAKE;
            kind = EVENT_BRAKED;
        } else if (!(noted & bit)) {
            continue;
        }
        write_event(number++, kind, i, state_then, inputs, position, tick);
    }
}

void look(void)
{
    for (;;) {
        uint8_t seen = config.filter ? steady() : hal_levels(), changed = seen ^ levels, becoming;

        if (!changed)
            return;
        becoming = becoming_active(changed, seen);
        if (becoming & may_stop[down])
            stop_by(changed, becoming);
        else
            act_on(seen, changed, becoming);
    }
}
