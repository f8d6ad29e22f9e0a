/* Hits become surface points: object, world, viewer's side. */
#include "render/local_hit.h"
#include "render/wave.h"
#include "shade/limit.h"

static const float unit_round = 0x1p-24f;

typedef struct ray_hit {
    vec3_f32 org, dir;
    float t_near;
    uint32_t geometry, primitive, instance;
} ray_hit;

static ray_hit load_hit(const trace_block *b, size_t i) {
    return (ray_hit){.org = {b->rays.org_x[i], b->rays.org_y[i], b->rays.org_z[i]},
                     .dir = {b->rays.dir_x[i], b->rays.dir_y[i], b->rays.dir_z[i]},
                     .t_near = b->rays.t_near[i],
                     .geometry = b->hits.geometry[i],
                     .primitive = b->hits.primitive[i],
                     .instance = b->hits.instance[i]};
}

static vec3_f32 map_vector(const float m[3][4], vec3_f32 v) {
    return (vec3_f32){m[0][0] * v.x + m[0][1] * v.y + m[0][2] * v.z,
                      m[1][0] * v.x + m[1][1] * v.y + m[1][2] * v.z,
                      m[2][0] * v.x + m[2][1] * v.y + m[2][2] * v.z};
}

static vec3_f32 map_point(const float m[3][4], vec3_f32 p) {
    return add_f32(map_vector(m, p), (vec3_f32){m[0][3], m[1][3], m[2][3]});
}

static vec3_f32 map_normal(const float inverse[3][4], vec3_f32 n) {
    return normalize_f32((vec3_f32){inverse[0][0] * n.x + inverse[1][0] * n.y + inverse[2][0] * n.z,
                                    inverse[0][1] * n.x + inverse[1][1] * n.y + inverse[2][1] * n.z,
                                    inverse[0][2] * n.x + inverse[1][2] * n.y + inverse[2][2] * n.z});
}

/* |M| e: how far errors e on each axis reach after the map. */
static vec3_f32 map_error(const float m[3][4], vec3_f32 e) {
    vec3_f32 out;
    out.x = fabsf(m[0][0]) * e.x + fabsf(m[0][1]) * e.y + fabsf(m[0][2]) * e.z;
    out.y = fabsf(m[1][0]) * e.x + fabsf(m[1][1]) * e.y + fabsf(m[1][2]) * e.z;
    out.z = fabsf(m[2][0]) * e.x + fabsf(m[2][1]) * e.y + fabsf(m[2][2]) * e.z;
    return out;
}

static vec3_f32 absolute(vec3_f32 v) { return (vec3_f32){fabsf(v.x), fabsf(v.y), fabsf(v.z)}; }

static vec3_f32 translation(const float m[3][4]) { return (vec3_f32){m[0][3], m[1][3], m[2][3]}; }

/* Object to world. To the object's own error come the map's four roundings, and those of carrying the next
 * ray's origin back into the object: 4 u (|M^-1||p| + |T^-1|) there, seen through M. */
static void to_world(const world_instance *instance, local_hit *hit) {
    const float(*m)[4] = instance->to_world, (*inverse)[4] = instance->to_object;
    vec3_f32 object_p = absolute(hit->p), p = map_point(m, hit->p);
    vec3_f32 forth = add_f32(map_error(m, object_p), absolute(translation(m)));
    vec3_f32 back = add_f32(map_error(inverse, absolute(p)), absolute(translation(inverse)));
    vec3_f32 inside = madd_f32(hit->error, 8 * unit_round, back);
    hit->error = madd_f32(map_error(m, inside), 8 * unit_round, forth);
    hit->p = p;
    hit->ng = map_normal(inverse, hit->ng);
    hit->ns = map_normal(inverse, hit->ns);
    hit->lift = map_vector(m, hit->lift);
    hit->lift_inside = map_vector(m, hit->lift_inside);
}

static void evaluate_primitive(const wave *w, const ray_hit *ray, const local_ray *local, local_hit *out) {
    const world *scene = w->plan->world;
    const world_geometry *geometry = &scene->geometries.items[ray->geometry];
    switch (geometry->kind) {
    case WORLD_SPHERES:
        local_sphere(&scene->spheres.items[geometry->first + ray->primitive], local, out);
        break;
    case WORLD_QUADS: local_quad(&scene->quads.items[geometry->first + ray->primitive], local, out); break;
    case WORLD_MESH:
        local_triangle(&scene->meshes.items[geometry->first], ray->primitive, local,
                       w->plan->settings.terminator_fix, out);
        break;
    }
}

static void evaluate(const wave *w, const ray_hit *ray, local_hit *out) {
    local_ray local = {ray->org, ray->dir, ray->t_near};
    if (ray->geometry == TRACE_PLANE) {
        local_plane(&w->plan->world->planes.items[ray->primitive], &local, out);
        return;
    }
    if (ray->instance == FATHOM_NONE) {
        evaluate_primitive(w, ray, &local, out);
        return;
    }
    const world_instance *instance = &w->plan->world->instances.items[ray->instance];
    local.org = map_point(instance->to_object, ray->org);
    local.dir = map_vector(instance->to_object, ray->dir);
    evaluate_primitive(w, ray, &local, out);
    to_world(instance, out);
}

static void put(lanes3 to, size_t i, vec3_f32 v) { to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z; }

static fathom_id hit_material(const world *scene, const ray_hit *ray) {
    if (ray->geometry == TRACE_PLANE) return scene->planes.items[ray->primitive].material;
    return world_material(scene, ray->geometry, ray->primitive, ray->instance);
}

/* n turns to the viewer: the geometric normal decides, and takes the shading normal with it. */
static void push_surface(wave *w, const ray_hit *ray, const local_hit *hit, const path_block *path,
                         size_t lane) {
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    size_t i = w->surface_count % LANES;
    bool outside = dot_f32(hit->ng, ray->dir) < 0;
    vec3_f32 ng = outside ? hit->ng : neg_f32(hit->ng);
    vec3_f32 ns = dot_f32(hit->ns, ng) < 0 ? neg_f32(hit->ns) : hit->ns;
    put(s->p, i, hit->p);
    put(s->ng, i, ng);
    put(s->ns, i, ns);
    put(s->v, i, neg_f32(ray->dir));
    put(s->lift, i, outside ? hit->lift : hit->lift_inside);
    s->offset[i] = w->plan->settings.epsilon > 0 ? 0 : dot_f32(absolute(ng), hit->error);
    for (int c = 0; c < 3; ++c) s->weight[c][i] = path->weight[c][lane];
    s->slot[i] = path->slot[lane];
    s->material[i] = hit_material(w->plan->world, ray);
    s->entering[i] = outside ? ~0u : 0;
    s->smooth[i] = hit->smooth ? ~0u : 0;
    s->count = (uint32_t)i + 1;
    ++w->surface_count;
}

static void add_background(wave *w, const path_block *path, size_t lane, bool first) {
    /* With coverage asked for, the image is to be laid over something else: colours are premultiplied, and
     * the background is not among them. Mirrors and glass still show it. */
    bool seen = !(first && w->plan->settings.aovs & FATHOM_AOV_ALPHA);
    for (int c = 0; c < 3 && seen; ++c) {
        w->radiance[c][path->slot[lane]] += limited(path->weight[c][lane] * w->plan->scene->background[c]);
    }
    if (!first || !w->first) return;
    first_hits *f = w->first;
    uint32_t slot = path->slot[lane];
    f->alpha[slot] = 0;
    f->z[slot] = INFINITY;
    for (int c = 0; c < 3; ++c) f->n[c][slot] = f->p[c][slot] = f->albedo[c][slot] = 0;
    f->object[slot] = f->primitive[slot] = f->instance[slot] = FATHOM_NONE;
}

static fathom_id placed_by(const world *scene, const ray_hit *ray) {
    return ray->instance != FATHOM_NONE ? scene->instances.items[ray->instance].id
                                        : scene->geometries.items[ray->geometry].instance;
}

static void keep_first(wave *w, const ray_hit *ray, const local_hit *hit, uint32_t slot) {
    const world *scene = w->plan->world;
    const fathom_material *m = &w->plan->scene->materials.items[hit_material(scene, ray)].value;
    first_hits *f = w->first;
    bool plane = ray->geometry == TRACE_PLANE, specular = m->specular != FATHOM_SPECULAR_NONE;
    vec3_f64 p = widen(hit->p), from_eye = sub_f64(p, widen(w->plan->camera.eye));
    vec3_f32 ns = dot_f32(hit->ns, hit->ng) * dot_f32(hit->ng, ray->dir) < 0 ? hit->ns : neg_f32(hit->ns);
    const float world_p[3] = {(float)(p.x + scene->origin.x), (float)(p.y + scene->origin.y),
                              (float)(p.z + scene->origin.z)};
    const float normal[3] = {ns.x, ns.y, ns.z};
    f->alpha[slot] = 1;
    f->z[slot] = (float)dot_f64(from_eye, w->plan->camera.view);
    for (int c = 0; c < 3; ++c) {
        f->p[c][slot] = world_p[c];
        f->n[c][slot] = normal[c];
        f->albedo[c][slot] = m->k_d[c] + (specular ? m->k_s[c] : 0);
    }
    f->object[slot] = plane ? scene->planes.items[ray->primitive].object
                            : world_object(scene, ray->geometry, ray->primitive);
    f->primitive[slot] = plane ? 0 : ray->primitive;
    f->instance[slot] = plane ? FATHOM_NONE : placed_by(scene, ray);
}

/* The rest of the last block repeats its last point, so that stages may compute all 16 lanes. */
static void pad(wave *w) {
    if (w->surface_count % LANES == 0) return;
    surface_block *s = &w->surfaces[w->surface_count / LANES];
    for (size_t last = s->count - 1, i = s->count; i < LANES; ++i) {
        for (int c = 0; c < 3; ++c) {
            s->p[c][i] = s->p[c][last], s->ng[c][i] = s->ng[c][last], s->ns[c][i] = s->ns[c][last];
            s->v[c][i] = s->v[c][last], s->lift[c][i] = s->lift[c][last],
            s->weight[c][i] = s->weight[c][last];
        }
        s->offset[i] = s->offset[last], s->slot[i] = s->slot[last], s->material[i] = s->material[last];
        s->entering[i] = s->entering[last], s->smooth[i] = s->smooth[last];
    }
}

static void note_depths(wave *w, const trace_block *block, const path_block *path, size_t lane) {
    watertight_sides sides =
        watertight_sides_of(w->plan->watertight, block, (unsigned)lane, path->depth[lane]);
    size_t k = w->surface_count - 1;
    w->surfaces[k / LANES].depth[k % LANES] = sides.before;
    w->surfaces[k / LANES].depth_behind[k % LANES] = sides.behind;
}

bool wave_surfaces(wave *w, bool first) {
    w->surface_count = 0;
    if (!wave_reserve_surfaces(w, w->now.count)) return false;
    for (size_t k = 0; k < w->now.count; ++k) {
        const trace_block *block = &w->now.rays[k / LANES];
        const path_block *path = &w->now.paths[k / LANES];
        ray_hit ray = load_hit(block, k % LANES);
        if (ray.geometry == FATHOM_NONE) {
            add_background(w, path, k % LANES, first);
            continue;
        }
        local_hit hit;
        evaluate(w, &ray, &hit);
        push_surface(w, &ray, &hit, path, k % LANES);
        if (w->plan->watertight) note_depths(w, block, path, k % LANES);
        if (first && w->first) keep_first(w, &ray, &hit, path->slot[k % LANES]);
    }
    pad(w);
    return true;
}
