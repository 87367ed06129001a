#include "commands.h"

#include "eeprom.h"
#include "language.h"
#include "pins.h"
#include "program.h"
#include "storage.h"

static uint8_t say(uint8_t *answer, const char *text)
{
    uint8_t length = 0;

    while (text[length]) {
        answer[length] = (uint8_t)text[length];
        length++;
    }
    return length;
}

static uint8_t state_of(const struct gsc *g)
{
    return is_running(g) ? RUNNING : g->program.is_entering ? ENTERING : IDLE;
}

/* ------------------------------------------------------------------------------------------------------------ queries */
/* F: E5 is reported once (GSC-UND-E5). */
static const char *feed_back(struct gsc *g)
{
    bool is_over = g->registers.is_over;

    if (is_running(g))
        return "B";
    g->registers.is_over = false;
    return is_over ? "E5" : "R";
}

/* V1: the position; V2: user inputs and outputs, each as a number of three bits. */
static uint8_t verify(const struct gsc *g, int32_t what, uint8_t *answer)
{
    answer[0] = 'V';
    if (what == 1)
        return (uint8_t)(1 + spell_number(g->position, g->part == GSC_C200S, answer + 1));
    answer[1] = (uint8_t)('0' + (g->inputs / GSC_UI1 & 7));
    answer[2] = (uint8_t)('0' + (g->levels >> GSC_UO1 & 7));
    return 3;
}

uint8_t list_program(struct gsc *g, uint8_t *at, bool *is_end, uint8_t *answer)
{
    struct command_line found;

    *is_end = !instruction_at(g, *at, &found);
    if (*is_end)
        return say(answer, "END");
    *at = (uint8_t)(*at + found.row->size);
    return spell_instruction(&found, answer);
}

/* ----------------------------------------------------------------------------------------------- direct execution */
static const char *execute(struct gsc *g)
{
    g->program.is_entering = false;
    if (!g->program.size || is_speed_missing(g))
        return "E4";
    g->registers.is_over = false;
    run_program(g);
    return "Y";
}

static const char *home(struct gsc *g, int32_t direction)
{
    if (!homing_speed(g))
        return "E4";
    run_homing(g, (int8_t)direction, false);
    return "Y";
}

/* Without a run, it has no effect (GSC-UND-KZ-IDLE). */
static enum outcome kill(struct gsc *g, gsc_time *until)
{
    *until = kill_run(g);
    return TAKES_TIME;
}

/* Without motion Z ends the program immediately; so it does with a homing, which has no ramp (GSC-UND-H-ABORT). */
static enum outcome zero_speed(struct gsc *g, gsc_time *until)
{
    if (!g->motion.is_moving || g->motion.homing)
        return kill(g, until);
    come_to_rest(g);
    return IS_ANSWERED;
}

/* I1 and I3 are answered after the RESET pulse. */
static enum outcome initialize_now(struct gsc *g, int32_t what, gsc_time *until)
{
    if (!initialize_module(g, what))
        return IS_ANSWERED;
    *until = g->now + RESET_PS;
    return TAKES_TIME;
}

void finish_command(struct gsc *g)
{
    if (is_running(g))
        end_run(g);
}

/* Execute a command directly; the answer is Y, unless another one is written. */
static enum outcome perform(struct gsc *g, const struct command_line *command, bool is_checked, uint8_t *answer,
                            uint8_t *length, gsc_time *until)
{
    int32_t value = command->values[0];

    *length = say(answer, "Y");
    switch ((enum command)command->row->command) {
    case PROGRAM: begin_program_entry(g); break;
    case PROGRAM_END: g->program.is_entering = false; break;
    case EXECUTE: *length = say(answer, execute(g)); break;
    case HOME: *length = say(answer, home(g, value)); break;
    case KILL: return kill(g, until);
    case ZERO_SPEED: return zero_speed(g, until);
    case INITIALIZE: return initialize_now(g, value, until);
    case FORCE: g->position = value; break;
    case FEEDBACK: *length = say(answer, feed_back(g)); break;
    case VERIFY: *length = verify(g, value, answer); break;
    case QUERY: return IS_LISTED;
    case MEMORIZE: write_program(g, is_checked); return IS_ANSWERED_LATER;
    case EXCHANGE: *length = say(answer, recall_program(g) ? "Y" : "E6"); break;
    default: break; /* the others are executed by a program only */
    }
    return IS_ANSWERED;
}

enum outcome obey_command(struct gsc *g, const uint8_t *text, uint8_t count, bool is_checked, uint8_t *answer,
                          uint8_t *length, gsc_time *until)
{
    struct command_line command;
    enum reading reading = read_command(g, text, count, &command);
    bool is_now = reading == IS_COMMAND && (command.row->when & state_of(g));
    const char *refusal;

    if (!g->eeprom.is_writing && is_now)
        return perform(g, &command, is_checked, answer, length, until);
    if (g->eeprom.is_writing || is_running(g))
        refusal = "B";
    else if (reading == IS_WRONG_ARGUMENT)
        refusal = "E2";
    else if (reading == IS_UNKNOWN || !g->program.is_entering || !command.row->size)
        refusal = "E4";
    else
        refusal = store_instruction(g, &command) ? "Y" : "E3";
    *length = say(answer, refusal);
    return IS_ANSWERED;
}
