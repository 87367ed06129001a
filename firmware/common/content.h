/* Parsing and checking the content of frames. */
#ifndef CONTENT_H
#define CONTENT_H

#include <stdint.h>

#include "queue.h"

/* Read a record; return whether it is valid. */
uint8_t read_record(const uint8_t *from, struct record *to);

/* Return the result for a TAIL with this content, and the number of its entries. */
uint8_t judge_tail(const uint8_t *payload, uint8_t length, uint8_t *entries);

#endif
