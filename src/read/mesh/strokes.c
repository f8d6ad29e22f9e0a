#include "read/mesh/strokes.h"

#include "math/frame.h"

#include <float.h>
#include <string.h>

/* A ball is an icosahedron, and a rod a prism of six sides with a tip at either end; normals make both look
 * round. */
enum {
    BALL_VERTICES = 12,
    BALL_TRIANGLES = 20,
    SIDES = 6,
    ROD_VERTICES = 2 * SIDES + 2,
    ROD_TRIANGLES = 4 * SIDES
};
_Static_assert(ROD_VERTICES *(3 + 3 + 4) * 4 + ROD_TRIANGLES * 12 <= STROKES_BYTES, "the larger of the two");

#define A 0.525731112119133606f
#define B 0.850650808352039932f
static const float ball[BALL_VERTICES][3] = {{-A, B, 0}, {A, B, 0}, {-A, -B, 0}, {A, -B, 0},
                                             {0, -A, B}, {0, A, B}, {0, -A, -B}, {0, A, -B},
                                             {B, 0, -A}, {B, 0, A}, {-B, 0, -A}, {-B, 0, A}};
static const uint8_t ball_corners[BALL_TRIANGLES][3] = {
    {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};

/* Where the arrays are filled up to. */
typedef struct pen {
    const strokes *s;
    float *positions, *normals, *colors;
    uint32_t *indices;
    uint32_t vertices, triangles;
    double radius;
} pen;

static uint32_t vertex_of(const strokes *s, size_t i) { return s->indices ? s->indices[i] : (uint32_t)i; }

static vec3_f64 position_of(const strokes *s, uint32_t vertex) {
    return widen(
        load_f32((const float *)(const void *)((const char *)s->positions + s->position_stride * vertex)));
}

static void put_vertex(pen *p, vec3_f64 at, vec3_f64 normal, uint32_t from) {
    const strokes *s = p->s;
    store_f32(p->positions + 3 * (size_t)p->vertices, narrow(madd_f64(at, p->radius, normal)));
    store_f32(p->normals + 3 * (size_t)p->vertices, narrow(normal));
    if (s->colors)
        memcpy(p->colors + s->color_channels * (size_t)p->vertices,
               (const char *)s->colors + s->color_stride * from, s->color_channels * sizeof(float));
    ++p->vertices;
}

static void put_triangle(pen *p, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *to = p->indices + 3 * (size_t)p->triangles++;
    to[0] = a, to[1] = b, to[2] = c;
}

static void put_ball(pen *p, uint32_t vertex) {
    const uint32_t first = p->vertices;
    for (int i = 0; i < BALL_VERTICES; ++i)
        put_vertex(p, position_of(p->s, vertex), widen(load_f32(ball[i])), vertex);
    for (int i = 0; i < BALL_TRIANGLES; ++i)
        put_triangle(p, first + ball_corners[i][0], first + ball_corners[i][1], first + ball_corners[i][2]);
}

static void put_rod(pen *p, uint32_t from, uint32_t to) {
    static const double ring[SIDES][2] = {{1, 0},  {.5, .866025403784438647},   {-.5, .866025403784438647},
                                          {-1, 0}, {-.5, -.866025403784438647}, {.5, -.866025403784438647}};
    const uint32_t ends[2] = {from, to}, first = p->vertices;
    const vec3_f64 along = normalize_f64(sub_f64(position_of(p->s, to), position_of(p->s, from)));
    if (!(dot_f64(along, along) > 0)) return;
    const frame_f64 f = frame_from((vec3_f64){0, 0, 0}, along, (vec3_f64){0, 1, 0});
    for (int e = 0; e < 2; ++e) {
        const vec3_f64 at = position_of(p->s, ends[e]);
        for (int i = 0; i < SIDES; ++i)
            put_vertex(p, at, add_f64(scale_f64(ring[i][0], f.x), scale_f64(ring[i][1], f.y)), ends[e]);
        put_vertex(p, at, e ? along : neg_f64(along), ends[e]);
    }
    for (uint32_t i = 0, n = SIDES + 1; i < SIDES; ++i) {
        const uint32_t a = first + i, b = first + (i + 1) % SIDES;
        put_triangle(p, a, b, b + n);
        put_triangle(p, a, b + n, a + n);
        put_triangle(p, b, a, first + SIDES);
        put_triangle(p, a + n, b + n, first + n + SIDES);
    }
}

/* *reach: the largest coordinate of what is made. */
static double radius_for(const strokes *s, double *reach) {
    scene_bounds bounds = bounds_empty();
    const size_t corners = (size_t)s->count * (s->lines ? 2 : 1);
    for (size_t i = 0; i < corners; ++i) bounds_add(&bounds, position_of(s, vertex_of(s, i)));
    const double diagonal = 2 * bounds_radius(&bounds),
                 share = s->lines ? 1e-3 : fmin(fmax(0.5 / sqrt(s->count), 1 / 2000.0), 1 / 200.0),
                 radius = diagonal > 0 ? diagonal * share : 1;
    *reach =
        radius + fmax(fmax(-bounds.lower.x, bounds.upper.x),
                      fmax(fmax(-bounds.lower.y, bounds.upper.y), fmax(-bounds.lower.z, bounds.upper.z)));
    return radius;
}

fathom_status strokes_make(fathom_scene *scene, const strokes *s, fathom_mesh *mesh) {
    const uint64_t vertices = (uint64_t)s->count * (s->lines ? ROD_VERTICES : BALL_VERTICES),
                   triangles = (uint64_t)s->count * (s->lines ? ROD_TRIANGLES : BALL_TRIANGLES);
    double reach;
    pen p = {.s = s, .radius = radius_for(s, &reach)};
    void *arrays[4] = {NULL};
    if (vertices >= UINT32_MAX || triangles > UINT32_MAX / 3)
        return fail(scene->context, FATHOM_BAD_INPUT, "has %u %s; more than can be shown", s->count,
                    s->lines ? "lines" : "points");
    if (s->count && !(reach <= (double)FLT_MAX))
        return fail(scene->context, FATHOM_BAD_INPUT,
                    "has %s as far out as %g: what is to show them would leave the range of float",
                    s->lines ? "lines" : "points", reach - p.radius);
    fathom_status status = scene_allocate_items(scene, vertices, 3 * sizeof(float), &arrays[0]);
    if (status == FATHOM_OK) status = scene_allocate_items(scene, vertices, 3 * sizeof(float), &arrays[1]);
    if (status == FATHOM_OK)
        status = scene_allocate_items(scene, triangles, 3 * sizeof(uint32_t), &arrays[2]);
    if (status == FATHOM_OK && s->colors)
        status = scene_allocate_items(scene, vertices, s->color_channels * sizeof(float), &arrays[3]);
    if (status != FATHOM_OK) return status;
    p.positions = arrays[0], p.normals = arrays[1], p.indices = arrays[2], p.colors = arrays[3];
    for (size_t i = 0; i < s->count; ++i) {
        if (s->lines)
            put_rod(&p, vertex_of(s, 2 * i), vertex_of(s, 2 * i + 1));
        else
            put_ball(&p, vertex_of(s, i));
    }
    if (s->lines)
        notes_add(s->notes, s->count - p.vertices / ROD_VERTICES, "", "lines without length are left out");
    mesh->positions = p.positions, mesh->position_stride = 3 * sizeof(float), mesh->vertex_count = p.vertices;
    mesh->normals = p.normals, mesh->normal_stride = 3 * sizeof(float), mesh->normal_count = p.vertices;
    mesh->indices = p.indices, mesh->triangle_count = p.triangles;
    mesh->colors = p.colors, mesh->color_stride = s->color_channels * sizeof(float);
    return FATHOM_OK;
}
