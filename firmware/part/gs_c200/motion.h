/* How a motion is made: a sample of the inputs just before each step, then the step.
 *
 *     CLOCK   ~~~~|_|~~~~~~~~~~~~~|_|~~~~~~      a step is the falling edge; low for 1.7 us
 *                 b               b'             ENABLE, Z and the switches of a homing: as they were before b
 *     MOV     _|~~~~~~~~~~~~~~~~~~~~|______      up with DIR, 10 us before the first step; down with the last pulse
 *
 * A step that ENABLE holds is not lost: the profile goes by steps, so it waits, and goes on where it was (pin 24).
 */
#ifndef MOTION_H
#define MOTION_H

#include "gsc200.h"

/* Begin a motion that has been planned: 1 clockwise, -1 counter-clockwise. */
void begin_motion(struct gsc *g, int8_t direction, bool is_endless);

/* Begin a homing towards EOT.  Return whether it is over already. */
bool begin_homing(struct gsc *g, int8_t direction, uint16_t speed);

/* The timer of the run has come, or an input has changed.  Return whether the motion is over. */
bool motion_timed(struct gsc *g);
bool motion_settled(struct gsc *g);

/* K: make no further step.  Return when the pulse in progress is over; then let it end. */
gsc_time kill_motion(struct gsc *g);
void end_motion(struct gsc *g);

bool is_step_ahead(const struct gsc *g);

/* Steps to the end of the position counter in a direction, or OPEN. */
uint32_t room_ahead(const struct gsc *g, int8_t direction);

#endif
