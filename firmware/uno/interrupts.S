/* The interrupts.  By hand, because the time of the step interrupt is what limits the rate: the compiler would save
 * twenty registers where four are enough.
 *
 * Interrupt A of timer 1 shows the phases of the step, first of all.  It does the ordinary step, the one in the middle
 * of a record, loads a record like the one before, and finds the first step of a way down; for everything else, and for
 * the rest of that, it calls match() of motion.c.
 */
#define __SFR_OFFSET 0
#include <avr/io.h>

#include "mode.h"
#include "protocol.h"
#include "sizes.h"

#define DISARMED (1 << COM1A1)

/* Bytes of a record in the queue, as on the line; RAMP of its flags is set by the main loop. */
#define FLAGS 0
#define COUNT 1
#define INTERVAL 3
#define FRACTION 7
#define ADD 9

/* What a function of C may use, behind r24, SREG and r25, which are on the stack already. */
        .macro SAVE
        push r0
        push r1
        push r18
        push r19
        push r20
        push r21
        push r22
        push r23
        push r26
        push r27
        push r30
        push r31
        clr r1
        .endm

        .macro RESTORE
        pop r31
        pop r30
        pop r27
        pop r26
        pop r23
        pop r22
        pop r21
        pop r20
        pop r19
        pop r18
        pop r1
        pop r0
        pop r25
        pop r24
        out SREG, r24
        pop r24
        reti
        .endm

/* Phases A..D of the step that has been made, first of all that is done behind its edge. */
        .macro SHOW_PHASES
        lds r24, phases_due
        in r25, PORTD
        andi r25, 0x0F
        or r25, r24
        out PORTD, r25
        .endm

/* Those of the step that comes next; r24, r30 and r31 are used. */
        .macro NEXT_PHASES
        lds r30, phase
        lds r24, phase_step
        add r30, r24
        andi r30, 7
        sts phase, r30
        ldi r31, 0
        subi r30, lo8(-(pattern))
        sbci r31, hi8(-(pattern))
        ld r24, Z
        sts phases_due, r24
        .endm

/* Let STEP fall, and rise again at the next match. */
        .macro END_PULSE
        ldi r24, DISARMED
        sts TCCR1A, r24
        ldi r24, 1 << FOC1A
        sts TCCR1C, r24
        lds r24, armed
        sts TCCR1A, r24
        .endm

/* The high half of `due` takes the carry of the low one; an interval that the short way may take has 16 bits. */
        .macro ADVANCE_HIGH
        ldi r24, 0
        lds r25, due+4
        sts last+2, r25
        adc r25, r24
        sts due+4, r25
        lds r25, due+5
        sts last+3, r25
        adc r25, r24
        sts due+5, r25
        .endm

/* ------------------------------------------------------------------------------------------------------- the step */
        .text
/* In a dry run STEP stays low, and the flag of the match shows that a step is made: zero if it is not. */
is_dry_match:
        lds r24, armed
        cpi r24, DISARMED
        in r24, TIFR1
        breq 1f
        clr r24
1:      andi r24, 1 << OCF1A
        ret
too_late:
        pop r23
        pop r22
        SAVE
        call late
        RESTORE

to_match:
        SAVE
matching:
        call match
        cli                     ; match() may have let interrupts in at its end
        lds r24, state
        cpi r24, STATE_BRAKE          ; on the way down the next step is more urgent than a byte, which can be sent again
        breq 1f
        call serve_line         ; this was long, and the next match would come before a byte that waits
1:      RESTORE

need_match:
        cpi r25, BRAKING
        breq braked
        andi r25, NO_STEP
        brne to_match
        SHOW_PHASES
shown:  SAVE
with_phases:
        lds r24, mode
        sbrs r24, PHASES_BIT
        rjmp matching
        NEXT_PHASES
        rjmp matching

braked: SHOW_PHASES
        rjmp descend

        .global TIMER1_COMPA_vect
TIMER1_COMPA_vect:
        push r24
        in r24, SREG
        push r24
        push r25
        lds r25, mode
        andi r25, NEED_MATCH
        brne need_match
        SHOW_PHASES
        lds r24, left
        lds r25, left+1
        sbiw r24, 1
        brne 1f
        rjmp next_record
1:      sts left, r24
        sts left+1, r25
        push r22
        push r23
        ; last = due; due += interval; the low half goes to the timer as soon as it is known
        lds r24, due
        lds r25, interval
        add r24, r25
        sts due, r24
        lds r24, due+1
        lds r25, interval+1
        adc r24, r25
        sts due+1, r24
        lds r22, due+2
        sts last, r22
        lds r25, interval+2
        adc r22, r25
        sts due+2, r22
        lds r23, due+3
        sts last+1, r23
        lds r25, interval+3
        adc r23, r25
        sts due+3, r23
        sts OCR1AH, r23
        sts OCR1AL, r22
        lds r25, mode
        tst r25
        brne ramp_or_phases     ; the carry remains as it is up to ADVANCE_HIGH
        END_PULSE
        ADVANCE_HIGH
        ; has the timer gone past `due`?  Then STEP is high again, or this was too late.
look_back:
        lds r24, TCNT1L
        lds r25, TCNT1H
        sub r22, r24
        sbc r23, r25
        brmi past
back:   pop r23
        pop r22
        pop r25
        pop r24
        out SREG, r24
        pop r24
        reti
past:   sbic PINB, PORTB1
        rjmp back
        rcall is_dry_match      ; r24 is free
        brne back
        rjmp too_late

one_more:                       ; before a way down: it begins behind the next step
        subi r25, ONE_MORE - BRAKING
        sts mode, r25
        rjmp 1f
ramp_or_phases:
        ADVANCE_HIGH
        lds r25, mode
        sbrc r25, ONE_MORE_BIT
        rjmp one_more
1:      sbrs r25, PHASES_BIT
        rjmp 2f
        push r30
        push r31
        NEXT_PHASES
        pop r31
        pop r30
2:      sbrs r25, RAMP_BIT
        rjmp end_pulse
        lds r24, interval
        lds r25, add
        add r24, r25
        sts interval, r24
        lds r24, interval+1
        lds r25, add+1
        adc r24, r25
        sts interval+1, r24
        lds r24, interval+2
        lds r25, add+2
        adc r24, r25
        sts interval+2, r24
        lds r24, interval+3
        lds r25, add+3
        adc r24, r25
        sts interval+3, r24
        brpl end_pulse
        lds r24, mode           ; 32768 ticks and more: match() does the next one
        ori r24, LONG
        sts mode, r24
end_pulse:
        END_PULSE
        rjmp look_back

/* The last step of a record, and another one with steps in the same direction follows: what the timer needs comes
   first, then the rest is loaded while the next step is on its way. */
next_record:
        lds r24, follows
        tst r24
        brne 1f
        rjmp shown
1:      lds r24, queued
        tst r24
        brne 2f
        rjmp descend
2:      push r30
        push r31
        lds r30, out
        lds r31, out+1
        ld r24, Z
        sbrc r24, RECORD_PAUSE_BIT
        rjmp cannot
        lds r25, down
        eor r25, r24
        sbrc r25, RECORD_DOWN_BIT
        rjmp cannot
        ldd r25, Z+INTERVAL+2
        tst r25
        brne cannot
        ldd r25, Z+INTERVAL+3
        tst r25
        brne cannot
        ldd r25, Z+INTERVAL+1
        tst r25
        brpl can
cannot: pop r31
        pop r30
        rjmp shown
can:    push r20
        push r21
        push r22
        push r23
        ldd r25, Z+INTERVAL+1
        ; last = due; due += interval of the record
        ldd r20, Z+FRACTION
        lds r24, due
        add r24, r20
        sts due, r24
        ldd r21, Z+FRACTION+1
        lds r24, due+1
        adc r24, r21
        sts due+1, r24
        lds r22, due+2
        sts last, r22
        ldd r24, Z+INTERVAL
        adc r22, r24
        sts due+2, r22
        lds r23, due+3
        sts last+1, r23
        adc r23, r25
        sts due+3, r23
        sts OCR1AH, r23
        sts OCR1AL, r22
        END_PULSE
        ADVANCE_HIGH
        lds r24, TCNT1L
        lds r25, TCNT1H
        sub r22, r24
        sbc r23, r25
        ldi r22, 0              ; 1: too late
        brpl 1f
        sbic PINB, PORTB1
        rjmp 1f
        rcall is_dry_match
        brne 1f
        ldi r22, 1
1:      ld r23, Z
        sts flags, r23
        lds r25, mode
        bst r25, ONE_MORE_BIT       ; it was in the old mode; this is the new one
        andi r25, PHASES
        breq 2f
        ldi r24, 2              ; half steps
        sbrc r23, RECORD_HALF_BIT
        ldi r24, 1
        sbrc r23, RECORD_DOWN_BIT
        neg r24
        andi r24, 7
        sts phase_step, r24
        push r30
        push r31
        NEXT_PHASES
        pop r31
        pop r30
2:      bld r25, BRAKING_BIT
        ; interval, and the one behind the step that is due now
        sbrc r23, RAMP_BIT
        rjmp 9f
        sbrs r23, RECORD_WAY_BIT
        rjmp 8f
        ldd r24, Z+ADD          ; `add` is a way down
        sts way, r24
        ldd r24, Z+ADD+1
        sts way+1, r24
        ldd r24, Z+ADD+2
        sts way_slope, r24
8:      sts interval, r20       ; it remains
        sts interval+1, r21
        ldd r20, Z+INTERVAL
        sts interval+2, r20
        ldd r20, Z+INTERVAL+1
        sts interval+3, r20
        rjmp 3f
9:      ori r25, RAMP
        ldd r24, Z+ADD
        sts add, r24
        add r20, r24
        sts interval, r20
        ldd r24, Z+ADD+1
        sts add+1, r24
        adc r21, r24
        sts interval+1, r21
        ldd r20, Z+INTERVAL
        ldd r24, Z+ADD+2
        sts add+2, r24
        adc r20, r24
        sts interval+2, r20
        ldd r20, Z+INTERVAL+1
        ldd r24, Z+ADD+3
        sts add+3, r24
        adc r20, r24
        sts interval+3, r20
        brpl 3f
        ori r25, LONG
3:      sts mode, r25           ; the high half of the interval is 0: it was not LONG
        ldi r24, 1
        sts stepped, r24
        ; count, and the position behind the record
        ldd r20, Z+COUNT
        sts left, r20
        sts count, r20
        ldd r21, Z+COUNT+1
        sts left+1, r21
        sts count+1, r21
        ldi r25, 0
        sbrc r23, RECORD_DOWN_BIT
        rjmp 4f
        lds r24, end
        add r24, r20
        sts end, r24
        lds r24, end+1
        adc r24, r21
        sts end+1, r24
        lds r24, end+2
        adc r24, r25
        sts end+2, r24
        lds r24, end+3
        adc r24, r25
        sts end+3, r24
        rjmp 5f
4:      lds r24, end
        sub r24, r20
        sts end, r24
        lds r24, end+1
        sbc r24, r21
        sts end+1, r24
        lds r24, end+2
        sbc r24, r25
        sts end+2, r24
        lds r24, end+3
        sbc r24, r25
        sts end+3, r24
5:      lds r24, queued
        dec r24
        sts queued, r24
        adiw r30, RECORD_BYTES
        ldi r24, hi8(queue + SLOTS * RECORD_BYTES)
        cpi r30, lo8(queue + SLOTS * RECORD_BYTES)
        cpc r31, r24
        brne 6f
        ldi r30, lo8(queue)
        ldi r31, hi8(queue)
6:      sts out, r30
        sts out+1, r31
        tst r22
        pop r23
        pop r22
        pop r21
        pop r20
        pop r31
        pop r30
        breq 7f
        SAVE
        call late
        RESTORE
7:      pop r25
        pop r24
        out SREG, r24
        pop r24
        reti

/* ---------------------------------------------------------------------------------------------------- the way down */
/* Where steps are fast and there is a table, the timer gets the first step of a way down here, as soon as can be: that
 * of the first entry that is slower than the last two steps were; or, if the record has a way, of the one with the
 * first of the steps that remain.  It is an eighth slower than before at least.  The rest is done by go_down() of
 * motion.c, and so is all of it in other cases, and what this is measured by.
 */
        .macro LOAD_INTERVAL    ; of the entry at Z
        ld r20, Z
        ldd r21, Z+1
        ldd r22, Z+2
        ldd r23, Z+3
        .endm

        .macro COMPARE_INTERVAL ; the ticks in r18 and r19 with it: carry if it is longer
        LOAD_INTERVAL
        cp r1, r20
        cpc r18, r21
        cpc r19, r22
        cpc r1, r23
        .endm

        .macro COMPARE_STEPS    ; those in r24 and r25 with all up to the end of the entry at Z: carry if they are fewer
        ldd r20, Z+4
        ldd r21, Z+5
        cp r24, r20
        cpc r25, r21
        .endm

other:  rjmp with_phases
descend:
        SAVE
        lds r18, due+2          ; ticks between the last two steps
        lds r24, last
        sub r18, r24
        lds r19, due+3
        lds r24, last+1
        sbc r19, r24
        lds r20, due+4
        lds r24, last+2
        sbc r20, r24
        lds r21, due+5
        lds r24, last+3
        sbc r21, r24
        cpi r18, lo8(FAST_TICKS)
        ldi r24, hi8(FAST_TICKS)
        cpc r19, r24
        cpc r20, r1
        cpc r21, r1
        brcc other
        lds r24, quick
        tst r24
        breq other
        lds r24, stepped
        tst r24
        brne 1f
        lds r24, left           ; the first step of a record, and none before it
        lds r25, count
        cp r24, r25
        lds r24, left+1
        lds r25, count+1
        cpc r24, r25
        breq other
1:      movw r20, r18
        lsr r21
        ror r20
        lsr r21
        ror r20
        lsr r21
        ror r20
        add r18, r20
        adc r19, r21
        lds r30, hint
        lds r31, hint+1
        lds r24, flags
        sbrc r24, RECORD_WAY_BIT
        rjmp by_way
2:      sbiw r30, ENTRY_BYTES
        COMPARE_INTERVAL
        brcs 2b
3:      adiw r30, ENTRY_BYTES
        COMPARE_INTERVAL
        brcc 3b
        lds r24, tail_end
        lds r25, tail_end+1
        cp r30, r24
        cpc r31, r25
        brne 9f
        rjmp with_phases
by_way:                         ; as from the first step of the record, and so much more for each since
        lds r24, count
        lds r25, count+1
        lds r20, left
        lds r21, left+1
        sub r24, r20
        sbc r25, r21
        lds r20, way
        lds r21, way+1
        lds r22, way_slope
        tst r22
        breq 4f
        brmi 5f
        add r20, r24
        adc r21, r25
        rjmp 4f
5:      sub r20, r24
        sbc r21, r25
4:      mov r24, r20
        or r24, r21
        brne 6f
        rjmp with_phases        ; it stands here
6:      lds r26, tail_end       ; the steps of the table that come before those
        lds r27, tail_end+1
        sbiw r26, ENTRY_BYTES - 4
        ld r24, X+
        ld r25, X
        sub r24, r20
        sbc r25, r21
        brcc 7f
        ldi r24, 0
        ldi r25, 0
7:      sts skip, r24
        sts skip+1, r25
8:      sbiw r30, ENTRY_BYTES
        COMPARE_STEPS
        brcs 8b
1:      adiw r30, ENTRY_BYTES
        COMPARE_STEPS
        brcc 1b
        LOAD_INTERVAL
9:      tst r23
        brne 6f
        sbrc r22, 7
6:      rjmp with_phases
        cp r21, r18
        cpc r22, r19
        brcc first_step
        ldi r20, 0              ; never faster
        mov r21, r18
        mov r22, r19
first_step:
        lds r24, due+2
        add r24, r21
        lds r25, due+3
        adc r25, r22
        sts OCR1AH, r25
        sts OCR1AL, r24
        END_PULSE
        sts interval, r1
        sts interval+1, r20
        sts interval+2, r21
        sts interval+3, r22
        sts interval+4, r1
        sts interval+5, r1
        sts entry, r30
        sts entry+1, r31
        ldi r24, 1
        sts begun, r24
        rjmp with_phases

/* ------------------------------------------------------------------------------------------------------ the inputs */
/* A look takes longer than a fast step may wait, so it lets other interrupts in, except itself.  An edge meanwhile
 * remains in the flag of the pin change interrupt, and a new look follows. */
        .global PCINT1_vect
PCINT1_vect:
        push r24
        in r24, SREG
        push r24
        push r25
        ldi r24, 0
        sts PCICR, r24
        sei
        SAVE
        call look
        cli
        ldi r24, 1 << PCIE1
        sts PCICR, r24
        RESTORE

/* --------------------------------------------------------------------------------------------- the clock's high half */
        .global TIMER1_OVF_vect
TIMER1_OVF_vect:
        push r24
        in r24, SREG
        push r24
        push r25
        lds r24, overflows
        lds r25, overflows+1
        adiw r24, 1
        sts overflows, r24
        sts overflows+1, r25
        pop r25
        pop r24
        out SREG, r24
        pop r24
        reti

/* --------------------------------------------------------------------------------------------------------- the line */
/* More than the ring holds is never under way: the host counts, ROOM of protocol.h. */
        .global USART_RX_vect
USART_RX_vect:
        push r24
        in r24, SREG
        push r24
        push r30
        push r31
        lds r30, received_head
        mov r24, r30
        inc r24
        andi r24, RING - 1
        sts received_head, r24
        ldi r31, 0
        subi r30, lo8(-(received))
        sbci r31, hi8(-(received))
        lds r24, UDR0
        st Z, r24
        pop r31
        pop r30
        pop r24
        out SREG, r24
        pop r24
        reti

        .global USART_UDRE_vect
USART_UDRE_vect:
        push r24
        in r24, SREG
        push r24
        push r30
        push r31
        lds r30, sending_tail
        mov r24, r30
        ldi r31, 0
        subi r30, lo8(-(sending))
        sbci r31, hi8(-(sending))
        ld r30, Z
        sts UDR0, r30
        inc r24
        andi r24, TX_RING - 1
        sts sending_tail, r24
        lds r30, sending_head
        cp r24, r30
        brne 8f
        lds r24, UCSR0B
        andi r24, 0xFF ^ (1 << UDRIE0)
        sts UCSR0B, r24
8:      pop r31
        pop r30
        pop r24
        out SREG, r24
        pop r24
        reti
