/* The second stage: the boot ROM copies these 256 bytes of the flash to RAM, checks the CRC-32 in the last four of them
   (2.8.1.3 of the data sheet of the RP2040), and calls them.  The flash interface is set up for the command that every
   flash memory supports, read (03h) with one line at a quarter of the clock, and then the program begins.

   It works with any memory on the board, which only has to be copied to RAM once. */
    .syntax unified
    .cpu cortex-m0plus
    .thumb

    .equ SSI, 0x18000000
    .equ CTRLR0, 0x00
    .equ CTRLR1, 0x04
    .equ ENABLE, 0x08
    .equ BAUDR, 0x14
    .equ SPI_CTRLR0, 0xF4

    .section .boot2, "ax"
    .global boot2
    .thumb_func
boot2:
    push {lr}
    ldr r0, =SSI
    movs r1, #0
    str r1, [r0, #ENABLE]
    movs r2, #4                 /* SCK is a quarter of the clock: 33 MHz at 132 MHz */
    str r2, [r0, #BAUDR]
    ldr r2, =(31 << 16) | (3 << 8) /* 32-bit words, EEPROM read, one line */
    str r2, [r0, #CTRLR0]
    str r1, [r0, #CTRLR1]       /* one word per read */
    ldr r3, =SSI + SPI_CTRLR0
    ldr r2, =(0x03 << 24) | (2 << 8) | (6 << 2) /* 8-bit command, 24-bit address, no wait */
    str r2, [r3]
    movs r2, #1
    str r2, [r0, #ENABLE]
    pop {r0}
    cmp r0, #0                  /* the ROM calls without a return address */
    beq 1f
    bx r0
1:  ldr r0, =0x10000100         /* the vectors of the program */
    ldr r1, [r0]
    msr msp, r1
    ldr r1, [r0, #4]
    bx r1
    .ltorg
