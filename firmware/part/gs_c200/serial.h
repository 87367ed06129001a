/* The serial port: characters become strings, strings have answers (data exchange protocol).
 *
 *     RXD ... characters ... CR                                characters form a string up to its carriage return;
 *     TXD                         |<- turn-round ->| answer CR  then it is executed; its effect comes with the answer
 *
 * While an answer is sent, one further string is kept; more are lost (GSC-UND-RX-WHILE-TX).
 */
#ifndef SERIAL_H
#define SERIAL_H

#include "gsc200.h"

void listen_to_host(struct gsc *g);      /* read rate and address from the straps (GSC-UND-STRAPS), and begin */
void receive_character(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end);
void serial_timed(struct gsc *g); /* process the timer */
void obey_strings(struct gsc *g); /* execute the strings that are due */
void answer_memorize(struct gsc *g, bool is_good); /* the answer to M: Y or E6 */

#endif
