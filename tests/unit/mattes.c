/* Cryptomatte, decoded by its published rule: the matte of a name is the sum of the coverages that stand next
 * to its id. */
#include "base/file.h"
#include "base/murmur.h"
#include "film/film.h"
#include "render.h"
#include "scene/scene.h"
#include "unit_folder.h"

#include <string.h>
#include <unistd.h>

#define SIDE 48

static const double up[3] = {0, 1, 0};

/* Values of the author's own implementation. */
UNIT_TEST(the_hash_is_murmur3) {
    assert_int_equal(murmur_hash("", 0), 0);
    assert_int_equal(murmur_hash("test", 4), 0xba6bd213);
    assert_int_equal(murmur_hash("hello", 5), 0x248bfa47);
    assert_int_equal(murmur_hash("hello, world", 12), 0x149bbb7f);
    assert_int_equal(murmur_hash("The quick brown fox jumps over the lazy dog", 43), 0x2e4ff723);
}

UNIT_TEST(ids_are_numbers) {
    char name[16];
    for (unsigned i = 0; i < 100000; ++i) {
        snprintf(name, sizeof name, "object %u", i);
        const uint32_t id = matte_id(name);
        float value;
        memcpy(&value, &id, sizeof value);
        assert_true(isnormal(value));
    }
}

static void name_last(stage *s, const char *name) {
    assert_ok(s->context, fathom_scene_name_object(s->scene, (fathom_id)(s->scene->objects.count - 1), name));
}

static fathom_id named_material(stage *s, const char *name, const fathom_material *m) {
    return new_material(s->scene, name, m);
}

/* Balls before each other, one behind a veil that lets three quarters of the paths through, glass that does
 * not. */
static stage open_balls(void) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 64, s.settings.target_error = 0, s.settings.max_depth = 2;
    s.settings.aovs = FATHOM_AOV_CRYPTO_OBJECT | FATHOM_AOV_CRYPTO_MATERIAL | FATHOM_AOV_ALPHA;
    fathom_material m = default_material();
    const fathom_id red = named_material(&s, "red \"wax\"", &m);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.opacity = 0.25f;
    const fathom_id veil = named_material(&s, "veil", &m);
    m.opacity = 1, m.transmission = 1, m.thickness = 1, m.roughness = 0;
    const fathom_id glass = named_material(&s, "glass", &m);
    stage_sphere(&s, -0.5, 0, 0, 0.8, red), name_last(&s, "left");
    stage_sphere(&s, 0.5, 0, -1, 0.8, red), name_last(&s, "right");
    stage_quad(&s, (double[3]){0.9, 0, 2}, (double[3]){0.4, 0, 0}, (double[3]){0, 1, 0}, veil);
    name_last(&s, "curtain");
    stage_sphere(&s, 0, 1, 1, 0.3, glass);
    stage_camera(&s, (double[3]){0, 0.3, 5}, (double[3]){0, 0.2, 0}, up, 0.7);
    return s;
}

/* ---- the rule ---- */

static const float *channel(const fathom_film *film, const char *layer, unsigned rank, char c) {
    char name[40];
    snprintf(name, sizeof name, "%s%02u.%c", layer, rank / 2, c);
    const float *pixels = fathom_film_channel(film, name);
    assert_non_null(pixels);
    return pixels;
}

static double matte_of(const fathom_film *film, const char *layer, uint32_t hash, int pixel) {
    const uint32_t exponent = hash >> 23 & 255;
    const uint32_t id = exponent == 0 ? hash | 1u << 23 : exponent == 255 ? hash ^ 1u << 23 : hash;
    double sum = 0;
    for (unsigned r = 0; r < MATTE_RANKS; ++r) {
        uint32_t bits;
        memcpy(&bits, &channel(film, layer, r, r % 2 ? 'B' : 'R')[pixel], sizeof bits);
        if (bits == id) sum += (double)channel(film, layer, r, r % 2 ? 'A' : 'G')[pixel];
    }
    return sum;
}

static uint32_t hash_of(const char *name) { return murmur_hash(name, strlen(name)); }

static double mean_of(const fathom_film *film, const char *layer, const char *name) {
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) sum += matte_of(film, layer, hash_of(name), i) / (SIDE * SIDE);
    return sum;
}

/* ---- laws ---- */

/* A sheet that fills the view, before a ball. */
static stage open_sheet(float color, float opacity) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 64, s.settings.target_error = 0;
    s.settings.aovs = FATHOM_AOV_CRYPTO_OBJECT | FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_ID;
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.opacity = opacity, m.specular_factor = 0;
    for (int c = 0; c < 3; ++c) m.base_color[c] = color;
    stage_quad(&s, (double[3]){0, 0, 2}, (double[3]){4, 0, 0}, (double[3]){0, 4, 0}, stage_material(&s, &m));
    name_last(&s, "sheet");
    stage_sphere(&s, 0, 0, 0, 0.5, stage_lambert(&s, 0.5f));
    name_last(&s, "ball");
    stage_camera(&s, (double[3]){0, 0, 5}, (double[3]){0, 0, 0}, up, 0.7);
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){1, 1, 1}));
    return s;
}

/* The corner pixel sees the sheet alone. Of 64 samples of a (0,1)-sequence, each 64th holds one number. If
 * errors are asked for, each of the four groups has one of 16 numbers in each sixteenth: a group is off by a
 * sample at most. */
UNIT_TEST(coverage_is_opacity_whatever_reflects) {
    for (int way = 0; way < 4; ++way) {
        const int color = way % 2;
        stage s = open_sheet((float)color, 17 / 64.0f);
        if (way > 1) s.settings.aovs |= FATHOM_AOV_ERROR;
        fathom_film *film = stage_render(&s);
        const double alpha = (double)fathom_film_channel(film, "A")[0];
        assert_near(alpha, 17 / 64.0, way > 1 ? 4 / 64.0 : 1e-6);
        assert_near(matte_of(film, "CryptoObject", hash_of("sheet"), 0), alpha, 1e-6);
        /* Premultiplied, without the background behind. */
        assert_true((double)fathom_film_channel(film, "R")[0] <= 1.2 * alpha * color);
    }
}

/* Rays that continue at the sheet round otherwise, by some h = 1e-6. So the ball's edge may move in a few
 * pixels, and depths there by sqrt(2 r h) = 1e-3. */
UNIT_TEST(aovs_see_past_holes) {
    stage s = open_sheet(1, 0), bare = open_sheet(1, 0);
    for (int k = 0; k < 4; ++k) bare.scene->quads.items[0].corners[k][1] += 100;
    fathom_film *film = stage_render(&s), *expected = stage_render(&bare);
    int moved = 0, seen = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const uint32_t id = fathom_film_channel_id(expected, "id.object")[i];
        const double z = (double)fathom_film_channel(expected, "Z")[i];
        if (fathom_film_channel_id(film, "id.object")[i] != id) {
            ++moved;
            continue;
        }
        seen += id != FATHOM_NONE;
        if (isfinite(z)) assert_near((double)fathom_film_channel(film, "Z")[i], z, 2e-3);
        assert_near((double)fathom_film_channel(film, "A")[i], (double)fathom_film_channel(expected, "A")[i],
                    2 / 64.0);
        assert_near((double)fathom_film_channel(film, "R")[i], (double)fathom_film_channel(expected, "R")[i],
                    0.1);
        assert_true(matte_of(film, "CryptoObject", hash_of("sheet"), i) == 0);
    }
    assert_true(seen > 50 && moved <= 4);
}

UNIT_TEST(mattes_share_what_is_not_empty) {
    static const char *const objects[] = {"left", "right", "curtain", "sphere 2"}, *const materials[] = {
                                                                                       "red \"wax\"", "veil",
                                                                                       "glass"};
    stage s = open_balls();
    for (int k = 0; k < 2; ++k) {
        s.settings.target_error = k ? 0.05 : 0;
        fathom_film *film = stage_render(&s);
        int several = 0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            double object = 0, material = 0;
            int met = 0;
            for (int n = 0; n < 4; ++n) {
                const double matte = matte_of(film, "CryptoObject", hash_of(objects[n]), i);
                object += matte, met += matte > 0;
            }
            for (int n = 0; n < 3; ++n)
                material += matte_of(film, "CryptoMaterial", hash_of(materials[n]), i);
            several += met > 1;
            assert_near(object, material, 1e-6);
            assert_true(object <= 1 + 1e-6);
            assert_near(object, (double)fathom_film_channel(film, "A")[i], 1e-6);
            for (unsigned r = 1; r < MATTE_RANKS; ++r)
                assert_true(channel(film, "CryptoObject", r, r % 2 ? 'A' : 'G')[i] <=
                            channel(film, "CryptoObject", r - 1, r % 2 ? 'G' : 'A')[i]);
        }
        assert_true(several > 20);
    }
}

/* Each sample meets the curtain with a chance of a quarter: 5 standard errors of all samples on it. */
UNIT_TEST(what_is_there_in_part_covers_in_part) {
    stage s = open_balls();
    fathom_film *film = stage_render(&s);
    const double veil = mean_of(film, "CryptoObject", "curtain");
    stage whole = open_balls();
    whole.scene->materials.items[2].value.opacity = 1;
    fathom_film *solid = stage_render(&whole);
    const double all = mean_of(solid, "CryptoObject", "curtain"), samples = all * SIDE * SIDE * 64;
    assert_true(all > 0.05);
    assert_near(veil / all, 0.25, 5 * sqrt(0.25 * 0.75 / samples));
    assert_near(veil, mean_of(film, "CryptoMaterial", "veil"), 1e-9);
    assert_true(mean_of(film, "CryptoObject", "right") > mean_of(solid, "CryptoObject", "right"));
}

static void assert_holds(const file_map *map, const char *text) {
    assert_non_null(memmem(map->bytes, map->size, text, strlen(text)));
}

UNIT_TEST(headers_hold_the_names) {
    stage s = open_balls();
    fathom_film *film = stage_render(&s);
    const char *path = in_folder("a.exr");
    for (int plain = 0; plain < 2; ++plain) {
        fathom_write_options options = default_write_options();
        assert_ok(s.context, plain ? fathom_film_write_plain(s.context, film, path)
                                   : fathom_film_write(s.context, film, path, &options));
        file_map map;
        char text[128];
        assert_ok(s.context, file_open(s.context, path, &map));
        snprintf(text, sizeof text, "cryptomatte/%07x/manifest", hash_of("CryptoObject") >> 4);
        assert_holds(&map, text);
        assert_holds(&map, "uint32_to_float32");
        assert_holds(&map, "MurmurHash3_32");
        snprintf(text, sizeof text, "\"left\":\"%08x\"", hash_of("left"));
        assert_holds(&map, text);
        snprintf(text, sizeof text, "\"red \\\"wax\\\"\":\"%08x\"", hash_of("red \"wax\""));
        assert_holds(&map, text);
        assert_holds(&map, "CryptoObject02.A");
        file_close(&map);
    }
}

/* A pixel keeps the largest six of sixteen, equal ones by their ids. */
UNIT_TEST(ranks_are_the_largest) {
    matte_list list = {{0}, {0}};
    for (uint32_t i = 1; i <= 20; ++i) matte_add(&list, i, i);
    matte_add(&list, 3, 12);
    float out[2 * MATTE_RANKS];
    matte_rank(&list, 100, out);
    static const uint32_t ids[] = {16, 3, 15, 14, 13, 12};
    static const float coverage[] = {0.16f, 0.15f, 0.15f, 0.14f, 0.13f, 0.12f};
    for (unsigned r = 0; r < MATTE_RANKS; ++r) {
        uint32_t id;
        memcpy(&id, &out[2 * r], sizeof id);
        assert_int_equal(id, ids[r]);
        assert_true(out[2 * r + 1] == coverage[r]);
    }
}

/* Two shapes, one of them named, three times side by side. */
static stage open_trees(const char *middle) {
    const char *const names[] = {"left", middle, "right"};
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = 16, s.settings.target_error = 0, s.settings.max_depth = 0;
    s.settings.aovs = FATHOM_AOV_CRYPTO_OBJECT | FATHOM_AOV_ALPHA;
    const fathom_id tree = new_group(s.scene, "tree");
    for (int k = 0; k < 2; ++k) {
        const fathom_sphere ball = {{0, 0.4 * k, 0}, 0.2, 0, 0};
        assert_ok(s.context, fathom_scene_add_sphere(s.scene, tree, &ball, NULL));
    }
    name_last(&s, "crown");
    for (int k = 0; k < 3; ++k) {
        fathom_instance placed = default_instance();
        placed.group = tree, placed.transform[3] = 0.6 * (k - 1), placed.name = names[k];
        assert_ok(s.context, fathom_scene_add_instance(s.scene, &placed, NULL));
    }
    stage_camera(&s, (double[3]){0, 0.2, 5}, (double[3]){0, 0.2, 0}, up, 0.5);
    return s;
}

/* All balls are as large in the image; the middle ones, a little nearer, by less than a tenth. */
UNIT_TEST(an_instance_names_its_shapes_without_names) {
    static const char *const middles[] = {NULL, "", "middle"};
    for (int k = 0; k < 3; ++k) {
        stage s = open_trees(middles[k]);
        fathom_film *film = stage_render(&s);
        const double left = mean_of(film, "CryptoObject", "left");
        assert_true(left > 0.01);
        assert_near(mean_of(film, "CryptoObject", "right"), left, 0.1 * left);
        assert_near(mean_of(film, "CryptoObject", k == 2 ? "middle" : "tree"), left, 0.1 * left);
        assert_near(mean_of(film, "CryptoObject", "crown"), 3 * left, 0.1 * left);
        char *manifest = matte_manifest(s.scene, MATTE_OBJECT);
        assert_non_null(strstr(manifest, "\"left\""));
        assert_true((strstr(manifest, "\"tree\"") != NULL) == (k < 2));
        free(manifest);
    }
}

/* Balls become meshes of their names; one is in a group that is placed twice. */
UNIT_TEST(names_read_back) {
    static const char *const files[] = {"a.json", "a.glb", "a.obj"}, *const names[] = {"one", "two", "three"};
    for (int f = 0; f < 3; ++f) {
        stage s = stage_open(SIDE, SIDE);
        const fathom_id group = new_group(s.scene, "group");
        for (int k = 0; k < 3; ++k) {
            const fathom_sphere ball = {{2 * k, 0, 0}, 0.5, 0, 0};
            assert_ok(s.context, fathom_scene_add_sphere(s.scene, k == 2 ? group : FATHOM_ROOT, &ball, NULL));
            name_last(&s, names[k]);
        }
        for (int k = 0; k < 2; ++k) {
            fathom_instance placed = default_instance();
            placed.group = group, placed.transform[7] = k;
            assert_ok(s.context, fathom_scene_add_instance(s.scene, &placed, NULL));
        }
        assert_ok(s.context, fathom_scene_write(s.scene, in_folder(files[f])));
        fathom_scene *back = scene_of_file(s.context, in_folder(files[f]));
        char *manifest = matte_manifest(back, MATTE_OBJECT), entry[64];
        for (int k = 0; k < 3; ++k) {
            snprintf(entry, sizeof entry, "\"%s\":\"%08x\"", names[k], matte_id(names[k]));
            if (!strstr(manifest, entry)) fail_msg("%s: %s is not in %s", files[f], entry, manifest);
        }
        free(manifest);
    }
}

/* A path of an assembly, say, whose parts differ in its last letter. */
UNIT_TEST(long_names_are_whole) {
    char names[2][402], entry[1024];
    stage s = stage_open(SIDE, SIDE);
    for (int k = 0; k < 2; ++k) {
        for (int i = 0; i < 200; ++i) memcpy(names[k] + 2 * i, "\xc3\xa9", 2);
        names[k][400] = (char)('a' + k), names[k][401] = 0;
        stage_sphere(&s, 2 * k - 1, 0, 0, 0.5, 0);
        name_last(&s, names[k]);
    }
    char *manifest = matte_manifest(s.scene, MATTE_OBJECT);
    uint32_t *ids = matte_ids(s.scene, MATTE_OBJECT);
    assert_non_null(manifest);
    assert_non_null(ids);
    for (int k = 0; k < 2; ++k) {
        assert_int_equal(ids[k], matte_id(names[k]));
        snprintf(entry, sizeof entry, "\"%s\":\"%08x\"", names[k], ids[k]);
        assert_non_null(strstr(manifest, entry));
    }
    assert_true(ids[0] != ids[1]);
    free(manifest);
    free(ids);
}

int main(void) { return unit_main(open_folder, remove_folder); }
