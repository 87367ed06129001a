/*
 * Port I/O between a host program and a chipset that slewline serves:
 *
 *     slewline serve mc1451a --tcp 127.0.0.1:4001
 *
 * Include this file after all others.  Calls such as outp(0x342, byte) and inp(0x344), under any name that a compiler
 * uses for them, then access the chipset; only the lowest four bits of an address matter.  Either call
 *
 *     slewline_open("127.0.0.1", 4001)        returns 0, or -1 with the reason on stderr
 *
 * first, or leave the program unchanged and name the server in its environment: SLEWLINE=127.0.0.1:4001
 *
 *     slewline_out(address, byte)             OUT; the byte has been sent when the call returns
 *     slewline_in(address)                    IN
 *     slewline_ready(ms)                      wait up to ms (0..255, chipset time) for HostRdy; returns its level
 *     slewline_close()
 *
 * In lockstep this file does not wait for an answer that it can predict: HostRdy is low after a command and after the
 * second byte of a word until one poll has read it low, and high after the first byte.  Each request is sent without
 * delay; the server processes requests in order, at the instants at which it would if every answer were waited for.
 * If HostRdy stays low, the next answer that has to be read shows it.  From then on the chipset answers polls, and the
 * bytes that the program has written in the meantime are kept until HostRdy is high.  With
 *
 *     #define SLEWLINE_PLAIN
 *
 * before the #include, it waits for every answer.  It does the same with a server in real time, and with an older
 * server, which rejects the request 90 02.
 *
 * If the connection to the server is lost, the program prints a message and exits with status 1.
 * C89; POSIX sockets, or Winsock 2 (link with ws2_32).  One chipset, one thread, one source file that includes this.
 */
#ifndef SLEWLINE_PORT_H
#define SLEWLINE_PORT_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef _WIN32
#include <winsock2.h>
#define slewline_hang_up closesocket
typedef SOCKET slewline_socket;
#else
#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>
#define slewline_hang_up close
typedef int slewline_socket;
#endif

#ifdef MSG_NOSIGNAL
#define SLEWLINE_SEND MSG_NOSIGNAL /* a lost server is an error, not a signal */
#else
#define SLEWLINE_SEND 0
#endif
#ifdef __GNUC__
#define SLEWLINE_CALL static __attribute__((unused))
#else
#define SLEWLINE_CALL static
#endif

static slewline_socket slewline_connection;
static int slewline_is_open = 0;

/* The requests of the protocol, in docs/reference/registers.md */
#define SLEWLINE_READY 0x24
#define SLEWLINE_POLL 0x54
#define SLEWLINE_HELLO 0x90
#define SLEWLINE_SERIES 0xC0
#define SLEWLINE_ON 0xC1
#define SLEWLINE_MOST 64 /* requests in flight */
#define SLEWLINE_MS 100  /* timeout of a poll; it is then repeated */
#define SLEWLINE_TRIES 10 /* polls before a byte is read regardless */

static unsigned char slewline_sent[2 * SLEWLINE_MOST]; /* requests whose answers are unread */
static int slewline_under_way = 0;                     /* their number */
static int slewline_foresees = 0;                      /* the server accepts series, and its time stops between them */
static int slewline_stays_low = 0;                     /* requests are kept because HostRdy has stayed low */
/* The register offsets; the first line of a server with a different card gives others.  -1: no such register */
static int slewline_data = 0, slewline_command = 2, slewline_status = 4, slewline_reset = 8;
static int slewline_half[2];  /* one byte of a word has been read, or written */
static int slewline_high = 0;  /* HostRdy is high, as a poll has shown */
static int slewline_known = 0; /* a command was written while it was high, so the bytes of words are counted */
/* What the next poll will read: unknown, so query the server; HostRdy low; HostRdy high */
static enum { SLEWLINE_ASK, SLEWLINE_LOW, SLEWLINE_HIGH } slewline_next = SLEWLINE_ASK;

/* End the program: a port can no longer return an answer. */
SLEWLINE_CALL void slewline_lost(const char *why)
{
    fprintf(stderr, "slewline_port: %s\n", why);
    exit(1);
}

/* Read a number of bytes; returns how many arrived before the server closed the connection. */
SLEWLINE_CALL int slewline_read(unsigned char *bytes, int number)
{
    int got, have = 0;

    while (have < number && (got = (int)recv(slewline_connection, (char *)bytes + have, number - have, 0)) > 0)
        have += got;
    return have;
}

/* Send bytes; if the connection is lost, end the program. */
SLEWLINE_CALL void slewline_write(const unsigned char *bytes, int number)
{
    if (send(slewline_connection, (const char *)bytes, number, SLEWLINE_SEND) != number)
        slewline_lost("the server has closed the connection");
}

/* Send requests as one series; `on`: it depends on the previous series. */
SLEWLINE_CALL void slewline_send_series(const unsigned char *requests, int number, int on)
{
    unsigned char bytes[2 + 2 * SLEWLINE_MOST];

    bytes[0] = on ? SLEWLINE_ON : SLEWLINE_SERIES;
    bytes[1] = (unsigned char)number;
    memcpy(bytes + 2, requests, 2 * (size_t)number);
    slewline_write(bytes, 2 + 2 * number);
}

/* Read the answers to all requests in flight; returns the last.  Keep the requests from the first failed poll on. */
SLEWLINE_CALL unsigned char slewline_collect(void)
{
    unsigned char answers[SLEWLINE_MOST];
    int at, number = slewline_under_way;

    if (slewline_read(answers, number) != number)
        slewline_lost("the server has closed the connection");
    for (at = 0; at < number; at++)
        if (slewline_sent[2 * at] == SLEWLINE_POLL && !(answers[at] & 0x80))
            break;
    slewline_stays_low = at < number;
    slewline_under_way = number - at;
    memmove(slewline_sent, slewline_sent + 2 * at, 2 * (size_t)slewline_under_way);
    return (unsigned char)(slewline_stays_low ? 0x7F : answers[number - 1]);
}

/* Send the kept requests again, beginning with request `from`; if `waits` is 0, without waiting for HostRdy. */
SLEWLINE_CALL unsigned char slewline_again(int from, int waits)
{
    int at, number = 0;

    for (at = from; at < slewline_under_way; at++)
        if (waits || slewline_sent[2 * at] != SLEWLINE_POLL) {
            slewline_sent[2 * number] = slewline_sent[2 * at];
            slewline_sent[2 * number + 1] = slewline_sent[2 * at + 1];
            number++;
        }
    slewline_under_way = number;
    slewline_stays_low = 0;
    if (number == 0)
        return 0xFF;
    slewline_send_series(slewline_sent, number, 0);
    return slewline_collect();
}

/* Send a request immediately. */
SLEWLINE_CALL void slewline_go(unsigned request, unsigned value)
{
    unsigned char *at;

    if (slewline_under_way == SLEWLINE_MOST && !slewline_stays_low)
        slewline_collect();
    if (slewline_under_way == SLEWLINE_MOST)
        slewline_again(0, 0);
    at = slewline_sent + 2 * slewline_under_way++;
    at[0] = (unsigned char)request;
    at[1] = (unsigned char)value;
    if (!slewline_stays_low)
        slewline_send_series(at, 1, slewline_under_way > 1);
}

/* Predict nothing until a command is written while HostRdy is high. */
SLEWLINE_CALL void slewline_forget(void)
{
    slewline_high = slewline_known = 0;
    slewline_next = SLEWLINE_ASK;
}

SLEWLINE_CALL void slewline_close(void)
{
    if (slewline_is_open) {
        if (slewline_under_way > 0 && !slewline_stays_low)
            slewline_collect(); /* closing a socket with unread answers may discard sent requests */
        slewline_hang_up(slewline_connection);
    }
    slewline_is_open = slewline_foresees = slewline_under_way = slewline_stays_low = 0;
    slewline_forget();
}

/* Connect a socket; returns 0, or -1. */
SLEWLINE_CALL int slewline_connect(const char *host, int port)
{
    struct sockaddr_in address;
    struct hostent *found;
    int on = 1;
#ifdef _WIN32
    WSADATA data;

    WSAStartup(MAKEWORD(2, 2), &data);
#endif
    found = gethostbyname(host);
    if (found == NULL || found->h_addrtype != AF_INET)
        return -1;
    memset(&address, 0, sizeof address);
    address.sin_family = AF_INET;
    address.sin_port = htons((unsigned short)port);
    memcpy(&address.sin_addr, found->h_addr_list[0], sizeof address.sin_addr);
    slewline_connection = socket(AF_INET, SOCK_STREAM, 0);
    slewline_is_open = 1;
    setsockopt(slewline_connection, IPPROTO_TCP, TCP_NODELAY, (char *)&on, sizeof on);
    return connect(slewline_connection, (struct sockaddr *)&address, sizeof address) == 0 ? 0 : -1;
}

/* Query the capabilities of the server: FF is an older server; bit 7 is set in lockstep. */
SLEWLINE_CALL void slewline_greet(void)
{
    static int at_exit = 0;
    unsigned char bytes[2];

    bytes[0] = SLEWLINE_HELLO;
    bytes[1] = 2;
    slewline_write(bytes, 2);
    if (slewline_read(bytes, 1) != 1)
        slewline_lost("the server has closed the connection");
    slewline_foresees = bytes[0] != 0xFF && (bytes[0] & 0x80) && (bytes[0] & 0x7F) >= 2;
    if (slewline_foresees && !at_exit)
        at_exit = atexit(slewline_close) == 0;
}

/* Return the offset of a register from the first line of the server, with entries like " status=1"; else `usual`. */
SLEWLINE_CALL int slewline_place(const char *line, const char *name, int usual)
{
    const char *found = strstr(line, name);

    return found == NULL ? usual : atoi(found + strlen(name));
}

SLEWLINE_CALL int slewline_open(const char *host, int port)
{
    static const char greeting[] = "slewline registers 1 ";
    char line[200];
    int at = 0;

    slewline_close();
    if (slewline_connect(host, port) != 0) {
        fprintf(stderr, "slewline_port: no server at %s:%d\n", host, port);
        slewline_close();
        return -1;
    }
    while (at < (int)sizeof line - 1 && slewline_read((unsigned char *)line + at, 1) == 1 && line[at] != '\n')
        at++;
    line[at] = '\0';
    if (strncmp(line, greeting, sizeof greeting - 1) != 0) {
        fprintf(stderr, "slewline_port: %s:%d says: %s\n", host, port, line);
        slewline_close();
        return -1;
    }
    slewline_data = slewline_place(line, " data=", 0);
    slewline_command = slewline_place(line, " command=", 2);
    slewline_status = slewline_place(line, " status=", 4);
    slewline_reset = slewline_place(line, " reset=", strchr(line, '=') == NULL ? 8 : -1);
#ifndef SLEWLINE_PLAIN
    slewline_greet();
#endif
    return 0;
}

/* Connect to the server that the environment names. */
SLEWLINE_CALL void slewline_open_named(void)
{
    const char *where = getenv("SLEWLINE"), *colon = where == NULL ? NULL : strrchr(where, ':');
    char host[200];

    if (colon == NULL || colon - where >= (int)sizeof host)
        slewline_lost("where is the chipset? call slewline_open, or set SLEWLINE=127.0.0.1:4001");
    memcpy(host, where, (size_t)(colon - where));
    host[colon - where] = '\0';
    if (slewline_open(host, atoi(colon + 1)) != 0)
        exit(1);
}

/* A request of two bytes and its answer. */
SLEWLINE_CALL unsigned char slewline_ask(unsigned request, unsigned value)
{
    unsigned char bytes[2];

    bytes[0] = (unsigned char)request;
    bytes[1] = (unsigned char)value;
    slewline_write(bytes, 2);
    if (slewline_read(bytes, 1) != 1)
        slewline_lost("the server has closed the connection");
    return bytes[0];
}

/* Return whether this file answers predictable requests itself.  Connects first, if necessary. */
SLEWLINE_CALL int slewline_foreseeing(void)
{
    if (!slewline_is_open)
        slewline_open_named();
    return slewline_foresees;
}

/* The data or command register has been accessed: update the prediction of the next poll. */
SLEWLINE_CALL void slewline_used(unsigned address, int written)
{
    int command = written && (int)(address & 15) == slewline_command;

    if (command)
        slewline_half[0] = slewline_half[1] = 0;
    else
        slewline_half[written] = !slewline_half[written];
    if (!slewline_high || !(command || slewline_known)) { /* while HostRdy is low, writes have no effect */
        slewline_forget();
        return;
    }
    slewline_known = 1;
    slewline_high = !command && slewline_half[written];
    slewline_next = slewline_high ? SLEWLINE_HIGH : SLEWLINE_LOW;
}

/* Poll the status register. */
SLEWLINE_CALL unsigned char slewline_poll(void)
{
    unsigned char status;

    if (slewline_stays_low) {
        unsigned char look[2];

        look[0] = (unsigned char)slewline_status;
        look[1] = 0;
        slewline_send_series(look, 1, 0);
        if (slewline_read(&status, 1) != 1)
            slewline_lost("the server has closed the connection");
        slewline_high = status >> 7;
        if (!(status & 0x80) || slewline_under_way == 1) {
            if (status & 0x80)
                slewline_under_way = slewline_stays_low = 0;
            return status;
        }
        slewline_again(1, 1); /* after the poll that has now succeeded */
        if (slewline_stays_low)
            return 0x7F;
    }
    if (slewline_next == SLEWLINE_LOW) {
        slewline_go((unsigned)slewline_status, 0);
        slewline_high = 0;
        slewline_next = SLEWLINE_HIGH;
        return 0x7F;
    }
    if (slewline_next == SLEWLINE_HIGH) {
        slewline_go(SLEWLINE_POLL, SLEWLINE_MS);
        slewline_high = 1;
        slewline_next = SLEWLINE_ASK;
        return 0xFF;
    }
    slewline_go((unsigned)slewline_status, 0);
    status = slewline_collect();
    if (slewline_stays_low)
        slewline_under_way--; /* the program polls again */
    slewline_high = status >> 7;
    return status;
}

SLEWLINE_CALL unsigned char slewline_out(unsigned address, unsigned byte)
{
    if (!slewline_foreseeing())
        return slewline_ask(0x10 + (address & 15), byte & 0xFF);
    slewline_go(0x10 + (address & 15), byte & 0xFF);
    if ((int)(address & 15) == slewline_data || (int)(address & 15) == slewline_command)
        slewline_used(address, 1);
    else if ((int)(address & 15) == slewline_reset)
        slewline_forget();
    return (unsigned char)byte;
}

SLEWLINE_CALL unsigned char slewline_in(unsigned address)
{
    unsigned char byte;
    int tries;

    if (!slewline_foreseeing())
        return slewline_ask(address & 15, 0);
    if ((int)(address & 15) == slewline_status)
        return slewline_poll();
    slewline_go(address & 15, 0);
    byte = slewline_stays_low ? 0x7F : slewline_collect();
    for (tries = 1; slewline_stays_low; tries++)
        byte = slewline_again(0, tries < SLEWLINE_TRIES);
    if ((int)(address & 15) == slewline_data)
        slewline_used(address, 0);
    return byte;
}

SLEWLINE_CALL int slewline_ready(unsigned ms)
{
    unsigned char status;

    if (!slewline_foreseeing())
        return slewline_ask(SLEWLINE_READY, ms & 0xFF) >> 7;
    if (slewline_stays_low) {
        slewline_sent[1] = (unsigned char)ms;
        slewline_again(0, 1);
        if (slewline_stays_low)
            return 0;
    }
    slewline_go(SLEWLINE_READY, ms & 0xFF);
    status = slewline_collect();
    if (slewline_stays_low)
        slewline_under_way--;
    slewline_next = SLEWLINE_ASK;
    slewline_high = status >> 7;
    return slewline_high;
}

/* Words: the bus of a PC splits a word access in two, low byte first. */
SLEWLINE_CALL unsigned slewline_in_word(unsigned address)
{
    unsigned low = slewline_in(address);

    return low | (unsigned)slewline_in(address + 1) << 8;
}

SLEWLINE_CALL unsigned slewline_out_word(unsigned address, unsigned word)
{
    slewline_out(address, word);
    slewline_out(address + 1, word >> 8);
    return word;
}

/* Microsoft and Watcom */
#define inp(address) slewline_in(address)
#define outp(address, byte) slewline_out(address, byte)
#define inpw(address) slewline_in_word(address)
#define outpw(address, word) slewline_out_word(address, word)
#define _inp(address) slewline_in(address)
#define _outp(address, byte) slewline_out(address, byte)
#define _inpw(address) slewline_in_word(address)
#define _outpw(address, word) slewline_out_word(address, word)
/* Borland and DJGPP */
#define inportb(address) slewline_in(address)
#define outportb(address, byte) slewline_out(address, byte)
/* Linux: the byte is the first argument; no permission is needed */
#define inb(address) slewline_in(address)
#define outb(byte, address) slewline_out(address, byte)
#define ioperm(address, number, on) 0

#endif
