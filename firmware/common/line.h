/* The line: 8N1, frames of COBS(number, kind, payload, CRC-16) and a 0. */
#ifndef LINE_H
#define LINE_H

#include <stdint.h>

#include "protocol.h"

#define FRAME_MOST (CHUNK_MOST - 1) /* decoded bytes */
#define PAYLOAD_MOST 16             /* of a frame that is sent */

extern uint8_t frame[];      /* the one that has come: number, kind, payload, CRC */
extern uint8_t frame_length; /* without its CRC */

/* Take bytes that have come, up to the end of a chunk: 1 if that is a good frame, -1 if it is damaged, 0 if there is
   none yet. */
int8_t listen(void);

/* Send a frame; waits while there is no room. */
void send(uint8_t number, uint8_t kind, const uint8_t *payload, uint8_t length);

#endif
