/* Pulses on STEP, counted at T0 if it is wired to STEP. */
#include "hal.h"
#include "protocol.h"
#include "state.h"

uint16_t hal_count_pulses(uint16_t pulses, uint16_t apart)
{
    uint8_t directions = DDRD;
    uint16_t counted = 0, i;
    uint8_t seen = 0;
    uint32_t tick, next;

    DDRD = directions & ~_BV(COUNTER_BIT);
    TCNT0 = 0;
    TCCR0B = _BV(CS02) | _BV(CS01) | _BV(CS00); /* rising edges at T0 */
    cli();
    next = hal_now();
    sei();
    for (i = 0; i < pulses && state == STATE_IDLE; i++) {
        next += apart;
        do {
            cli();
            tick = hal_now();
            sei();
        } while ((int32_t)(tick - next) < 0);
        cli(); /* input sampling cannot arm a step, but it disarms */
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
    return counted;
}
