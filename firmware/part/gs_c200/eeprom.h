/* The EEPROM: 10 ms for each byte of the program and for a check byte after it (commands M, X; GSC-UND-M-REPLY). */
#ifndef EEPROM_H
#define EEPROM_H

#include "gsc200.h"

/* M: begin to write the program.  `is_checked`: the answer, which follows the write, has a checksum. */
void write_program(struct gsc *g, bool is_checked);

/* X: load the program.  Return whether there is a valid program; if not, the memory is unchanged. */
bool recall_program(struct gsc *g);

/* Process the timer.  Return whether the write has ended; `is_good` is set to its success. */
bool eeprom_timed(struct gsc *g, bool *is_good);

#endif
