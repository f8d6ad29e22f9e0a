/* Decodes what KHR_meshopt_compression adds to EXT_meshopt_compression, which meshoptimizer 0.22 and older do
 * not have: version 1 of the attribute codec, and the filter COLOR. Written from the extension's
 * specification, appendices A and B.
 *
 * Both functions return NULL, or what is wrong with the data as the end of a sentence. */
#pragma once

#include <stddef.h>

/* The first byte of a stream of version 0 and of version 1. */
enum { GLTF_ATTRIBUTES_0 = 0xa0, GLTF_ATTRIBUTES_1 = 0xa1 };

/* Decodes a stream of version 1 into `count` elements of `stride` bytes at `to`. stride: a multiple of 4, 4
 * to 256. Reads no byte outside of the stream; after an error, `to` has any values. */
const char *gltf_attributes_decode(const unsigned char *bytes, size_t size, size_t count, size_t stride,
                                   unsigned char *to);

/* Converts `count` elements of `stride` bytes in place from YCoCg and alpha to red, green, blue and alpha.
 * stride: 4 for components of 8 bits, 8 for 16 bits. */
const char *gltf_colors_decode(unsigned char *elements, size_t count, size_t stride);
