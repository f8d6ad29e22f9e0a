/* The kernels of every instruction set give the same bits. */
#include "integrate/kernels.h"
#include "camera/camera.h"
#include "defaults.h"
#include "film/pixel_sums.h"
#include "math/lane.h"
#include "random.h"
#include "surface/half.h"
#include "surface/kernels.h"
#include "surface/placed.h"
#include "unit.h"
#include "variants.h"

VARIANTS(material_kernels)
VARIANTS(light_kernels)
VARIANTS(surface_kernels)
VARIANTS(integrate_kernels)
VARIANTS(film_kernels)
VARIANTS(camera_kernels)

static random_state random_numbers = {7};

static double between(double low, double high) { return random_in(&random_numbers, low, high); }

static vec3_f32 unit(void) {
    vec3_f64 v;
    do v = vec_f64(between(-1, 1), between(-1, 1), between(-1, 1));
    while (dot_f64(v, v) > 1 || dot_f64(v, v) < 1e-4);
    return narrow(normalize_f64(v));
}

static void put(lanes3 to, int i, vec3_f32 v) { to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z; }

/* Points of any size, seen and lit from all sides, some along the surface. */
static void random_surface(surface_block *s) {
    memset(s, 0, sizeof *s);
    s->count = LANES;
    for (int i = 0; i < LANES; ++i) {
        float size = (float)random_log(&random_numbers, 1e-6, 1e6);
        vec3_f32 ng = unit();
        put(s->p, i, scale_f32(size, unit()));
        put(s->ng, i, ng);
        put(s->ns, i, between(0, 1) < 0.5 ? ng : unit());
        put(s->v, i, between(0, 1) < 0.1 ? neg_f32(ng) : unit());
        put(s->lift, i, scale_f32(size * 1e-3f, unit()));
        s->offset[i] = size * 1e-6f;
        s->entering[i] = between(0, 1) < 0.5 ? ~0u : 0, s->smooth[i] = between(0, 1) < 0.5 ? ~0u : 0;
        s->material[i] = (uint32_t)between(0, 4);
    }
}

static void random_materials(scene_named_material table[4]) {
    static const fathom_specular kinds[] = {FATHOM_SPECULAR_PHONG, FATHOM_SPECULAR_BLINN,
                                            FATHOM_SPECULAR_NONE, FATHOM_SPECULAR_PHONG};
    for (int k = 0; k < 4; ++k) {
        fathom_material *m = &table[k].value;
        memset(&table[k], 0, sizeof table[k]);
        fathom_material_default(m);
        m->specular = kinds[k];
        m->shininess = (float)random_log(&random_numbers, 0.1, 1e6);
        m->ior = (float)random_log(&random_numbers, 0.1, 10);
        m->fresnel = k % 2, m->lit_from_behind = k == 3;
        for (int c = 0; c < 3; ++c)
            m->k_s[c] = m->k_r[c] = m->k_t[c] = (float)between(0, 1), m->k_d[c] = (float)between(0, 1);
    }
}

typedef struct outputs {
    bsdf_block bsdf;
    light_block lit[3];
    bsdf_value values[3];
    lanes3 gains[3];
    scatter_block mirrored, refracted;
    bool lights[3];
} outputs;

/* Surfaces, lights and materials with the kernels of set k. */
static void run(unsigned k, const scene_named_material *table, const surface_block *s,
                const fathom_light lights[3], const light_surface near[3], outputs *out) {
    static const float ambient[3] = {0.25f, 0.5f, 1};
    path_block path;
    bsdf bsdfs[4];
    const bsdf *at[LANES];
    memset(out, 0, sizeof *out);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) path.weight[c][i] = 1.0f / (float)(1 + c + i);
    }
    for (int i = 0; i < 4; ++i) bsdf_prepare(&table[i].value, ambient, &bsdfs[i]);
    for (int i = 0; i < LANES; ++i) at[i] = &bsdfs[s->material[i]];
    material_kernels_at(k)->make(at, &out->bsdf);
    for (int i = 0; i < 3; ++i) {
        shade_light light;
        light_block *lit = &out->lit[i];
        light_prepare(&lights[i], vec_f64(0, 0, 0), &light);
        light.surfaces = near, light.surface_count = i ? 3 : 0;
        light_kernels_at(k)->sample(&light, s->p, lit);
        out->lights[i] =
            material_kernels_at(k)->evaluate(s, &out->bsdf, lit->direction, lit->falloff, &out->values[i]);
        surface_kernels_at(k)->starts(s, lit->direction, out->values[i].behind, lit->origin);
        light_kernels_at(k)->aim(&light, lit);
        if (out->lights[i]) integrate_kernels_at(k)->gains(&path, lit, &out->values[i], out->gains[i]);
    }
    material_kernels_at(k)->scatter(s, &out->bsdf, &out->mirrored, &out->refracted);
}

static void random_lights(fathom_light lights[3]) {
    static const fathom_light_type types[] = {FATHOM_LIGHT_POINT, FATHOM_LIGHT_DIRECTIONAL,
                                              FATHOM_LIGHT_SPOT};
    for (int k = 0; k < 3; ++k) {
        fathom_light_default(&lights[k]);
        lights[k].type = types[k];
        for (int c = 0; c < 3; ++c)
            lights[k].position[c] = between(-10, 10), lights[k].direction[c] = between(-1, 1);
        lights[k].inner_angle = 0.2f, lights[k].outer_angle = 2;
    }
}

/* Two that hold the light, in an edge, and one beside it. */
static void random_near(light_surface near[3]) {
    for (int k = 0; k < 3; ++k) {
        near[k] = (light_surface){unit(), k < 2 ? 0 : (float)between(-1e-4, 1e-4), 1e-4f, 1e-5f};
    }
}

UNIT_TEST(same_bits_from_all) {
    unsigned sets = 0;
    while (material_kernels_at(sets)) ++sets;
    assert_ptr_equal(material_kernels_at(sets - 1), material_kernels_best());
    assert_ptr_equal(surface_kernels_at(sets - 1), surface_kernels_best());
    assert_ptr_equal(light_kernels_at(sets - 1), light_kernels_best());
    for (int round = 0; round < 3000; ++round) {
        static scene_named_material table[4];
        static surface_block s;
        static outputs plain, wide;
        fathom_light lights[3];
        light_surface near[3];
        random_near(near);
        random_surface(&s);
        random_materials(table);
        random_lights(lights);
        for (int i = 0; i < LANES && round % 2; ++i) s.material[i] = s.material[0];
        run(0, table, &s, lights, near, &plain);
        for (unsigned k = 1; k < sets; ++k) {
            run(k, table, &s, lights, near, &wide);
            assert_memory_equal(&plain, &wide, sizeof plain);
        }
    }
}

/* ---- triangles ---- */

#define TRIANGLES 40
#define VERTICES 30

typedef struct hit_case {
    float positions[5 * VERTICES + 4], normals[3 * VERTICES + 4];
    uint32_t indices[3 * TRIANGLES], normal_indices[3 * TRIANGLES], triangle[LANES];
    lanes3 org, dir;
    fathom_mesh mesh;
} hit_case;

static void random_hits(hit_case *c, int round) {
    double size = random_log(&random_numbers, 1e-12, 1e12);
    memset(c, 0, sizeof *c);
    for (int i = 0; i < 5 * VERTICES; ++i) c->positions[i] = (float)between(-size, size);
    for (int i = 0; i < VERTICES; ++i) {
        vec3_f32 n = scale_f32(round % 3 ? 1 : (float)random_log(&random_numbers, 1e-30, 1e3), unit());
        c->normals[3 * i] = n.x, c->normals[3 * i + 1] = n.y, c->normals[3 * i + 2] = n.z;
    }
    for (int i = 0; i < 3 * TRIANGLES; ++i) {
        c->indices[i] = (uint32_t)between(0, VERTICES);
        c->normal_indices[i] = (uint32_t)between(0, VERTICES);
    }
    for (int i = 0; i < LANES; ++i) {
        c->triangle[i] = (uint32_t)between(0, TRIANGLES);
        put(c->org, i, scale_f32((float)size, unit()));
        put(c->dir, i, unit());
    }
    c->mesh = (fathom_mesh){.positions = c->positions,
                            .position_stride = (round % 2 ? 3 : 5) * sizeof(float),
                            .vertex_count = VERTICES,
                            .indices = c->indices,
                            .triangle_count = TRIANGLES,
                            .normals = round % 5 ? c->normals : NULL,
                            .normal_stride = 3 * sizeof(float),
                            .normal_count = VERTICES,
                            .normal_indices = round % 7 ? NULL : c->normal_indices};
}

typedef struct hit_outputs {
    facet_block facets;
    local_block local;
    surface_block surface;
} hit_outputs;

static void find_hits(const surface_kernels *k, const hit_case *c, hit_outputs *out) {
    memset(out, 0, sizeof *out);
    k->facet_gather(&c->mesh, c->triangle, c->org, c->dir, &out->facets, &out->local);
    memcpy(out->local.ray, c->dir, sizeof c->dir);
    k->facets(&out->facets, true, &out->local);
    k->surfaces(&out->local, true, &out->surface);
}

/* What is gathered is what the mesh says, and the same is made of it. */
UNIT_TEST(same_hits_from_all) {
    for (int round = 0; round < 3000; ++round) {
        static hit_case c;
        static hit_outputs plain, wide;
        random_hits(&c, round);
        find_hits(surface_kernels_at(0), &c, &plain);
        for (int i = 0; i < LANES; ++i) {
            size_t vertex = c.indices[3 * c.triangle[i] + 2] * (c.mesh.position_stride / sizeof(float));
            for (int axis = 0; axis < 3; ++axis)
                assert_true(plain.facets.corner[2][axis][i] == c.positions[vertex + (size_t)axis]);
        }
        for (unsigned k = 1; surface_kernels_at(k); ++k) {
            find_hits(surface_kernels_at(k), &c, &wide);
            assert_memory_equal(&plain, &wide, sizeof plain);
        }
    }
}

/* ---- instances ---- */

static world_instance random_instance(void) {
    world_instance instance = {.id = 0};
    affine_f64 map;
    do {
        const double size = random_log(&random_numbers, 1e-6, 1e6);
        for (int i = 0; i < 12; ++i) map.m[i / 4][i % 4] = between(-size, size);
    } while (!world_instance_set(&instance, &map));
    return instance;
}

static placed_hit random_hit(void) {
    const double size = random_log(&random_numbers, 1e-6, 1e6);
    return (placed_hit){.p = scale_f64(size, widen(unit())),
                        .n = widen(unit()),
                        .self_hit = size * 1e-6,
                        .ns = unit(),
                        .lift = scale_f32((float)size * 1e-3f, unit())};
}

static placed_hit hit_of(const local_block *b, unsigned i) {
    return (placed_hit){lane_f64(b->p, i), lane_f64(b->n, i), b->self_hit[i], lane_f32(b->ns, i),
                        lane_f32(b->lift, i)};
}

static void is_hit(placed_hit a, placed_hit b) {
    assert_memory_equal(&a.p, &b.p, sizeof a.p);
    assert_memory_equal(&a.n, &b.n, sizeof a.n);
    assert_true(a.self_hit == b.self_hit);
    assert_memory_equal(&a.ns, &b.ns, sizeof a.ns);
    assert_memory_equal(&a.lift, &b.lift, sizeof a.lift);
}

/* Lanes of a block have the bits that they have one by one; other lanes stay. */
static void instances_are_left_alike(const surface_kernels *k) {
    const world_instance instance = random_instance();
    const uint32_t lanes = (uint32_t)between(0, 1u << LANES);
    static local_block b;
    for (unsigned i = 0; i < LANES; ++i) {
        const placed_hit hit = random_hit();
        put_lane_f64(b.p, i, hit.p), put_lane_f64(b.n, i, hit.n), b.self_hit[i] = hit.self_hit;
        put_lane_f32(b.ns, i, hit.ns), put_lane_f32(b.lift, i, hit.lift);
        put_lane_f64(b.org, i, hit.p), put_lane_f64(b.dir, i, hit.n);
    }
    const local_block before = b;
    k->hits_to_world(&instance, lanes, &b);
    k->rays_to_object(&instance, &b);
    for (unsigned i = 0; i < LANES; ++i) {
        const placed_hit hit = hit_of(&before, i);
        const vec3_f64 org = placed_point(instance.to_object, hit.p),
                       dir = placed_vector(instance.to_object, hit.n), own_org = lane_f64(b.org, i),
                       own_dir = lane_f64(b.dir, i);
        is_hit(hit_of(&b, i), lanes >> i & 1 ? placed_to_world(&instance, hit) : hit);
        assert_memory_equal(&own_org, &org, sizeof org);
        assert_memory_equal(&own_dir, &dir, sizeof dir);
    }
}

UNIT_TEST(instances_are_left_alike_by_all) {
    for (unsigned set = 0; surface_kernels_at(set); ++set) {
        for (int round = 0; round < 1000; ++round) instances_are_left_alike(surface_kernels_at(set));
    }
}

/* ---- quads ---- */

#define QUADS 5

typedef struct quad_case {
    world_quad quads[QUADS];
    uint32_t primitive[LANES];
    lanes3 org, dir;
} quad_case;

/* Parallelograms, that rays are aimed at; all lanes at one in every third round. */
static void random_quads(quad_case *c, int round) {
    float size = (float)random_log(&random_numbers, 1e-12, 1e12);
    for (int q = 0; q < QUADS; ++q) {
        vec3_f32 center = scale_f32(size, unit()), u = scale_f32(size, unit()), v = scale_f32(size, unit());
        for (int k = 0; k < 4; ++k)
            c->quads[q].corner[k] = madd_f32(madd_f32(center, k % 3 ? 1 : -1, u), k > 1 ? 1 : -1, v);
    }
    for (int i = 0; i < LANES; ++i) {
        c->primitive[i] = round % 3 ? (uint32_t)between(0, QUADS) : 3;
        const vec3_f32 *corner = c->quads[c->primitive[i]].corner;
        vec3_f32 org = scale_f32(3 * size, unit());
        vec3_f32 target = madd_f32(corner[0], (float)between(0, 1), sub_f32(corner[1], corner[0]));
        target = madd_f32(target, (float)between(0, 1), sub_f32(corner[3], corner[0]));
        put(c->org, i, org), put(c->dir, i, sub_f32(target, org));
    }
}

static void find_quads(const surface_kernels *k, const quad_case *c, hit_outputs *out) {
    memset(out, 0, sizeof *out);
    k->quad_gather(c->quads, c->primitive, c->org, c->dir, &out->facets, &out->local);
    memcpy(out->local.ray, c->dir, sizeof c->dir);
    k->facets(&out->facets, true, &out->local);
    k->surfaces(&out->local, true, &out->surface);
}

static vec3_f64 lane_of(const lanes3 from, int i) {
    return vec_f64((double)from[0][i], (double)from[1][i], (double)from[2][i]);
}

/* The half is the one that a hit by itself is given: a pixel does not depend on its neighbours. */
static void check_halves(const quad_case *c, const hit_outputs *out) {
    for (int i = 0; i < LANES; ++i) {
        const vec3_f32 *v = c->quads[c->primitive[i]].corner;
        bool second = half_is_second(widen(v[0]), widen(v[1]), widen(v[2]), widen(v[3]), lane_of(c->org, i),
                                     lane_of(c->dir, i));
        vec3_f64 expected = widen(v[second ? 2 : 0]);
        vec3_f64 got = {(double)out->facets.corner[0][0][i], (double)out->facets.corner[0][1][i],
                        (double)out->facets.corner[0][2][i]};
        assert_true(got.x == expected.x && got.y == expected.y && got.z == expected.z);
    }
}

UNIT_TEST(same_halves_from_all) {
    for (int round = 0; round < 3000; ++round) {
        static quad_case c;
        static hit_outputs plain, wide;
        random_quads(&c, round);
        find_quads(surface_kernels_at(0), &c, &plain);
        check_halves(&c, &plain);
        for (unsigned k = 1; surface_kernels_at(k); ++k) {
            find_quads(surface_kernels_at(k), &c, &wide);
            assert_memory_equal(&plain, &wide, sizeof plain);
        }
    }
}

/* ---- rays ---- */

typedef struct ray_case {
    shade_camera camera;
    uint32_t left, top;
    square_samples at;
    trace_hits hits;
    light_block light;
    uint32_t slot[LANES];
    unsigned lanes;
} ray_case;

#define SLOTS 64

typedef struct ray_outputs {
    trace_rays camera, shadow;
    path_block path;
    uint32_t met, gaining;
    float radiance[3][SLOTS];
    double sums[SLOTS];
    float stored[4][5];
} ray_outputs;

static void random_ray_case(ray_case *c, int round) {
    fathom_camera camera = default_camera();
    memset(c, 0, sizeof *c);
    camera.h *= random_log(&random_numbers, round % 4 ? 0.1 : 1e-40, round % 4 ? 10 : 1e40);
    camera_prepare(&camera, 640, 480, vec_f64(1, 2, 3), &c->camera);
    c->left = (uint32_t)between(0, 160) * 4, c->top = (uint32_t)between(0, 120) * 4;
    c->lanes = round % 3 ? LANES : 1 + (unsigned)between(0, LANES);
    c->at.alike = round % 2;
    for (uint32_t i = 0; i < LANES; ++i) {
        c->at.x[i] = between(0, 1), c->at.y[i] = between(0, 1);
        c->hits.geometry[i] = between(0, 1) < 0.5 ? FATHOM_NONE : i;
        put(c->light.origin, (int)i, unit());
        put(c->light.direction, (int)i, unit());
        c->light.distance[i] = (float)between(-0.2, 1);
        c->slot[i] = round % 2 ? 7 + i : (i * 13 + 5) % SLOTS;
        for (int k = 0; k < 3; ++k) c->light.radiance[k][i] = fmaxf((float)between(-1, 1), 0);
    }
}

static void run_rays(unsigned set, const ray_case *c, ray_outputs *out) {
    const integrate_kernels *k = integrate_kernels_at(set);
    const film_kernels *film = film_kernels_at(set);
    shadow_block shadows;
    memset(out, 0, sizeof *out);
    memcpy(shadows.gain, c->light.radiance, sizeof shadows.gain);
    memcpy(shadows.slot, c->slot, sizeof shadows.slot);
    camera_kernels_at(set)->rays(&c->camera, 0.5f, c->left, c->top, &c->at, &out->camera);
    k->begin_paths(48, 3, &out->path);
    out->met = k->met(&c->hits);
    out->gaining = k->shadow_rays(&c->light, c->light.radiance, 0.5f, &out->shadow);
    trace_rays answered = out->shadow;
    for (int i = 0; i < LANES; i += 3) answered.t_far[i] = -INFINITY;
    k->add_seen(&answered, &shadows, c->lanes,
                (float *const[]){out->radiance[0], out->radiance[1], out->radiance[2]});
    for (int square = 0; square < SLOTS; square += LANES)
        film->add_samples(out->radiance[0] + square, out->sums + square);
    film->store_square(out->sums + 16, 0.25, 5, out->stored[0]);
}

static void is_right(const ray_case *c, const ray_outputs *out) {
    for (uint32_t i = 0; i < LANES; ++i) {
        const light_block *l = &c->light;
        bool gains = l->radiance[0][i] + l->radiance[1][i] + l->radiance[2][i] > 0 && l->distance[i] > 0;
        const uint32_t at = c->at.alike ? 0 : i;
        const double x = c->left + i % 4 + c->at.x[at], y = c->top + i / 4 + c->at.y[at];
        vec3_f32 d = camera_direction(&c->camera, x, y);
        assert_int_equal(out->met >> i & 1, c->hits.geometry[i] != FATHOM_NONE);
        assert_int_equal(out->gaining >> i & 1, gains);
        assert_true(out->camera.dir_x[i] == d.x && out->camera.dir_y[i] == d.y &&
                    out->camera.dir_z[i] == d.z);
        /* Double's root, then one rounding: the quick root may turn it. */
        vec3_f64 exact = normalize_f64(camera_towards(&c->camera, x, y));
        assert_true(length_f64(sub_f64(exact, widen(d))) < 0x1p-23);
        bool seen = i < c->lanes && i % 3 && out->shadow.t_far[i] >= 0;
        assert_true(out->radiance[1][c->slot[i]] == (seen ? l->radiance[1][i] : 0));
        assert_true(out->sums[c->slot[i]] == (double)out->radiance[0][c->slot[i]]);
        assert_true((double)out->stored[i / 4][i % 4] == 0.25 * out->sums[16 + i]);
    }
}

UNIT_TEST(same_rays_from_all) {
    for (int round = 0; round < 3000; ++round) {
        static ray_case c;
        static ray_outputs plain, wide;
        random_ray_case(&c, round);
        run_rays(0, &c, &plain);
        is_right(&c, &plain);
        for (unsigned k = 1; integrate_kernels_at(k); ++k) {
            run_rays(k, &c, &wide);
            assert_memory_equal(&plain, &wide, sizeof plain);
        }
    }
}

enum { ROWS = 9 };

/* Lanes go in order behind those that are there, and no other number changes. */
static void appends_lanes(unsigned set, uint32_t lanes, unsigned at, bool in_place) {
    _Alignas(64) uint32_t from[ROWS + 1][LANES], to[ROWS + 1][LANES], right[ROWS + 1][LANES];
    for (uint32_t i = 0; i < (ROWS + 1) * LANES; ++i)
        from[i / LANES][i % LANES] = 1000 + i, to[i / LANES][i % LANES] = in_place ? 1000 + i : i;
    memcpy(right, to, sizeof right);
    for (unsigned i = 0, k = at; i < LANES; ++i) {
        if (!(lanes >> i & 1)) continue;
        for (int r = 0; r < ROWS; ++r) right[r][k] = from[r][i];
        ++k;
    }
    integrate_kernels_at(set)->append(in_place ? to : from, ROWS, lanes, to, at);
    /* In place, only what is appended has to be right. */
    const unsigned count = (unsigned)__builtin_popcount(lanes);
    for (int r = 0; in_place && r < ROWS; ++r) assert_memory_equal(to[r], right[r], count * sizeof **to);
    if (!in_place) assert_memory_equal(to, right, sizeof right);
}

UNIT_TEST(lanes_are_appended_in_order_by_all) {
    for (unsigned set = 0; integrate_kernels_at(set); ++set) {
        for (uint32_t lanes = 0; lanes < 1u << LANES; lanes += 1 + lanes % 7) {
            const unsigned count = (unsigned)__builtin_popcount(lanes);
            for (unsigned at = 0; at + count <= LANES; ++at) appends_lanes(set, lanes, at, false);
            appends_lanes(set, lanes, 0, true);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
