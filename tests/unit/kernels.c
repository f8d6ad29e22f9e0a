/* The kernels of every instruction set give the same bits. */
#include "shade/kernels.h"
#include "random.h"
#include "unit.h"

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
        for (int c = 0; c < 3; ++c) s->weight[c][i] = (float)between(0, 1);
        s->entering[i] = between(0, 1) < 0.5 ? ~0u : 0, s->smooth[i] = between(0, 1) < 0.5 ? ~0u : 0;
        s->material[i] = (uint32_t)between(0, 4);
        s->slot[i] = (uint32_t)i;
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
    lanes3 camera;
    material_block materials;
    light_block lit[3];
    bend_block mirrored, refracted;
} outputs;

static void run(const shade_kernels *k, const scene_named_material *table, const surface_block *s,
                const fathom_light lights[3], const double at[2][LANES], outputs *out) {
    fathom_camera camera;
    shade_camera prepared;
    memset(out, 0, sizeof *out);
    fathom_camera_default(&camera);
    camera_prepare(&camera, 640, 480, vec_f64(0, 0, 0), &prepared);
    k->camera_directions(&prepared, at[0], at[1], out->camera);
    k->material_gather(table, s, &out->materials);
    for (int i = 0; i < 3; ++i) {
        shade_light light;
        light_prepare(&lights[i], vec_f64(0, 0, 0), &light);
        k->light_evaluate(&light, s, &out->materials, i != 1, &out->lit[i]);
    }
    k->bend_rays(s, &out->materials, &out->mirrored, &out->refracted);
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

static void same_bits_from_all(void **state) {
    (void)state;
    unsigned sets = 0;
    while (shade_kernels_at(sets)) ++sets;
    assert_ptr_equal(shade_kernels_at(sets - 1), shade_kernels_best());
    for (int round = 0; round < 3000; ++round) {
        static scene_named_material table[4];
        static surface_block s;
        static outputs plain, wide;
        fathom_light lights[3];
        double at[2][LANES];
        random_surface(&s);
        random_materials(table);
        random_lights(lights);
        for (int i = 0; i < LANES; ++i) at[0][i] = between(0, 640), at[1][i] = between(0, 480);
        for (int i = 0; i < LANES && round % 2; ++i) s.material[i] = s.material[0];
        run(shade_kernels_at(0), table, &s, lights, at, &plain);
        for (unsigned k = 1; k < sets; ++k) {
            run(shade_kernels_at(k), table, &s, lights, at, &wide);
            assert_memory_equal(&plain, &wide, sizeof plain);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(same_bits_from_all)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
