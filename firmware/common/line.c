#include <string.h>

#include "bytes.h"
#include "hal.h"
#include "line.h"

uint8_t frame[FRAME_MOST + 1];
uint8_t frame_length;

/* The chunk being received. */
static uint8_t encoded; /* bytes of it so far */
static uint8_t decoded;
static uint8_t group;    /* bytes until the next code */
static uint8_t implied;  /* a 0 belongs between this group and the next */
static uint8_t hopeless; /* the chunk is too long */
static uint16_t crc = 0xFFFF;

static inline void put(uint8_t byte)
{
    frame[decoded++] = byte;
    crc = hal_crc(crc, byte);
}

/* After a valid frame with its CRC, the register is 0xF0B8. */
static int8_t end_of_chunk(void)
{
    int8_t verdict = 0;

    if (encoded) {
        verdict = hopeless || group || decoded < 4 || crc != 0xF0B8 ? -1 : 1;
        frame_length = (uint8_t)(decoded - 2);
    }
    encoded = decoded = group = implied = hopeless = 0;
    crc = 0xFFFF;
    return verdict;
}

int8_t listen(void)
{
    uint8_t byte;

    while (hal_get_byte(&byte)) {
        if (!byte) {
            int8_t verdict = end_of_chunk();

            if (verdict)
                return verdict;
        } else if (hopeless) {
            ;
        } else if (++encoded > CHUNK_MOST) {
            hopeless = 1;
        } else if (group) {
            put(byte);
            group--;
        } else {
            if (implied)
                put(0);
            implied = byte != 0xFF;
            group = (uint8_t)(byte - 1);
        }
    }
    return 0;
}

void send(uint8_t number, uint8_t kind, const uint8_t *payload, uint8_t length)
{
    uint8_t plain[2 + PAYLOAD_MOST + 2];
    uint8_t i, from = 0, total = (uint8_t)(length + 4);
    uint16_t check = 0xFFFF;

    plain[0] = number;
    plain[1] = kind;
    memcpy(plain + 2, payload, length);
    for (i = 0; i < total - 2; i++)
        check = hal_crc(check, plain[i]);
    put16(plain + i, (uint16_t)~check);
    /* Each group: the distance to the next 0, which is omitted, and the bytes before it. */
    while (from <= total) {
        uint8_t to = from;

        while (to < total && plain[to])
            to++;
        hal_put_byte((uint8_t)(to - from + 1));
        while (from < to)
            hal_put_byte(plain[from++]);
        from++;
    }
    hal_put_byte(0);
}
