/* Triangulates polygons. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Vertices of a mesh; the stride is in bytes. */
typedef struct polygon_vertices {
    const float *positions;
    size_t stride;
} polygon_vertices;

/* Memory reused between polygons, one for each thread. Zero it; release it with polygon_work_free(). */
typedef struct polygon_work {
    void *memory;
    size_t size;
} polygon_work;

/* A polygon that was written as a fan. */
typedef struct polygon_fan {
    size_t first; /* index of its first triangle */
    uint32_t corners;
} polygon_fan;

void polygon_work_free(polygon_work *work);

/* Readers write a polygon of n corners as the fan (0,1,2) (0,2,3)… before they know the vertices. This call
 * replaces the fan, n - 2 triangles of vertex indices at `fan`, by a good triangulation with the same
 * winding: quads along the better diagonal, concave polygons by ear clipping. The corners of the other
 * streams (indices of normals and uvs, or NULL) are reordered in the same way. A polygon that is not simple
 * also becomes n - 2 triangles, whose shape is not specified. So does one with a lost vertex (lost.h), and
 * each of its corners is that vertex. False: out of memory, nothing is changed. */
bool polygon_split(polygon_work *work, const polygon_vertices *vertices, uint32_t corners, uint32_t *fan,
                   uint32_t *second, uint32_t *third);
