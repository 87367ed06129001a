/* The program that M keeps, in two sectors of the flash in turn.
 *
 * A record has a sequence number and a CRC-32.  A new one is written into the sector that does not hold the valid one, so
 * a power failure at any instant leaves the old program or the new one.  (The model, after the sheet, has no valid program
 * then; with STORE_LIKE_THE_MODEL the old one is made invalid first.)
 *
 * What is found at power-up: a valid record, the newer one if both are; else no program yet, if both sectors are erased;
 * else no valid program, which X answers with E6.
 */
#ifndef STORE_H
#define STORE_H

#include <stdbool.h>
#include <stdint.h>

#define STORE_MOST 119 /* bytes of a program */

void store_start(void);

/* Return the length of the program and write it; -1: there is no valid one. */
int store_recall(uint8_t *program);

void store_begin(const uint8_t *program, uint8_t length);

/* Go on with what has begun; return whether it is over now, and whether it is good. */
bool store_go_on(bool *is_good);
bool store_is_writing(void);

#endif
