/* Records become steps. */
#ifndef MOTION_H
#define MOTION_H

#include <avr/io.h>
#include <stdint.h>

#include "mode.h"
#include "outputs.h"
#include "pins.h"

/* 1/65536 tick in the low half: 48 bits, little-endian, as interrupts.S adds them. */
struct instant {
    uint16_t fraction;
    uint32_t tick;
};

/* As on the line. */
struct record {
    uint8_t flags;
    uint16_t count;
    uint32_t interval;
    uint16_t fraction;
    int32_t add;
};

/* The interval is in 1/256 tick.  On the line the second field is a count of steps; in the table it is how many there
   are up to the end of the entry. */
struct tail_entry {
    uint32_t interval;
    uint16_t up_to;
};

extern volatile uint8_t state;
extern uint8_t down; /* the record that plays, or the last one that did, goes down */
extern struct tail_entry tail_table[];
#define TAIL_ENTRIES (tail_table + 1)
extern volatile uint8_t tail_count;
extern volatile uint8_t queued;

extern int32_t end; /* position behind the record */
extern uint16_t left; /* steps of the record that have not been made */

/* Return the position; every record knows its end, so the interrupt counts down and nothing else. */
static inline int32_t position_now(void)
{
    return down ? end + left : end - left;
}

/* All of these are called with interrupts off, as that one. */
void place(int32_t position);
void set_state(uint8_t new_state);
void forget_queue(void);
void halt(void);
void set_start_stop(uint32_t ticks); /* the motor may stand behind steps that are so far apart */
void start(uint32_t tick, uint32_t present);
uint8_t begins_brake(void); /* if steps are played; then only the event is left to be noted */
void brake(uint8_t happening, uint8_t which, uint32_t tick);

extern volatile uint8_t mode;

static inline uint8_t is_in_pause(void)
{
    return mode & PAUSE;
}

/* What OC1A does at the match of a step: it rises, or, in a dry run, stays low. */
extern uint8_t armed;

/* The match of a step has been prepared, and has passed: has it been made?  STEP shows it, or in a dry run the flag. */
static inline uint8_t is_made(void)
{
    return PINB & _BV(STEP_BIT) || (armed == DISARMED && TIFR1 & _BV(OCF1A));
}

/* The step that is due may be made while interrupts are off for long: its phases do not wait for the interrupt, which
   ends the pulse. */
static inline void show_in_time(void)
{
    if (PINB & _BV(STEP_BIT))
        PORTD = (PORTD & ~PHASES_MASK) | phases_due;
}

uint32_t first_due(uint32_t tick);
void match(void);
void late(void);
void take_tail(const struct tail_entry *from, uint8_t first, uint8_t n);
extern uint8_t phase_step; /* half steps a step, modulo 8 */
void set_phase_step(void);

/* These are for the main loop. */
void prepare(uint8_t ahead, const struct record *record);
void publish(uint8_t count);
void tail_settled(void);
void refresh_hint(void);

#endif
