/* Messages between host and board.  Written by tools/protocol.py from src/slewline/drive/board: change it there. */
#ifndef PROTOCOL_H
#define PROTOCOL_H

#define VERSION 2 /* of the messages */
#define CHUNK_MOST 80 /* encoded bytes of a frame, without its zero */
#define RECORD_BYTES 13
#define RECORDS_MOST 5 /* of a frame */
#define ENTRY_BYTES 6 /* of an entry of the stop ramp */
#define ENTRIES_MOST 10 /* of a frame */
#define SHORTEST_PAUSE 256 /* ticks */
#define START_MOST_TICKS 268435456U /* from a START to the first step; more is a stale frame */
#define INPUTS 6
#define INPUTS_MASK 63
#define USER_OUTPUTS 15 /* bits of the outputs */
#define ENABLE 16 /* in addition to them */
#define POLARITY_UP_IS_HIGH 1 /* bits of `polarity`: DIR is high upwards */
#define POLARITY_ENABLE_LOW 2 /* the driver is on while ENABLE is low */
#define HOST 255 /* `which` of an event without an input as its cause */

/* Kinds of frames: numbers below 0x80 are sent by the host, 0x80 and above by the board. */
#define FRAME_HELLO 1
#define FRAME_PUSH 2
#define FRAME_START 3
#define FRAME_STOP 4
#define FRAME_CONFIG 5
#define FRAME_ASK 6
#define FRAME_TAIL 7
#define FRAME_RESET 8
#define FRAME_OUTPUTS 9
#define FRAME_REPEAT 10
#define FRAME_CHECK 11
#define FRAME_ANSWER 128
#define FRAME_IDENT 129
#define FRAME_EVENT 130

/* Results of a frame sent to the board; only a frame that is accepted (TAKEN) uses up its frame number. */
#define RESULT_TAKEN 0
#define RESULT_DAMAGED 1
#define RESULT_WRONG_NUMBER 2
#define RESULT_NO_ROOM 3
#define RESULT_WRONG_STATE 4
#define RESULT_BAD_CONTENT 5
#define RESULT_LATE 6

/* States of a board; only RESET leaves HALT, and only CONFIG leaves BOOT, the state at power-up. */
#define STATE_IDLE 0
#define STATE_RUN 1
#define STATE_BRAKE 2
#define STATE_HALT 3
#define STATE_BOOT 4

/* Kinds of events on a board. */
#define EVENT_REST 1
#define EVENT_UNDERRUN 2
#define EVENT_HALTED 3
#define EVENT_STOPPED 4
#define EVENT_BRAKED 5
#define EVENT_MARK 6
#define EVENT_INPUT 7
#define EVENT_LATE 8
#define EVENT_WATCHDOG 9
#define EVENT_ESTOP 10
#define EVENT_BOOT 11
#define EVENT_CHECKED 12

/* Immediate reactions of a board to an active input; STOP and BRAKE may be limited to UPWARDS or DOWNWARDS. */
#define REFLEX_NONE 0
#define REFLEX_STOP 1
#define REFLEX_BRAKE 2
#define REFLEX_MARK 3
#define REFLEX_ESTOP 4
#define REFLEX_UPWARDS 16
#define REFLEX_DOWNWARDS 32

/* Properties of the driver. */
#define DRIVER_ENABLE 1
#define DRIVER_DRY 2

/* Conditions under which a board switches the driver off by itself; in an emergency stop it always does so. */
#define OFF_NEVER 0
#define OFF_HALT 1
#define OFF_REST 2

/* Flags of RESET. */
#define RESET_POSITION 1
#define RESET_KNOWN 2
#define RESET_POWER 4

/* Flags of ANSWER that describe the driver. */
#define POWER_ENERGISED 1
#define POWER_ESTOP 2
#define POWER_UNSURE 4
#define POWER_LOCKED 8

/* Flags of a record, and the numbers of their bits. */
#define RECORD_DOWN 1
#define RECORD_DOWN_BIT 0
#define RECORD_REST 2
#define RECORD_REST_BIT 1
#define RECORD_PAUSE 4
#define RECORD_PAUSE_BIT 2
#define RECORD_OUT 8
#define RECORD_OUT_BIT 3
#define RECORD_HALF 16
#define RECORD_HALF_BIT 4
#define RECORD_RAMP_LEFT 64
#define RECORD_RAMP_LEFT_BIT 6

#endif
