#include "hal.h"
#include "protocol.h"
#include "state.h"

volatile uint8_t state;
volatile uint8_t levels;
uint8_t follows;
uint8_t down;
uint32_t end;
uint16_t left;

void set_state(uint8_t new_state)
{
    state = new_state;
    follows = new_state == STATE_RUN;
    hal_set_light(new_state != STATE_IDLE);
}
