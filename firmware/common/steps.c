/* Records become steps.
 *
 * The timer itself generates the edge, at the preset tick; the interrupt after it ends the pulse and prepares the next
 * one.  `due` is that next instant, `interval` is added to it there.  A board may output the ordinary step of a record by
 * its own interrupt; match() below handles every case of a step, and is the reference for that interrupt.
 */
#include "steps.h"
#include "config.h"
#include "events.h"
#include "hal.h"
#include "inputs.h"
#include "limits.h"
#include "motion.h"
#include "outputs.h"
#include "protocol.h"
#include "queue.h"
#include "reflexes.h"
#include "state.h"
#include "stop_ramp.h"

/* interval += add, and set whether it may need hops. */
static void grow(void)
{
    uint16_t low;

    if (mode & RAMP) {
        low = (uint16_t)(interval.fraction + (uint16_t)add);
        interval.tick += (uint32_t)((int32_t)(int16_t)((uint32_t)add >> 16) + (low < interval.fraction));
        interval.fraction = low;
    }
    mode &= (uint8_t)~LONG;
    if ((uint16_t)(interval.tick >> 16) || (uint16_t)interval.tick >= LONG_LEAST)
        mode |= LONG;
}

/* Add the interval of the next record to `due`; the queue is not empty. */
static inline void begin_record(void)
{
    interval.fraction = out->fraction;
    interval.tick = out->interval;
    hal_advance();
}

/* Do the rest of the load. */
static void load_record(void)
{
    const struct record *record = out;
    uint8_t was_one_more = mode & ONE_MORE;

    flags = record->flags;
    count = record->count;
    down = flags & RECORD_DOWN;
    mode = has_phases ? PHASES : 0;
    if (flags & RECORD_PAUSE) {
        mode |= PAUSE;
        left = 0;
        /* A motor that has been at rest for this time may stop immediately; a pause may have many pieces. */
        if (due.tick - last >= config.start_stop)
            stepped = paced = 0;
    } else {
        left = count;
        if (down)
            end -= count;
        else
            end += count;
        if (flags & RECORD_RAMP_LEFT) {
            ramp_left = (uint16_t)record->add;
            ramp_slope = (int8_t)((uint32_t)record->add >> 16);
        } else {
            add = record->add;
        }
        mode |= (uint8_t)((flags & RAMP) | (was_one_more ? BRAKING : 0));
        grow();
    }
    set_phase_step(flags);
    drop_record();
}

uint32_t first_due(uint32_t tick)
{
    return tick + out->interval;
}

void start(uint32_t tick, uint32_t present)
{
    due.fraction = 0;
    due.tick = tick;
    stepped = paced = 0;
    set_state(STATE_RUN);
    begin_record();
    load_record();
    show_direction();
    if (acting_at_load(1))
        act_at_load(tick, 1);
    if (!(mode & STILL))
        hal_aim_anew(present);
}

/* The step at `tick` was the last of a record or of a piece: store its interval as the pace. */
static void remember(uint32_t tick)
{
    if (left != count)
        stepped = 1; /* the record had earlier steps */
    left--;
    paced = stepped;
    pace = tick - last;
    stepped = 1;
    last = tick;
}

/* After a record, at `tick`, there is another one. */
static void play_next(uint32_t tick)
{
    uint8_t new_flags = out->flags, was_step = !(mode & PAUSE), turns, is_set = 0;

    turns = (new_flags ^ down) & RECORD_DOWN;
    begin_record();
    hal_end_pulse();
    if (!turns && !(new_flags & RECORD_PAUSE) && interval.tick < LONG_LEAST) {
        hal_arm((uint16_t)due.tick);
        is_set = 1;
    }
    if (was_step)
        remember(tick);
    load_record();
    if (is_set) {
        look_back();
        return;
    }
    if (turns) {
        uint8_t causes = acting_at_load(0);

        show_direction();
        if (causes) {
            uint8_t stays = !takes_away(causes);

            if (stays)
                aim(tick);
            act_at_load(tick, 0);
            return;
        }
    }
    aim(tick);
}

/* After a record, at `tick`: begin the next one; after a pause without one: the end, or the stop ramp. */
static __attribute__((noinline)) void go_on(uint32_t tick)
{
    if (queued && (state == STATE_RUN || mode & ONE_MORE)) {
        play_next(tick);
        return;
    }
    if (flags & RECORD_REST) {
        stand(STATE_IDLE);
        note(EVENT_REST, HOST, tick);
        return;
    }
    if (goes_down_from_pause(tick)) {
        aim(tick);
        account();
    } else {
        halt();
    }
    note(EVENT_UNDERRUN, HOST, tick);
}

static __attribute__((noinline)) void ordinary_step(void)
{
    uint32_t tick = due.tick;

    left--;
    last = tick;
    hal_advance();
    hal_end_pulse();
    aim(tick);
    if (mode & ONE_MORE)
        mode = (uint8_t)(mode - ONE_MORE + BRAKING);
    if (!(mode & STILL))
        grow();
}

static __attribute__((noinline)) void underrun(void)
{
    if (!go_down())
        halt();
    else if (state == STATE_RUN) /* it may have been too late */
        state = STATE_BRAKE;
    note_in_passing(EVENT_UNDERRUN, HOST, last);
}

static __attribute__((noinline)) void brake_at_step(void)
{
    if (!go_down()) {
        halt();
        note(EVENT_HALTED, HOST, last);
    }
}

static __attribute__((noinline)) void match_uninterrupted(void)
{
    do {
        uint8_t was = mode;

        overdue = 0;
        if (was & STILL)
            return;
        if (was & HOP) {
            hal_hop();
        } else {
            if (was & PAUSE && flags & RECORD_OUT) {
                set_outputs((uint8_t)(count >> 8), (uint8_t)count);
                hal_serve_line();
            }
            go_on(due.tick);
        }
        if (overdue)
            hal_serve_line(); /* short pauses in a row */
    } while (overdue);
}

/* Process a match; interrupts are off.  The phases of the step are already set.  A case that may be followed by a
   fast step has a separate path, with as few saved registers as possible. */
void match(void)
{
    uint8_t was = mode;

    if (was & (STILL | HOP | PAUSE))
        match_uninterrupted();
    else if (was & BRAKING)
        brake_at_step();
    else if (left != 1)
        ordinary_step();
    else if (state == STATE_BRAKE && !(was & ONE_MORE))
        play_piece();
    else if (!queued)
        underrun();
    else
        match_uninterrupted();
}
