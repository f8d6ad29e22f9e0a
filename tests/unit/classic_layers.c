/* Layers of light of classic ray tracing, where a sample has several paths at a time: the order of its sums
 * does not depend on the paths of other samples. */
#include "render.h"

enum { SIDE = 48 };

static const char *const channels[] = {"indirect.R", "indirect.G", "indirect.B", "R", "G", "B"};

/* Balls of glass before a sky, over a floor that ambient light shows. */
static fathom_film *render_glass(const uint32_t crop[4], uint32_t samples) {
    stage s = stage_open(SIDE, SIDE);
    fathom_material glass = default_material();
    for (int c = 0; c < 3; ++c)
        glass.k_d[c] = 0.01f * (float)(c + 1), glass.k_t[c] = glass.k_r[c] = 0.9f - 0.1f * (float)c;
    glass.fresnel = true;
    const fathom_id material = stage_material(&s, &glass);
    for (int k = 0; k < 9; ++k)
        stage_sphere(&s, 1.1 * (k % 3 - 1), 1.1 * (k / 3 - 1), 0.3 * k, 0.5, material);
    stage_plane(&s, (double[]){0, -1.7, 0}, (double[]){0, 1, 0}, stage_lambert(&s, 0.6f));
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[]){0.21f, 0.33f, 0.57f}));
    assert_ok(s.context, fathom_scene_set_ambient(s.scene, (float[]){0.13f, 0.27f, 0.11f}));
    stage_point_light(&s, 1, 5, 4, 20);
    stage_camera(&s, (double[]){0, 0.3, 7}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.6);
    s.settings.aovs = FATHOM_AOV_INDIRECT, s.settings.spp = samples;
    memcpy(s.settings.crop, crop, sizeof s.settings.crop);
    fathom_film *film = stage_render(&s);
    return film;
}

UNIT_TEST(a_crop_has_the_bits_of_the_whole) {
    static const uint32_t whole[4] = {0, 0, SIDE, SIDE};
    fathom_film *all = render_glass(whole, 4);
    for (uint32_t k = 0; k < 8; ++k) {
        const uint32_t crop[4] = {3 + k, 5 + 2 * k, 40 - k, 37 - k}, width = crop[2] - crop[0];
        fathom_film *part = render_glass(crop, 4);
        for (size_t c = 0; c < sizeof channels / sizeof *channels; ++c) {
            const float *from = fathom_film_channel(all, channels[c]),
                        *cut = fathom_film_channel(part, channels[c]);
            for (uint32_t y = crop[1]; y < crop[3]; ++y)
                assert_memory_equal(cut + (y - crop[1]) * width, from + y * SIDE + crop[0],
                                    width * sizeof *cut);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
