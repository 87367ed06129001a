#include "serial.h"

#include "pins.h"
#include "pio_code.h"
#include "registers.h"

enum { IN, OUT }; /* machines of PIO 1 */

/* A bit is 2 x (n + 3) cycles; n is in OSR.  Start bit, seven of data, parity and the first stop bit are sampled in
   their middle; a start bit that is no longer low in its middle was a spike. */
enum { BIT = 6 };
static const uint16_t RECEIVE[] = {
    WAIT_PIN(1),
    WAIT_PIN(0),
    MOV_X_OSR,
    JMP_X_AND_COUNT(3),
    JMP_PIN(0),
    SET_Y(8),
    [BIT] = MOV_X_OSR,
    JMP_X_AND_COUNT(BIT + 1) | DELAY(1),
    IN_PINS(1),
    JMP_Y_AND_COUNT(BIT) | DELAY(1),
    PUSH,
};

/* A bit is n + 6 cycles; n is in ISR.  A word is a number of cycles to wait, in 21 bits, and ten bits from the start bit
   to the first stop bit; the second one is the remaining time while the next word is taken. */
enum { SEND = 11, WAIT = SEND + 2, SEND_BIT = SEND + 4, SECOND_STOP = SEND_BIT + 4 };
static const uint16_t TRANSMIT[] = {
    PULL,
    OUT_X(21),
    JMP_X_AND_COUNT(WAIT),
    SET_Y(9),
    OUT_PINS(1) | DELAY(2), /* SEND_BIT */
    MOV_X_ISR,
    JMP_X_AND_COUNT(SEND_BIT + 2),
    JMP_Y_AND_COUNT(SEND_BIT),
    MOV_X_ISR, /* SECOND_STOP */
    JMP_X_AND_COUNT(SECOND_STOP + 1),
};
enum {
    BEFORE_START = 5, /* from the write of a word to the start bit, with a wait of 0 */
    LONGEST_WAIT = (1 << 21) - 1,
    SEEN_LATE = 30, /* from the middle of the stop bit to the stamp of the interrupt */
    WAITING = 8
};

static uint32_t bit;
static cycles free_at; /* the end of the last character sent */
static struct {
    uint32_t word, stamp;
} queue[WAITING];
static volatile uint8_t came, taken;

void serial_begin(uint16_t baud)
{
    bit = CLOCK_HZ / baud;
    CLEAR(PIO_CTRL(PIO1)) = 3;
    for (unsigned place = 0; place < sizeof RECEIVE / sizeof *RECEIVE; place++)
        PIO_MEMORY(PIO1, place) = RECEIVE[place];
    for (unsigned place = 0; place < sizeof TRANSMIT / sizeof *TRANSMIT; place++)
        PIO_MEMORY(PIO1, SEND + place) = TRANSMIT[place];
    PIO_EXECCTRL(PIO1, IN) = WRAP(0, SEND - 1) | (uint32_t)PIN_RXD << 24;
    PIO_SHIFTCTRL(PIO1, IN) = 3u << 18; /* to the right: the lowest bit comes first */
    PIO_PINCTRL(PIO1, IN) = (uint32_t)PIN_RXD << 15;
    PIO_TX(PIO1, IN) = bit / 2 - 3;
    PIO_INSTR(PIO1, IN) = PULL;
    PIO_INSTR(PIO1, IN) = JMP(1); /* a line already at space is in a start bit */

    PIO_EXECCTRL(PIO1, OUT) = WRAP(SEND, SECOND_STOP + 1);
    PIO_SHIFTCTRL(PIO1, OUT) = 3u << 18;
    PIO_PINCTRL(PIO1, OUT) = 1u << 26 | 1u << 20 | (uint32_t)PIN_TXD << 5 | PIN_TXD;
    PIO_INSTR(PIO1, OUT) = SET_PINS(1);
    PIO_INSTR(PIO1, OUT) = SET_DIRECTIONS(1);
    PIO_TX(PIO1, OUT) = bit - 6;
    PIO_INSTR(PIO1, OUT) = PULL;
    PIO_INSTR(PIO1, OUT) = MOV_ISR_OSR;
    PIO_INSTR(PIO1, OUT) = JMP(SEND);
    PIO_INTE(PIO1) = 1 << IN;
    SET(PIO_CTRL(PIO1)) = 3;
}

cycles serial_length(void)
{
    return 11ull * bit;
}

static unsigned ones(uint32_t word)
{
    unsigned count = 0;
    for (; word; word &= word - 1)
        count++;
    return count;
}

bool serial_get(struct received *character)
{
    if (taken == came)
        return false;
    const uint32_t word = queue[taken % WAITING].word >> 23;
    const cycles middle = clock_of_stamp(queue[taken % WAITING].stamp) - SEEN_LATE;
    taken++;
    character->character = word & 0x7F;
    character->is_parity_wrong = ones(word & 0xFF) % 2 == 0;
    character->is_framing_wrong = !(word >> 8 & 1);
    character->at = middle;
    character->end = middle + bit + bit / 2;
    return true;
}

void serial_put(uint8_t character, cycles at, bool follows)
{
    const uint32_t parity = (ones(character & 0x7Fu) + 1) % 2;
    const uint32_t bits = (1u << 9 | parity << 8 | (character & 0x7Fu) << 1); /* and a start bit of 0 */
    hold();
    const cycles now = clock_now();
    uint32_t wait = 0;
    if (follows && (int64_t)(free_at - now) > 0)
        at = free_at;
    else if ((int64_t)(at - now) > BEFORE_START + 20)
        wait = (uint32_t)(at - now) - BEFORE_START - 20;
    PIO_TX(PIO1, OUT) = bits << 21 | (wait > LONGEST_WAIT ? LONGEST_WAIT : wait);
    let_go();
    free_at = ((int64_t)(at - now) > 0 ? at : now + BEFORE_START) + serial_length();
}

bool serial_is_waiting(void)
{
    return taken != came;
}

bool serial_is_empty(void)
{
    return PIO_FSTAT(PIO1) >> (24 + OUT) & 1;
}

bool serial_is_sending(void)
{
    return (int64_t)(free_at - clock_now()) > 0;
}

void serial_interrupt(void)
{
    const uint32_t stamp = clock_stamp();
    while (!(PIO_FSTAT(PIO1) & 1u << (8 + IN))) {
        const uint32_t word = PIO_RX(PIO1, IN);
        if ((uint8_t)(came - taken) < WAITING) {
            queue[came % WAITING].word = word;
            queue[came % WAITING].stamp = stamp;
            came++;
        }
    }
}
