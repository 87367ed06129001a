/* Sizes that the compiler and the assembler must agree on. */
#ifndef SIZES_H
#define SIZES_H

#define SLOTS 64   /* records in the queue */
#define RECORD 13  /* bytes of one */
#define RING 128   /* bytes received, a power of 2 */
#define TX_RING 64 /* bytes to be sent, a power of 2 */
#define ENTRY 6    /* bytes of an entry of the way down */
#define FAST 640   /* ticks between steps: with less there is no time to brake at the next one */

#endif
