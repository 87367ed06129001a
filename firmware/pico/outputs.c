#include "outputs.h"

#include "gsc200.h"
#include "pins.h"
#include "registers.h"

static const uint8_t OUTPUTS[] = {
    [GSC_RDY] = PIN_RDY,     [GSC_MOV] = PIN_MOV, [GSC_RAMP] = PIN_RAMP, [GSC_DIR] = PIN_DIR,
    [GSC_RESET] = PIN_RESET, [GSC_UO1] = PIN_UO1, [GSC_UO2] = PIN_UO2,   [GSC_UO3] = PIN_UO3,
};

static uint16_t shown;
static cycles dir_changed;

void outputs_start(uint16_t levels)
{
    shown = (uint16_t)~levels;
    outputs_show(levels);
}

void outputs_show(uint16_t levels)
{
    uint32_t changed = levels ^ shown;
    shown = levels;
    changed &= ~(1u << GSC_TALK);
    for (unsigned pin = 0; changed >> pin; pin++) {
        if (!(changed >> pin & 1))
            continue;
        if ((pin == GSC_RDY) != (shown >> pin & 1))
            SIO_OUT_SET = 1u << OUTPUTS[pin];
        else
            SIO_OUT_CLEAR = 1u << OUTPUTS[pin];
        if (pin == GSC_DIR)
            dir_changed = clock_now();
    }
}

cycles outputs_dir_changed(void)
{
    return dir_changed;
}
