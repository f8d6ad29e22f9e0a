/* Memory runs out at every one of the library's own requests in turn: each call then fails with its status, a
 * message and no result, and gives back all it took; or does without, and its result is the same. The program
 * is linked with --wrap, so that the requests pass through here. Those of other libraries: tests/cli/oom.sh.
 */
#include "scene/scene.h"
#include "unit.h"

#include <fathom/fathom.h>

#include <errno.h>
#include <jansson.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>

/* ---- requests ---- */

#define BLOCKS (1u << 18)
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static struct {
    const void *block;
    unsigned long request;
} blocks[BLOCKS]; /* what was given and not come back; open addressing, under the lock */
static unsigned long requests, failing, block_count;

static size_t slot_of(const void *block) { return (uintptr_t)block / 16 * 2654435761u % BLOCKS; }

static bool refuse(void) {
    pthread_mutex_lock(&lock);
    bool refused = ++requests == failing;
    pthread_mutex_unlock(&lock);
    if (refused) errno = ENOMEM;
    return refused;
}

static void *given(void *block) {
    if (!block) return NULL;
    pthread_mutex_lock(&lock);
    size_t i = slot_of(block);
    while (blocks[i].block) i = (i + 1) % BLOCKS;
    blocks[i].block = block, blocks[i].request = requests;
    ++block_count;
    pthread_mutex_unlock(&lock);
    return block;
}

/* What follows in the same run of slots moves up, where it still is found. */
static void close_gap(size_t gap) {
    for (size_t i = (gap + 1) % BLOCKS; blocks[i].block; i = (i + 1) % BLOCKS) {
        size_t home = slot_of(blocks[i].block);
        bool stays = gap <= i ? gap < home && home <= i : gap < home || home <= i;
        if (stays) continue;
        blocks[gap] = blocks[i];
        gap = i;
    }
    blocks[gap].block = NULL;
}

static void came_back(const void *block) {
    if (!block) return;
    pthread_mutex_lock(&lock);
    size_t i = slot_of(block);
    while (blocks[i].block && blocks[i].block != block) i = (i + 1) % BLOCKS;
    if (blocks[i].block) {
        close_gap(i);
        --block_count;
    }
    pthread_mutex_unlock(&lock);
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
char *__real_strdup(const char *text);
void __real_free(void *block);
FILE *__real_fopen(const char *path, const char *mode);
FILE *__real_fdopen(int descriptor, const char *mode);
void *__real_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset);
int __real_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user);

void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
char *__wrap_strdup(const char *text);
void __wrap_free(void *block);
FILE *__wrap_fopen(const char *path, const char *mode);
FILE *__wrap_fdopen(int descriptor, const char *mode);
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset);
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user);

void *__wrap_malloc(size_t size) { return refuse() ? NULL : given(__real_malloc(size)); }
void *__wrap_calloc(size_t count, size_t size) { return refuse() ? NULL : given(__real_calloc(count, size)); }
void *__wrap_realloc(void *old, size_t size) {
    if (refuse()) return NULL;
    came_back(old);
    return given(__real_realloc(old, size));
}
void *__wrap_aligned_alloc(size_t alignment, size_t size) {
    return refuse() ? NULL : given(__real_aligned_alloc(alignment, size));
}
char *__wrap_strdup(const char *text) { return refuse() ? NULL : given(__real_strdup(text)); }
void __wrap_free(void *block) {
    came_back(block);
    __real_free(block);
}
FILE *__wrap_fopen(const char *path, const char *mode) { return refuse() ? NULL : __real_fopen(path, mode); }
FILE *__wrap_fdopen(int descriptor, const char *mode) {
    return refuse() ? NULL : __real_fdopen(descriptor, mode);
}
void *__wrap_mmap(void *at, size_t size, int protection, int flags, int descriptor, off_t offset) {
    return refuse() ? MAP_FAILED : __real_mmap(at, size, protection, flags, descriptor, offset);
}
int __wrap_pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                          void *user) {
    return refuse() ? EAGAIN : __real_pthread_create(thread, attributes, run, user);
}

static void *json_take(size_t size) { return __wrap_malloc(size); }
static void json_return(void *block) { __wrap_free(block); }

/* ---- work ---- */

static char folder[64];

static const char *in_folder(const char *name) {
    static char paths[4][128];
    static unsigned next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static void put(const char *name, const char *text) {
    FILE *file = fopen(in_folder(name), "wb");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

static const char scene_json[] =
    "{ \"name\": \"a name that is longer than the first room for a string\",\n"
    "  \"camera\": { \"eye\": [0, 1.5, 5.12345678901234567], \"target\": [0, 0.7, 0], \"fovy\": 40 },\n"
    "  \"image\": { \"width\": 8, \"height\": 6, \"spp\": 4 }, \"background\": [0.2, 0.3, 0.4],\n"
    "  \"materials\": {\n"
    "    \"chrome\": { \"kd\": [0.1, 0.1, 0.1], \"kr\": [0.8, 0.8, 0.8] },\n"
    "    \"glass\": { \"kd\": [0, 0, 0], \"kt\": [0.9, 0.9, 0.9], \"ior\": 1.5 },\n"
    "    \"floor\": { \"kd\": [0.6, 0.5, 0.4] } },\n"
    "  \"lights\": [ { \"type\": \"point\", \"position\": [2, 4, 3], \"intensity\": 25 },\n"
    "    { \"type\": \"spot\", \"position\": [0, 4, 0], \"direction\": [0, -1, 0], \"intensity\": 9 } ],\n"
    "  \"groups\": { \"pair\": [\n"
    "    { \"type\": \"mesh\", \"file\": \"part.obj\" },\n"
    "    { \"type\": \"sphere\", \"center\": [0.5, 0.8, 0], \"radius\": 0.4, \"material\": \"glass\" } ] },\n"
    "  \"objects\": [\n"
    "    { \"type\": \"sphere\", \"center\": [-0.5, 0.8, 0], \"radius\": 0.5, \"material\": \"chrome\" },\n"
    "    { \"type\": \"quad\", \"center\": [0, 0, 0], \"u\": [3, 0, 0], \"v\": [0, 0, -3], \"material\": "
    "\"floor\" },\n"
    "    { \"type\": \"instance\", \"of\": \"pair\", \"translation\": [0.5, 0, 0] } ] }\n";

static const char part_obj[] = "mtllib part.mtl\nv -1 0 -1\nv 1 0 -1\nv 0 1 -1\nv 0 2 -2\nvn 0 0 1\nvt 0 0\n"
                               "usemtl red\nf 1/1/1 2/1/1 3/1/1\ng other\nusemtl none\nf 1 2 3 4\n";
static const char part_mtl[] = "newmtl red\nKd 0.8 0.1 0.1\nNs 10\nKs 0.2 0.2 0.2\n";
static const char part_ply[] =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    "3 0 1 2\n4 0 1 2 3\n";
static const char part_gltf[] =
    "{ \"asset\": { \"version\": \"2.0\" }, \"scene\": 0, \"scenes\": [ { \"nodes\": [0] } ],\n"
    "  \"nodes\": [ { \"mesh\": 0, \"children\": [1] }, { \"mesh\": 0, \"translation\": [1, 0, 0] } ],\n"
    "  \"materials\": [ { \"name\": \"red\" } ],\n"
    "  \"meshes\": [ { \"primitives\": [ { \"attributes\": { \"POSITION\": 0 }, \"material\": 0 } ] } ],\n"
    "  \"accessors\": [ { \"bufferView\": 0, \"componentType\": 5126, \"count\": 3, \"type\": \"VEC3\",\n"
    "    \"min\": [0, 0, 0], \"max\": [1, 1, 0] } ],\n"
    "  \"bufferViews\": [ { \"buffer\": 0, \"byteLength\": 36 } ],\n"
    "  \"buffers\": [ { \"byteLength\": 36, \"uri\": \"data:application/octet-stream;base64,"
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\" } ] }\n";

/* What a piece of work gives, to be compared: bytes added up. */
typedef struct outcome {
    uint64_t sum;
    size_t bytes;
} outcome;

static void add(outcome *o, const void *data, size_t bytes) {
    const unsigned char *from = data;
    for (size_t i = 0; i < bytes; ++i) o->sum = (o->sum ^ from[i]) * UINT64_C(1099511628211);
    o->bytes += bytes;
}

typedef fathom_status work_fn(fathom_context *context, const char *file, outcome *out);

static fathom_status render(fathom_context *context, const char *file, const char *tracer, outcome *out) {
    fathom_scene *scene;
    fathom_film *film;
    fathom_settings settings;
    fathom_status status = fathom_scene_read(context, in_folder(file), &scene);
    if (status != FATHOM_OK) {
        assert_null(scene);
        return status;
    }
    fathom_scene_settings(scene, &settings);
    settings.width = 8, settings.height = 6, settings.spp = 4;
    settings.aovs = FATHOM_AOV_ALPHA | FATHOM_AOV_Z | FATHOM_AOV_N;
    settings.tracer_spec = tracer;
    status = fathom_render(context, scene, &settings, NULL, NULL, NULL, &film);
    if (status == FATHOM_OK) {
        static const char *const channels[] = {"R", "G", "B", "A", "Z", "N.X"};
        for (size_t c = 0; c < sizeof channels / sizeof *channels; ++c)
            add(out, fathom_film_channel(film, channels[c]), 8 * 6 * sizeof(float));
        fathom_film_destroy(film);
    } else {
        assert_null(film);
    }
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status render_linear(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "linear", out);
}
static fathom_status render_bvh(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "bvh", out);
}
static fathom_status render_embree(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "embree", out);
}
static fathom_status render_user(fathom_context *context, const char *file, outcome *out) {
    return render(context, file, "embree:user", out);
}

static fathom_status write_mesh(fathom_context *context, const char *file, outcome *out) {
    const char *path = in_folder(file);
    fathom_scene *scene;
    unlink(path);
    fathom_status status = fathom_scene_read(context, in_folder("scene.json"), &scene);
    if (status != FATHOM_OK) return status;
    status = fathom_scene_write_mesh(scene, path);
    fathom_scene_destroy(scene);
    unsigned long keep = failing;
    failing = 0;
    FILE *made = fopen(path, "rb");
    failing = keep;
    assert_true((made != NULL) == (status == FATHOM_OK));
    char bytes[4096];
    for (size_t got; made && (got = fread(bytes, 1, sizeof bytes, made));) add(out, bytes, got);
    if (made) fclose(made);
    return status;
}

static fathom_status generate(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    (void)file;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return status;
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.kind = FATHOM_GENERATE_FOREST, options.triangles = 3000;
    status = fathom_scene_generate(scene, FATHOM_ROOT, &options);
    if (status == FATHOM_OK) add(out, &scene->instances.count, sizeof scene->instances.count);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status trace(fathom_context *context, const char *file, outcome *out) {
    fathom_scene *scene;
    fathom_tracer *tracer;
    fathom_status status = fathom_scene_read(context, in_folder(file), &scene);
    if (status != FATHOM_OK) return status;
    status = fathom_tracer_create(context, scene, FATHOM_TRACER_REFERENCE, &tracer);
    if (status == FATHOM_OK) {
        fathom_ray rays[20];
        fathom_hit hits[20];
        bool met[20];
        for (int i = 0; i < 20; ++i)
            rays[i] = (fathom_ray){{0, 1.5, 5}, {0.1 * (i - 10), -0.1, -1}, 0, (double)INFINITY};
        status = fathom_tracer_closest(tracer, rays, 20, hits);
        if (status == FATHOM_OK) status = fathom_tracer_any(tracer, rays, 20, met);
        for (int i = 0; i < 20 && status == FATHOM_OK; ++i) add(out, &hits[i].t, sizeof hits[i].t);
        fathom_tracer_destroy(tracer);
    } else {
        assert_null(tracer);
    }
    fathom_scene_destroy(scene);
    return status;
}

/* ---- every request in turn ---- */

static fathom_status attempt(work_fn *work, const char *file, outcome *out, bool *told) {
    fathom_context *context;
    *out = (outcome){0, 0};
    *told = true;
    if (fathom_context_create(&context) != FATHOM_OK) return FATHOM_OUT_OF_RESOURCES;
    fathom_context_set_threads(context, 1);
    fathom_status status = work(context, file, out);
    *told = status == FATHOM_OK || fathom_context_message(context)[0];
    if (status != FATHOM_OK && !failing) print_error("%s\n", fathom_context_message(context));
    fathom_context_destroy(context);
    return status;
}

static unsigned long leaked_request(unsigned long since) {
    for (size_t i = 0; i < BLOCKS; ++i) {
        if (blocks[i].block && blocks[i].request > since) return blocks[i].request - since;
    }
    return 0;
}

/* The first runs bring what stays: threads, tables. */
static void exhaust(work_fn *work, const char *file) {
    outcome good, now;
    bool told;
    failing = 0;
    for (int i = 0; i < 2; ++i) assert_int_equal(attempt(work, file, &good, &told), FATHOM_OK);
    unsigned long begin = requests, refused = 0, harmless = 0;
    assert_int_equal(attempt(work, file, &good, &told), FATHOM_OK);
    unsigned long count = requests - begin;
    assert_true(good.bytes > 0 && count > 10);
    for (unsigned long n = 1; n <= count; ++n) {
        unsigned long held = block_count, before = requests;
        failing = before + n;
        fathom_status status = attempt(work, file, &now, &told);
        failing = 0;
        if (status != FATHOM_OK && status != FATHOM_OUT_OF_RESOURCES)
            fail_msg("%s, request %lu: status %d", file, n, status);
        if (!told) fail_msg("%s, request %lu: no message", file, n);
        if (status == FATHOM_OK && (now.sum != good.sum || now.bytes != good.bytes))
            fail_msg("%s, request %lu: another result", file, n);
        if (block_count > held)
            fail_msg("%s, request %lu: %lu blocks leaked, one of them request %lu", file, n,
                     block_count - held, leaked_request(before));
        refused += status != FATHOM_OK;
        harmless += status == FATHOM_OK;
    }
    assert_true(refused > 0);
    print_message("%s: %lu requests, %lu refused, %lu done without\n", file, count, refused, harmless);
}

static void reading_and_rendering(void **state) {
    (void)state;
    exhaust(render_linear, "scene.json");
    exhaust(render_linear, "part.obj");
    exhaust(render_linear, "part.ply");
    exhaust(render_linear, "part.gltf");
    exhaust(render_linear, "part.glb");
}

static void tracers(void **state) {
    (void)state;
    exhaust(render_bvh, "scene.json");
    exhaust(render_embree, "scene.json");
    exhaust(render_user, "scene.json");
    exhaust(trace, "scene.json");
}

static void writing_and_generating(void **state) {
    (void)state;
    exhaust(write_mesh, "made.glb");
    exhaust(write_mesh, "made.ply");
    exhaust(write_mesh, "made.obj");
    exhaust(generate, "forest");
}

static int set_up(void **state) {
    (void)state;
    json_set_alloc_funcs(json_take, json_return);
    snprintf(folder, sizeof folder, "/tmp/fathom-oom-XXXXXX");
    assert_non_null(mkdtemp(folder));
    put("scene.json", scene_json), put("part.obj", part_obj), put("part.mtl", part_mtl);
    put("part.ply", part_ply), put("part.gltf", part_gltf);
    fathom_context *context;
    fathom_scene *scene;
    assert_int_equal(fathom_context_create(&context), FATHOM_OK);
    assert_ok(context, fathom_scene_read(context, in_folder("part.gltf"), &scene));
    assert_ok(context, fathom_scene_write_mesh(scene, in_folder("part.glb")));
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return 0;
}

/* Nothing is left but what was put there. */
static int tear_down(void **state) {
    (void)state;
    static const char *const names[] = {"scene.json", "part.obj", "part.mtl", "part.ply", "part.gltf",
                                        "part.glb",   "made.glb", "made.ply", "made.obj", "made.mtl"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) unlink(in_folder(names[i]));
    return rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reading_and_rendering),
        cmocka_unit_test(tracers),
        cmocka_unit_test(writing_and_generating),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
