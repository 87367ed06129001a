/*
 * A host program in DOS style: it homes axis 1 through the I/O ports of an ISA board, and moves it.  On a PC with the
 * board it would include <conio.h>; here it reaches its chipset through a socket.
 *
 *     slewline serve mc1451a --tcp 127.0.0.1:4001 --control 127.0.0.1:4002
 *     cc -o homing homing.c && SLEWLINE=127.0.0.1:4001 ./homing
 *
 * To close the home switch, send {"do": "drive", "pin": "mc1451a.home1", "level": 0} to the control port.
 */
#include <stdio.h>
#include <stdlib.h>

#include "slewline_port.h"

#define BASE 0x340
#define DATA (BASE + 0)
#define COMMAND (BASE + 2)
#define STATUS (BASE + 4)

#define SET_POS 0x10
#define SET_VEL 0x11
#define SET_ACC 0x12
#define UPDATE 0x1a
#define GET_TRGT_POS 0x1d
#define GET_STATUS 0x31
#define CLR_STATUS 0x33
#define STOP 0x46
#define SET_ACTL_POS 0x4d
#define SET_EXT_BRK 0x5e
#define GET_VRSN 0x6c

#define MOTION_COMPLETE 0x0001
#define BREAKPOINT 0x0004
#define IN_MOTION 0x0400

static unsigned sum;                    /* checksum of the packet so far */

static void wait_ready(void)
{
    while (!(inp(STATUS) & 0x80))
        ;
}

static void command(unsigned code)
{
    wait_ready();
    outp(COMMAND, code);
    sum = code;
}

static void write_word(unsigned word)
{
    wait_ready();
    outp(DATA, word >> 8 & 0xff);
    wait_ready();
    outp(DATA, word & 0xff);
    sum += word;
}

static unsigned read_word(void)
{
    unsigned word;

    wait_ready();
    word = inp(DATA) << 8;
    wait_ready();
    word |= inp(DATA);
    sum += word;
    return word;
}

static void end_packet(void)
{
    unsigned expected = sum & 0xffff, found = read_word();

    if (found != expected) {
        fprintf(stderr, "checksum %04x, expected %04x\n", found, expected);
        exit(1);
    }
}

static void do_command(unsigned code)
{
    command(code);
    end_packet();
}

static void set_long(unsigned code, long value)
{
    command(code);
    write_word((unsigned)((unsigned long)value >> 16 & 0xffff));
    write_word((unsigned)((unsigned long)value & 0xffff));
    end_packet();
}

static unsigned get_word(unsigned code)
{
    unsigned word;

    command(code);
    word = read_word();
    end_packet();
    return word;
}

static long get_position(void)
{
    long high, low;

    command(GET_TRGT_POS);
    high = (long)read_word();
    low = (long)read_word();
    end_packet();
    return ((high ^ 0x8000L) - 0x8000L) * 0x10000L + low;
}

static void wait_status(unsigned bit)
{
    while (!(get_word(GET_STATUS) & bit))
        ;
}

int main(void)
{
    printf("version %04x\n", get_word(GET_VRSN));
    fflush(stdout);

    set_long(SET_POS, -1000000000L);    /* beyond the switch */
    set_long(SET_VEL, 0x100000L);
    set_long(SET_ACC, 0x4000L);
    do_command(UPDATE);
    wait_status(IN_MOTION);             /* the update has taken effect; later commands wait for the next */
    do_command(STOP);
    do_command(SET_EXT_BRK);            /* which will come from a low HOME */
    wait_status(BREAKPOINT);
    wait_status(MOTION_COMPLETE);
    printf("home\n");

    set_long(SET_ACTL_POS, 0L);
    set_long(SET_POS, 500L);
    do_command(CLR_STATUS);
    do_command(UPDATE);
    wait_status(MOTION_COMPLETE);
    printf("at %ld\n", get_position());
    return 0;
}
