/* The wiring: Arduino Uno or Nano, ATmega328P at 16 MHz. */
#ifndef PINS_H
#define PINS_H

#include <avr/io.h>

#define STEP_BIT PORTB1   /* D9, which is OC1A: the timer raises it, to the cycle */
#define DIR_BIT PORTB2    /* D10 */
#define ENABLE_BIT PORTB3 /* D11: an input, so high impedance, until CONFIG sets its active level */
#define LED_BIT PORTB5    /* D13: lit while the board is not at rest */

#define PHASES_MASK 0xF0 /* D4..D7: phases A..D in the high half of PORTD */
#define COUNTER_BIT PORTD4 /* D4 is T0 as well: CHECK counts STEP there */

#define OUT0_BIT PORTD2 /* D2 */
#define OUT1_BIT PORTD3 /* D3 */
#define OUT2_BIT PORTB0 /* D8 */
#define OUT3_BIT PORTB4 /* D12 */


/* Timer 1 runs freely, a tick per cycle. Actions of OC1A at a match: */
#define RISING (_BV(COM1A1) | _BV(COM1A0)) /* rise: a step is due */
#define DISARMED _BV(COM1A1)               /* fall, that is, remain low */

#endif
