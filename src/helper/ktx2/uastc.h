/* UASTC LDR 4x4, the subset of ASTC that Basis Universal stores: blocks of 16 bytes. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#define UASTC_BLOCK 16 /* bytes */

/* Decodes a block to 16 texels of R, G, B, A, row by row. False if it has no valid mode or pattern. */
bool uastc_decode(const uint8_t block[UASTC_BLOCK], uint8_t texels[16][4]);
