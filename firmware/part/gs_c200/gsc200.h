/* A GS-C200 or GS-C200S: what comes in at its pins, and when; what goes out of them, and when.
 *
 *     RXD ------> gsc_receive()     gsc_on_character() ------> TXD
 *     inputs ---> gsc_set_inputs()  gsc_on_pin(), gsc_on_step() -> RDY, MOV, RAMP, DIR, RESET, UO; CLOCK
 *     EEPROM <--> gsc_recall(), gsc_on_store(), gsc_stored()
 *
 * Nothing here reads a clock, a register or the heap.  Whoever uses it
 *
 *     calls gsc_power_up() once, then gsc_advance() whenever the deadline of gsc_next() has come, and tells of every input
 *     and character when it comes; each of these calls may make any of the gsc_on_ calls, in the order of time;
 *
 * so the same files are the part on a board, and a library that tests compare with the model.  No call comes from within
 * another one, and no instant lies before that of the call before.
 *
 * Sections named in these files are those of the GS-C200/GS-C200S data sheet, June 1994; decisions where it is silent
 * carry the names of docs/reference/gs-c200.md, such as GSC-UND-TURNAROUND.
 */
#ifndef GSC200_H
#define GSC200_H

#include <stdbool.h>
#include <stdint.h>

#define GSC_LOCATIONS 119 /* of the program memory: program storage area */
#define GSC_LONGEST 11    /* characters of a string, without its carriage return: GSC-UND-MAXLEN */

/* An instant: picoseconds modulo 2^64, from any instant on.  No two that a part deals with at a time lie further apart
   than 2^63 ps, 106 days; so a part may stay switched on for longer than the 213 days after which they begin again. */
typedef uint64_t gsc_time;

static inline bool gsc_is_before(gsc_time one, gsc_time other)
{
    return (int64_t)(one - other) < 0;
}

enum gsc_part { GSC_C200, GSC_C200S };

/* The inputs, a bit each, as levels of the pins: 1 is high, and so is an input that is open (GSC-UND-OPEN-INPUTS). */
enum gsc_input {
    GSC_SEL0 = 1 << 0, /* pin 1 */
    GSC_SEL1 = 1 << 1,
    GSC_SEL2 = 1 << 2,
    GSC_BR0 = 1 << 3, /* pin 4 */
    GSC_BR1 = 1 << 4,
    GSC_BR2 = 1 << 5,
    GSC_CHS = 1 << 6,    /* pin 7 */
    GSC_REC = 1 << 7,    /* pin 9 */
    GSC_RXD = 1 << 8,    /* pin 11, RS-232: 1 is positive, the space; 0, also when open.  Only looked at for H+ or H- */
    GSC_ENABLE = 1 << 9, /* pin 24 */
    GSC_HOME = 1 << 10,  /* pin 30 */
    GSC_EOT = 1 << 11,   /* pin 32 */
    GSC_UI1 = 1 << 12,   /* pin 34 */
    GSC_UI2 = 1 << 13,   /* pin 36 */
    GSC_UI3 = 1 << 14    /* pin 37 */
};

/* The outputs, but for CLOCK and the characters of TXD. */
enum gsc_pin {
    GSC_RDY,   /* pin 14, open collector: 0 pulls it low, 1 lets go of it */
    GSC_MOV,   /* pin 22 */
    GSC_RAMP,  /* pin 23 */
    GSC_DIR,   /* pin 26: 1 clockwise */
    GSC_RESET, /* pin 27: 0 resets the driver */
    GSC_UO1,   /* pin 31 */
    GSC_UO2,   /* pin 33 */
    GSC_UO3,   /* pin 35 */
    GSC_TALK,  /* no pin: 1 while TXD is driven, 0 while it is left to other modules (pin 13) */
    GSC_PINS
};

/* What was wrong with a character. */
enum gsc_fault { GSC_PARITY = 1, GSC_FRAMING = 2 };

struct gsc_line { /* a string of the host, or an answer that comes late */
    gsc_time due;                   /* it is obeyed at this instant, or as soon as the one before it has its answer */
    uint8_t text[GSC_LONGEST];
    uint8_t length;
    bool is_faulty, is_first_faulty, is_too_long; /* it came with a fault; its first character did; it was cut off */
    bool is_checked;                /* CHS was high at its carriage return */
    bool is_answer;                 /* `text` is the answer to M */
};

/* Everything that a part knows.  To look at, not to change; what each field means is said where it is used. */
struct gsc {
    enum gsc_part part;
    gsc_time now;
    uint16_t inputs;
    uint16_t levels, shown; /* of the outputs, a bit for each gsc_pin: now, and as last told */

    struct { /* the registers of S, T and R, 0: never set; and what F reports once */
        uint16_t start_stop, top_speed, ramp;
        bool is_over; /* E5 */
    } reg;
    int32_t position;

    struct { /* the serial port: serial.c */
        uint8_t rate;    /* of RATES */
        uint8_t address; /* 0: point to point */
        bool listens;
        uint8_t waiting; /* strings in `queue`, the first of which is in progress */
        uint8_t phase, list_at;
        uint8_t answer_length, sent;
        gsc_time due;
        struct gsc_line coming, queue[3];
        uint8_t answer[GSC_LONGEST + 4];
    } serial;

    struct { /* the program memory and its run: program.c */
        uint8_t memory[GSC_LOCATIONS];
        uint8_t size, pc, at;
        bool entering, ending;
        uint8_t until;       /* user input of U at location 0, 0: none */
        bool loops;          /* a loop has begun, at `loop`, and made `passes` */
        uint8_t loop, passes;
    } program;

    struct { /* what runs besides a string of the host: program.c, motion.c */
        uint8_t phase;
        bool homes_first; /* a stand-alone start */
        bool is_timed;
        gsc_time due;
        gsc_time origin; /* of the looks of W */
        uint8_t watched; /* user input of W */
    } run;

    struct { /* the motion: motion.c, profile.c */
        bool moving, is_endless, stopping, stopped, homing;
        bool stop;          /* it shall come to rest; told to the motion with the other changes of an instant */
        int8_t sign;
        uint8_t way;        /* of a homing: out to EOT, or back to HOME */
        uint16_t start_stop, top_speed, ramp; /* as the motion began */
        uint16_t up, down;  /* intervals of the two ramps */
        bool no_ramp;
        uint32_t steps, step; /* of the plan, and the one that comes next; see OPEN in profile.c */
        uint64_t interval;
        gsc_time begun, end; /* of the last step, and of its interval */
    } motion;

    struct { /* the looks at the input that ends a run */
        uint8_t input;
        bool is_on;
        gsc_time due;
    } watch;

    struct { /* the EEPROM: eeprom.c */
        bool writing, is_checked;
        uint8_t result;
        gsc_time due;
    } eeprom;
};

/* ---------------------------------------------------------------------------------------------------------- what comes */

/* The supply has come: forget everything, and begin with the RESET pulse.  All outputs are told.  It may be called again
   at any instant: then the supply has been gone. */
void gsc_power_up(struct gsc *g, enum gsc_part part, uint16_t inputs, gsc_time now);

/* The inputs have new levels, bits of gsc_input.  Looks of this very instant have seen the levels before. */
void gsc_set_inputs(struct gsc *g, uint16_t inputs, gsc_time now);

/* The receiver has a character: now is the middle of its first stop bit, `end` the end of the second one.  Before
   gsc_baud() says a rate no character counts. */
void gsc_receive(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end, gsc_time now);

/* Let time pass up to an instant, and do what is due at it. */
void gsc_advance(struct gsc *g, gsc_time now);

/* What gsc_on_store() has begun is over.  The part answers after its own time for it, and no sooner than it has looked
   here, every 10 ms from then on. */
void gsc_stored(struct gsc *g, bool is_good);

/* ---------------------------------------------------------------------------------------------------------- what is next */

/* Return whether anything is due as things stand, and when; it may be now. */
bool gsc_next(const struct gsc *g, gsc_time *due);

/* Return whether the deadline of gsc_next() is a step, and will be one unless an input or a string changes it before:
   a board may prepare its pulse, and must be able to take it back.  The direction is at DIR already. */
bool gsc_step_ahead(const struct gsc *g);

/* Return the rate at which the part listens, 110 to 9600 baud, 7 data bits, odd parity, 2 stop bits; 0: it does not. */
uint16_t gsc_baud(const struct gsc *g);

/* ------------------------------------------------------------------------------- what goes out: brought by who uses this */

/* An output has another level, or its first one. */
void gsc_on_pin(struct gsc *g, enum gsc_pin pin, int level, gsc_time now);

/* A step: CLOCK falls now and rises 1.7 us later, whatever happens; 1 clockwise, -1 counter-clockwise. */
void gsc_on_step(struct gsc *g, int direction, gsc_time now);

/* The start bit of a character begins on TXD now.  The next one follows no sooner than it is over. */
void gsc_on_character(struct gsc *g, uint8_t character, gsc_time now);

/* M: begin to keep a program in the EEPROM, and call gsc_stored() when that is over.  The bytes stay as they are until
   then. */
void gsc_on_store(struct gsc *g, const uint8_t *program, uint8_t size, gsc_time now);

/* Return how many bytes the program in the EEPROM has, 0 to 119, written to `program`; -1: there is no valid one.  A new
   EEPROM has a program of 0. */
int gsc_recall(struct gsc *g, uint8_t program[GSC_LOCATIONS]);

#endif
