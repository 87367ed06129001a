/* The pins of the module, its timers, and RDY, which every other file uses. */
#ifndef PINS_H
#define PINS_H

#include "gsc200.h"

/* Activities of the module, during which RDY is low (pin 14). */
enum work { LINE_WORK = 1, PROGRAM_WORK = 2, EEPROM_WORK = 4, START_WORK = 8 };

void begin_work(struct gsc *g, enum work work);
void end_work(struct gsc *g, enum work work);

void set_pin(struct gsc *g, enum gsc_pin pin, bool is_high);
bool is_high(const struct gsc *g, enum gsc_input input);
bool is_user_input_high(const struct gsc *g, uint8_t number); /* 1 to 3 */
void show_pins(struct gsc *g);                                /* report what has changed */

void start_timer(struct gsc *g, enum gsc_timer timer, gsc_time delay_ps);
void start_timer_at(struct gsc *g, enum gsc_timer timer, gsc_time at);
void stop_timer(struct gsc *g, enum gsc_timer timer);

void pulse_reset(struct gsc *g);  /* RESET low, pin 27 */
void end_reset_pulse(struct gsc *g);

#endif
