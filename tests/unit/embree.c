/* Embree against the linear search, which defines the closest hit; and that no answer depends on how rays are
 * grouped, how the tree was built or how many threads built it. */
#include "stage.h"

/* ---- parity ---- */

static vec3_f64 carried(const float m[3][4], vec3_f64 p, double w) {
    double r[3];
    for (int i = 0; i < 3; ++i) {
        r[i] = (double)m[i][0] * p.x + (double)m[i][1] * p.y + (double)m[i][2] * p.z + (double)m[i][3] * w;
    }
    return load_f64(r);
}

/* Whether float cannot tell on which side of an edge of the triangle that was hit the ray passes. The side is
 * the sign of d·(a × b), a and b from the origin to the edge's ends. Differences, products and sums leave 8
 * units of |d||a||b|; an instance's map, rounded once in each of its factors, as much again. */
static bool near_edge(const world *w, const ray_set *set, size_t i) {
    const trace_rays *r = &set->blocks[i / 16].rays;
    const trace_hits *h = &set->blocks[i / 16].hits;
    size_t k = i % 16;
    if (h->geometry[k] >= w->geometries.count) return false;
    const world_geometry *geometry = &w->geometries.items[h->geometry[k]];
    if (geometry->kind != WORLD_MESH) return false;
    vec3_f64 org = {(double)r->org_x[k], (double)r->org_y[k], (double)r->org_z[k]};
    vec3_f64 dir = {(double)r->dir_x[k], (double)r->dir_y[k], (double)r->dir_z[k]}, v[3];
    if (h->instance[k] != FATHOM_NONE) {
        const world_instance *instance = &w->instances.items[h->instance[k]];
        org = carried(instance->to_object, org, 1), dir = carried(instance->to_object, dir, 0);
    }
    const fathom_mesh *mesh = &w->meshes.items[geometry->first];
    for (int c = 0; c < 3; ++c) {
        const float *p = &mesh->positions[3 * (size_t)mesh->indices[3 * (size_t)h->primitive[k] + (size_t)c]];
        v[c] = sub_f64(widen(load_f32(p)), org);
    }
    for (int c = 0; c < 3; ++c) {
        vec3_f64 a = v[c], b = v[(c + 1) % 3];
        double side = dot_f64(dir, cross_f64(a, b)), size = length_f64(a) * length_f64(b) * length_f64(dir);
        if (fabs(side) <= 16 * 0x1p-24 * size) return true;
    }
    return false;
}

/* Closest hits are the linear search's, and so is occlusion, but where a ray passes an edge so closely that
 * float cannot tell the side: then Embree may take the neighbour, or the edge's own rounding. Returns how
 * many differ. */
static size_t agrees_with_linear(stage *s, ray_set set) {
    trace_tracer *embree = stage_embree(s, 16), *linear = stage_trace(s, "reference", 16, 0, 2);
    ray_set e = traced(embree, &set, TRACE_COHERENT), l = traced(linear, &set, TRACE_COHERENT);
    unsigned char *eo = occluded(embree, &set, TRACE_COHERENT), *lo = occluded(linear, &set, TRACE_COHERENT);
    size_t differ = 0, unexplained = 0;
    for (size_t i = 0; i < set.count; ++i) {
        if (same_hit(&e, &l, i) && eo[i] == lo[i]) continue;
        ++differ;
        unexplained += !near_edge(s->world, &e, i) && !near_edge(s->world, &l, i);
    }
    assert_int_equal(unexplained, 0);
    return differ;
}

UNIT_TEST(parity) {
    stage s = stage_open();
    add_everything(&s);
    stage_embree(&s, 1);
    /* A random ray comes so near to an edge once in some 10^5 (16 units, 3 edges, at most 10 triangles deep).
     */
    assert_in_range(agrees_with_linear(&s, random_rays(fewer(20000))), 0, 2);
    agrees_with_linear(&s, edge_rays(s.world, fewer(10000)));
    agrees_with_linear(&s, camera_rays(90));
}

/* ---- one answer, however rays are grouped and the tree was built ---- */

/* Rays in another order, with holes: partial blocks, of rays that do not belong together. Ray i of the result
 * is ray order[i]. */
static ray_set shuffled(const ray_set *set, size_t *order) {
    for (size_t i = 0; i < set->count; ++i) order[i] = i;
    for (size_t i = set->count; i-- > 1;) {
        size_t j = (size_t)(uniform() * (double)(i + 1)), swap = order[i];
        order[i] = order[j], order[j] = swap;
    }
    ray_set mixed = rays_new(set->count);
    for (size_t i = 0; i < set->count; ++i) {
        const trace_rays *from = &set->blocks[order[i] / 16].rays;
        size_t k = order[i] % 16;
        double org[3] = {(double)from->org_x[k], (double)from->org_y[k], (double)from->org_z[k]};
        double dir[3] = {(double)from->dir_x[k], (double)from->dir_y[k], (double)from->dir_z[k]};
        ray_set_to(&mixed, i, org, dir, from->t_far[k]);
    }
    return mixed;
}

static void same_answers(const trace_tracer *tracer, const ray_set *set, const ray_set *expected,
                         const unsigned char *expected_any, trace_coherence coherence) {
    ray_set got = traced(tracer, set, coherence);
    unsigned char *any = occluded(tracer, set, coherence);
    size_t differ = 0, t_differ = 0, any_differ = 0;
    for (size_t i = 0; i < set->count; ++i) {
        differ += !same_hit(&got, expected, i);
        t_differ += hit_t(&got, i) != hit_t(expected, i);
        any_differ += any[i] != expected_any[i];
    }
    assert_int_equal(differ, 0);
    assert_int_equal(t_differ, 0);
    assert_int_equal(any_differ, 0);
}

/* The same rays in random order and company: each still gets its answer. */
static void same_answers_mixed(const trace_tracer *tracer, const ray_set *set, const ray_set *expected,
                               const unsigned char *expected_any, trace_coherence coherence) {
    size_t *order = unit_memory(set->count * sizeof *order);
    ray_set mixed = shuffled(set, order), e = rays_new(set->count);
    unsigned char *any = unit_memory(set->count);
    for (size_t i = 0; i < set->count; ++i) {
        const trace_block *from = &expected->blocks[order[i] / 16];
        trace_block *to = &e.blocks[i / 16];
        size_t k = order[i] % 16, n = i % 16;
        to->rays.t_far[n] = from->rays.t_far[k];
        to->hits.geometry[n] = from->hits.geometry[k], to->hits.primitive[n] = from->hits.primitive[k],
        to->hits.instance[n] = from->hits.instance[k];
        any[i] = expected_any[order[i]];
    }
    same_answers(tracer, &mixed, &e, any, coherence);
}

static void one_answer(stage *s, ray_set set) {
    trace_tracer *single = stage_trace(s, "embree", 1, TRACE_QUALITY_MEDIUM, 1);
    ray_set expected = traced(single, &set, TRACE_COHERENT);
    unsigned char *any = occluded(single, &set, TRACE_COHERENT);
    for (unsigned width = 1; width <= 16; width = width == 1 ? 4 : 2 * width) {
        for (trace_quality quality = TRACE_QUALITY_LOW; quality <= TRACE_QUALITY_MEDIUM; ++quality) {
            trace_tracer *tracer = stage_trace(s, "embree", width, quality, 2);
            same_answers(tracer, &set, &expected, any, TRACE_COHERENT);
            same_answers(tracer, &set, &expected, any, TRACE_INCOHERENT);
            same_answers_mixed(tracer, &set, &expected, any, TRACE_COHERENT);
        }
    }
}

UNIT_TEST(one_answer_on_everything) {
    stage s = stage_open();
    add_everything(&s);
    stage_embree(&s, 1);
    one_answer(&s, random_rays(fewer(10003)));
    one_answer(&s, edge_rays(s.world, fewer(10003)));
    one_answer(&s, camera_rays(100));
}

/* Twice the same mesh, meshes in one plane, meshes through each other: ties everywhere. */
UNIT_TEST(one_answer_on_ties) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 40, 0.05, 0.5, 0, 0);
    add_ball(&s, FATHOM_ROOT, 40, 0.05, 0.5, 0, 0);
    add_ball(&s, FATHOM_ROOT, 33, 0.03, 0.6, 0.2, 0);
    add_grid(&s, 64, 0);
    add_grid(&s, 64, 0);
    add_grid(&s, 37, 0);
    const double center[3] = {0, 0, 0}, u[3] = {0.9, 0, 0}, v[3] = {0, 0.9, 0};
    add_quad(&s, FATHOM_ROOT, center, u, v, 0);
    add_quad(&s, FATHOM_ROOT, center, v, u, 0);
    add_sphere(&s, FATHOM_ROOT, 0.5, 0.5, 0, 0.3, 0);
    add_sphere(&s, FATHOM_ROOT, 0.5, 0.5, 0, 0.3, 0);
    stage_embree(&s, 1);
    one_answer(&s, random_rays(fewer(10003)));
    one_answer(&s, edge_rays(s.world, fewer(10003)));
    one_answer(&s, camera_rays(100));
}

int main(void) { return unit_main(NULL, NULL); }
