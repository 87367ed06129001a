/* Constants shared by the board, the tool that builds its file and the tests. */
#ifndef SIZES_H
#define SIZES_H

#include <stdint.h>

#define HEADER_MAGIC 0x32435347u /* GSC2 */
#ifndef VERSION_TEXT
#define VERSION_TEXT "slewline gs-c200s pico 0"
#endif

struct header {
    uint32_t magic, length, crc;
    char version[48];
};

/* The last two sectors of 2 MB: no firmware file reaches them, so an update keeps the program. */
#define SECTOR 4096u
#define STORE_A 0x1FE000u
#define STORE_B 0x1FF000u

/* The clock: cycles per second and per microsecond; 33 cycles are 250 ns. */
#define CLOCK_HZ 132000000u
#define US 132u

#endif
