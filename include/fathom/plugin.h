/* Your own tracer: what a shared library must export so that Fathom can render with it, validate it and
 * measure it: `--tracer ./mine.so`.
 *
 * The library defines
 *
 *     const fathom_plugin *fathom_plugin_get(void);
 *
 * which returns a table that stays valid as long as the library is loaded. It links no library of Fathom:
 * this header is all it needs. Plain C99, and C++17.
 *
 * Fathom passes only triangles to it, and refuses a scene with spheres, quads or instances. Fathom
 * intersects planes itself. These calls must not throw exceptions or end the process. */
#ifndef FATHOM_PLUGIN_H
#define FATHOM_PLUGIN_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Grows when this header changes so that older libraries no longer fit. */
#define FATHOM_PLUGIN_VERSION 1u

#define FATHOM_PLUGIN_WIDTH 16
#define FATHOM_PLUGIN_MISS UINT32_MAX

/* Triangle i has the vertices indices[3 i], [3 i + 1], [3 i + 2]; vertex k has x, y, z at positions[3 k].
 * Valid until destroy(). Vertices may be NaN or infinite and triangles may have no area: such triangles are
 * never hit. At least 16 bytes past the last vertex can be read. */
typedef struct fathom_plugin_mesh {
    const float *positions;
    const uint32_t *indices;
    uint32_t vertex_count;
    uint32_t triangle_count; /* may be 0 */
} fathom_plugin_mesh;

/* 16 rays as a structure of arrays, and their answers. A hit has t in the open interval (t_near, t_far), in
 * units of the direction's length, which need not be 1. Both sides of a triangle are hit. */
typedef struct fathom_plugin_block {
    float org_x[16], org_y[16], org_z[16], t_near[16];
    float dir_x[16], dir_y[16], dir_z[16], t_far[16];
    uint32_t active; /* bit i: lane i is to be answered; the numbers of others may be anything */

    uint32_t primitive[16]; /* out: the triangle, or FATHOM_PLUGIN_MISS */
    double t[16];           /* out: of a hit; a tracer in float stores its floats */
    double u[16], v[16];    /* out: the hit's weights of the second and third vertex */
} fathom_plugin_block;

typedef struct fathom_plugin {
    uint32_t version; /* FATHOM_PLUGIN_VERSION */
    const char *name; /* for reports; at most 63 bytes are shown */
    double unit;      /* unit roundoff of the arithmetic behind t: 2^-24 for float, 2^-53 for double */

    /* Builds the tracer's structures on `threads` threads, and stores them in *out. Returns 0; on failure,
     * writes the reason into message and returns another number. */
    int (*build)(const fathom_plugin_mesh *mesh, unsigned threads, char *message, size_t message_size,
                 void **out);
    /* The closest hits of all active lanes. Any number of threads call at the same time. Denormals are
     * flushed to zero in those threads. */
    void (*closest)(const void *tracer, fathom_plugin_block *blocks, size_t count);
    /* Asks whether anything is hit: `primitive` is any triangle that is, or FATHOM_PLUGIN_MISS; t, u and v
     * are not looked at. */
    void (*any)(const void *tracer, fathom_plugin_block *blocks, size_t count);
    /* Releases what build() stored. */
    void (*destroy)(void *tracer);
} fathom_plugin;

typedef const fathom_plugin *(*fathom_plugin_get_fn)(void);

#if defined(__GNUC__)
#define FATHOM_PLUGIN_EXPORT __attribute__((visibility("default")))
#else
#define FATHOM_PLUGIN_EXPORT
#endif

/* Defined by the library. */
FATHOM_PLUGIN_EXPORT const fathom_plugin *fathom_plugin_get(void);

#ifdef __cplusplus
}
#endif
#endif
