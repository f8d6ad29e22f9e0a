/* A placed mesh loses this in formats without instances. Only scene JSON holds the radius of points: readers
 * of other formats choose one by the number of points and the size of their bounds. */
#include "read/mesh/strokes.h"
#include "write/write.h"

#include <stdlib.h>

typedef struct cloud {
    scene_bounds bounds;
    size_t points;
} cloud;

typedef struct radius_search {
    const fathom_scene *scene;
    cloud *clouds; /* as a reader would group the points */
    write_clouds how;
    size_t off;
} radius_search;

static cloud *cloud_of(const radius_search *s, const write_placement *at) {
    return &s->clouds[s->how == WRITE_CLOUDS_BY_MATERIAL ? at->material : 0];
}

/* Strays are those of one mesh here: readers look at all points of a cloud. */
static bool is_stray(const mesh_facts *facts, const float *p) {
    bool out = false;
    for (int k = 0; k < 3; ++k) out |= p[k] < facts->core_lower[k] || p[k] > facts->core_upper[k];
    return out;
}

static fathom_status add_points(void *user, const write_placement *at) {
    radius_search *s = user;
    const fathom_mesh *m = at->mesh;
    if (!(m->point_radius > 0)) return FATHOM_OK;
    cloud *c = cloud_of(s, at);
    c->points += m->vertex_count;
    for (size_t i = 0; i < m->vertex_count; ++i) {
        if (is_stray(&s->scene->mesh_facts.items[at->mesh_index], mesh_vertex(m, i))) continue;
        bounds_add(&c->bounds,
                   widen(write_placed_position(at, write_item(m->positions, m->position_stride, i))));
    }
    return FATHOM_OK;
}

/* Equal up to a few rounding errors of float. */
static bool same(double a, double b) { return fabs(a - b) <= 1e-5 * b; }

/* True if the map makes everything larger by this factor. */
static bool scales_by(const affine_f64 *map, double scale) {
    const double(*m)[4] = map->m;
    const vec3_f64 x = {m[0][0], m[1][0], m[2][0]}, y = {m[0][1], m[1][1], m[2][1]},
                   z = {m[0][2], m[1][2], m[2][2]};
    return same(length_f64(x), scale) && same(length_f64(y), scale) && same(length_f64(z), scale) &&
           same(fabs(dot_f64(cross_f64(x, y), z)), scale * scale * scale);
}

/* A transform with a non-uniform scale also counts as a different radius: only the points' positions can be
 * written. */
static fathom_status check_radius(void *user, const write_placement *at) {
    radius_search *s = user;
    const double radius = (double)at->mesh->point_radius;
    if (!(radius > 0)) return FATHOM_OK;
    const cloud *c = cloud_of(s, at);
    s->off += !scales_by(&at->map, strokes_radius(&c->bounds, c->points, false) / radius);
    return FATHOM_OK;
}

static fathom_status check_stretch(void *user, const write_placement *at) {
    size_t *count = user;
    const double(*m)[4] = at->map.m;
    *count += at->mesh->normals && !scales_by(&at->map, length_f64(vec_f64(m[0][0], m[1][0], m[2][0])));
    return FATHOM_OK;
}

fathom_status write_count_stretched(const fathom_scene *scene, const scene_graph *graph, size_t *out) {
    *out = 0;
    return write_each_placement(scene, graph, check_stretch, out);
}

static size_t count_each(const fathom_scene *scene) {
    size_t off = 0;
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *m = &scene->meshes.items[i];
        const mesh_facts *facts = &scene->mesh_facts.items[i];
        const scene_bounds box = {widen(load_f32(facts->core_lower)), widen(load_f32(facts->core_upper))};
        off += m->point_radius > 0 &&
               !same(strokes_radius(&box, m->vertex_count, false), (double)m->point_radius);
    }
    return off;
}

fathom_status write_count_radii(const fathom_scene *scene, const scene_graph *graph, write_clouds how,
                                size_t *out) {
    const size_t count = how == WRITE_CLOUDS_BY_MATERIAL ? scene->materials.count : 1;
    *out = 0;
    if (how == WRITE_CLOUDS_EACH) {
        *out = count_each(scene);
        return FATHOM_OK;
    }
    radius_search s = {.scene = scene, .clouds = malloc(count * sizeof *s.clouds), .how = how};
    if (!s.clouds) return fail_memory(scene->context, count * sizeof *s.clouds);
    for (size_t i = 0; i < count; ++i) s.clouds[i] = (cloud){bounds_empty(), 0};
    fathom_status status = write_each_placement(scene, graph, add_points, &s);
    if (status == FATHOM_OK) status = write_each_placement(scene, graph, check_radius, &s);
    free(s.clouds);
    *out = s.off;
    return status;
}
