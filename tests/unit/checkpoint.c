/* Checkpoints: what is saved comes back to the last bit, and nothing else is ever taken for it. */
#include "base/file.h"
#include "base/hash.h"
#include "film/film.h"
#include "job/adaptive_record.h"
#include "job/checkpoint/checkpoint_state.h"
#include "job/checkpoint/checkpoint_write.h"
#include "scene/scene.h"
#include "scene/settings.h"

#include "random.h"
#include "render.h"
#include "unit_folder.h"

#include <sys/stat.h>
#include <unistd.h>

#define SQUARES_RECORD ((size_t)64 * 28) /* what a wave's record says of the squares of a run */

/* ---- a scene with all that a pixel may depend on, and renders of it ---- */

static stage st;
static char path[256];
static fathom_checkpoint saving;
static int ticks; /* of progress while rendering, after which it stops */

static void fill_scene(stage *s, float k_d, float light) {
    static const double eye[3] = {0, 1, 4}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0}, center[3] = {0, -1, 0},
                        u[3] = {3, 0, 0}, v[3] = {0, 0, -3};
    fathom_material mirror = default_material();
    for (int c = 0; c < 3; ++c) mirror.k_r[c] = 0.6f, mirror.k_d[c] = 0.2f;
    stage_camera(s, eye, target, up, 0.8);
    stage_sphere(s, -1, 0, 0, 0.8, stage_material(s, &mirror));
    stage_quad(s, center, u, v, stage_lambert(s, 0.7f));
    stage_mesh_sphere(s, FATHOM_ROOT, 8, 12, stage_lambert(s, k_d));
    stage_point_light(s, 2, 4, 3, light);
}

static int set_up(void **state) {
    (void)state;
    snprintf(path, sizeof path, "%s", in_folder("c"));
    ticks = 0;
    st = stage_open(106, 70);
    st.settings.crop[0] = 3, st.settings.crop[1] = 5, st.settings.crop[2] = 102, st.settings.crop[3] = 69;
    st.settings.aovs = FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_N | FATHOM_AOV_P | FATHOM_AOV_ALBEDO |
                       FATHOM_AOV_ID | FATHOM_AOV_SAMPLES;
    st.settings.pattern = FATHOM_PATTERN_SOBOL;
    fill_scene(&st, 0.5f, 20);
    fathom_checkpoint_default(&saving);
    saving.path = path;
    return 0;
}

static bool is_there(void) { return access(path, F_OK) == 0; }

static bool stop_after(void *user, const fathom_progress *now) {
    (void)user;
    return now->phase != FATHOM_PHASE_RENDER || ticks-- > 0;
}

static fathom_status render(unsigned threads, fathom_stats *stats, fathom_film **out) {
    fathom_context_set_threads(st.context, threads);
    fathom_session_options options = default_session_options();
    options.checkpoint = &saving, options.progress = stop_after;
    return fathom_session_run(st.context, st.scene, &st.settings, &options, stats, out);
}

/* Stopped again and again, each time on another number of threads. Returns how often. */
static int render_in_parts(fathom_film **out) {
    fathom_stats stats = {.size = sizeof stats};
    for (int part = 0;; ++part) {
        ticks = part;
        fathom_status status = render(1 + (unsigned)part % 3, &stats, out);
        if (part) assert_true(stats.resumed_seconds > 0);
        if (status == FATHOM_OK) return part;
        assert_int_equal(status, FATHOM_INTERRUPTED);
        assert_true(is_there());
        assert_true(stats.checkpoints >= 1);
        fathom_film_destroy(*out);
        saving.resume = true;
    }
}

static void assert_same_film(const fathom_film *a, const fathom_film *b) {
    assert_int_equal(a->channel_count, b->channel_count);
    size_t bytes = (size_t)a->width * a->height * sizeof(float);
    for (uint32_t i = 0; i < a->channel_count; ++i)
        assert_memory_equal(a->channels[i].data, b->channels[i].data, bytes);
}

/* ---- what is saved comes back ---- */

/* Too few samples on most machines; try_parts() gives as many as it takes to be stopped so often. */
#define FIRST_SPP 16u
#define LEAST_STOPS 2
/* Minutes on any machine: for renders that are always stopped. */
#define ENDLESS_SPP 65536u

/* True when the render was stopped often enough; if it ended before, another try gets more samples. */
static bool try_parts(fathom_film **whole, fathom_film **parts) {
    const bool resume = saving.resume;
    *whole = stage_render(&st);
    if (render_in_parts(parts) >= LEAST_STOPS) return true;
    fathom_film_destroy(*parts);
    unlink(path);
    saving.resume = resume;
    st.settings.spp *= 2;
    return false;
}

static fathom_film *assert_parts_make_the_whole(void) {
    fathom_film *whole, *parts;
    st.settings.spp = FIRST_SPP;
    while (!try_parts(&whole, &parts)) assert_true(st.settings.spp < ENDLESS_SPP);
    assert_same_film(whole, parts);
    assert_int_equal(parts->stats.samples, whole->stats.samples);
    assert_true(parts->stats.error_estimate == whole->stats.error_estimate);
    fathom_film_destroy(parts);
    return whole;
}

UNIT_TEST(even_samples_continue) { assert_parts_make_the_whole(); }

UNIT_TEST(samples_to_an_error_continue) {
    st.settings.target_error = 1e-4;
    saving.every = 0; /* every pass is kept */
    assert_parts_make_the_whole();
}

/* With time for all samples the clock decides nothing. Even samples are of the same groups if errors are
 * asked for. */
UNIT_TEST(samples_to_a_time_continue) {
    st.settings.integrator = FATHOM_INTEGRATOR_PATH;
    st.settings.max_time = 1e6, st.settings.aovs = FATHOM_AOV_ERROR;
    fathom_film *timed = assert_parts_make_the_whole();
    st.settings.max_time = 0;
    fathom_film *untimed = stage_render(&st);
    assert_same_film(timed, untimed);
}

/* What was spent counts: a time that is over leaves what was sampled. */
UNIT_TEST(spent_time_counts) {
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    st.settings.spp = ENDLESS_SPP;
    st.settings.max_time = 1000;
    ticks = 8;
    assert_int_equal(render(2, &stats, &film), FATHOM_INTERRUPTED);
    fathom_film_destroy(film);
    st.settings.max_time = 1e-6;
    saving.resume = true;
    ticks = 1000;
    assert_ok(st.context, render(2, &stats, &film));
    assert_true(stats.samples > 0);
    fathom_film_destroy(film);
}

static bool want_always(void *user) {
    (void)user;
    return true;
}

static void count_saves(void *user, fathom_status status, const char *message, double fraction) {
    assert_int_equal(status, FATHOM_OK);
    assert_string_equal(message, "");
    assert_true(fraction >= 0 && fraction <= 1);
    ++*(int *)user;
}

UNIT_TEST(program_asks_for_saves) {
    int saves = 0;
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    st.settings.spp = ENDLESS_SPP;
    saving.every = 1e6;
    saving.wanted = want_always, saving.saved = count_saves, saving.user = &saves;
    ticks = 3;
    assert_int_equal(render(1, &stats, &film), FATHOM_INTERRUPTED);
    assert_true(saves >= 1);
    assert_int_equal(stats.checkpoints, saves);
    assert_true(stats.checkpoint_seconds > 0);
    fathom_film_destroy(film);
}

/* ---- files ---- */

UNIT_TEST(file_without_resume_is_kept) {
    fathom_film *film;
    FILE *file = fopen(path, "w");
    fputs("hours", file);
    fclose(file);
    assert_int_equal(render(1, NULL, &film), FATHOM_BAD_USAGE);
    assert_null(film);
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_size, 5);
    saving.resume = true;
    assert_int_equal(render(1, NULL, &film), FATHOM_BAD_INPUT);
    assert_non_null(strstr(fathom_context_message(st.context), "is not a checkpoint"));
}

static void count_warnings(void *user, const char *message) {
    *(int *)user += strstr(message, "there is no checkpoint yet") != NULL;
}

UNIT_TEST(nothing_to_resume_begins) {
    int warnings = 0;
    fathom_film *film, *whole = stage_render(&st);
    fathom_context_on_warning(st.context, count_warnings, &warnings);
    saving.resume = true;
    ticks = 1000;
    assert_ok(st.context, render(1, NULL, &film));
    assert_int_equal(warnings, 1);
    assert_same_film(whole, film);
    fathom_film_destroy(film);
}

UNIT_TEST(bad_requests_are_refused) {
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    fathom_checkpoint_default(NULL);
    saving.path = NULL;
    assert_int_equal(render(1, NULL, &film), FATHOM_BAD_USAGE);
    saving.path = path;
    saving.every = -1;
    assert_int_equal(render(1, NULL, &film), FATHOM_BAD_USAGE);
    saving.every = (double)NAN;
    assert_int_equal(render(1, NULL, &film), FATHOM_BAD_USAGE);
    saving.every = 1;
    saving.path = "/no/such/folder/c";
    assert_int_equal(render(1, NULL, &film), FATHOM_OUT_OF_RESOURCES);
    saving.path = folder;
    saving.resume = true;
    assert_int_equal(render(1, NULL, &film), FATHOM_OUT_OF_RESOURCES);
}

/* ---- another render ---- */

static void make_checkpoint(void) {
    fathom_film *film;
    st.settings.spp = ENDLESS_SPP;
    ticks = 0;
    assert_int_equal(render(1, NULL, &film), FATHOM_INTERRUPTED);
    fathom_film_destroy(film);
    saving.resume = true;
}

static void assert_refused(const char *saved, const char *now) {
    fathom_film *film;
    assert_int_equal(render(1, NULL, &film), FATHOM_BAD_INPUT);
    const char *message = fathom_context_message(st.context);
    if (!strstr(message, saved) || !strstr(message, now)) fail_msg("%s", message);
    assert_null(film);
}

#define REFUSED(field, value, saved, now)                                                                    \
    do {                                                                                                     \
        const fathom_settings before = st.settings;                                                          \
        st.settings.field = (value);                                                                         \
        assert_refused("saved with " saved ",", "has " now ";");                                             \
        st.settings = before;                                                                                \
    } while (0)

UNIT_TEST(other_settings_are_refused) {
    make_checkpoint();
    REFUSED(width, 107, "width 106", "107");
    REFUSED(height, 71, "height 70", "71");
    REFUSED(crop[0], 4, "--crop 3,5,102,69", "4,5,102,69");
    REFUSED(crop[1], 4, "--crop 3,5,102,69", "3,4,102,69");
    REFUSED(crop[2], 70, "--crop 3,5,102,69", "3,5,70,69");
    REFUSED(crop[3], 48, "--crop 3,5,102,69", "3,5,102,48");
    REFUSED(spp, 64, "--spp 65536", "64");
    REFUSED(pattern, FATHOM_PATTERN_STRATIFIED, "--pattern sobol", "stratified");
    REFUSED(seed, 7, "--seed 0", "7");
    REFUSED(target_error, 0.01, "--target-error off", "0.01");
    REFUSED(max_time, 5, "--max-time off", "on");
    REFUSED(max_depth, 3, "--max-depth 8", "3");
    REFUSED(min_weight, 0.25f, "--min-weight 1.5258789e-05", "0.25");
    REFUSED(max_loss, 0.25f, "a loss by --leave-out-below of 0", "0.25");
    REFUSED(max_relative_loss, 0.25f, "a loss by --leave-out-below of 0", "0.25");
    REFUSED(epsilon, 0.5, "--epsilon auto", "0.5");
    REFUSED(terminator_fix, false, "terminator fix true", "false");
    REFUSED(photons, false, "photons true", "false");
    REFUSED(aovs, 0x1f, "aovs alpha,Z,N,P,albedo,id,samples", "alpha,Z,N,P,albedo");
    st.settings.tracer = "bvh";
    assert_refused("the tracer Embree", "reference BVH");
}

UNIT_TEST(the_key_has_every_setting_that_pixels_depend_on) {
    fathom_settings plain = default_settings(), changed;
    checkpoint_key before, after;
    checkpoint_key_of(&plain, 1, &before);
    for (size_t i = 0; i < settings_table.count; ++i) {
        const fathom_parameter *p = &settings_table.rows[i];
        if (p->type == FATHOM_PARAMETER_TEXT) continue; /* the tracer has a place of its own */
        fathom_settings_default(&changed);
        parameter_set_number(p, &changed, parameter_count(p) / 2, p->fallback == 1 ? 0 : 1);
        checkpoint_key_of(&changed, 1, &after);
        const bool same = memcmp(&before, &after, sizeof before) == 0;
        if (same == ((p->flags & FATHOM_PARAMETER_PIXELS) != 0)) fail_msg("%s", p->name);
    }
}

UNIT_TEST(what_no_pixel_depends_on_is_free) {
    fathom_film *film;
    make_checkpoint();
    st.settings.tile_size = 64, st.settings.block_width = 4;
    ticks = 0;
    assert_int_equal(render(3, NULL, &film), FATHOM_INTERRUPTED);
    fathom_film_destroy(film);
}

UNIT_TEST(other_scene_is_refused) {
    make_checkpoint();
    st.scene = new_scene(st.context);
    fill_scene(&st, 0.5000001f, 20);
    assert_refused("a scene of contents", "has 0x");
}

/* ---- scenes ---- */

static uint64_t fingerprint(const stage *s) {
    uint64_t number;
    assert_ok(s->context, scene_fingerprint(s->scene, &number));
    return number;
}

/* A mesh of one triangle over vertices that lie `stride` apart. */
static uint64_t fingerprint_of_mesh(size_t stride, float z, float between, uint32_t last) {
    stage s = stage_open(8, 8);
    float rows[4 * 8];
    const uint32_t index[] = {0, 1, last};
    for (size_t i = 0; i < 32; ++i) rows[i] = between;
    for (size_t i = 0; i < 4; ++i) {
        float *at = rows + i * stride / sizeof(float);
        at[0] = (float)(i & 1), at[1] = (float)(i / 2), at[2] = z;
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = rows, mesh.position_stride = stride, mesh.vertex_count = 4;
    mesh.indices = index, mesh.triangle_count = 1;
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
    uint64_t number = fingerprint(&s);
    return number;
}

UNIT_TEST(fingerprint_is_of_contents) {
    stage *s = &st;
    fathom_context_set_threads(s->context, 1);
    uint64_t before = fingerprint(s);
    fathom_context_set_threads(s->context, 4);
    assert_true(fingerprint(s) == before);
    assert_ok(s->context, fathom_scene_set_name(s->scene, "another name"));
    assert_true(fingerprint(s) == before);
    const float grey[3] = {0.1f, 0.1f, 0.1f};
    assert_ok(s->context, fathom_scene_set_background(s->scene, grey));
    uint64_t after = fingerprint(s);
    assert_true(after != before);
    stage_point_light(s, 0, 5, 0, 1);
    assert_true(fingerprint(s) != after);
    /* How rows lie in memory is no content; what they hold is. */
    uint64_t mesh = fingerprint_of_mesh(12, 1, 0, 2);
    assert_true(fingerprint_of_mesh(32, 1, 0, 2) == mesh);
    assert_true(fingerprint_of_mesh(32, 1, 5, 2) == mesh);
    assert_true(fingerprint_of_mesh(12, 1.0000001f, 0, 2) != mesh);
    assert_true(fingerprint_of_mesh(12, 1, 0, 3) != mesh);
}

static uint64_t hash_in_pieces(const unsigned char *bytes, size_t size, size_t piece) {
    hash h;
    hash_begin(&h);
    for (size_t at = 0; at < size; at += piece)
        hash_put(&h, bytes + at, size - at < piece ? size - at : piece);
    return hash_end(&h);
}

UNIT_TEST(hash_sees_every_bit_and_no_piece) {
    unsigned char bytes[203];
    for (size_t i = 0; i < sizeof bytes; ++i) bytes[i] = (unsigned char)(i * 37);
    for (size_t size = 0; size <= sizeof bytes; ++size) {
        uint64_t whole = hash_in_pieces(bytes, size, sizeof bytes);
        for (size_t piece = 1; piece < 70; ++piece) assert_true(hash_in_pieces(bytes, size, piece) == whole);
        if (size) assert_true(hash_in_pieces(bytes, size - 1, 64) != whole);
    }
    uint64_t whole = hash_in_pieces(bytes, sizeof bytes, 64);
    for (size_t bit = 0; bit < 8 * sizeof bytes; ++bit) {
        bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
        assert_true(hash_in_pieces(bytes, sizeof bytes, 64) != whole);
        bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
}

/* ---- bytes of strangers ---- */

/* One thread reads them: ThreadSanitizer has nothing to find there, and takes half a minute. */
#ifdef __SANITIZE_THREAD__
#define SKIP_WITH_THREAD_SANITIZER() skip()
#else
#define SKIP_WITH_THREAD_SANITIZER() (void)0
#endif

typedef struct file {
    unsigned char *bytes;
    size_t size;
    fathom_film *film;
    checkpoint_key key;
    fathom_context *context;
    film_parts parts;
} file;

/* A small checkpoint with finished squares and a record. */
static void make_file(file *f) {
    stage *s = &st;
    s->settings.width = 36, s->settings.height = 10;
    memset(s->settings.crop, 0, sizeof s->settings.crop);
    s->settings.target_error = 0.1, s->settings.spp = 64;
    s->settings.aovs = FATHOM_AOV_Z;
    *f = (file){.film = stage_render(s), .context = s->context, .parts = {.hits = true}};
    checkpoint_key_of(&s->settings, 1234, &f->key);
    strcpy(f->key.tracer, "a tracer");
    checkpoint_state state;
    checkpoint_write room;
    assert_true(checkpoint_state_create(&s->settings, f->film, f->parts, &state));
    assert_true(checkpoint_write_create(&state, f->film, &room));
    assert_int_equal(state.grid.count, 2);
    const wave_region shown = wave_grid_region(&state.grid, 1);
    state.squares[1] = wave_region_bits(shown);
    state.records[0] = calloc(1, adaptive_record_bytes(f->parts));
    for (size_t k = 0; k < WAVE_SQUARES; ++k) {
        double *errors = (double *)(void *)state.records[0];
        errors[k] = errors[SQUARES_RECORD / sizeof *errors + k] = INFINITY;
    }
    state.samples = 99, state.error = 0.25;
    room.rays = 5, room.seconds = 1.5;
    pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    atomic_bool give_up = false;
    assert_ok(s->context, checkpoint_write_file(s->context, &room, path, &f->key, NULL, f->film, &state,
                                                &lock, &give_up));
    checkpoint_write_destroy(&room);
    checkpoint_state_destroy(&state);
    file_map map;
    assert_ok(s->context, file_open(s->context, path, &map));
    f->size = map.size;
    f->bytes = malloc(map.size);
    unit_own(f->bytes, free);
    memcpy(f->bytes, map.bytes, map.size);
    file_close(&map);
}

static fathom_status read_state(const file *f, const unsigned char *bytes, size_t size,
                                checkpoint_state *state) {
    char tracer[128];
    assert_true(checkpoint_state_create(&f->film->settings, f->film, f->parts, state));
    return checkpoint_read(f->context, "file", bytes, size, &f->key, f->film, state, tracer);
}

/* Bytes of exactly this size, so that a sanitizer sees a step beyond them. */
static fathom_status read_bytes(const file *f, const unsigned char *bytes, size_t size) {
    checkpoint_state state;
    unsigned char *own = malloc(size + !size);
    memcpy(own, bytes, size);
    fathom_status status = read_state(f, own, size, &state);
    checkpoint_state_destroy(&state);
    free(own);
    return status;
}

static void seal(file *f) {
    const uint64_t sum = hash_of(f->bytes, f->size - 8);
    memcpy(f->bytes + f->size - 8, &sum, sizeof sum);
}

UNIT_TEST(bytes_come_back) {
    file f;
    checkpoint_state read;
    make_file(&f);
    size_t bytes = (size_t)f.film->width * f.film->height * f.film->channel_count * sizeof(float);
    float *pixels = unit_memory(bytes);
    memcpy(pixels, f.film->pixels, bytes);
    memset(f.film->pixels, 0, bytes);
    assert_ok(f.context, read_state(&f, f.bytes, f.size, &read));
    assert_int_equal(read.samples, 99);
    assert_int_equal(read.rays, 5);
    assert_true(read.error == 0.25 && read.seconds == 1.5);
    assert_non_null(read.records[0]);
    assert_null(read.records[1]);
    for (uint32_t c = 0; c < f.film->channel_count; ++c) {
        for (uint32_t y = 0; y < 10; ++y) {
            const float *row = (const float *)f.film->channels[c].data + y * 36;
            const float *wanted = pixels + ((size_t)c * 10 + y) * 36;
            for (uint32_t x = 0; x < 32; ++x) assert_true(row[x] == 0);
            assert_memory_equal(row + 32, wanted + 32, 4 * sizeof(float));
        }
    }
    checkpoint_state_destroy(&read);
}

UNIT_TEST(no_part_is_taken_for_the_whole) {
    SKIP_WITH_THREAD_SANITIZER();
    file f;
    make_file(&f);
    for (size_t size = 0; size < f.size; size += size < 1000 || f.size - size < 1000 ? 1 : 97)
        assert_int_equal(read_bytes(&f, f.bytes, size), FATHOM_BAD_INPUT);
    unsigned char *longer = unit_memory(f.size + 9);
    memcpy(longer, f.bytes, f.size);
    for (size_t more = 1; more < 10; ++more)
        assert_int_equal(read_bytes(&f, longer, f.size + more), FATHOM_BAD_INPUT);
}

UNIT_TEST(no_flipped_bit_goes_unseen) {
    SKIP_WITH_THREAD_SANITIZER();
    file f;
    random_state random = {1};
    make_file(&f);
    for (size_t i = 0; i < 4000; ++i) {
        size_t bit = i < 8 * 340 ? i : random_bits(&random) % (8 * f.size); /* the head's, then any */
        f.bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
        checkpoint_state read;
        assert_int_equal(read_state(&f, f.bytes, f.size, &read), FATHOM_BAD_INPUT);
        checkpoint_state_destroy(&read);
        f.bytes[bit / 8] ^= (unsigned char)(1 << bit % 8);
    }
    assert_int_equal(read_bytes(&f, f.bytes, f.size), FATHOM_OK);
}

/* Whoever makes the checksum fit is told what is wrong, or does no harm. */
UNIT_TEST(forged_bytes_do_no_harm) {
    SKIP_WITH_THREAD_SANITIZER();
    file f;
    random_state random = {2};
    make_file(&f);
    const size_t head = 12 + sizeof(checkpoint_key), after = head + 8 + adaptive_record_bytes(f.parts);
    const struct {
        size_t at;
        uint64_t value;
        size_t bytes;
        const char *message;
    } cases[] = {
        {12 + 31, 'x', 1, "a text in its head has no end"},
        {head, 2, 4, "a record of a wave that there is not"},
        {head, 0xfffffffe, 4, "a record of a wave that there is not"},
        {head + 4, 1, 4, "it ends among the waves' records"},
        {head + 8, 0xfff8000000000000, 8, "a wave's record makes no sense"}, /* an error that is no number */
        {head + 8 + 64 * 24, 3, 4, "a wave's record makes no sense"},        /* samples: no power of two */
        {head + 8 + 64 * 24, 128, 4, "a wave's record makes no sense"},      /* more than spp */
        {head + 8, 0, 8, "a wave's record makes no sense"},                  /* an error over no rays */
        {head + 8 + SQUARES_RECORD, 0, 8, "a wave's record makes no sense"}, /* likewise, of the other run */
        {after, 0, 4, "a record of a wave that there is not"},               /* once more */
        {after + 8 + 16, 0xbff0000000000000, 8, "its error or time makes no sense"},
        {after + 8 + 24, 0x7ff0000000000000, 8, "its error or time makes no sense"},
        {after + 8 + 32 + 8, UINT64_MAX, 8, "a square beyond the film"},
        {after + 8 + 32 + 8, 0, 8, "it goes on after its end"},
        {after + 8 + 32, 1, 8, "it ends among the pixels"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        unsigned char kept[8];
        memcpy(kept, f.bytes + cases[i].at, 8);
        memcpy(f.bytes + cases[i].at, &cases[i].value, cases[i].bytes);
        seal(&f);
        assert_int_equal(read_bytes(&f, f.bytes, f.size), FATHOM_BAD_INPUT);
        if (!strstr(fathom_context_message(f.context), cases[i].message))
            fail_msg("%zu: %s", i, fathom_context_message(f.context));
        memcpy(f.bytes + cases[i].at, kept, 8);
    }
    for (int i = 0; i < 2000; ++i) {
        size_t at = random_bits(&random) % (f.size - 8);
        unsigned char kept = f.bytes[at];
        f.bytes[at] = (unsigned char)random_bits(&random);
        seal(&f);
        fathom_status status = read_bytes(&f, f.bytes, f.size);
        assert_true(status == FATHOM_OK || status == FATHOM_BAD_INPUT);
        f.bytes[at] = kept;
    }
}

int main(void) {
    unit_each(set_up, NULL);
    return unit_main(open_folder, remove_folder);
}
