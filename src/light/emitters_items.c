/* The light tree's item of each finite emitter: bounds of its positions and its axes, and its power. A moving
 * emitter's bounds cover the whole time that the shutter is open. */
#include "light/emitters_inner.h"

#include <float.h>

float emitters_power(const emitters *e, uint32_t geometry, uint32_t primitive, uint32_t instance) {
    return luminance(e->emission[world_material(e->w, geometry, primitive, instance)]);
}

/* Empty bounds, no power, all directions. */
static void begin_item(tree_item *item) {
    for (int k = 0; k < 3; ++k) item->lower[k] = FLT_MAX, item->upper[k] = -FLT_MAX, item->axis[k] = 0;
    item->power = 0, item->spread = 1, item->beam = false;
}

static void bound_box(tree_item *item, vec3_f64 at, const double half[3]) {
    const double middle[3] = {at.x, at.y, at.z};
    for (int k = 0; k < 3; ++k) {
        item->lower[k] = fminf(item->lower[k], (float)(middle[k] - half[k]));
        item->upper[k] = fmaxf(item->upper[k], (float)(middle[k] + half[k]));
    }
}

static void bound(tree_item *item, const vec3_f64 *corners, int count) {
    static const double none[3] = {0, 0, 0};
    for (int i = 0; i < count; ++i) bound_box(item, corners[i], none);
}

/* ---- motion ---- */

/* How the primitives of a run move. */
typedef struct run_motion {
    const world_motion *placed;      /* NULL: their instance is static */
    uint32_t steps;                  /* steps of `placed`, else of the vertices; 0: static */
    uint32_t bends;                  /* steps of the vertices; 0: they are static */
    bool stretches;                  /* the transform scales or shears over time */
    double turn;                     /* maximum rotation in radians between two steps */
    affine_f64 at[WORLD_STEPS_MOST]; /* the transform at each step; only the first if it is static */
} run_motion;

static double turn_between(const motion_parts *a, const motion_parts *b) {
    return 2 * acos(fmin(motion_turn_cosine(a, b), 1));
}

/* Keys that only rotate leave scale and skew unchanged, except for rounding errors. */
static bool is_stretched(const motion_parts *a, const motion_parts *b) {
    double most = 0, off = 0;
    for (int k = 0; k < 3; ++k) {
        most = fmax(most, fabs(a->scale[k]));
        off = fmax(off, fmax(fabs(a->scale[k] - b->scale[k]), fabs(a->skew[k] - b->skew[k])));
    }
    return off > 0x1p-20 * most;
}

static void follow_run(const emitters *e, const emitter_run *run, run_motion *m) {
    const world *w = e->w;
    const uint32_t bent = w->geometries.items[run->geometry].moving;
    m->placed = NULL, m->stretches = false, m->turn = 0;
    m->steps = m->bends = bent ? w->vertex_motions.items[bent - 1].steps : 0;
    m->at[0] = affine_identity();
    if (run->instance == FATHOM_NONE) return;
    const world_instance *instance = &w->instances.items[run->instance];
    m->at[0] = affine_widen(instance->to_world);
    if (!instance->moving) return;
    m->placed = &w->motions.items[instance->moving - 1];
    m->steps = m->placed->steps;
    for (uint32_t k = 0; k < m->steps; ++k) {
        const motion_parts *at = &m->placed->parts[k];
        m->at[k] = motion_put_together(at);
        m->stretches |= m->placed->linear || is_stretched(at, m->placed->parts);
        if (k) m->turn = fmax(m->turn, turn_between(at - 1, at));
    }
}

static float step_time(uint32_t k, uint32_t steps) { return (float)k / (float)(steps - 1); }

static vec3_f64 stretched(const motion_parts *p, vec3_f64 x) {
    return vec_f64(p->scale[0] * x.x + p->skew[0] * x.y + p->skew[1] * x.z,
                   p->scale[1] * x.y + p->skew[2] * x.z, p->scale[2] * x.z);
}

/* Upper bound of the scale of lengths. */
static double stretch_of(const motion_parts *p) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += p->scale[k] * p->scale[k] + p->skew[k] * p->skew[k];
    return sqrt(square);
}

/* Upper bound of the distance between a ball's points and the straight lines that connect their positions at
 * two steps. Such a point is p = R y + T, where y and T move linearly and R rotates by an angle a at nearly
 * constant speed: the distance is at most max |p''| / 8, and |p''| is at most a² |y| + 2 a |y'|. The factor
 * 1.05 is for R, which moves on a chord, and 2^-18 for the tracer's rounding errors. Linear motion has
 * only the last. */
static double slack_between(const world_motion *motion, uint32_t step, vec3_f64 x, double radius) {
    const motion_parts *a = &motion->parts[step], *b = a + 1;
    const vec3_f64 from = stretched(a, x), to = stretched(b, x);
    const double wide = fmax(stretch_of(a), stretch_of(b)), turn = motion->linear ? 0 : turn_between(a, b);
    const double reach = fmax(length_f64(from), length_f64(to)) + radius * wide;
    const double change = length_f64(sub_f64(to, from)) + radius * (is_stretched(a, b) ? 2 * wide : 0);
    return 1.05 / 8 * (turn * turn * reach + 2 * turn * change) + 0x1p-18 * reach;
}

/* Bounds a ball of object space over all positions that the transform gives it. */
static void bound_placed(const run_motion *m, vec3_f64 x, double radius, tree_item *item) {
    for (uint32_t k = 0; k + 1 < m->steps; ++k) {
        const double slack = slack_between(m->placed, k, x, radius);
        for (int end = 0; end < 2; ++end) {
            const affine_f64 *map = &m->at[k + (uint32_t)end];
            double half[3];
            for (int i = 0; i < 3; ++i) half[i] = radius * length_f64(load_f64(map->m[i])) + slack;
            bound_box(item, affine_point(map, x), half);
        }
    }
}

/* ---- faces ---- */

/* The area, and a normal of the first triangle. */
static double face_area(const vec3_f64 c[4], bool quad, vec3_f64 *n) {
    *n = cross_f64(sub_f64(c[1], c[0]), sub_f64(c[3], c[0]));
    double area = 0.5 * length_f64(*n);
    if (quad) area += 0.5 * length_f64(cross_f64(sub_f64(c[3], c[2]), sub_f64(c[1], c[2])));
    return area;
}

/* The corners in the space of the face's group. */
static void own_corners(const emitters *e, const emitter_run *run, uint32_t index, float time,
                        vec3_f64 c[4]) {
    emitters_corners(e->w, run, emitters_primitive(e, run, index), time, c);
    emitters_cut(e, run, index, c);
}

/* The corners at a step, in world space. */
static void corners_at(const emitters *e, const emitter_run *run, uint32_t index, const run_motion *m,
                       uint32_t k, vec3_f64 c[4]) {
    own_corners(e, run, index, step_time(k, m->steps), c);
    for (int i = 0; i < 4; ++i) c[i] = affine_point(&m->at[m->placed ? k : 0], c[i]);
}

/* Bounds all positions of a face whose vertices and transform both move: those of a box around its
 * object-space positions. */
static void bound_bent(const emitters *e, const emitter_run *run, uint32_t index, const run_motion *m,
                       tree_item *item) {
    scene_bounds inside = bounds_empty();
    for (uint32_t k = 0; k < m->bends; ++k) {
        vec3_f64 c[4];
        own_corners(e, run, index, step_time(k, m->bends), c);
        for (int i = 0; i < 4; ++i) bounds_add(&inside, c[i]);
    }
    for (int i = 0; i < 8; ++i) bound_placed(m, bounds_corner(&inside, i), 0, item);
}

/* If vertices move linearly between two steps, their normal is a positive combination of the normals at both
 * steps and of a mixed one: a cone that holds all three also holds it. If the transform rotates, the normal
 * deviates at most by that rotation. For any other motion, the normal may have any direction. */
static void moving_face(const emitters *e, const emitter_run *run, uint32_t index, const run_motion *m,
                        tree_item *item) {
    const bool quad = emitters_is_quad(e, run);
    vec3_f64 c[4], n, b0 = {0, 0, 0}, c0 = b0, axis;
    double area = 0, least = 1;
    corners_at(e, run, index, m, m->steps / 2, c);
    face_area(c, quad, &axis);
    axis = normalize_f64(axis);
    for (uint32_t k = 0; k < m->steps; ++k) {
        corners_at(e, run, index, m, k, c);
        area = fmax(area, face_area(c, quad, &n));
        least = fmin(least, dot_f64(axis, normalize_f64(n)));
        const vec3_f64 b1 = sub_f64(c[1], c[0]), c1 = sub_f64(c[3], c[0]);
        const vec3_f64 mixed = add_f64(cross_f64(b0, c1), cross_f64(b1, c0));
        if (k && m->bends) least = fmin(least, dot_f64(axis, normalize_f64(mixed)));
        b0 = b1, c0 = c1;
        if (!m->placed) bound(item, c, 4);
    }
    own_corners(e, run, index, 0, c);
    for (int i = 0; m->placed && !m->bends && i < 4; ++i) bound_placed(m, c[i], 0, item);
    if (m->placed && m->bends) bound_bent(e, run, index, m, item);
    item->power = (float)area;
    const double angle = acos(fmin(fmax(least, -1), 1)) + m->turn;
    if (m->stretches || (m->placed && m->bends) || !(angle < SHAPE_PI / 2)) return;
    store_f32(item->axis, narrow(axis));
    item->spread = (float)cos(angle);
}

/* The power is half the sum of both sides' intensities along the normal. */
static void face_item(const emitters *e, const emitter_run *run, uint32_t index, const run_motion *m,
                      tree_item *item) {
    shape_face f;
    vec3_f64 n;
    if (m->steps) {
        moving_face(e, run, index, m, item);
        return;
    }
    emitters_face(e, run, emitters_primitive(e, run, index), 0, &f);
    emitters_cut(e, run, index, f.corner);
    item->power = (float)face_area(f.corner, emitters_is_quad(e, run), &n);
    bound(item, f.corner, 4);
    n = normalize_f64(n);
    item->axis[0] = (float)n.x, item->axis[1] = (float)n.y, item->axis[2] = (float)n.z;
}

/* ---- balls ---- */

static void ball_item(const emitters *e, const emitter_run *run, uint32_t primitive, const run_motion *m,
                      tree_item *item) {
    emitter_ball b;
    emitters_ball(e, run, primitive, 0, &b);
    for (uint32_t k = 0; k < (m->steps ? m->steps : 1); ++k) {
        double half[3], square = 0;
        for (int i = 0; i < 3; ++i) {
            half[i] = b.instance ? b.radius * length_f64(load_f64(m->at[k].m[i])) : b.radius;
            square += half[i] * half[i];
        }
        item->power = fmaxf(item->power, (float)(SHAPE_PI / 3 * square));
        if (!m->steps) bound_box(item, affine_point(&m->at[k], b.center), half);
    }
    if (m->steps) bound_placed(m, b.center, b.radius, item);
}

/* ---- each ---- */

/* Embree ignores geometry beyond its range. */
static bool within_reach(const tree_item *item) {
    bool within = true;
    for (int k = 0; k < 3; ++k)
        within &= fabsf(item->lower[k]) < (float)WORLD_REACH && fabsf(item->upper[k]) < (float)WORLD_REACH;
    return within;
}

/* Returns false if the emitter emits nothing, has no area, or is out of range. BSDF samples still hit the
 * emission if a varying one has the mean 0 by mistake. */
static bool surface_item(const emitters *e, const emitter_run *run, uint32_t index, const run_motion *m,
                         tree_item *item) {
    const bool ball = e->w->geometries.items[run->geometry].kind == WORLD_SPHERES;
    const uint32_t primitive = emitters_primitive(e, run, index);
    float power = emitters_power(e, run->geometry, primitive, run->instance);
    if (power > 0 && e->texturing &&
        texturing_varies_emission(e->texturing,
                                  world_material(e->w, run->geometry, primitive, run->instance)))
        power = emitters_varied_power(e, run, index);
    if (!(power > 0)) return false;
    begin_item(item);
    (ball ? ball_item : face_item)(e, run, index, m, item);
    if (!(item->power > 0) || !isfinite(item->power)) return false;
    item->power = fmaxf(fminf(item->power * power, FLT_MAX), FLT_MIN);
    return within_reach(item);
}

/* The power is the irradiance at distance 1, pi k_l. Spots that light almost half of all directions count as
 * points. */
void emitters_lamp_item(const emitter_lamp *lamp, tree_item *item) {
    vec3_f64 at = widen(lamp->light.position);
    begin_item(item);
    bound(item, &at, 1);
    for (int k = 0; k < 3; ++k) item->lower[k] -= lamp->radius, item->upper[k] += lamp->radius;
    item->power = fmaxf(fminf((float)SHAPE_PI * luminance(lamp->light.intensity), FLT_MAX), FLT_MIN);
    if (lamp->light.type != FATHOM_LIGHT_SPOT || !(lamp->light.cone_edge < 0.9f)) return;
    store_f32(item->axis, neg_f32(lamp->light.to_light));
    item->spread = 1 - lamp->light.cone_edge, item->beam = true;
}

uint32_t emitters_list_items(emitters *e, tree_item *items) {
    uint32_t count = 0;
    run_motion m;
    for (uint32_t r = 0; r < e->run_count; ++r) {
        const emitter_run *run = &e->runs[r];
        if (run->count) follow_run(e, run, &m);
        for (uint32_t i = 0; i < run->count; ++i) {
            e->slot_of[run->first + i] = FATHOM_NONE;
            items[count].light = run->first + i;
            count += surface_item(e, run, i, &m, &items[count]);
        }
    }
    for (uint32_t i = 0; i < e->lamp_count; ++i) {
        items[count].light = e->surface_count + i;
        emitters_lamp_item(&e->lamps[i], &items[count++]);
    }
    return count;
}
