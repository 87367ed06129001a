#include <avr/interrupt.h>
#include <avr/io.h>
#include <string.h>
#include <util/crc16.h>

#include "protocol.h"
#include "sizes.h"
#include "wire.h"

/* Rings, whose other ends are in interrupts.S. */
volatile uint8_t received[RING];
volatile uint8_t received_head;
static uint8_t received_tail;

volatile uint8_t sending[TX_RING];
volatile uint8_t sending_head, sending_tail;

uint8_t frame[FRAME_MOST + 1];
uint8_t frame_length;

/* The chunk that is coming. */
static uint8_t encoded; /* bytes of it so far */
static uint8_t decoded;
static uint8_t group;    /* bytes until the next code */
static uint8_t implied;  /* a 0 belongs between this group and the next */
static uint8_t hopeless; /* too long */
static uint16_t crc = 0xFFFF;

void set_up_wire(void)
{
    UBRR0 = 3; /* 16 MHz / 8 / (3 + 1) */
    UCSR0A = _BV(U2X0);
    UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
    UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

void serve_line(void)
{
    while (UCSR0A & _BV(RXC0)) {
        received[received_head] = UDR0;
        received_head = (received_head + 1) & (RING - 1);
    }
}

static inline void put(uint8_t byte)
{
    frame[decoded++] = byte;
    crc = _crc_ccitt_update(crc, byte);
}

/* CRC-16/X-25: behind a sound frame with its own CRC the register is 0xF0B8. */
static int8_t end_of_chunk(void)
{
    int8_t verdict = 0;

    if (encoded) {
        verdict = hopeless || group || decoded < 4 || crc != 0xF0B8 ? -1 : 1;
        frame_length = decoded - 2;
    }
    encoded = decoded = group = implied = hopeless = 0;
    crc = 0xFFFF;
    return verdict;
}

int8_t listen(void)
{
    while (received_tail != received_head) {
        uint8_t byte = received[received_tail];

        received_tail = (received_tail + 1) & (RING - 1);
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
            group = byte - 1;
        }
    }
    return 0;
}

static void transmit(uint8_t byte)
{
    uint8_t next = (sending_head + 1) & (TX_RING - 1);

    while (next == sending_tail)
        ;
    sending[sending_head] = byte;
    /* In one piece: a long look in between could send all there is, and then nothing would be sent as a byte. */
    cli();
    sending_head = next;
    UCSR0B |= _BV(UDRIE0);
    sei();
}

#define PAYLOAD_MOST 16

void send(uint8_t number, uint8_t kind, const void *payload, uint8_t length)
{
    uint8_t plain[2 + PAYLOAD_MOST + 2];
    uint8_t i, from = 0, total = length + 4;
    uint16_t check = 0xFFFF;

    plain[0] = number;
    plain[1] = kind;
    memcpy(plain + 2, payload, length);
    for (i = 0; i < total - 2; i++)
        check = _crc_ccitt_update(check, plain[i]);
    check = ~check;
    plain[i] = check;
    plain[i + 1] = check >> 8;
    /* Each group: how far it is to the next 0, which itself is left out, and what lies before it. */
    while (from <= total) {
        uint8_t to = from;

        while (to < total && plain[to])
            to++;
        transmit(to - from + 1);
        while (from < to)
            transmit(plain[from++]);
        from++;
    }
    transmit(0);
}
