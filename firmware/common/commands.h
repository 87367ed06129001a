/* The frames of the host, and their effects. */
#ifndef COMMANDS_H
#define COMMANDS_H

void take_frame(void);  /* process the frame in `frame` */
void take_damage(void); /* process a damaged frame */

#endif
