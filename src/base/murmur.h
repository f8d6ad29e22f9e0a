/* MurmurHash3_x86_32 (Appleby, public domain; github.com/aappleby/smhasher), of seed 0: Cryptomatte's hash.
 */
#ifndef BASE_MURMUR_H
#define BASE_MURMUR_H

#include <stddef.h>
#include <stdint.h>

uint32_t murmur_hash(const char *bytes, size_t size);

#endif
