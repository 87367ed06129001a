/* Instructions of a PIO, 3.4 of the data sheet of the RP2040; each takes a cycle, and its delay. */
#ifndef PIO_CODE_H
#define PIO_CODE_H

#define DELAY(cycles) ((cycles) << 8)

#define JMP(to) (0x0000 | (to))
#define JMP_X_AND_COUNT(to) (0x0040 | (to)) /* if x was not 0; x is decremented in any case */
#define JMP_Y_AND_COUNT(to) (0x0080 | (to))
#define JMP_PIN(to) (0x00C0 | (to))
#define WAIT_PIN(level) (0x2020 | (level) << 7) /* of pin 0 of the inputs */
#define IN_PINS(bits) (0x4000 | ((bits) & 31))
#define IN_X(bits) (0x4020 | ((bits) & 31))
#define OUT_PINS(bits) (0x6000 | ((bits) & 31))
#define OUT_X(bits) (0x6020 | ((bits) & 31))
#define PUSH 0x8000 /* no effect if there is no room */
#define PULL 0x80A0 /* wait for a word */
#define MOV_X_Y 0xA022
#define MOV_X_ISR 0xA026
#define MOV_X_OSR 0xA027
#define MOV_Y_OSR 0xA047
#define MOV_ISR_OSR 0xA0C7
#define MOV_X_ONES 0xA02B /* inverse of NULL */
#define IRQ_SET(flag) (0xC000 | (flag))
#define SET_PINS(value) (0xE000 | (value))
#define SET_X(value) (0xE020 | (value))
#define SET_Y(value) (0xE040 | (value))
#define SET_DIRECTIONS(value) (0xE080 | (value))

/* The wrap of a program: its target, and the place after which it wraps. */
#define WRAP(bottom, top) ((uint32_t)(top) << 12 | (uint32_t)(bottom) << 7)

#endif
