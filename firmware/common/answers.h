/* Messages of the board: answers to frames, and events. */
#ifndef ANSWERS_H
#define ANSWERS_H

#include <stdint.h>

#include "events.h"

struct answer {
    uint8_t echo; /* number of the answered frame */
    uint8_t kind;
    uint8_t result;
    uint8_t free;
    uint8_t state;
    uint8_t events;
    uint8_t inputs;
    uint8_t flags;
    int32_t position;
    uint32_t tick;
};

extern struct answer answer; /* to the last frame */
extern uint8_t wanted;       /* number of the next numbered frame */

/* Put the present state into the answer, and let steps resume: the end of what hal_enter() began. */
void settle(uint8_t result, uint32_t tick);
void refuse(uint8_t result); /* the same, for a frame without any other effect */
void send_answer(void);      /* after the events that preceded it */
void send_event(uint8_t number, const struct event *event);
void send_events(void); /* for the main loop: the events not yet sent */

/* For the main loop: return whether no frame has arrived for as long as CONFIG allows. */
uint8_t is_host_silent(uint32_t tick);

#endif
