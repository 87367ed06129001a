/* The serial port: 500 kbaud 8N1. */
#include "hal.h"
#include "serial.h"

volatile uint8_t received[RING];
volatile uint8_t received_head;
uint8_t received_tail;

volatile uint8_t sending[TX_RING];
volatile uint8_t sending_head, sending_tail;

void set_up_serial(void)
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

void hal_put_byte(uint8_t byte)
{
    uint8_t next = (sending_head + 1) & (TX_RING - 1);

    while (next == sending_tail)
        ;
    sending[sending_head] = byte;
    /* Uninterrupted: a long input sample in between could empty the buffer, and then an invalid byte would be sent. */
    cli();
    sending_head = next;
    UCSR0B |= _BV(UDRIE0);
    sei();
}
