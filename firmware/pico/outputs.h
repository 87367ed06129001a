/* The outputs except CLOCK and TXD: their levels, a bit for each enum gsc_pin. */
#ifndef OUTPUTS_H
#define OUTPUTS_H

#include <stdint.h>

#include "clock.h"

void outputs_start(uint16_t levels); /* write all of them */
void outputs_show(uint16_t levels);  /* write the changed ones */
cycles outputs_dir_changed(void);

#endif
