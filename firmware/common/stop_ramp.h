/* The stop ramp: the end of a motion that is stopped, or whose queue underruns. */
#ifndef STOP_RAMP_H
#define STOP_RAMP_H

#include <stdint.h>

/* All of these but the last are called held. */

/* Begin to brake if steps are played; then only the event remains to be recorded. */
uint8_t begins_brake(void);

void brake(uint8_t happening, uint8_t which, uint32_t tick);

/* In a pause, or at its end, at `tick`: begin, if there is a stop ramp.  The caller sets the timer. */
uint8_t goes_down_from_pause(uint32_t tick);
void account(void); /* then do the rest: the steps of the chosen piece */

/* At the last step of a record, or at the step for which a brake waited: begin, if there is a stop ramp. */
uint8_t go_down(void);

void play_piece(void); /* at the last step of a piece: the next piece, or the end */

/* For the main loop: find the entry for the present pace, because a search from one end of the table could take
   longer than a step. */
void refresh_hint(void);

#endif
