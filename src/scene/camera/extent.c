/* A run of vertices is read only if its box exceeds the maximum found so far. This never changes the result:
 * rounding is monotonic, so the same operations in the same order give for the outermost corner of the box at
 * least the value of any vertex inside. The bound needs no tolerance. */
#include "scene/camera/extent.h"

#include "base/threads.h"
#include "scene/kernels.h"

#include <math.h>
#include <stdlib.h>

/* Vertices in a run. Shorter runs have tighter boxes, but then each pass compares more boxes. */
#define RUN 128
/* Runs that a thread takes at a time, about 0.1 ms of work if all their vertices are read. */
#define PIECE 256

static size_t run_end(const fathom_mesh *mesh, size_t run) {
    const size_t begin = run * RUN;
    return mesh->vertex_count - begin > RUN ? begin + RUN : mesh->vertex_count;
}

/* ---- boxes ---- */

typedef struct box_loop {
    const scene_kernels *kernels;
    const fathom_mesh *mesh;
    extent_box *boxes;
} box_loop;

/* A run that contains a number that is not finite gets an infinite box, so it is always read. */
static void make_boxes(void *user, size_t begin, size_t end) {
    const box_loop *loop = user;
    const extent_box empty = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}},
                     endless = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    for (size_t run = begin; run < end; ++run) {
        const size_t count = run_end(loop->mesh, run) - run * RUN;
        extent_box box = empty;
        const bool finite = loop->kernels->vectors(mesh_vertex(loop->mesh, run * RUN),
                                                   loop->mesh->position_stride, count, box.lower, box.upper);
        loop->boxes[run] = finite ? box : endless;
    }
}

bool extent_make_boxes(unsigned threads, const fathom_mesh *mesh, extent_boxes *out) {
    const size_t count = ((size_t)mesh->vertex_count + RUN - 1) / RUN;
    extent_box *boxes = malloc(count * sizeof *boxes);
    if (!boxes) return false;
    box_loop loop = {scene_kernels_best(), mesh, boxes};
    loop_parallel(threads, count, PIECE, make_boxes, &loop);
    *out = (extent_boxes){boxes, count};
    return true;
}

/* ---- reach ---- */

static double larger(double a, double b) { return a > b ? a : b; }

/* The extent of the outermost corner along side i. It may be NaN. */
static double reach_of_box(const extent_sides *s, int i, const extent_box *box) {
    const double x = larger(s->x[i] * (double)box->lower[0], s->x[i] * (double)box->upper[0]);
    const double y = larger(s->y[i] * (double)box->lower[1], s->y[i] * (double)box->upper[1]);
    const double z = larger(s->z[i] * (double)box->lower[2], s->z[i] * (double)box->upper[2]);
    return x + y + z + s->origin[i] + s->offset[i];
}

bool extent_box_beyond(const extent_sides *sides, const extent_box *box, const double most[EXTENT_SIDES]) {
    bool beyond = false;
    for (int i = 0; i < EXTENT_SIDES; ++i) beyond |= !(reach_of_box(sides, i, box) <= most[i]);
    return beyond;
}

/* The loop over the sides is the inner one, so that the compiler vectorises it. */
static void look_at_run(const extent_sides *s, const fathom_mesh *mesh, size_t run,
                        double out[EXTENT_SIDES]) {
    double most[EXTENT_SIDES];
    for (int i = 0; i < EXTENT_SIDES; ++i) most[i] = out[i];
    for (size_t k = run * RUN, end = run_end(mesh, run); k < end; ++k) {
        const float *p = mesh_vertex(mesh, k);
        const double px = (double)p[0], py = (double)p[1], pz = (double)p[2];
        for (int i = 0; i < EXTENT_SIDES; ++i) {
            const double reach = s->x[i] * px + s->y[i] * py + s->z[i] * pz + s->origin[i] + s->offset[i];
            most[i] = larger(reach, most[i]);
        }
    }
    for (int i = 0; i < EXTENT_SIDES; ++i) out[i] = most[i];
}

/* For each side, the run whose box extends farthest is read first: few other boxes exceed its vertices. */
void extent_of_mesh(const extent_sides *sides, const fathom_mesh *mesh, const extent_boxes *boxes,
                    double most[EXTENT_SIDES]) {
    double farthest[EXTENT_SIDES];
    size_t first[EXTENT_SIDES] = {0};
    for (int i = 0; i < EXTENT_SIDES; ++i) farthest[i] = -INFINITY;
    for (size_t run = 0; run < boxes->count; ++run) {
        for (int i = 0; i < EXTENT_SIDES; ++i) {
            const double reach = reach_of_box(sides, i, &boxes->items[run]);
            if (reach > farthest[i]) farthest[i] = reach, first[i] = run;
        }
    }
    for (int i = 0; i < EXTENT_SIDES; ++i) look_at_run(sides, mesh, first[i], most);
    for (size_t run = 0; run < boxes->count; ++run) {
        if (extent_box_beyond(sides, &boxes->items[run], most)) look_at_run(sides, mesh, run, most);
    }
}
