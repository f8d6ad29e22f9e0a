/* BVH traversal with one ray. bvh_trace.c includes this file once per precision, with REAL, FN(name), ABS and
 * UNIT defined.
 *
 * A box must not be culled if it holds a primitive that linear search hits (the aim of Ize 2013, Robust BVH
 * Ray Traversal, JCGT 2(2)). For triangles and quads this is exact, without any slack. The watertight test
 * shears each vertex, X = fl(fl(x - ox) - fl(sx fl(z - oz))), and hits the triangle only if the origin lies
 * in the hull of the sheared vertices. Rounding is monotonic, so the same operations on the box's faces bound
 * the X of every vertex in it, and a hit requires that these bounds contain 0. The same holds for Y. So a box
 * is culled by the bounding rectangle of its projection along the ray, without a division.
 *
 * Along the ray: the reported depth is the depth of A plus differences to it, with positive weights whose sum
 * is at most 1. So it lies between the vertices' depths, up to 14 units of the largest: 6 from the
 * differences, each at most twice the largest, 1 from the sum, and the rest of second order. We use 16 units,
 * which cover the rounding here too. Only the depth has this bound: the t of a sliver may lie well outside
 * the other two slabs. So boxes are sorted, and culled behind the best hit, by their depth only.
 *
 * Spheres, with F the largest coordinate of the box relative to the ray's origin, |f| <= √3 F the distance to
 * the centre, and u the unit roundoff: if sphere_plain() is sure, the point at the reported t satisfies |P -
 * C|² = R² + δD with |δD| <= 51 u |f| R (sphere_text.h), so it lies within 26 u |f| of the sphere; the error
 * of c / q is 54 u from c, δD / q <= 102 u |f|, since q >= √c >= R / 2, and a few u for the rest: together
 * 256 u |f|. If it is not sure, the wider precision decides; its error is negligible, even √u R where both
 * roots vanish. Quadruple has no wider precision, so we use double's units there. Shearing adds 5 u F: 512 u
 * F covers everything.
 *
 * Instances: transforming a ray to object space costs 4 units of each product, for origin and direction. With
 * M the matrix, B the largest coordinate in the world and T that of M's translation, these are 4 u (|M| (F +
 * B) + T) and 4 u |M| 3 F. Shearing there adds 5 u |M| F. Transformed back, all of these grow by |M⁻¹|: 21 u
 * κ F + 4 u (κ B + |M⁻¹| T), κ = |M| |M⁻¹|; 32 and 8 units cover this and the shearing here. The slack of the
 * object's own tree grows by κ. A sliver's t may lie outside its box by up to the box's extent, which is
 * `reach` in the world. */

/* The ray, prepared for the box tests of one tree. */
typedef struct FN(bvh_view) {
    REAL ox, oy, oz, sx, sy; /* axes permuted so that z is the ray's main axis */
    int x, y, z;
    bool up;                    /* the ray runs along +z */
    REAL spread, offset, reach; /* of the tree */
    REAL length, near;          /* |dz|; the minimum depth of a hit */
} FN(bvh_view);

static inline FN(bvh_view) FN(bvh_view_make)(const FN(search) * s, const bvh_tree *tree) {
    const FN(triangle_ray) *ray = &s->ray;
    REAL length = ABS(ray->dz);
    const REAL org[3] = {s->org.x, s->org.y, s->org.z};
    const REAL unit = tree->spread > 0 && UNIT < (REAL)0x1p-53 ? (REAL)0x1p-53 : (REAL)UNIT;
    FN(bvh_view)
    v = {.sx = ray->sx,
         .sy = ray->sy,
         .x = (ray->axis + 1) % 3,
         .y = (ray->axis + 2) % 3,
         .z = ray->axis,
         .up = ray->dz > 0,
         .spread = (REAL)tree->spread * unit,
         .offset = (REAL)tree->offset * unit,
         .reach = (REAL)tree->reach + (REAL)TINY,
         .length = length,
         .near = s->t_min * length * (1 - 8 * UNIT)};
    v.ox = org[v.x], v.oy = org[v.y], v.oz = org[v.z];
    return v;
}

/* The maximum depth that still matters: t <= rank means depth <= rank |dz| (1 + 2 u); rounding adds 3 u
 * more. */
static inline REAL FN(bvh_limit)(const FN(search) * s, const FN(bvh_view) * v) {
    return (s->met ? s->rank : s->t_max) * v->length * (1 + 8 * UNIT);
}

/* True if the ray may hit something in the box before `limit`. *depth: lower bound of its depth. The
 * comparisons are written so that a NaN (from infinities) never culls a box. */
static inline bool FN(bvh_meets)(const FN(bvh_view) * v, const bvh_node *node, REAL limit, REAL *depth) {
    REAL x0 = (REAL)node->lower[v->x] - v->ox, x1 = (REAL)node->upper[v->x] - v->ox;
    REAL y0 = (REAL)node->lower[v->y] - v->oy, y1 = (REAL)node->upper[v->y] - v->oy;
    REAL z0 = (REAL)node->lower[v->z] - v->oz, z1 = (REAL)node->upper[v->z] - v->oz;
    REAL left = x0 - v->sx * (v->sx >= 0 ? z1 : z0), right = x1 - v->sx * (v->sx >= 0 ? z0 : z1);
    REAL low = y0 - v->sy * (v->sy >= 0 ? z1 : z0), high = y1 - v->sy * (v->sy >= 0 ? z0 : z1);
    REAL deep = -z0 > z1 ? -z0 : z1; /* the larger of |z0| and |z1|, as z0 <= z1 */
    REAL wide = -x0 > x1 ? -x0 : x1, tall = -y0 > y1 ? -y0 : y1, far = wide > tall ? wide : tall;
    REAL slack = v->spread * (far > deep ? far : deep) + v->offset;
    REAL along = 16 * UNIT * deep + (slack + v->reach);
    REAL begin = (v->up ? z0 : -z1) - along, end = (v->up ? z1 : -z0) + along;
    *depth = begin;
    return !((left > slack) | (right < -slack) | (low > slack) | (high < -slack) | (begin > limit) |
             (end < v->near));
}

static void FN(bvh_walk)(FN(search) * s, const bvh_tracer *tracer, const bvh_tree *tree);

/* A geometry, or an instance of a group. */
static void FN(bvh_part)(FN(search) * s, const bvh_tracer *tracer, uint32_t part) {
    const world *w = tracer->base.world;
    if (part < w->geometries.count) {
        if (s->any && w->geometries.items[part].flags & FATHOM_CASTS_NO_SHADOW) return;
        s->at[1] = part;
        FN(bvh_walk)(s, tracer, &tracer->geometries[part]);
        return;
    }
    uint32_t instance = part - (uint32_t)w->geometries.count;
    FN(search_enter)(s, instance);
    FN(bvh_walk)(s, tracer, &tracer->groups[w->instances.items[instance].group]);
    FN(search_enter)(s, FATHOM_NONE);
}

static inline void FN(bvh_leaf)(FN(search) * s, const bvh_tracer *tracer, const bvh_tree *tree,
                                const bvh_node *node) {
    for (uint32_t i = node->first; i < node->first + node->count && !(s->any && s->met); ++i)
        if (tree->geometry)
            FN(search_primitive)(s, tree->geometry, tree->items[i]);
        else
            FN(bvh_part)(s, tracer, tree->items[i]);
}

/* Depth first, the nearer child first. A child that begins exactly at the best hit is still visited: it may
 * hold a hit at the same t that comes earlier in world order. */
static void FN(bvh_walk)(FN(search) * s, const bvh_tracer *tracer, const bvh_tree *tree) {
    struct {
        REAL depth;
        uint32_t node;
    } stack[BVH_STACK];
    unsigned waiting = 0;
    FN(bvh_view) v = FN(bvh_view_make)(s, tree);
    REAL limit = FN(bvh_limit)(s, &v), depth[2];
    if (!tree->node_count || !FN(bvh_meets)(&v, tree->nodes, limit, depth)) return;
    for (uint32_t at = 0;;) {
        const bvh_node *node = &tree->nodes[at];
        if (node->count) {
            FN(bvh_leaf)(s, tracer, tree, node);
            if (s->any && s->met) return;
            limit = FN(bvh_limit)(s, &v);
        } else {
            bool first = FN(bvh_meets)(&v, &tree->nodes[node->first], limit, &depth[0]);
            bool second = FN(bvh_meets)(&v, &tree->nodes[node->first + 1], limit, &depth[1]);
            unsigned nearer = first & second ? depth[1] < depth[0] : second;
            at = node->first + nearer;
            if (first & second) {
                stack[waiting].depth = depth[!nearer];
                stack[waiting++].node = node->first + !nearer;
            }
            if (first | second) continue;
        }
        do {
            if (!waiting) return;
        } while (stack[--waiting].depth > limit);
        at = stack[waiting].node;
    }
}

/* ---- blocks ---- */

static void FN(bvh_lane)(FN(search) * s, const trace_tracer *base) {
    const bvh_tracer *tracer = (const bvh_tracer *)base;
    FN(search_enter)(s, FATHOM_NONE);
    FN(bvh_walk)(s, tracer, &tracer->groups[0]);
    FN(search_planes)(s);
}

static void FN(bvh_closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                            trace_coherence coherence) {
    (void)coherence;
    for (size_t i = 0; i < count; ++i) {
        trace_block *block = &blocks[i / LANES];
        FN(search) s;
        if (FN(search_begin)(&s, tracer->world, &block->rays, i % LANES, false)) FN(bvh_lane)(&s, tracer);
        FN(search_end)(&s, block, fine ? &fine[i / LANES] : NULL, i % LANES);
    }
}

static void FN(bvh_any)(const trace_tracer *tracer, trace_rays *blocks, size_t count,
                        trace_coherence coherence) {
    (void)coherence;
    for (size_t i = 0; i < count; ++i) {
        trace_rays *rays = &blocks[i / LANES];
        FN(search) s;
        if (!FN(search_begin)(&s, tracer->world, rays, i % LANES, true)) continue;
        FN(bvh_lane)(&s, tracer);
        if (s.met) rays->t_far[i % LANES] = -INFINITY;
    }
}

#undef REAL
#undef FN
#undef ABS
#undef UNIT
