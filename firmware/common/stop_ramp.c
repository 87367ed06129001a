/* The stop ramp: entries of the table sent by the host, or, without a table, each interval a sixteenth longer.
 *
 * Each function arms the timer first, because a fast step may follow: choose sets `interval`, `due` and the
 * timer; account does the rest.
 */
#include "stop_ramp.h"
#include "config.h"
#include "events.h"
#include "hal.h"
#include "limits.h"
#include "motion.h"
#include "outputs.h"
#include "queue.h"
#include "state.h"
#include "tail.h"

const struct tail_entry *entry; /* the next entry */
uint8_t begun; /* an interrupt has begun a ramp: `entry` has the first entry, `interval` the time to its first step, */
uint16_t skip; /* and this, if the record has RAMP_LEFT, the number of table steps before that entry */

static uint16_t chosen; /* steps of the piece */

/* Return the number of steps of a stop ramp from the step that is due. */
static inline uint16_t ramp_left_now(void)
{
    uint16_t made = (uint16_t)(count - left);

    return (uint16_t)(ramp_slope > 0 ? ramp_left + made : ramp_slope < 0 ? ramp_left - made : ramp_left);
}

void refresh_hint(void)
{
    uint32_t ticks;
    uint16_t remain = 0;
    uint8_t moving, before;
    const struct tail_entry *found;

    if (!tail_count)
        return;
    before = hal_hold();
    moving = state == STATE_RUN && !(mode & (PAUSE | STILL));
    ticks = due.tick - last;
    if (flags & RECORD_RAMP_LEFT)
        remain = ramp_left_now();
    hal_restore(before);
    if (moving) {
        found = remain ? behind(skipped(remain), hint) : slower(least_behind(ticks), hint);
        before = hal_hold();
        hint = found;
        hal_restore(before);
    }
}

static uint8_t choose_entry(void)
{
    const struct tail_entry *next = entry;

    if (next == tail_end)
        return 0;
    chosen = (uint16_t)(next->up_to - next[-1].up_to);
    entry++;
    interval.fraction = (uint16_t)((uint16_t)(uint8_t)next->interval << 8);
    interval.tick = next->interval >> 8;
    hal_advance();
    return 1;
}

static uint8_t choose_longer(void)
{
    pace += pace >> 4;
    if (pace > config.start_stop)
        return 0;
    interval.fraction = 0;
    interval.tick = pace;
    chosen = 1;
    hal_advance();
    return 1;
}

void account(void)
{
    count = left = chosen;
    if (down)
        end -= chosen;
    else
        end += chosen;
    mode = (uint8_t)((has_phases ? PHASES : 0) | (mode & HOP));
    if (interval.tick >= LONG_LEAST)
        mode |= LONG;
}

/* From the last step, at `last`, choose the first piece, or return 0 if there is nothing to play. */
static uint8_t choose_first(void)
{
    if (!paced || pace >= config.start_stop)
        return 0;
    due.fraction = 0;
    due.tick = last;
    if (is_tail_fresh())
        settle_tail();
    if (!tail_count)
        return choose_longer();
    entry = slower(least_behind(pace), hint);
    return choose_entry();
}

uint8_t goes_down_from_pause(uint32_t tick)
{
    if (!choose_first())
        return 0;
    if ((int32_t)(due.tick - tick) < (int32_t)SOONEST_TICKS)
        due.tick = tick + SOONEST_TICKS;
    mode &= (uint8_t)~PAUSE;
    set_state(STATE_BRAKE);
    return 1;
}

/* The next step may occur while interrupts are off here, without enough time to choose the one after it.  So if
   steps are that fast, output one more.  Return whether this is so. */
static inline uint8_t makes_one_more(void)
{
    if (left > 1)
        return interval.tick < FAST_TICKS;
    return queued && !(out->flags & RECORD_PAUSE) && !((out->flags ^ down) & RECORD_DOWN) && out->interval < FAST_TICKS;
}

uint8_t begins_brake(void)
{
    if (state != STATE_RUN || mode & PAUSE)
        return 0;
    state = STATE_BRAKE; /* the light is on already */
    if (makes_one_more()) {
        mode |= ONE_MORE;
        follows = left == 1;
    } else {
        mode |= BRAKING;
        follows = 0;
    }
    hal_show_in_time(phases_due);
    return 1;
}

void brake(uint8_t happening, uint8_t which, uint32_t tick)
{
    if (begins_brake()) {
        ;
    } else if (state == STATE_RUN && goes_down_from_pause(tick)) {
        hal_aim_anew(tick);
        account();
    } else {
        halt();
    }
    note(happening, which, tick);
}

/* The first piece has been chosen: `entry`, and `interval` to its first step.  Do the rest. */
static void begin_ramp(uint16_t steps_before)
{
    follows = 0;
    left--;
    last = due.tick;
    due.fraction = 0;
    hal_advance();
    hal_show_in_time(phases_due);
    place(position_now());
    pace = interval.tick;
    chosen = tail_count ? (uint16_t)(entry->up_to - steps_before) : 1;
    entry++;
    account();
    hal_show_in_time(phases_due);
    if (interval.tick < LONG_LEAST)
        look_back();
    else
        aim(last);
}

static __attribute__((noinline)) uint8_t ramp_down_uninterrupted(void)
{
    uint32_t ticks = due.tick - last;
    uint16_t remain = 1, before = 0;
    uint8_t fraction = 0, plays = stepped || left != count;
    const struct tail_entry *first = hint;

    if (is_tail_fresh())
        settle_tail();
    if (flags & RECORD_RAMP_LEFT && !(remain = ramp_left_now()))
        plays = 0;
    if (!plays) {
        ;
    } else if (flags & RECORD_RAMP_LEFT && tail_count) {
        before = skipped(remain);
        first = behind(before, first);
        ticks = least_behind(ticks);
    } else if (ticks >= config.start_stop) {
        plays = 0;
    } else if (tail_count) {
        ticks = least_behind(ticks);
        first = slower(ticks, first);
        before = first[-1].up_to;
        plays = first != tail_end;
    } else {
        ticks += ticks >> 4;
        plays = ticks <= config.start_stop;
    }
    hal_end_pulse();
    if (!plays) {
        left--;
        last = due.tick;
        place(position_now());
        return 0;
    }
    if (tail_count && ticks <= first->interval >> 8) { /* never faster than before */
        ticks = first->interval >> 8;
        fraction = (uint8_t)first->interval;
    }
    if (ticks < LONG_LEAST)
        hal_arm((uint16_t)(due.tick + ticks));
    interval.fraction = (uint16_t)((uint16_t)fraction << 8);
    interval.tick = ticks;
    entry = first;
    begin_ramp(before);
    return 1;
}

uint8_t go_down(void)
{
    if (!begun)
        return ramp_down_uninterrupted();
    begun = 0;
    begin_ramp(flags & RECORD_RAMP_LEFT ? skip : entry[-1].up_to);
    return 1;
}

void play_piece(void)
{
    const struct tail_entry *next = entry;
    uint8_t fraction = 0;

    if (!tail_count) {
        pace += pace >> 4;
        interval.tick = pace;
    } else if (next != tail_end) {
        interval.tick = next->interval >> 8;
        fraction = (uint8_t)next->interval;
        if (interval.tick < pace) {
            interval.tick = pace;
            fraction = 0;
        }
    }
    hal_end_pulse();
    if (tail_count ? next == tail_end : pace > config.start_stop) {
        left = 0;
        last = due.tick;
        halt();
        note(EVENT_HALTED, HOST, last);
        return;
    }
    interval.fraction = (uint16_t)((uint16_t)fraction << 8);
    if (interval.tick < LONG_LEAST) {
        uint8_t past = (uint8_t)(due.fraction >> 8);

        hal_arm((uint16_t)((uint16_t)due.tick + (uint16_t)interval.tick + ((uint8_t)(past + fraction) < past)));
    }
    last = due.tick;
    hal_advance();
    chosen = tail_count ? (uint16_t)(next->up_to - next[-1].up_to) : 1;
    entry = next + 1;
    account();
    hal_show_in_time(phases_due); /* after a piece of one step, the next step happens during this work */
    if (interval.tick < LONG_LEAST)
        look_back();
    else
        aim(last);
}
