/* The words of the line. The host's half is src/slewline/drive/board/wire.py. */
#ifndef PROTOCOL_H
#define PROTOCOL_H

#include "sizes.h"

#define VERSION 1
#define BOARD_UNO 1
#define HZ 16000000UL
#define SHORTEST 224 /* ticks; tests/firmware/test_rates.py measures what is behind it */
#define TAIL_MOST 40 /* entries of the way down */
#define ROOM (RING - 1) /* bytes of frames that may be unanswered */
#define CHUNK_MOST 80

enum kind { HELLO = 1, PUSH, START, STOP, CONFIG, ASK, TAIL, RESET, OUTPUTS, REPEAT, CHECK, KINDS };
enum { ANSWER = 0x80, IDENT, EVENT };
enum result { TAKEN, DAMAGED, WRONG_NUMBER, NO_ROOM, NOT_NOW, BAD_CONTENT, TOO_LATE };
enum state { IDLE, RUN, BRAKE, HOLD, HALT, BOOT };
enum happening {
    REST = 1, UNDERRUN, HALTED, STOPPED, BRAKED, HELD, RELEASED, MARKED, INPUT_CHANGED, LATE, SILENT, ESTOPPED, BOOTED,
    CHECKED
};
enum reflex { REFLEX_NONE, REFLEX_STOP, REFLEX_BRAKE, REFLEX_HOLD, REFLEX_MARK, REFLEX_ESTOP };
#define ONLY_UP 16
#define ONLY_DOWN 32
#define NOBODY 255 /* `which` of an event that no input caused */

/* Flags of a record. */
#define DOWN 1
#define MAY_STAND 2 /* REST: behind it the motor may stand */
#define IS_PAUSE 4
#define SETS_OUTPUTS 8
#define IS_HALF 16
#define HAS_WAY 64 /* `add` of a record of one interval is a way down: u16 steps from its first step, i16 more each */

#define ENABLE_OUTPUT 16 /* in masks and values of outputs, beside the user's bits 0..3 */

#endif
