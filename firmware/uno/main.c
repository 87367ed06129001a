/* A stepper board that plays records exact to the cycle, stops on its own and keeps count.
 *
 * This is not a safety device: an emergency stop must cut the driver's power; the board only keeps the count.
 *
 *   step.S             every step: short, by hand
 *   stop_ramp.S        the first step of a stop ramp, where steps are fast
 *   inputs_and_line.S  each byte, each edge of an input
 *   board.h            functions that ../common needs of the processor; pins.h, serial.c, self_test.c
 */
#include "hal.h"
#include "protocol.h"
#include "queue.h"
#include "rounds.h"
#include "serial.h"

_Static_assert(sizeof(struct record) == RECORD_BYTES, "step.S knows its fields");

volatile uint16_t overflows;
uint8_t armed = DISARMED;
uint32_t far;

static void set_up_timer(void)
{
    TCCR1A = DISARMED;
    TCCR1B = _BV(CS10); /* from here on ticks are counted */
    TIFR1 = 0xFF;
    TIMSK1 = _BV(OCIE1A) | _BV(TOIE1); /* never masked: `mode` has a bit for nothing due */
}

static void set_up_inputs(void)
{
    PORTC = INPUTS_MASK; /* pull-ups: a broken wire reads high */
    PCMSK1 = INPUTS_MASK;
    PCICR = _BV(PCIE1); /* an edge from now on is in the flag */
}

int main(void)
{
    /* STEP and DIR low; the others remain inputs until CONFIG, so their loads do not switch when power returns. */
    DDRB = _BV(STEP_BIT) | _BV(DIR_BIT) | _BV(LED_BIT);
    hal_set_light(1);
    set_up_timer();
    set_up_inputs();
    set_up_serial();
    power_up();
    sei();
    for (;;)
        round_once();
}
