/* Switching the driver on and off: the rules of ENABLE, which no host can bypass. */
#ifndef POWER_H
#define POWER_H

#include <stdint.h>

#include "config.h"

extern uint16_t looked_at; /* the high half of the tick of the last round of the main loop */

/* All of these are called held. */
uint8_t may_switch(uint8_t mask, uint8_t value); /* as requested by an OUTPUTS frame */
void unlock(uint8_t reset_flags);                /* by RESET */
void begin_motion(void);                         /* steps follow: without current, the count becomes unsure */
void cut_power(uint8_t in_motion);               /* an emergency stop */
void power_configured(uint8_t is_other_driver); /* or another level that enables it */

/* For the main loop: switch the driver off after a halt, at rest, or without frames from the host, as set by CONFIG.
   `state_then`: in RUN and BRAKE interrupts may be on. */
void watch_power(uint32_t tick, uint8_t state_then, uint8_t is_host_silent);

#endif
