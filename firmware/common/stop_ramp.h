/* The stop ramp: how a motion ends that is stopped, or whose records have run out. */
#ifndef STOP_RAMP_H
#define STOP_RAMP_H

#include <stdint.h>

/* All of these but the last are called held. */

/* Begin to brake if steps are played; then only the event is left to be noted. */
uint8_t begins_brake(void);

void brake(uint8_t happening, uint8_t which, uint32_t tick);

/* In a pause, or at its end, at `tick`: begin, if there is a stop ramp.  The timer is for the caller. */
uint8_t goes_down_from_pause(uint32_t tick);
void account(void); /* then do the rest: the steps of the piece that has been chosen */

/* At a step that was the last one of its record, or that a brake waited for: begin, if there is a stop ramp. */
uint8_t go_down(void);

void play_piece(void); /* at the last step of a piece: the next piece, or the end */

/* For the main loop: find the entry that belongs to the present pace, for a search from one end of the table could last
   longer than a step does. */
void refresh_hint(void);

#endif
