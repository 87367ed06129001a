/* Records waiting to be played: the main loop writes them, the step interrupt removes them. */
#ifndef QUEUE_H
#define QUEUE_H

#include <stdint.h>

/* In the order of a frame; an assembler interrupt uses the offset of each field. */
struct record {
    uint8_t flags;
    uint16_t count;
    uint32_t interval;
    uint16_t fraction;
    int32_t add;
};

extern volatile uint8_t queued;
extern struct record queue[];
extern struct record *out; /* the next one to play */

/* For the main loop: return the place for a record, counted from the end of the queue; complete it after writing it;
   publish several together, held, up to the place after them. */
struct record *place_in_queue(uint8_t ahead);
void complete(struct record *record);
void publish(uint8_t count, struct record *behind);

/* These are called held. */
void forget_queue(void);
void drop_record(void); /* the record at `out`, which is now being played */

#endif
