/* Records become steps.
 *
 * The timer makes the edge, by itself, at the tick that stands in OCR1A; the interrupt behind it ends the pulse and
 * prepares the next one.  `due` is that next instant, `interval` what is added to it there.  The ordinary step of a
 * record is done by interrupts.S; match() below does all that a step can need, and is what that one is measured by.
 */
#include <avr/io.h>

#include "clock.h"
#include "events.h"
#include "inputs.h"
#include "motion.h"
#include "outputs.h"
#include "pins.h"
#include "protocol.h"
#include "wire.h"

#define HOP_TICKS 32768u
#define DIRECT_MOST 49152u /* more than this is hopped towards: what remains is never close */
#define LONG_LEAST 32768u

volatile uint8_t state;
uint8_t down;
static uint32_t start_stop;
struct tail_entry tail_table[TAIL_MOST + 2]; /* before the entries one of 0, behind them one that is longer than any */
volatile uint8_t tail_count;
volatile uint8_t queued;

/* These are shared with interrupts.S. */
volatile uint8_t mode = STILL;
struct instant due;
struct instant interval;
int32_t add;
uint32_t last; /* tick of the last step */
uint16_t left;
uint8_t phase_step;

struct record queue[SLOTS];
struct record *out = queue; /* the next one to play */
uint16_t count;             /* steps of the record; in a pause the word with mask and value */
uint8_t flags;              /* of the record */
int32_t end;
uint8_t armed = DISARMED;
uint8_t stepped;            /* there is a last step that a pace may count from */
uint16_t way;               /* steps of a way down from the first step of the record, if it has one */
int8_t way_slope;           /* and how many more from each next one: -1, 0, 1 */

static struct record *in = queue; /* where the main loop writes */
static struct record *prepared;   /* behind what it has written */
static uint32_t far;              /* ticks from the next hop to `due` */
static uint8_t paced;             /* there have been two */
static uint32_t pace;             /* ticks between them, as of the end of a record */
uint8_t follows;                  /* behind a record comes the next one */
static uint8_t overdue; /* the end of a pause has passed by unseen */

const struct tail_entry *tail_end = TAIL_ENTRIES; /* behind the last entry */
const struct tail_entry *entry;                   /* the one that comes next */
const struct tail_entry *hint = TAIL_ENTRIES;     /* that of the present pace, as of the last turn of the main loop */
uint8_t quick; /* interrupts.S may begin a way down where steps are fast: there is a table, and it is in its place */
uint8_t begun; /* it has begun one: the first entry is in `entry`, how far its first step is in `interval`, */
uint16_t skip; /* and, if the record has a way, how many steps of the table come before that one here */

void place(int32_t position)
{
    end = position;
    left = 0;
}

void set_state(uint8_t new_state)
{
    state = new_state;
    follows = new_state == STATE_RUN;
    if (new_state == STATE_IDLE)
        PORTB &= ~_BV(LED_BIT);
    else
        PORTB |= _BV(LED_BIT);
}

void forget_queue(void)
{
    queued = 0;
    out = in;
}

static void stand(uint8_t new_state)
{
    TCCR1A = DISARMED;
    mode = STILL;
    place(position_now());
    set_state(new_state);
}

void halt(void)
{
    stand(STATE_HALT);
    forget_queue();
}

/* What the step that is due does to the phases; until it is made they remain. */
void set_phase_step(void)
{
    uint8_t before = phase - phase_step, step = flags & RECORD_HALF ? 1 : 2;

    phase_step = down ? 8 - step : step;
    phase = (before + phase_step) & 7;
    phases_due = pattern[phase];
}

/* due += interval */
static inline void advance(void)
{
    __asm__ volatile("lds r24, due\n\t"
                     "lds r25, interval\n\t"
                     "add r24, r25\n\t"
                     "sts due, r24\n\t"
                     "lds r24, due+1\n\t"
                     "lds r25, interval+1\n\t"
                     "adc r24, r25\n\t"
                     "sts due+1, r24\n\t"
                     "lds r24, due+2\n\t"
                     "lds r25, interval+2\n\t"
                     "adc r24, r25\n\t"
                     "sts due+2, r24\n\t"
                     "lds r24, due+3\n\t"
                     "lds r25, interval+3\n\t"
                     "adc r24, r25\n\t"
                     "sts due+3, r24\n\t"
                     "lds r24, due+4\n\t"
                     "lds r25, interval+4\n\t"
                     "adc r24, r25\n\t"
                     "sts due+4, r24\n\t"
                     "lds r24, due+5\n\t"
                     "lds r25, interval+5\n\t"
                     "adc r24, r25\n\t"
                     "sts due+5, r24"
                     :
                     :
                     : "r24", "r25", "memory");
}

/* interval += add, and say whether it may need hops. */
static void grow(void)
{
    uint16_t low;

    if (mode & RAMP) {
        low = interval.fraction + (uint16_t)add;
        interval.tick += (int32_t)(int16_t)((uint32_t)add >> 16) + (low < interval.fraction);
        interval.fraction = low;
    }
    mode &= ~LONG;
    if ((uint16_t)(interval.tick >> 16) || (uint16_t)interval.tick >= LONG_LEAST)
        mode |= LONG;
}

void late(void)
{
    uint32_t tick = now();

    halt();
    note(EVENT_LATE, HOST, tick);
}

/* Has the timer gone past what it has just been set to?  Then a step has been made, or never will be; the
   end of a pause can be made up for. */
static void look_back(void)
{
    if ((int16_t)((uint16_t)due.tick - TCNT1) >= 0)
        return;
    if (mode & PAUSE)
        overdue = !(TIFR1 & _BV(OCF1A));
    else if (!is_made())
        late();
}

/* Write to the timer where `due` is, or a hop on the way to it, seen from the tick `from`, which is now or not long ago.
   Return the ticks up to `due`. */
static inline uint32_t set_timer(uint32_t from)
{
    uint32_t ahead = due.tick - from;

    if (ahead > DIRECT_MOST) {
        OCR1A = (uint16_t)from + HOP_TICKS;
        far = ahead - HOP_TICKS;
        mode |= HOP;
    } else {
        OCR1A = due.tick;
        mode &= ~HOP;
    }
    return ahead;
}

/* Set the timer behind a match. */
static void aim(uint32_t from)
{
    uint32_t ahead = set_timer(from);

    if (mode & HOP)
        return;
    if (!(mode & PAUSE))
        TCCR1A = armed;
    if (ahead < HOP_TICKS)
        look_back();
}

/* The same, but not from a match: what was written to the timer before may have come true until now, and must not be
   taken for what is due.  That is SOON ticks away at least, so its flag cannot be lost here. */
static void aim_anew(uint32_t from)
{
    set_timer(from);
    TIFR1 = _BV(OCF1A);
    if (!(mode & (HOP | PAUSE)))
        TCCR1A = armed;
}

static inline void end_pulse(void)
{
    TCCR1A = DISARMED;
    TCCR1C = _BV(FOC1A);
}

/* --------------------------------------------------------------------------------------------------------- the tail */
static struct {
    const struct tail_entry *from;
    uint8_t first;
    uint8_t count;
} fresh; /* entries that are valid and not yet in their places: a frame is too long to be copied in one piece */

static void settle_tail(void)
{
    const struct tail_entry *from = fresh.from;
    uint8_t i;

    for (i = 0; i < fresh.count; i++)
        TAIL_ENTRIES[fresh.first + i] = from[i];
    TAIL_ENTRIES[fresh.first + i].interval = 0xFFFFFFFF;
}

/* Put entries into the table, with interrupts off.  They count from here on: whoever needs the table first puts them
   into their places.  `from` must remain as it is until tail_settled(). */
void take_tail(const struct tail_entry *from, uint8_t first, uint8_t n)
{
    fresh.from = from;
    fresh.first = first;
    fresh.count = n;
    quick = 0;
    tail_count = first + n;
    tail_end = TAIL_ENTRIES + first + n;
    if (hint > tail_end)
        hint = tail_end;
}

/* The same, for the main loop, with interrupts on. */
void tail_settled(void)
{
    settle_tail();
    cli();
    fresh.count = 0;
    quick = start_stop >= FAST_TICKS;
    sei();
}

void set_start_stop(uint32_t ticks)
{
    start_stop = ticks;
    quick = tail_count && ticks >= FAST_TICKS;
}

/* Return the least interval behind one of `ticks`: where steps are fast a longer one, for there is much to do before
   it ends. */
static inline uint32_t least_behind(uint32_t ticks)
{
    return ticks < FAST_TICKS ? (uint16_t)ticks + ((uint16_t)ticks >> 3) : ticks;
}

/* Return the first entry whose interval is longer than `ticks`; entries do not descend, so any place to begin will do. */
static inline const struct tail_entry *slower(uint32_t ticks, const struct tail_entry *at)
{
    uint32_t limit = ticks << 8;

    if (ticks >> 24)
        return tail_end;
    while (at[-1].interval > limit)
        at--;
    while (at->interval <= limit)
        at++;
    return at;
}

/* Return how many steps the table has before those that remain on a way down. */
static inline uint16_t skipped(uint16_t remain)
{
    uint16_t all = tail_end[-1].up_to;

    return all > remain ? all - remain : 0;
}

/* Return the entry with the step that comes behind so many; there is one. */
static inline const struct tail_entry *behind(uint16_t steps, const struct tail_entry *at)
{
    while (at[-1].up_to > steps)
        at--;
    while (at->up_to <= steps)
        at++;
    return at;
}

/* Return how many steps a way down from the step that is due has. */
static inline uint16_t way_now(void)
{
    uint16_t made = count - left;

    return way_slope > 0 ? way + made : way_slope < 0 ? way - made : way;
}

/* Begin where the main loop saw the pace last, or the way down, for a search from one end could last longer than a step
   does. */
void refresh_hint(void)
{
    uint32_t ticks;
    uint16_t remain = 0;
    uint8_t moving;
    const struct tail_entry *found;

    if (!tail_count)
        return;
    cli();
    moving = state == STATE_RUN && !(mode & (PAUSE | STILL));
    ticks = due.tick - last;
    if (flags & RECORD_WAY)
        remain = way_now();
    sei();
    if (moving) {
        found = remain ? behind(skipped(remain), hint) : slower(least_behind(ticks), hint);
        cli();
        hint = found;
        sei();
    }
}
/* The way down.  Here too the timer's part comes first, for a fast step may follow: choose sets `interval`, `due` and
   what OCR1A gets; account does the rest. */
static uint16_t chosen; /* steps of the piece */

static uint8_t choose_entry(void)
{
    const struct tail_entry *next = entry;

    if (next == tail_end)
        return 0;
    chosen = next->up_to - next[-1].up_to;
    entry++;
    interval.fraction = (uint16_t)(uint8_t)next->interval << 8;
    interval.tick = next->interval >> 8;
    advance();
    return 1;
}

static uint8_t choose_longer(void)
{
    pace += pace >> 4;
    if (pace > start_stop)
        return 0;
    interval.fraction = 0;
    interval.tick = pace;
    chosen = 1;
    advance();
    return 1;
}

static void account(void)
{
    count = left = chosen;
    if (down)
        end -= chosen;
    else
        end += chosen;
    mode = (has_phases ? PHASES : 0) | (mode & HOP);
    if (interval.tick >= LONG_LEAST)
        mode |= LONG;
}

/* From the last step, at `last`, choose the first piece of the way down, or return 0 if there is nothing to play. */
static uint8_t choose_first(void)
{
    if (!paced || pace >= start_stop)
        return 0;
    due.fraction = 0;
    due.tick = last;
    if (fresh.count)
        settle_tail();
    if (!tail_count)
        return choose_longer();
    entry = slower(least_behind(pace), hint);
    return choose_entry();
}

/* The same in a pause, or at its end, at `tick`. */
static uint8_t choose_first_from_pause(uint32_t tick)
{
    if (!choose_first())
        return 0;
    if ((int32_t)(due.tick - tick) < (int32_t)SOONEST_TICKS)
        due.tick = tick + SOONEST_TICKS;
    mode &= ~PAUSE;
    return 1;
}

/* The next step may come while interrupts are off here, and then there is no time left to choose one behind it; so where
   steps are that fast, one more is made.  Return whether it is. */
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
    state = STATE_BRAKE; /* the LED is lit already */
    if (makes_one_more()) {
        mode |= ONE_MORE;
        follows = left == 1;
    } else {
        mode |= BRAKING;
        follows = 0;
    }
    show_in_time();
    return 1;
}

void brake(uint8_t happening, uint8_t which, uint32_t tick)
{
    if (begins_brake()) {
        ;
    } else if (state == STATE_RUN) {
        if (choose_first_from_pause(tick)) {
            set_state(STATE_BRAKE);
            aim_anew(tick);
            account();
        } else {
            halt();
        }
    } else {
        halt();
    }
    note(happening, which, tick);
}

/* --------------------------------------------------------------------------------------------------------- the queue */
static struct record *place_in_queue(uint8_t ahead)
{
    struct record *free = in + ahead;

    if (free >= queue + SLOTS)
        free -= SLOTS;
    return free;
}

/* Write a record `ahead` places behind the queue, with what the interrupt wants to know of it at a glance. */
void prepare(uint8_t ahead, const struct record *record)
{
    struct record *free = place_in_queue(ahead);

    *free = *record;
    if (record->add && !(record->flags & (RECORD_PAUSE | RECORD_WAY)))
        free->flags |= RAMP;
    prepared = place_in_queue(ahead + 1);
}

void publish(uint8_t n)
{
    in = prepared;
    queued += n;
}

/* Add the interval of the next record to `due`; the queue is not empty. */
static inline void begin_record(void)
{
    interval.fraction = out->fraction;
    interval.tick = out->interval;
    advance();
}

/* Do the rest that belongs to it. */
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
        /* Who has stood that long may stop at once; a pause may be laid in many pieces. */
        if (due.tick - last >= start_stop)
            stepped = paced = 0;
    } else {
        left = count;
        if (down)
            end -= count;
        else
            end += count;
        if (flags & RECORD_WAY) {
            way = record->add;
            way_slope = record->add >> 16;
        } else {
            add = record->add;
        }
        mode |= (flags & RAMP) | (was_one_more ? BRAKING : 0);
        grow();
    }
    set_phase_step();
    queued--;
    if (++out == queue + SLOTS)
        out = queue;
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
    show_direction(down);
    if (acts_at_load(1))
        act_at_load(tick, 1);
    if (!(mode & STILL))
        aim_anew(present);
}

/* The step of `tick` was the last one of a record or of a piece: remember how fast it came. */
static void remember(uint32_t tick)
{
    if (left != count)
        stepped = 1; /* the record had steps before it */
    left--;
    paced = stepped;
    pace = tick - last;
    stepped = 1;
    last = tick;
}

/* Behind a record, at `tick`, there is another one. */
static void play_next(uint32_t tick)
{
    uint8_t new_flags = out->flags, was_step = !(mode & PAUSE), turns, is_set = 0;

    turns = (new_flags ^ down) & RECORD_DOWN;
    begin_record();
    end_pulse();
    if (!turns && !(new_flags & RECORD_PAUSE) && interval.tick < LONG_LEAST) {
        OCR1A = due.tick;
        TCCR1A = armed;
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
        uint8_t causes = acts_at_load(0);

        show_direction(down);
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

/* The first piece of a way down has been chosen: `entry`, and in `interval` how far its first step is.  Do the rest. */
static void begin_way_down(uint16_t steps_before)
{
    follows = 0;
    left--;
    last = due.tick;
    due.fraction = 0;
    advance();
    show_in_time();
    place(position_now());
    pace = interval.tick;
    chosen = tail_count ? entry->up_to - steps_before : 1;
    entry++;
    account();
    show_in_time();
    if (interval.tick < LONG_LEAST)
        look_back();
    else
        aim(last);
}

/* The step that is due was the last one of its record, or a brake waited for it: begin the way down from it, or return 0
   if there is nothing to play. */
static __attribute__((noinline)) uint8_t go_down_in_peace(void)
{
    uint32_t ticks = due.tick - last;
    uint16_t remain = 1, before = 0;
    uint8_t fraction = 0, plays = stepped || left != count;
    const struct tail_entry *first = hint;

    if (fresh.count)
        settle_tail();
    if (flags & RECORD_WAY && !(remain = way_now()))
        plays = 0;
    if (!plays) {
        ;
    } else if (flags & RECORD_WAY && tail_count) {
        before = skipped(remain);
        first = behind(before, first);
        ticks = least_behind(ticks);
    } else if (ticks >= start_stop) {
        plays = 0;
    } else if (tail_count) {
        ticks = least_behind(ticks);
        first = slower(ticks, first);
        before = first[-1].up_to;
        plays = first != tail_end;
    } else {
        ticks += ticks >> 4;
        plays = ticks <= start_stop;
    }
    end_pulse();
    if (!plays) {
        left--;
        last = due.tick;
        place(position_now());
        return 0;
    }
    if (tail_count && ticks <= first->interval >> 8) { /* never faster than before */
        ticks = first->interval >> 8;
        fraction = first->interval;
    }
    if (ticks < LONG_LEAST) {
        OCR1A = (uint16_t)due.tick + (uint16_t)ticks;
        TCCR1A = armed;
    }
    interval.fraction = (uint16_t)fraction << 8;
    interval.tick = ticks;
    entry = first;
    begin_way_down(before);
    return 1;
}

static __attribute__((noinline)) uint8_t go_down(void)
{
    if (!begun)
        return go_down_in_peace();
    begun = 0;
    begin_way_down(flags & RECORD_WAY ? skip : entry[-1].up_to);
    return 1;
}

/* On the way down, behind a piece of it: the next one, with the timer's part first, or the end. */
static __attribute__((noinline)) void play_piece(void)
{
    const struct tail_entry *next = entry;
    uint16_t ticks;
    uint8_t fraction = 0;

    if (!tail_count) {
        pace += pace >> 4;
        interval.tick = pace;
    } else if (next != tail_end) {
        interval.tick = next->interval >> 8;
        fraction = next->interval;
        if (interval.tick < pace) {
            interval.tick = pace;
            fraction = 0;
        }
    }
    end_pulse();
    if (tail_count ? next == tail_end : pace > start_stop) {
        left = 0;
        last = due.tick;
        halt();
        note(EVENT_HALTED, HOST, last);
        return;
    }
    interval.fraction = (uint16_t)fraction << 8;
    if (interval.tick < LONG_LEAST) {
        uint8_t past = due.fraction >> 8;

        ticks = (uint16_t)interval.tick + ((uint8_t)(past + fraction) < past);
        OCR1A = (uint16_t)due.tick + ticks;
        TCCR1A = armed;
    }
    last = due.tick;
    advance();
    show_in_time(); /* behind a piece of one step the next one comes while this is done */
    chosen = tail_count ? next->up_to - next[-1].up_to : 1;
    entry = next + 1;
    account();
    if (interval.tick < LONG_LEAST)
        look_back();
    else
        aim(last);
}

/* Behind a record, at `tick`: the next one; behind a pause without one: the end, or the way down. */
static __attribute__((noinline)) void go_on(uint32_t tick)
{
    uint8_t plays;

    if (queued && (state == STATE_RUN || mode & ONE_MORE)) {
        play_next(tick);
    } else {
        if (flags & RECORD_REST) {
            stand(STATE_IDLE);
            note(EVENT_REST, HOST, tick);
            return;
        }
        plays = choose_first_from_pause(tick);
        if (plays) {
            set_state(STATE_BRAKE);
            aim(tick);
            account();
        } else {
            halt();
        }
        note(EVENT_UNDERRUN, HOST, tick);
    }
}

/* --------------------------------------------------------------------------------------------------------- the match */
static void hop(void)
{
    if (far > DIRECT_MOST) {
        OCR1A += HOP_TICKS;
        far -= HOP_TICKS;
        return;
    }
    OCR1A = due.tick;
    mode &= ~HOP;
    if (!(mode & PAUSE))
        TCCR1A = armed;
}

static __attribute__((noinline)) void ordinary_step(void)
{
    uint32_t tick = due.tick;

    left--;
    last = tick;
    advance();
    end_pulse();
    aim(tick);
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

static __attribute__((noinline)) void match_in_peace(void)
{
    do {
        uint8_t was = mode;

        overdue = 0;
        if (was & STILL)
            return;
        if (was & HOP) {
            hop();
        } else {
            if (was & PAUSE && flags & RECORD_OUT) {
                set_outputs(count >> 8, count);
                serve_line();
            }
            go_on(due.tick);
        }
        if (overdue)
            serve_line(); /* short pauses in a row */
    } while (overdue);
}

/* Do what follows from a match; interrupts are off.  The phases of a step are there already.  What may be followed by a
   fast step goes its own way, with as little as possible to be saved before it. */
void match(void)
{
    uint8_t was = mode;

    if (was & (STILL | HOP | PAUSE))
        match_in_peace();
    else if (was & BRAKING)
        brake_at_step();
    else if (left != 1)
        ordinary_step();
    else if (state == STATE_BRAKE && !(was & ONE_MORE))
        play_piece();
    else if (!queued)
        underrun();
    else
        match_in_peace();
}
