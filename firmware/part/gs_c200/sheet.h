/* The GS-C200/GS-C200S data sheet as tables.  Written by tools/part_tables.py from src/slewline/chips/gs_c200/sheet.py: change it there. */
#ifndef SHEET_H
#define SHEET_H

#include <stdbool.h>
#include <stdint.h>

/* Times, in picoseconds, each with its meaning and its section. */
#define CLOCK_PS 1700000ULL /* CLOCK low; at most 5 us: pin 28; electrical characteristics */
#define RESET_PS 400000000ULL /* RESET low; at most 500 us: pin 27; electrical characteristics */
#define DIR_SETUP_PS 10000000ULL /* DIR and MOV to the first step: figure 2 */
#define DELAY_UNIT_PS 100000000000ULL /* the unit of D: command D */
#define INSTRUCTION_PS 1000000000ULL /* an instruction of a program, before its effect: program examples */
#define TURNROUND_PS 1000000000ULL /* carriage return to answer: data exchange protocol */
#define RELEASE_PS 5000000ULL /* ENABLE high to the step that it held: pin 24 */
#define EEPROM_PS 1200000000000ULL /* M with a full memory: 119 bytes and a check byte, 10 ms each: command M */
#define STORE_LOOK_PS 10000000000ULL /* interval of sampling an EEPROM that is still busy */

#define RATE_UNIT 10U /* steps/s: motion characteristics */
#define CHECKSUM_BIT 0x10U /* always set: data exchange protocol */
#define INVALID_BYTE 0xffU /* not an opcode: the first byte after an interrupted write */
#define C200_LEAST (0) /* of the position counter */
#define C200_MOST 9999999
#define C200S_LEAST (-8388608) /* of the position counter */
#define C200S_MOST 8388607

enum command {
    ACTIVATE,
    CLEAR,
    DELAY,
    EXECUTE,
    FEEDBACK,
    HOME,
    KILL,
    LOOP_START,
    LOOP,
    MEMORIZE,
    QUERY,
    RAMP,
    START_STOP,
    TOP_SPEED,
    UNTIL,
    VERIFY,
    WAIT,
    EXCHANGE,
    ZERO_SPEED,
    MOVE,
    GOTO,
    VELOCITY,
    CONTROLLED_VELOCITY,
    INITIALIZE,
    PROGRAM,
    FORCE,
    JUMP,
    JUMP_ON,
    PROGRAM_END,
    FOREIGN /* a command of the other part */
};

/* The form of an argument: a number, with or without a sign; a sign alone, which may be optional. */
enum sign { UNSIGNED, SIGNED, WITH_SIGN, WITH_SIGN_BUT_0, SIGN_ALONE, SIGN_IF_ANY };

/* The states in which a command is executed directly. */
enum state { IDLE = 1, ENTERING = 2, RUNNING = 4 };

struct arg {
    int32_t low, high;
    uint8_t sign;
    uint8_t size; /* bytes in the program memory; 0: it is added to the opcode */
};

/* One form of a command.  Forms with the same letters are adjacent; the first that fits is used. */
struct row {
    char head[3]; /* empty: the sign of the argument */
    char tail[3]; /* alternative last letters, the standard one first */
    uint8_t command;
    uint8_t args;
    uint8_t code; /* in the program memory; the codes are the model's own */
    uint8_t size; /* locations there; 0: it is never stored */
    uint8_t when; /* states in which it is executed directly */
    bool is_motion;
    struct arg arg[2];
};

struct rate {
    uint16_t baud;
    uint64_t character_ps; /* start bit, 7 data bits, parity, 2 stop bits */
};

#define C200_ROWS 32
extern const struct row c200_rows[C200_ROWS];
#define C200S_ROWS 30
extern const struct row c200s_rows[C200S_ROWS];
extern const struct rate rates[8]; /* by BR2, BR1, BR0 as a number */
extern const uint8_t addresses[8]; /* by SEL2, SEL1, SEL0 as a number */

#define LEVELS_AT_RESET (1U << 3 /* DIR */ | 1U << 4 /* RESET */) /* pin description */

#endif
