/* The serial port: characters of 7 bits, odd parity, 2 stop bits, by two state machines. */
#ifndef SERIAL_H
#define SERIAL_H

#include <stdbool.h>
#include <stdint.h>

#include "clock.h"

struct received {
    uint8_t character;
    bool is_parity_wrong, is_framing_wrong;
    cycles at, end; /* the middle of its first stop bit; the end of the second */
};

void serial_begin(uint16_t baud); /* begin to receive */

bool serial_is_waiting(void); /* whether a character is available */
bool serial_get(struct received *character);

/* Send a character whose start bit begins at a cycle; one that follows the last one immediately, or is too late for
   that, begins at the end of that one. */
void serial_put(uint8_t character, cycles at, bool follows);

cycles serial_length(void); /* of a character */
bool serial_is_sending(void);
bool serial_is_empty(void); /* no character waits after the one being sent */

void serial_interrupt(void);

#endif
