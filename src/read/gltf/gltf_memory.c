/* Limits on the memory that a file may take. */
#include "read/gltf/gltf.h"

/* A few bytes of glTF can allocate any amount of memory: by elements without data, or by one array that is
 * converted in many ways. Bytes take at most 4 times their size as floats, 12 times as a strip, about 20
 * times as instances.
 *
 * Poses have a limit of their own, because their size does not follow from that of the files: a small file
 * may have 400 nodes that each deform one mesh. 512 MiB hold 400 poses of 9,000 vertices with normals, at
 * five moments. */
#define FACTOR 128u
#define FREE 65536u
#ifndef FREE_POSES /* less where tests/fuzz limits memory by the size of the input */
#define FREE_POSES ((uint64_t)1 << 29)
#endif

fathom_status gltf_charge(gltf *g, const gltf_value *at, const char *key, uint64_t bytes) {
    /* These are sums of sizes in memory, so they do not overflow: `bytes` is below 2^40. */
    const uint64_t most = (g->posing ? FREE_POSES : FREE) + FACTOR * g->file_bytes,
                   charged = g->charged[g->posing] += bytes;
    if (charged <= most) return g->status;
    if (g->posing)
        return gltf_fail(
            g, at, key,
            "raises the poses of the file's nodes to %llu bytes of memory; expected at most 512 MiB plus %u "
            "times the %llu bytes of its files: shorten the shutter, or split the file",
            (unsigned long long)charged, FACTOR, (unsigned long long)g->file_bytes);
    return gltf_fail(g, at, key,
                     "raises what the file needs to %llu bytes of memory; expected at most %u times the %llu "
                     "bytes of its files",
                     (unsigned long long)charged, FACTOR, (unsigned long long)g->file_bytes);
}

fathom_status gltf_allocate(gltf *g, const gltf_value *at, const char *key, uint64_t bytes, void **out) {
    *out = NULL;
    if (gltf_charge(g, at, key, bytes) == FATHOM_OK) g->status = scene_allocate(g->scene, (size_t)bytes, out);
    return g->status;
}
