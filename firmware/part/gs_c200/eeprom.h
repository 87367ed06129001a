/* The EEPROM: 10 ms for each byte of the program and for a check byte after it (commands M, X; GSC-UND-M-REPLY). */
#ifndef EEPROM_H
#define EEPROM_H

#include "gsc200.h"

/* M: begin to write the program.  `is_checked`: the answer, which comes when it is written, has a checksum. */
void write_program(struct gsc *g, bool is_checked);

/* X: load the program.  Return whether there is a valid one; else the memory is unchanged. */
bool recall_program(struct gsc *g);

/* The timer has come.  Return whether the write is over; `is_good` says how. */
bool eeprom_timed(struct gsc *g, bool *is_good);

#endif
