/* MurmurHash3_x86_32 (Appleby, public domain; github.com/aappleby/smhasher) with seed 0, as Cryptomatte uses
 * it. */
#pragma once

#include <stddef.h>
#include <stdint.h>

uint32_t murmur_hash(const char *bytes, size_t size);
