/* The part on this board: the core of ../part/gs_c200, synchronised with the pins. */
#ifndef PART_H
#define PART_H

#include <stdint.h>

#include "clock.h"

void part_start(void);
void part_round(void); /* process all due events, then sleep until the next one */

#endif
