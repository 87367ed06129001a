/* Bits of `mode` of due.h, for the compiler and the assembler. */
#ifndef MODE_H
#define MODE_H

#define HOP 0x01     /* the match is an intermediate one, before a distant instant */
#define PAUSE 0x02   /* the end of a pause is due */
#define BRAKING 0x04 /* the stop ramp begins after the step that is due */
#define STILL 0x08   /* nothing is due */
#define LONG 0x10    /* the interval after the step that is due may need hops */
#define RAMP 0x20    /* the interval changes with each step */
#define PHASES 0x40
#define ONE_MORE 0x80 /* becomes BRAKING after the step that is due */

#define LONG_LEAST 32768 /* ticks */

#define NEED_MATCH (HOP | PAUSE | BRAKING | STILL | LONG) /* without any of these, the short code path is enough */
#define NO_STEP (HOP | PAUSE | STILL)

#define BRAKING_BIT 2 /* their numbers */
#define LONG_BIT 4
#define RAMP_BIT 5
#define PHASES_BIT 6
#define ONE_MORE_BIT 7

#endif
