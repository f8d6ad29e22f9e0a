#include "read/mesh/strokes.h"

#include "math/frame.h"

#include <float.h>
#include <string.h>

/* A rod is a prism of four sides with a tip at either end; normals make it look round. */
enum { SIDES = 4 };
_Static_assert(ROD_VERTICES == 2 * SIDES + 2 && ROD_TRIANGLES == 4 * SIDES, "its parts");
_Static_assert(ROD_VERTICES *(3 + 3 + 4) * 4 + ROD_TRIANGLES * 12 <= ROD_BYTES, "its arrays");

/* The arrays, and how far they are filled. */
typedef struct pen {
    const strokes *s;
    float *positions, *normals, *colors;
    uint32_t *indices;
    uint32_t vertices, triangles;
    double radius;
} pen;

static uint32_t vertex_of(const strokes *s, size_t i) { return s->indices ? s->indices[i] : (uint32_t)i; }

static vec3_f64 position_of(const strokes *s, uint32_t vertex) {
    return widen(load_f32(mesh_row(s->positions, s->position_stride, vertex)));
}

static void copy_color(const strokes *s, uint32_t from, float *colors, size_t to) {
    if (s->colors)
        memcpy(colors + s->color_channels * to, (const char *)s->colors + s->color_stride * from,
               s->color_channels * sizeof(float));
}

static void put_vertex(pen *p, vec3_f64 at, vec3_f64 normal, uint32_t from) {
    store_f32(p->positions + 3 * (size_t)p->vertices, narrow(madd_f64(at, p->radius, normal)));
    store_f32(p->normals + 3 * (size_t)p->vertices, narrow(normal));
    copy_color(p->s, from, p->colors, p->vertices);
    ++p->vertices;
}

static void put_triangle(pen *p, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *to = p->indices + 3 * (size_t)p->triangles++;
    to[0] = a, to[1] = b, to[2] = c;
}

static void put_rod(pen *p, uint32_t from, uint32_t to) {
    static const double ring[SIDES][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
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

double strokes_radius(const scene_bounds *bounds, size_t count, bool lines) {
    const double diagonal = 2 * bounds_radius(bounds), distance = 1 / sqrt((double)count),
                 share = lines ? fmin(fmax(distance / 20, 1 / 1000.0), 1 / 300.0)
                               : fmin(fmax(distance / 2, 1 / 2000.0), 1 / 80.0);
    return diagonal > 0 ? diagonal * share : 1;
}

static fathom_status check_range(fathom_context *context, const scene_bounds *b, double radius,
                                 const char *what) {
    const double far = fmax(fmax(fmax(-b->lower.x, b->upper.x), fmax(-b->lower.y, b->upper.y)),
                            fmax(-b->lower.z, b->upper.z));
    if (far + radius <= (double)FLT_MAX) return FATHOM_OK;
    return fail(context, FATHOM_BAD_INPUT,
                "has %s as far out as %g: the spheres or rods that show them would leave the range of float",
                what, far);
}

/* Makes a point cloud in the order of the indices. Without indices, it shares the arrays. */
static fathom_status make_cloud(fathom_scene *scene, const strokes *s, fathom_mesh *mesh) {
    void *positions = NULL, *colors = NULL;
    mesh->positions = s->positions, mesh->position_stride = s->position_stride;
    mesh->colors = s->colors, mesh->color_stride = s->color_stride, mesh->color_channels = s->color_channels;
    mesh->vertex_count = s->count, mesh->point_radius = 1;
    if (!s->indices) return FATHOM_OK;
    fathom_status status = scene_allocate_items(scene, s->count, 3 * sizeof(float), &positions);
    if (status == FATHOM_OK && s->colors)
        status = scene_allocate_items(scene, s->count, s->color_channels * sizeof(float), &colors);
    for (size_t i = 0; i < s->count && status == FATHOM_OK; ++i) {
        store_f32((float *)positions + 3 * i, narrow(position_of(s, s->indices[i])));
        copy_color(s, s->indices[i], colors, i);
    }
    mesh->positions = positions, mesh->position_stride = 3 * sizeof(float);
    mesh->colors = colors, mesh->color_stride = s->color_channels * sizeof(float);
    return status;
}

static fathom_status make_rods(fathom_scene *scene, const strokes *s, fathom_mesh *mesh) {
    scene_bounds b = bounds_empty();
    for (size_t i = 0; i < 2 * (size_t)s->count; ++i) bounds_add(&b, position_of(s, vertex_of(s, i)));
    const uint64_t vertices = (uint64_t)s->count * ROD_VERTICES,
                   triangles = (uint64_t)s->count * ROD_TRIANGLES;
    pen p = {.s = s, .radius = strokes_radius(&b, s->count, true)};
    void *arrays[4] = {NULL};
    if (vertices >= UINT32_MAX || triangles > UINT32_MAX / 3)
        return fail(scene->context, FATHOM_BAD_INPUT, "has %u lines; more than can be shown", s->count);
    fathom_status status = check_range(scene->context, &b, p.radius, "lines");
    if (status == FATHOM_OK) status = scene_allocate_items(scene, vertices, 3 * sizeof(float), &arrays[0]);
    if (status == FATHOM_OK) status = scene_allocate_items(scene, vertices, 3 * sizeof(float), &arrays[1]);
    if (status == FATHOM_OK)
        status = scene_allocate_items(scene, triangles, 3 * sizeof(uint32_t), &arrays[2]);
    if (status == FATHOM_OK && s->colors)
        status = scene_allocate_items(scene, vertices, s->color_channels * sizeof(float), &arrays[3]);
    if (status != FATHOM_OK) return status;
    p.positions = arrays[0], p.normals = arrays[1], p.indices = arrays[2], p.colors = arrays[3];
    for (size_t i = 0; i < s->count; ++i) put_rod(&p, vertex_of(s, 2 * i), vertex_of(s, 2 * i + 1));
    notes_add(s->notes, s->count - p.vertices / ROD_VERTICES, "", "lines without length are left out");
    mesh->positions = p.positions, mesh->position_stride = 3 * sizeof(float), mesh->vertex_count = p.vertices;
    mesh->normals = p.normals, mesh->normal_stride = 3 * sizeof(float), mesh->normal_count = p.vertices;
    mesh->indices = p.indices, mesh->triangle_count = p.triangles;
    mesh->colors = p.colors, mesh->color_stride = s->color_channels * sizeof(float);
    return FATHOM_OK;
}

fathom_status strokes_make(fathom_scene *scene, const strokes *s, fathom_mesh *mesh) {
    if (!s->count) return FATHOM_OK;
    return s->lines ? make_rods(scene, s, mesh) : make_cloud(scene, s, mesh);
}

fathom_status strokes_add(fathom_scene *scene, fathom_id group, const fathom_mesh *mesh,
                          const mesh_facts *facts, note_list *notes) {
    fathom_status status = scene_add_mesh_checked(scene, group, mesh, facts, NULL);
    if (status != FATHOM_OK || !(mesh->point_radius > 0)) return status;
    const size_t last = scene->meshes.count - 1;
    const mesh_facts *own = &scene->mesh_facts.items[last];
    const scene_bounds all = {widen(load_f32(own->lower)), widen(load_f32(own->upper))},
                       core = {widen(load_f32(own->core_lower)), widen(load_f32(own->core_upper))};
    const double radius = strokes_radius(&core, mesh->vertex_count, false);
    notes_add(notes, own->strays, "",
              "stray points far from the others count neither for the size of the points nor for the "
              "automatic camera");
    scene->meshes.items[last].point_radius = fmaxf((float)radius, FLT_MIN);
    return check_range(scene->context, &all, radius, "points");
}
