/* The effect of a host command, and its answer (data exchange protocol; direct execution commands).
 *
 * Checks, in this order: is it a command (else E4), its argument (E2), no program in progress (B), allowed now (E4), fits
 * into the memory (E3): GSC-UND-CHECK-ORDER.  Reception errors of a string are checked first (E1).
 */
#ifndef COMMANDS_H
#define COMMANDS_H

#include "gsc200.h"

enum outcome {
    IS_ANSWERED,     /* the answer has been written */
    IS_LISTED,       /* Q: the answer is the program, line by line */
    IS_ANSWERED_LATER, /* M: after the write to the EEPROM */
    TAKES_TIME       /* the answer is Y at `until`, after finish_command() */
};

/* Execute a string without address and checksum.  `answer` has room for 9 characters; `length` is set to their number. */
enum outcome obey_command(struct gsc *g, const uint8_t *text, uint8_t count, bool is_checked, uint8_t *answer,
                          uint8_t *length, gsc_time *until);

/* Complete K, Z or I after its time. */
void finish_command(struct gsc *g);

/* Write an answer to Q: the instruction at a location, which advances to the next one, or finally END.  Return the
   number of characters. */
uint8_t list_program(struct gsc *g, uint8_t *at, bool *is_end, uint8_t *answer);

#endif
