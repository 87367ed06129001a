/* A GS-C200S on a Raspberry Pi Pico.
 *
 *   boot2.S, start.c   from the flash to RAM
 *   part.c             the core, ../part/gs_c200, between its pins
 *   inputs.c           queued edges, with their time stamps
 *   outputs.c          levels
 *   steps.c, serial.c  the state machines: CLOCK, RXD, TXD
 *   store.c, flash.c   the program saved by M
 *   clock.c            cycles, and picoseconds
 *
 * This is not a safety device: an emergency stop must cut the driver's power.
 */
#include "clock.h"
#include "flash.h"
#include "inputs.h"
#include "part.h"
#include "pins.h"
#include "registers.h"
#include "serial.h"
#include "steps.h"

#define WATCHDOG_US 100000u

extern uint32_t stack_top;
static void hang(void)
{
    hold();
    for (;;) /* until the watchdog resets */
        ;
}

static void alarm(void)
{
    TIMER_INTR = 1;
}

int main(void);

__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*handlers[15 + IRQS])(void);
} vectors = {
    &stack_top,
    {
        [0] = (void (*)(void))main, /* unused: start.c runs first */
        [1] = hang, /* NMI */
        [2] = hang, /* a fault */
        [10] = hang,
        [13] = hang,
        [14] = hang,
        [15 + IRQ_TIMER_0] = alarm,
        [15 + IRQ_PIO0_0] = steps_interrupt,
        [15 + IRQ_PIO1_0] = serial_interrupt,
        [15 + IRQ_IO_BANK0] = inputs_interrupt,
    },
};

static void start_pins(void)
{
    const uint32_t wanted = RESETS_IO_BANK0 | RESETS_PADS_BANK0 | RESETS_PIO0 | RESETS_PIO1 | RESETS_TIMER;
    CLEAR(RESETS) = wanted;
    while (~RESETS_DONE & wanted)
        ;
    /* Levels first, then directions: as it becomes an output, each pin has the level of its resistor. */
    SIO_OUT_SET = 1u << PIN_DIR | 1u << PIN_RESET | 1u << PIN_RDY | 1u << PIN_LED;
    for (unsigned pin = 0; pin <= PIN_TXD; pin++) {
        if (pin <= PIN_TEST) {
            PAD(pin) = PAD_SCHMITT | PAD_UP | PAD_INPUT;
            GPIO_CTRL(pin) = FUNCTION_SIO;
        } else if (pin != PIN_CLOCK && pin != PIN_TXD && (pin <= PIN_UO1 || pin == PIN_LED || pin >= PIN_UO2)) {
            PAD(pin) = PAD_SCHMITT | PAD_4MA | PAD_INPUT;
            GPIO_CTRL(pin) = FUNCTION_SIO;
            SIO_OE_SET = 1u << pin;
        }
    }
    steps_start();
    PAD(PIN_CLOCK) = PAD_SCHMITT | PAD_4MA | PAD_INPUT;
    GPIO_CTRL(PIN_CLOCK) = FUNCTION_PIO0;
    PAD(PIN_TXD) = PAD_SCHMITT | PAD_UP | PAD_12MA | PAD_INPUT; /* the mark, until the rate is known */
    GPIO_CTRL(PIN_TXD) = FUNCTION_PIO1;
    GPIO_INTR(PIN_HOME) = 0xFFFFFFFFu;
    for (unsigned pin = PIN_HOME; pin <= PIN_UI3; pin++)
        SET(GPIO_INTE(pin)) = (uint32_t)EDGES << 4 * (pin % 8);
}

int main(void)
{
    WATCHDOG_TICK = 1u << 9 | 12; /* a microsecond, for the timer too */
    PSM_WDSEL = 0x1FFFF & ~3u;    /* it resets everything except the two oscillators */
    BOD = 0xB << 4 | 1;           /* a core below 0.946 V is reset */
    clock_start();
    start_pins();
    flash_start();
    TIMER_INTE = 1;
    NVIC_ENABLE = 1u << IRQ_TIMER_0 | 1u << IRQ_PIO0_0 | 1u << IRQ_PIO1_0 | 1u << IRQ_IO_BANK0;
    WATCHDOG_LOAD = 2 * WATCHDOG_US; /* it counts twice per microsecond: erratum E1 */
    WATCHDOG_CTRL = 1u << 30;
    part_start();
    let_go();
    for (;;) {
        WATCHDOG_LOAD = 2 * WATCHDOG_US;
        part_round();
    }
}
