/* Functions that common code needs of a board.  All are in board.h of the board's folder, inline if time-critical.
 *
 * Ticks are those of limits.h, modulo 2^32.  "Held": interrupts are off, so no step and no byte is processed.
 */
#ifndef HAL_H
#define HAL_H

#include <stdint.h>

#include "due.h"

/* --------------------------------------------------------------------------------------------------------- the time */
static inline uint32_t hal_now(void); /* held */

/* Hold, and return the tick: every match at or before it has been processed, none after it. */
static inline uint32_t hal_enter(void);
static inline void hal_leave(void);

static inline uint8_t hal_hold(void); /* return what hal_restore() needs */
static inline void hal_restore(uint8_t before);

/* ------------------------------------------------------------------------------------------------------- the steps */
static inline void hal_advance(void); /* due += interval */

/* After a match, at `from`: set the next one to `due`; it is a step unless `mode` has PAUSE.  Return whether it is
   so near that it may have passed already. */
static inline uint8_t hal_aim(uint32_t from);

/* The same, but not from a match: `due` is at least SOONEST_TICKS away, and an earlier match must not be taken for
   it. */
static inline void hal_aim_anew(uint32_t from);

static inline void hal_hop(void); /* at a match with HOP in `mode`: continue towards `due` */

/* Make the next match a step at a tick less than LONG_LEAST away, given by its low half. */
static inline void hal_arm(uint16_t tick);

static inline uint8_t hal_is_missed(void); /* `due` has passed, and no match will come */
static inline void hal_end_pulse(void);
static inline void hal_stop(void); /* no step from here on */

/* Cancel the step, or the end of a pause, that is due, held; return 1 if it happened nevertheless: then its interrupt
   completes it as soon as interrupts are enabled. */
static inline uint8_t hal_disarm(void);

static inline void hal_set_dry(uint8_t is_dry); /* the steps of a dry run have no edges */

/* -------------------------------------------------------------------------------------------------------- the pins */
static inline uint8_t hal_levels(void);         /* of the inputs */
static inline void hal_wait_between_looks(void); /* between samples of the filter */
static inline void hal_set_output(uint8_t number, uint8_t level); /* held */
static inline uint8_t hal_outputs(void);                          /* levels of the user outputs' pins */
static inline void hal_set_enable(uint8_t level);                 /* held */
static inline void hal_set_direction(uint8_t level);
static inline void hal_set_phases(uint8_t levels);
static inline void hal_set_light(uint8_t level); /* lit while the board is not at rest */

/* Make pins outputs: user outputs, phases and ENABLE; a pin that is not an output is high impedance. */
static inline void hal_drive(uint8_t has_phases, uint8_t has_enable);

/* The step that is due may happen while its interrupt is held off for long: output its phases without it. */
static inline void hal_show_in_time(uint8_t phases);

/* -------------------------------------------------------------------------------------------------------- the line */
static inline uint8_t hal_get_byte(uint8_t *byte); /* return whether there was one */
static inline void hal_serve_line(void);           /* to call where interrupts are off for longer than two bytes */
void hal_put_byte(uint8_t byte);                   /* waits for room */

static inline uint16_t hal_crc(uint16_t before, uint8_t byte); /* CRC-16/X-25, updated with a byte */

/* Output pulses on STEP, a number of ticks apart, in IDLE, and return how many were counted through a loop. */
uint16_t hal_count_pulses(uint16_t pulses, uint16_t apart);

#include "board.h"

#endif
