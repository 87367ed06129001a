/*
 * Port I/O of a host program, with a chipset that slewline serves:
 *
 *     slewline serve mc1451a --tcp 127.0.0.1:4001
 *
 * Include this file behind all others.  outp(0x342, byte) and inp(0x344), under whatever name the compiler has for
 * them, then go to the chipset; of an address the lowest four bits count.  Either call
 *
 *     slewline_open("127.0.0.1", 4001)        returns 0, or -1 and says why on stderr
 *
 * first, or leave the program as it is, and say in its environment where the chipset is: SLEWLINE=127.0.0.1:4001
 *
 *     slewline_out(address, byte)             OUT; the byte is written when the call returns
 *     slewline_in(address)                    IN
 *     slewline_ready(ms)                      wait until HostRdy is high, for 0..255 ms of the chipset's time; is it?
 *     slewline_close()
 *
 * When the server goes away in between, the program ends: it says so, and exits with status 1.
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
#define SLEWLINE_SEND MSG_NOSIGNAL /* a server that has gone is told, and no signal */
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

/* End the program: there is no answer that a port could give any more. */
SLEWLINE_CALL void slewline_lost(const char *why)
{
    fprintf(stderr, "slewline_port: %s\n", why);
    exit(1);
}

/* Read so many bytes; returns how many there were before the other side hung up. */
SLEWLINE_CALL int slewline_read(unsigned char *bytes, int number)
{
    int got, have = 0;

    while (have < number && (got = (int)recv(slewline_connection, (char *)bytes + have, number - have, 0)) > 0)
        have += got;
    return have;
}

SLEWLINE_CALL void slewline_close(void)
{
    if (slewline_is_open)
        slewline_hang_up(slewline_connection);
    slewline_is_open = 0;
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

SLEWLINE_CALL int slewline_open(const char *host, int port)
{
    static const char greeting[] = "slewline registers 1 ";
    char line[200];
    int at = 0;

    slewline_close();
    if (slewline_connect(host, port) != 0) {
        fprintf(stderr, "slewline_port: nobody is at %s:%d\n", host, port);
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
    return 0;
}

/* Open what the environment names. */
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

    if (!slewline_is_open)
        slewline_open_named();
    bytes[0] = (unsigned char)request;
    bytes[1] = (unsigned char)value;
    if (send(slewline_connection, (char *)bytes, 2, SLEWLINE_SEND) != 2 || slewline_read(bytes, 1) != 1)
        slewline_lost("the server has hung up");
    return bytes[0];
}

SLEWLINE_CALL unsigned char slewline_out(unsigned address, unsigned byte)
{
    return slewline_ask(0x10 + (address & 15), byte & 0xFF);
}

SLEWLINE_CALL unsigned char slewline_in(unsigned address)
{
    return slewline_ask(address & 15, 0);
}

SLEWLINE_CALL int slewline_ready(unsigned ms)
{
    return slewline_ask(0x24, ms & 0xFF) >> 7;
}

/* Words: the bus of a PC makes two accesses of one, the low byte first. */
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
/* Linux: the byte comes first, and no permission is needed */
#define inb(address) slewline_in(address)
#define outb(byte, address) slewline_out(address, byte)
#define ioperm(address, number, on) 0

#endif
