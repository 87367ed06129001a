/* The pins of the Pico for the pins of the part.  All 26 are in use.
 *
 * The inputs are GP0 to GP14 in the order of enum gsc_input, so all levels are read together; GP25 is the LED of the Pico.
 * While they are not driven, resistors on the board keep the outputs at the levels in the comments.
 */
#ifndef PINS_H
#define PINS_H

enum pin {
    PIN_SEL0 = 0, /* GP0 to GP14: enum gsc_input; RXD comes through an optocoupler, so 1 is the mark here */
    PIN_RXD = 8,
    PIN_ENABLE = 9,
    PIN_HOME = 10,
    PIN_EOT = 11,
    PIN_UI3 = 14,
    PIN_TEST = 15,
    PIN_CLOCK = 16, /* pulled up */
    PIN_DIR = 17,   /* pulled up */
    PIN_MOV = 18,
    PIN_RAMP = 19,
    PIN_RESET = 20, /* pulled up */
    PIN_RDY = 21,   /* 1, or not driven: the transistor pulls RDY low; pulled up */
    PIN_UO1 = 22,
    PIN_LED = 25,
    PIN_UO2 = 26,
    PIN_UO3 = 27,
    PIN_TXD = 28 /* 1 is the mark: the transistor is off; pulled up */
};

#define OF_THE_PART 0x7FFFu /* bits of enum gsc_input */

#endif
