/* The effects of frames.
 *
 * Each takes effect at one instant, between hal_enter() and settle(), which its ANSWER reports.  So the host knows
 * which steps came before it and which after.  Long work, such as checking records, is done outside, where steps
 * continue.
 */
#include "commands.h"
#include "answers.h"
#include "bytes.h"
#include "config.h"
#include "content.h"
#include "events.h"
#include "hal.h"
#include "inputs.h"
#include "limits.h"
#include "line.h"
#include "motion.h"
#include "outputs.h"
#include "power.h"
#include "queue.h"
#include "reflexes.h"
#include "state.h"
#include "steps.h"
#include "stop_ramp.h"
#include "tail.h"

#define NUMBER frame[0]
#define KIND frame[1]
#define PAYLOAD (frame + 2)
#define LENGTH ((uint8_t)(frame_length - 2))

/* Write records after the queue, where there is room; return whether they are valid. */
static uint8_t read_records(uint8_t n, uint8_t has_room)
{
    struct record spare;
    const uint8_t *from = PAYLOAD;
    uint8_t i;

    if (n < 1 || n > RECORDS_MOST || LENGTH != n * RECORD_BYTES)
        return 0;
    for (i = 0; i < n; i++, from += RECORD_BYTES) {
        struct record *to = has_room ? place_in_queue(i) : &spare;

        if (!read_record(from, to))
            return 0;
        complete(to);
    }
    return 1;
}

static void take_push(void)
{
    /* Meanwhile the queue can only get shorter; a halt may empty it, and then its end is unchanged. */
    uint8_t n = LENGTH / RECORD_BYTES, has_room = queued + n <= SLOTS, good = read_records(n, has_room);
    struct record *behind = place_in_queue(n);
    uint32_t tick = hal_enter();

    if (state > STATE_RUN) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (!good) {
        settle(RESULT_BAD_CONTENT, tick);
    } else if (!has_room) {
        settle(RESULT_NO_ROOM, tick);
    } else {
        publish(n, behind);
        settle(RESULT_TAKEN, tick);
    }
}

static void take_start(void)
{
    uint32_t tick = hal_enter(), begin = get32(PAYLOAD), ahead = begin - tick;

    if (state != STATE_IDLE || !queued) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (LENGTH != 4) {
        settle(RESULT_BAD_CONTENT, tick);
    } else if (ahead + START_MOST_TICKS > 2 * START_MOST_TICKS || first_due(ahead) - START_LEAD_TICKS >= 0xE0000000) {
        /* From -2^28 to 2^28, and an interval of less than 2^31: negative values are at the upper end of 32 bits. */
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
        /* Steps may be fast, and are waiting: the event has its number, and is written after them. */
        uint8_t number = next_event++;

        settle(RESULT_TAKEN, tick);
        write_event(number, EVENT_BRAKED, HOST, answer.state, answer.inputs, answer.position, tick);
        return;
    }
    command(cause, tick);
    settle(RESULT_TAKEN, tick);
}

/* Not part of `main`, so its CONFIG is on the stack only while one is processed. */
static __attribute__((noinline)) void take_config(void)
{
    struct config new;
    uint8_t is_good = read_config(PAYLOAD, LENGTH, &new), is_other_driver;
    uint32_t tick = hal_enter();

    if (state != STATE_BOOT && state != STATE_IDLE && state != STATE_HALT) {
        settle(RESULT_WRONG_STATE, tick);
        return;
    }
    if (!is_good) {
        settle(RESULT_BAD_CONTENT, tick);
        return;
    }
    is_other_driver = new.driver != config.driver || (new.polarity ^ config.polarity) & POLARITY_ENABLE_LOW;
    config = new;
    tail_configured();
    hal_set_dry(is_dry());
    hal_serve_line();
    sort_reflexes();
    hal_serve_line();
    power_configured(is_other_driver);
    if (state == STATE_IDLE && is_estop_active())
        halt();
    hal_serve_line();
    configure_outputs();
    set_phase_step(flags);
    show_direction();
    if (state == STATE_BOOT)
        set_state(STATE_HALT);
    settle(RESULT_TAKEN, tick);
}

static void take_tail_frame(void)
{
    uint8_t n, result = judge_tail(PAYLOAD, LENGTH, &n);
    uint32_t tick = hal_enter();

    if (state == STATE_BRAKE || state == STATE_BOOT)
        result = RESULT_WRONG_STATE;
    if (result == RESULT_TAKEN)
        take_tail(PAYLOAD + 1, PAYLOAD[0], n);
    settle(result, tick);
    if (result == RESULT_TAKEN)
        tail_settled();
}

static void take_reset(void)
{
    uint32_t tick = hal_enter();

    if ((state != STATE_IDLE && state != STATE_HALT) || is_estop_active()) {
        settle(RESULT_WRONG_STATE, tick);
    } else if (LENGTH != 5 || PAYLOAD[0] > (RESET_POSITION | RESET_KNOWN | RESET_POWER)) {
        settle(RESULT_BAD_CONTENT, tick);
    } else {
        forget_queue();
        unlock(PAYLOAD[0]);
        if (PAYLOAD[0] & RESET_POSITION)
            place((int32_t)get32(PAYLOAD + 1));
        set_state(STATE_IDLE);
        settle(RESULT_TAKEN, tick);
    }
}

static void take_outputs(void)
{
    uint32_t tick = hal_enter();

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

/* Fetch the requested event, in its state at the instant of the answer, or return 0. */
static uint8_t take_repeat(struct event *event)
{
    uint8_t next, back;
    uint32_t tick;

    for (;;) {
        next = next_event;
        fetch_event(PAYLOAD[0], event);
        tick = hal_enter();
        if (next_event == next)
            break;
        hal_leave();
    }
    settle(LENGTH == 1 ? RESULT_TAKEN : RESULT_BAD_CONTENT, tick);
    back = (uint8_t)(next - PAYLOAD[0]);
    return LENGTH == 1 && back >= 1 && back <= EVENTS_KEPT;
}

static void take_check(void)
{
    uint32_t tick = hal_enter();

    if (state != STATE_IDLE || is_dry() || is_enabled())
        settle(RESULT_WRONG_STATE, tick);
    else if (LENGTH != 4 || !get16(PAYLOAD) || get16(PAYLOAD + 2) < LEAST_CHECK)
        settle(RESULT_BAD_CONTENT, tick);
    else
        settle(RESULT_TAKEN, tick);
}

/* Output pulses and count them: with STEP looped to a counter input, the board checks its own pin. */
static void check(uint16_t pulses, uint16_t apart)
{
    uint16_t counted = hal_count_pulses(pulses, apart);
    uint32_t tick = hal_enter();

    write_event(next_event++, EVENT_CHECKED, counted != pulses, state, levels, counted, tick);
    hal_leave();
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
        send_event(PAYLOAD[0], &event);
    if (kind == FRAME_CHECK)
        check(get16(PAYLOAD), get16(PAYLOAD + 2));
}

void take_damage(void)
{
    answer.echo = answer.kind = 0;
    refuse(RESULT_DAMAGED);
    send_answer();
}
