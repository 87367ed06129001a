/* The driver's current.
 *
 *     off -> on    OUTPUTS, in IDLE, with every emergency stop closed, if a driver is known, the run is not dry, and the
 *                  board has been allowed to by RESET since power-up, and since it last switched it off by itself
 *     on -> off    OUTPUTS at rest; an emergency stop, in any state; after a halt, at rest or without a host as CONFIG
 *                  says, after a time
 *
 * In motion nobody but an emergency stop takes the current away, for the motor would coast and the count be wrong.
 */
#include "outputs.h"
#include "power.h"
#include "reflexes.h"
#include "state.h"

/* POWER_ENERGISED is what outputs.c says.  POWER_UNSURE: the motor may be elsewhere than the count says.  POWER_LOCKED:
   nobody has allowed current since power-up, or since the board took it away. */
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

/* Nobody has asked for another driver's current yet.  An active emergency stop counts immediately. */
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
