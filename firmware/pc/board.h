/* A board without hardware for ../common/hal.h: time is a number, pins are fields, matches follow from the time. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>
#include <stdlib.h>

#include "due.h"
#include "limits.h"

#define NEVER UINT64_MAX
#define LINE_MOST 65536

struct pc {
    uint64_t now;   /* ticks that do not wrap */
    uint64_t match; /* the next one, or NEVER */
    uint8_t levels; /* of the inputs */
    uint8_t is_dry;
    uint8_t direction;
    uint8_t phases;
    uint8_t outputs;
    uint8_t enable; /* level of its pin */
    uint8_t drives_enable;
    uint8_t light;
    uint8_t received[LINE_MOST], sent[LINE_MOST];
    size_t received_head, received_tail, sent_length;
};

extern struct pc pc;

/* Let time pass up to a tick, with all matches before it.  `stepped` is called first at each step. */
void pc_run(uint64_t tick, void (*stepped)(void));

static inline uint32_t hal_now(void)
{
    return (uint32_t)pc.now;
}

static inline uint32_t hal_enter(void)
{
    return hal_now();
}

static inline void hal_leave(void)
{
}

static inline uint8_t hal_hold(void)
{
    return 0;
}

static inline void hal_restore(uint8_t before)
{
    (void)before;
}

static inline void hal_advance(void)
{
    uint32_t fraction = (uint32_t)due.fraction + interval.fraction;

    due.tick += interval.tick + (fraction >> 16);
    due.fraction = (uint16_t)fraction;
}

static inline uint8_t hal_aim(uint32_t from)
{
    (void)from;
    pc.match = pc.now + (uint32_t)(due.tick - hal_now());
    return 0;
}

static inline void hal_aim_anew(uint32_t from)
{
    hal_aim(from);
}

static inline void hal_hop(void)
{
    abort(); /* this timer needs no hops */
}

static inline void hal_arm(uint16_t tick)
{
    pc.match = pc.now + (uint16_t)(tick - (uint16_t)pc.now);
}

static inline uint8_t hal_is_missed(void)
{
    return 0;
}

static inline void hal_end_pulse(void)
{
}

static inline void hal_stop(void)
{
    pc.match = NEVER;
}

static inline uint8_t hal_disarm(void)
{
    pc.match = NEVER;
    return 0;
}

static inline void hal_set_dry(uint8_t is_dry)
{
    pc.is_dry = is_dry;
}

#define HAL_PHASES(pattern) (pattern)

static inline uint8_t hal_levels(void)
{
    return pc.levels;
}

static inline void hal_wait_between_looks(void)
{
}

static inline void hal_set_output(uint8_t number, uint8_t level)
{
    uint8_t bit = (uint8_t)(1 << number);

    pc.outputs = (uint8_t)((pc.outputs & ~bit) | (level ? bit : 0));
}

static inline uint8_t hal_outputs(void)
{
    return pc.outputs;
}

static inline void hal_set_enable(uint8_t level)
{
    pc.enable = level;
}

static inline void hal_set_direction(uint8_t level)
{
    pc.direction = level;
}

static inline void hal_set_phases(uint8_t levels)
{
    pc.phases = levels;
}

static inline void hal_set_light(uint8_t level)
{
    pc.light = level;
}

static inline void hal_drive(uint8_t has_phases, uint8_t has_enable)
{
    (void)has_phases;
    pc.drives_enable = has_enable;
}

static inline void hal_show_in_time(uint8_t phases)
{
    (void)phases;
}

static inline uint8_t hal_get_byte(uint8_t *byte)
{
    if (pc.received_tail == pc.received_head)
        return 0;
    *byte = pc.received[pc.received_tail++];
    return 1;
}

static inline void hal_serve_line(void)
{
}

static inline uint16_t hal_crc(uint16_t before, uint8_t byte)
{
    uint16_t after = before ^ byte;
    uint8_t bit;

    for (bit = 0; bit < 8; bit++)
        after = (uint16_t)(after & 1 ? (after >> 1) ^ 0x8408 : after >> 1);
    return after;
}

#endif
