/* The flash memory, byte by byte over its own commands; the caller polls for the end of an erase or program. */
#ifndef FLASH_H
#define FLASH_H

#include <stdbool.h>
#include <stdint.h>

#define FLASH_PAGE 256u

void flash_start(void); /* code can no longer run from flash */
void flash_read(uint32_t address, uint8_t *to, uint32_t length);
void flash_erase(uint32_t address); /* begin to erase a sector: to 0xFF */
void flash_program(uint32_t address, const uint8_t *from, uint32_t length); /* begin; within a page */
bool flash_is_busy(void);

#endif
