#include "storage.h"

#include <string.h>

bool instruction_at(const struct gsc *g, uint8_t at, struct command_line *found)
{
    return unpack_instruction(g, g->program.memory + at, (uint8_t)(g->program.size - at), found);
}

void begin_program_entry(struct gsc *g)
{
    g->program.is_entering = true;
    g->program.size = 0;
}

bool store_instruction(struct gsc *g, const struct command_line *command)
{
    if (g->program.size + command->row->size > GSC_LOCATIONS)
        return false;
    pack_instruction(command, g->program.memory + g->program.size);
    g->program.size = (uint8_t)(g->program.size + command->row->size);
    return true;
}

static bool is_program(const struct gsc *g, const uint8_t *program, uint8_t size)
{
    struct command_line found;
    uint8_t at = 0;

    while (at < size) {
        if (!unpack_instruction(g, program + at, (uint8_t)(size - at), &found))
            return false;
        at = (uint8_t)(at + found.row->size);
    }
    return true;
}

bool load_program(struct gsc *g, const uint8_t *program, int size)
{
    if (size < 0 || size > GSC_LOCATIONS || !is_program(g, program, (uint8_t)size))
        return false;
    memcpy(g->program.memory, program, (size_t)size);
    g->program.size = (uint8_t)size;
    return true;
}

bool is_speed_missing(const struct gsc *g)
{
    bool has_start_stop = g->registers.start_stop, has_top_speed = g->registers.top_speed, has_ramp = g->registers.ramp;
    struct command_line found;

    for (uint8_t at = 0; instruction_at(g, at, &found); at = (uint8_t)(at + found.row->size)) {
        if (found.row->is_motion && !(has_start_stop && has_top_speed && has_ramp))
            return true;
        has_start_stop |= found.row->command == START_STOP;
        has_top_speed |= found.row->command == TOP_SPEED;
        has_ramp |= found.row->command == RAMP;
    }
    return false;
}

static bool reads_start_stop(const struct gsc *g, struct command_line *found)
{
    return instruction_at(g, 0, found) && found->row->command == START_STOP;
}

bool begins_with_start_stop(const struct gsc *g)
{
    struct command_line found;

    return reads_start_stop(g, &found);
}

uint16_t homing_speed(const struct gsc *g)
{
    struct command_line found;

    return reads_start_stop(g, &found) ? (uint16_t)found.values[0] : g->registers.start_stop;
}

bool is_start_of_instruction(const struct gsc *g, uint8_t location)
{
    struct command_line found;
    uint8_t at = 0;

    while (at < location && instruction_at(g, at, &found))
        at = (uint8_t)(at + found.row->size);
    return at == location;
}
