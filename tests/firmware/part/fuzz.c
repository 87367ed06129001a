/* Bytes at random for the core, under sanitizers: fuzz SEED BYTES.  Laws hold whatever comes.

   A byte is a character of RXD with its faults, new levels of inputs, an end of the supply, or time that passes; most are
   characters of the language, so that programs are stored, run and killed. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gsc200.h"

#define US 1000000ULL
#define SHORTEST (100 * US) /* between two steps */

static const char LETTERS[] = "\r\r\r\r\r\r\r\r\rPoPxEEFFVQMXKZHLRSTUWDACIGgfjc+-+-,0011123456789\n ";
static struct gsc module;
static uint64_t state, bytes, steps, answers, stored, runs, now, last_step;
static int has_stepped, storing;
static uint8_t kept[GSC_LOCATIONS];
static int kept_size;
static uint16_t levels;

static void demand(int is_so, const char *law)
{
    if (is_so)
        return;
    fprintf(stderr, "%s, after %llu bytes\n", law, (unsigned long long)bytes);
    exit(1);
}

static uint64_t chance(void)
{
    state ^= state << 13, state ^= state >> 7, state ^= state << 17;
    return state;
}

static uint8_t next_byte(void)
{
    bytes++;
    return (uint8_t)(chance() >> 24);
}

static void in_order(gsc_time at)
{
    demand(!gsc_is_before(at, now), "an output lies before its input");
    now = at;
}

void gsc_on_pin(struct gsc *g, enum gsc_pin pin, int level, gsc_time at)
{
    in_order(at);
    demand(pin < GSC_PINS && (level == 0 || level == 1), "a pin has a level");
    levels = (uint16_t)((levels & ~(1U << pin)) | (unsigned)level << pin);
    runs += pin == GSC_MOV && level;
    demand(!(levels >> GSC_RAMP & 1) || levels >> GSC_MOV & 1 || pin == GSC_MOV, "RAMP is high in a motion alone");
    demand(g == &module, "the part is known");
}

void gsc_on_step(struct gsc *g, int direction, gsc_time at)
{
    in_order(at);
    demand(levels >> GSC_MOV & 1, "MOV is high at a step");
    demand((levels >> GSC_DIR & 1) == (direction > 0), "DIR shows the direction of a step");
    demand(g->inputs & GSC_ENABLE, "ENABLE is high at a step");
    demand(!has_stepped || at - last_step >= SHORTEST, "steps are 100 us apart");
    last_step = at, has_stepped = 1;
    steps++;
}

void gsc_on_character(struct gsc *g, uint8_t character, gsc_time at)
{
    in_order(at);
    demand(gsc_baud(g) != 0 && character < 128, "an answer has seven bits");
    demand(character >= 0x10 || character == '\r', "an answer is text");
    answers += character == '\r';
}

void gsc_on_store(struct gsc *g, const uint8_t *program, uint8_t size, gsc_time at)
{
    in_order(at);
    demand(size <= GSC_LOCATIONS && g, "a program fits");
    memcpy(kept, program, size);
    kept_size = chance() % 8 ? size : -1;
    storing = 1;
    stored++;
}

int gsc_recall(struct gsc *g, uint8_t program[GSC_LOCATIONS])
{
    (void)g;
    if (kept_size > 0 && chance() % 16 == 0) /* the EEPROM has aged */
        kept[chance() % (unsigned)kept_size] = (uint8_t)chance();
    if (chance() % 32 == 0) { /* it cannot be read: what is in the buffer counts for nothing */
        memset(program, 'l', GSC_LOCATIONS);
        return -1;
    }
    if (kept_size > 0)
        memcpy(program, kept, (size_t)kept_size);
    return kept_size;
}

static void check(void)
{
    gsc_time due, when;
    int32_t least = module.part == GSC_C200S ? -8388608 : 0, most = module.part == GSC_C200S ? 8388607 : 9999999;

    demand(module.position >= least && module.position <= most, "the position counter has its range");
    demand(module.program.size <= GSC_LOCATIONS && module.serial.waiting <= 3, "what is kept fits");
    if (gsc_next(&module, &due))
        demand(!gsc_is_before(due, module.now), "a deadline lies ahead");
    if (gsc_step_ahead(&module, &when))
        demand(!gsc_is_before(when, module.now) && module.inputs & GSC_ENABLE, "a step lies ahead");
}

static void begin(void)
{
    has_stepped = storing = 0;
    levels = 0;
    gsc_power_up(&module, chance() % 2 ? GSC_C200S : GSC_C200, (uint16_t)(0x7fffU & ~(next_byte() & 0xf8U)), now);
}

static void let_pass(uint64_t ps)
{
    gsc_time due;

    if (ps > 200000 * US && gsc_next(&module, &due) && module.motion.is_moving)
        ps = 200000 * US; /* a run without end need not be long */
    gsc_advance(&module, module.now + ps);
    if (storing && chance() % 4) {
        gsc_stored(&module, kept_size >= 0);
        storing = module.eeprom.is_writing;
    }
}

static void character(uint8_t code, uint8_t faults)
{
    gsc_time at = module.now + 900 * US;

    gsc_receive(&module, code, faults, at + 300 * US, at);
}

/* # is a number. */
static const char *const COMMANDS[] = {
    "S#", "T#", "R#", "S1", "R1", "+#", "-#", "+1", "G#", "G-#", "G+", "g-", "g+1", "G-2", "g-3", "A1", "C2", "D1", "L0", "L#", "j#",
    "jc7,0", "jc#,#", "U1", "U2", "W1", "I1", "I3", "f+#", "f-8388608", "f+8388607", "E", "E", "E", "H", "H-", "K", "Z", "F", "V1", "V2",
    "Q", "M", "X", "Po", "P", "Px", "Po\rS#\rT#\rR#\r+#\rE", "P\rS9\rT#\rR#\r-#\rG#\rE", "Po\rS9\rT9#\rR#\rg+1\rE",
    "P\rS9\rT9#\rR7\rG-\rE", "Po\rS99\rT99#\rR#\r-#\rL#\rE",
};

static void command(void)
{
    const char *text = COMMANDS[next_byte() % (sizeof COMMANDS / sizeof *COMMANDS)];

    for (; *text; text++)
        if (*text != '#') {
            character((uint8_t)*text, 0);
            if (*text == '\r')
                let_pass(10000 * US);
        } else {
            for (unsigned digits = next_byte() % 4U, first = 1; first || digits--; first = 0)
                character((uint8_t)('0' + next_byte() % 10), 0);
        }
    character('\r', 0);
    let_pass(10000 * US);
}

static void act(uint8_t byte)
{
    if (byte < 100)
        command();
    else if (byte < 200)
        character((uint8_t)LETTERS[byte % (sizeof LETTERS - 1)], 0);
    else if (byte < 205)
        character(next_byte() & 127, next_byte() % 4);
    else if (byte < 225)
        gsc_set_inputs(&module, (uint16_t)(module.inputs ^ 1U << next_byte() % 15), module.now + (byte & 1U) * US);
    else if (byte < 235)
        gsc_set_inputs(&module, (uint16_t)(module.inputs | 0x7e00U), module.now);
    else if (byte < 251)
        let_pass((uint64_t)next_byte() << (next_byte() % 30) << 4);
    else if (byte < 254)
        let_pass(3000000 * US);
    else if (next_byte() < 60)
        begin();
}

int main(int count, char **given)
{
    uint64_t most = count > 2 ? strtoull(given[2], 0, 10) : 1000000;

    state = 0x9e3779b97f4a7c15ULL * (count > 1 ? strtoull(given[1], 0, 10) : 1) + 1;
    now = chance();
    begin();
    while (bytes < most) {
        act(next_byte());
        now = module.now;
        check();
    }
    printf("%llu bytes, %llu steps, %llu motions, %llu answers, %llu programs kept\n", (unsigned long long)bytes,
           (unsigned long long)steps, (unsigned long long)runs, (unsigned long long)answers, (unsigned long long)stored);
    return 0;
}
