/* What an EXR file of a film says of itself: where its pixels lie in the world, names that other programs
 * take apart, and whether it is finished. */
#include "film/film.h"
#include "render.h"
#include "unit_folder.h"

#include <locale.h>
#include <unistd.h>

#define WIDTH 40u
#define HEIGHT 24u

typedef struct bytes {
    char *at;
    size_t size;
} bytes;

static bytes read_whole(const char *path) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    bytes out = {malloc(1 << 20), 0};
    out.size = fread(out.at, 1, 1 << 20, file);
    fclose(file);
    return out;
}

static const char *find(const bytes *b, const char *what, size_t size) {
    return memmem(b->at, b->size, what, size);
}

/* An attribute is its name, its type, four bytes of size and its value (openexr.com, "OpenEXR File Layout").
 */
static void read_matrix(const bytes *b, const char *name, float out[4][4]) {
    char head[64];
    size_t length = (size_t)snprintf(head, sizeof head, "%s%cm44f%c%c%c%c%c", name, 0, 0, 64, 0, 0, 0);
    const char *at = find(b, head, length);
    if (!at) fail_msg("no m44f %s", name);
    memcpy(out, at + length, 64);
}

/* (p 1) M, divided by its last component. */
static void transform(const float p[3], const float m[4][4], double out[3]) {
    double sums[4];
    for (int c = 0; c < 4; ++c) {
        sums[c] = (double)m[3][c];
        for (int r = 0; r < 3; ++r) sums[c] += (double)p[r] * (double)m[r][c];
    }
    for (int c = 0; c < 3; ++c) out[c] = sums[c] / sums[3];
}

/* Looking askance from afar at a plane and a ball; w: of the camera. */
static stage askance(double w) {
    static const double eye[3] = {7, 3, -4}, target[3] = {1, 0.5, 2}, up[3] = {0.1, 1, 0.2};
    stage s = stage_open(WIDTH, HEIGHT);
    fathom_camera camera;
    fathom_camera_look_at(eye, target, up, 0.7, &camera);
    camera.w = w, camera.d = 1.5;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    stage_plane(&s, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0);
    stage_sphere(&s, 1, 0.5, 2, 1.2, 0);
    stage_point_light(&s, 2, 9, 1, 30);
    s.settings.aovs = FATHOM_AOV_P | FATHOM_AOV_Z | FATHOM_AOV_ID | FATHOM_AOV_SAMPLES;
    return s;
}

static bytes write_and_read(stage *s, const fathom_film *film, bool plain) {
    fathom_write_options options = default_write_options();
    const char *path = in_folder("a.exr");
    if (plain)
        assert_ok(s->context, fathom_film_write_plain(s->context, film, path));
    else
        assert_ok(s->context, fathom_film_write(s->context, film, path, &options));
    bytes b = read_whole(path);
    return b;
}

/* The point that a pixel saw goes back to the pixel's middle, and its depth is the camera's z. P, Z and the
 * matrices are floats of numbers below 64 = 2^6: each is off by 2^-18 at most, sums of four by 2^-16, and the
 * image is at most 2 units across at depth 1: 2^-14 of it is more than the roundings come to. */
static void check_points(const stage *s, const fathom_film *film, const bytes *b) {
    float to_camera[4][4], to_ndc[4][4];
    uint32_t width, height;
    read_matrix(b, "worldToCamera", to_camera);
    read_matrix(b, "worldToNDC", to_ndc);
    fathom_film_size(film, &width, &height);
    for (size_t i = 0; i < (size_t)width * height; ++i) {
        const float p[3] = {fathom_film_channel(film, "P.X")[i], fathom_film_channel(film, "P.Y")[i],
                            fathom_film_channel(film, "P.Z")[i]};
        const double z = (double)fathom_film_channel(film, "Z")[i];
        double at[3];
        if (!(z < 64)) continue;
        transform(p, (const float(*)[4])to_camera, at);
        assert_near(at[2], z, 0x1p-14);
        transform(p, (const float(*)[4])to_ndc, at);
        assert_near(at[0], ((double)(s->settings.crop[0] + i % width) + 0.5) / WIDTH, 0x1p-14);
        assert_near(at[1], ((double)(s->settings.crop[1] + i / width) + 0.5) / HEIGHT, 0x1p-14);
    }
}

UNIT_TEST(matrices_take_points_to_their_pixels) {
    for (int i = 0; i < 4; ++i) {
        stage s = askance(i & 1 ? 0.8 : 0); /* 0.8: pixels that are not square */
        if (i & 2) memcpy(s.settings.crop, (uint32_t[4]){5, 3, 31, 20}, sizeof s.settings.crop);
        fathom_film *film = stage_render(&s);
        for (int plain = 0; plain < 2; ++plain) {
            bytes b = write_and_read(&s, film, plain);
            check_points(&s, film, &b);
            free(b.at);
        }
    }
}

/* Without blur the image is that of the camera halfway, and so are the matrices. */
UNIT_TEST(matrices_of_a_sharp_image_are_of_the_middle_of_the_time) {
    static const double times[2] = {0, 2};
    stage s = askance(0);
    fathom_camera camera[2];
    double frames[24];
    for (int k = 0; k < 2; ++k) {
        fathom_camera_look_at((double[3]){7 + k, 3 - k, -4}, (double[3]){1, 0.5 + k, 2},
                              (double[3]){0.1, 1, 0.2}, 0.7, &camera[k]);
        for (int i = 0; i < 12; ++i) {
            const double column[4] = {camera[k].x[i / 4], camera[k].y[i / 4], camera[k].z[i / 4],
                                      camera[k].origin[i / 4]};
            frames[12 * k + i] = column[i % 4];
        }
    }
    camera->shutter[0] = 0.5, camera->shutter[1] = 1.75;
    camera->key_count = 2, camera->key_times = times, camera->key_frames = frames;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, camera));
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = 1, s.settings.pattern = FATHOM_PATTERN_GRID;
    s.settings.motion_blur = false;
    fathom_film *film = stage_render(&s);
    bytes b = write_and_read(&s, film, false);
    check_points(&s, film, &b);
    free(b.at);
}

/* Blender takes the last part of a name for a component, and older versions know single letters alone. */
UNIT_TEST(every_channel_ends_in_a_single_letter) {
    stage s = askance(0);
    s.settings.aovs = FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
    fathom_film *film = stage_render(&s);
    bytes b = write_and_read(&s, film, false);
    size_t count = 0;
    /* "channels", "chlist", a size, then names, each with 16 bytes behind it, until there is none. */
    const char *at = find(&b, "channels\0chlist", 16);
    assert_non_null(at);
    for (at += 20; *at; at += strlen(at) + 1 + 16, ++count) {
        size_t length = strlen(at);
        if (length != 1 && at[length - 2] != '.') fail_msg("channel %s", at);
    }
    assert_int_equal(count, film->channel_count);
    free(b.at);
}

static bool stop_at_once(void *user, const fathom_progress *now) {
    (void)user;
    return now->phase != FATHOM_PHASE_RENDER;
}

UNIT_TEST(only_an_interrupted_film_says_so) {
    stage s = askance(0);
    s.settings.spp = 65536;
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    assert_int_equal(fathom_render(s.context, s.scene, &s.settings, stop_at_once, NULL, &stats, &film),
                     FATHOM_INTERRUPTED);
    assert_true(stats.finished >= 0 && stats.finished < 1);
    bytes b = write_and_read(&s, film, false);
    const char *text = unit_text("%.4f", stats.finished);
    const char *share = find(&b, "fathom:finished\0string", 23);
    assert_non_null(share);
    assert_memory_equal(share + 23 + 4, text, strlen(text));
    assert_non_null(find(&b, "fathom:interrupted", 18));
    free(b.at);
    fathom_film_destroy(film);
    s.settings.spp = 1;
    assert_ok(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, &stats, &film));
    assert_true(stats.finished == 1);
    b = write_and_read(&s, film, false);
    assert_null(find(&b, "fathom:interrupted", 18));
    free(b.at);
    fathom_film_destroy(film);
}

/* Makes a locale in the test's folder, and gives it to the process. False: this system cannot. */
static bool take_locale(const char *name) {
    char command[512];
    snprintf(command, sizeof command, "localedef -i %s -f UTF-8 %s >%s 2>&1", name, in_folder(name),
             in_folder("log"));
    const bool made = system(command) == 0 && setenv("LOCPATH", folder, 1) == 0 && setlocale(LC_ALL, name);
    snprintf(command, sizeof command, "rm -r %s/*", folder);
    assert_int_equal(system(command), 0);
    return made;
}

static bytes write_to(stage *s, const fathom_film *film, const char *name) {
    const fathom_write_options options = {.size = sizeof options, .exposure = 0.5f};
    assert_ok(s->context, fathom_film_write(s->context, film, in_folder(name), &options));
    bytes b = read_whole(in_folder(name));
    return b;
}

/* German has a decimal comma, and Turkish an i without a dot for the capital I. */
UNIT_TEST(files_do_not_depend_on_the_locale) {
    static const char *const locales[] = {"de_DE", "tr_TR"}, *const files[] = {"a.exr", "a.png"};
    const fathom_write_options plain = {.size = sizeof plain};
    stage s = askance(0);
    s.settings.fireflies = FATHOM_FIREFLIES_REWEIGHT;
    s.settings.pattern = FATHOM_PATTERN_SOBOL, s.settings.spp = 4;
    assert_int_equal(setenv("SOURCE_DATE_EPOCH", "0", 1), 0);
    for (size_t i = 0; i < 2; ++i) {
        fathom_film *film, *second;
        bytes expected[2], found;
        assert_ok(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film));
        assert_ok(s.context, fathom_film_reweight(s.context, film, &second));
        for (int k = 0; k < 2; ++k) expected[k] = write_to(&s, second, files[k]);
        fathom_film_destroy(second);
        const bool made = take_locale(locales[i]);
        assert_ok(s.context, fathom_film_reweight(s.context, film, &second));
        for (int k = 0; k < 2; ++k) {
            found = write_to(&s, second, files[k]);
            assert_int_equal(found.size, expected[k].size);
            assert_memory_equal(found.at, expected[k].at, found.size);
            free(found.at), free(expected[k].at);
        }
        assert_true(fathom_write_needs_helper("a.TIF", &plain));
        setlocale(LC_ALL, "C");
        fathom_film_destroy(second);
        fathom_film_destroy(film);
        if (!made) print_message("no locale %s: nothing was tested\n", locales[i]);
    }
    assert_int_equal(unsetenv("SOURCE_DATE_EPOCH"), 0);
}

int main(void) { return unit_main(open_folder, remove_folder); }
