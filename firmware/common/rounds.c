#include "rounds.h"
#include "answers.h"
#include "commands.h"
#include "events.h"
#include "hal.h"
#include "inputs.h"
#include "line.h"
#include "motion.h"
#include "outputs.h"
#include "power.h"
#include "reflexes.h"
#include "state.h"
#include "stop_ramp.h"

static uint8_t is_silent; /* at the last check */

void power_up(void)
{
    levels = hal_levels();
    set_state(STATE_BOOT);
    note(EVENT_BOOT, HOST, hal_now());
}

void watch(void)
{
    uint32_t tick = hal_enter();
    uint8_t state_then = state;

    if (state_then == STATE_RUN || state_then == STATE_BRAKE)
        hal_leave(); /* steps may be fast */
    is_silent = is_host_silent(tick);
    watch_power(tick, state_then, is_silent);
    hal_leave();
}

void brake_if_silent(void)
{
    uint32_t tick;

    if (!is_silent || state != STATE_RUN)
        return;
    enter_to_stop(BY_BRAKE, &tick);
    if (begins_brake())
        note_in_passing(EVENT_WATCHDOG, HOST, tick);
    else if (state == STATE_RUN)
        brake(EVENT_WATCHDOG, HOST, tick);
    hal_leave();
}

void round_once(void)
{
    int8_t verdict = listen();

    if (verdict > 0)
        take_frame();
    else if (verdict < 0)
        take_damage();
    send_events();
    refresh_hint();
    watch();
    brake_if_silent();
    refresh_lamps();
}
