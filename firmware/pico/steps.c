#include "steps.h"

#include <stdbool.h>

#include "pins.h"
#include "pio_code.h"
#include "registers.h"

/* The program, by its places.  A word is the rest of the interval after PULSE and REST, so it may arrive as
   late as 80 us after the previous step. */
enum { GET, COUNT = 2, LOOK, HOLD = 5, RELEASED = 8, GO = 12, END_OF_PULSE = 15, FLAG, REST = 18 };
static const uint16_t PROGRAM[] = {
    [GET] = PULL,
    [1] = MOV_X_OSR,
    [COUNT] = JMP_X_AND_COUNT(COUNT),
    [LOOK] = JMP_PIN(GO),
    [4] = MOV_X_ONES,
    [HOLD] = JMP_PIN(RELEASED),
    [6] = JMP_X_AND_COUNT(HOLD),
    [7] = JMP(HOLD),
    [RELEASED] = IN_X(32), /* reported */
    [9] = SET_X(31),
    [10] = JMP_X_AND_COUNT(10) | DELAY(19),
    [11] = JMP(LOOK) | DELAY(13),
    [GO] = SET_PINS(0),
    [13] = SET_X(31) | DELAY(30),
    [14] = JMP_X_AND_COUNT(14) | DELAY(5),
    [END_OF_PULSE] = SET_PINS(1), /* 224 cycles after GO: 1.697 us */
    [FLAG] = IRQ_SET(0),
    [17] = MOV_X_Y,
    [REST] = JMP_X_AND_COUNT(REST),
};
enum {
    REST_COUNT = 10300,
    BETWEEN = REST_COUNT + 232, /* cycles from a step to the next with a word of 0 */
    BEFORE_FIRST = 5,           /* from the write of a word to the step, with a word of 0 */
    HELD_TO_STEP = 657,         /* from the report of a release to the step */
    HELD_FIRST = 2,             /* from the instant of the step to the report, if it was held for one sample */
    RELEASE = 5 * US,           /* from ENABLE to the step, pin 24: GSC-UND-ENABLE-LATENCY */
    SOON = 200                  /* cycles within which a first word is certainly written */
};

static bool armed;
static volatile bool stopped; /* by steps_stop_now() */
static bool in_motion;        /* a step of this motion has been armed */
static uint64_t origin;       /* an instant of the part, and the corresponding cycle of the pin */
static cycles origin_at;
static cycles at, last_at;    /* of the armed step, of the previous one */
static volatile bool made, released;
static volatile uint32_t count;
static uint32_t late;

void steps_start(void)
{
    CLEAR(PIO_CTRL(PIO0)) = 1;
    for (unsigned place = 0; place < sizeof PROGRAM / sizeof *PROGRAM; place++)
        PIO_MEMORY(PIO0, place) = PROGRAM[place];
    PIO_EXECCTRL(PIO0, 0) = WRAP(GET, REST) | (uint32_t)PIN_ENABLE << 24;
    PIO_SHIFTCTRL(PIO0, 0) = 3u << 18 | 1u << 16; /* a report is pushed by itself */
    PIO_PINCTRL(PIO0, 0) = 1u << 26 | (uint32_t)PIN_CLOCK << 5;
    PIO_INSTR(PIO0, 0) = SET_PINS(1);
    PIO_INSTR(PIO0, 0) = SET_DIRECTIONS(1);
    PIO_TX(PIO0, 0) = REST_COUNT;
    PIO_INSTR(PIO0, 0) = PULL;
    PIO_INSTR(PIO0, 0) = MOV_Y_OSR;
    PIO_INSTR(PIO0, 0) = JMP(GET);
    PIO_INTE(PIO0) = 1 << 8 | 1;
    SET(PIO_CTRL(PIO0)) = 1;
}

static void move_origin(void) /* by a whole multiple of the common period of both counts */
{
    origin += 250000ull << 16;
    origin_at += 33ull << 16;
}

void steps_arm(uint64_t instant, cycles soonest)
{
    const bool is_first = !in_motion;
    if (is_first) {
        origin = instant;
        origin_at = clock_cycle(instant);
        in_motion = true;
    }
    while (instant - origin > 250000ull << 16)
        move_origin();
    at = origin_at + clock_of_ps(instant - origin);
    armed = true;
    made = released = false;
    hold();
    const cycles now = clock_now();
    if (is_first || PIO_ADDR(PIO0, 0) == GET) {
        cycles least = now + SOON;
        if (soonest > least)
            least = soonest;
        if (at < least) {
            if (!is_first)
                late++;
            origin_at += least - at;
            at = least;
        }
        PIO_INSTR(PIO0, 0) = JMP(GET);
        clock_write_after(&PIO_TX(PIO0, 0), (uint32_t)(at - now) - BEFORE_FIRST);
    } else {
        uint32_t word = (uint32_t)(at - last_at) - BETWEEN;
        if (word >> 31) {
            late++;
            word = 0;
        }
        PIO_TX(PIO0, 0) = word;
    }
    let_go();
}

unsigned steps_disarm(void)
{
    if (!armed && !stopped)
        return 0;
    hold();
    CLEAR(PIO_CTRL(PIO0)) = 1;
    const uint32_t place = PIO_ADDR(PIO0, 0);
    const bool waits = !(PIO_FSTAT(PIO0) & 1u << 24); /* its word has not been taken */
    const bool is_made = armed && !waits && (made || (PIO_IRQ(PIO0) & 1) || (place > GO && place <= FLAG));
    if (!is_made) {
        if (waits)
            PIO_INSTR(PIO0, 0) = PULL;
        if (place < GO || place > FLAG) /* no pulse is cut short, and a hold is not part of an interval */
            PIO_INSTR(PIO0, 0) = JMP(GET);
        armed = false;
    }
    SET(PIO_CTRL(PIO0)) = 1;
    stopped = false;
    let_go();
    return is_made;
}

void steps_end_motion(void)
{
    in_motion = false;
}

enum step_state steps_look(void)
{
    if (!armed)
        return STEP_NONE;
    if (released)
        return STEP_RELEASED;
    if (made)
        return STEP_MADE;
    const uint32_t place = PIO_ADDR(PIO0, 0);
    return place > LOOK && place < RELEASED ? STEP_HELD : STEP_COMING;
}

cycles steps_at(void)
{
    return armed ? at : last_at;
}

uint64_t steps_released_at(void)
{
    at += HELD_FIRST + 2ull * (uint32_t)~count + HELD_TO_STEP;
    while (at - RELEASE - origin_at > 33ull << 16)
        move_origin();
    return origin + clock_ps_of(at - RELEASE - origin_at); /* a release is never earlier than the first due step */
}

void steps_go_on(uint64_t instant)
{
    origin = instant;
    origin_at = at;
    hold();
    released = false;
    let_go();
}

void steps_take(void)
{
    last_at = at;
    armed = false;
    made = false;
}

uint32_t steps_late(void)
{
    return late;
}

bool steps_is_news(void)
{
    return made || (released && armed);
}

void steps_interrupt(void)
{
    if (!(PIO_FSTAT(PIO0) & 1u << 8)) {
        count = PIO_RX(PIO0, 0);
        released = true;
    }
    if (PIO_IRQ(PIO0) & 1) {
        PIO_IRQ(PIO0) = 1;
        made = true;
    }
}

bool steps_are_stopped(void)
{
    return stopped;
}

void steps_stop_now(void)
{
    CLEAR(PIO_CTRL(PIO0)) = 1;
    if (PIO_ADDR(PIO0, 0) >= GO)
        SET(PIO_CTRL(PIO0)) = 1; /* a pulse ends in time; the next step is 80 us away */
    stopped = true;
}
