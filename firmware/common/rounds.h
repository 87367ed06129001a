/* The main loop of a board. */
#ifndef ROUNDS_H
#define ROUNDS_H

void power_up(void); /* held; from here on the levels of the inputs are known */
void round_once(void);

/* The parts of a round: the driver's current, and a host that stops sending while steps are played. */
void watch(void);
void brake_if_silent(void);

#endif
