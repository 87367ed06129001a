/* From the second stage to main(): clocks, the image to RAM, its check.  All of this runs in flash.
 *
 * A damaged image is not run: every pin remains an input, as at power-up, so the pull-ups and pull-downs of the
 * board keep the driver at rest; the LED flashes in pairs.  Remedy: BOOTSEL, and copy the file again.
 */
#include "registers.h"
#include "sizes.h"

#define START __attribute__((section(".start"), noinline))
#define LED 25u

extern uint32_t stack_top, image_begin, image_end, bss_begin, bss_end;
extern const uint32_t image_stored;
int main(void);
static void reset(void) START;

__attribute__((section(".start_vectors"), used)) static void *const start_vectors[2] = {&stack_top, (void *)reset};

/* The tool that builds the file puts the length and the CRC-32 of the image here. */
__attribute__((section(".header"), used)) static const volatile struct header header = {HEADER_MAGIC, 0, 0, VERSION_TEXT};

/* The crystal is 12 MHz; 12 x 110 / (5 x 2) is 132: a bit has a whole number of cycles at all eight rates. */
static void START start_clocks(void)
{
    XOSC_CTRL = 0xAA0;                /* 1 to 15 MHz */
    XOSC_STARTUP = 47;                /* x 256 of its cycles: 1 ms */
    SET(0x40024000u) = 0xFAB000;
    while (!(XOSC_STATUS >> 31))
        ;
    CLK_REF_CTRL = 2;
    while (!(CLK_REF_SELECTED & 4))
        ;
    CLEAR(RESETS) = RESETS_PLL_SYS;
    while (!(RESETS_DONE & RESETS_PLL_SYS))
        ;
    PLL_CS = 1;
    PLL_FBDIV = 110;
    CLEAR(PLL_PWR) = 0x21;            /* on, and the VCO */
    while (!(PLL_CS >> 31))
        ;
    PLL_PRIM = 5u << 16 | 2u << 12;
    CLEAR(PLL_PWR) = 8;               /* the dividers after it */
    REGISTER(CLK_SYS_CTRL) = 0;       /* auxiliary source: PLL */
    REGISTER(CLK_SYS_CTRL) = 1;
    while (!(CLK_SYS_SELECTED & 2))
        ;
}

/* CRC-32 (IEEE 802.3, reflected), half a byte at a time. */
__attribute__((section(".start.nibbles"))) static const uint32_t NIBBLES[16] = {
    0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
    0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
};

static uint32_t START crc32_of(const uint8_t *from, uint32_t length)
{
    uint32_t crc = 0xFFFFFFFFu;
    while (length--) {
        crc ^= *from++;
        crc = crc >> 4 ^ NIBBLES[crc & 15];
        crc = crc >> 4 ^ NIBBLES[crc & 15];
    }
    return ~crc;
}

static void START flash_in_pairs(void)
{
    CLEAR(RESETS) = RESETS_IO_BANK0 | RESETS_PADS_BANK0;
    while (~RESETS_DONE & (RESETS_IO_BANK0 | RESETS_PADS_BANK0))
        ;
    GPIO_CTRL(LED) = FUNCTION_SIO;
    SIO_OE_SET = 1u << LED;
    for (unsigned beat = 0;; beat = (beat + 1) % 8) {
        if (beat == 0 || beat == 2)
            SIO_OUT_SET = 1u << LED;
        else
            SIO_OUT_CLEAR = 1u << LED;
        for (volatile uint32_t wait = 0; wait < 2000000; wait++)
            ;
    }
}

static void reset(void)
{
    hold();
    start_clocks();
    const uint32_t length = (uint32_t)((uint8_t *)&image_end - (uint8_t *)&image_begin);
    if (header.length != length || crc32_of((const uint8_t *)&image_stored, length) != header.crc)
        flash_in_pairs();
    const uint32_t *from = &image_stored;
    for (uint32_t *to = &image_begin; to < &image_end;)
        *to++ = *from++;
    for (uint32_t *to = &bss_begin; to < &bss_end;)
        *to++ = 0;
    VTOR = (uint32_t)&image_begin;
    main();
    for (;;)
        ;
}
