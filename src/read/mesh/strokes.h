/* Points and lines, which have no size, as small balls and thin rods of triangles. */
#ifndef READ_STROKES_H
#define READ_STROKES_H

#include "read/mesh/text.h"
#include "scene/scene.h"

/* Bytes of the arrays for each point or line at most, with colours. */
#define STROKES_BYTES 1024u

typedef struct strokes {
    const float *positions; /* finite; x y z */
    size_t position_stride;
    const float *colors; /* NULL: none */
    size_t color_stride;
    unsigned color_channels;
    const uint32_t *indices; /* of vertices: one a point, two a line; NULL: 0, 1, 2… */
    uint32_t count;          /* of points or of lines */
    bool lines;
    note_list *notes; /* is told of lines without length */
} strokes;

/* Sets positions, normals, colours and indices of *mesh, in memory of the scene. With D the diagonal of the
 * bounds of the points in use, a line is a rod of radius D / 1000, and one of n points a ball of radius D /
 * (2 sqrt(n)), which is about half the distance of points that are spread over a surface, but at least D /
 * 2000 and at most D / 200; 1 where all points are one. A line without length is left out: *mesh may have no
 * triangles. FATHOM_BAD_INPUT: more than 2^32 vertices, or some
 * that leave the range of float. */
fathom_status strokes_make(fathom_scene *scene, const strokes *s, fathom_mesh *mesh);

#endif
