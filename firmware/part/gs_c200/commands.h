/* What a command of the host does, and its answer (data exchange protocol; direct execution commands).
 *
 * Checks, in this order: is it a command (E4), its argument (E2), does a program run (B), may it come now (E4), does it
 * fit into the memory (E3): GSC-UND-CHECK-ORDER.  How a string was received is checked before (E1).
 */
#ifndef COMMANDS_H
#define COMMANDS_H

#include "gsc200.h"

enum outcome {
    IS_ANSWERED,     /* the answer has been written */
    IS_LISTED,       /* Q: it is the program, line by line */
    IS_ANSWERED_LATER, /* M: by the EEPROM */
    TAKES_TIME       /* the answer is Y at `until`, after finish_command() */
};

/* Obey a string without address and checksum.  `answer` has room for 9 characters, `length` says how many there are. */
enum outcome obey_command(struct gsc *g, const uint8_t *text, uint8_t count, bool is_checked, uint8_t *answer,
                          uint8_t *length, gsc_time *until);

/* K, Z and I have taken their time. */
void finish_command(struct gsc *g);

/* Write an answer to Q: the instruction at a location, which becomes that of the next one, or at last END.  Return the
   number of characters. */
uint8_t list_program(struct gsc *g, uint8_t *at, bool *is_end, uint8_t *answer);

#endif
