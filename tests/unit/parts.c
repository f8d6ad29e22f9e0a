/* Parts of a render: merged, they are the render to the last bit; and nothing else is ever merged. */
#include "film/sum_tree.h"
#include "job/part/part_file.h"

#include "random.h"
#include "render.h"
#include "unit_folder.h"

#include <float.h>
#include <sys/stat.h>
#include <unistd.h>

#define PARTS_MAX 16

static stage st;
static char paths[PARTS_MAX][256];
static const char *names[PARTS_MAX];
static const float *exposure;

static int set_up(void **state) {
    static const double eye[3] = {0, 1, 4}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0}, center[3] = {0, -1, 0},
                        u[3] = {3, 0, 0}, v[3] = {0, 0, -3};
    (void)state;
    exposure = NULL;
    for (int i = 0; i < PARTS_MAX; ++i) {
        snprintf(paths[i], sizeof paths[i], "%s", in_folder(unit_text("%d.part", i + 1)));
        names[i] = paths[i];
    }
    st = stage_open(106, 70);
    fathom_material mirror = default_material();
    for (int c = 0; c < 3; ++c) mirror.k_r[c] = 0.6f, mirror.k_d[c] = 0.2f;
    stage_camera(&st, eye, target, up, 0.8);
    stage_sphere(&st, -1, 0, 0, 0.8, stage_material(&st, &mirror));
    stage_sphere(&st, 1, 1, 0, 0.4, stage_emitter(&st, 3));
    stage_quad(&st, center, u, v, stage_lambert(&st, 0.7f));
    stage_point_light(&st, 2, 4, 3, 20);
    return 0;
}

static void remove_parts(void) {
    for (int i = 0; i < PARTS_MAX; ++i) unlink(paths[i]);
}

static fathom_status render_to(const char *path, uint32_t index, uint32_t count, fathom_split split) {
    fathom_part part = default_part();
    part.path = path, part.index = index, part.count = count, part.split = split;
    part.exposure = exposure;
    fathom_session_options options = default_session_options();
    options.part = &part;
    fathom_film *film;
    fathom_context_set_threads(st.context, 1 + index % 3);
    fathom_status status = fathom_session_run(st.context, st.scene, &st.settings, &options, NULL, &film);
    fathom_film_destroy(film);
    return status;
}

static void render_parts(uint32_t count, fathom_split split) {
    for (uint32_t i = 1; i <= count; ++i) assert_ok(st.context, render_to(paths[i - 1], i, count, split));
}

static void assert_same_film(const fathom_film *a, const fathom_film *b) {
    assert_int_equal(a->channel_count, b->channel_count);
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    size_t bytes = (size_t)a->width * a->height * sizeof(float);
    for (uint32_t i = 0; i < a->channel_count; ++i)
        assert_memory_equal(a->channels[i].data, b->channels[i].data, bytes);
}

static void assert_parts_make(const fathom_film *whole, uint32_t count, fathom_split split) {
    fathom_film *merged;
    fathom_stats stats = {.size = sizeof stats};
    render_parts(count, split);
    /* In any order. */
    const char *first = names[0];
    names[0] = names[count - 1], names[count - 1] = first;
    assert_ok(st.context, fathom_parts_merge(st.context, names, count, &stats, &merged));
    names[count - 1] = names[0], names[0] = first;
    assert_same_film(whole, merged);
    assert_int_equal(stats.samples, whole->stats.samples);
    assert_int_equal(stats.camera_rays, whole->stats.camera_rays);
    assert_true(stats.error_estimate == whole->stats.error_estimate);
    fathom_film_destroy(merged);
    remove_parts();
}

/* ---- the same bits ---- */

UNIT_TEST(samples_make_the_whole) {
    static const uint32_t spp[] = {1, 4, 5, 37, 16, 64};
    static const uint32_t crop[] = {3, 5, 102, 69};
    st.settings.pattern = FATHOM_PATTERN_SOBOL;
    for (uint32_t i = 0; i < (SANITIZED ? 8 : 12); ++i) {
        st.settings.integrator = i % 2 ? FATHOM_INTEGRATOR_PATH : FATHOM_INTEGRATOR_CLASSIC;
        st.settings.spp = spp[i / 2];
        st.settings.aovs = i % 3 ? FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR : 0;
        if (i % 4 == 3) st.settings.aovs = FATHOM_AOV_ERROR;
        if (i == 6) memcpy(st.settings.crop, crop, sizeof crop);
        const uint32_t leaves = sum_leaves(spp[i / 2]);
        fathom_film *whole = stage_render(&st);
        if (!SANITIZED) assert_parts_make(whole, 1, FATHOM_SPLIT_SAMPLES);
        if (!SANITIZED && leaves > 1) assert_parts_make(whole, 2, FATHOM_SPLIT_SAMPLES);
        assert_parts_make(whole, leaves < 7 ? leaves : 7, FATHOM_SPLIT_SAMPLES);
    }
}

/* Means at the edge of a black ball before the dimmest background are no normal floats: those who merge flush
 * them to zero as those who render do. */
UNIT_TEST(the_dimmest_light_is_the_wholes) {
    assert_ok(st.context, fathom_scene_set_background(st.scene, (float[3]){FLT_MIN, FLT_MIN, 0}));
    stage_sphere(&st, -1.2, 1.6, 0, 0.3, stage_lambert(&st, 0));
    st.settings.integrator = FATHOM_INTEGRATOR_PATH, st.settings.spp = 16;
    st.settings.pattern = FATHOM_PATTERN_SOBOL;
    fathom_film *whole = stage_render(&st);
    assert_parts_make(whole, 3, FATHOM_SPLIT_SAMPLES);
}

UNIT_TEST(tiles_make_the_whole) {
    for (uint32_t i = 0; i < 4; ++i) {
        st.settings.spp = i % 2 ? 9 : 1;
        st.settings.pattern = FATHOM_PATTERN_GRID;
        st.settings.aovs = i % 2 ? FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR : 0;
        if (i > 1) st.settings.crop[2] = 70, st.settings.crop[3] = 41;
        fathom_film *whole = stage_render(&st);
        assert_parts_make(whole, 1, FATHOM_SPLIT_TILES);
        assert_parts_make(whole, 5, FATHOM_SPLIT_TILES);
        assert_parts_make(whole, PARTS_MAX, FATHOM_SPLIT_AUTO); /* more parts than tiles: some are empty */
    }
}

UNIT_TEST(tiles_to_an_error_make_the_whole) {
    st.settings.pattern = FATHOM_PATTERN_SOBOL;
    st.settings.target_error = 0.02, st.settings.spp = 64;
    st.settings.aovs = FATHOM_AOVS;
    for (int i = 0; i < 2; ++i) {
        st.settings.integrator = i ? FATHOM_INTEGRATOR_PATH : FATHOM_INTEGRATOR_CLASSIC;
        fathom_film *whole = stage_render(&st);
        assert_parts_make(whole, 3, FATHOM_SPLIT_AUTO);
    }
}

/* ---- the sums ---- */

static square_sums random_leaf(uint64_t seed) {
    square_sums s;
    memset(&s, 0, sizeof s);
    for (int k = 0; k < LANES; ++k)
        s.rgb[0][0][k] =
            ldexp(1 + (double)(seed * 0x9e3779b97f4a7c15u >> 11) * 0x1p-53, (int)(seed % 90) - 45 + k);
    return s;
}

static void push_leaves(const pixel_sums *like, uint32_t begin, uint32_t end, sum_stack *stack) {
    for (uint32_t i = begin; i < end; ++i) {
        stack->nodes[stack->count].first = i, stack->nodes[stack->count].level = 0;
        stack->nodes[stack->count].sums = random_leaf(i + 1);
        sum_push(like, stack);
    }
}

/* Over 90 powers of two, nearly every other order of additions rounds to other bits. */
UNIT_TEST(sums_do_not_depend_on_where_samples_are_cut) {
    const pixel_sums like = {.groups = 1, .kernels = film_kernels_best()};
    sum_node whole[64], part[64], merged[64];
    for (uint32_t leaves = 1; leaves < 70; ++leaves) {
        sum_stack all = {0, whole};
        push_leaves(&like, 0, leaves, &all);
        sum_fold(&like, &all);
        for (uint32_t count = 1; count <= leaves; ++count) {
            sum_stack sum = {0, merged};
            for (uint32_t i = 0; i < count; ++i) {
                const sum_range range = sum_part(leaves * SUM_LEAF, i, count);
                sum_node listed[64];
                sum_stack own = {0, part};
                push_leaves(&like, range.begin / SUM_LEAF, range.end / SUM_LEAF, &own);
                assert_int_equal(own.count, sum_list_nodes(range, listed));
                assert_true(own.count < sum_stack_depth(range));
                for (uint32_t k = 0; k < own.count; ++k) {
                    assert_int_equal(own.nodes[k].first, listed[k].first);
                    assert_int_equal(own.nodes[k].level, listed[k].level);
                    merged[sum.count] = own.nodes[k];
                    sum_push(&like, &sum);
                }
            }
            sum_fold(&like, &sum);
            assert_memory_equal(merged[0].sums.rgb, whole[0].sums.rgb, sizeof whole[0].sums.rgb);
        }
    }
}

UNIT_TEST(each_tile_is_of_one_part) {
    part_head head = {.index = 1, .split = FATHOM_SPLIT_TILES};
    fathom_settings_default(&head.settings);
    for (uint32_t width = 32; width < 1400; width += 171) {
        head.settings.width = width, head.settings.height = 300;
        for (head.count = 1; head.count < 40; head.count += 6) {
            part_shape s = part_shape_of(&head);
            uint32_t all = 0;
            for (s.index = 0; s.index < s.count; ++s.index) {
                uint32_t own = 0;
                for (uint32_t i = 0; i < s.grid.count; ++i) own += part_owns(&s, i);
                assert_true(own >= s.grid.count / s.count && own <= s.grid.count / s.count + 1);
                all += own;
            }
            assert_int_equal(all, s.grid.count);
        }
    }
}

/* ---- files that are cut off, damaged, missing, of another render ---- */

static void small(void) {
    st.settings.width = 64, st.settings.height = 64, st.settings.spp = 8;
    st.settings.pattern = FATHOM_PATTERN_SOBOL;
}

static unsigned char *read_all(const char *path, size_t *size) {
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    *size = (size_t)info.st_size;
    unsigned char *bytes = malloc(*size);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(bytes, 1, *size, file), *size);
    fclose(file);
    return bytes;
}

static fathom_status merge(uint32_t count, fathom_film **out) {
    return fathom_parts_merge(st.context, names, count, NULL, out);
}

/* Wherever a file ends, or a bit of it is turned: merging says so, and the same render mends it, unless it is
 * the head that is damaged. */
static void assert_mended(fathom_split split) {
    fathom_film *whole = stage_render(&st), *merged;
    size_t size;
    random_state random = {7};
    render_parts(2, split);
    unsigned char *bytes = read_all(paths[1], &size);
    for (int i = 0; i < 24; ++i) {
        const size_t at = i < 2 ? (size_t)i : random_bits(&random) % size;
        const bool cut = i % 2 == 0, head = at < sizeof(part_head) + sizeof(uint64_t);
        bytes[at] ^= 16;
        unit_write_file(paths[1], bytes, cut ? at : size);
        bytes[at] ^= 16;
        assert_int_equal(merge(2, &merged), FATHOM_BAD_INPUT);
        fathom_status status = render_to(paths[1], 2, 2, split);
        if (status != FATHOM_OK) {
            assert_int_equal(status, FATHOM_BAD_INPUT);
            assert_true(head && !cut);
            continue;
        }
        assert_ok(st.context, merge(2, &merged));
        assert_same_film(whole, merged);
        fathom_film_destroy(merged);
    }
    free(bytes);
}

UNIT_TEST(cut_or_damaged_parts_are_mended) {
    small();
    assert_mended(FATHOM_SPLIT_SAMPLES);
    remove_parts();
    assert_mended(FATHOM_SPLIT_TILES);
}

UNIT_TEST(parts_of_different_renders_are_refused) {
    fathom_film *film;
    small();
    render_parts(2, FATHOM_SPLIT_SAMPLES);
    st.settings.seed = 9;
    assert_fails(st.context, render_to(paths[1], 2, 2, FATHOM_SPLIT_SAMPLES), FATHOM_BAD_INPUT,
                 "2.part: the existing part was rendered with --seed 0, and this render has 9");
    unlink(paths[1]);
    assert_ok(st.context, render_to(paths[1], 2, 2, FATHOM_SPLIT_SAMPLES));
    assert_fails(st.context, merge(2, &film), FATHOM_BAD_INPUT,
                 "2.part: the part was rendered with --seed 9, and ");
    st.settings.seed = 0;
    assert_fails(st.context, render_to(paths[0], 2, 2, FATHOM_SPLIT_SAMPLES), FATHOM_BAD_INPUT,
                 "1.part: the existing part was rendered with the number 1 of 2, by samples, and this render "
                 "has 2 of 2, by samples");
    unlink(paths[1]);
    st.settings.tracer = "linear";
    assert_ok(st.context, render_to(paths[1], 2, 2, FATHOM_SPLIT_SAMPLES));
    assert_fails(st.context, merge(2, &film), FATHOM_BAD_INPUT,
                 "2.part: the part was rendered with the tracer ");
    assert_fails(st.context, render_to(paths[0], 1, 2, FATHOM_SPLIT_SAMPLES), FATHOM_BAD_INPUT,
                 "1.part: the existing part was rendered with the tracer ");
    st.settings.tracer = NULL;
    unlink(paths[1]);
    assert_ok(st.context, render_to(paths[1], 2, 2, FATHOM_SPLIT_TILES));
    assert_fails(st.context, merge(2, &film), FATHOM_BAD_INPUT, "rendered with a split by tiles, and ");
    unlink(paths[1]);
    stage_point_light(&st, 0, 4, 3, 20);
    assert_ok(st.context, render_to(paths[1], 2, 2, FATHOM_SPLIT_SAMPLES));
    assert_fails(st.context, merge(2, &film), FATHOM_BAD_INPUT, "rendered with a scene of contents ");
}

UNIT_TEST(missing_and_double_parts_are_named) {
    fathom_film *film;
    small();
    for (uint32_t i = 1; i <= 5; i += 2)
        assert_ok(st.context, render_to(paths[i / 2], i, 6, FATHOM_SPLIT_TILES));
    assert_fails(st.context, merge(3, &film), FATHOM_BAD_INPUT,
                 "1.part: is one of 6 parts, and missing are: 2, 4, 6");
    assert_ok(st.context, render_to(paths[3], 3, 6, FATHOM_SPLIT_TILES));
    assert_fails(st.context, merge(4, &film), FATHOM_BAD_INPUT, "4.part: is part 3 of 6, and so is ");
    unit_write_file(paths[1], "nothing", 7);
    assert_fails(st.context, merge(2, &film), FATHOM_BAD_INPUT, "2.part: is not a part of an image");
    assert_fails(st.context, render_to(paths[1], 3, 6, FATHOM_SPLIT_TILES), FATHOM_BAD_INPUT,
                 "2.part: is not a part of an image");
}

UNIT_TEST(what_cannot_be_split_is_refused) {
    small();
    assert_fails(st.context, render_to(paths[0], 1, 3, FATHOM_SPLIT_SAMPLES), FATHOM_BAD_USAGE,
                 "8 samples a pixel cannot be split into 3 parts");
    assert_fails(st.context, render_to(paths[0], 3, 2, FATHOM_SPLIT_AUTO), FATHOM_BAD_USAGE,
                 "found part 3 of 2");
    assert_fails(st.context, render_to(paths[0], 0, 2, FATHOM_SPLIT_AUTO), FATHOM_BAD_USAGE,
                 "found part 0 of 2");
    assert_fails(st.context, render_to(NULL, 1, 2, FATHOM_SPLIT_AUTO), FATHOM_BAD_USAGE, "path");
    st.settings.target_error = 0.1;
    assert_fails(st.context, render_to(paths[0], 1, 2, FATHOM_SPLIT_SAMPLES), FATHOM_BAD_USAGE,
                 "a render to an error cannot be split by samples");
    st.settings.target_error = 0, st.settings.max_time = 1;
    assert_fails(st.context, render_to(paths[0], 1, 2, FATHOM_SPLIT_TILES), FATHOM_BAD_USAGE,
                 "a render to a time cannot be split");
}

UNIT_TEST(the_merged_film_tells_the_parts_exposure) {
    static const float given = -3.5f, wrong[] = {128, -128, INFINITY, NAN};
    fathom_film *film;
    float found = 7;
    small();
    render_parts(2, FATHOM_SPLIT_TILES);
    assert_ok(st.context, merge(2, &film));
    assert_false(fathom_film_exposure(film, &found));
    fathom_film_destroy(film);
    remove_parts();
    exposure = &given;
    render_parts(2, FATHOM_SPLIT_SAMPLES);
    assert_ok(st.context, merge(2, &film));
    assert_true(fathom_film_exposure(film, &found) && found == given);
    fathom_film_destroy(film);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        exposure = &wrong[i];
        assert_fails(st.context, render_to(paths[2], 1, 2, FATHOM_SPLIT_AUTO), FATHOM_BAD_USAGE,
                     "part: expected an exposure below 128 stops, found ");
    }
}

int main(void) {
    unit_each(set_up, NULL);
    return unit_main(open_folder, remove_folder);
}
