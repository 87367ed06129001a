/* The settings of CONFIG. */
#ifndef CONFIG_H
#define CONFIG_H

#include <stdint.h>

#include "protocol.h"

#define CONFIG_BYTES 32

struct config {
    uint32_t start_stop; /* ticks: from this interval on, the motor may stop without a ramp */
    uint32_t watchdog;   /* ticks allowed without a frame; 0: unlimited */
    uint8_t polarity;
    uint8_t active;       /* bit n: input n is active when high */
    uint8_t report;       /* bit n: each edge of input n is an event */
    uint8_t driver;       /* DRIVER_ENABLE, DRIVER_DRY */
    uint8_t enable_off;   /* OFF_NEVER, OFF_HALT, OFF_REST */
    uint16_t enable_hold; /* time for which the driver remains on, in units of 65,536 ticks */
    uint8_t filter;       /* samples before a changed input takes effect; not for an emergency stop */
    uint8_t lamps;        /* low half: number + 1 of the output that shows a halt; high half: the same for the driver */
    uint8_t reflex[INPUTS];
    uint8_t pattern[8]; /* levels of the phases by half step */
    uint8_t phase;      /* their present half step */
};

extern struct config config;

/* Read a frame's content; return whether it is valid. */
uint8_t read_config(const uint8_t *payload, uint8_t length, struct config *to);

static inline uint8_t is_dry(void)
{
    return config.driver & DRIVER_DRY;
}

#endif
