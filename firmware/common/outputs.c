#include "config.h"
#include "hal.h"
#include "outputs.h"
#include "state.h"

uint8_t pattern[8];
uint8_t phase;
uint8_t phase_step;
uint8_t phases_due;
uint8_t has_phases;

static volatile uint8_t outputs; /* bits 0..3 the user's, bit 4 ENABLE */

static uint8_t fault_lamp, power_lamp;   /* bits of outputs; 0: none */

static inline uint8_t user_outputs(void)
{
    uint8_t shown = outputs & (uint8_t)~(fault_lamp | power_lamp);

    if (state > STATE_BRAKE)
        shown |= fault_lamp;
    if (outputs & ENABLE)
        shown |= power_lamp;
    return shown & USER_OUTPUTS;
}

/* Write each pin and its level without interruption, because an interrupt may change the level. */
static inline void show_output(uint8_t number)
{
    uint8_t before = hal_hold();

    hal_set_output(number, user_outputs() >> number & 1);
    hal_restore(before);
}

void show_outputs(void)
{
    uint8_t before;

    show_output(0);
    show_output(1);
    show_output(2);
    show_output(3);
    if (!(config.driver & DRIVER_ENABLE))
        return;
    before = hal_hold();
    hal_set_enable(!(outputs & ENABLE) != !(config.polarity & POLARITY_ENABLE_LOW));
    hal_restore(before);
}

void choose_outputs(uint8_t mask, uint8_t value)
{
    outputs = (uint8_t)((outputs & ~mask) | (value & mask));
    if (!(mask & ENABLE))
        return;
    if (value & ENABLE)
        power |= POWER_ENERGISED;
    else
        power &= (uint8_t)~POWER_ENERGISED;
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
    if (hal_outputs() != user_outputs())
        show_outputs();
}

void show_direction(void)
{
    hal_set_direction(!down != !(config.polarity & POLARITY_UP_IS_HIGH));
}

/* Phases after the step that is due; until then they are unchanged. */
void set_phase_step(uint8_t flags)
{
    uint8_t before = (uint8_t)(phase - phase_step), step = flags & RECORD_HALF ? 1 : 2;

    phase_step = down ? (uint8_t)(8 - step) : step;
    phase = (uint8_t)((before + phase_step) & 7);
    phases_due = pattern[phase];
}

/* Return the bit of an output by its number + 1; 0: none. */
static uint8_t bit_of(uint8_t number)
{
    return (uint8_t)(number ? 1 << (number - 1) : 0);
}

/* Set the levels before the pins become outputs: ENABLE must not have the wrong level even for a moment. */
void configure_outputs(void)
{
    uint8_t i;

    fault_lamp = bit_of(config.lamps & 15);
    power_lamp = bit_of(config.lamps >> 4);
    has_phases = 0;
    for (i = 0; i < 8; i++)
        has_phases |= pattern[i] = is_dry() ? 0 : HAL_PHASES(config.pattern[i]);
    phase = config.phase; /* unchanged */
    phase_step = 0;
    hal_serve_line();
    show_outputs();
    hal_set_phases(pattern[phase]);
    hal_drive(has_phases, config.driver & DRIVER_ENABLE);
}
