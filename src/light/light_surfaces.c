/* With u = 2^-24, n the unit normal of a surface, S the light and D the length of a shadow ray, these errors
 * can move the ray's end to the other side of the surface. They are distances along n:
 * - S was rounded to float: Σ |n_i| u |S_i|. The surface's data was rounded, too: Σ |n_i| u |c_i| for the
 * farthest corner c, the same and u R for a sphere, 4 u Σ |n_i| |S_i| for a plane, whose normal was rounded.
 * In an instance, tracers transform rays to object space (surface/gather.c); the entries of the matrix were
 * also rounded, which adds two of the six roundings there once more. If a light is within the sum of these
 * errors, the surface holds it.
 * - The tracer's own error near the surface: LOCAL_FACE_SELF_HIT times the extent for faces, 8 u R for
 * spheres, 8 u Σ |n_i| (|S_i| + |c_i|) for planes, which are subtracted whole.
 * - The ray: direction, length and product contribute 6 u D; t = n·v / n·d, v from the start to a corner,
 * contributes 4 u |v| in the numerator and 4 u D in the denominator, and edges that are differences of two
 * such v rotate n by up to 4 u |v| / extent, which moves the plane by up to 4 u |v| within the face. |v| <= D
 * + extent, and the extent is covered by the second item. These 18 u D are rounded up to 32 u D. In an
 * instance, the start and the direction are transformed to object space with 8 roundings of Σ_j |A_ij| D on
 * axis i.
 *
 * The first two items make `clear`, the third `slope`. An occluder therefore hides the light if it crosses
 * the ray at more than twice the sum, about 2^-18 of the distance and of the coordinates, away from the
 * surface that holds the light. */
#include "light/light.h"

#include "surface/gather.h"
#include "surface/placed.h"
#include "trace/search.h"

#include <float.h>
#include <stdlib.h>

static const double unit_round = 0x1p-24;

/* A light, in the space in which surfaces are searched. */
typedef struct probe {
    vec3_f64 at;
    uint32_t light;
} probe;

typedef struct found {
    uint32_t light;
    light_surface surface;
} found;

typedef struct finder {
    const world *w;
    const shade_light *lights;
    uint32_t count;
    double *farthest;     /* by light: the length of the longest shadow ray */
    double loose;         /* no surface farther than this from a light affects it; in world space */
    scene_bounds *bounds; /* by group, in its own space */
    probe *all, *local;   /* sorted along x; in world space, and in the space of the current instance */
    bool *in_mesh;
    ARRAY(found) list;
    bool out_of_memory;
} finder;

/* The space and the lights for which surfaces are tested. */
typedef struct view {
    finder *f;
    const world_instance *instance; /* NULL: world space */
    const probe *probes;            /* sorted along x */
    size_t count;
    double loose; /* in this space */
    bool mesh;
} view;

static double larger(double a, double b) { return a > b ? a : b; }
static vec3_f64 absolute(vec3_f64 v) { return vec_f64(fabs(v.x), fabs(v.y), fabs(v.z)); }
static double largest(vec3_f64 v) { return larger(fabs(v.x), larger(fabs(v.y), fabs(v.z))); }

/* ---- bounds ---- */

static scene_bounds mesh_box(const world *w, uint32_t mesh) {
    const mesh_facts *facts = &w->mesh_facts.items[mesh];
    return (scene_bounds){widen(load_f32(facts->lower)), widen(load_f32(facts->upper))};
}

static scene_bounds sphere_box(const world_sphere *s) {
    vec3_f64 c = world_sphere_center(s), r = {(double)s->radius, (double)s->radius, (double)s->radius};
    return (scene_bounds){sub_f64(c, r), add_f64(c, r)};
}

static scene_bounds face_box(const vec3_f64 v[3]) {
    scene_bounds out = {v[0], v[0]};
    bounds_add(&out, v[1]);
    bounds_add(&out, v[2]);
    return out;
}

static void join(scene_bounds *to, scene_bounds other) { bounds_join(to, &other); }

static scene_bounds group_box(const world *w, const world_group *group) {
    scene_bounds out = bounds_empty();
    for (uint32_t i = group->first; i < group->first + group->count; ++i) {
        const world_geometry *g = &w->geometries.items[i];
        for (uint32_t k = 0; k < g->count && g->kind != WORLD_MESH; ++k) {
            if (g->kind == WORLD_SPHERES) join(&out, sphere_box(&w->spheres.items[g->first + k]));
            for (int c = 0; c < 4 && g->kind == WORLD_QUADS; ++c)
                bounds_add(&out, widen(w->quads.items[g->first + k].corner[c]));
        }
        if (g->kind == WORLD_MESH) join(&out, mesh_box(w, g->first));
    }
    return out;
}

/* Transforms the centre by M, and half the extent by |M|. */
static scene_bounds placed_bounds(const scene_bounds *b, const world_instance *instance) {
    if (bounds_is_empty(b)) return *b;
    vec3_f64 middle = scale_f64(0.5, add_f64(b->lower, b->upper)), half = sub_f64(b->upper, middle);
    double at[3], reach[3];
    for (int i = 0; i < 3; ++i) {
        const float *m = instance->to_world[i];
        vec3_f64 row = {(double)m[0], (double)m[1], (double)m[2]};
        at[i] = dot_f64(row, middle) + (double)m[3];
        reach[i] = dot_f64(absolute(row), half);
    }
    return (scene_bounds){sub_f64(load_f64(at), load_f64(reach)), add_f64(load_f64(at), load_f64(reach))};
}

/* ---- one surface and one light ---- */

/* A surface near the light, in its own space. */
typedef struct contact {
    vec3_f64 n;      /* unit */
    double above;    /* of the light above the surface */
    double rounding; /* of the surface's data, along n */
    double self_hit; /* error of the tracer near the surface */
} contact;

static void add_contact(const view *v, const probe *p, const contact *c) {
    finder *f = v->f;
    vec3_f64 n = c->n, at = widen(f->lights[p->light].position);
    double held = c->rounding, near = c->self_hit, slope = 32 * unit_round, length = 1;
    if (v->instance) {
        const double map = placed_carried_along(v->instance, n, at);
        n = placed_normal(v->instance->to_object, n);
        length = length_f64(n);
        n = scale_f64(1 / length, n);
        held += map / 3, near += map,
            slope += 8 * unit_round * surface_stretch_along(v->instance, c->n) / length;
    }
    held = held / length + unit_round * dot_f64(absolute(n), absolute(at));
    double clear = held + near / length, above = c->above / length;
    if (!(fabs(above) <= clear + slope * f->farthest[p->light])) return;
    const bool holds = fabs(above) <= held;
    light_surface surface = {narrow(n), holds ? 0 : (float)above, (float)clear, (float)slope};
    f->in_mesh[p->light] |= holds && v->mesh;
    if (!array_push(&f->list, ((found){p->light, surface}))) f->out_of_memory = true;
}

static void look_at_sphere(const view *v, const probe *p, const world_sphere *s) {
    vec3_f64 from = sub_f64(p->at, world_sphere_center(s));
    double distance = length_f64(from), radius = world_sphere_radius(s);
    if (!(distance > 0)) return;
    contact c = {.n = scale_f64(1 / distance, from), .above = distance - radius};
    c.rounding =
        world_sphere_is_split(s) ? 0 : dot_f64(absolute(c.n), absolute(world_sphere_center(s))) + radius;
    c.rounding *= unit_round, c.self_hit = 8 * unit_round * radius;
    add_contact(v, p, &c);
}

/* True if the light, projected along n, lies in the face or within `loose` of it. */
static bool lies_in(const vec3_f64 v[3], vec3_f64 n, vec3_f64 at, double loose) {
    for (int k = 0; k < 3; ++k) {
        vec3_f64 side = sub_f64(v[(k + 1) % 3], v[k]);
        if (dot_f64(cross_f64(n, side), sub_f64(at, v[k])) < -loose * length_f64(side)) return false;
    }
    return true;
}

static void look_at_face(const view *v, const probe *p, const vec3_f64 corner[3]) {
    vec3_f64 ab = sub_f64(corner[1], corner[0]), ac = sub_f64(corner[2], corner[0]), n = cross_f64(ab, ac);
    double area = length_f64(n), reach = 0;
    if (!(area > 0) || !(area <= DBL_MAX)) return;
    contact c = {.n = scale_f64(1 / area, n)};
    c.above = dot_f64(c.n, sub_f64(p->at, corner[0]));
    if (fabs(c.above) > v->loose || !lies_in(corner, c.n, p->at, v->loose)) return;
    for (int k = 0; k < 3; ++k) reach = larger(reach, dot_f64(absolute(c.n), absolute(corner[k])));
    c.rounding = unit_round * reach;
    c.self_hit = LOCAL_FACE_SELF_HIT * larger(largest(ab), larger(largest(ac), largest(sub_f64(ac, ab))));
    add_contact(v, p, &c);
}

static void look_at_plane(const view *v, const probe *p, const world_plane *plane) {
    vec3_f64 n = normalize_f64(widen(plane->normal)), point = widen(plane->point);
    contact c = {.n = n, .above = dot_f64(n, sub_f64(p->at, point))};
    c.rounding = 4 * unit_round * dot_f64(absolute(n), absolute(p->at));
    c.self_hit = 8 * unit_round * dot_f64(absolute(n), add_f64(absolute(p->at), absolute(point)));
    add_contact(v, p, &c);
}

/* ---- many ---- */

/* The first probe at or beyond x. */
static size_t first_from(const view *v, double x) {
    size_t low = 0, high = v->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (v->probes[middle].at.x < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool in_box(const view *v, const scene_bounds *b, vec3_f64 at) {
    return at.y >= b->lower.y - v->loose && at.y <= b->upper.y + v->loose && at.z >= b->lower.z - v->loose &&
           at.z <= b->upper.z + v->loose;
}

/* The next probe, from index `from` on, that lies in the bounds or within `loose` of them; v->count: none. */
static size_t next_in(const view *v, const scene_bounds *b, size_t from) {
    for (size_t k = from; k < v->count && v->probes[k].at.x <= b->upper.x + v->loose; ++k) {
        if (in_box(v, b, v->probes[k].at)) return k;
    }
    return v->count;
}

static size_t first_in(const view *v, const scene_bounds *b) {
    return next_in(v, b, first_from(v, b->lower.x - v->loose));
}

static void look_through_faces(const view *v, const vec3_f64 corner[3]) {
    const scene_bounds b = face_box(corner);
    for (size_t k = first_in(v, &b); k < v->count; k = next_in(v, &b, k + 1))
        look_at_face(v, &v->probes[k], corner);
}

/* Float is precise enough: `loose` is about 2^12 of its roundings. */
typedef struct float_box {
    vec3_f32 lower, upper;
} float_box;

static float_box probes_box(const view *v) {
    const vec3_f64 loose = {v->loose, v->loose, v->loose};
    scene_bounds all = bounds_empty();
    for (size_t k = 0; k < v->count; ++k) bounds_add(&all, v->probes[k].at);
    return (float_box){narrow(sub_f64(all.lower, loose)), narrow(add_f64(all.upper, loose))};
}

static inline bool apart(float a, float b, float c, float lower, float upper) {
    return ((a < lower) & (b < lower) & (c < lower)) | ((a > upper) & (b > upper) & (c > upper));
}

/* Nearly all of millions of triangles are far from all lights, so this loop must reject them quickly. */
static void look_through_mesh(const view *v, const world *w, uint32_t index) {
    const fathom_mesh *mesh = &w->meshes.items[index];
    const scene_bounds all = mesh_box(w, index);
    if (first_in(v, &all) == v->count) return;
    const float_box near = probes_box(v);
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        vec3_f32 c[3];
        search_corners(mesh, t, c);
        if (apart(c[0].x, c[1].x, c[2].x, near.lower.x, near.upper.x) ||
            apart(c[0].y, c[1].y, c[2].y, near.lower.y, near.upper.y) ||
            apart(c[0].z, c[1].z, c[2].z, near.lower.z, near.upper.z))
            continue;
        const vec3_f64 corner[3] = {widen(c[0]), widen(c[1]), widen(c[2])};
        look_through_faces(v, corner);
    }
}

static void look_through_quad(const view *v, const world_quad *quad) {
    vec3_f64 c[4];
    for (int k = 0; k < 4; ++k) c[k] = widen(quad->corner[k]);
    look_through_faces(v, (const vec3_f64[3]){c[0], c[1], c[3]});
    look_through_faces(v, (const vec3_f64[3]){c[2], c[3], c[1]});
}

static void look_through_sphere(const view *v, const world_sphere *s) {
    const scene_bounds b = sphere_box(s);
    for (size_t k = first_in(v, &b); k < v->count; k = next_in(v, &b, k + 1))
        look_at_sphere(v, &v->probes[k], s);
}

/* Surfaces that cast no shadows hide no light. */
static void look_through_group(view *v, uint32_t group) {
    const world *w = v->f->w;
    const world_group *g = &w->groups.items[group];
    for (uint32_t i = g->first; i < g->first + g->count; ++i) {
        const world_geometry *geometry = &w->geometries.items[i];
        if (geometry->flags & FATHOM_CASTS_NO_SHADOW || geometry->moving) continue;
        v->mesh = geometry->kind == WORLD_MESH;
        if (v->mesh) {
            look_through_mesh(v, w, geometry->first);
            continue;
        }
        for (uint32_t k = geometry->first; k < geometry->first + geometry->count; ++k) {
            if (geometry->kind == WORLD_SPHERES)
                look_through_sphere(v, &w->spheres.items[k]);
            else
                look_through_quad(v, &w->quads.items[k]);
        }
    }
}

static int by_x(const void *a, const void *b) {
    double x = ((const probe *)a)->at.x, y = ((const probe *)b)->at.x;
    return (x > y) - (x < y);
}

/* Only lights within the instance's bounds are transformed to object space. */
static void look_through_instance(finder *f, const world_instance *instance) {
    const scene_bounds b = placed_bounds(&f->bounds[instance->group], instance);
    const view outside = {.probes = f->all, .count = f->count, .loose = f->loose};
    view v = {.f = f, .instance = instance, .probes = f->local};
    double square = 0;
    for (size_t k = first_in(&outside, &b); k < outside.count; k = next_in(&outside, &b, k + 1)) {
        vec3_f64 at = placed_point(instance->to_object, f->all[k].at);
        f->local[v.count++] = (probe){at, f->all[k].light};
    }
    if (!v.count) return;
    for (int i = 0; i < 9; ++i) square += pow((double)instance->to_object[i / 3][i % 3], 2);
    v.loose = f->loose * sqrt(square);
    qsort(f->local, v.count, sizeof *f->local, by_x);
    look_through_group(&v, instance->group);
}

static void look_through_world(finder *f) {
    const world *w = f->w;
    view v = {.f = f, .probes = f->all, .count = f->count, .loose = f->loose};
    if (w->groups.count) look_through_group(&v, 0);
    /* Moving instances are skipped: their surfaces never count as holding a lamp. */
    for (size_t i = 0; i < w->instances.count; ++i)
        if (!w->instances.items[i].moving) look_through_instance(f, &w->instances.items[i]);
    v.mesh = false;
    for (size_t i = 0; i < w->planes.count; ++i) {
        if (w->planes.items[i].flags & FATHOM_CASTS_NO_SHADOW) continue;
        for (uint32_t k = 0; k < f->count; ++k) look_at_plane(&v, &f->all[k], &w->planes.items[i]);
    }
}

/* ---- the whole ---- */

/* Shadow rays are assumed to start in the bounds of the finite objects. Those from the rest of a plane may be
 * longer; there, the light of a lamp just below its panel may be lost. */
static void measure(finder *f, vec3_f32 eye) {
    const world *w = f->w;
    scene_bounds all = {widen(eye), widen(eye)};
    for (size_t g = 0; g < w->groups.count; ++g) f->bounds[g] = group_box(w, &w->groups.items[g]);
    if (w->groups.count) bounds_join(&all, &f->bounds[0]);
    for (size_t i = 0; i < w->instances.count; ++i) {
        const world_instance *instance = &w->instances.items[i];
        join(&all, placed_bounds(&f->bounds[instance->group], instance));
    }
    for (uint32_t k = 0; k < f->count; ++k) {
        vec3_f64 at = f->all[k].at, most = {larger(at.x - all.lower.x, all.upper.x - at.x),
                                            larger(at.y - all.lower.y, all.upper.y - at.y),
                                            larger(at.z - all.lower.z, all.upper.z - at.z)};
        double reach = larger(largest(at), larger(largest(all.lower), largest(all.upper)));
        f->farthest[f->all[k].light] = length_f64(most);
        /* 64 times the tolerance of add_contact() in world space, for transforms that scale. */
        f->loose = larger(f->loose, 0x1p-12 * (length_f64(most) + reach));
    }
}

static bool is_same(const light_surface *a, const light_surface *b) {
    vec3_f32 apart = sub_f32(a->normal, b->normal), sum = add_f32(a->normal, b->normal);
    /* Normals that differ by 2^-10 or less: an end that is clear of one surface is clear of the other. */
    bool turned = dot_f32(sum, sum) < 0x1p-20f, alike = dot_f32(apart, apart) < 0x1p-20f;
    return (alike || turned) && (a->above == 0) == (b->above == 0) && (a->above == 0 || alike);
}

static int by_distance(const void *a, const void *b) {
    const found *x = a, *y = b;
    float p = fabsf(x->surface.above), q = fabsf(y->surface.above);
    if (x->light != y->light) return x->light < y->light ? -1 : 1;
    return (p > q) - (p < q);
}

/* Adds a surface to those of its light, out[0, count), unless it has an equal one; returns their number. */
static uint32_t take(light_surface *out, uint32_t count, const light_surface *s) {
    for (uint32_t k = 0; k < count; ++k) {
        if (!is_same(&out[k], s)) continue;
        out[k].clear = fmaxf(out[k].clear, s->clear), out[k].slope = fmaxf(out[k].slope, s->slope);
        return count;
    }
    if (count == LIGHT_SURFACES_MOST) return count;
    out[count] = *s;
    return count + 1;
}

static bool hand_over(finder *f, shade_light *lights, light_surface **out) {
    if (!f->list.count) return true;
    light_surface *kept = malloc(f->list.count * sizeof *kept);
    if (!kept) return false;
    qsort(f->list.items, f->list.count, sizeof *f->list.items, by_distance);
    size_t first = 0;
    for (size_t i = 0; i < f->list.count; ++i) {
        const found *item = &f->list.items[i];
        shade_light *light = &lights[item->light];
        if (!light->surface_count) light->surfaces = kept + first;
        uint32_t count = take(kept + (light->surfaces - kept), light->surface_count, &item->surface);
        first += count - light->surface_count;
        light->surface_count = count;
    }
    *out = kept;
    return true;
}

static bool find(finder *f, vec3_f32 eye, shade_light *lights, uint32_t count, light_surface **out) {
    for (uint32_t i = 0; i < count; ++i) {
        if (lights[i].type != FATHOM_LIGHT_DIRECTIONAL)
            f->all[f->count++] = (probe){widen(lights[i].position), i};
    }
    if (!f->count) return true;
    measure(f, eye);
    qsort(f->all, f->count, sizeof *f->all, by_x);
    look_through_world(f);
    return !f->out_of_memory && hand_over(f, lights, out);
}

fathom_status light_surfaces_find(fathom_context *context, const world *w, vec3_f32 eye, shade_light *lights,
                                  uint32_t count, bool *in_mesh, light_surface **out) {
    *out = NULL;
    finder f = {.w = w, .lights = lights, .in_mesh = in_mesh};
    f.farthest = calloc(count + 1, sizeof *f.farthest);
    f.bounds = calloc(w->groups.count + 1, sizeof *f.bounds);
    f.all = calloc(2 * ((size_t)count + 1), sizeof *f.all);
    f.local = f.all ? f.all + count + 1 : NULL;
    bool fine = f.farthest && f.bounds && f.all && find(&f, eye, lights, count, out);
    free(f.farthest);
    free(f.bounds);
    free(f.all);
    array_free(&f.list);
    return fine ? FATHOM_OK : fail_memory(context, count * sizeof(light_surface));
}
