#ifndef SERIAL_H
#define SERIAL_H

void set_up_serial(void);

#endif
