#include "eeprom.h"

#include "pins.h"
#include "storage.h"

enum result { UNKNOWN, GOOD, BAD };

void write_program(struct gsc *g, bool is_checked)
{
    g->eeprom.is_writing = true;
    g->eeprom.is_checked = is_checked;
    g->eeprom.result = UNKNOWN;
    begin_work(g, EEPROM_WORK);
    start_timer(g, GSC_EEPROM_TIMER, EEPROM_PS / (GSC_LOCATIONS + 1) * (g->program.size + 1U));
    gsc_on_store(g, g->program.memory, g->program.size, g->now);
}

void gsc_stored(struct gsc *g, bool is_good)
{
    g->eeprom.result = is_good ? GOOD : BAD;
}

bool eeprom_timed(struct gsc *g, bool *is_good)
{
    if (g->eeprom.result == UNKNOWN) {
        start_timer(g, GSC_EEPROM_TIMER, STORE_LOOK_PS);
        return false;
    }
    *is_good = g->eeprom.result == GOOD;
    g->eeprom.is_writing = false;
    end_work(g, EEPROM_WORK);
    return true;
}

bool recall_program(struct gsc *g)
{
    uint8_t program[GSC_LOCATIONS];

    return load_program(g, program, gsc_recall(g, program));
}
