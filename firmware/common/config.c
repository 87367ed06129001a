#include <string.h>

#include "bytes.h"
#include "config.h"

struct config config;

static uint8_t is_good(const struct config *new)
{
    uint8_t i;

    if (new->start_stop >= 0x80000000 || new->watchdog >= 0x80000000 ||
        new->polarity > (POLARITY_UP_IS_HIGH | POLARITY_ENABLE_LOW) || (new->active | new->report) > INPUTS_MASK ||
        new->driver > (DRIVER_ENABLE | DRIVER_DRY) || new->enable_off > OFF_REST || new->filter > 15 ||
        (new->lamps & 15) > 4 || new->lamps >> 4 > 4 || new->phase > 7)
        return 0;
    for (i = 0; i < INPUTS; i++) {
        uint8_t kind = new->reflex[i] & 15, only = new->reflex[i] >> 4;

        if (kind > REFLEX_ESTOP || only > 2 || (only && kind != REFLEX_STOP && kind != REFLEX_BRAKE))
            return 0;
    }
    for (i = 0; i < 8; i++)
        if (new->pattern[i] > 15)
            return 0;
    return 1;
}

uint8_t read_config(const uint8_t *payload, uint8_t length, struct config *to)
{
    if (length != CONFIG_BYTES)
        return 0;
    to->start_stop = get32(payload);
    to->watchdog = get32(payload + 4);
    to->polarity = payload[8];
    to->active = payload[9];
    to->report = payload[10];
    to->driver = payload[11];
    to->enable_off = payload[12];
    to->enable_hold = get16(payload + 13);
    to->filter = payload[15];
    to->lamps = payload[16];
    memcpy(to->reflex, payload + 17, INPUTS);
    memcpy(to->pattern, payload + 17 + INPUTS, 8);
    to->phase = payload[17 + INPUTS + 8];
    return is_good(to);
}
