#include "store.h"

#include <string.h>

#include "flash.h"
#include "sizes.h"

#define MAGIC 0x50435347u /* GSCP */

struct record {
    uint32_t magic, sequence;
    uint8_t length;
    uint8_t program[STORE_MOST];
    uint32_t crc; /* of all fields before it */
};
_Static_assert(sizeof(struct record) == 132, "a record has no holes, and fits into a page");

static const uint32_t PLACES[2] = {STORE_A, STORE_B};

static struct record kept;    /* the valid record, because X has no time to read the flash */
static struct record record;  /* the record being read or written */
static uint8_t next;          /* the sector to be written next */
static int length;            /* of the valid program; -1: none is valid */
static enum { AT_REST, VOIDING, ERASING, PROGRAMMING } phase;

static uint32_t crc32_of(const void *data, uint32_t count)
{
    const uint8_t *from = data;
    uint32_t crc = 0xFFFFFFFFu;
    while (count--) {
        crc ^= *from++;
        for (unsigned bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

static bool is_valid(const struct record *of)
{
    return of->magic == MAGIC && of->length <= STORE_MOST && of->crc == crc32_of(of, sizeof *of - sizeof of->crc);
}

static bool is_erased(const struct record *of)
{
    const uint8_t *byte = (const uint8_t *)of;
    for (uint32_t at = 0; at < sizeof *of; at++)
        if (byte[at] != 0xFF)
            return false;
    return true;
}

void store_start(void)
{
    bool found = false, erased = true;
    next = 0;
    for (uint8_t place = 0; place < 2; place++) {
        flash_read(PLACES[place], (uint8_t *)&record, sizeof record);
        if (!is_erased(&record))
            erased = false;
        if (is_valid(&record) && (!found || (int32_t)(record.sequence - kept.sequence) > 0)) {
            found = true;
            kept = record;
            length = record.length;
            next = (uint8_t)(1 - place);
        }
    }
    if (!found)
        length = erased ? 0 : -1;
}

int store_recall(uint8_t *program)
{
    if (length > 0)
        memcpy(program, kept.program, (uint32_t)length);
    return length;
}

static void erase(void)
{
    flash_erase(PLACES[next]);
    phase = ERASING;
}

void store_begin(const uint8_t *program, uint8_t count)
{
#ifdef STORE_LIKE_THE_MODEL
    static const uint8_t NOTHING[sizeof record.magic] = {0};
    flash_program(PLACES[1 - next], NOTHING, sizeof NOTHING);
    phase = VOIDING;
#else
    erase();
#endif
    memset(&record, 0, sizeof record);
    record.magic = MAGIC;
    record.sequence = kept.sequence + 1;
    record.length = count;
    memcpy(record.program, program, count);
    record.crc = crc32_of(&record, sizeof record - sizeof record.crc);
}

bool store_go_on(bool *is_good)
{
    if (phase == AT_REST || flash_is_busy())
        return false;
    if (phase == VOIDING) {
        erase();
        return false;
    }
    if (phase == ERASING) {
        flash_program(PLACES[next], (const uint8_t *)&record, sizeof record);
        phase = PROGRAMMING;
        return false;
    }
    phase = AT_REST;
    struct record written;
    flash_read(PLACES[next], (uint8_t *)&written, sizeof written);
    *is_good = memcmp(&written, &record, sizeof record) == 0;
    if (*is_good) {
        next = (uint8_t)(1 - next);
        kept = record;
        length = record.length;
    }
#ifdef STORE_LIKE_THE_MODEL
    else
        length = -1;
#endif
    return true;
}

bool store_is_writing(void)
{
    return phase != AT_REST;
}
