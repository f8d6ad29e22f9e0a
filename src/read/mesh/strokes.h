/* Points and lines, which have no size, as spheres and thin rods of triangles. */
#ifndef READ_STROKES_H
#define READ_STROKES_H

#include "read/mesh/text.h"
#include "scene/scene.h"

/* One line has so many. */
enum { ROD_VERTICES = 10, ROD_TRIANGLES = 16 };

/* Bytes of the arrays for each line, and for each point with an index, at most; with colours. */
#define ROD_BYTES 592u
#define POINT_BYTES 28u

typedef struct strokes {
    const float *positions; /* finite; x y z */
    size_t position_stride;
    const float *colors; /* NULL: none */
    size_t color_stride;
    unsigned color_channels;
    const uint32_t *indices; /* of vertices: one a point, two a line; NULL: 0, 1, 2…, and points share the
                                arrays, which are the scene's then */
    uint32_t count;          /* of points or of lines */
    bool lines;
    note_list *notes; /* is told of lines without length */
} strokes;

/* With D the diagonal of the bounds, a line is a rod of radius D / 1000, and one of n points a sphere of
 * radius D / (2 sqrt(n)), which is about half the distance of points that are spread over a surface, but at
 * least D / 2000 and at most D / 200; 1 where all points are one. */
double strokes_radius(const scene_bounds *bounds, size_t count, bool lines);

/* Makes *mesh a cloud of the points, or a mesh of the lines, in memory of the scene. A line without length is
 * left out. FATHOM_BAD_INPUT: more lines than 2^32 vertices can show, or something that leaves the range of
 * float. */
fathom_status strokes_make(fathom_scene *scene, const strokes *s, fathom_mesh *mesh);
/* False where nothing is left of *mesh. */
static inline bool strokes_any(const fathom_mesh *mesh) {
    return mesh->triangle_count || mesh->point_radius > 0;
}

#endif
