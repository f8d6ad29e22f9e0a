/* Shaders that are made sixteen at a time. */
#include "material/plain.h"
#include "random.h"
#include "unit.h"
#include "variants.h"

VARIANTS(plain_kernels)

static fathom_material any_plain(random_state *r) {
    fathom_material m;
    fathom_material_default(&m);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    for (int c = 0; c < 3; ++c) {
        m.base_color[c] = random_bits(r) % 5 ? (float)random_unit(r) : 0;
        m.specular_color[c] = (float)random_in(r, 0, 30);
        m.emissive[c] = (float)random_unit(r);
    }
    m.emissive_strength = (float)random_log(r, 1, 1e35);
    m.metallic = (float)(random_bits(r) % 3) / 2 * (float)random_unit(r);
    m.roughness = random_bits(r) % 8 ? (float)random_unit(r) : 0;
    m.specular_factor = random_bits(r) % 8 ? (float)random_unit(r) : 0;
    m.ior = random_bits(r) % 8 ? (float)random_in(r, 1, 3) : 0;
    m.priority = (uint32_t)(random_bits(r) % 4);
    return m;
}

UNIT_TEST(shaders_of_a_block_are_those_made_one_by_one) {
    random_state r = {31};
    const plain_kernels *kernels;
    for (unsigned set = 0; (kernels = plain_kernels_at(set)); ++set) {
        for (int trial = 0; trial < 500; ++trial) {
            shader made[LANES], one[LANES];
            plain_block b = {.lanes = 0};
            for (unsigned i = 0; i < LANES; ++i) {
                const fathom_material m = any_plain(&r);
                shader_prepare(&m, &one[i]);
                assert_true(plain_add(&b, i, &m, &made[i]));
            }
            plain_finish(&b, kernels, made);
            for (unsigned i = 0; i < LANES; ++i)
                assert_memory_equal(&made[i], &one[i], offsetof(shader, stretch));
        }
    }
}

UNIT_TEST(materials_with_more_lobes_are_not_plain) {
    static const size_t members[] = {
        offsetof(fathom_material, transmission),   offsetof(fathom_material, clearcoat),
        offsetof(fathom_material, sheen_color[1]), offsetof(fathom_material, anisotropy),
        offsetof(fathom_material, iridescence),    offsetof(fathom_material, diffuse_transmission)};
    random_state r = {37};
    plain_block b = {.lanes = 0};
    shader out;
    for (size_t k = 0; k < sizeof members / sizeof *members; ++k) {
        fathom_material m = any_plain(&r);
        const float some = 0.1f;
        memcpy((char *)&m + members[k], &some, sizeof some);
        assert_false(plain_add(&b, 0, &m, &out));
    }
    fathom_material m = any_plain(&r);
    m.opacity = 0.9f;
    assert_false(plain_add(&b, 0, &m, &out));
    m = any_plain(&r), m.multiscatter = false;
    assert_false(plain_add(&b, 0, &m, &out));
    fathom_material_default(&m);
    assert_false(plain_add(&b, 0, &m, &out));
    assert_int_equal(b.lanes, 0);
}

int main(void) { return unit_main(NULL, NULL); }
