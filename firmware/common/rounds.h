/* The main loop of a board. */
#ifndef ROUNDS_H
#define ROUNDS_H

void power_up(void); /* held; the inputs' levels are known from here on */
void round_once(void);

/* The parts of a round: the driver's current, and a host that is silent while steps are played. */
void watch(void);
void brake_if_silent(void);

#endif
