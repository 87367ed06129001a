/* Functions called by the compiler, faster than its library: division by the divider of the RP2040 (2.3.1.5 of its data
 * sheet), and copies by words.  The divider has one user: interrupts do not divide.
 */
#include <stddef.h>
#include <stdint.h>

#include "registers.h"

#define DIVIDEND REGISTER(0xD0000060u)
#define DIVISOR REGISTER(0xD0000064u)
#define QUOTIENT REGISTER(0xD0000070u)
#define REMAINDER REGISTER(0xD0000074u)

uint32_t __udivsi3(uint32_t dividend, uint32_t divisor);
uint32_t __aeabi_uidiv(uint32_t dividend, uint32_t divisor);
uint64_t __aeabi_uidivmod(uint32_t dividend, uint32_t divisor);

static inline void divide(uint32_t dividend, uint32_t divisor)
{
    DIVIDEND = dividend;
    DIVISOR = divisor;
    __asm__ volatile("b 1f\n1: b 2f\n2: b 3f\n3: b 4f\n4:"); /* eight cycles */
}

uint32_t __aeabi_uidiv(uint32_t dividend, uint32_t divisor)
{
    divide(dividend, divisor);
    return QUOTIENT;
}

uint32_t __udivsi3(uint32_t dividend, uint32_t divisor)
{
    divide(dividend, divisor);
    return QUOTIENT;
}

uint64_t __aeabi_uidivmod(uint32_t dividend, uint32_t divisor)
{
    divide(dividend, divisor);
    const uint32_t remainder = REMAINDER;
    return (uint64_t)remainder << 32 | QUOTIENT; /* QUOTIENT last: 2.3.1.5 */
}

void *memcpy(void *restrict to, const void *restrict from, size_t count)
{
    uint8_t *byte = to;
    const uint8_t *of = from;
    if (!(((uintptr_t)to | (uintptr_t)from) & 3)) {
        uint32_t *word = to;
        const uint32_t *of_word = from;
        for (; count >= 16; count -= 16)
            __asm__ volatile("ldmia %[from]!, {r3-r6}\n\tstmia %[to]!, {r3-r6}"
                             : [from] "+l"(of_word), [to] "+l"(word)
                             :
                             : "r3", "r4", "r5", "r6", "memory");
        for (; count >= 4; count -= 4)
            *word++ = *of_word++;
        byte = (uint8_t *)word;
        of = (const uint8_t *)of_word;
    }
    while (count--)
        *byte++ = *of++;
    return to;
}
