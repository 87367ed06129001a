/* Ticks of 62.5 ns, modulo 2^32, and instants that are ordered with the steps. */
#ifndef CLOCK_H
#define CLOCK_H

#include <avr/interrupt.h>
#include <stdint.h>

extern volatile uint16_t overflows; /* counted in interrupts.S */

/* Return the time; interrupts are off. */
static inline uint32_t now(void)
{
    uint16_t low = TCNT1;
    uint16_t high = overflows;

    /* An overflow that nobody has counted yet, unless it came behind the reading. */
    if ((TIFR1 & _BV(TOV1)) && !(low & 0x8000))
        high++;
    return (uint32_t)high << 16 | low;
}

/* Turn interrupts off and return an instant: every match at or before it has been dealt with, none after it has. */
static inline uint32_t enter(void)
{
    uint32_t tick;

    for (;;) {
        cli();
        tick = now();
        if (!(TIFR1 & _BV(OCF1A)))
            return tick;
        sei();
        __asm__ volatile("nop"); /* behind sei one instruction is run before an interrupt */
    }
}

static inline void leave(void)
{
    sei();
}

#endif
