/* Every call of the core carries the instant of an event, not the instant at which the processor handles it: a
 * character and an edge have the time stamp of their interrupt, a step that of its state machine.  So the core may be
 * late by tens of microseconds without effect, as long as the next step is prepared in time.
 *
 *     pins --stamps--> queues --+
 *                               +--> the core, in the order of instants --> pins, characters
 *     state machine of CLOCK ---+                  |
 *            ^                                     v
 *            +---- the next step, prepared for the case without further events
 *
 * The next event is tried on a copy of the core while there is time: a step of a ramp takes some 50 us to compute,
 * E the same.  When the event is due, the copy replaces the part, unless another event intervened.
 */
#include "part.h"

#include <stdbool.h>

#include "gsc200.h"
#include "inputs.h"
#include "outputs.h"
#include "pins.h"
#include "registers.h"
#include "serial.h"
#include "sizes.h"
#include "steps.h"
#include "store.h"

enum {
    ANSWER_DELAY = 8 * US,  /* of every answer: time to write the word of its first character */
    DIR_SETUP = 10 * US,    /* figure 2: GSC-UND-DIR-SETUP */
    LOOK_FOR_HOLD = 3 * US, /* after the instant of a step */
    TRY = 200 * US,         /* lead time for trying an event */
    TRY_AGAIN = 150 * US,
    TOO_NEAR = 50 * US,     /* an input closer than this before a step takes effect after it */
    ROUND = CLOCK_HZ / 100,       /* the longest sleep */
    WHILE_WRITING = CLOCK_HZ / 1000,
    TOGETHER_PS = 2000000, /* events within this time are tried together */
    POWER_UP_PS = 26000000, /* duration of gsc_power_up(), so RESET has the length in the sheet */
    ENQ = 5
};

static struct gsc cores[2];
static struct gsc *part = &cores[0], *ahead = &cores[1]; /* the part; its state after the next event */
static bool is_tried;           /* `ahead` is valid */
static gsc_time tried_due;
static bool ahead_stores, ahead_sends;
static uint32_t enable = GSC_ENABLE; /* level known to the core: the sample of the state machine */
static uint32_t levels;              /* of the other inputs, as known to the core */
static bool is_held, has_step;
static gsc_time step_due;
static gsc_time last_character;
static bool is_early;                /* the next character of the answer has already been sent */
static const char *version; /* the rest still to be sent */

/* ---------------------------------------------------------------------------------------------- outputs of the core */
void gsc_on_pin(struct gsc *g, enum gsc_pin pin, int level, gsc_time now)
{
    (void)g, (void)pin, (void)level, (void)now; /* of several changes in one instant only the last is an edge */
}

void gsc_on_step(struct gsc *g, int direction, gsc_time now)
{
    (void)g, (void)direction, (void)now; /* its state machine has output it */
}

static void send(uint8_t character, gsc_time at)
{
    const bool follows = at - last_character < clock_ps_of(serial_length() + US);
    serial_put(character, clock_cycle(at) + ANSWER_DELAY, follows);
    last_character = at;
}

/* The copy provides the first character of an answer before it is due. */
void gsc_on_character(struct gsc *g, uint8_t character, gsc_time now)
{
    if (!is_early)
        send(character, now);
    is_early = ahead_sends = g == ahead;
}

/* The next character of an answer in progress is known. */
static void send_ahead(void)
{
    if (is_early || !part->serial.sent || part->serial.sent >= part->serial.length)
        return;
    send(part->serial.answer[part->serial.sent], last_character + clock_ps_of(serial_length()));
    is_early = true;
}

void gsc_on_store(struct gsc *g, const uint8_t *program, uint8_t size, gsc_time now)
{
    (void)now;
    if (g == part)
        store_begin(program, size);
    else
        ahead_stores = true;
}

int gsc_recall(struct gsc *g, uint8_t program[GSC_LOCATIONS])
{
    (void)g;
    return store_recall(program);
}

/* ------------------------------------------------------------------------------------------------------- progress */
static gsc_time no_sooner(gsc_time instant)
{
    return gsc_is_before(instant, part->now) ? part->now : instant;
}

/* Replace the part by the tried copy. */
static void take_what_was_tried(void)
{
    struct gsc *const before = part;
    part = ahead;
    ahead = before;
    if (ahead_sends)
        is_early = false;
    if (ahead_stores)
        store_begin(part->program.memory, part->program.size);
}

static void go_on_to(gsc_time due)
{
    if (is_tried && tried_due == due)
        take_what_was_tried();
    else
        gsc_advance(part, due);
    is_tried = false;
}

/* Return whether an event has been tried. */
static bool try_what_is_next(void)
{
    gsc_time due, next;
    if (is_tried || is_held || part->is_unsettled || !gsc_next(part, &due))
        return false;
    if (!(has_step && due == step_due) && (int64_t)(clock_cycle(due) - clock_now()) > TRY)
        return false;
    *ahead = *part;
    ahead_stores = ahead_sends = false;
    gsc_advance(ahead, due);
    while (gsc_next(ahead, &next) && next - due < TOGETHER_PS && !(has_step && !gsc_is_before(next, step_due)))
        gsc_advance(ahead, next); /* a string that waits for the end of an answer is due with it, except for its stamp */
    tried_due = due;
    is_tried = true;
    return true;
}

/* ----------------------------------------------------------------------------------------------------------- the steps */
/* A prepared step has not been output, whatever its instant: the first step of a motion may be late. */
static gsc_time before_step(gsc_time instant)
{
    return no_sooner(has_step && !is_held && !gsc_is_before(instant, step_due) ? step_due - 1 : instant);
}

static void tell_inputs(gsc_time instant)
{
    gsc_set_inputs(part, (uint16_t)(levels | enable), before_step(instant));
    is_tried = false;
}

/* Return whether a step follows in the present state, and its instant.  A string executed before it, or an input sample,
   may change that, as the tried copy shows. */
static bool foresee(gsc_time *due)
{
    gsc_time then;
    if (!gsc_step_ahead(part, due))
        return false;
    if (!is_tried || !gsc_is_before(tried_due, *due))
        return true;
    return gsc_step_ahead(ahead, &then) && then == *due;
}

/* Send the next step to the state machine, and no other. */
static void prepare(void)
{
    gsc_time due;
    if (part->is_unsettled)
        return;
    if (is_held) {
        if (!part->motion.is_moving) { /* no step waits for the release any more */
            (void)steps_disarm();
            is_held = has_step = false;
            enable = GSC_ENABLE;
            tell_inputs(part->now);
        }
    } else if (!foresee(&due)) {
        if (has_step && !steps_disarm())
            has_step = false;
    } else if (!has_step || due != step_due) {
        if (has_step && steps_disarm())
            return; /* it has just been output, and its interrupt follows */
        inputs_set_fatal(part->motion.homing ? 1u << (part->motion.homing == 1 ? PIN_EOT : PIN_HOME) : 0);
        if (~SIO_IN & inputs_fatal())
            return; /* its edge is in the queue */
        step_due = due;
        has_step = true;
        steps_arm(due, outputs_dir_changed() + DIR_SETUP);
    }
    if (!part->motion.is_moving)
        steps_end_motion();
    if (!has_step)
        inputs_set_fatal(0);
}

/* The step was held at its instant: pass ENABLE low to the core then. */
static void be_held(void)
{
    enable = 0;
    tell_inputs(step_due - 1);
    go_on_to(step_due);
    is_held = true;
}

static void be_released(void)
{
    gsc_time due;
    enable = GSC_ENABLE;
    tell_inputs(steps_released_at());
    is_held = false;
    if (gsc_step_ahead(part, &due)) {
        step_due = due;
        steps_go_on(due);
    } else if (!steps_disarm())
        has_step = false;
}

/* Process the prepared step, if it is due; return whether the core has advanced. */
static bool step(void)
{
    switch (has_step ? steps_look() : STEP_NONE) {
    case STEP_MADE:
        go_on_to(no_sooner(step_due));
        steps_take();
        has_step = false;
        return true;
    case STEP_HELD:
        if (is_held)
            return false;
        be_held();
        return true;
    case STEP_RELEASED:
        if (!is_held)
            be_held();
        be_released();
        return true;
    default:
        return false;
    }
}

/* Let the core advance to a cycle.  A prepared step keeps its place among the due events, and is awaited. */
static void advance(cycles limit)
{
    gsc_time due;
    for (;;) {
        if (is_held && step())
            continue;
        const bool is_any = gsc_next(part, &due);
        if (!is_any || due != part->now)
            outputs_show(part->shown); /* no further event is due in this instant */
        if (!is_any)
            return;
        if (has_step && !is_held && !gsc_is_before(due, step_due)) {
            if (!step())
                return;
        } else if ((int64_t)(limit - clock_cycle(due)) < 0)
            return;
        else
            go_on_to(due);
        send_ahead();
        prepare();
    }
}

/* ----------------------------------------------------------------------------------------------------------- the inputs */
/* Take new levels, valid at a cycle; return false if a step must be awaited. */
static bool change(uint32_t now_levels, cycles at)
{
    if (now_levels == levels)
        return true;
    if (has_step && !is_held) {
        if (~now_levels & inputs_fatal() & (GSC_HOME | GSC_EOT)) {
            if (steps_disarm())
                return false;
            has_step = false;
        } else if (steps_look() == STEP_MADE || (int64_t)(steps_at() - clock_now()) < TOO_NEAR)
            return false;
    }
    levels = now_levels;
    tell_inputs(clock_instant(at));
    prepare();
    return true;
}

static void take_character(const struct received *character)
{
    if (character->character == ENQ && !character->is_parity_wrong && SIO_IN >> PIN_TEST & 1) {
        version = VERSION_TEXT;
        return;
    }
    const uint8_t faults = (character->is_parity_wrong ? GSC_PARITY : 0) | (character->is_framing_wrong ? GSC_FRAMING : 0);
    const gsc_time now = before_step(clock_instant(character->at));
    gsc_receive(part, character->character, faults, clock_instant(character->end), now);
    is_tried = false;
}

static void say_version(void)
{
    if (!version || !serial_is_empty())
        return;
    const bool is_over = !*version;
    serial_put(is_over ? '\r' : (uint8_t)*version++, clock_now() + ANSWER_DELAY, true);
    if (is_over)
        version = 0;
}

void part_start(void)
{
    store_start();
    levels = inputs_of(SIO_IN);
    gsc_power_up(part, PART, (uint16_t)(levels | enable), clock_instant(clock_now()) + POWER_UP_PS);
    outputs_start(part->shown);
}

static bool is_news(void)
{
    return inputs_are_waiting() || serial_is_waiting() || steps_is_news();
}

void part_round(void)
{
    static bool listens;
    struct received character;
    bool is_good;

    clock_move_anchor();
    while (serial_get(&character)) {
        advance(character.at);
        take_character(&character);
    }
    while (inputs_are_waiting()) {
        const struct edge edge = inputs_first();
        const cycles at = clock_of_stamp(edge.stamp);
        advance(at);
        /* RXD unchanged: its edges are characters */
        if (!change((inputs_of(edge.pins) & ~(uint32_t)GSC_RXD) | (levels & GSC_RXD), at))
            break;
        inputs_take();
    }
    if (steps_are_stopped()) { /* by a pulse that has already ended */
        if (!steps_disarm())
            has_step = false;
        prepare();
    }
    const cycles now = clock_now();
    if (!inputs_are_waiting()) {
        uint32_t pins = inputs_of(SIO_IN);
        if (listens)
            pins = (pins & ~(uint32_t)GSC_RXD) | (levels & GSC_RXD);
        (void)change(pins, now);
    }
    advance(clock_now());
    if (!listens && gsc_baud(part)) {
        serial_begin(gsc_baud(part));
        listens = true;
    }
    if (store_go_on(&is_good))
        gsc_stored(part, is_good), is_tried = false;
    say_version();
    prepare();
    if (try_what_is_next())
        prepare();

    gsc_time due;
    cycles wake = clock_now() + (store_is_writing() || version ? WHILE_WRITING : ROUND);
    if (has_step && !is_held && (int64_t)(wake - steps_at()) > LOOK_FOR_HOLD)
        wake = steps_at() + LOOK_FOR_HOLD;
    if (gsc_next(part, &due) && !(has_step && !is_held && !gsc_is_before(due, step_due)) && (int64_t)(wake - clock_cycle(due)) > 0)
        wake = clock_cycle(due) - (is_tried || is_held ? 0 : TRY_AGAIN);
    clock_sleep_until(wake, is_news);
}
