/* The state of a board, and the position count of its motor. */
#ifndef STATE_H
#define STATE_H

#include <stdint.h>

extern volatile uint8_t state;
extern volatile uint8_t levels; /* of the inputs, at the last sample */
extern uint8_t follows;         /* another record follows this one */
extern uint8_t down;            /* the record being played, or the last one played, counts downwards */
extern uint32_t end;            /* position at the end of the record, modulo 2^32 */
extern uint16_t left;           /* remaining steps of the record */

/* All of these are called held. */
void set_state(uint8_t new_state);

/* Return the position; the end of every record is known, so the interrupt only counts down. */
static inline int32_t position_now(void)
{
    return (int32_t)(down ? end + left : end - left);
}

static inline void place(int32_t position)
{
    end = (uint32_t)position;
    left = 0;
}

#endif
