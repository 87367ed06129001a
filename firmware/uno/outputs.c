#include <avr/io.h>
#include <util/atomic.h>

#include "motion.h"
#include "outputs.h"
#include "pins.h"
#include "power.h"
#include "protocol.h"

uint8_t polarity;
uint8_t fault_output;
uint8_t power_output;
uint8_t pattern[8];
uint8_t phase;
uint8_t phases_due;
uint8_t has_phases;

static volatile uint8_t outputs; /* bits 0..3 the user's, bit 4 ENABLE */

void set_up_outputs(void)
{
    /* STEP and DIR low; the others remain inputs until CONFIG: what they switch must not move when power returns. */
    DDRB = _BV(STEP_BIT) | _BV(DIR_BIT) | _BV(LED_BIT);
}

/* Return the user outputs, with the lamps among them. */
static inline uint8_t user_outputs(void)
{
    uint8_t levels = outputs & ~(fault_output | power_output);

    if (state > STATE_BRAKE)
        levels |= fault_output;
    if (outputs & ENABLE)
        levels |= power_output;
    return levels;
}

/* The pins are written one by one by sbi and cbi, for the main loop writes others of the same ports; and each with its
   level in one piece, for an interrupt may change that. */
#define SHOW(level, port, bit)                                                                                         \
    ATOMIC_BLOCK(ATOMIC_RESTORESTATE)                                                                                  \
    {                                                                                                                  \
        if (level)                                                                                                     \
            port |= _BV(bit);                                                                                          \
        else                                                                                                           \
            port &= ~_BV(bit);                                                                                         \
    }

void show_outputs(void)
{
    SHOW(user_outputs() & 1, PORTD, OUT0_BIT);
    SHOW(user_outputs() & 2, PORTD, OUT1_BIT);
    SHOW(user_outputs() & 4, PORTB, OUT2_BIT);
    SHOW(user_outputs() & 8, PORTB, OUT3_BIT);
    if (driver & DRIVER_ENABLE)
        SHOW(!(outputs & ENABLE) != !(polarity & POLARITY_ENABLE_LOW), PORTB, ENABLE_BIT);
}

void choose_outputs(uint8_t mask, uint8_t value)
{
    outputs = (outputs & ~mask) | (value & mask);
    if (!(mask & ENABLE))
        return;
    if (value & ENABLE)
        power |= POWER_ENERGISED;
    else
        power &= ~POWER_ENERGISED;
}

void set_outputs(uint8_t mask, uint8_t value)
{
    choose_outputs(mask, value);
    show_outputs();
}

uint8_t is_enabled(void)
{
    return outputs & ENABLE;
}

void refresh_lamps(void)
{
    uint8_t shown = 0;

    if (PORTD & _BV(OUT0_BIT))
        shown |= 1;
    if (PORTD & _BV(OUT1_BIT))
        shown |= 2;
    if (PORTB & _BV(OUT2_BIT))
        shown |= 4;
    if (PORTB & _BV(OUT3_BIT))
        shown |= 8;
    if (shown != (user_outputs() & USER_OUTPUTS))
        show_outputs();
}

void show_direction(uint8_t is_down)
{
    if (!is_down == !(polarity & POLARITY_UP_IS_HIGH))
        PORTB &= ~_BV(DIR_BIT);
    else
        PORTB |= _BV(DIR_BIT);
}

/* Levels first, then the pins become outputs: ENABLE must not show the wrong one even for a moment. */
void configure_outputs(void)
{
    uint8_t i;

    has_phases = 0;
    if (!(driver & DRIVER_DRY))
        for (i = 0; i < 8; i++)
            has_phases |= pattern[i];
    show_outputs();
    PORTD = (PORTD & ~PHASES_MASK) | (has_phases ? pattern[phase] : 0);
    DDRB |= _BV(OUT2_BIT) | _BV(OUT3_BIT);
    if (driver & DRIVER_ENABLE) {
        DDRB |= _BV(ENABLE_BIT);
    } else { /* no level: what the driver does is up to its resistor */
        DDRB &= ~_BV(ENABLE_BIT);
        PORTB &= ~_BV(ENABLE_BIT);
    }
    DDRD = (has_phases ? PHASES_MASK : 0) | _BV(OUT0_BIT) | _BV(OUT1_BIT);
}
