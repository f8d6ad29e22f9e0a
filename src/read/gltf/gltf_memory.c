/* Memory for what a file describes: a few bytes of glTF can ask for any amount, by elements that are all
 * zero, or by one array that is used in many ways. */
#include "read/gltf/gltf.h"

/* What is stored in bytes takes at most 4 times that as floats, a strip of them 12 times, and their places as
 * instances some 20 times. */
#define FACTOR 128u
#define FREE 65536u

fathom_status gltf_charge(gltf *g, const gltf_value *at, const char *key, uint64_t bytes) {
    /* Sums of sizes that are in memory: no overflow, as `bytes` is below 2^40. */
    uint64_t most = FREE + FACTOR * g->file_bytes;
    g->charged += bytes;
    if (g->charged <= most) return FATHOM_OK;
    return gltf_fail(
        g, at, key,
        "brings what the file asks for to %llu bytes of memory; expected at most %u times the %llu "
        "bytes of its files",
        (unsigned long long)g->charged, FACTOR, (unsigned long long)g->file_bytes);
}

fathom_status gltf_allocate(gltf *g, const gltf_value *at, const char *key, uint64_t bytes, void **out) {
    fathom_status status = gltf_charge(g, at, key, bytes);
    return status == FATHOM_OK ? scene_allocate(g->scene, (size_t)bytes, out) : status;
}
