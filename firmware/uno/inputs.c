/* Inputs and their reflexes.
 *
 * A look is called by the pin change interrupt (interrupts.S), which has masked itself and lets the steps go on.  What
 * a look does, it does at one instant: levels first, then the tick, then all that follows from it.
 */
#include <avr/io.h>
#include <util/delay_basic.h>

#include "clock.h"
#include "events.h"
#include "inputs.h"
#include "motion.h"
#include "outputs.h"
#include "pins.h"
#include "power.h"
#include "protocol.h"
#include "wire.h"

volatile uint8_t levels;
uint8_t active;
uint8_t reported;
uint8_t reflexes[6];

/* Bit n: input n has this reflex; for the first two by direction, up and down. */
static uint8_t stops[2] = {BY_STOP, BY_STOP};
static uint8_t brakes[2] = {BY_BRAKE, BY_BRAKE};
static uint8_t marks;
static uint8_t estops;
static uint8_t may_stop[2] = {BY_STOP, BY_STOP}; /* all but brakes and marks, by direction */
uint8_t filter;

void set_up_inputs(void)
{
    PORTC = INPUTS_MASK; /* pull-ups: a wire that breaks reads high */
    PCMSK1 = INPUTS_MASK;
    PCICR = _BV(PCIE1);
    levels = PINC & INPUTS_MASK; /* an edge from now on is in the flag */
}

void sort_reflexes(void)
{
    uint8_t i, bit;

    stops[0] = stops[1] = BY_STOP;
    brakes[0] = brakes[1] = BY_BRAKE;
    marks = estops = 0;
    for (i = 0, bit = 1; i < 6; i++, bit <<= 1) {
        uint8_t goes_up = !(reflexes[i] & REFLEX_DOWNWARDS), goes_down = !(reflexes[i] & REFLEX_UPWARDS);

        serve_line();
        switch (reflexes[i] & 15) {
        case REFLEX_STOP:
            stops[0] |= goes_up ? bit : 0;
            stops[1] |= goes_down ? bit : 0;
            break;
        case REFLEX_BRAKE:
            brakes[0] |= goes_up ? bit : 0;
            brakes[1] |= goes_down ? bit : 0;
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

/* Return the inputs that are active, as of the last look. */
static inline uint8_t active_now(void)
{
    return ~(levels ^ active) & INPUTS_MASK;
}

uint8_t has_estop(uint8_t inputs)
{
    return ~(inputs ^ active) & estops;
}

uint8_t is_estop_active(void)
{
    return has_estop(levels);
}

/* Is the match that is due not to come, if `causes` act now?  Interrupts are off. */
uint8_t takes_away(uint8_t causes)
{
    if (causes & (stops[down] | estops))
        return 1;
    /* Brakes make a step that is due. */
    return state == STATE_RUN && causes & brakes[down] && is_in_pause();
}

uint8_t enter_to_stop(uint8_t causes, uint32_t *tick)
{
    for (;;) {
        *tick = enter();
        /* The quick answer first: steps wait meanwhile. */
        if (!(causes & may_stop[down]) && !is_in_pause())
            return 0;
        if (!takes_away(causes)) {
            show_in_time();
            return 0;
        }
        /* A match may come until the next line has been run; then STEP is high and the step counts. */
        TCCR1A = DISARMED;
        __asm__ volatile("nop\n\tnop"); /* what PINB shows is a cycle and a half old */
        if (!is_made()) {
            TIFR1 = _BV(OCF1A);
            return 1;
        }
        sei(); /* the interrupt is pending: it counts the step and arms the next */
        __asm__ volatile("nop");
    }
}

/* Do what the input (or command) `bit` does when it becomes active; return 0 if that is nothing. */
static uint8_t act(uint8_t bit, uint8_t which, uint32_t tick)
{
    if (bit & estops) {
        cut_power(state == STATE_RUN || state == STATE_BRAKE);
        halt();
        note(EVENT_ESTOP, which, tick);
        return 1;
    }
    if (bit & marks) {
        note(EVENT_MARK, which, tick);
        return 1;
    }
    if (bit & stops[down]) {
        if (state != STATE_RUN && state != STATE_BRAKE)
            return 0;
        halt();
        note(EVENT_STOPPED, which, tick);
        return 1;
    }
    if (bit & brakes[down]) {
        if (state != STATE_RUN)
            return 0;
        brake(EVENT_BRAKED, which, tick);
        return 1;
    }
    return 0;
}

void command(uint8_t bit, uint32_t tick)
{
    act(bit, HOST, tick);
}

/* What an input that is active does to a record that has been loaded. */
static uint8_t acting_at_load(uint8_t at_start)
{
    return active_now() & (stops[down] | brakes[down] | (at_start ? estops : 0));
}

uint8_t acts_at_load(uint8_t at_start)
{
    return acting_at_load(at_start);
}

void act_at_load(uint32_t tick, uint8_t at_start)
{
    uint8_t causes = acting_at_load(at_start);
    uint8_t i, bit;

    for (i = 0, bit = 1; i < 6; i++, bit <<= 1)
        if (causes & bit) {
            serve_line();
            act(bit, i, tick);
        }
}

/* Do what follows from `changed` inputs, in ascending order, where no step waits: behind what stops the motor. */
static void act_in_peace(uint8_t changed, uint8_t becoming, uint32_t tick)
{
    uint8_t i, bit;

    for (i = 0, bit = 1; i < 6; i++, bit <<= 1) {
        if (!(changed & bit))
            continue;
        serve_line();
        levels ^= bit;
        if (becoming & bit) {
            if (act(bit, i, tick))
                continue;
        }
        if (bit & reported)
            note(EVENT_INPUT, i, tick);
    }
}

static uint8_t bits_of(uint8_t set)
{
    uint8_t count = 0;

    for (; set; set &= set - 1)
        count++;
    return count;
}

#define LOOK_APART 16 /* turns of 4 cycles between two looks of the filter */

/* Return the inputs.  An emergency stop that has changed counts immediately, and before the others.  An input that
   changes again within as many looks as the filter has keeps its former level; its edge calls another look. */
static uint8_t steady(void)
{
    uint8_t seen = PINC & INPUTS_MASK, doubtful = 0, n;

    if (!filter)
        return seen;
    for (n = filter; n && !((seen ^ levels) & estops) && seen != levels; n--) {
        uint8_t is;

        _delay_loop_2(LOOK_APART);
        is = PINC & INPUTS_MASK;
        doubtful |= (is ^ seen) & ~estops;
        seen = (seen & ~estops) | (is & estops);
    }
    if ((seen ^ levels) & estops)
        return (levels & ~estops) | (seen & estops);
    return (seen & ~doubtful) | (levels & doubtful);
}

/* Steps go on while inputs do no more than to be told, or to begin a brake, which the first of several does.  Then
   interrupts are off for as long only as it takes to fix what the events say; they are written behind that. */
static void act_on(uint8_t seen)
{
    uint8_t inputs = levels, changed = seen ^ inputs;
    uint8_t becoming = changed & ~(seen ^ active), marking = becoming & marks, told = (changed & reported) | marking;
    uint8_t many = bits_of(told), braking = 0, number, state_then, i, bit;
    int32_t position;
    uint32_t tick;

    if (enter_to_stop(becoming, &tick)) {
        act_in_peace(changed, becoming, tick);
        leave();
        return;
    }
    state_then = state;
    if (becoming & brakes[down] && begins_brake()) {
        braking = becoming & brakes[down];
        braking &= -braking;
        if (!(told & braking))
            many++;
    }
    levels = seen;
    number = next_event;
    next_event = number + many;
    position = position_now();
    leave();
    for (i = 0, bit = 1; i < 6; i++, bit <<= 1) {
        uint8_t kind = marking & bit ? EVENT_MARK : EVENT_INPUT;

        inputs ^= changed & bit;
        if (bit == braking) {
            state_then = STATE_BRAKE;
            kind = EVENT_BRAKED;
        } else if (!(told & bit)) {
            continue;
        }
        write_event(number++, kind, i, state_then, inputs, position, tick);
    }
}

void look(void)
{
    uint8_t seen;

    while ((seen = steady()) != levels)
        act_on(seen);
}
