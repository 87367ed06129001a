/*
 * The tick of each step of a move, as firmware that generates steps computes it: segments of interval, count and add,
 * a step whenever the interval has passed, and the next interval longer by add.
 */
#include <stdint.h>

int64_t generate(const int64_t *segments, int64_t number, int64_t now, int64_t *ticks)
{
    const int64_t *end = segments + 3 * number;
    int64_t *next = ticks;

    for (; segments < end; segments += 3) {
        int64_t interval = segments[0], add = segments[2], left;

        for (left = segments[1]; left > 0; left--) {
            *next++ = now;
            now += interval;
            interval += add;
        }
    }
    return next - ticks;
}
