/* An Arduino Uno or Nano for ../common/hal.h: ATmega328P at 16 MHz; a tick is a cycle of its processor. */
#ifndef BOARD_H
#define BOARD_H

#include <avr/interrupt.h>
#include <avr/io.h>
#include <util/crc16.h>
#include <util/delay_basic.h>

#include "limits.h"
#include "pins.h"
#include "protocol.h"
#include "sizes.h"

/* --------------------------------------------------------------------------------------------------------- the time */
extern volatile uint16_t overflows; /* of timer 1, the high half of a tick: counted in inputs_and_line.S */

static inline uint32_t hal_now(void)
{
    uint16_t low = TCNT1;
    uint16_t high = overflows;

    /* An overflow that has not been counted yet, unless it came after the reading. */
    if ((TIFR1 & _BV(TOV1)) && !(low & 0x8000))
        high++;
    return (uint32_t)high << 16 | low;
}

static inline uint32_t hal_enter(void)
{
    uint32_t tick;

    for (;;) {
        cli();
        tick = hal_now();
        if (!(TIFR1 & _BV(OCF1A)))
            return tick;
        sei();
        __asm__ volatile("nop"); /* after sei one instruction is run before an interrupt */
    }
}

static inline void hal_leave(void)
{
    sei();
}

static inline uint8_t hal_hold(void)
{
    uint8_t before = SREG;

    cli();
    return before;
}

static inline void hal_restore(uint8_t before)
{
    SREG = before;
    __asm__ volatile("" : : : "memory");
}

/* -------------------------------------------------------------------------------------------------------- the steps */
/* Action of OC1A at the match of a step: it rises, or, in a dry run, remains low. */
extern uint8_t armed;
extern uint32_t far; /* ticks from the next hop to `due` */

#define HOP_TICKS 32768u
#define DIRECT_MOST 49152u /* longer times use hops, so the rest is never short */

static inline void hal_advance(void)
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

/* Set the timer to `due`, or to a hop towards it, from the tick `from`.  Return the ticks up to `due`. */
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

static inline uint8_t hal_aim(uint32_t from)
{
    uint32_t ahead = set_timer(from);

    if (mode & HOP)
        return 0;
    if (!(mode & PAUSE))
        TCCR1A = armed;
    return ahead < HOP_TICKS;
}

/* A match set earlier may have happened by now. */
static inline void hal_aim_anew(uint32_t from)
{
    set_timer(from);
    TIFR1 = _BV(OCF1A);
    if (!(mode & (HOP | PAUSE)))
        TCCR1A = armed;
}

static inline void hal_hop(void)
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

static inline void hal_arm(uint16_t tick)
{
    OCR1A = tick;
    TCCR1A = armed;
}

static inline void hal_stop(void)
{
    TCCR1A = DISARMED;
}

static inline void hal_end_pulse(void)
{
    TCCR1A = DISARMED;
    TCCR1C = _BV(FOC1A);
}

/* The prepared match of a step has passed: STEP, or in a dry run the flag, shows whether the step was output. */
static inline uint8_t is_made(void)
{
    return PINB & _BV(STEP_BIT) || (armed == DISARMED && TIFR1 & _BV(OCF1A));
}

static inline uint8_t hal_is_missed(void)
{
    if ((int16_t)((uint16_t)due.tick - TCNT1) >= 0)
        return 0;
    return mode & PAUSE ? !(TIFR1 & _BV(OCF1A)) : !is_made();
}

static inline uint8_t hal_disarm(void)
{
    /* A match may happen until the next line has run; then STEP is high and the step counts. */
    TCCR1A = DISARMED;
    __asm__ volatile("nop\n\tnop"); /* PINB is a cycle and a half old */
    if (is_made())
        return 1;
    TIFR1 = _BV(OCF1A);
    return 0;
}

static inline void hal_set_dry(uint8_t is_dry)
{
    armed = is_dry ? DISARMED : RISING;
}

/* --------------------------------------------------------------------------------------------------------- the pins */
#define HAL_PHASES(pattern) ((uint8_t)((pattern) << 4)) /* the high half of PORTD */

static inline uint8_t hal_levels(void)
{
    return PINC & INPUTS_MASK;
}

static inline void hal_wait_between_looks(void)
{
    _delay_loop_2(16); /* loops of 4 cycles */
}

/* Written by sbi and cbi, because the main loop and interrupts write pins of the same ports. */
#define WRITE(port, bit, level)                                                                                        \
    do {                                                                                                               \
        if (level)                                                                                                     \
            port |= _BV(bit);                                                                                          \
        else                                                                                                           \
            port &= ~_BV(bit);                                                                                         \
    } while (0)

static inline void hal_set_output(uint8_t number, uint8_t level)
{
    if (number == 0)
        WRITE(PORTD, OUT0_BIT, level);
    else if (number == 1)
        WRITE(PORTD, OUT1_BIT, level);
    else if (number == 2)
        WRITE(PORTB, OUT2_BIT, level);
    else
        WRITE(PORTB, OUT3_BIT, level);
}

static inline uint8_t hal_outputs(void)
{
    uint8_t shown = 0;

    if (PORTD & _BV(OUT0_BIT))
        shown |= 1;
    if (PORTD & _BV(OUT1_BIT))
        shown |= 2;
    if (PORTB & _BV(OUT2_BIT))
        shown |= 4;
    if (PORTB & _BV(OUT3_BIT))
        shown |= 8;
    return shown;
}

static inline void hal_set_enable(uint8_t level)
{
    WRITE(PORTB, ENABLE_BIT, level);
}

static inline void hal_set_direction(uint8_t level)
{
    WRITE(PORTB, DIR_BIT, level);
}

static inline void hal_set_light(uint8_t level)
{
    WRITE(PORTB, LED_BIT, level);
}

static inline void hal_set_phases(uint8_t levels)
{
    PORTD = (PORTD & ~PHASES_MASK) | levels;
}

static inline void hal_show_in_time(uint8_t phases)
{
    if (PINB & _BV(STEP_BIT))
        hal_set_phases(phases);
}

static inline void hal_drive(uint8_t has_phases, uint8_t has_enable)
{
    DDRB |= _BV(OUT2_BIT) | _BV(OUT3_BIT);
    if (has_enable) {
        DDRB |= _BV(ENABLE_BIT);
    } else { /* high impedance: the resistor of the driver decides */
        DDRB &= ~_BV(ENABLE_BIT);
        PORTB &= ~_BV(ENABLE_BIT);
    }
    DDRD = (has_phases ? PHASES_MASK : 0) | _BV(OUT0_BIT) | _BV(OUT1_BIT);
}

/* --------------------------------------------------------------------------------------------------------- the line */
/* Rings, with their other ends in inputs_and_line.S. */
extern volatile uint8_t received[RING];
extern volatile uint8_t received_head;
extern uint8_t received_tail;

static inline uint8_t hal_get_byte(uint8_t *byte)
{
    if (received_tail == received_head)
        return 0;
    *byte = received[received_tail];
    received_tail = (received_tail + 1) & (RING - 1);
    return 1;
}

static inline uint16_t hal_crc(uint16_t before, uint8_t byte)
{
    return _crc_ccitt_update(before, byte);
}

void serve_line(void);

static inline void hal_serve_line(void)
{
    serve_line();
}

#endif
