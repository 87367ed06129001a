/* The line: 500 kbaud 8N1, frames of COBS(number, kind, payload, CRC-16) and a 0. */
#ifndef WIRE_H
#define WIRE_H

#include <stdint.h>

#define FRAME_MOST (CHUNK_MOST - 1) /* decoded bytes */

extern uint8_t frame[];      /* the one that has come: number, kind, payload, CRC */
extern uint8_t frame_length; /* without its CRC */

void set_up_wire(void);

/* Take bytes that have come, up to the end of a chunk: 1 if that is a good frame, -1 if it is damaged, 0 if there is
   none yet. */
int8_t listen(void);

/* Take a byte from the receiver, if there is one: for whoever has interrupts off for longer than two bytes last. */
void serve_line(void);

/* Send a frame; waits while there is no room. */
void send(uint8_t number, uint8_t kind, const void *payload, uint8_t length);

#endif
