#include "bytes.h"
#include "config.h"
#include "hal.h"
#include "tail.h"

struct tail_entry tail_table[TAIL_MOST + 2];
volatile uint8_t tail_count;
const struct tail_entry *tail_end = TAIL_ENTRIES;
const struct tail_entry *hint = TAIL_ENTRIES;
uint8_t quick;

static struct {
    const uint8_t *from;
    uint8_t first;
    uint8_t count;
} fresh; /* valid entries that are not yet in the table: a frame is too long to be copied without interruption */

uint8_t is_tail_fresh(void)
{
    return fresh.count;
}

void settle_tail(void)
{
    const uint8_t *from = fresh.from;
    struct tail_entry *entry = TAIL_ENTRIES + fresh.first;
    uint8_t i;

    for (i = fresh.count; i; i--, entry++, from += ENTRY_BYTES) {
        entry->interval = get32(from);
        entry->up_to = (uint16_t)(entry[-1].up_to + get16(from + 4));
    }
    entry->interval = 0xFFFFFFFF;
}

void take_tail(const uint8_t *from, uint8_t first, uint8_t count)
{
    fresh.from = from;
    fresh.first = first;
    fresh.count = count;
    quick = 0;
    tail_count = (uint8_t)(first + count);
    tail_end = TAIL_ENTRIES + tail_count;
    if (hint > tail_end)
        hint = tail_end;
}

void tail_configured(void)
{
    quick = tail_count && config.start_stop >= FAST_TICKS;
}

void tail_settled(void)
{
    uint8_t before;

    settle_tail();
    before = hal_hold();
    fresh.count = 0;
    tail_configured();
    hal_restore(before);
}
