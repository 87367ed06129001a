/* The line: 8N1, frames of COBS(number, kind, payload, CRC-16) and a 0. */
#ifndef LINE_H
#define LINE_H

#include <stdint.h>

#include "protocol.h"

#define FRAME_MOST (CHUNK_MOST - 1) /* decoded bytes */
#define PAYLOAD_MOST 16             /* of a sent frame */

extern uint8_t frame[];      /* the received frame: number, kind, payload, CRC */
extern uint8_t frame_length; /* without its CRC */

/* Process received bytes, up to the end of a chunk: return 1 for a valid frame, -1 for a damaged one, 0 if there is
   none yet. */
int8_t listen(void);

/* Send a frame; wait for room. */
void send(uint8_t number, uint8_t kind, const uint8_t *payload, uint8_t length);

#endif
