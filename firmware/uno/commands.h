/* The frames of the host, what they do, and what they are answered. */
#ifndef COMMANDS_H
#define COMMANDS_H

#include <stdint.h>

void take_frame(void);
void take_damage(void);
void tell_events(void);
void watch_for_silence(void);

#endif
