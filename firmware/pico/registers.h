/* The registers of the RP2040 that this firmware uses; sections are those of its data sheet. */
#ifndef REGISTERS_H
#define REGISTERS_H

#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(address))

/* Writes to these addresses change single bits without reading: 2.1.2. */
#define SET(address) REGISTER((address) + 0x2000u)
#define CLEAR(address) REGISTER((address) + 0x3000u)

/* ------------------------------------------------------------------------------------------------------ 2.14, resets */
#define RESETS 0x4000C000u
#define RESETS_DONE REGISTER(0x4000C008u)
enum {
    RESETS_IO_BANK0 = 1 << 5,
    RESETS_PADS_BANK0 = 1 << 8,
    RESETS_PIO0 = 1 << 10,
    RESETS_PIO1 = 1 << 11,
    RESETS_PLL_SYS = 1 << 12,
    RESETS_TIMER = 1 << 21
};

/* ------------------------------------------------------------------------------- 2.15 to 2.18, crystal, PLL, clocks */
#define XOSC_CTRL REGISTER(0x40024000u)
#define XOSC_STATUS REGISTER(0x40024004u)
#define XOSC_STARTUP REGISTER(0x4002400Cu)
#define PLL_CS REGISTER(0x40028000u)
#define PLL_PWR 0x40028004u
#define PLL_FBDIV REGISTER(0x40028008u)
#define PLL_PRIM REGISTER(0x4002800Cu)
#define CLK_REF_CTRL REGISTER(0x40008030u)
#define CLK_REF_SELECTED REGISTER(0x40008038u)
#define CLK_SYS_CTRL 0x4000803Cu
#define CLK_SYS_SELECTED REGISTER(0x40008044u)

/* ------------------------------------------------------------------------------------------- 4.7, watchdog, and tick */
#define WATCHDOG_CTRL REGISTER(0x40058000u)
#define WATCHDOG_LOAD REGISTER(0x40058004u)
#define WATCHDOG_REASON REGISTER(0x40058008u)
#define WATCHDOG_TICK REGISTER(0x4005802Cu)
#define PSM_WDSEL REGISTER(0x40010008u)

/* -------------------------------------------------------------------------------- 2.10, brown-out; 4.6, timer; SysTick */
#define BOD REGISTER(0x40064004u)
#define TIMER_ALARM0 REGISTER(0x40054010u)
#define TIMER_RAW REGISTER(0x40054028u)
#define TIMER_INTR REGISTER(0x40054034u)
#define TIMER_INTE REGISTER(0x40054038u)
#define SYSTICK_CSR REGISTER(0xE000E010u)
#define SYSTICK_RVR REGISTER(0xE000E014u)
#define SYSTICK_CVR REGISTER(0xE000E018u)

/* ------------------------------------------------------------------------------------------------- interrupts: 2.3.2 */
#define NVIC_ENABLE REGISTER(0xE000E100u)
#define VTOR REGISTER(0xE000ED08u)
enum { IRQ_TIMER_0 = 0, IRQ_PIO0_0 = 7, IRQ_PIO1_0 = 9, IRQ_IO_BANK0 = 13, IRQS = 26 };

/* --------------------------------------------------------------------------------------------------- 2.19, 2.3.1, pins */
#define GPIO_CTRL(pin) REGISTER(0x40014004u + 8u * (pin))
#define GPIO_INTR(pin) REGISTER(0x400140F0u + 4u * ((pin) / 8u))
#define GPIO_INTE(pin) (0x40014100u + 4u * ((pin) / 8u))
enum { FUNCTION_SIO = 5, FUNCTION_PIO0 = 6, FUNCTION_PIO1 = 7, EDGES = 0xC /* of the four bits of a pin: low, high */ };
#define PAD(pin) REGISTER(0x4001C004u + 4u * (pin))
enum { PAD_SCHMITT = 1 << 1, PAD_DOWN = 1 << 2, PAD_UP = 1 << 3, PAD_4MA = 1 << 4, PAD_12MA = 3 << 4, PAD_INPUT = 1 << 6 };
#define SIO_IN REGISTER(0xD0000004u)
#define SIO_OUT_SET REGISTER(0xD0000014u)
#define SIO_OUT_CLEAR REGISTER(0xD0000018u)
#define SIO_OE_SET REGISTER(0xD0000024u)

/* ------------------------------------------------------------------------------------------------- 3.7, PIO 0 and 1 */
#define PIO0 0x50200000u
#define PIO1 0x50300000u
#define PIO_CTRL(pio) (pio)
#define PIO_FSTAT(pio) REGISTER((pio) + 0x004u)
#define PIO_FDEBUG(pio) REGISTER((pio) + 0x008u)
#define PIO_TX(pio, machine) REGISTER((pio) + 0x010u + 4u * (machine))
#define PIO_RX(pio, machine) REGISTER((pio) + 0x020u + 4u * (machine))
#define PIO_IRQ(pio) REGISTER((pio) + 0x030u)
#define PIO_MEMORY(pio, place) REGISTER((pio) + 0x048u + 4u * (place))
#define PIO_EXECCTRL(pio, machine) REGISTER((pio) + 0x0CCu + 24u * (machine))
#define PIO_SHIFTCTRL(pio, machine) REGISTER((pio) + 0x0D0u + 24u * (machine))
#define PIO_ADDR(pio, machine) REGISTER((pio) + 0x0D4u + 24u * (machine))
#define PIO_INSTR(pio, machine) REGISTER((pio) + 0x0D8u + 24u * (machine))
#define PIO_PINCTRL(pio, machine) REGISTER((pio) + 0x0DCu + 24u * (machine))
#define PIO_INTE(pio) REGISTER((pio) + 0x12Cu)

/* -------------------------------------------------------------------------------------- 4.10, the port of the flash */
#define SSI_CTRLR0 REGISTER(0x18000000u)
#define SSI_CTRLR1 REGISTER(0x18000004u)
#define SSI_ENABLE REGISTER(0x18000008u)
#define SSI_SER REGISTER(0x18000010u)
#define SSI_BAUDR REGISTER(0x18000014u)
#define SSI_SR REGISTER(0x18000028u)
#define SSI_DR REGISTER(0x18000060u)
#define QSPI_SS_CTRL REGISTER(0x4001800Cu)

static inline void hold(void)
{
    __asm__ volatile("cpsid i" ::: "memory");
}

static inline void let_go(void)
{
    __asm__ volatile("cpsie i" ::: "memory");
}

#endif
