/* Interrupt A of timer 1 sets the phases of the step first.  It does the ordinary step, the one in the middle of
 * a record, and loads a record like the one before; for everything else it calls match() of ../common/steps.c.  Where a
 * stop ramp begins, `descend` of stop_ramp.S comes first.
 */
#include "interrupts.inc"

        .text
/* In a dry run STEP stays low, and the flag of the match shows whether a step is due: zero if it is not. */
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
        cpi r24, STATE_BRAKE          ; in a stop ramp the next step is more urgent than a byte, which can be sent again
        breq 1f
        call serve_line         ; this took long, and the next match would come before a waiting byte
1:      RESTORE

need_match:
        cpi r25, BRAKING
        breq braked
        andi r25, NO_STEP
        brne to_match
        SHOW_PHASES
shown:  SAVE
        .global with_phases
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
        ; last = due; due += interval; the low half goes to the timer as soon as possible
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
        brne ramp_or_phases     ; the carry remains unchanged up to ADVANCE_HIGH
        END_PULSE
        ADVANCE_HIGH
        ; if the timer has passed `due`, STEP is high again, or this was too late.
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

one_more:                       ; before a stop ramp, which begins after the next step
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

/* The last step of a record, and another one with steps in the same direction follows: the timer is armed
   first, then the rest is loaded while the next step is pending. */
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
        ; interval, and the one after the step that is due now
        sbrc r23, RAMP_BIT
        rjmp 9f
        sbrs r23, RECORD_RAMP_LEFT_BIT
        rjmp 8f
        ldd r24, Z+ADD          ; `add` belongs to a stop ramp
        sts ramp_left, r24
        ldd r24, Z+ADD+1
        sts ramp_left+1, r24
        ldd r24, Z+ADD+2
        sts ramp_slope, r24
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
        ; count, and the position after the record
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
