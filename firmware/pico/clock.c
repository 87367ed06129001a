#include "clock.h"

/* 33 / 250,000 and its inverse, as fractions of powers of two. */
#define CYCLES_OF_PS 72567767ull /* x 2^-39 */
#define PS_OF_CYCLE 7943757576ull /* x 2^-20 */

static cycles now;
static uint32_t last; /* SysTick, which counts down in 24 bits */

static uint64_t anchor_instant;
static cycles anchor;

#define SOON (4 * (int64_t)US) /* the processor does not sleep for less */

#define ANCHOR_CYCLES (33u << 16) /* 16 ms */
#define ANCHOR_PS (250000ull << 16)

void clock_start(void)
{
    SYSTICK_RVR = 0xFFFFFF;
    SYSTICK_CVR = 0;
    SYSTICK_CSR = 5; /* the processor's clock */
    last = SYSTICK_CVR;
}

cycles clock_now(void)
{
    const uint32_t value = SYSTICK_CVR;
    now += (last - value) & 0xFFFFFF;
    last = value;
    return now;
}

void clock_write_after(volatile uint32_t *to, uint32_t number)
{
    uint32_t value = number - 6; /* from the read of SysTick to the write */
    uint32_t since;
    __asm__ volatile("ldr  %[since], [%[systick]]\n\t"
                     "subs %[since], %[last], %[since]\n\t"
                     "lsls %[since], %[since], #8\n\t"
                     "lsrs %[since], %[since], #8\n\t"
                     "subs %[value], %[value], %[since]\n\t"
                     "str  %[value], [%[to]]"
                     : [since] "=&l"(since), [value] "+l"(value)
                     : [systick] "l"(&SYSTICK_CVR), [last] "l"(last), [to] "l"(to)
                     : "cc", "memory");
}

void clock_move_anchor(void)
{
    while (clock_now() - anchor > 2 * ANCHOR_CYCLES) {
        anchor += ANCHOR_CYCLES;
        anchor_instant += ANCHOR_PS;
    }
}

cycles clock_of_stamp(uint32_t stamp)
{
    const int32_t later = (int32_t)((last - stamp) << 8) >> 8;
    return now + (cycles)(int64_t)later;
}

cycles clock_of_ps(uint64_t ps)
{
    return (ps * CYCLES_OF_PS + (1ull << 38)) >> 39;
}

uint64_t clock_ps_of(cycles count)
{
    return (count * PS_OF_CYCLE) >> 20;
}

uint64_t clock_instant(cycles at)
{
    const int64_t after = (int64_t)(at - anchor);
    return after < 0 ? anchor_instant - clock_ps_of((cycles)-after) : anchor_instant + clock_ps_of((cycles)after);
}

cycles clock_cycle(uint64_t instant)
{
    const int64_t after = (int64_t)(instant - anchor_instant);
    if (after < 0)
        return anchor - clock_of_ps((uint64_t)-after);
    return anchor + clock_of_ps(after > (int64_t)CLOCK_FAR_PS ? CLOCK_FAR_PS : (uint64_t)after);
}

void clock_sleep_until(cycles at, bool (*is_over)(void))
{
    hold();
    const int64_t left = (int64_t)(at - clock_now());
    if (left > SOON) {
        TIMER_INTR = 1;
        TIMER_ALARM0 = TIMER_RAW + (uint32_t)left / US; /* it has to be written before the timer reaches it */
        if (!is_over())
            __asm__ volatile("wfi"); /* an interrupt ends it, even while interrupts are off */
    }
    let_go();
}
