/* Images and colours on surfaces, seen through whole renders: where texels lie, what parameters make of them,
 * and the light that goes through and out of them. */
#include "render.h"

#include <stdio.h>

/* ---- images in memory ---- */

typedef struct picture {
    unsigned char bytes[1 << 16];
    size_t size;
} picture;

static picture new_picture(unsigned width, unsigned height, const unsigned char *rgb) {
    picture p;
    const int header = snprintf((char *)p.bytes, sizeof p.bytes, "P6\n%u %u\n255\n", width, height);
    p.size = (size_t)header + (size_t)width * height * 3;
    assert_true(p.size <= sizeof p.bytes);
    memcpy(p.bytes + header, rgb, (size_t)width * height * 3);
    return p;
}

static fathom_id add_filtered(stage *s, const picture *p, fathom_wrap wrap, fathom_texture_filter filter) {
    fathom_texture t = default_texture();
    t.bytes = p->bytes, t.byte_count = p->size, t.name = "picture.ppm";
    t.color_space = FATHOM_COLOR_LINEAR, t.filter = filter;
    t.wrap_u = t.wrap_v = wrap;
    return new_texture(s->scene, &t);
}

/* Texels as they are: linear, and without anything between them. */
static fathom_id add_picture(stage *s, const picture *p, fathom_wrap wrap) {
    return add_filtered(s, p, wrap, FATHOM_TEXTURE_NEAREST);
}

static fathom_id add_texels(stage *s, unsigned width, unsigned height, const unsigned char *rgb) {
    const picture p = new_picture(width, height, rgb);
    return add_picture(s, &p, FATHOM_WRAP_REPEAT);
}

static float value(const fathom_film *film, char channel, uint32_t x, uint32_t y) {
    uint32_t width, height;
    const char name[] = {channel, 0};
    fathom_film_size(film, &width, &height);
    return fathom_film_channel(film, name)[(size_t)y * width + x];
}

/* The square [-1,1]² of z = 0 fills the image. */
static void look_at_square(stage *s) {
    stage_camera(s, (double[]){0, 0, 1}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 2 * atan(1.0));
}

static void add_square(stage *s, fathom_id material) {
    stage_quad(s, (double[]){0, 0, 0}, (double[]){1, 0, 0}, (double[]){0, 1, 0}, material);
}

static fathom_material glowing(void) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_e[c] = 1;
    return m;
}

/* The square as a mesh. */
typedef struct square {
    fathom_mesh mesh;
    float positions[12], normals[12], uvs[8], uvs_1[8], colors[12], tangents[16];
    uint32_t indices[6];
} square;

static void new_square(square *q, fathom_id material) {
    memset(q, 0, sizeof *q);
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    fathom_mesh_default(&q->mesh);
    for (int k = 0; k < 4; ++k) {
        const bool right = k == 1 || k == 2, up = k >= 2;
        q->positions[3 * k] = right ? 1 : -1, q->positions[3 * k + 1] = up ? 1 : -1;
        q->normals[3 * k + 2] = 1;
        q->uvs[2 * k] = right ? 1 : 0, q->uvs[2 * k + 1] = up ? 0 : 1;
        q->uvs_1[2 * k] = right ? 0 : 1, q->uvs_1[2 * k + 1] = up ? 0 : 1; /* mirrored */
        q->tangents[4 * k] = 1, q->tangents[4 * k + 3] = 1;
    }
    memcpy(q->indices, indices, sizeof indices);
    q->mesh.positions = q->positions, q->mesh.vertex_count = 4;
    q->mesh.indices = q->indices, q->mesh.triangle_count = 2;
    q->mesh.uvs = q->uvs, q->mesh.uv_count = 4;
    q->mesh.uvs_1 = q->uvs_1;
    q->mesh.material = material;
}

static void add_mesh(stage *s, const square *q) {
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &q->mesh, NULL));
}

/* ---- texels ---- */

enum { SIDE = 8 };

static void fill_texels(unsigned char rgb[SIDE * SIDE * 3]) {
    for (unsigned i = 0; i < SIDE * SIDE; ++i)
        rgb[3 * i] = (unsigned char)(4 * i), rgb[3 * i + 1] = (unsigned char)(255 - i), rgb[3 * i + 2] = 7;
}

/* Pixels that are texels: nothing is rounded but the division by 255. */
static void assert_texels(const fathom_film *film, const unsigned char *rgb, bool mirrored) {
    for (uint32_t y = 0; y < SIDE; ++y) {
        for (uint32_t x = 0; x < SIDE; ++x) {
            const unsigned char *texel = rgb + 3 * (y * SIDE + (mirrored ? SIDE - 1 - x : x));
            for (int c = 0; c < 3; ++c)
                assert_near(value(film, "RGB"[c], x, y), (float)texel[c] / 255, 0x1p-23);
        }
    }
}

UNIT_TEST(an_image_stands_upright_on_a_quad_texel_by_texel) {
    const fathom_integrator integrators[] = {FATHOM_INTEGRATOR_CLASSIC, FATHOM_INTEGRATOR_PATH};
    unsigned char rgb[SIDE * SIDE * 3];
    fill_texels(rgb);
    for (size_t k = 0; k < 2; ++k) {
        stage s = stage_open(SIDE, SIDE);
        fathom_settings_set_integrator(&s.settings, integrators[k]);
        s.settings.target_error = 0, s.settings.spp = 4;
        fathom_material m = glowing();
        m.maps[FATHOM_MAP_EMISSIVE].texture = add_texels(&s, SIDE, SIDE, rgb);
        add_square(&s, stage_material(&s, &m));
        look_at_square(&s);
        fathom_film *film = stage_render(&s);
        assert_texels(film, rgb, false);
    }
}

static fathom_id add_stripes(stage *s, fathom_texture_filter filter) {
    enum { ACROSS = 32 };
    unsigned char rgb[ACROSS * ACROSS * 3];
    for (unsigned i = 0; i < sizeof rgb; ++i) rgb[i] = i / 3 % 2 ? 255 : 0;
    const picture p = new_picture(ACROSS, ACROSS, rgb);
    return add_filtered(s, &p, FATHOM_WRAP_REPEAT, filter);
}

/* Stripes of 32 texels that lead away from a viewer just above them. Half a pixel is at most 0.047 wide, less
 * than a texel of 0.0625 where the image repeats once, but up to 15 times as long. */
static fathom_film *render_stripes(fathom_texture_filter filter, int map, float repeats) {
    stage s = stage_open(24, 24);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 4;
    fathom_material m = default_material();
    if (map != FATHOM_MAP_COLOR) {
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
        m.clearcoat = m.clearcoat_roughness = m.iridescence = m.anisotropy = m.sheen_roughness = 0.7f;
        for (int c = 0; c < 3; ++c) m.sheen_color[c] = 0.5f;
    }
    m.maps[map].texture = add_stripes(&s, filter);
    m.maps[map].transform[0] = m.maps[map].transform[4] = repeats;
    add_square(&s, stage_material(&s, &m));
    stage_point_light(&s, 0, 0, 3, 20);
    stage_camera(&s, (double[]){0, -1.2, 0.15}, (double[]){0, 0, 0}, (double[]){0, 0, 1}, 0.9);
    fathom_film *film = stage_render(&s);
    return film;
}

static void check_stripes(int map, float repeats) {
    fathom_film *sharp = render_stripes(FATHOM_TEXTURE_LINEAR, map, repeats),
                *seen = render_stripes(FATHOM_TEXTURE_TRILINEAR, map, repeats);
    for (uint32_t y = 0; y < 24; ++y) {
        for (uint32_t x = 0; x < 24; ++x) assert_true(value(seen, 'R', x, y) == value(sharp, 'R', x, y));
    }
}

UNIT_TEST(stripes_stay_sharp_at_grazing_angles) { check_stripes(FATHOM_MAP_COLOR, 1); }

/* 16 texels a pixel across, and up to 240 along. */
UNIT_TEST(distance_averages_no_normals_roughness_or_layers) {
    static const int maps[] = {FATHOM_MAP_NORMAL,
                               FATHOM_MAP_BUMP,
                               FATHOM_MAP_OPACITY,
                               FATHOM_MAP_ROUGHNESS,
                               FATHOM_MAP_METALLIC,
                               FATHOM_MAP_CLEARCOAT,
                               FATHOM_MAP_CLEARCOAT_ROUGHNESS,
                               FATHOM_MAP_SHEEN_COLOR,
                               FATHOM_MAP_SHEEN_ROUGHNESS,
                               FATHOM_MAP_IRIDESCENCE,
                               FATHOM_MAP_IRIDESCENCE_THICKNESS,
                               FATHOM_MAP_TRANSMISSION,
                               FATHOM_MAP_CLEARCOAT_NORMAL,
                               FATHOM_MAP_ANISOTROPY};
    /* Which map it is makes no difference to what reads it. */
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i += SANITIZED ? 3 : 1) check_stripes(maps[i], 16);
}

/* A volume of the priority 2 is around all. A ball of the priority 1 in it, which it hides, is around the
 * square. Only a ceiling is seen. */
static fathom_film *render_hidden_ball(fathom_texture_filter filter) {
    stage s = stage_open(8, 8);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 16;
    fathom_material volume = default_material(), rough = default_material();
    rough.model = volume.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    volume.metallic = volume.roughness = 0, volume.transmission = volume.thickness = 1;
    volume.priority = 2;
    stage_sphere(&s, 0, 0, 0, 20, stage_material(&s, &volume));
    volume.priority = 1;
    stage_sphere(&s, 0, 0, 0, 2, stage_material(&s, &volume));
    rough.maps[FATHOM_MAP_ROUGHNESS].texture = add_stripes(&s, filter);
    add_square(&s, stage_material(&s, &rough));
    stage_quad(&s, (double[]){0, 0, 5}, (double[]){4, 0, 0}, (double[]){0, 4, 0}, stage_lambert(&s, 0.5f));
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){1, 1, 1}));
    stage_camera(&s, (double[]){0, 0, 3}, (double[]){0, 0, 5}, (double[]){0, 1, 0}, 0.9);
    return stage_render(&s);
}

UNIT_TEST(a_hidden_surface_does_not_bring_texels_back_that_scattered_rays_average) {
    fathom_film *exact = render_hidden_ball(FATHOM_TEXTURE_LINEAR),
                *averaged = render_hidden_ball(FATHOM_TEXTURE_TRILINEAR);
    unsigned differ = 0;
    for (uint32_t i = 0; i < 64; ++i)
        differ += value(exact, 'R', i % 8, i / 8) != value(averaged, 'R', i % 8, i / 8);
    assert_true(differ > 0);
}

UNIT_TEST(each_uv_set_has_its_own_place) {
    unsigned char rgb[SIDE * SIDE * 3];
    fill_texels(rgb);
    for (uint32_t set = 0; set < 2; ++set) {
        stage s = stage_open(SIDE, SIDE);
        fathom_material m = glowing();
        m.maps[FATHOM_MAP_EMISSIVE].texture = add_texels(&s, SIDE, SIDE, rgb);
        m.maps[FATHOM_MAP_EMISSIVE].uv_set = set;
        square q;
        new_square(&q, stage_material(&s, &m));
        add_mesh(&s, &q);
        look_at_square(&s);
        fathom_film *film = stage_render(&s);
        assert_texels(film, rgb, set == 1);
    }
}

/* Four texels in a row, from u = -1 to 2. */
UNIT_TEST(wrap_modes_go_on_beside_the_image) {
    static const unsigned char row[12] = {10, 10, 10, 20, 20, 20, 30, 30, 30, 40, 40, 40};
    static const int expected[3][12] = {
        [FATHOM_WRAP_REPEAT] = {10, 20, 30, 40, 10, 20, 30, 40, 10, 20, 30, 40},
        [FATHOM_WRAP_MIRROR] = {40, 30, 20, 10, 10, 20, 30, 40, 40, 30, 20, 10},
        [FATHOM_WRAP_CLAMP] = {10, 10, 10, 10, 10, 20, 30, 40, 40, 40, 40, 40}};
    for (int wrap = 0; wrap < 3; ++wrap) {
        stage s = stage_open(12, 12);
        const picture p = new_picture(4, 1, row);
        fathom_material m = glowing();
        fathom_map *map = &m.maps[FATHOM_MAP_EMISSIVE];
        map->texture = add_picture(&s, &p, (fathom_wrap)wrap);
        map->transform[0] = 3, map->transform[2] = -1;
        add_square(&s, stage_material(&s, &m));
        look_at_square(&s);
        fathom_film *film = stage_render(&s);
        for (uint32_t x = 0; x < 12; ++x)
            assert_near(value(film, 'R', x, 6), (float)expected[wrap][x] / 255, 0x1p-23);
    }
}

/* ---- colours ---- */

/* A colour that is linear over the square is what it is at each pixel, times k_d and the ambient light. */
UNIT_TEST(vertex_colours_interpolate) {
    stage s = stage_open(16, 16);
    fathom_material m = default_material();
    square q;
    new_square(&q, stage_material(&s, &m));
    for (int k = 0; k < 4; ++k) {
        q.colors[3 * k] = (q.positions[3 * k] + 1) / 2,
                     q.colors[3 * k + 1] = (q.positions[3 * k + 1] + 1) / 2;
        q.colors[3 * k + 2] = 0.25f;
    }
    q.mesh.colors = q.colors;
    add_mesh(&s, &q);
    assert_ok(s.context, fathom_scene_set_ambient(s.scene, (float[]){1, 1, 1}));
    look_at_square(&s);
    fathom_film *film = stage_render(&s);
    for (uint32_t y = 0; y < 16; ++y) {
        for (uint32_t x = 0; x < 16; ++x) {
            /* The weights are within a few roundings of float. */
            assert_near(value(film, 'R', x, y), 0.5 * (x + 0.5) / 16, 8 * 0x1p-24);
            assert_near(value(film, 'G', x, y), 0.5 * (15.5 - y) / 16, 8 * 0x1p-24);
            assert_near(value(film, 'B', x, y), 0.125, 8 * 0x1p-24);
        }
    }
}

/* The material decides, not what an image makes of it at a point: light samples do not look there. */
UNIT_TEST(colours_multiply_the_emission_of_unlit_materials_alone) {
    static const unsigned char black[3] = {0, 0, 0};
    for (int unlit = 0; unlit < 2; ++unlit) {
        stage s = stage_open(4, 4);
        fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
        s.settings.target_error = 0, s.settings.spp = 4;
        fathom_material m = default_material();
        m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.specular_factor = 0;
        for (int c = 0; c < 3; ++c) m.emissive[c] = 1, m.base_color[c] = unlit ? 0 : 1;
        m.maps[FATHOM_MAP_COLOR].texture = add_texels(&s, 1, 1, black);
        square q;
        new_square(&q, stage_material(&s, &m));
        for (int k = 0; k < 12; ++k) q.colors[k] = 0.5f;
        q.mesh.colors = q.colors;
        add_mesh(&s, &q);
        assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0, 0, 0}));
        look_at_square(&s);
        fathom_film *film = stage_render(&s);
        assert_true(value(film, 'G', 1, 1) == (unlit ? 0.5f : 1));
    }
}

/* ---- normal maps ---- */

/* Tangents are made for a smooth mesh without. */
typedef enum lies {
    LIES_QUAD,
    LIES_MESH,
    LIES_SMOOTH,
    LIES_MESH_WITH_TANGENTS,
    LIES_SMOOTH_MIRRORED,
    LIES_MIRRORED,
    LIES_KINDS
} lies;

static bool is_mirrored(lies how) { return how == LIES_MIRRORED || how == LIES_SMOOTH_MIRRORED; }

static void add_mapped(stage *s, lies how, fathom_id material) {
    square q;
    fathom_instance instance = default_instance();
    if (how == LIES_QUAD) {
        add_square(s, material);
        return;
    }
    new_square(&q, material);
    if (how != LIES_MESH) {
        q.mesh.normals = q.normals, q.mesh.normal_count = 4;
        if (how == LIES_MESH_WITH_TANGENTS || how == LIES_MIRRORED) q.mesh.tangents = q.tangents;
    }
    if (!is_mirrored(how)) {
        add_mesh(s, &q);
        return;
    }
    const fathom_id group = new_group(s->scene, NULL);
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &q.mesh, NULL));
    instance.group = group, instance.transform[0] = -1;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

/* Red tilts the normal along u, and green against v: upwards in the image. Mirroring the surface mirrors what
 * lies along u. */
UNIT_TEST(a_normal_map_tilts_the_normal) {
    static const unsigned char texels[3][3] = {{128, 128, 255}, {218, 128, 218}, {128, 218, 218}};
    static const double to_light[3][3] = {{0, 0, 1}, {0.6, 0, 0.8}, {0.48, 0.6, 0.64}};
    for (int how = 0; how < LIES_KINDS; ++how) {
        for (int i = 0; i < 9; ++i) {
            const unsigned char *rgb = texels[i / 3];
            const double *l = to_light[i % 3];
            stage s = stage_open(4, 4);
            fathom_material m = default_material();
            fathom_light light = default_light();
            for (int c = 0; c < 3; ++c) m.k_d[c] = 1;
            m.maps[FATHOM_MAP_NORMAL].texture = add_texels(&s, 1, 1, rgb);
            add_mapped(&s, (lies)how, stage_material(&s, &m));
            light.type = FATHOM_LIGHT_DIRECTIONAL;
            for (int c = 0; c < 3; ++c) light.direction[c] = -l[c];
            assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
            look_at_square(&s);
            double n[3], length = 0, cosine = 0;
            for (int c = 0; c < 3; ++c) n[c] = 2 * rgb[c] / 255.0 - 1, length += n[c] * n[c];
            if (is_mirrored((lies)how)) n[0] = -n[0];
            for (int c = 0; c < 3; ++c) cosine += n[c] * l[c] / sqrt(length);
            fathom_film *film = stage_render(&s);
            assert_near(value(film, 'R', 1, 1), fmax(cosine, 0), 1e-5);
        }
    }
}

/* The middle of the square under a sun, once scattered. */
static float lit_by_sun(const fathom_material *from, int map, const unsigned char *rgb, const double *l) {
    stage s = stage_open(8, 8);
    fathom_material m = *from;
    fathom_light light = default_light();
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 4, s.settings.max_depth = 1;
    if (rgb) m.maps[map].texture = add_texels(&s, 1, 1, rgb);
    add_mapped(&s, LIES_MESH, stage_material(&s, &m));
    light.type = FATHOM_LIGHT_DIRECTIONAL;
    for (int c = 0; c < 3; ++c) light.direction[c] = -l[c];
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    look_at_square(&s);
    fathom_film *film = stage_render(&s);
    const float result = value(film, 'R', 4, 4);
    return result;
}

/* A coat over nothing is a dielectric of index 1.5 without its base, so that both reflect alike where their
 * normals are alike: with one map in one or the other, and with none where the map is that of the base under
 * the coat. Sums of four samples in float differ by some 2^-20. */
UNIT_TEST(a_coat_has_its_own_normal) {
    static const unsigned char tilted[3] = {170, 100, 230};
    static const double to_light[3][3] = {{0, 0, 1}, {0.48, -0.36, 0.8}, {0.64, 0.48, 0.6}};
    fathom_material coat = default_material(), dielectric;
    coat.model = FATHOM_MODEL_METALLIC_ROUGHNESS, coat.multiscatter = false;
    for (int c = 0; c < 3; ++c) coat.base_color[c] = 0;
    dielectric = coat, dielectric.roughness = 0.6f, dielectric.metallic = 0;
    coat.specular_factor = coat.metallic = 0, coat.clearcoat = 1, coat.clearcoat_roughness = 0.6f;
    float before = -1;
    for (int i = 0; i < 3; ++i) {
        const double *l = to_light[i];
        const float flat = lit_by_sun(&dielectric, 0, NULL, l);
        const float turned = lit_by_sun(&dielectric, FATHOM_MAP_NORMAL, tilted, l);
        assert_true(flat > 0 && turned > 0 && fabsf(turned - flat) > 0.01f * flat && turned != before);
        before = turned;
        assert_near(lit_by_sun(&coat, FATHOM_MAP_CLEARCOAT_NORMAL, tilted, l), turned, 1e-5 * (double)turned);
        assert_near(lit_by_sun(&coat, FATHOM_MAP_NORMAL, tilted, l), flat, 1e-5 * (double)flat);
    }
}

/* A white image changes no number of a material, so neither the light that a smooth coat leaves. */
UNIT_TEST(a_smooth_coat_stays_smooth_over_an_image) {
    static const unsigned char white[3] = {255, 255, 255};
    static const double to_light[2][3] = {{0, 0, 1}, {0.48, -0.36, 0.8}};
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.clearcoat = 1;
    for (int i = 0; i < 2; ++i) {
        const float plain = lit_by_sun(&m, 0, NULL, to_light[i]);
        assert_true(plain > 0);
        assert_true(lit_by_sun(&m, FATHOM_MAP_COLOR, white, to_light[i]) == plain);
    }
}

/* A ramp over the whole square, 2 wide and high: 16 steps of 8 grey levels each along u, as many of -4 along
 * v. A pixel is smaller than a texel, and slopes go over a texel. */
UNIT_TEST(a_ramp_of_heights_tilts_the_normal_by_its_slope) {
    unsigned char rgb[16 * 16][3];
    for (int k = 0; k < 16 * 16; ++k) memset(rgb[k], 70 + 8 * (k % 16) - 4 * (k / 16), 3);
    const double to_light[3] = {0.36, 0.48, 0.8};
    for (int how = 0; how < LIES_KINDS; ++how) {
        stage s = stage_open(64, 64);
        fathom_material m = default_material();
        fathom_light light = default_light();
        for (int c = 0; c < 3; ++c) m.k_d[c] = 1;
        m.bump_scale = 0.75f;
        m.maps[FATHOM_MAP_BUMP].texture = add_texels(&s, 16, 16, rgb[0]);
        add_mapped(&s, (lies)how, stage_material(&s, &m));
        light.type = FATHOM_LIGHT_DIRECTIONAL;
        for (int c = 0; c < 3; ++c) light.direction[c] = -to_light[c];
        assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
        look_at_square(&s);
        const double across = 0.75 * 16 * 8 / 255 / 2, up = 0.75 * 16 * 4 / 255 / 2;
        const double n[3] = {is_mirrored((lies)how) ? across : -across, -up, 1};
        const double length = sqrt(n[0] * n[0] + n[1] * n[1] + 1);
        double cosine = 0;
        for (int c = 0; c < 3; ++c) cosine += n[c] * to_light[c] / length;
        fathom_film *film = stage_render(&s);
        assert_near(value(film, 'R', 30, 30), cosine, 1e-5);
    }
}

/* ---- opacity ---- */

/* The light of the floor below a sheet whose opacity an image says, straight under the sun. */
static double light_below(unsigned char opacity, float cutoff) {
    const unsigned char rgb[3] = {opacity, opacity, opacity};
    stage s = stage_open(4, 4);
    fathom_material m = default_material();
    fathom_light light = default_light();
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 16, s.settings.max_depth = 1;
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.opacity_cutoff = cutoff;
    m.maps[FATHOM_MAP_OPACITY].texture = add_texels(&s, 1, 1, rgb);
    stage_quad(&s, (double[]){0, 0, 1}, (double[]){5, 0, 0}, (double[]){0, 5, 0}, stage_material(&s, &m));
    stage_quad(&s, (double[]){0, 0, 0}, (double[]){5, 0, 0}, (double[]){0, 5, 0}, stage_lambert(&s, 1));
    light.type = FATHOM_LIGHT_DIRECTIONAL, light.direction[1] = 0, light.direction[2] = -1;
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    stage_camera(&s, (double[]){0, -1, 0.5}, (double[]){0, 0, 0}, (double[]){0, 0, 1}, 0.1);
    fathom_film *film = stage_render(&s);
    const double found = (double)value(film, 'R', 2, 2);
    return found;
}

UNIT_TEST(opacity_from_an_image_shades_the_floor) {
    assert_near(light_below(255, 0), 0, 0);
    assert_near(light_below(0, 0), 1, 1e-6);
    assert_near(light_below(102, 0), 0.6, 1e-6);
    assert_near(light_below(102, 0.5f), 1, 1e-6);
    assert_near(light_below(153, 0.5f), 0, 0);
}

/* ---- emission ---- */

/* Of a rectangle light of 1 by 4, the half of its image that is white is the one of 1 by 2 whose corner lies
 * straight above the floor's point at height 1.5: the closed form, 0.12235966. The means of
 * independent seeds have Student's t with 15 degrees of freedom; 4.9 standard errors are met but once in
 * 5,000 such tests. */
UNIT_TEST(half_a_light_by_its_image_is_the_light_of_that_half) {
    static const unsigned char halves[6] = {255, 255, 255, 0, 0, 0};
    enum { SEEDS = 16 };
    double sum = 0, squares = 0;
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        stage s = stage_open(4, 4);
        fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
        s.settings.target_error = 0, s.settings.spp = 256, s.settings.max_depth = 1, s.settings.seed = seed;
        fathom_material m = glowing();
        m.maps[FATHOM_MAP_EMISSIVE].texture = add_texels(&s, 2, 1, halves);
        /* u runs along y, from the corner above the point. */
        stage_quad(&s, (double[]){0.5, 2, 1.5}, (double[]){0, 2, 0}, (double[]){0.5, 0, 0},
                   stage_material(&s, &m));
        stage_quad(&s, (double[]){0, 0, 0}, (double[]){9, 0, 0}, (double[]){0, 9, 0}, stage_lambert(&s, 1));
        stage_camera(&s, (double[]){-1, -1, 1}, (double[]){0, 0, 0}, (double[]){0, 0, 1}, 1e-4);
        fathom_film *film = stage_render(&s);
        double mean = 0;
        for (uint32_t i = 0; i < 16; ++i) mean += (double)value(film, 'R', i % 4, i / 4) / 16;
        sum += mean, squares += mean * mean;
    }
    const double mean = sum / SEEDS, variance = (squares / SEEDS - mean * mean) / (SEEDS - 1);
    assert_true(sqrt(variance) < 1e-3 * mean);
    assert_near(mean, 0.12235966, 4.9 * sqrt(variance));
}

/* ---- no thread, tile or crop changes a pixel ---- */

static fathom_film *render_ball(unsigned threads, uint32_t tile, bool crop) {
    unsigned char rgb[SIDE * SIDE * 3];
    fill_texels(rgb);
    stage s = stage_open(96, 64);
    fathom_context_set_threads(s.context, threads);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 8, s.settings.tile_size = tile;
    if (crop) memcpy(s.settings.crop, (uint32_t[]){32, 16, 64, 48}, sizeof s.settings.crop);
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.emissive[0] = 0.5f;
    const fathom_id texture = add_texels(&s, SIDE, SIDE, rgb);
    const fathom_map_kind kinds[] = {FATHOM_MAP_COLOR, FATHOM_MAP_ROUGHNESS, FATHOM_MAP_NORMAL,
                                     FATHOM_MAP_EMISSIVE, FATHOM_MAP_OPACITY};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) {
        m.maps[kinds[i]].texture = texture;
        m.maps[kinds[i]].transform[1] = 0.25f * (float)i;
    }
    stage_mesh_sphere(&s, FATHOM_ROOT, 12, 24, stage_material(&s, &m));
    stage_plane(&s, (double[]){0, -1, 0}, (double[]){0, 1, 0}, stage_material(&s, &m));
    stage_point_light(&s, 3, 4, 3, 20);
    stage_camera(&s, (double[]){0, 0.5, 3}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.9);
    fathom_film *film = stage_render(&s);
    return film;
}

UNIT_TEST(threads_tiles_and_crops_change_no_pixel) {
    fathom_film *one = render_ball(1, 32, false), *three = render_ball(3, 64, false),
                *crop = render_ball(2, 32, true);
    for (uint32_t y = 0; y < 64; ++y) {
        for (uint32_t x = 0; x < 96; ++x) {
            const bool inside = x >= 32 && x < 64 && y >= 16 && y < 48;
            for (int c = 0; c < 3; ++c) {
                const float pixel = value(one, "RGB"[c], x, y);
                assert_true(isfinite(pixel) && pixel == value(three, "RGB"[c], x, y));
                if (inside) assert_true(pixel == value(crop, "RGB"[c], x - 32, y - 16));
            }
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
