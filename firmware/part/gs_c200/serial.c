#include "serial.h"

#include <string.h>

#include "commands.h"
#include "pins.h"
#include "sheet.h"

#define CARRIAGE_RETURN 0x0d

enum phase {
    NOTHING_COMES,
    TURNING_ROUND, /* the carriage return has arrived */
    IS_DUE,        /* the string is executed with the other changes of this instant */
    OBEYING,       /* during its time */
    ANSWERING
};

void listen_to_host(struct gsc *g)
{
    g->serial.rate = (uint8_t)(g->inputs / GSC_BR0 & 7);
    g->serial.address = addresses[g->inputs / GSC_SEL0 & 7];
    g->serial.listens = true;
}

uint16_t gsc_baud(const struct gsc *g)
{
    return g->serial.listens ? rates[g->serial.rate].baud : 0;
}

/* The low seven bits of the sum of the codes, one of them always set: never a carriage return (GSC-CON-CHK-OR). */
static uint8_t checksum(const uint8_t *text, uint8_t length)
{
    uint8_t sum = 0;

    while (length--)
        sum = (uint8_t)(sum + *text++);
    return (uint8_t)((sum & 0x7fU) | CHECKSUM_BIT);
}

/* ------------------------------------------------------------------------------------------------------------ answers */
static void send_character(struct gsc *g)
{
    gsc_on_character(g, g->serial.answer[g->serial.sent++], g->now);
    start_timer(g, GSC_SERIAL_TIMER, rates[g->serial.rate].character_ps);
}

/* Send `answer`. */
static void begin_answer(struct gsc *g, uint8_t length, bool is_checked)
{
    uint8_t *answer = g->serial.answer;

    if (is_checked) {
        answer[length] = checksum(answer, length);
        length++;
    }
    answer[length++] = CARRIAGE_RETURN;
    g->serial.length = length;
    g->serial.sent = 0;
    g->serial.phase = ANSWERING;
    set_pin(g, GSC_TALK, true);
    send_character(g);
}

/* Take the string, or the answer to M, that is first in the queue. */
static void begin_next(struct gsc *g)
{
    struct gsc_line *line = g->serial.queue;

    if (!g->serial.waiting) {
        g->serial.phase = NOTHING_COMES;
    } else if (line->is_answer) {
        memcpy(g->serial.answer, line->text, line->length);
        begin_answer(g, line->length, line->is_checked);
    } else {
        begin_work(g, LINE_WORK);
        g->serial.phase = gsc_is_before(g->now, line->due) ? TURNING_ROUND : IS_DUE;
        if (g->serial.phase == TURNING_ROUND)
            start_timer_at(g, GSC_SERIAL_TIMER, line->due);
    }
}

static void queue(struct gsc *g, const struct gsc_line *line)
{
    g->serial.queue[g->serial.waiting++] = *line;
    if (g->serial.waiting == 1)
        begin_next(g);
}

static void leave_queue(struct gsc *g)
{
    g->serial.waiting--;
    memmove(g->serial.queue, g->serial.queue + 1, g->serial.waiting * sizeof *g->serial.queue);
    begin_next(g);
}

void answer_memorize(struct gsc *g, bool is_good)
{
    struct gsc_line line = {.is_answer = true, .is_checked = g->eeprom.is_checked};

    memcpy(line.text, is_good ? "Y" : "E6", 2);
    line.length = is_good ? 1 : 2;
    queue(g, &line);
}

static void list_next(struct gsc *g)
{
    bool is_end;
    uint8_t length = list_program(g, &g->serial.list_at, &is_end, g->serial.answer);

    g->serial.is_listing = !is_end;
    begin_answer(g, length, g->serial.queue->is_checked);
}

/* ---------------------------------------------------------------------------------------------------------- reception */
static bool has_right_checksum(const struct gsc_line *line)
{
    uint8_t length = (uint8_t)(line->length - 1);

    return line->text[length] == checksum(line->text, length);
}

/* Return whether the string is for this module; one with a faulty address is not (GSC-UND-ADDR-FAULT, GSC-UND-EMPTY). */
static bool is_meant(const struct gsc *g, const struct gsc_line *line)
{
    if (!g->serial.address)
        return line->length > 0;
    return line->length > 1 && !line->is_first_faulty && line->text[0] == '0' + g->serial.address;
}

static enum outcome obey_string(struct gsc *g, const struct gsc_line *line, uint8_t *length, gsc_time *until)
{
    uint8_t *answer = g->serial.answer;
    uint8_t first = g->serial.address ? 1 : 0;

    if (line->is_faulty || line->is_too_long || (line->is_checked && !has_right_checksum(line))) {
        memcpy(answer, "E1", 2);
        *length = 2;
        return IS_ANSWERED;
    }
    return obey_command(g, line->text + first, (uint8_t)(line->length - first - line->is_checked), line->is_checked, answer,
                        length, until);
}

static void answer(struct gsc *g, uint8_t length)
{
    end_work(g, LINE_WORK);
    begin_answer(g, length, g->serial.queue->is_checked);
}

static void finish(struct gsc *g)
{
    finish_command(g);
    answer(g, 1); /* Y, which was prepared at its start */
}

static void obey(struct gsc *g)
{
    const struct gsc_line *line = g->serial.queue;
    uint8_t length = 0;
    gsc_time until = g->now;

    if (!is_meant(g, line)) {
        end_work(g, LINE_WORK);
        leave_queue(g);
        return;
    }
    switch (obey_string(g, line, &length, &until)) {
    case IS_ANSWERED: answer(g, length); break;
    case IS_LISTED:
        end_work(g, LINE_WORK);
        g->serial.list_at = 0;
        list_next(g);
        break;
    case IS_ANSWERED_LATER:
        end_work(g, LINE_WORK);
        leave_queue(g);
        break;
    case TAKES_TIME:
        g->serial.phase = OBEYING;
        if (until == g->now)
            finish(g);
        else
            start_timer_at(g, GSC_SERIAL_TIMER, until);
        break;
    }
}

void obey_strings(struct gsc *g)
{
    while (g->serial.phase == IS_DUE)
        obey(g);
}

void serial_timed(struct gsc *g)
{
    switch ((enum phase)g->serial.phase) {
    case TURNING_ROUND: g->serial.phase = IS_DUE; break;
    case OBEYING: finish(g); break;
    case ANSWERING:
        if (g->serial.sent < g->serial.length) {
            send_character(g);
        } else if (g->serial.is_listing) {
            list_next(g);
        } else {
            set_pin(g, GSC_TALK, false);
            leave_queue(g);
        }
        break;
    case NOTHING_COMES:
    case IS_DUE: break;
    }
}

/* A carriage return ends the string; more than 11 characters make it too long (GSC-UND-MAXLEN). */
void receive_character(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end)
{
    struct gsc_line *line = &g->serial.coming;

    if (!g->serial.listens)
        return;
    if (character == CARRIAGE_RETURN) {
        line->is_faulty |= faults != 0;
        line->is_checked = is_high(g, GSC_CHS);
        line->due = end + TURNROUND_PS;
        if (g->serial.waiting < 2)
            queue(g, line);
        *line = (struct gsc_line){0};
    } else if (line->length < GSC_LONGEST) {
        line->is_first_faulty |= !line->length && faults;
        line->is_faulty |= faults != 0;
        line->text[line->length++] = character;
    } else {
        line->is_too_long = true;
    }
}
