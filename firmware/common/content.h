/* Content of frames: what it says, and whether that is possible. */
#ifndef CONTENT_H
#define CONTENT_H

#include <stdint.h>

#include "queue.h"

/* Read a record; return whether it is a good one. */
uint8_t read_record(const uint8_t *from, struct record *to);

/* Return what is to be answered to a TAIL with this content, and how many entries it has. */
uint8_t judge_tail(const uint8_t *payload, uint8_t length, uint8_t *entries);

#endif
