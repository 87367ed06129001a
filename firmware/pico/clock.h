/* Time: cycles of 132 MHz since the firmware began, and their conversion to picoseconds of the part.
 *
 * 33 cycles are 250,000 ps exactly.  Both counts have an anchor that advances by whole multiples of that, so a
 * conversion is one product, correct to the nearest cycle, however long the board has been on.
 */
#ifndef CLOCK_H
#define CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "registers.h"
#include "sizes.h"

typedef uint64_t cycles;

void clock_start(void);

/* Return the cycle.  It must be called at least every 60 ms; not by interrupts. */
cycles clock_now(void);

/* Write a number minus the exact cycles since the last clock_now(); interrupts are off. */
void clock_write_after(volatile uint32_t *to, uint32_t number);

/* The time stamp of an interrupt, and its conversion to a cycle, for the last 60 ms. */
static inline uint32_t clock_stamp(void)
{
    return SYSTICK_CVR;
}
cycles clock_of_stamp(uint32_t stamp);

/* Return the nearest number of cycles of a time, and the time of a number of cycles; both are valid up to 200 ms. */
#define CLOCK_FAR_PS 200000000000ull
cycles clock_of_ps(uint64_t ps);
uint64_t clock_ps_of(cycles count);

/* Return the instant of the part that begins with a cycle, and the cycle nearest to an instant; one that is more than
   200 ms away counts as 200 ms away. */
uint64_t clock_instant(cycles at);
cycles clock_cycle(uint64_t instant);

void clock_move_anchor(void); /* every 60 ms at least */

/* Let the processor sleep until a cycle or an interrupt, unless `is_over` returns true with interrupts off. */
void clock_sleep_until(cycles at, bool (*is_over)(void));

#endif
