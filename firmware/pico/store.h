/* The program saved by M, in two sectors of the flash, used alternately.
 *
 * A record has a sequence number and a CRC-32.  A new one is written into the sector without the valid one, so
 * a power failure at any instant leaves the old program or the new one.  (The model, after the sheet, has no valid program
 * then; with STORE_LIKE_THE_MODEL the old one is made invalid first.)
 *
 * At power-up it finds a valid record, the newer if both are valid; else, if both sectors are erased, no program yet;
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

/* Continue the operation in progress; return whether it has ended, and whether it succeeded. */
bool store_go_on(bool *is_good);
bool store_is_writing(void);

#endif
