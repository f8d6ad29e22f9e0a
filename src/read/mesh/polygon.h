/* Polygons into triangles. */
#ifndef READ_POLYGON_H
#define READ_POLYGON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Vertices as a mesh has them: the stride is in bytes. */
typedef struct polygon_vertices {
    const float *positions;
    size_t stride;
} polygon_vertices;

/* Memory that is used again from polygon to polygon: zero it, and release it with polygon_work_free(). One
 * for each thread. */
typedef struct polygon_work {
    void *memory;
    size_t size;
} polygon_work;

void polygon_work_free(polygon_work *work);

/* Readers write a polygon of n corners as the fan (0,1,2) (0,2,3)… of its first corner before they know where
 * the vertices are. This turns that fan, n - 2 triangles starting at `fan` (vertex indices), into a good
 * triangulation of the same polygon, with the same winding: quads along the better diagonal, concave polygons
 * by cutting ears. Every corner of every other stream (indices of normals, of uvs; NULL for none) is moved
 * along. Polygons that are not simple come out as some n - 2 triangles. False: out of memory, nothing is
 * changed. */
bool polygon_split(polygon_work *work, const polygon_vertices *vertices, uint32_t corners, uint32_t *fan,
                   uint32_t *second, uint32_t *third);

#endif
