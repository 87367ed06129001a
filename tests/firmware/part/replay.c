/* The core as a library: what came in at the pins of a module, in the order of time, is given to it; what goes out is kept.

   The EEPROM follows the model, also where the supply fails in the midst of a write. */
#include <stdint.h>
#include <string.h>

#include "gsc200.h"
#include "sheet.h"

enum kind { ON, OFF, INPUTS, INPUTS_AFTER, CHARACTER, FAULT, END };

struct event {
    int64_t at, end;
    int32_t kind, value;
};

struct out {
    int64_t *step_times, *pin_times, *character_times;
    int32_t *positions, *pins, *characters; /* a pin: number * 4 + level + 1 */
    int8_t *directions;
    int64_t most, steps, pin_count, character_count;
    int64_t baud;  /* of the line at the end; 0: nothing listens */
    int64_t wrong; /* steps foreseen that do not come or the other way round; levels reported that are none */
};

static struct gsc module;
static struct out *out;
static uint64_t offset;
static int is_on, leaps;
static int shown[GSC_PINS]; /* -1: not yet, since the supply came */

static struct {
    uint8_t content[GSC_LOCATIONS + 2], program[GSC_LOCATIONS];
    int length, size, fault, looks;
    int saving, is_written; /* a write is under way; only its end has not been noticed */
    int64_t since;
} store;

static int64_t told(gsc_time now)
{
    return (int64_t)(now - offset);
}

static void note_pin(int64_t now, int pin, int level)
{
    if (out->pin_count < out->most) {
        out->pin_times[out->pin_count] = now;
        out->pins[out->pin_count] = pin * 4 + level + 1;
    }
    out->pin_count++;
}

void gsc_on_pin(struct gsc *g, enum gsc_pin pin, int level, gsc_time now)
{
    (void)g;
    out->wrong += shown[pin] == level;
    shown[pin] = level;
    note_pin(told(now), (int)pin, level);
}

void gsc_on_step(struct gsc *g, int direction, gsc_time now)
{
    if (out->steps < out->most) {
        out->step_times[out->steps] = told(now);
        out->directions[out->steps] = (int8_t)direction;
        out->positions[out->steps] = g->position;
    }
    out->steps++;
}

void gsc_on_character(struct gsc *g, uint8_t character, gsc_time now)
{
    (void)g;
    if (out->character_count < out->most) {
        out->character_times[out->character_count] = told(now);
        out->characters[out->character_count] = character;
    }
    out->character_count++;
}

/* ------------------------------------------------------------------------------------------------------- the EEPROM */
static int64_t end_of_write(void)
{
    return store.since + (int64_t)(EEPROM_PS / (GSC_LOCATIONS + 1)) * (store.size + 1);
}

static int is_good(void)
{
    return store.is_written ? store.length == store.size && !memcmp(store.content, store.program, (size_t)store.size)
                            : !store.fault;
}

/* It has its new content at the end of the write, and is found busy for some looks from then on. */
static void finish_write(int64_t now)
{
    if (!store.saving || end_of_write() > now)
        return;
    if (!store.is_written) {
        store.is_written = 1;
        store.length = store.fault ? 1 : store.size;
        memcpy(store.content, store.program, (size_t)store.size);
        if (store.fault)
            store.content[0] = INVALID_BYTE;
    }
    if (end_of_write() + store.looks * (int64_t)STORE_LOOK_PS <= now) {
        store.saving = 0;
        gsc_stored(&module, is_good());
    }
}

/* The supply has failed: what has been written is new, the rest as it was. */
static void cut_write(int64_t now)
{
    int done = (int)((now - store.since) * (GSC_LOCATIONS + 1) / (int64_t)EEPROM_PS);
    int skip = store.length > 0 && store.content[0] == INVALID_BYTE, before = store.length - skip;
    uint8_t torn[GSC_LOCATIONS + 2];
    int length = done < store.size ? done : store.size;

    if (!store.saving)
        return;
    store.saving = 0;
    memcpy(torn, store.program, (size_t)length);
    for (int at = done; at < before && length <= GSC_LOCATIONS; at++)
        torn[length++] = store.content[skip + at];
    if (length == store.length && !memcmp(torn, store.content, (size_t)length))
        return;
    store.content[0] = INVALID_BYTE;
    memcpy(store.content + 1, torn, (size_t)length);
    store.length = length + 1;
}

void gsc_on_store(struct gsc *g, const uint8_t *program, uint8_t size, gsc_time now)
{
    store.saving = 1;
    store.is_written = 0;
    store.size = size;
    store.since = told(now);
    memcpy(store.program, program, size);
    if (leaps)
        gsc_stored(g, is_good());
}

int gsc_recall(struct gsc *g, uint8_t program[GSC_LOCATIONS])
{
    finish_write(told(g->now));
    if (store.length > GSC_LOCATIONS || (store.length && store.content[0] == INVALID_BYTE))
        return -1;
    memcpy(program, store.content, (size_t)store.length);
    return store.length;
}

/* ------------------------------------------------------------------------------------------------------- the replay */
/* As a board does: from deadline to deadline, a step prepared before it comes; or in one leap. */
static void advance(gsc_time now)
{
    gsc_time due, when;

    while ((!leaps || store.saving) && gsc_next(&module, &due) && !gsc_is_before(now, due)) {
        int64_t before = out->steps;
        int is_step = gsc_step_ahead(&module, &when) && when == due;

        finish_write(told(due));
        gsc_advance(&module, due);
        out->wrong += is_step != (out->steps > before);
        out->wrong += gsc_step_ahead(&module, &when) && !module.timer[GSC_RUN_TIMER].is_on;
    }
    gsc_advance(&module, now);
}

static void switch_off(int64_t now)
{
    advance((gsc_time)now + offset);
    finish_write(now);
    cut_write(now);
    is_on = 0;
    for (int pin = 0; pin < GSC_PINS; pin++)
        note_pin(now, pin, -1);
}

static void play(const struct event *event, enum gsc_part part)
{
    gsc_time now = (gsc_time)event->at + offset;

    if (is_on && event->kind != INPUTS && event->kind != CHARACTER)
        advance(now);
    else if (is_on && (!leaps || store.saving) && gsc_is_before(module.now, now))
        advance(now - 1);
    finish_write(event->at);
    switch (event->kind) {
    case ON:
        memset(shown, -1, sizeof shown);
        gsc_power_up(&module, part, (uint16_t)event->value, now);
        out->wrong += gsc_baud(&module) != 0;
        is_on = 1;
        break;
    case OFF:
        if (is_on)
            switch_off(event->at);
        break;
    case INPUTS:
    case INPUTS_AFTER:
        if (is_on)
            gsc_set_inputs(&module, (uint16_t)event->value, now);
        break;
    case CHARACTER:
        if (is_on)
            gsc_receive(&module, (uint8_t)event->value, (uint8_t)(event->value >> 8), (gsc_time)event->end + offset, now);
        break;
    case FAULT: store.fault = event->value; break;
    case END: break;
    }
}

void keep(const char *content, int32_t length, int32_t looks)
{
    memset(&store, 0, sizeof store);
    store.length = length;
    store.looks = looks;
    memcpy(store.content, content, (size_t)(length > GSC_LOCATIONS ? GSC_LOCATIONS : length));
}

/* What the EEPROM holds; return how many bytes. */
int32_t kept(uint8_t *content)
{
    memcpy(content, store.content, (size_t)store.length);
    return store.length;
}

void replay(const struct event *events, int64_t count, int32_t part, uint64_t from, struct out *into)
{
    out = into, offset = from, is_on = 0, leaps = (from & 1) && !store.looks;
    out->steps = out->pin_count = out->character_count = out->wrong = 0;
    for (int64_t i = 0; i < count; i++)
        play(&events[i], part ? GSC_C200S : GSC_C200);
    out->baud = is_on ? gsc_baud(&module) : 0;
}
