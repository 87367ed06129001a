#include "motion.h"

#include "pins.h"
#include "profile.h"
#include "sheet.h"

enum phase {
    AT_REST,
    SETTING_UP,    /* DIR has its level, the first step follows */
    STEPPING,      /* the next step follows */
    HELD,          /* by ENABLE */
    RELEASED,      /* the held step follows */
    LAST_PULSE,    /* the last step has begun */
    LAST_INTERVAL  /* and its pulse has ended */
};
enum homing { NO_HOMING, TO_EOT, TO_HOME };

/* ---------------------------------------------------------------------------------------------- the position counter */
uint32_t room_ahead(const struct gsc *g, int8_t direction)
{
    if (g->part == GSC_C200S)
        return OPEN;
    return (uint32_t)(direction > 0 ? C200_MOST - g->position : g->position);
}

/* Beyond its limits the counter of a GS-C200S wraps; that of a GS-C200 has room for the step.  A homing is not counted
   (GSC-UND-H-COUNTER). */
static void count_step(struct gsc *g)
{
    if (g->motion.homing)
        return;
    g->position += g->motion.direction;
    if (g->part == GSC_C200S && g->position > C200S_MOST)
        g->position = C200S_LEAST;
    else if (g->part == GSC_C200S && g->position < C200S_LEAST)
        g->position = C200S_MOST;
}

/* --------------------------------------------------------------------------------------------------- start and end */
static void set_out(struct gsc *g)
{
    set_pin(g, GSC_DIR, g->motion.direction > 0);
    set_pin(g, GSC_MOV, true);
    set_pin(g, GSC_RAMP, is_ramp(g));
    g->motion.phase = SETTING_UP;
    start_timer(g, GSC_RUN_TIMER, DIR_SETUP_PS);
}

static void begin(struct gsc *g, int8_t direction, enum homing homing)
{
    g->motion.is_moving = true;
    g->motion.is_stop = g->motion.is_stopping = g->motion.is_stopped = false;
    g->motion.direction = direction;
    g->motion.homing = homing;
}

void begin_motion(struct gsc *g, int8_t direction, bool is_endless)
{
    begin(g, direction, NO_HOMING);
    g->motion.is_endless = is_endless;
    set_out(g);
}

/* MOV and RAMP fall as the last pulse ends (GSC-UND-LAST-PULSE). */
static void let_fall(struct gsc *g)
{
    g->motion.is_moving = false;
    set_pin(g, GSC_MOV, false);
    set_pin(g, GSC_RAMP, false);
}

void end_motion(struct gsc *g)
{
    let_fall(g);
    g->motion.phase = AT_REST;
}

gsc_time kill_motion(struct gsc *g)
{
    bool is_pulse = g->motion.phase == STEPPING || g->motion.phase == LAST_PULSE;

    return is_pulse && gsc_is_before(g->now, g->motion.pulse_end) ? g->motion.pulse_end : g->now;
}

/* -------------------------------------------------------------------------------------------------- homing: command H */
static bool is_at_switch(const struct gsc *g)
{
    return !is_high(g, g->motion.homing == TO_EOT ? GSC_EOT : GSC_HOME);
}

/* Out to EOT, back to HOME, where the counter is cleared; a switch that is already low needs no travel.  Return whether
   the homing is complete. */
static bool go_home(struct gsc *g)
{
    if (g->motion.homing == TO_EOT) {
        if (!is_at_switch(g)) {
            set_out(g);
            return false;
        }
        g->motion.homing = TO_HOME;
        g->motion.direction = (int8_t)-g->motion.direction;
    }
    if (!is_at_switch(g)) {
        set_out(g);
        return false;
    }
    end_motion(g);
    g->position = 0;
    return true;
}

bool begin_homing(struct gsc *g, int8_t direction, uint16_t speed)
{
    plan_homing(g, speed);
    begin(g, direction, TO_EOT);
    return go_home(g);
}

/* ---------------------------------------------------------------------------------------------------------- the steps */
/* An endless motion counts only as far as a stop needs. */
static void advance_step(struct gsc *g)
{
    if (g->motion.steps != OPEN || g->motion.step <= g->motion.up)
        g->motion.step++;
}

static void make_step(struct gsc *g)
{
    uint64_t interval = step_interval(g);

    set_pin(g, GSC_RAMP, is_ramp(g));
    count_step(g);
    gsc_on_step(g, g->motion.direction, g->now);
    g->motion.pulse_end = g->now + CLOCK_PS;
    g->motion.end = g->now + interval;
    advance_step(g);
    g->motion.phase = g->motion.step == g->motion.steps ? LAST_PULSE : STEPPING;
    start_timer_at(g, GSC_RUN_TIMER, g->motion.phase == LAST_PULSE ? g->motion.pulse_end : g->motion.end);
}

/* Just before a step: check whether it is due.  Return whether the motion has ended instead. */
static bool sample(struct gsc *g)
{
    if (g->motion.homing && is_at_switch(g))
        return go_home(g);
    if (g->motion.is_stop && !g->motion.is_stopping) {
        g->motion.is_stopping = true;
        g->motion.is_stopped = plan_stop(g);
    }
    if (g->motion.step == g->motion.steps) { /* it stops at its present position */
        end_motion(g);
        return true;
    }
    if (is_high(g, GSC_ENABLE))
        make_step(g);
    else
        g->motion.phase = HELD;
    return false;
}

bool motion_timed(struct gsc *g)
{
    if (g->motion.phase == LAST_INTERVAL)
        return true;
    if (g->motion.phase != LAST_PULSE)
        return sample(g);
    let_fall(g);
    g->motion.phase = LAST_INTERVAL;
    start_timer_at(g, GSC_RUN_TIMER, g->motion.end);
    return false;
}

/* A held step follows 5 us after ENABLE is high again (GSC-UND-ENABLE-LATENCY); a stop request may end the
   motion here. */
bool motion_settled(struct gsc *g)
{
    if (g->motion.phase != HELD)
        return false;
    if (is_high(g, GSC_ENABLE)) {
        g->motion.phase = RELEASED;
        start_timer(g, GSC_RUN_TIMER, RELEASE_PS);
        return false;
    }
    return g->motion.is_stop && !g->motion.is_stopping && sample(g);
}

/* After a stop request there is a further step only if there is a ramp down. */
bool is_step_ahead(const struct gsc *g)
{
    bool is_next = g->motion.phase == SETTING_UP || g->motion.phase == STEPPING || g->motion.phase == RELEASED;
    bool is_last = g->motion.is_stop && !g->motion.is_stopping && (g->motion.is_flat || g->motion.step == 0);

    return is_next && !is_last && !(g->motion.homing && is_at_switch(g)) && is_high(g, GSC_ENABLE);
}
