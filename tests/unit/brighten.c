/* Materials that send out more light than they get are told, with the sum that they reflect and pass. */
#include "integrate/parts.h"
#include "unit_scene.h"

#include <string.h>

static fathom_material classic(float d, float r, float t) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_CLASSIC;
    for (int c = 0; c < 3; ++c) m.k_d[c] = d, m.k_r[c] = r, m.k_t[c] = t;
    return m;
}

static fathom_material shiny(float d, float s, fathom_specular specular, float n) {
    fathom_material m = classic(d, 0, 0);
    m.specular = specular, m.shininess = n;
    for (int c = 0; c < 3; ++c) m.k_s[c] = s;
    return m;
}

static fathom_id add(const char *name, const fathom_material *m) { return new_material(scene, name, m); }

static void add_sphere(fathom_id group, fathom_id material) {
    fathom_sphere sphere = default_sphere();
    sphere.material = material;
    assert_ok(context, fathom_scene_add_sphere(scene, group, &sphere, NULL));
}

static void tells(const char *expected) {
    char text[PARTS_TEXT] = "";
    if (!expected) {
        assert_false(parts_brighten(scene, FATHOM_INTEGRATOR_PATH, text));
        return;
    }
    assert_true(parts_brighten(scene, FATHOM_INTEGRATOR_PATH, text));
    if (!strstr(text, expected)) fail_msg("\"%s\", expected \"%s\"", text, expected);
}

/* The highlights send 2 / (n + 2) and 8 (2^(-n/2) + n) / ((n + 2)(n + 4)) of k_s, which for n = 6 are 1/4 and
 * 0.6125. */
UNIT_TEST(sums_follow_the_formulas) {
    fathom_material both = classic(0.6f, 0, 0), fresnel = classic(0.5f, 1, 1),
                    weak = classic(0.6f, 0.3f, 0.2f), faint = classic(0.5f, 0.1f, 0.6f);
    both.lit_from_behind = true, fresnel.fresnel = weak.fresnel = faint.fresnel = true;
    const struct {
        fathom_material m;
        const char *expected; /* NULL: nothing is told */
    } cases[] = {
        {classic(0.5f, 0, 0), NULL},
        {classic(1, 0, 0), NULL},
        {classic(0.7f, 0.2f, 0.1f), NULL}, /* rounded, it is a little more than 1 */
        {classic(0.6f, 0.3f, 0.2f), "\"m\" reflects 10 % more"},
        {classic(0.5f, 0, 1), "50 % more"},
        {both, "20 % more"},
        {fresnel, "50 % more"},
        {weak, NULL},        /* at most 0.6 + 0.3: F is 0.04 to 1, and 0.04 0.3 + 0.96 0.2 is less */
        {faint, "8 % more"}, /* 0.5 + 0.04 0.1 + 0.96 0.6 */
        {shiny(0.9f, 0.8f, FATHOM_SPECULAR_PHONG, 6), "10 % more"},
        {shiny(0.9f, 0.8f, FATHOM_SPECULAR_BLINN, 6), "39 % more"},
        {shiny(0.75f, 1, FATHOM_SPECULAR_PHONG, 6), NULL},
        {shiny(0.9f, 0.8f, FATHOM_SPECULAR_NONE, 6), NULL},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        add_sphere(FATHOM_ROOT, add("m", &cases[i].m));
        tells(cases[i].expected);
        char text[PARTS_TEXT];
        assert_false(parts_brighten(scene, FATHOM_INTEGRATOR_CLASSIC, text));
        open_scene(state);
    }
}

UNIT_TEST(materials_in_use_are_counted) {
    const fathom_material bad = classic(0.9f, 0.2f, 0), worse = classic(0.9f, 0, 0.9f),
                          fine = classic(0.5f, 0, 0);
    fathom_material other = bad;
    other.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    const fathom_id first = add("bad", &bad), second = add("worse", &worse), third = add("fine", &fine);
    add_sphere(FATHOM_ROOT, third), add_sphere(FATHOM_ROOT, add("other", &other));
    tells(NULL);
    add_sphere(FATHOM_ROOT, first), add_sphere(FATHOM_ROOT, first);
    tells("get brighter at each hit: 1; \"bad\" reflects 10 % more");
    fathom_instance instance = default_instance();
    assert_ok(context, fathom_scene_add_group(scene, "g", &instance.group));
    add_sphere(instance.group, third);
    instance.material = second;
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    tells("get brighter at each hit: 2; \"worse\" reflects 80 % more");
}

/* What images give is not known. */
UNIT_TEST(images_count_as_black) {
    fathom_texture t = default_texture();
    t.bytes = "x", t.byte_count = 1;
    fathom_material m = shiny(1, 1, FATHOM_SPECULAR_PHONG, 6);
    assert_ok(context, fathom_scene_add_texture(scene, &t, &m.maps[FATHOM_MAP_COLOR].texture));
    add_sphere(FATHOM_ROOT, add("m", &m));
    tells(NULL);
    m.k_r[1] = 0.9f;
    add_sphere(FATHOM_ROOT, add("n", &m));
    tells("1; \"n\" reflects 15 % more");
    m.maps[FATHOM_MAP_SPECULAR_COLOR] = m.maps[FATHOM_MAP_COLOR], m.k_t[1] = 0.2f;
    add_sphere(FATHOM_ROOT, add("o", &m));
    tells("2; \"n\" reflects 15 % more"); /* o: 1.1 */
}

int main(void) { return unit_main_each(open_scene, NULL); }
