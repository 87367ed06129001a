/* Execution of a motion: a sample of the inputs just before each step, then the step.
 *
 *     CLOCK   ~~~~|_|~~~~~~~~~~~~~|_|~~~~~~      a step is the falling edge; low for 1.7 us
 *                 b               b'             ENABLE, Z and the switches of a homing: levels before b
 *     MOV     _|~~~~~~~~~~~~~~~~~~~~|______      rises with DIR, 10 us before the first step; falls with the last pulse
 *
 * A step held by ENABLE is not lost: the profile is counted in steps, so it waits and continues from there (pin 24).
 */
#ifndef MOTION_H
#define MOTION_H

#include "gsc200.h"

/* Begin a planned motion: 1 clockwise, -1 counter-clockwise. */
void begin_motion(struct gsc *g, int8_t direction, bool is_endless);

/* Begin a homing towards EOT.  Return whether it is already complete. */
bool begin_homing(struct gsc *g, int8_t direction, uint16_t speed);

/* Process the timer of the run, or a changed input.  Return whether the motion has ended. */
bool motion_timed(struct gsc *g);
bool motion_settled(struct gsc *g);

/* K: output no further step.  Return the end of the pulse in progress; then end the motion. */
gsc_time kill_motion(struct gsc *g);
void end_motion(struct gsc *g);

bool is_step_ahead(const struct gsc *g);

/* Steps to the end of the position counter in a direction, or OPEN. */
uint32_t room_ahead(const struct gsc *g, int8_t direction);

#endif
