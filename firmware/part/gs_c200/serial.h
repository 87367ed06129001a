/* The serial port: characters become strings, strings have answers (data exchange protocol).
 *
 *     RXD ... characters ... CR                                characters go into a string until its carriage return;
 *     TXD                         |<- turn-round ->| answer CR  then it is obeyed; its effect comes with the answer
 *
 * While an answer is on its way one further string is kept; what comes beyond that is lost (GSC-UND-RX-WHILE-TX).
 */
#ifndef SERIAL_H
#define SERIAL_H

#include "gsc200.h"

void listen_to_host(struct gsc *g);      /* read rate and address from the straps (GSC-UND-STRAPS), and begin */
void receive_character(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end);
void serial_timed(struct gsc *g); /* the timer has come */
void obey_strings(struct gsc *g); /* those whose time has come */
void answer_memorize(struct gsc *g, bool is_good); /* the answer to M: Y or E6 */

#endif
