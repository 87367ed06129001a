/* Records that wait to be played: the main loop writes them, the step interrupt takes them out. */
#ifndef QUEUE_H
#define QUEUE_H

#include <stdint.h>

/* In the order of a frame; an interrupt in assembler knows where each field is. */
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

/* For the main loop: where a record goes that is so many places behind the queue; complete it when it has been written;
   publish so many together, held, up to the place behind them. */
struct record *place_in_queue(uint8_t ahead);
void complete(struct record *record);
void publish(uint8_t count, struct record *behind);

/* These are called held. */
void forget_queue(void);
void drop_record(void); /* the one at `out`, which is played now */

#endif
