/* The table of the stop ramp: entries of a number of steps each, with intervals that never decrease. */
#ifndef TAIL_H
#define TAIL_H

#include <stdint.h>

#include "limits.h"

/* The interval is in 1/256 tick; `up_to`: the number of steps up to the end of the entry. */
struct tail_entry {
    uint32_t interval;
    uint16_t up_to;
};

extern struct tail_entry tail_table[]; /* with an entry of 0 before the first, and a longest entry after the last */
#define TAIL_ENTRIES (tail_table + 1)
extern volatile uint8_t tail_count;
extern const struct tail_entry *tail_end; /* after the last entry */
extern const struct tail_entry *hint;     /* entry of the present pace, at the last round of the main loop */
extern uint8_t quick; /* an interrupt may begin a stop ramp at fast steps: the table is complete */

void tail_configured(void); /* held; after config.start_stop has changed */

/* Put entries of a frame, intervals and counts of steps, into the table, held.  They are valid from here on: the first
   user of the table copies them into it.  `from` must remain unchanged until tail_settled(). */
void take_tail(const uint8_t *from, uint8_t first, uint8_t count);
void tail_settled(void); /* for the main loop */
void settle_tail(void);
uint8_t is_tail_fresh(void);

/* Return the least interval after one of `ticks`: longer at fast steps, because much work must be done before
   it ends. */
static inline uint32_t least_behind(uint32_t ticks)
{
    return ticks < FAST_TICKS ? (uint16_t)((uint16_t)ticks + ((uint16_t)ticks >> 3)) : ticks;
}

/* Return the first entry whose interval is longer than `ticks`; intervals never decrease, so any start is possible. */
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

/* Return the number of table steps before the remaining ones. */
static inline uint16_t skipped(uint16_t remain)
{
    uint16_t all = tail_end[-1].up_to;

    return all > remain ? (uint16_t)(all - remain) : 0;
}

/* Return the entry with the step after the given number; it exists. */
static inline const struct tail_entry *behind(uint16_t steps, const struct tail_entry *at)
{
    while (at[-1].up_to > steps)
        at--;
    while (at->up_to <= steps)
        at++;
    return at;
}

#endif
