/* Fireflies: taken out of the second image, and kept in the first. */
#include "film/film.h"

#include "render.h"

#include <string.h>

enum { SIDE = 32, SAMPLES = 16 };

/* An image of 32 x 32 pixels of a plate that sends out this radiance, 32 units across, from far away. */
static stage plate(float radiance) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.spp = SAMPLES;
    s.settings.fireflies = FATHOM_FIREFLIES_REWEIGHT;
    stage_camera(&s, (double[3]){0, 0, 1600}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 2 * atan(0.01));
    stage_quad(&s, (double[3]){0, 0, 0}, (double[3]){20, 0, 0}, (double[3]){0, 20, 0},
               stage_emitter(&s, radiance));
    return s;
}

static fathom_film *second_of(stage *s, const fathom_film *film) {
    fathom_film *second;
    assert_ok(s->context, fathom_film_reweight(s->context, film, &second));
    assert_non_null(second);
    return own_film(second);
}

/* Lamps of a tenth of a pixel across in every eighth pixel. How many samples meet one follows from the
 * pixel's value. The one that a single sample met is no part of the second image, whatever it sends out;
 * without it the others are (SAMPLES - 1) / SAMPLES. The sums are of doubles; the film's floats are off by
 * 2^-24 of them. */
UNIT_TEST(a_sample_that_no_other_confirms_is_left_out) {
    uint32_t single = 0;
    for (float lamp = 1e3f; lamp < 1e7f; lamp *= 10) {
        stage s = plate(1);
        const fathom_id material = stage_emitter(&s, lamp);
        for (int y = 2; y < SIDE; y += 4) {
            for (int x = 2; x < SIDE; x += 4)
                stage_sphere(&s, x - SIDE / 2 + 0.5, SIDE / 2 - y - 0.5, 1, 0.1, material);
        }
        fathom_film *film = stage_render(&s), *second = second_of(&s, film);
        for (size_t i = 0; i < SIDE * SIDE; ++i) {
            const double met = ((double)film->rgb[0][i] - 1) * SAMPLES / ((double)lamp - 1);
            if (fabs(met - 1) > 0.01) continue;
            ++single;
            assert_true(fabs((double)second->rgb[0][i] - (SAMPLES - 1.0) / SAMPLES) <= 0x1p-22);
        }
    }
    assert_true(single > 20);
}

/* Samples of a pixel that met the lamp, or on the mean in the 3 x 3 pixels around it: the larger of both. */
static double lamp_count(const fathom_film *film, float lamp, int x, int y) {
    double sum = 0, own = 0;
    int pixels = 0;
    for (int v = y - 1; v <= y + 1; ++v) {
        for (int u = x - 1; u <= x + 1; ++u) {
            if (u < 0 || v < 0 || u >= SIDE || v >= SIDE) continue;
            const double met = ((double)film->rgb[0][v * SIDE + u] - 1) * SAMPLES / ((double)lamp - 1);
            sum += met, ++pixels;
            if (u == x && v == y) own = met;
        }
    }
    return fmax(own, sum / pixels);
}

/* Five confirm each other. At a lamp's edge the pixels inside confirm those that it hardly fills. */
UNIT_TEST(what_five_samples_around_confirm_keeps_its_bits) {
    const float lamp = 1e4f;
    stage s = plate(1);
    stage_quad(&s, (double[3]){0.3, 0.2, 1}, (double[3]){5, 2, 0}, (double[3]){-2, 5, 0},
               stage_emitter(&s, lamp));
    fathom_film *film = stage_render(&s), *second = second_of(&s, film);
    int edge = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double value = (double)film->rgb[0][i];
        if (lamp_count(film, lamp, i % SIDE, i / SIDE) < 5.01) continue;
        edge += value > 1 && value < 5.0 / SAMPLES * (double)lamp;
        assert_true(film->rgb[0][i] == second->rgb[0][i]);
    }
    assert_true(edge > 4);
}

/* Samples of a pixel that are within a factor of 1.5 have the weight 1 (film/fireflies.c), from two on. The
 * floor's brightness spans several cascades. */
UNIT_TEST(a_smooth_image_keeps_its_bits) {
    for (int k = 0; k < 6; ++k) {
        stage s = stage_open(SIDE, SIDE);
        fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
        s.settings.target_error = k == 5 ? 0.01 : 0, s.settings.spp = k == 5 ? 64 : 1u << k;
        s.settings.fireflies = FATHOM_FIREFLIES_REWEIGHT;
        stage_camera(&s, (double[3]){0, 3, 6}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.6);
        stage_plane(&s, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.8f));
        stage_point_light(&s, 0.5, 0.6, 1, 30);
        fathom_film *film = stage_render(&s), *second = second_of(&s, film);
        for (int c = 0; c < 3; ++c)
            assert_memory_equal(film->rgb[c], second->rgb[c], SIDE * SIDE * sizeof(float));
    }
}

UNIT_TEST(the_first_image_is_the_same_with_and_without) {
    for (int k = 0; k < 3; ++k) {
        stage s = plate(1);
        stage_sphere(&s, 3, 2, 6, 5, stage_lambert(&s, 0.5f));
        stage_sphere(&s, -7, 4, 3, 0.05, stage_emitter(&s, 1e4f));
        s.settings.aovs = FATHOM_AOV_DIRECT | FATHOM_AOV_ERROR | FATHOM_AOV_CRYPTO_OBJECT | FATHOM_AOV_Z;
        if (k == 1) s.settings.target_error = 0.02, s.settings.spp = 256;
        if (k == 2)
            fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_CLASSIC), s.settings.aovs = 0;
        fathom_film *with = stage_render(&s);
        s.settings.fireflies = FATHOM_FIREFLIES_KEEP;
        fathom_film *without = stage_render(&s), *second;
        assert_ok(s.context, fathom_film_reweight(s.context, without, &second));
        assert_null(second);
        for (uint32_t i = 0; i < without->channel_count; ++i) {
            const film_channel *c = &without->channels[i];
            const void *same = c->is_id ? (const void *)fathom_film_channel_id(with, c->name)
                                        : fathom_film_channel(with, c->name);
            assert_memory_equal(c->data, same, SIDE * SIDE * sizeof(float));
        }
    }
}

/* A cascade and its neighbours count each sample once, whatever its brightness. Cascade k is in slot k modulo
 * 12, so its sum gives the same count whatever multiple of 36 octaves is taken off. */
UNIT_TEST(cascades_add_up_and_count) {
    static float radiance[3][WAVE_SLOTS];
    static double sums[3 * FIREFLY_CASCADES][WAVE_SLOTS];
    const wave_samples samples = {.radiance = {radiance[0], radiance[1], radiance[2]}};
    for (double brightness = 0x1p-100; brightness < 0x1p100; brightness *= 1.37) {
        for (uint32_t octave = 0; octave < 3; ++octave) {
            double total[3] = {0}, count = 0;
            memset(sums, 0, sizeof sums);
            for (int c = 0; c < 3; ++c) radiance[c][5] = (float)brightness * (0.5f + 0.5f * (float)c);
            fireflies_add(&samples, 0, octave, sums, 16);
            for (int k = 0; k < (int)FIREFLY_CASCADES; ++k) {
                double grey = 0;
                for (int c = 0; c < 3; ++c)
                    total[c] += sums[3 * k + c][16 + 5], grey += sums[3 * k + c][16 + 5] / 3;
                if (grey <= 0) continue;
                const double sum = log2(grey) - 3 * k - octave, own = exp2(sum - 36 * floor((sum + 18) / 36));
                count += own < 2 ? own : 0;
            }
            for (int c = 0; c < 3; ++c)
                assert_true(fabs(total[c] - (double)radiance[c][5]) <= 0x1p-50 * total[c]);
            /* Less than 2^-18 of a sample counts for a darker cascade. */
            assert_true(fabs(count - 1) <= 0x1p-18);
        }
    }
}

static fathom_film *lamps(float factor, fathom_film **second) {
    stage s = plate(0.25f * factor);
    const fathom_id lamp = stage_emitter(&s, 1e4f * factor);
    for (int i = 2; i < SIDE; i += 4) stage_sphere(&s, i - SIDE / 2 + 0.5, 0.3 * i, 1, 0.1, lamp);
    fathom_film *film = stage_render(&s);
    *second = second_of(&s, film);
    return film;
}

UNIT_TEST(lights_brighter_by_a_power_of_two_keep_their_weights) {
    static const int powers[] = {1, 2, 23, -1, -11, -60};
    fathom_film *expected, *film = lamps(1, &expected);
    assert_memory_not_equal(film->rgb[0], expected->rgb[0], SIDE * SIDE * sizeof(float));
    for (size_t k = 0; k < sizeof powers / sizeof *powers; ++k) {
        fathom_film *second;
        lamps(ldexpf(1, powers[k]), &second);
        for (int i = 0; i < SIDE * SIDE; ++i)
            assert_true(second->rgb[0][i] == ldexpf(expected->rgb[0][i], powers[k]));
    }
}

int main(void) { return unit_main(NULL, NULL); }
