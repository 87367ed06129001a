/* A GS-C200 or GS-C200S: what comes in at its pins, and when; what goes out of them, and when.
 *
 *     RXD ------> gsc_receive()     gsc_on_character() ------> TXD
 *     inputs ---> gsc_set_inputs()  gsc_on_pin(), gsc_on_step() -> RDY, MOV, RAMP, DIR, RESET, UO; CLOCK
 *     EEPROM <--> gsc_recall(), gsc_on_store(), gsc_stored()
 *
 * Nothing here reads a clock, a register or the heap.  The caller
 *
 *     calls gsc_power_up(), then gsc_advance() whenever the deadline of gsc_next() has come, and passes on every input and
 *     every character when it comes; each of these calls may make any of the gsc_on_ calls, in the order of time;
 *
 * so the same files are the part on a board, and a library that tests compare with the model.  No call may come from a
 * gsc_on_ call, but for gsc_stored(), and no instant may be earlier than that of the call before.
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

/* An instant: picoseconds modulo 2^64, from any instant on.  No two that a part deals with at a time are further apart
   than 2^63 ps, 106 days; so a part may be switched on for longer than the 213 days after which they begin again. */
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
    GSC_TALK,  /* no pin: 1 while TXD is driven, 0 while it is left to others (pin 13) */
    GSC_PINS
};

/* What was wrong with a character. */
enum gsc_fault { GSC_PARITY = 1, GSC_FRAMING = 2 };

/* A string of the host without its carriage return; or the answer to M, which waits for its turn. */
struct gsc_line {
    gsc_time due; /* it is obeyed at this instant, or when the one before it has its answer */
    uint8_t text[GSC_LONGEST];
    uint8_t length;
    bool is_faulty;       /* a character had a fault */
    bool is_first_faulty; /* the first one had */
    bool is_too_long;     /* there were more characters */
    bool is_checked;      /* CHS was high at its carriage return */
    bool is_answer;
};

enum gsc_timer {
    GSC_RESET_TIMER,  /* the end of the RESET pulse */
    GSC_RUN_TIMER,    /* the program, and its motion */
    GSC_WATCH_TIMER,  /* the next sample of the input that ends a run */
    GSC_EEPROM_TIMER, /* the end of a write */
    GSC_SERIAL_TIMER, /* a string is to be obeyed; the next character of its answer */
    GSC_TIMERS
};

/* Everything that a part knows: to read, not to change.  The files named here say more. */
struct gsc {
    enum gsc_part part;
    gsc_time now;
    uint16_t inputs;        /* levels, bits of gsc_input */
    uint16_t levels, shown; /* of the outputs, a bit for each gsc_pin: now, and as last reported */
    uint8_t work;           /* what RDY is low for: pins.h */
    bool is_unsettled;      /* of this instant only what is timed has been done: part.c */

    struct {
        bool is_on;
        gsc_time at;
    } timer[GSC_TIMERS];

    struct { /* what S, T and R set, 0: never; and what F reports once */
        uint16_t start_stop, top_speed, ramp;
        bool is_over; /* E5 */
    } registers;
    int32_t position;

    struct { /* serial.c */
        uint8_t rate;    /* of the table of rates */
        uint8_t address; /* 0: point to point */
        bool listens;
        uint8_t phase;
        uint8_t waiting;         /* in `queue`; the first one is in progress */
        struct gsc_line coming;  /* the string that is being received */
        struct gsc_line queue[3]; /* two strings, and an answer to M */
        uint8_t answer[GSC_LONGEST + 2];
        uint8_t length, sent; /* of it */
        bool is_listing;      /* Q: more lines follow */
        uint8_t list_at;      /* the next one, in the program memory */
    } serial;

    struct { /* storage.c, program.c */
        uint8_t phase;
        uint8_t memory[GSC_LOCATIONS];
        uint8_t size;
        bool is_entering;   /* between Po and Px or E */
        uint8_t at;         /* the instruction in progress */
        uint8_t next;       /* the one after it */
        bool is_ending;     /* there is none after it */
        uint8_t until;      /* the user input of a U at location 0; 0: none */
        bool has_loop;      /* L0 has been executed, or an L without one */
        uint8_t loop;       /* where it repeats from */
        uint8_t passes;     /* made so far */
        uint8_t waits_for;  /* the user input of W */
        uint8_t watched;    /* the user input that ends the run; 0: none */
        bool runs_on_after; /* a stand-alone start: after the homing the program runs */
    } program;

    struct { /* motion.c, profile.c */
        uint8_t phase;
        bool is_moving;   /* MOV is high */
        int8_t direction; /* 1 clockwise */
        uint8_t homing;   /* the way to EOT, or to HOME; 0: no homing */
        bool is_endless;
        bool is_stop;     /* it shall come to rest */
        bool is_stopping; /* it does */
        bool is_stopped;  /* it did, before the end of the position counter */
        uint16_t start_stop, top_speed, ramp; /* as it began */
        bool is_flat;                         /* no ramps */
        uint16_t up, down;                    /* intervals of the ramps */
        uint32_t down_from, steps, step;      /* where the ramp down begins; all; the next one */
        uint64_t slew_ps;                     /* the interval between the ramps */
        gsc_time pulse_end, end;              /* of the last step */
    } motion;

    struct { /* eeprom.c */
        bool is_writing;
        uint8_t result;
        bool is_checked; /* M came with a checksum, and its answer has one */
    } eeprom;
};

/* ---------------------------------------------------------------------------------------------------------- what comes */

/* The supply has come: forget everything, and begin with the RESET pulse.  All outputs are reported.  It may be called
   again at any instant: then the supply has been gone. */
void gsc_power_up(struct gsc *g, enum gsc_part part, uint16_t inputs, gsc_time now);

/* The inputs have new levels, bits of gsc_input.  What is sampled in this very instant has the levels before. */
void gsc_set_inputs(struct gsc *g, uint16_t inputs, gsc_time now);

/* The receiver has a character: now is the middle of its first stop bit, `end` the end of the second one.  Before
   gsc_baud() says a rate no character counts. */
void gsc_receive(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end, gsc_time now);

/* Let time pass up to an instant, and do what is due at it. */
void gsc_advance(struct gsc *g, gsc_time now);

/* What gsc_on_store() has begun is over.  The part answers after its own time for a write; where the EEPROM takes longer,
   it asks again every 10 ms. */
void gsc_stored(struct gsc *g, bool is_good);

/* ---------------------------------------------------------------------------------------------------------- what is next */

/* Return whether anything is due as things stand, and when; it may be now. */
bool gsc_next(const struct gsc *g, gsc_time *due);

/* Return whether a step follows unless an input or a string changes it before, and when; DIR shows its direction already.
   A board may prepare its pulse, and must be able to take it back when this is no longer so; gsc_advance() is called at
   that instant all the same. */
bool gsc_step_ahead(const struct gsc *g, gsc_time *when);

/* Return the rate at which the part listens, 110 to 9600 baud, 7 data bits, odd parity, 2 stop bits; 0: it does not. */
uint16_t gsc_baud(const struct gsc *g);

/* ------------------------------------------------------------------------------- what goes out: brought by who uses this */

/* An output has another level, or its first one. */
void gsc_on_pin(struct gsc *g, enum gsc_pin pin, int level, gsc_time now);

/* A step: CLOCK falls now and rises 1.7 us later, whatever happens; 1 clockwise, -1 counter-clockwise. */
void gsc_on_step(struct gsc *g, int direction, gsc_time now);

/* The start bit of a character begins on TXD now.  The next one follows no sooner than it is over. */
void gsc_on_character(struct gsc *g, uint8_t character, gsc_time now);

/* M: begin to keep a program in the EEPROM, and call gsc_stored() when that is over.  The bytes do not change before. */
void gsc_on_store(struct gsc *g, const uint8_t *program, uint8_t size, gsc_time now);

/* Return how many bytes the program in the EEPROM has, 0 to 119, written to `program`; -1: there is no valid one.  A new
   EEPROM has a program of 0. */
int gsc_recall(struct gsc *g, uint8_t program[GSC_LOCATIONS]);

#endif
