/* The path integrator and the reference render one image. Each pair of renders alarms falsely once in 100,000
 * seeds, which are fixed; sums in float err by the allowance of `fathom validate --light`. */
#include "image/image.h"
#include "random.h"
#include "render.h"
#include "scene/scene.h"
#include "unit_folder.h"
#include "verify/laws/laws.h"

static const laws_pair options = {
    .across = 4, .down = 4, .depth = 6, .samples = 1 << 17, .seed = 1, .threads = 2, .allowance = 2e-5};

static fathom_material metallic(float metal, float roughness) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = metal, m.roughness = roughness, m.multiscatter = false;
    m.base_color[1] = 0.5f;
    return m;
}

static fathom_material classic_glass(void) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_r[c] = m.k_t[c] = 1;
    m.fresnel = true;
    return m;
}

/* A floor under a sky and a wide lamp. */
static stage room_open(void) {
    stage s = stage_open(32, 32);
    const float sky[3] = {0.2f, 0.3f, 0.4f};
    assert_ok(s.context, fathom_scene_set_background(s.scene, sky));
    stage_plane(&s, (double[3]){0, -1.2, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.6f));
    stage_quad(&s, (double[3]){0, 4, 0}, (double[3]){3, 0, 0}, (double[3]){0, 0.5, 2}, stage_emitter(&s, 1));
    stage_camera(&s, (double[3]){0, 0.5, 4}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7);
    return s;
}

static void compare_by(const laws_pair *o, stage *s, const char *what) {
    laws_difference d;
    assert_ok(s->context, fathom_scene_check(s->scene));
    assert_ok(s->context, laws_pair_run(s->context, s->scene, o, &d));
    if (d.p < 1e-5)
        fail_msg("%s: p %g, path less reference %g +- %g", what, d.p, d.relative, d.relative_error);
}

static void compare(stage *s, const char *what) { compare_by(&options, s, what); }

/* Facets at the outline refract rays to between their horizon and that of the shading normal. A third vertex
 * would end the path. */
UNIT_TEST(refracted_rays_cross_the_facets_of_smooth_meshes) {
    stage s = stage_open(32, 32);
    laws_pair o = options;
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_t[c] = 1;
    m.ior = 1.05f, o.depth = 2, o.across = o.down = 8;
    assert_ok(s.context, fathom_scene_set_background(s.scene, (const float[3]){1, 1, 1}));
    stage_mesh_sphere(&s, FATHOM_ROOT, 2, 4, stage_material(&s, &m));
    stage_camera(&s, (double[3]){0.4, 1.2, 4}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.6);
    compare_by(&o, &s, "an octahedron");
}

/* Coarse, so that many directions lie between the shading normal's horizon and the facet's. */
UNIT_TEST(smooth_meshes_follow_one_rule_of_sides) {
    fathom_material lambert, behind, thin = metallic(0, 0.8f), solid = metallic(0, 0);
    fathom_material_default(&lambert);
    fathom_material_default(&behind);
    behind.lit_from_behind = true;
    thin.transmission = solid.transmission = solid.thickness = 1;
    const struct {
        const char *name;
        fathom_material m;
    } cases[] = {{"Lambert", lambert},
                 {"lit from behind", behind},
                 {"metal", metallic(1, 0.8f)},
                 {"dielectric", metallic(0, 0.7f)},
                 {"less than the least alpha", metallic(1, 0.008f)},
                 {"thin wall", thin},
                 {"classic glass", classic_glass()},
                 {"solid glass", solid}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        stage s = room_open();
        stage_mesh_sphere(&s, FATHOM_ROOT, 6, 8, stage_material(&s, &cases[i].m));
        compare(&s, cases[i].name);
    }
}

/* Lamps, the sky and a point light through sheets that are there in part, one of which sends out light. */
UNIT_TEST(coverage_is_a_matter_of_chance) {
    stage s = room_open();
    fathom_material sheet = metallic(0, 0.7f);
    sheet.opacity = 0.4f;
    stage_point_light(&s, 1, 3, 1, 2);
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &sheet));
    stage_sphere(&s, 0, 0, 0, 0.4, stage_lambert(&s, 0.7f));
    sheet.emissive[0] = 1;
    stage_quad(&s, (double[3]){0, 2, 0}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1},
               stage_material(&s, &sheet));
    compare(&s, "coverage");
}

/* A lamp in a bulb, and a point light and a sun behind a pane, one of which is there in part. Few bounces:
 * panes are none. */
UNIT_TEST(clear_thin_walls_pass_light_straight) {
    for (uint32_t depth = 1; depth < 4; depth += 2) {
        stage s = room_open();
        fathom_material pane = metallic(0, 0);
        fathom_light sun = default_light();
        pane.transmission = 0.8f, pane.base_color[1] = 0.5f;
        s.settings.max_depth = depth;
        stage_sphere(&s, 0, 1, 0, 0.5, stage_material(&s, &pane));
        stage_sphere(&s, 0, 1, 0, 0.1, stage_emitter(&s, 5));
        pane.opacity = 0.7f;
        stage_quad(&s, (double[3]){0, 2, 0}, (double[3]){1.5, 0, 0}, (double[3]){0, 0, 1.5},
                   stage_material(&s, &pane));
        fathom_material old = classic_glass();
        old.ior = 1, old.k_t[0] = 0.5f, old.k_d[1] = 0.3f;
        stage_quad(&s, (double[3]){-1, 1.5, 0}, (double[3]){0.5, 0, 0}, (double[3]){0, 0.3, 1},
                   stage_material(&s, &old));
        stage_point_light(&s, 1, 3, 1, 2);
        sun.type = FATHOM_LIGHT_DIRECTIONAL, sun.angular_radius = 0.2f, sun.direction[1] = -1;
        assert_ok(s.context, fathom_scene_add_light(s.scene, &sun, NULL));
        compare(&s, "panes");
    }
}

/* ---- lamps with a radius ---- */

static void add_ball_lamp(stage *s, fathom_light_type type, const double at[3], float radius) {
    fathom_light light = default_light();
    light.type = type, light.radius = radius;
    light.inner_angle = 0.5f, light.outer_angle = 1;
    for (int c = 0; c < 3; ++c) light.position[c] = at[c], light.intensity[c] = 0.5f;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

/* Mirrors, glass and rough metal show a spot light, and a lamp in a bulb and one in front of it. */
UNIT_TEST(lamps_with_a_radius_show_in_what_scatters) {
    for (int k = 0; k < 3; ++k) {
        stage s = room_open();
        fathom_material pane = metallic(0, 0), m = metallic(k < 2, k ? 0 : 0.3f);
        pane.transmission = 0.8f, pane.base_color[1] = 0.5f;
        m.transmission = m.thickness = k == 2;
        m.attenuation_distance = k == 2, m.attenuation_color[1] = 0.5f;
        stage_sphere(&s, -0.5, 0, 0, 0.8, stage_material(&s, &m));
        stage_sphere(&s, 0.9, 0.5, 0, 0.5, stage_material(&s, &pane));
        add_ball_lamp(&s, FATHOM_LIGHT_POINT, (double[3]){0.9, 0.5, 0}, 0.3f);
        add_ball_lamp(&s, FATHOM_LIGHT_POINT, (double[3]){0.3, 0.2, 1}, 0.2f);
        add_ball_lamp(&s, FATHOM_LIGHT_SPOT, (double[3]){-0.5, 2, 0}, 0.3f);
        compare(&s, k ? k == 2 ? "lamps in glass" : "lamps in chrome" : "lamps in metal");
    }
}

/* One of them reaches out of the volume that the other hides in part. */
UNIT_TEST(lamps_with_a_radius_shine_in_volumes) {
    stage s = room_open();
    fathom_material drink = metallic(0, 0), ice = drink;
    drink.transmission = drink.thickness = 1, drink.ior = 1.3f, drink.priority = 1;
    drink.attenuation_distance = 0.5f, drink.attenuation_color[2] = 0.2f;
    ice.transmission = ice.thickness = 1, ice.priority = 2;
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &drink));
    stage_sphere(&s, 0.5, 0.3, 0, 0.6, stage_material(&s, &ice));
    stage_sphere(&s, -0.5, 0, 0, 0.2, stage_lambert(&s, 0.7f));
    add_ball_lamp(&s, FATHOM_LIGHT_POINT, (double[3]){0.1, 0.1, 0}, 0.3f);
    add_ball_lamp(&s, FATHOM_LIGHT_POINT, (double[3]){-0.2, 0.9, 0.3}, 0.2f);
    compare(&s, "lamps in volumes");
}

UNIT_TEST(shapes_that_cast_no_shadow_may_send_out_light) {
    stage s = room_open();
    fathom_material lamp = metallic(0, 0.7f);
    fathom_sphere sphere = default_sphere();
    lamp.emissive[1] = 1;
    sphere.radius = 0.7, sphere.material = stage_material(&s, &lamp), sphere.flags = FATHOM_CASTS_NO_SHADOW;
    stage_point_light(&s, 0, 3, 0, 2);
    assert_ok(s.context, fathom_scene_add_sphere(s.scene, FATHOM_ROOT, &sphere, NULL));
    compare(&s, "no shadow");
}

UNIT_TEST(emission_in_glass_is_as_bright_as_seen_from_outside) {
    for (int k = 0; k < 2; ++k) {
        stage s = room_open();
        fathom_material glass = metallic(0, k ? 0.8f : 0);
        glass.transmission = glass.thickness = 1;
        stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &glass));
        stage_sphere(&s, 0.2, 0, 0, 0.4, stage_emitter(&s, 2));
        compare(&s, k ? "lamp in rough glass" : "lamp in glass");
    }
}

/* ---- lobes of glTF's extensions ---- */

static void coated(fathom_material *m) { m->clearcoat = 0.8f, m->clearcoat_roughness = 0.5f; }
static void lacquered(fathom_material *m) { m->clearcoat = 1; }
static void velvet(fathom_material *m) {
    m->sheen_color[0] = 0.9f, m->sheen_color[2] = 0.4f, m->sheen_roughness = 0.4f;
    coated(m);
}
static void brushed(fathom_material *m) {
    m->metallic = 1, m->roughness = 0.4f, m->anisotropy = 0.8f, m->anisotropy_rotation = 0.6f;
}
static void filmed(fathom_material *m) { m->iridescence = 0.7f, m->iridescence_thickness_max = 450; }
static void tempered(fathom_material *m) {
    filmed(m);
    m->metallic = 1, m->iridescence_ior = 2.3f;
}
static void bubble(fathom_material *m) {
    filmed(m);
    m->roughness = 0, m->transmission = m->ior = 1;
}
static void leaf(fathom_material *m) {
    m->diffuse_transmission = 0.6f, m->diffuse_transmission_color[1] = 0.3f;
}
static void diamond(fathom_material *m) {
    m->transmission = m->thickness = 1, m->dispersion = 5, m->roughness = 0;
}
/* The cosine alone hardly meets what a smaller index sends on almost straight. */
static void frosted(fathom_material *m) {
    diamond(m);
    m->roughness = 1, m->ior = 3;
}

UNIT_TEST(lobes_of_extensions_agree) {
    laws_pair few = options;
    static const struct {
        const char *name;
        void (*set)(fathom_material *m);
    } cases[] = {{"coated", coated},   {"lacquered", lacquered}, {"velvet", velvet}, {"brushed", brushed},
                 {"filmed", filmed},   {"tempered", tempered},   {"bubble", bubble}, {"leaf", leaf},
                 {"diamond", diamond}, {"frosted", frosted}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        stage s = room_open();
        fathom_material m = metallic(0, 0.6f);
        cases[i].set(&m);
        /* Only so many tell by which colour's index light is totally reflected. */
        few.samples = cases[i].set == diamond ? 1 << 18 : 1 << 15;
        stage_point_light(&s, 1, 3, 1, 2);
        stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &m));
        compare_by(&few, &s, cases[i].name);
    }
}

static void give_back_light(laws_pair *few, const char *name, void (*set)(fathom_material *m), float metal,
                            float roughness) {
    stage s = room_open();
    fathom_material m = metallic(metal, roughness);
    m.multiscatter = true;
    if (set) set(&m);
    stage_point_light(&s, 1, 3, 1, 2);
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &m));
    compare_by(few, &s, name);
}

static void walled(fathom_material *m) { m->transmission = 0.9f; }
static void solid(fathom_material *m) {
    m->transmission = 0.5f, m->thickness = 1;
    m->diffuse_transmission = 0.5f;
}
static void tinted(fathom_material *m) { m->specular_factor = 0.7f, m->specular_color[1] = 0.2f; }

UNIT_TEST(scattering_again_agrees) {
    laws_pair few = options;
    (void)state;
    few.samples = 1 << 15;
    give_back_light(&few, "rough metal", NULL, 1, 1);
    give_back_light(&few, "rough dielectric", NULL, 0, 0.9f);
    give_back_light(&few, "smooth dielectric", NULL, 0, 0);
    give_back_light(&few, "both", tinted, 0.4f, 0.7f);
    give_back_light(&few, "thin wall", walled, 0, 0.9f);
    give_back_light(&few, "rough solid", solid, 0, 0.8f);
    give_back_light(&few, "leaf", leaf, 0, 0.7f);
    give_back_light(&few, "coated", coated, 0.3f, 0.8f);
    give_back_light(&few, "velvet", velvet, 0, 0.8f);
    give_back_light(&few, "filmed", filmed, 0, 0.7f);
    give_back_light(&few, "filmed metal", tempered, 1, 0.7f);
    give_back_light(&few, "brushed", brushed, 1, 0.4f);
}

/* The way of u turns the other way round there. */
UNIT_TEST(brushed_metal_agrees_in_a_mirror) {
    stage s = room_open();
    fathom_material metal = metallic(1, 0.2f);
    fathom_instance instance = default_instance();
    fathom_quad quad;
    metal.anisotropy = 0.9f, metal.anisotropy_rotation = -0.8f;
    fathom_quad_from_axes((double[3]){0, 0, 0}, (double[3]){1.2, 0.8, 0}, (double[3]){-0.8, 1.2, 0}, &quad);
    assert_ok(s.context, fathom_scene_add_group(s.scene, NULL, &instance.group));
    quad.material = stage_material(&s, &metal);
    assert_ok(s.context, fathom_scene_add_quad(s.scene, instance.group, &quad, NULL));
    const double map[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    memcpy(instance.transform, map, sizeof map);
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    compare(&s, "brushed metal");
}

/* Its light goes in by the rough surface, which it is not absorbed before. */
UNIT_TEST(a_light_without_a_surface_shines_into_coloured_glass) {
    stage s = room_open();
    fathom_material glass = metallic(0, 0.6f);
    glass.transmission = glass.thickness = 1;
    glass.attenuation_distance = 0.5f, glass.attenuation_color[2] = 0.2f;
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &glass));
    stage_point_light(&s, 0.5, 0, -3, 100);
    compare(&s, "a light behind coloured glass");
}

/* The cone's edge crosses the floor, which some of the lamp's points light and others do not. */
UNIT_TEST(a_wide_spot_falls_off_point_by_point) {
    stage s = stage_open(32, 32);
    fathom_light spot = default_light();
    spot.type = FATHOM_LIGHT_SPOT, spot.radius = 0.5f;
    spot.inner_angle = 0.3f, spot.outer_angle = 0.6f;
    spot.position[1] = 1.5, spot.direction[1] = -1, spot.direction[2] = 0;
    for (int c = 0; c < 3; ++c) spot.intensity[c] = 5;
    assert_ok(s.context, fathom_scene_add_light(s.scene, &spot, NULL));
    stage_plane(&s, (double[3]){0, -1.2, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.6f));
    stage_camera(&s, (double[3]){0, 5, 0.1}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7);
    compare(&s, "a spot light with a radius");
}

/* A cube of ice reaches out of a drink that fills more than its glass. */
UNIT_TEST(volumes_of_higher_priority_win) {
    stage s = room_open();
    fathom_material glass = metallic(0, 0), drink = glass;
    glass.transmission = glass.thickness = 1, glass.priority = 2;
    drink = glass, drink.ior = 1.3f, drink.priority = 1;
    drink.attenuation_distance = 0.5f, drink.attenuation_color[2] = 0.2f;
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &drink));
    stage_sphere(&s, 0.7, 0.3, 0, 0.6, stage_material(&s, &glass));
    glass.ior = 1.7f, glass.dispersion = 3, glass.priority = 3;
    stage_sphere(&s, 0.2, 0.6, 0, 0.5, stage_material(&s, &glass));
    compare(&s, "drink");
}

static void add_balls(stage *s) {
    const fathom_material metal = metallic(1, 0.3f), plastic = metallic(0, 0.5f);
    stage_sphere(s, -1, 0, 0, 0.9, stage_material(s, &metal));
    stage_sphere(s, 1, 0, 0, 0.9, stage_material(s, &plastic));
}

/* An overcast sky with one bright texel, and a few that hardly differ from black. */
static void write_sky(fathom_context *for_image) {
    enum { WIDTH = 40, HEIGHT = 20 };
    static float texels[WIDTH * HEIGHT][3];
    random_state r = {3};
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        for (int c = 0; c < 3; ++c)
            texels[i][c] = i % 7 ? (float)random_in(&r, 0.2, 1 + 0.5 * c) : (float)random_in(&r, 0, 1e-3);
    }
    texels[5 * WIDTH + 11][0] = texels[5 * WIDTH + 11][1] = 40;
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], sizeof *texels},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], sizeof *texels},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], sizeof *texels}};
    const image img = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, channels, 3, NULL, 0, 0};
    assert_ok(for_image, exr_write_plain(for_image, &img, in_folder("sky.exr")));
}

/* Alone, and with another image and an even light beside. */
UNIT_TEST(images_of_skies_agree) {
    for (int both = 0; both < 2; ++both) {
        stage s = both ? room_open() : stage_open(32, 32);
        fathom_light light = default_light();
        write_sky(s.context);
        light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr"), light.rotation = 0.7;
        assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
        if (both) {
            light.rotation = -2, light.intensity[2] = 0.2f;
            assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
        } else {
            stage_plane(&s, (double[3]){0, -1, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.6f));
            stage_camera(&s, (double[3]){0, 0.5, 4}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7);
        }
        add_balls(&s);
        compare(&s, both ? "two skies, a background and a lamp" : "a sky");
    }
}

/* With the floor that it comes with. */
UNIT_TEST(the_studio_agrees) {
    stage s = stage_open(32, 32);
    add_balls(&s);
    assert_ok(s.context, fathom_scene_complete(s.scene));
    assert_true(s.scene->in_studio);
    compare(&s, "the studio");
}

int main(void) { return unit_main(open_folder, remove_folder); }
