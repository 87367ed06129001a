/* What frames do.
 *
 * Each takes effect at one instant, between enter() and leave(), and its ANSWER says which.  So the host can know which
 * steps came before it and which after.  What takes long, such as to look at records, is done outside, where the steps
 * go on.
 */
#include <avr/io.h>

#include "clock.h"
#include "commands.h"
#include "events.h"
#include "inputs.h"
#include "motion.h"
#include "outputs.h"
#include "pins.h"
#include "power.h"
#include "protocol.h"
#include "wire.h"

#define NUMBER frame[0]
#define KIND frame[1]
#define PAYLOAD (frame + 2)
#define LENGTH ((uint8_t)(frame_length - 2))

static struct {
    uint8_t echo;
    uint8_t kind;
    uint8_t result;
    uint8_t free;
    uint8_t state;
    uint8_t events;
    uint8_t inputs;
    uint8_t flags;
    int32_t position;
    uint32_t tick;
} answer;

static uint8_t wanted;      /* number of the next numbered frame */
static uint8_t told;        /* number of the next event to be sent */
static uint32_t last_heard; /* tick of the last sound frame */
static uint8_t is_silent;   /* there has been none for as long as the watchdog allows */
static uint32_t watchdog;

/* Say in the answer how things are, and let the steps go on. */
static __attribute__((noinline)) void settle(uint8_t result, uint32_t tick)
{
    answer.free = SLOTS - queued;
    answer.state = state;
    answer.events = next_event;
    answer.inputs = levels;
    answer.flags = power;
    answer.position = position_now();
    leave();
    answer.result = result;
    answer.tick = tick;
    if (result != RESULT_DAMAGED) {
        last_heard = tick;
        is_silent = 0;
    }
    if (has_estop(answer.inputs)) /* last: whatever had to outlast a call would be saved before the steps go on */
        answer.flags |= POWER_ESTOP;
}

static void refuse(uint8_t result)
{
    settle(result, enter());
}

/* Fetch an event while interrupts may write others. */
static void fetch(uint8_t number, struct event *event)
{
    *event = events[number % EVENTS_KEPT];
    __asm__ volatile("" : : : "memory"); /* all of it, before anything else is looked at */
}

/* Send events, in order, up to the one with this number. */
static void tell_events_before(uint8_t number)
{
    for (;;) {
        struct event event;
        uint8_t next = next_event;

        if ((uint8_t)(next - told) <= (uint8_t)(next - number))
            return; /* seen from the next one, for many may have come in a self-test */
        fetch(told, &event);
        if ((uint8_t)(next_event - told) > EVENTS_KEPT) {
            told = next_event - EVENTS_KEPT; /* overwritten; the host sees the gap */
            continue;
        }
        send(told, FRAME_EVENT, &event, sizeof event);
        told++;
    }
}

void tell_events(void)
{
    tell_events_before(next_event);
}

static void send_answer(void)
{
    tell_events_before(answer.events);
    if (answer.kind == FRAME_HELLO && answer.result == RESULT_TAKEN) {
        static const struct {
            uint8_t version, board, slots, tail, room;
            uint16_t shortest;
            uint32_t hz;
        } ident = {VERSION, BOARD_NUMBER, SLOTS, TAIL_MOST, ROOM, SHORTEST, HZ};

        send(wanted, FRAME_IDENT, &ident, sizeof ident);
    }
    send(wanted, FRAME_ANSWER, &answer, sizeof answer);
}

void take_damage(void)
{
    answer.echo = answer.kind = 0;
    refuse(RESULT_DAMAGED);
    send_answer();
}

/* ------------------------------------------------------------------------------------------------- content of frames */
static uint32_t magnitude(int32_t value)
{
    return value < 0 ? -(uint32_t)value : (uint32_t)value;
}

/* Are whole ticks of an interval within what the timer can do? */
static uint8_t is_possible(uint32_t ticks)
{
    return ticks >= SHORTEST && ticks < 0x80000000;
}

static uint8_t is_good_record(const struct record *record)
{
    uint32_t most, low, high;

    if (record->flags & RECORD_PAUSE) {
        uint8_t mask = record->count >> 8, value = record->count;

        if (record->flags & RECORD_OUT ? (mask | value) > USER_OUTPUTS : record->count != 0)
            return 0;
        return record->flags < 32 && record->interval >= SHORTEST_PAUSE && record->interval < 0x80000000;
    }
    if (record->flags & ~(RECORD_DOWN | RECORD_HALF | RECORD_WAY) || !record->count)
        return 0;
    if (!is_possible(record->interval))
        return 0;
    if (record->flags & RECORD_WAY) {
        uint16_t way = record->add, more = record->count - 1;
        int16_t slope = record->add >> 16;

        return !slope || (slope == 1 && (uint16_t)(way + more) >= way) || (slope == -1 && way >= more);
    }
    if (!record->add)
        return 1;
    /* The last interval: 48 bits, the product in two pieces of 32 by 16. */
    most = magnitude(record->add);
    low = (most & 0xFFFF) * (uint32_t)(record->count - 1u);
    high = (most >> 16) * (uint32_t)(record->count - 1u) + (low >> 16);
    low &= 0xFFFF;
    if (record->add < 0) {
        uint32_t ticks = record->interval - high - (record->fraction < low);

        return high <= record->interval && is_possible(ticks);
    }
    return is_possible(record->interval + high + (record->fraction + low > 0xFFFF));
}

/* ------------------------------------------------------------------------------------------------------------- frames */
static void take_push(void)
{
    uint8_t n = LENGTH / sizeof(struct record), i;
    const struct record *records = (const struct record *)PAYLOAD;
    uint32_t tick;

    if (n < 1 || n > RECORDS_MOST || LENGTH != n * sizeof(struct record)) {
        refuse(state > STATE_RUN ? RESULT_WRONG_STATE : RESULT_BAD_CONTENT);
        return;
    }
    for (i = 0; i < n; i++)
        if (!is_good_record(&records[i])) {
            refuse(state > STATE_RUN ? RESULT_WRONG_STATE : RESULT_BAD_CONTENT);
            return;
        }
    /* The queue only gets shorter behind our back, so there is room if there seems to be; but a halt may forget it, and
       then `in` is where it was. */
    if (queued + n <= SLOTS)
        for (i = 0; i < n; i++)
            prepare(i, &records[i]);
    else
        n = 0;
    tick = enter();
    if (state > STATE_RUN) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (!n) {
        settle(RESULT_NO_ROOM, tick);
    } else {
        publish(n);
        settle(RESULT_TAKEN, tick);
    }
}

static void take_start(void)
{
    uint32_t tick = enter(), begin = *(const uint32_t *)PAYLOAD, ahead = begin - tick;

    if (state != STATE_IDLE || !queued) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (LENGTH != 4) {
        settle(RESULT_BAD_CONTENT, tick);
    } else if (ahead + START_MOST_TICKS > 2 * START_MOST_TICKS || first_due(ahead) - START_LEAD_TICKS >= 0xE0000000) {
        /* From -2^28 to 2^28, and an interval of less than 2^31: what is below 0 is at the upper end of 32 bits. */
        settle(RESULT_LATE, tick);
    } else {
        begin_motion();
        start(begin, tick);
        settle(RESULT_TAKEN, tick);
    }
}

static void take_stop(void)
{
    uint8_t cause;
    uint32_t tick;

    if (LENGTH != 1 || PAYLOAD[0] > 1) {
        refuse(RESULT_BAD_CONTENT);
        return;
    }
    cause = PAYLOAD[0] ? BY_BRAKE : BY_STOP;
    enter_to_stop(cause, &tick);
    if (cause == BY_BRAKE && begins_brake()) {
        /* Steps may be fast, and wait: the event has its number, and is written behind that. */
        uint8_t number = next_event++;

        settle(RESULT_TAKEN, tick);
        write_event(number, EVENT_BRAKED, HOST, answer.state, answer.inputs, answer.position, tick);
        return;
    }
    command(cause, tick);
    settle(RESULT_TAKEN, tick);
}

struct config {
    uint32_t start_stop;
    uint32_t watchdog;
    uint8_t polarity;
    uint8_t active;
    uint8_t report;
    uint8_t driver;
    uint8_t enable_off;
    uint16_t enable_hold;
    uint8_t filter;
    uint8_t lamps; /* low half: number + 1 of the output that shows a halt; high half: of that for the driver */
    uint8_t reflex[INPUTS];
    uint8_t pattern[8];
    uint8_t phase;
};

static uint8_t is_good_config(const struct config *config)
{
    uint8_t i;

    if (LENGTH != sizeof *config || config->start_stop >= 0x80000000 || config->watchdog >= 0x80000000 ||
        config->polarity > 3 ||
        (config->active | config->report) > INPUTS_MASK || config->driver > 3 ||
        config->enable_off > OFF_REST || config->filter > 15 || (config->lamps & 15) > 4 || config->lamps >> 4 > 4 ||
        config->phase > 7)
        return 0;
    for (i = 0; i < 6; i++) {
        uint8_t kind = config->reflex[i] & 15, only = config->reflex[i] >> 4;

        if (kind > REFLEX_ESTOP || only > 2 || (only && kind != REFLEX_STOP && kind != REFLEX_BRAKE))
            return 0;
    }
    for (i = 0; i < 8; i++)
        if (config->pattern[i] > 15)
            return 0;
    return 1;
}

/* Return the bit of an output by its number + 1; 0: none. */
static uint8_t bit_of(uint8_t number)
{
    return number ? 1 << (number - 1) : 0;
}

static void take_config(void)
{
    const struct config *config = (const struct config *)PAYLOAD;
    uint8_t i, is_good = is_good_config(config), driver_before, polarity_before;
    uint32_t tick = enter();

    if (state != STATE_BOOT && state != STATE_IDLE && state != STATE_HALT) {
        settle(RESULT_WRONG_STATE, tick);
        return;
    }
    if (!is_good) {
        settle(RESULT_BAD_CONTENT, tick);
        return;
    }
    set_start_stop(config->start_stop);
    watchdog = config->watchdog;
    driver_before = driver;
    polarity_before = polarity;
    driver = config->driver;
    polarity = config->polarity;
    active = config->active;
    reported = config->report;
    enable_off = config->enable_off;
    enable_hold = config->enable_hold;
    filter = config->filter;
    fault_output = bit_of(config->lamps & 15);
    power_output = bit_of(config->lamps >> 4);
    for (i = 0; i < 6; i++)
        reflexes[i] = config->reflex[i];
    for (i = 0; i < 8; i++)
        pattern[i] = driver & DRIVER_DRY ? 0 : config->pattern[i] << 4;
    serve_line();
    phase = config->phase; /* as it is now */
    phase_step = 0;
    sort_reflexes();
    serve_line();
    power_configured(driver_before, polarity_before);
    serve_line();
    configure_outputs();
    set_phase_step();
    show_direction(down);
    if (state == STATE_BOOT)
        set_state(STATE_HALT);
    settle(RESULT_TAKEN, tick);
}

static void take_tail_frame(void)
{
    uint8_t first = PAYLOAD[0], n = (LENGTH - 1) / sizeof(struct tail_entry), i;
    struct tail_entry *entries = (struct tail_entry *)(PAYLOAD + 1);
    uint32_t least = (uint32_t)SHORTEST << 8, tick, steps = 0;
    uint8_t result = RESULT_TAKEN;

    if (n < 1 || n > ENTRIES_MOST || LENGTH != 1 + n * sizeof(struct tail_entry) || first > tail_count) {
        result = RESULT_BAD_CONTENT;
    } else {
        if (first) {
            least = TAIL_ENTRIES[first - 1].interval; /* no less than SHORTEST */
            steps = TAIL_ENTRIES[first - 1].up_to;
        }
        for (i = 0; i < n; i++) {
            if (entries[i].interval < least || !entries[i].up_to)
                result = RESULT_BAD_CONTENT;
            least = entries[i].interval;
            entries[i].up_to = steps += entries[i].up_to;
        }
        if (result == RESULT_TAKEN && first + n > TAIL_MOST)
            result = RESULT_NO_ROOM;
        else if (steps > 0xFFFF)
            result = RESULT_BAD_CONTENT;
    }
    tick = enter();
    if (state == STATE_BRAKE || state == STATE_BOOT)
        result = RESULT_WRONG_STATE;
    if (result == RESULT_TAKEN)
        take_tail(entries, first, n);
    settle(result, tick);
    if (result == RESULT_TAKEN)
        tail_settled();
}

static void take_reset(void)
{
    uint32_t tick = enter();

    if ((state != STATE_IDLE && state != STATE_HALT) || is_estop_active()) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (LENGTH != 5 || PAYLOAD[0] > (RESET_POSITION | RESET_KNOWN | RESET_POWER)) {
        settle(RESULT_BAD_CONTENT, tick);
    } else {
        forget_queue();
        unlock(PAYLOAD[0]);
        if (PAYLOAD[0] & RESET_POSITION)
            place(*(const int32_t *)(PAYLOAD + 1));
        set_state(STATE_IDLE);
        settle(RESULT_TAKEN, tick);
    }
}

static void take_outputs(void)
{
    uint32_t tick = enter();

    if (state == STATE_BOOT) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (LENGTH != 2 || (PAYLOAD[0] | PAYLOAD[1]) > (USER_OUTPUTS | ENABLE)) {
        settle(RESULT_BAD_CONTENT, tick);
    } else if (!may_switch(PAYLOAD[0], PAYLOAD[1])) {
        settle(RESULT_WRONG_STATE, tick);
    } else {
        choose_outputs(PAYLOAD[0], PAYLOAD[1]);
        settle(RESULT_TAKEN, tick);
        show_outputs();
    }
}

/* Make pulses and count them: with STEP looped to D4 the board sees what its own pin does. */
static void check(uint16_t pulses, uint16_t interval)
{
    uint8_t directions = DDRD;
    uint16_t counted = 0, i;
    uint8_t seen = 0;
    uint32_t tick, next;

    DDRD = directions & ~_BV(COUNTER_BIT);
    TCNT0 = 0;
    TCCR0B = _BV(CS02) | _BV(CS01) | _BV(CS00); /* rising edges at T0 */
    cli();
    next = now();
    sei();
    for (i = 0; i < pulses && state == STATE_IDLE; i++) {
        next += interval;
        do {
            cli();
            tick = now();
            sei();
        } while ((int32_t)(tick - next) < 0);
        cli(); /* a look may arm nothing, but disarms */
        TCCR1A = RISING;
        TCCR1C = _BV(FOC1A);
        __asm__ volatile("nop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop\n\tnop");
        TCCR1A = DISARMED;
        TCCR1C = _BV(FOC1A);
        sei();
        __asm__ volatile("nop\n\tnop\n\tnop\n\tnop");
        counted += (uint8_t)(TCNT0 - seen);
        seen = TCNT0;
    }
    TCCR0B = 0;
    DDRD = directions;
    tick = enter();
    note(EVENT_CHECKED, counted != pulses, tick);
    events[(uint8_t)(next_event - 1) % EVENTS_KEPT].position = counted;
    leave();
}

/* Fetch the event that is asked for, as it is at the instant of the answer, or return 0. */
static uint8_t take_repeat(struct event *event)
{
    uint8_t next, back;
    uint32_t tick;

    for (;;) {
        next = next_event;
        fetch(PAYLOAD[0], event);
        tick = enter();
        if (next_event == next)
            break;
        leave();
    }
    settle(LENGTH == 1 ? RESULT_TAKEN : RESULT_BAD_CONTENT, tick);
    back = next - PAYLOAD[0];
    return LENGTH == 1 && back >= 1 && back <= EVENTS_KEPT;
}

static void take_check(void)
{
    uint32_t tick = enter();
    const uint16_t *words = (const uint16_t *)PAYLOAD;

    if (state != STATE_IDLE || driver & DRIVER_DRY || is_enabled())
        settle(RESULT_WRONG_STATE, tick);
    else if (LENGTH != 4 || !words[0] || words[1] < LEAST_CHECK)
        settle(RESULT_BAD_CONTENT, tick);
    else
        settle(RESULT_TAKEN, tick);
}

void take_frame(void)
{
    uint8_t kind = KIND, is_numbered, repeats = 0;
    struct event event;

    answer.echo = NUMBER;
    answer.kind = kind;
    is_numbered = kind != FRAME_HELLO && kind != FRAME_STOP && kind != FRAME_ASK && kind != FRAME_REPEAT;
    if (!kind || kind > FRAME_CHECK) {
        refuse(RESULT_BAD_CONTENT);
    } else if (is_numbered && NUMBER != wanted) {
        refuse(RESULT_WRONG_NUMBER);
    } else {
        switch (kind) {
        case FRAME_HELLO:
            refuse(LENGTH ? RESULT_BAD_CONTENT : RESULT_TAKEN);
            if (!LENGTH)
                wanted = 0;
            break;
        case FRAME_PUSH:
            take_push();
            break;
        case FRAME_START:
            take_start();
            break;
        case FRAME_STOP:
            take_stop();
            break;
        case FRAME_CONFIG:
            take_config();
            break;
        case FRAME_ASK:
            refuse(LENGTH ? RESULT_BAD_CONTENT : RESULT_TAKEN);
            break;
        case FRAME_TAIL:
            take_tail_frame();
            break;
        case FRAME_RESET:
            take_reset();
            break;
        case FRAME_OUTPUTS:
            take_outputs();
            break;
        case FRAME_REPEAT:
            repeats = take_repeat(&event);
            break;
        case FRAME_CHECK:
            take_check();
            break;
        }
        if (is_numbered && answer.result == RESULT_TAKEN)
            wanted++;
    }
    send_answer();
    if (answer.result != RESULT_TAKEN)
        return;
    if (repeats)
        send(PAYLOAD[0], FRAME_EVENT, &event, sizeof event);
    if (kind == FRAME_CHECK)
        check(*(const uint16_t *)PAYLOAD, *(const uint16_t *)(PAYLOAD + 2));
}

/* ----------------------------------------------------------------------------------------------------------- watchdog */
void watch_for_silence(void)
{
    uint32_t tick = enter();
    uint8_t state_then = state;
    uint16_t passed = (uint16_t)(tick >> 16) - looked_at;

    looked_at = tick >> 16;
    if (state_then == STATE_RUN || state_then == STATE_BRAKE)
        leave(); /* steps may be fast */
    if (watchdog && tick - last_heard >= watchdog)
        is_silent = 1;
    watch_power(passed, state_then, is_silent);
    leave();
    if (!is_silent || state != STATE_RUN)
        return;
    enter_to_stop(BY_BRAKE, &tick);
    if (begins_brake())
        note_in_passing(EVENT_WATCHDOG, HOST, tick);
    else if (state == STATE_RUN)
        brake(EVENT_WATCHDOG, HOST, tick);
    leave();
}
