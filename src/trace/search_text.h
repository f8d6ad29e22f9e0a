/* Source that search.h includes once per precision, with these defined: REAL, VEC3, FN(name), FROM(v)
 * (converts a vec3_f32 to VEC3), and SUM, the precision in which rays are transformed. */

typedef struct FN(search) {
    const world *world;
    vec3_f32 world_org, world_dir;
    VEC3 org, dir; /* in the current space */
    FN(triangle_ray) ray;
    REAL t_min, t_max;
    float time;                  /* of the shutter; 0 where nothing moves */
    bool any;                    /* any-hit query; geometry that casts no shadow is skipped */
    bool met;                    /* the fields below are set */
    FN(reference_hit) best;      /* on equal rank the first in world order */
    REAL rank;                   /* of `best`: t, or a little more; see search_rank() */
    uint32_t at[3], best_ids[3]; /* instance, geometry, primitive: current, and of the best hit */
} FN(search);

/* Dot product of a matrix row with (p, w), rounded once: products of two floats are exact in double. */
static inline REAL FN(search_row)(const float row[4], vec3_f32 p, float w) {
    return (REAL)((SUM)row[0] * (SUM)p.x + (SUM)row[1] * (SUM)p.y + (SUM)row[2] * (SUM)p.z +
                  (SUM)row[3] * (SUM)w);
}

/* Transforms the ray to the space of an instance, or the world's for FATHOM_NONE. Directions are not
 * normalised, so t keeps its meaning. */
static inline void FN(search_enter)(FN(search) * s, uint32_t instance) {
    s->at[0] = instance;
    if (instance == FATHOM_NONE) {
        s->org = FROM(s->world_org), s->dir = FROM(s->world_dir);
    } else {
        world_instance moved;
        const float(*m)[4] = world_instance_when(s->world, instance, s->time, &moved)->to_object;
        vec3_f32 o = s->world_org, d = s->world_dir;
        s->org = FN(vec)(FN(search_row)(m[0], o, 1), FN(search_row)(m[1], o, 1), FN(search_row)(m[2], o, 1));
        s->dir = FN(vec)(FN(search_row)(m[0], d, 0), FN(search_row)(m[1], d, 0), FN(search_row)(m[2], d, 0));
    }
    s->ray = FN(triangle_ray_make)(s->org, s->dir);
}

/* World order: the root's geometries, then the instances in order. FATHOM_NONE + 1 wraps to 0, so the root
 * comes first. */
static inline bool FN(search_comes_before)(const uint32_t a[3], const uint32_t b[3]) {
    if (a[0] != b[0]) return a[0] + 1 < b[0] + 1;
    return a[1] != b[1] ? a[1] < b[1] : a[2] < b[2];
}

static inline void FN(search_offer)(FN(search) * s, uint32_t primitive, const FN(reference_hit) * hit,
                                    REAL rank) {
    s->at[2] = primitive;
    if (s->met && (rank > s->rank || (rank == s->rank && !FN(search_comes_before)(s->at, s->best_ids))))
        return;
    s->met = true;
    s->best = *hit;
    s->rank = rank;
    s->best_ids[0] = s->at[0], s->best_ids[1] = s->at[1], s->best_ids[2] = primitive;
}

/* ---- one primitive of the current geometry ----
 * The interval never shrinks. So a primitive's hit and its t do not depend on earlier hits, and the result
 * does not depend on the order of the tests. */

static inline bool FN(search_sphere_robust)(const world_sphere *sphere, VEC3 org, VEC3 dir, REAL t_min,
                                            REAL t_max, REAL *t) {
    VEC3 c[2] = {FROM(sphere->center), FROM(sphere->center_rest)};
    REAL radius[2] = {(REAL)sphere->radius, (REAL)sphere->radius_rest};
    if (world_sphere_is_split(sphere)) return FN(sphere_split)(c, radius, org, dir, t_min, t_max, t);
    return FN(sphere_robust)(c[0], radius[0], org, dir, t_min, t_max, t);
}

static inline void FN(search_sphere)(FN(search) * s, const world_sphere *sphere, uint32_t k) {
    FN(reference_hit) hit = {0, 0, 0};
    if (FN(search_sphere_robust)(sphere, s->org, s->dir, s->t_min, s->t_max, &hit.t))
        FN(search_offer)(s, k, &hit, hit.t);
}

/* The rank of a hit at t of a triangle or quad with these corners. */
static inline REAL FN(search_rank)(const FN(search) * s, uint32_t k, REAL t, vec3_f32 a, vec3_f32 b,
                                   vec3_f32 last) {
    if (!s->world->one_sided) return t;
    const vec3_f64 dir = {(double)s->dir.x, (double)s->dir.y, (double)s->dir.z};
    return search_sees_back(s->world, s->at, k, a, b, last, dir) ? t * (REAL)SEARCH_BACK : t;
}

static inline void FN(search_quad)(FN(search) * s, const world_quad *quad, uint32_t k) {
    FN(reference_hit) hit;
    VEC3 v[4] = {FROM(quad->corner[0]), FROM(quad->corner[1]), FROM(quad->corner[2]), FROM(quad->corner[3])};
    if (FN(quad_robust)(v[0], v[1], v[2], v[3], s->org, s->dir, s->t_min, s->t_max, &hit)) FN(search_offer)
    (s, k, &hit, FN(search_rank)(s, k, hit.t, quad->corner[0], quad->corner[1], quad->corner[3]));
}

static inline void FN(search_triangle)(FN(search) * s, const vec3_f32 corner[3], uint32_t k) {
    FN(reference_hit) hit;
    VEC3 v[3] = {FROM(corner[0]), FROM(corner[1]), FROM(corner[2])};
    if (FN(triangle_robust_ray)(v[0], v[1], v[2], &s->ray, s->t_min, s->t_max, &hit))
        FN(search_offer)(s, k, &hit, FN(search_rank)(s, k, hit.t, corner[0], corner[1], corner[2]));
}

/* Tests primitive k of the current geometry. */
static inline void FN(search_primitive)(FN(search) * s, const world_geometry *geometry, uint32_t k) {
    const world *w = s->world;
    switch (geometry->kind) {
    case WORLD_SPHERES: FN(search_sphere)(s, &w->spheres.items[geometry->first + k], k); break;
    case WORLD_QUADS: FN(search_quad)(s, &w->quads.items[geometry->first + k], k); break;
    case WORLD_MESH: {
        vec3_f32 v[3];
        if (geometry->moving)
            world_corners_when(w, geometry, k, s->time, v, NULL);
        else
            search_corners(&w->meshes.items[geometry->first], k, v);
        FN(search_triangle)(s, v, k);
        break;
    }
    }
}

/* Planes are tested last: on equal t, other geometry wins. */
static inline void FN(search_planes)(FN(search) * s) {
    FN(search_enter)(s, FATHOM_NONE);
    s->at[1] = TRACE_PLANE;
    for (size_t p = 0; p < s->world->planes.count && !(s->any && s->met); ++p) {
        const world_plane *plane = &s->world->planes.items[p];
        if (s->any && plane->flags & FATHOM_CASTS_NO_SHADOW) continue;
        FN(reference_hit) hit = {0, 0, 0};
        VEC3 point = FROM(plane->point), normal = FROM(plane->normal);
        if (FN(plane_robust)(point, normal, s->org, s->dir, s->t_min, s->t_max, &hit.t) &&
            (!s->met || hit.t < s->rank)) {
            s->met = true;
            s->best = hit;
            s->rank = hit.t;
            s->best_ids[0] = FATHOM_NONE, s->best_ids[1] = TRACE_PLANE, s->best_ids[2] = (uint32_t)p;
        }
    }
}

/* ---- from blocks and back ---- */

/* False: the lane's interval is empty. */
static inline bool FN(search_begin)(FN(search) * s, const world *w, const trace_rays *rays, unsigned lane,
                                    bool any) {
    *s = (FN(search)){.world = w,
                      .world_org = trace_org(rays, lane),
                      .world_dir = trace_dir(rays, lane),
                      .t_min = (REAL)rays->t_near[lane],
                      .t_max = (REAL)rays->t_far[lane],
                      .time = w->moves ? rays->time[lane] : 0,
                      .any = any};
    return rays->t_near[lane] < rays->t_far[lane];
}

/* The normal as the tracer computes it, in the space of the primitive. */
static inline vec3_f32 FN(search_normal)(FN(search) * s) {
    const world *w = s->world;
    if (s->best_ids[1] == TRACE_PLANE) return w->planes.items[s->best_ids[2]].normal;
    const world_geometry *geometry = &w->geometries.items[s->best_ids[1]];
    VEC3 n;
    if (geometry->kind == WORLD_SPHERES) {
        FN(search_enter)(s, s->best_ids[0]);
        n = FN(sub)(FN(madd)(s->org, s->best.t, s->dir),
                    FROM(w->spheres.items[geometry->first + s->best_ids[2]].center));
    } else {
        vec3_f32 v[4];
        const unsigned last = search_flat(w, geometry, s->best_ids[2], v) - 1;
        if (geometry->moving) world_corners_when(w, geometry, s->best_ids[2], s->time, v, NULL);
        n = FN(cross)(FN(sub)(FROM(v[1]), FROM(v[0])), FN(sub)(FROM(v[last]), FROM(v[0])));
    }
    return vec_f32((float)n.x, (float)n.y, (float)n.z);
}

/* Sets the lane of the block, and of `fine` unless NULL. */
static inline void FN(search_end)(FN(search) * s, trace_block *block, trace_fine *fine, unsigned lane) {
    trace_hits *hits = &block->hits;
    hits->geometry[lane] = FATHOM_NONE;
    if (!s->met) return;
    block->rays.t_far[lane] = (float)s->best.t;
    hits->instance[lane] = s->best_ids[0];
    hits->geometry[lane] = s->best_ids[1];
    hits->primitive[lane] = s->best_ids[2];
    hits->u[lane] = (float)s->best.u, hits->v[lane] = (float)s->best.v;
    vec3_f32 n = FN(search_normal)(s);
    hits->ng_x[lane] = n.x, hits->ng_y[lane] = n.y, hits->ng_z[lane] = n.z;
    if (!fine) return;
    fine->t[lane] = (double)s->best.t;
    fine->t_low[lane] = (double)(s->best.t - (REAL)fine->t[lane]);
    fine->u[lane] = (double)s->best.u, fine->v[lane] = (double)s->best.v;
}

#undef REAL
#undef VEC3
#undef FN
#undef FROM
#undef SUM
