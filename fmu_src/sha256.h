/* SHA-256 (FIPS 180-4), of bytes given piece by piece. */
#ifndef MBDFMI_SHA256_H
#define MBDFMI_SHA256_H

#include <stddef.h>
#include <stdint.h>

#include "layout.h" /* names of a source FMU are its own */

#define SHA256_SIZE 32

typedef struct {
    uint32_t h[8];
    uint64_t length; /* bytes so far */
    unsigned char block[64];
} Sha256;

void sha256_start(Sha256 *s);
void sha256_add(Sha256 *s, const void *data, size_t size);
void sha256_end(Sha256 *s, unsigned char digest[SHA256_SIZE]);

#endif
