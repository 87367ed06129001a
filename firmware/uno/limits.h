/* The limits of this board.  Written by tools/protocol.py from src/slewline/drive/board: change it there. */
#ifndef LIMITS_H
#define LIMITS_H

#define BOARD_NUMBER 1 /* of IDENT */
#define HZ 16000000U /* ticks a second */
#define SLOTS 64 /* records in the queue */
#define TAIL_MOST 40 /* entries of the stop ramp */
#define RING 128 /* bytes received, a power of 2; ROOM may be unanswered */
#define ROOM 127
#define SHORTEST 224 /* ticks between two steps */
#define FAST_TICKS 640 /* between steps: below this there is no time to brake at the next one */
#define SOONEST_TICKS 1200 /* from an edge, or a pause, to a step */
#define START_LEAD_TICKS 1600 /* from the answer to a START to the first step */
#define LEAST_CHECK 256 /* ticks between the pulses of a self-test */

#endif
