#include "content.h"
#include "bytes.h"
#include "limits.h"
#include "protocol.h"
#include "tail.h"

static uint32_t magnitude(int32_t value)
{
    return value < 0 ? -(uint32_t)value : (uint32_t)value;
}

/* Return whether the whole ticks of an interval are within the range of the timer. */
static uint8_t is_possible(uint32_t ticks)
{
    return ticks >= SHORTEST && ticks < 0x80000000;
}

static uint8_t is_good_pause(const struct record *record)
{
    uint8_t mask = (uint8_t)(record->count >> 8), value = (uint8_t)record->count;

    if (record->flags & RECORD_OUT ? (mask | value) > USER_OUTPUTS : record->count != 0)
        return 0;
    return record->flags < 32 && record->interval >= SHORTEST_PAUSE && record->interval < 0x80000000;
}

/* `add` is a number of steps of a stop ramp, and its change with each step. */
static uint8_t is_good_ramp_left(const struct record *record)
{
    uint16_t ramp_left = (uint16_t)record->add, more = (uint16_t)(record->count - 1);
    int16_t slope = (int16_t)((uint32_t)record->add >> 16);

    return !slope || (slope == 1 && (uint16_t)(ramp_left + more) >= ramp_left) || (slope == -1 && ramp_left >= more);
}

/* The last interval: 48 bits, the product in two pieces of 32 by 16. */
static uint8_t is_last_possible(const struct record *record)
{
    uint32_t most = magnitude(record->add), more = record->count - 1u;
    uint32_t low = (most & 0xFFFF) * more, high = (most >> 16) * more + (low >> 16);

    low &= 0xFFFF;
    if (record->add < 0)
        return high <= record->interval && is_possible(record->interval - high - (record->fraction < low));
    return is_possible(record->interval + high + (record->fraction + low > 0xFFFF));
}

static uint8_t is_good(const struct record *record)
{
    if (record->flags & RECORD_PAUSE)
        return is_good_pause(record);
    if (record->flags & (uint8_t)~(RECORD_DOWN | RECORD_HALF | RECORD_RAMP_LEFT) || !record->count ||
        !is_possible(record->interval))
        return 0;
    if (record->flags & RECORD_RAMP_LEFT)
        return is_good_ramp_left(record);
    return !record->add || is_last_possible(record);
}

uint8_t read_record(const uint8_t *from, struct record *to)
{
    to->flags = from[0];
    to->count = get16(from + 1);
    to->interval = get32(from + 3);
    to->fraction = get16(from + 7);
    to->add = (int32_t)get32(from + 9);
    return is_good(to);
}

uint8_t judge_tail(const uint8_t *payload, uint8_t length, uint8_t *entries)
{
    uint8_t first = payload[0], n = (uint8_t)((length - 1) / ENTRY_BYTES), i;
    const struct tail_entry *before;
    uint32_t least, steps;

    *entries = n;
    if (n < 1 || n > ENTRIES_MOST || length != 1 + n * ENTRY_BYTES || first > tail_count)
        return RESULT_BAD_CONTENT;
    before = TAIL_ENTRIES + first - 1;
    least = first ? before->interval : (uint32_t)SHORTEST << 8;
    steps = before->up_to;
    for (i = 0, payload++; i < n; i++, payload += ENTRY_BYTES) {
        if (get32(payload) < least || !get16(payload + 4))
            return RESULT_BAD_CONTENT;
        least = get32(payload);
        steps += get16(payload + 4);
    }
    if (first + n > TAIL_MOST)
        return RESULT_NO_ROOM;
    return steps > 0xFFFF ? RESULT_BAD_CONTENT : RESULT_TAKEN;
}
