/* The library from several threads at once: contexts side by side, one scene under several renders, one
 * tracer under several threads. Each gives what it gives alone, to the bit, and says what is wrong to its own
 * context alone. */
#include "render.h"

#include <pthread.h>

#define SIDE 64
#define AT_ONCE 3

static const char *const channels[] = {"R", "G", "B", "Z", "N.X"};
enum { CHANNELS = sizeof channels / sizeof *channels };

static const char *const tracers[] = {"embree", "bvh:f32", "embree:user:high"};

/* A mirror, glass, a mesh and two lights: of another size for each index. */
static void fill(stage *s, unsigned index) {
    fathom_material glass = default_material();
    for (int c = 0; c < 3; ++c) glass.k_r[c] = 0.2f, glass.k_t[c] = 0.8f, glass.k_d[c] = 0;
    glass.fresnel = true;
    stage_sphere(s, -1, 0, -6, 1 + 0.1 * index, stage_material(s, &glass));
    stage_plane(s, (double[3]){0, -1.5, 0}, (double[3]){0, 1, 0}, stage_lambert(s, 0.7f));
    fathom_generate_options options = default_generate_options();
    options.triangles = 2000 + 1000 * index, options.seed = index;
    fathom_instance instance = default_instance();
    const fathom_id group = new_group(s->scene, "mesh");
    assert_ok(s->context, fathom_scene_generate(s->scene, group, &options));
    instance.group = group, instance.transform[3] = 1, instance.transform[11] = -7;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
    fathom_light light = default_light();
    light.position[0] = 2, light.position[1] = 5, light.intensity[0] = 30;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
    light.position[0] = -4, light.intensity[1] = 9;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

static fathom_settings settings_of(unsigned index) {
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = settings.height = SIDE;
    settings.spp = 4, settings.aovs = FATHOM_AOV_Z | FATHOM_AOV_N;
    settings.tracer = tracers[index % 3];
    return settings;
}

static void assert_same_film(const fathom_film *a, const fathom_film *b) {
    for (int i = 0; i < CHANNELS; ++i) {
        assert_memory_equal(fathom_film_channel(a, channels[i]), fathom_film_channel(b, channels[i]),
                            sizeof(float) * SIDE * SIDE);
    }
}

/* ---- a context and a scene each ---- */

typedef struct job {
    unsigned index;
    const fathom_scene *scene; /* NULL: one of its own */
    fathom_film *film;
    char message[256];
} job;

/* No assertions on threads: cmocka's would leave by a jump to another thread's stack. */
static void *run_shared(void *user) {
    job *j = user;
    fathom_context *context;
    if (fathom_context_create(&context) != FATHOM_OK) return NULL;
    fathom_context_set_threads(context, j->index + 1);
    fathom_settings settings = settings_of(j->index);
    if (fathom_render(context, j->scene, &settings, NULL, NULL, NULL, &j->film) != FATHOM_OK)
        snprintf(j->message, sizeof j->message, "%s", fathom_context_message(context));
    fathom_context_destroy(context);
    return NULL;
}

static void run_all(job *jobs, void *(*run)(void *)) {
    pthread_t threads[AT_ONCE];
    for (unsigned i = 0; i < AT_ONCE; ++i) {
        jobs[i].index = i;
        assert_int_equal(pthread_create(&threads[i], NULL, run, &jobs[i]), 0);
    }
    for (unsigned i = 0; i < AT_ONCE; ++i) assert_int_equal(pthread_join(threads[i], NULL), 0);
}

static void take_films(job *jobs, fathom_film *const *alone) {
    for (unsigned i = 0; i < AT_ONCE; ++i) {
        if (!jobs[i].film) fail_msg("render %u: %s", i, jobs[i].message);
        assert_same_film(jobs[i].film, alone[i]);
        fathom_film_destroy(jobs[i].film);
        jobs[i].film = NULL;
    }
}

UNIT_TEST(contexts_side_by_side) {
    stage stages[AT_ONCE];
    fathom_film *alone[AT_ONCE];
    job jobs[AT_ONCE] = {0};
    for (unsigned i = 0; i < AT_ONCE; ++i) {
        stages[i] = stage_open(SIDE, SIDE);
        fill(&stages[i], i);
        stages[i].settings = settings_of(i);
        alone[i] = stage_render(&stages[i]);
        jobs[i].scene = stages[i].scene;
    }
    run_all(jobs, run_shared);
    take_films(jobs, alone);
}

/* From the scene's first call on, not renders alone. */
static void *read_and_render(void *user) {
    job *j = user;
    fathom_context *context;
    fathom_scene *scene = NULL;
    if (fathom_context_create(&context) != FATHOM_OK) return NULL;
    fathom_settings settings = settings_of(0);
    fathom_status status = fathom_scene_read(context, SOURCE_DIR "/scenes/tour/11-mirror.json", &scene);
    if (status == FATHOM_OK) status = fathom_render(context, scene, &settings, NULL, NULL, NULL, &j->film);
    if (status != FATHOM_OK) snprintf(j->message, sizeof j->message, "%s", fathom_context_message(context));
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return NULL;
}

UNIT_TEST(reading_side_by_side) {
    job first = {0}, jobs[AT_ONCE] = {0};
    read_and_render(&first);
    if (!first.film) fail_msg("%s", first.message);
    fathom_film *const alone[AT_ONCE] = {first.film, first.film, first.film};
    run_all(jobs, read_and_render);
    take_films(jobs, alone);
    fathom_film_destroy(first.film);
}

/* What include/fathom/base.h promises; sanitizers take several times as much. */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SMALL_STACK ((size_t)1 << 20)
#else
#define SMALL_STACK ((size_t)64 << 10)
#endif

UNIT_TEST(small_stack_is_enough) {
    job usual = {0}, small = {0};
    read_and_render(&usual);
    pthread_attr_t attributes;
    pthread_t thread;
    assert_int_equal(pthread_attr_init(&attributes), 0);
    assert_int_equal(pthread_attr_setstacksize(&attributes, SMALL_STACK), 0);
    assert_int_equal(pthread_create(&thread, &attributes, read_and_render, &small), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    pthread_attr_destroy(&attributes);
    if (!small.film) fail_msg("%s", small.message);
    assert_same_film(usual.film, small.film);
    fathom_film_destroy(usual.film);
    fathom_film_destroy(small.film);
}

/* ---- one scene ---- */

UNIT_TEST(one_scene_under_several_renders) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s, 1);
    fathom_film *alone[AT_ONCE];
    job jobs[AT_ONCE] = {0};
    for (unsigned i = 0; i < AT_ONCE; ++i) {
        s.settings = settings_of(i);
        alone[i] = stage_render(&s);
        jobs[i].scene = s.scene;
    }
    run_all(jobs, run_shared);
    take_films(jobs, alone);
}

static void count_warning(void *user, const char *message) {
    (void)message;
    ++*(unsigned *)user;
}

/* What a render has to say goes to the context that it was given, not to the scene's. */
UNIT_TEST(messages_go_to_the_renders_context) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s, 0);
    static const float line[] = {0, 0, 0, 1, 1, 1, 2, 2, 2, 0, 0, 0, 0};
    static const uint32_t corners[] = {0, 1, 2};
    fathom_mesh flat = default_mesh();
    flat.positions = line, flat.vertex_count = 3, flat.indices = corners, flat.triangle_count = 1;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &flat, NULL));
    fathom_context *other;
    unsigned scenes_warnings = 0, others_warnings = 0;
    assert_int_equal(fathom_context_create(&other), FATHOM_OK);
    fathom_context_on_warning(s.context, count_warning, &scenes_warnings);
    fathom_context_on_warning(other, count_warning, &others_warnings);
    fathom_context_set_threads(other, 3);
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    assert_ok(other, fathom_render(other, s.scene, &s.settings, NULL, NULL, &stats, &film));
    fathom_film_destroy(film);
    assert_int_equal(scenes_warnings, 0);
    assert_int_equal(others_warnings, 1);
    assert_int_equal(stats.threads, 3);
    /* A cycle is only found when the scene is whole. */
    fathom_instance loop = default_instance();
    assert_ok(s.context, fathom_scene_add_group(s.scene, "loop", &loop.group));
    loop.parent = loop.group;
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &loop, NULL));
    fathom_tracer *tracer;
    assert_fails(other, fathom_render(other, s.scene, &s.settings, NULL, NULL, NULL, &film), FATHOM_BAD_INPUT,
                 "in a cycle");
    assert_fails(other, fathom_tracer_create(other, s.scene, "embree", &tracer), FATHOM_BAD_INPUT,
                 "in a cycle");
    assert_string_equal(fathom_context_message(s.context), "");
    fathom_context_destroy(other);
}

/* ---- one tracer ---- */

enum { RAYS = 500 };

typedef struct aim {
    const fathom_tracer *tracer;
    fathom_ray rays[RAYS];
    fathom_hit hits[RAYS];
    fathom_status status, refused;
} aim;

static void aim_rays(aim *a, const fathom_tracer *tracer, unsigned index) {
    a->tracer = tracer;
    for (unsigned i = 0; i < RAYS; ++i) {
        a->rays[i] = (fathom_ray){
            .direction = {0.01 * (i % 25) - 0.12, 0.01 * (double)(i / 25) - 0.1, -1 - (double)index},
            .t_max = HUGE_VAL};
    }
}

static void *shoot(void *user) {
    aim *a = user;
    a->status = fathom_tracer_closest(a->tracer, a->rays, RAYS, a->hits);
    fathom_ray none = {.t_max = 1};
    bool any;
    a->refused = fathom_tracer_any(a->tracer, &none, 1, &any);
    return NULL;
}

UNIT_TEST(one_tracer_under_several_threads) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s, 2);
    for (int kind = 0; kind < 2; ++kind) {
        fathom_tracer *tracer;
        assert_ok(s.context,
                  fathom_tracer_create(s.context, s.scene, kind ? "reference" : "embree", &tracer));
        static aim alone[AT_ONCE], together[AT_ONCE];
        pthread_t threads[AT_ONCE];
        memset(alone, 0, sizeof alone), memset(together, 0, sizeof together);
        for (unsigned i = 0; i < AT_ONCE; ++i) {
            aim_rays(&alone[i], tracer, i), aim_rays(&together[i], tracer, i);
            shoot(&alone[i]);
        }
        for (unsigned i = 0; i < AT_ONCE; ++i)
            assert_int_equal(pthread_create(&threads[i], NULL, shoot, &together[i]), 0);
        for (unsigned i = 0; i < AT_ONCE; ++i) assert_int_equal(pthread_join(threads[i], NULL), 0);
        for (unsigned i = 0; i < AT_ONCE; ++i) {
            assert_int_equal(together[i].status, FATHOM_OK);
            assert_int_equal(together[i].refused, FATHOM_BAD_USAGE);
            assert_memory_equal(together[i].hits, alone[i].hits, sizeof alone[i].hits);
        }
        assert_non_null(strstr(fathom_context_message(s.context), "rays[0]: direction: is zero"));
        fathom_tracer_destroy(tracer);
    }
}

int main(void) { return unit_main(NULL, NULL); }
