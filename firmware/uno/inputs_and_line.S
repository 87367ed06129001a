/* Each edge of an input, each byte of the line, and the clock's high half. */
#include "interrupts.inc"

        .text
/* ------------------------------------------------------------------------------------------------------ the inputs */
/* Sampling takes longer than a fast step may wait, so it enables interrupts other than itself.  An edge meanwhile
 * remains in the flag of the pin change interrupt, and another sample follows. */
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
/* There are never more bytes in transit than the ring has room for: the host counts, ROOM of protocol.h. */
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
