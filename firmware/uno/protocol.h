/* The words of the line. The host's half is src/slewline/drive/board/wire.py. */
#ifndef PROTOCOL_H
#define PROTOCOL_H

#include "sizes.h"

#define VERSION 2
#define BOARD_UNO 1
#define HZ 16000000UL
#define SHORTEST 224 /* ticks; tests/firmware/test_rates.py measures what is behind it */
#define TAIL_MOST 40 /* entries of the way down */
#define ROOM (RING - 1) /* bytes of frames that may be unanswered */
#define CHUNK_MOST 80

enum kind { HELLO = 1, PUSH, START, STOP, CONFIG, ASK, TAIL, RESET, OUTPUTS, REPEAT, CHECK, KINDS };
enum { ANSWER = 0x80, IDENT, EVENT };
enum result { TAKEN, DAMAGED, WRONG_NUMBER, NO_ROOM, NOT_NOW, BAD_CONTENT, TOO_LATE };
enum state { IDLE, RUN, BRAKE, HALT, BOOT };
enum happening {
    REST = 1, UNDERRUN, HALTED, STOPPED, BRAKED, MARKED, INPUT_CHANGED, LATE, SILENT, ESTOPPED, BOOTED, CHECKED
};
enum reflex { REFLEX_NONE, REFLEX_STOP, REFLEX_BRAKE, REFLEX_MARK, REFLEX_ESTOP };
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

#define USER_OUTPUTS 15
#define ENABLE_OUTPUT 16 /* in masks and values of outputs, beside the user's bits 0..3 */

/* `driver` of CONFIG. */
#define HAS_ENABLE 1 /* ENABLE leads to a driver whose level is known; without that its pin remains an input */
#define IS_DRY 2     /* steps are counted, and make no edge */

/* `enable_off` of CONFIG: when the board switches the driver off by itself; at an emergency stop it always does. */
enum { OFF_NEVER, OFF_AT_HALT, OFF_AT_REST };

/* Flags of RESET. */
#define SETS_POSITION 1
#define IS_KNOWN 2  /* the count is where the motor is: the user says so */
#define MAY_POWER 4 /* the driver may be switched on, though the board has switched it off */

/* Flags of ANSWER. */
#define IS_ENERGISED 1
#define IN_ESTOP 2
#define IS_UNSURE 4 /* the motor may be elsewhere: steps without current, or a driver that the board has switched off */
#define IS_LOCKED 8 /* the board has switched the driver off: RESET unlocks it */

#endif
