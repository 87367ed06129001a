/* With fast steps and a table, this code arms the timer for the first step of a stop ramp as early as possible: that
 * of the first entry slower than the last two steps; or, if the record has WAY, of the entry with the first of
 * the steps that remain.  It is at least an eighth slower than before.  The rest is done by go_down() of
 * ../common/stop_ramp.c, which also handles all other cases and is the reference for this code.
 */
#include "interrupts.inc"

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

        .macro COMPARE_STEPS    ; the steps in r24 and r25 with all up to the end of the entry at Z: carry if fewer
        ldd r20, Z+4
        ldd r21, Z+5
        cp r24, r20
        cpc r25, r21
        .endm

        .text
        .global descend
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
        lds r24, left           ; the first step of a record without steps before it
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
        sbrc r24, RECORD_RAMP_LEFT_BIT
        rjmp by_ramp_left
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
by_ramp_left:                         ; from the first step of the record, plus the change for each step since
        lds r24, count
        lds r25, count+1
        lds r20, left
        lds r21, left+1
        sub r24, r20
        sbc r25, r21
        lds r20, ramp_left
        lds r21, ramp_left+1
        lds r22, ramp_slope
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
        rjmp with_phases        ; the motor stops here
6:      lds r26, tail_end       ; the table steps before those
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
