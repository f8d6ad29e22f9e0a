/* Turns points and lines, which have no size, into spheres and thin rods of triangles. */
#pragma once

#include "read/mesh/text.h"
#include "scene/scene.h"

/* Vertices and triangles of one line. */
enum { ROD_VERTICES = 10, ROD_TRIANGLES = 16 };

/* Maximum bytes of the arrays for each line, and for each point with an index, colours included. */
#define ROD_BYTES 592u
#define POINT_BYTES 28u

typedef struct strokes {
    const float *positions; /* finite; x y z */
    size_t position_stride;
    const float *colors; /* NULL: none */
    size_t color_stride;
    unsigned color_channels;
    const uint32_t *indices; /* vertex indices: one per point, two per line. NULL: 0, 1, 2…; then points use
                                the arrays above without a copy, so the scene must own them */
    uint32_t count;          /* of points or of lines */
    bool lines;
    note_list *notes; /* receives notes on lines of length 0 */
} strokes;

/* D is the diagonal of the bounds, without stray points (mesh_find_strays()). n points or lines that are
 * spread over a surface are about D / sqrt(n) apart. A point is a sphere of half that radius, clamped to [D /
 * 2000, D / 80]; a line is a rod of a 20th of it, clamped to [D / 1000, D / 300]. So few points and lines are
 * seen, and many do not merge. The radius is 1 if all points are equal. */
double strokes_radius(const scene_bounds *bounds, size_t count, bool lines);

/* Makes *mesh a cloud of the points, or a mesh of the lines, in memory of the scene. Lines of length 0 are
 * skipped. FATHOM_BAD_INPUT: the lines need more than 2^32 vertices, or a coordinate is out of float's
 * range. */
fathom_status strokes_make(fathom_scene *scene, const strokes *s, fathom_mesh *mesh);
/* As scene_add_mesh_checked(); a cloud gets the radius of its points, which its stray points do not change;
 * notes receives their number. FATHOM_BAD_INPUT: as strokes_make(). */
fathom_status strokes_add(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                          const mesh_facts *facts, note_list *notes);
/* False if *mesh is empty. */
static inline bool strokes_any(const fathom_mesh *mesh) {
    return mesh->triangle_count || mesh->point_radius > 0;
}
