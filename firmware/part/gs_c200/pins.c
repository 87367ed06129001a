#include "pins.h"

#include "sheet.h"

void set_pin(struct gsc *g, enum gsc_pin pin, bool is_high)
{
    uint16_t bit = (uint16_t)(1U << pin);

    if (is_high)
        g->levels |= bit;
    else
        g->levels &= (uint16_t)~bit;
}

bool is_high(const struct gsc *g, enum gsc_input input)
{
    return (g->inputs & (unsigned)input) != 0;
}

bool is_user_input_high(const struct gsc *g, uint8_t number)
{
    return (g->inputs & (unsigned)GSC_UI1 << (number - 1)) != 0;
}

/* Of several changes in one instant only the last is an edge. */
void show_pins(struct gsc *g)
{
    uint16_t changed = g->levels ^ g->shown;

    g->shown = g->levels;
    for (unsigned pin = 0; pin < GSC_PINS; pin++)
        if (changed >> pin & 1)
            gsc_on_pin(g, (enum gsc_pin)pin, g->levels >> pin & 1, g->now);
}

void begin_work(struct gsc *g, enum work work)
{
    g->work |= (uint8_t)work;
    set_pin(g, GSC_RDY, false);
}

void end_work(struct gsc *g, enum work work)
{
    g->work &= (uint8_t)~work;
    set_pin(g, GSC_RDY, !g->work);
}

void start_timer_at(struct gsc *g, enum gsc_timer timer, gsc_time at)
{
    g->timer[timer].is_on = true;
    g->timer[timer].at = at;
}

void start_timer(struct gsc *g, enum gsc_timer timer, gsc_time delay_ps)
{
    start_timer_at(g, timer, g->now + delay_ps);
}

void stop_timer(struct gsc *g, enum gsc_timer timer)
{
    g->timer[timer].is_on = false;
}

/* The pulse is completed even if the requesting command is ended. */
void pulse_reset(struct gsc *g)
{
    set_pin(g, GSC_RESET, false);
    start_timer(g, GSC_RESET_TIMER, RESET_PS);
}

void end_reset_pulse(struct gsc *g)
{
    set_pin(g, GSC_RESET, true);
}
