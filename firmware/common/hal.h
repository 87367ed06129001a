/* What common code needs of a board.  All of it is in board.h of the board's folder, inline where time is short.
 *
 * Ticks are those of limits.h, modulo 2^32.  "Held": interrupts are off, so no step and no byte is dealt with.
 */
#ifndef HAL_H
#define HAL_H

#include <stdint.h>

#include "due.h"

/* --------------------------------------------------------------------------------------------------------- the time */
static inline uint32_t hal_now(void); /* held */

/* Hold, and return the tick: every match at or before it has been dealt with, none after it has. */
static inline uint32_t hal_enter(void);
static inline void hal_leave(void);

static inline uint8_t hal_hold(void); /* return what hal_restore() needs */
static inline void hal_restore(uint8_t before);

/* ------------------------------------------------------------------------------------------------------- the steps */
static inline void hal_advance(void); /* due += interval */

/* Behind a match, at `from`: let the next one be at `due`; it is a step unless `mode` has PAUSE.  Return whether it is
   so near that it may have passed already. */
static inline uint8_t hal_aim(uint32_t from);

/* The same, but not from a match: `due` is SOONEST_TICKS away at least, and a match from before must not be taken for
   it. */
static inline void hal_aim_anew(uint32_t from);

static inline void hal_hop(void); /* at a match with HOP in `mode`: go on towards `due` */

/* Let the next match be a step at a tick that is less than LONG_LEAST away, by its low half. */
static inline void hal_arm(uint16_t tick);

static inline uint8_t hal_is_missed(void); /* `due` has passed, and no match will come */
static inline void hal_end_pulse(void);
static inline void hal_stop(void); /* no step from here on */

/* Take back the step, or the end of a pause, that is due, held; return 1 if it came nevertheless: then its interrupt
   does what follows from it, as soon as it may. */
static inline uint8_t hal_disarm(void);

static inline void hal_set_dry(uint8_t is_dry); /* the steps of a dry run have no edges */

/* -------------------------------------------------------------------------------------------------------- the pins */
static inline uint8_t hal_levels(void);         /* of the inputs */
static inline void hal_wait_between_looks(void); /* of the filter */
static inline void hal_set_output(uint8_t number, uint8_t level); /* held */
static inline uint8_t hal_outputs(void);                          /* levels of the user outputs' pins */
static inline void hal_set_enable(uint8_t level);                 /* held */
static inline void hal_set_direction(uint8_t level);
static inline void hal_set_phases(uint8_t levels);
static inline void hal_set_light(uint8_t level); /* lit while the board is not at rest */

/* Let pins be outputs: those of the user, of the phases and of ENABLE; one that is no output has no level. */
static inline void hal_drive(uint8_t has_phases, uint8_t has_enable);

/* The step that is due may be made while its interrupt is held for long: show its phases without it. */
static inline void hal_show_in_time(uint8_t phases);

/* -------------------------------------------------------------------------------------------------------- the line */
static inline uint8_t hal_get_byte(uint8_t *byte); /* return whether there was one */
static inline void hal_serve_line(void);           /* where interrupts are off for longer than two bytes last */
void hal_put_byte(uint8_t byte);                   /* waits while there is no room */

static inline uint16_t hal_crc(uint16_t before, uint8_t byte); /* CRC-16/X-25, a byte further */

/* Make pulses on STEP, so many ticks apart, while the board is in IDLE, and return how many came back by a loop. */
uint16_t hal_count_pulses(uint16_t pulses, uint16_t apart);

#include "board.h"

#endif
