/* The driver's current.
 *
 *     off -> on    OUTPUTS, in IDLE, with every emergency stop closed, if the driver is known, the run not dry, and the
 *                  host has permitted it with RESET since power-up, and since the board last switched it off itself
 *     on -> off    OUTPUTS at rest; an emergency stop, in any state; after a halt, at rest or without a host, after
 *                  the time in CONFIG
 *
 * In motion only an emergency stop switches the current off, because the motor would coast and the count be wrong.
 */
#include "outputs.h"
#include "power.h"
#include "reflexes.h"
#include "state.h"

/* POWER_ENERGISED is set by outputs.c.  POWER_UNSURE: the motor position may differ from the count.  POWER_LOCKED:
   the host has not permitted current since power-up, or since the board switched it off. */
volatile uint8_t power = POWER_LOCKED;

uint8_t may_switch(uint8_t mask, uint8_t value)
{
    uint8_t turns_on = value & ENABLE;

    if (!(mask & ENABLE) || !turns_on == !is_enabled())
        return 1;
    if (!turns_on)
        return state == STATE_IDLE || state == STATE_HALT;
    return state == STATE_IDLE && config.driver == DRIVER_ENABLE && !(power & POWER_LOCKED) && !is_estop_active();
}

void unlock(uint8_t reset_flags)
{
    if (reset_flags & (RESET_KNOWN | RESET_POWER))
        power &= (uint8_t)~POWER_LOCKED;
    if (reset_flags & RESET_KNOWN)
        power &= (uint8_t)~POWER_UNSURE;
}

void begin_motion(void)
{
    if (!is_enabled())
        power |= POWER_UNSURE;
}

static void lock(void)
{
    if (is_enabled())
        power |= POWER_LOCKED | POWER_UNSURE;
    set_outputs(ENABLE, 0);
}

void cut_power(uint8_t in_motion)
{
    if (in_motion)
        power |= POWER_UNSURE;
    lock();
}

/* Current for the new driver has not been requested yet.  An active emergency stop takes effect immediately. */
void power_configured(uint8_t is_other_driver)
{
    if (is_other_driver)
        set_outputs(ENABLE, 0);
    if (is_estop_active())
        lock();
}

uint16_t looked_at;

void watch_power(uint32_t tick, uint8_t state_then, uint8_t is_host_silent)
{
    static uint16_t resting;
    uint8_t is_abandoned = state_then == STATE_HALT || (state_then == STATE_IDLE && is_host_silent);
    uint16_t passed = (uint16_t)((uint16_t)(tick >> 16) - looked_at);

    looked_at = (uint16_t)(tick >> 16);
    if (!is_enabled() || config.enable_off == OFF_NEVER ||
        !(is_abandoned || (state_then == STATE_IDLE && config.enable_off == OFF_REST))) {
        resting = 0;
        return;
    }
    resting = passed > 0xFFFF - resting ? 0xFFFF : (uint16_t)(resting + passed);
    if (resting < config.enable_hold)
        return;
    if (is_abandoned)
        lock();
    else
        set_outputs(ENABLE, 0);
}
