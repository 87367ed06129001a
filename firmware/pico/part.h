/* The part on this board: the core of ../part/gs_c200, held to the time of the pins. */
#ifndef PART_H
#define PART_H

#include <stdint.h>

#include "clock.h"

void part_start(void);
void part_round(void); /* deal with all that is due, then sleep until more is */

#endif
