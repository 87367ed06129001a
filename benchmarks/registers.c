/*
 * Milliseconds of so many exchanges, the median: SET_POS 12345 with a poll before each byte, as an old program sends it,
 * on the chipset that SLEWLINE names; with the port of an echo, two bytes there and back.
 */
#define _POSIX_C_SOURCE 199309L
#include <time.h>
#include "slewline_port.h"

#define MOST 100000
static double took[MOST];

static double now(void)
{
    struct timespec time;

    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec * 1e3 + (double)time.tv_nsec / 1e6;
}

static int order(const void *one, const void *other)
{
    double difference = *(const double *)one - *(const double *)other;

    return difference < 0 ? -1 : difference > 0;
}

static void ready(void)
{
    while (!(inp(0x344) & 0x80))
        ;
}

static void packet(void)
{
    static const unsigned char bytes[] = {0, 0, 0x30, 0x39};
    unsigned at, word;

    ready();
    outp(0x342, 0x10);
    for (at = 0; at < sizeof bytes; at++) {
        ready();
        outp(0x340, bytes[at]);
    }
    ready();
    word = (unsigned)inp(0x340) << 8;
    ready();
    word |= inp(0x340);
    if (word != 0x3049)
        slewline_lost("the checksum is wrong");
}

static void echo(void)
{
    unsigned char bytes[2] = {0, 0};

    slewline_write(bytes, 2);
    slewline_read(bytes, 2);
}

int main(int count, char **words)
{
    void (*exchange)(void) = count == 3 ? echo : packet;
    int number = count > 1 ? atoi(words[1]) : 0, at;
    double begun;

    if (number < 1 || number > MOST || (count == 3 && slewline_connect("127.0.0.1", atoi(words[2])) != 0))
        return 2;
    for (at = -20; at < number; at++) {
        begun = now();
        exchange();
        if (at >= 0)
            took[at] = now() - begun;
    }
    qsort(took, (size_t)number, sizeof took[0], order);
    printf("%.6f\n", took[number / 2]);
    return 0;
}
