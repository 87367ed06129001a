#include "flash.h"

#include "registers.h"

enum { PROGRAM = 0x02, READ = 0x03, STATUS = 0x05, ENABLE = 0x06, ERASE = 0x20, BUSY = 1 };
enum { SELECT_LOW = 2 << 8, SELECT_HIGH = 3 << 8, DIVISOR = 4 };

void flash_start(void)
{
    QSPI_SS_CTRL = SELECT_HIGH;
    SSI_ENABLE = 0;
    SSI_CTRLR0 = 7u << 16; /* bytes, one line, both ways */
    SSI_CTRLR1 = 0;
    SSI_BAUDR = DIVISOR; /* 33 MHz: READ allows 50 */
    SSI_SER = 1;
    SSI_ENABLE = 1;
}

static uint8_t exchange(uint8_t byte)
{
    SSI_DR = byte;
    while (!(SSI_SR & 8))
        ;
    return (uint8_t)SSI_DR;
}

static void begin(uint8_t command)
{
    QSPI_SS_CTRL = SELECT_LOW;
    (void)exchange(command);
}

static void at(uint32_t address)
{
    (void)exchange((uint8_t)(address >> 16));
    (void)exchange((uint8_t)(address >> 8));
    (void)exchange((uint8_t)address);
}

static void end(void)
{
    QSPI_SS_CTRL = SELECT_HIGH;
}

static void enable(void)
{
    begin(ENABLE);
    end();
}

void flash_read(uint32_t address, uint8_t *to, uint32_t length)
{
    begin(READ);
    at(address);
    while (length--)
        *to++ = exchange(0);
    end();
}

void flash_erase(uint32_t address)
{
    enable();
    begin(ERASE);
    at(address);
    end();
}

void flash_program(uint32_t address, const uint8_t *from, uint32_t length)
{
    enable();
    begin(PROGRAM);
    at(address);
    while (length--)
        (void)exchange(*from++);
    end();
}

bool flash_is_busy(void)
{
    begin(STATUS);
    const bool is_busy = exchange(0) & BUSY;
    end();
    return is_busy;
}
