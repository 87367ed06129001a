/* Sizes that only the compiler and the assembler must agree on; the sizes known to the host are in protocol.h. */
#ifndef SIZES_H
#define SIZES_H

#define TX_RING 64 /* bytes to be sent, a power of 2 */

#endif
