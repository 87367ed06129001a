/* A GS-C200 or GS-C200S: inputs and outputs of its pins, with their instants.
 *
 *     RXD ------> gsc_receive()     gsc_on_character() ------> TXD
 *     inputs ---> gsc_set_inputs()  gsc_on_pin(), gsc_on_step() -> RDY, MOV, RAMP, DIR, RESET, UO; CLOCK
 *     EEPROM <--> gsc_recall(), gsc_on_store(), gsc_stored()
 *
 * No code here uses a clock, a hardware register or the heap.  The caller
 *
 *     calls gsc_power_up(), then gsc_advance() whenever the deadline of gsc_next() is reached, and passes on every
 *     input and every character as it arrives; each of these calls may make any of the gsc_on_ calls, in order of time;
 *
 * so the same files are the part on a board, and a library that tests compare with the model.  A gsc_on_ call must not
 * call back, except gsc_stored(), and no instant may be earlier than that of the previous call.
 *
 * Sections named in these files are those of the GS-C200/GS-C200S data sheet, June 1994; decisions on its gaps
 * have the names in docs/reference/gs-c200.md, such as GSC-UND-TURNAROUND.
 */
#ifndef GSC200_H
#define GSC200_H

#include <stdbool.h>
#include <stdint.h>

#define GSC_LOCATIONS 119 /* of the program memory: program storage area */
#define GSC_LONGEST 11    /* characters of a string, without its carriage return: GSC-UND-MAXLEN */

/* An instant: picoseconds modulo 2^64, from any origin.  No two instants in use at the same time are further apart
   than 2^63 ps, 106 days; so a part may be switched on for longer than the 213 days after which they wrap. */
typedef uint64_t gsc_time;

static inline bool gsc_is_before(gsc_time one, gsc_time other)
{
    return (int64_t)(one - other) < 0;
}

enum gsc_part { GSC_C200, GSC_C200S };

/* The inputs, a bit each, as levels of the pins: 1 is high, also for an open input (GSC-UND-OPEN-INPUTS). */
enum gsc_input {
    GSC_SEL0 = 1 << 0, /* pin 1 */
    GSC_SEL1 = 1 << 1,
    GSC_SEL2 = 1 << 2,
    GSC_BR0 = 1 << 3, /* pin 4 */
    GSC_BR1 = 1 << 4,
    GSC_BR2 = 1 << 5,
    GSC_CHS = 1 << 6,    /* pin 7 */
    GSC_REC = 1 << 7,    /* pin 9 */
    GSC_RXD = 1 << 8,    /* pin 11, RS-232: 1 is positive, the space; 0, also when open.  Sampled only for H+ or H- */
    GSC_ENABLE = 1 << 9, /* pin 24 */
    GSC_HOME = 1 << 10,  /* pin 30 */
    GSC_EOT = 1 << 11,   /* pin 32 */
    GSC_UI1 = 1 << 12,   /* pin 34 */
    GSC_UI2 = 1 << 13,   /* pin 36 */
    GSC_UI3 = 1 << 14    /* pin 37 */
};

/* The outputs, except CLOCK and the characters of TXD. */
enum gsc_pin {
    GSC_RDY,   /* pin 14, open collector: 0 pulls it low, 1 releases it */
    GSC_MOV,   /* pin 22 */
    GSC_RAMP,  /* pin 23 */
    GSC_DIR,   /* pin 26: 1 clockwise */
    GSC_RESET, /* pin 27: 0 resets the driver */
    GSC_UO1,   /* pin 31 */
    GSC_UO2,   /* pin 33 */
    GSC_UO3,   /* pin 35 */
    GSC_TALK,  /* no pin: 1 while TXD is driven, 0 while it is released for other modules (pin 13) */
    GSC_PINS
};

/* Faults of a character. */
enum gsc_fault { GSC_PARITY = 1, GSC_FRAMING = 2 };

/* A string from the host without its carriage return; or the answer to M, which is queued. */
struct gsc_line {
    gsc_time due; /* it is executed at this instant, or when the previous one has been answered */
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

/* The whole state of a part: read it, but do not change it.  The named files describe it. */
struct gsc {
    enum gsc_part part;
    gsc_time now;
    uint16_t inputs;        /* levels, bits of gsc_input */
    uint16_t levels, shown; /* of the outputs, a bit for each gsc_pin: now, and as last reported */
    uint8_t work;           /* the activities for which RDY is low: pins.h */
    bool is_unsettled;      /* only the timed events of this instant have been processed: part.c */

    struct {
        bool is_on;
        gsc_time at;
    } timer[GSC_TIMERS];

    struct { /* settings of S, T and R, 0: not set; and the error that F reports once */
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
        uint8_t at;         /* location of the instruction in progress */
        uint8_t next;       /* location of the next one */
        bool is_ending;     /* there is no next one */
        uint8_t until;      /* the user input of a U at location 0; 0: none */
        bool has_loop;      /* L0 has been executed, or an L without one */
        uint8_t loop;       /* start of the loop */
        uint8_t passes;     /* completed so far */
        uint8_t waits_for;  /* the user input of W */
        uint8_t watched;    /* the user input that ends the run; 0: none */
        bool runs_on_after; /* a stand-alone start: after the homing the program runs */
    } program;

    struct { /* motion.c, profile.c */
        uint8_t phase;
        bool is_moving;   /* MOV is high */
        int8_t direction; /* 1 clockwise */
        uint8_t homing;   /* travel to EOT, or to HOME; 0: no homing */
        bool is_endless;
        bool is_stop;     /* a stop is requested */
        bool is_stopping; /* it is stopping */
        bool is_stopped;  /* it was stopped, before the end of the position counter */
        uint16_t start_stop, top_speed, ramp; /* at its start */
        bool is_flat;                         /* no ramps */
        uint16_t up, down;                    /* intervals of the ramps */
        uint32_t down_from, steps, step;      /* first step of the ramp down; total; next step */
        uint64_t slew_ps;                     /* the interval between the ramps */
        gsc_time pulse_end, end;              /* of the last step */
    } motion;

    struct { /* eeprom.c */
        bool is_writing;
        uint8_t result;
        bool is_checked; /* M came with a checksum, and its answer has one */
    } eeprom;
};

/* ------------------------------------------------------------------------------------------------------------- inputs */

/* Power up: reset all state, and begin with the RESET pulse.  All outputs are reported.  It may be called
   again at any instant, after a loss of the supply. */
void gsc_power_up(struct gsc *g, enum gsc_part part, uint16_t inputs, gsc_time now);

/* Set new levels of the inputs, bits of gsc_input.  Samples at this very instant still read the previous levels. */
void gsc_set_inputs(struct gsc *g, uint16_t inputs, gsc_time now);

/* Receive a character: now is the middle of its first stop bit, `end` the end of the second one.  Characters before
   gsc_baud() returns a rate are ignored. */
void gsc_receive(struct gsc *g, uint8_t character, uint8_t faults, gsc_time end, gsc_time now);

/* Let time pass up to an instant, and process its events. */
void gsc_advance(struct gsc *g, gsc_time now);

/* Report the end of the write begun by gsc_on_store().  The part answers after its own write time; if the EEPROM takes
   longer, it checks again every 10 ms. */
void gsc_stored(struct gsc *g, bool is_good);

/* -------------------------------------------------------------------------------------------------------- next events */

/* Return whether an event is due in the present state, and its instant, which may be now. */
bool gsc_next(const struct gsc *g, gsc_time *due);

/* Return whether a step follows unless an input or a string prevents it, and its instant; DIR has its direction already.
   A board may prepare its pulse, and must be able to cancel it when this changes; gsc_advance() must be called at that
   instant nevertheless. */
bool gsc_step_ahead(const struct gsc *g, gsc_time *when);

/* Return the rate at which the part receives, 110 to 9600 baud, 7 data bits, odd parity, 2 stop bits; 0: none. */
uint16_t gsc_baud(const struct gsc *g);

/* ----------------------------------------------------------------------------------- outputs: functions of the caller */

/* An output has a new level, or its first one. */
void gsc_on_pin(struct gsc *g, enum gsc_pin pin, int level, gsc_time now);

/* A step: CLOCK falls now and rises 1.7 us later in any case; 1 clockwise, -1 counter-clockwise. */
void gsc_on_step(struct gsc *g, int direction, gsc_time now);

/* The start bit of a character begins on TXD now.  The next one begins at its end or later. */
void gsc_on_character(struct gsc *g, uint8_t character, gsc_time now);

/* M: begin to write a program to the EEPROM, and call gsc_stored() at the end.  The bytes do not change until then. */
void gsc_on_store(struct gsc *g, const uint8_t *program, uint8_t size, gsc_time now);

/* Write the program in the EEPROM to `program`, and return its length, 0 to 119; -1: no valid program.  A new
   EEPROM has a program of 0. */
int gsc_recall(struct gsc *g, uint8_t program[GSC_LOCATIONS]);

#endif
