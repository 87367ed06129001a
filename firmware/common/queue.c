#include "limits.h"
#include "mode.h"
#include "protocol.h"
#include "queue.h"

volatile uint8_t queued;
struct record queue[SLOTS];
struct record *out = queue;

static struct record *in = queue; /* where the main loop writes */

struct record *place_in_queue(uint8_t ahead)
{
    struct record *free = in + ahead;

    if (free >= queue + SLOTS)
        free -= SLOTS;
    return free;
}

/* Marks ramps for the interrupt. */
void complete(struct record *record)
{
    if (record->add && !(record->flags & (RECORD_PAUSE | RECORD_RAMP_LEFT)))
        record->flags |= RAMP;
}

void publish(uint8_t count, struct record *behind)
{
    in = behind;
    queued = (uint8_t)(queued + count);
}

void forget_queue(void)
{
    queued = 0;
    out = in;
}

void drop_record(void)
{
    queued--;
    if (++out == queue + SLOTS)
        out = queue;
}
