/* The program memory (the program storage area): 119 locations; the sheet has the number for each instruction. */
#ifndef STORAGE_H
#define STORAGE_H

#include "gsc200.h"
#include "language.h"

void begin_program_entry(struct gsc *g);                                   /* Po, P */
bool store_instruction(struct gsc *g, const struct command_line *command); /* return whether it fits */
bool load_program(struct gsc *g, const uint8_t *program, int size);        /* return whether it is a program */

/* Read the instruction at a location up to the end of the program; return false if there is none. */
bool instruction_at(const struct gsc *g, uint8_t at, struct command_line *found);

bool is_speed_missing(const struct gsc *g); /* whether a motion of the program would lack S, T or R (GSC-UND-DEFAULTS)? */
uint16_t homing_speed(const struct gsc *g); /* in units of 10 steps/s; 0: not set (GSC-UND-H-NO-S) */
bool begins_with_start_stop(const struct gsc *g);

bool is_start_of_instruction(const struct gsc *g, uint8_t location);

#endif
