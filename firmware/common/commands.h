/* The frames of the host, and what they do. */
#ifndef COMMANDS_H
#define COMMANDS_H

void take_frame(void);  /* the one in `frame` */
void take_damage(void); /* one that was none */

#endif
