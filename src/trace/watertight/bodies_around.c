#include "trace/watertight/bodies.h"

static const depth_span anything = {0, BODIES_ANY};

/* ---- from a point ---- */

/* A surface whose surroundings are sampled: a body, or all contents of an instance. */
typedef struct surface {
    uint32_t group, instance, body;
    vec3_f32 points[SAMPLES];
} surface;

static bool is_own(const finder *f, const surface *s, const trace_crossing *c) {
    if (s->instance != FATHOM_NONE) return c->instance == s->instance;
    return c->instance == FATHOM_NONE && finder_body(f, c->geometry, c->primitive) == s->body;
}

static uint8_t clamp_depth(int depth) {
    return (uint8_t)(depth < 0 ? 0 : (depth < BODIES_ANY ? depth : BODIES_ANY));
}

/* Counts the bodies around point k. Surfaces that nearly touch it, within 2^-10 of its body's size, may lie
 * on either side, so they widen the span. */
static bool look_at(finder *f, const surface *s, unsigned k, float touching, depth_span *out) {
    int low = 0, high = 0;
    vec3_f32 dir = load_f32(bodies_probes[k % BODIES_PROBES]);
    if (!f->retry->crossings(f->out->tracer->self, s->group, s->points[k], dir, &f->room)) return false;
    for (size_t i = 0; i < f->room.count; ++i) {
        const trace_crossing *c = &f->room.items[i];
        if (is_own(f, s, c)) continue;
        int step = bodies_step_out(f->out, c);
        if (c->t > touching || step < 0) low += step;
        if (c->t > touching || step > 0) high += step;
    }
    *out = (depth_span){clamp_depth(low), clamp_depth(high)};
    return true;
}

static bool look_around(finder *f, const surface *s, depth_span *out) {
    float size = 0;
    *out = anything;
    if (f->looks++ >= LOOKS_MOST) return true;
    for (unsigned k = 1; k < SAMPLES; ++k)
        size = fmaxf(size, length_f32(sub_f32(s->points[k], s->points[0])));
    for (unsigned k = 0; k < SAMPLES; ++k) {
        depth_span here;
        if (!look_at(f, s, k, size * 0x1p-10f, &here)) return false;
        if (k == 0) *out = here;
        out->low = here.low < out->low ? here.low : out->low;
        out->high = here.high > out->high ? here.high : out->high;
    }
    return true;
}

/* ---- boxes ---- */

static void box_add(body_box *box, vec3_f32 p) {
    box->lower = vec_f32(fminf(box->lower.x, p.x), fminf(box->lower.y, p.y), fminf(box->lower.z, p.z));
    box->upper = vec_f32(fmaxf(box->upper.x, p.x), fmaxf(box->upper.y, p.y), fmaxf(box->upper.z, p.z));
}

static body_box box_none(void) {
    return (body_box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, 0};
}

static void box_join(body_box *box, const body_box *other) {
    box_add(box, other->lower), box_add(box, other->upper);
    box->count = clamp_depth(box->count + other->count);
}

/* Makes the box a little wider. Boxes are only a filter for further tests, so this is safe. */
static void box_widen(body_box *box) {
    vec3_f32 margin = scale_f32(0x1p-10f, sub_f32(box->upper, box->lower));
    box->lower = sub_f32(box->lower, margin), box->upper = add_f32(box->upper, margin);
}

static bool boxes_meet(const body_box *a, const body_box *b) {
    return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
           b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

static vec3_f32 placed_point(const world_instance *instance, vec3_f32 p) {
    const float(*m)[4] = instance->to_world;
    return vec_f32(m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3],
                   m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3],
                   m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3]);
}

static body_box mesh_box(const finder *f, uint32_t geometry) {
    const mesh_facts *facts = &f->world->mesh_facts.items[f->world->geometries.items[geometry].first];
    body_box box = {load_f32(facts->lower), load_f32(facts->upper), 0};
    box_widen(&box);
    return box;
}

static body_box instance_box(const finder *f, uint32_t k) {
    const world_instance *instance = &f->world->instances.items[k];
    vec3_f32 lower, upper;
    body_box box = box_none();
    f->retry->bounds(f->out->tracer->self, instance->group, &lower, &upper);
    if (lower.x > upper.x) return box;
    for (unsigned c = 0; c < 8; ++c) {
        box_add(&box, placed_point(instance, vec_f32(c & 1 ? lower.x : upper.x, c & 2 ? lower.y : upper.y,
                                                     c & 4 ? lower.z : upper.z)));
    }
    box_widen(&box);
    return box;
}

static uint8_t closed_bodies(const finder *f, uint32_t geometry) {
    const geometry_bodies *of = &f->out->of[geometry];
    if (f->out->all[of->first].facing == FACING_NONE) return 0;
    return of->vague ? BODIES_ANY : clamp_depth((int)of->count);
}

/* Number of closed bodies in a group. */
static uint8_t group_bodies(const finder *f, uint32_t group) {
    const world_group *g = &f->world->groups.items[group];
    int count = 0;
    for (uint32_t i = g->first; i < g->first + g->count; ++i) count += closed_bodies(f, i);
    return clamp_depth(count);
}

static bool push_box(finder *f, body_box box, uint32_t owner, uint8_t count) {
    box.count = count;
    return !count || array_push(&f->boxes, ((owned_box){box, owner}));
}

/* Finds the boxes of the closed bodies in the group's space. */
static bool find_boxes(finder *f, uint32_t group) {
    const world_group *g = &f->world->groups.items[group];
    const uint32_t geometries = (uint32_t)f->world->geometries.count;
    f->boxes.count = 0;
    for (uint32_t i = g->first; i < g->first + g->count; ++i)
        if (closed_bodies(f, i) && !push_box(f, mesh_box(f, i), i, closed_bodies(f, i))) return false;
    if (group || !f->out->around) return true;
    for (uint32_t k = 0; k < f->world->instances.count; ++k) {
        uint8_t count = group_bodies(f, f->world->instances.items[k].group);
        if (!push_box(f, instance_box(f, k), geometries + k, count)) return false;
    }
    return true;
}

/* Stores the root's boxes for watertight.c. */
static void keep_boxes(finder *f) {
    bodies *b = f->out;
    body_box all = box_none();
    if (!b->around) {
        f->retry->bounds(b->tracer->self, 0, &all.lower, &all.upper);
        box_widen(&all);
        all.count = BODIES_ANY;
    }
    for (size_t i = 0; i < f->boxes.count; ++i) box_join(&all, &f->boxes.items[i].box);
    b->box_count = 1;
    b->boxes[0] = all;
    if (!b->around || f->boxes.count > BODIES_BOXES) return;
    b->box_count = (unsigned)f->boxes.count;
    for (unsigned i = 0; i < b->box_count; ++i) b->boxes[i] = f->boxes.items[i].box;
}

/* True if other closed bodies may lie around the box. */
static bool may_lie_in(const finder *f, const body_box *box, uint32_t owner) {
    for (size_t i = 0; i < f->boxes.count; ++i) {
        const owned_box *other = &f->boxes.items[i];
        if ((other->owner != owner || other->box.count > 1) && boxes_meet(box, &other->box)) return true;
    }
    return false;
}

/* ---- all surroundings ---- */

static body_box body_box_of(const finder *f, const sample *at) {
    const world_geometry *g = &f->world->geometries.items[at->geometry];
    body_box box = box_none();
    switch (g->kind) {
    case WORLD_MESH: return mesh_box(f, at->geometry);
    case WORLD_SPHERES: {
        const world_sphere *s = &f->world->spheres.items[g->first + at->primitive];
        const vec3_f32 r = {s->radius, s->radius, s->radius};
        box_add(&box, sub_f32(s->center, r)), box_add(&box, add_f32(s->center, r));
        break;
    }
    case WORLD_QUADS:
        for (unsigned c = 0; c < 4; ++c)
            box_add(&box, f->world->quads.items[g->first + at->primitive].corner[c]);
        break;
    }
    return box;
}

static bool find_around_body(finder *f, uint32_t group, uint32_t geometry, uint32_t k) {
    uint32_t body = f->out->of[geometry].first + k;
    const sample *samples = f->samples[body];
    surface s = {.group = group, .instance = FATHOM_NONE, .body = body};
    depth_span *around = &f->out->all[body].around;
    const body_box box = body_box_of(f, &samples[0]);
    if (!may_lie_in(f, &box, geometry)) return true; /* nothing can be around it */
    for (unsigned i = 0; i < SAMPLES; ++i) s.points[i] = finder_point(f->world, &samples[i], i);
    return look_around(f, &s, around);
}

static bool find_around_instance(finder *f, uint32_t k) {
    const world_instance *instance = &f->world->instances.items[k];
    const world_group *group = &f->world->groups.items[instance->group];
    surface s = {.instance = k};
    const body_box box = instance_box(f, k);
    if (!group->count || !may_lie_in(f, &box, (uint32_t)f->world->geometries.count + k)) return true;
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        const geometry_bodies *of = &f->out->of[group->first + i * group->count / SAMPLES];
        uint32_t body = of->first + (of->count > 1 ? i % of->count : 0);
        s.points[i] = placed_point(instance, finder_point(f->world, &f->samples[body][i], i));
    }
    return look_around(f, &s, &f->out->around[k]);
}

static bool find_around_geometry(finder *f, uint32_t group, uint32_t g) {
    geometry_bodies *of = &f->out->of[g];
    if (of->vague) {
        f->out->all[of->first].around = anything;
        return true;
    }
    if (!f->world->geometries.items[g].count) return true;
    for (uint32_t k = 0; k < of->count; ++k) {
        if (!find_around_body(f, group, g, k)) return false;
        of->nested |= f->out->all[of->first + k].around.low > 0;
    }
    return true;
}

bool finder_around(finder *f) {
    const world *w = f->world;
    bool fine = true;
    for (uint32_t group = (uint32_t)w->groups.count; group-- > 0 && fine;) {
        uint32_t first = w->groups.items[group].first, end = first + w->groups.items[group].count;
        fine = find_boxes(f, group);
        for (uint32_t g = first; g < end && fine; ++g) fine = find_around_geometry(f, group, g);
    }
    for (uint32_t k = 0; f->out->around && k < w->instances.count && fine; ++k)
        fine = find_around_instance(f, k);
    if (fine) keep_boxes(f);
    return fine;
}
