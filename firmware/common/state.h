/* What a board does, and where its motor is by count. */
#ifndef STATE_H
#define STATE_H

#include <stdint.h>

extern volatile uint8_t state;
extern volatile uint8_t levels; /* of the inputs, as of the last look */
extern uint8_t follows;         /* another record is played behind this one */
extern uint8_t down;            /* the record that plays, or the last one that did, goes downwards */
extern uint32_t end;            /* position behind the record, modulo 2^32 */
extern uint16_t left;           /* steps of the record that have not been made */

/* All of these are called held. */
void set_state(uint8_t new_state);

/* Return the position; every record knows its end, so the interrupt counts down and nothing else. */
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
