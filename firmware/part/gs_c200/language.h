/* The commands as text and as bytes of the program memory (S.I.M.P.L.E. interpreter command and functions). */
#ifndef LANGUAGE_H
#define LANGUAGE_H

#include "gsc200.h"
#include "sheet.h"

struct command_line {
    const struct row *row;
    int32_t values[2];
};

enum reading { IS_COMMAND, IS_UNKNOWN, IS_WRONG_ARGUMENT };

/* Read a string without address and checksum. */
enum reading read_command(const struct gsc *g, const uint8_t *text, uint8_t length, struct command_line *found);

/* Write an instruction in its one spelling; return the number of characters, 10 at most. */
uint8_t spell_instruction(const struct command_line *instruction, uint8_t *text);
uint8_t spell_number(int32_t number, bool has_plus, uint8_t *text);

/* Write an instruction as bytes: opcode, arguments with the low byte first, as many locations as the sheet counts. */
void pack_instruction(const struct command_line *instruction, uint8_t *bytes);

/* Read the instruction at the start of some bytes.  Return false if there is none. */
bool unpack_instruction(const struct gsc *g, const uint8_t *bytes, uint8_t length, struct command_line *found);

#endif
