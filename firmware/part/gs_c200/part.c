/* The module as a whole: its supply, and the order in which an instant is processed.
 *
 *     1  everything timed      levels of inputs as before the instant     timed()
 *     2  a received character                                             gsc_receive()
 *     3  inputs                                                           gsc_set_inputs()
 *     4  strings of the host   the new levels                             settle()
 *     5  waits for a level
 *     6  outputs
 *
 * docs/explanation/simultaneous.md lists the consequences.
 */
#include "eeprom.h"
#include "gsc200.h"
#include "motion.h"
#include "pins.h"
#include "program.h"
#include "serial.h"
#include "sheet.h"
#include "storage.h"

/* --------------------------------------------------------------------------------------------------------- the supply */
void gsc_power_up(struct gsc *g, enum gsc_part part, uint16_t inputs, gsc_time now)
{
    *g = (struct gsc){.part = part, .inputs = inputs, .now = now, .levels = LEVELS_AT_RESET};
    begin_work(g, START_WORK);
    pulse_reset(g);
    g->shown = (uint16_t)~g->levels; /* so that all of them are reported */
    show_pins(g);
}

/* The stand-alone start (pins 9 and 11; command H; GSC-UND-AUTO-NO-S, GSC-UND-AUTO-EMPTY, GSC-UND-AUTO-RXD). */
static void start_alone(struct gsc *g)
{
    bool is_loaded = !is_high(g, GSC_REC) && recall_program(g);

    if (is_loaded && g->program.size && begins_with_start_stop(g) && !is_speed_missing(g))
        run_homing(g, is_high(g, GSC_RXD) ? -1 : 1, true);
}

static void reset_timed(struct gsc *g)
{
    end_reset_pulse(g);
    if (g->work & START_WORK) {
        end_work(g, START_WORK);
        listen_to_host(g);
        start_alone(g);
    }
}

/* --------------------------------------------------------------------------------------------------------- an instant */
static bool is_due(struct gsc *g, enum gsc_timer timer)
{
    if (!g->timer[timer].is_on || gsc_is_before(g->now, g->timer[timer].at))
        return false;
    g->timer[timer].is_on = false;
    return true;
}

static void timed(struct gsc *g)
{
    bool is_good;

    if (is_due(g, GSC_RESET_TIMER))
        reset_timed(g);
    if (is_due(g, GSC_RUN_TIMER))
        run_timed(g);
    if (is_due(g, GSC_WATCH_TIMER))
        watch_timed(g);
    if (is_due(g, GSC_EEPROM_TIMER) && eeprom_timed(g, &is_good))
        answer_memorize(g, is_good);
    if (is_due(g, GSC_SERIAL_TIMER))
        serial_timed(g);
    g->is_unsettled = true;
}

static void settle(struct gsc *g)
{
    obey_strings(g);
    run_settled(g);
    show_pins(g);
    g->is_unsettled = false;
}

bool gsc_next(const struct gsc *g, gsc_time *due)
{
    bool is_any = g->is_unsettled;

    *due = g->now;
    for (unsigned timer = 0; timer < GSC_TIMERS; timer++)
        if (g->timer[timer].is_on && (!is_any || gsc_is_before(g->timer[timer].at, *due))) {
            *due = g->timer[timer].at;
            is_any = true;
        }
    return is_any;
}

/* Process all events before an instant, and the timed events in it. */
static void pass(struct gsc *g, gsc_time now)
{
    gsc_time due;

    while (gsc_next(g, &due) && !gsc_is_before(now, due)) {
        if (g->is_unsettled) {
            if (due == now)
                break;
            settle(g);
        } else {
            g->now = due;
            timed(g);
        }
    }
    g->now = now;
}

void gsc_advance(struct gsc *g, gsc_time now)
{
    pass(g, now);
    if (g->is_unsettled)
        settle(g);
}

void gsc_set_inputs(struct gsc *g, uint16_t inputs, gsc_time now)
{
    pass(g, now);
    g->inputs = inputs;
    settle(g);
}

void gsc_receive(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end, gsc_time now)
{
    pass(g, now);
    receive_character(g, character, faults, end);
    g->is_unsettled = true;
}

bool gsc_step_ahead(const struct gsc *g, gsc_time *when)
{
    *when = g->timer[GSC_RUN_TIMER].at;
    return g->timer[GSC_RUN_TIMER].is_on && !g->is_unsettled && is_step_ahead(g);
}
