#include "profile.h"

#include <math.h>

#include "sheet.h"

#define SECOND 1000000000000ULL /* ps */

static uint32_t least(uint32_t one, uint32_t other)
{
    return one < other ? one : other;
}

/* Interval of a step at a speed in units of 10 steps/s, rounded. */
static uint64_t period(uint16_t speed)
{
    uint32_t rate = RATE_UNIT * speed;

    return (SECOND + rate / 2) / rate;
}

/* Interval k of the ramp up, k below R.  These are the operations of the model, each rounded by IEEE 754, so
   the result is the same to the last bit; the last one rounds to the nearest picosecond, half to even. */
static uint64_t ramp_interval(const struct gsc *g, uint32_t k)
{
    double low = (double)(RATE_UNIT * g->motion.start_stop), high = (double)(RATE_UNIT * g->motion.top_speed);
    double exact, rest;
    uint64_t whole;

    if (k == 0)
        return period(g->motion.start_stop);
    exact = 1e12 / sqrt(low * low + (high * high - low * low) * (double)k / (double)g->motion.ramp);
    whole = (uint64_t)exact;
    rest = exact - (double)whole;
    return whole + (rest > 0.5 || (rest == 0.5 && (whole & 1)));
}

static void plan(struct gsc *g, uint32_t steps, uint16_t slew)
{
    g->motion.start_stop = g->registers.start_stop;
    g->motion.top_speed = g->registers.top_speed;
    g->motion.ramp = g->registers.ramp;
    g->motion.is_flat = g->motion.top_speed <= g->motion.start_stop;
    g->motion.up = g->motion.down = 0;
    g->motion.down_from = OPEN;
    g->motion.steps = steps;
    g->motion.step = 0;
    g->motion.slew_ps = period(slew);
}

void plan_move(struct gsc *g, uint32_t steps)
{
    plan(g, steps, g->registers.top_speed);
    if (g->motion.is_flat)
        return;
    if (steps == 1) { /* GSC-UND-SINGLE */
        g->motion.slew_ps = period(g->motion.start_stop);
        return;
    }
    g->motion.up = (uint16_t)least(g->motion.ramp, steps / 2);
    g->motion.down = (uint16_t)least(g->motion.ramp, (steps - 1) / 2);
    g->motion.down_from = steps - 1 - g->motion.down;
}

void plan_endless(struct gsc *g, uint32_t limit)
{
    plan(g, limit, g->registers.top_speed);
    if (!g->motion.is_flat)
        g->motion.up = (uint16_t)least(g->motion.ramp, limit);
}

void plan_homing(struct gsc *g, uint16_t speed)
{
    plan(g, OPEN, speed);
}

/* As many ramp steps as the acceleration has taken so far, or the rest of the ramp down. */
bool plan_stop(struct gsc *g)
{
    uint32_t room = g->motion.steps - g->motion.step; /* in an endless motion, more than is ever needed */
    uint32_t left = least(g->motion.step, g->motion.up + 1U);

    if (g->motion.is_flat)
        left = 0;
    else if (!g->motion.is_endless) /* a move does not exceed its target */
        left = least(left, room);
    g->motion.up = 0;
    g->motion.down = (uint16_t)(left ? left - 1 : 0);
    g->motion.down_from = 0;
    g->motion.steps = least(left, room);
    g->motion.step = 0;
    return left <= room;
}

bool is_ramp(const struct gsc *g)
{
    return !g->motion.is_flat && (g->motion.step < g->motion.up || g->motion.step >= g->motion.down_from);
}

uint64_t step_interval(const struct gsc *g)
{
    uint32_t step = g->motion.step;

    if (!is_ramp(g))
        return g->motion.slew_ps;
    if (step < g->motion.up)
        return ramp_interval(g, step);
    step -= g->motion.down_from;
    return ramp_interval(g, step < g->motion.down ? g->motion.down - 1U - step : 0);
}
