/* Linear search through the world for blocks of rays. linear.c includes this file once per precision, with
 * REAL, VEC3 and FN(name) defined. */

/* Up to 16 rays in the space of the current geometry. Unused lanes are zero. */
typedef struct FN(linear_block) {
    FN(search) s[LANES];
    unsigned lanes; /* bit i: lane i is still searching */
    /* For triangle_candidates(): the lanes of each shear axis, as bits; the origin with permuted axes; the
     * shear. */
    unsigned axis_lanes[3];
    REAL ox[LANES], oy[LANES], oz[LANES], sx[LANES], sy[LANES];
} FN(linear_block);

/* Transforms all rays to the space of an instance, or the world's for FATHOM_NONE. */
static void FN(linear_enter)(FN(linear_block) * b, uint32_t instance) {
    b->axis_lanes[0] = b->axis_lanes[1] = b->axis_lanes[2] = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        if (!(b->lanes >> i & 1)) continue;
        FN(search_enter)(&b->s[i], instance);
        const FN(triangle_ray) *ray = &b->s[i].ray;
        const VEC3 org = FN(turned)(ray->org, ray->axis);
        b->ox[i] = org.x, b->oy[i] = org.y, b->oz[i] = org.z;
        b->sx[i] = ray->sx, b->sy[i] = ray->sy;
        b->axis_lanes[ray->axis] |= 1u << i;
    }
}

/* The lanes whose edge functions do not differ in sign, as if all lanes had this axis. It is
 * triangle_sheared() up to its first return, for all lanes at once, with the same operations in the same
 * order. */
static unsigned FN(triangle_candidates)(const FN(linear_block) * b, int axis, const VEC3 v[3]) {
    const VEC3 p = FN(turned)(v[0], axis), q = FN(turned)(v[1], axis), r = FN(turned)(v[2], axis);
    int candidate[LANES], any = 0;
    for (int i = 0; i < LANES; ++i) {
        const REAL ox = b->ox[i], oy = b->oy[i], oz = b->oz[i], sx = b->sx[i], sy = b->sy[i];
        const REAL az = p.z - oz, bz = q.z - oz, cz = r.z - oz;
        const REAL ax = (p.x - ox) - sx * az, ay = (p.y - oy) - sy * az;
        const REAL bx = (q.x - ox) - sx * bz, by = (q.y - oy) - sy * bz;
        const REAL cx = (r.x - ox) - sx * cz, cy = (r.y - oy) - sy * cz;
        const REAL e = cx * by - cy * bx, f = ax * cy - ay * cx, g = bx * ay - by * ax;
        const int negative = (e < 0) | (f < 0) | (g < 0), positive = (e > 0) | (f > 0) | (g > 0);
        candidate[i] = !(negative & positive);
    }
    for (int i = 0; i < LANES; ++i) any |= candidate[i];
    if (!any) return 0;
    unsigned lanes = 0;
    for (unsigned i = 0; i < LANES; ++i) lanes |= (unsigned)candidate[i] << i;
    return lanes;
}

/* A lane of an any-hit query is done at its first hit. */
static void FN(linear_note)(FN(linear_block) * b, unsigned i) {
    if (b->s[i].any && b->s[i].met) b->lanes &= ~(1u << i);
}

static void FN(linear_triangle)(FN(linear_block) * b, const vec3_f32 corner[3], uint32_t k) {
    const VEC3 v[3] = {FROM(corner[0]), FROM(corner[1]), FROM(corner[2])};
    unsigned lanes = b->lanes;
    /* SSE2 vectors hold four floats, which is faster. With two doubles it is slower if the directions have
     * several axes. */
    if (sizeof(REAL) == sizeof(float)) {
        lanes = 0;
        for (int axis = 0; axis < 3; ++axis) {
            unsigned turned = b->lanes & b->axis_lanes[axis];
            if (turned) lanes |= turned & FN(triangle_candidates)(b, axis, v);
        }
    }
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = (unsigned)__builtin_ctz(lanes);
        FN(search_triangle)(&b->s[i], corner, k);
        FN(linear_note)(b, i);
    }
}

static void FN(linear_geometry)(FN(linear_block) * b, uint32_t index) {
    const world *w = b->s[0].world;
    const world_geometry *geometry = &w->geometries.items[index];
    if (b->s[0].any && geometry->flags & FATHOM_CASTS_NO_SHADOW) return;
    for (unsigned i = 0; i < LANES; ++i) b->s[i].at[1] = index;
    for (uint32_t k = 0; k < geometry->count && b->lanes; ++k) {
        if (geometry->kind == WORLD_MESH && !geometry->moving) {
            vec3_f32 v[3];
            search_corners(&w->meshes.items[geometry->first], k, v);
            FN(linear_triangle)(b, v, k);
            continue;
        }
        for (unsigned lanes = b->lanes; lanes; lanes &= lanes - 1) {
            const unsigned i = (unsigned)__builtin_ctz(lanes);
            FN(search_primitive)(&b->s[i], geometry, k);
            FN(linear_note)(b, i);
        }
    }
}

static void FN(linear_group)(FN(linear_block) * b, uint32_t group, uint32_t instance) {
    const world_group *g = &b->s[0].world->groups.items[group];
    FN(linear_enter)(b, instance);
    for (uint32_t i = 0; i < g->count && b->lanes; ++i) FN(linear_geometry)(b, g->first + i);
}

/* Traces the first `count` lanes of one block. */
static void FN(linear_walk)(const trace_tracer *tracer, const trace_rays *rays, size_t count, bool any,
                            FN(linear_block) * b) {
    const world *w = tracer->world;
    memset(b, 0, sizeof *b);
    for (unsigned i = 0; i < LANES && i < count; ++i)
        b->lanes |= (unsigned)FN(search_begin)(&b->s[i], w, rays, i, any) << i;
    unsigned asked = b->lanes;
    FN(linear_group)(b, 0, FATHOM_NONE);
    for (size_t k = 0; k < w->instances.count && b->lanes; ++k)
        FN(linear_group)(b, w->instances.items[k].group, (uint32_t)k);
    for (; asked; asked &= asked - 1) FN(search_planes)(&b->s[__builtin_ctz(asked)]);
}

static void FN(linear_closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine,
                               size_t count, trace_coherence coherence) {
    (void)coherence;
    FN(linear_block) b;
    for (size_t first = 0; first < count; first += LANES) {
        trace_block *block = &blocks[first / LANES];
        FN(linear_walk)(tracer, &block->rays, count - first, false, &b);
        for (unsigned i = 0; i < LANES && i < count - first; ++i)
            FN(search_end)(&b.s[i], block, fine ? &fine[first / LANES] : NULL, i);
    }
}

static void FN(linear_any)(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                           trace_coherence coherence) {
    (void)coherence;
    FN(linear_block) b;
    for (size_t first = 0; first < count; first += LANES) {
        trace_rays *rays = &blocks[first / LANES];
        FN(linear_walk)(tracer, rays, count - first, true, &b);
        for (unsigned i = 0; i < LANES && i < count - first; ++i)
            if (b.s[i].met) rays->t_far[i] = -INFINITY;
    }
}

#undef REAL
#undef VEC3
#undef FN
#undef FROM
