#include "hal.h"
#include "outputs.h"
#include "steps.h"

struct pc pc = {.match = NEVER};

void pc_run(uint64_t tick, void (*stepped)(void))
{
    while (pc.match <= tick) {
        pc.now = pc.match;
        pc.match = NEVER;
        if (!(mode & NO_STEP)) {
            stepped();
            pc.phases = phases_due;
            if (mode & PHASES) {
                phase = (uint8_t)(phase + phase_step) & 7;
                phases_due = pattern[phase];
            }
        }
        match();
    }
    pc.now = tick;
}

void hal_put_byte(uint8_t byte)
{
    if (pc.sent_length == LINE_MOST)
        abort();
    pc.sent[pc.sent_length++] = byte;
}

uint16_t hal_count_pulses(uint16_t pulses, uint16_t apart)
{
    (void)pulses;
    (void)apart;
    return 0; /* STEP is not looped back */
}
