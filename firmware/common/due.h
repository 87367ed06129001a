/* The next match of the timer, which the step interrupt of a board and common code share. */
#ifndef DUE_H
#define DUE_H

#include <stdint.h>

#include "mode.h"

/* 1/65536 tick in the low half: 48 bits, little-endian, for addition in an assembler interrupt. */
struct instant {
    uint16_t fraction;
    uint32_t tick;
};

extern volatile uint8_t mode;
extern struct instant due;      /* instant of the match */
extern struct instant interval; /* added to it at the match */

static inline uint8_t is_in_pause(void)
{
    return mode & PAUSE;
}

#endif
