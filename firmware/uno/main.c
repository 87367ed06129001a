/* A stepper board that plays what it is told to the cycle, stops by itself and keeps count.
 *
 * This is no safety device: an emergency stop cuts the driver's power; the board only keeps the count.
 *
 *   interrupts.S   every step, each byte, each edge of an input: short, by hand
 *   motion.c       records, the way down, the queue: what a match of the timer needs beyond the ordinary step
 *   inputs.c       reflexes
 *   power.c        who switches the driver on and off
 *   commands.c     what a frame does, at which instant, and what it is answered
 *   wire.c         bytes become frames, and the reverse
 *   events.c, outputs.c, clock.h, pins.h, protocol.h
 */
#include <avr/interrupt.h>
#include <avr/io.h>

#include "clock.h"
#include "commands.h"
#include "events.h"
#include "inputs.h"
#include "motion.h"
#include "outputs.h"
#include "pins.h"
#include "protocol.h"
#include "wire.h"

volatile uint16_t overflows; /* of timer 1: the high half of a tick, see clock.h */

int main(void)
{
    set_up_outputs();
    set_state(STATE_BOOT);
    TCCR1A = DISARMED;
    TCCR1B = _BV(CS10); /* from here on ticks are counted */
    TIFR1 = 0xFF;
    TIMSK1 = _BV(OCIE1A) | _BV(TOIE1); /* never masked: what stands still is told by `mode` */
    set_up_inputs();
    set_up_wire();
    note(EVENT_BOOT, HOST, now());
    sei();
    for (;;) {
        int8_t verdict = listen();

        if (verdict > 0)
            take_frame();
        else if (verdict < 0)
            take_damage();
        tell_events();
        refresh_hint();
        watch_for_silence();
        refresh_lamps();
    }
}
