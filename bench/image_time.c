/* What a first image takes at the least, by programs that do nothing else:
 *
 *   bench_image_time trace FILE.glb THREADS QUALITY FLAGS EYE TOWARD FOVY LIGHT...
 *     maps the file, hands its first mesh to Embree where it lies, builds, traces 1280x720 camera rays from
 * EYE TOWARD a direction and for each hit a shadow ray to each light that is before it, in packets of 16, and
 *     leaves. QUALITY is low, medium or high, FLAGS robust or default; FOVY in degrees; EYE and TOWARD are
 *     x,y,z; a LIGHT is x,y,z for a point, or sun:x,y,z for the direction towards it.
 *   bench_image_time load MODULE
 *     loads the image module and leaves.
 *   bench_image_time touch
 *     writes to a gigabyte and a half of memory and leaves: what runs next finds it with the virtual machine.
 *
 * Only Embree's own interface is used here, so that nothing of the renderer can make both alike. */
#if FATHOM_EMBREE_MAJOR == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <dlfcn.h>
#include <fcntl.h>
#include <jansson.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

#define WIDTH 1280
#define HEIGHT 720
#define TILE 32
#define LIGHTS_MAX 16
#define THREADS_MAX 64

typedef struct vec3 {
    float x, y, z;
} vec3;

typedef struct light {
    vec3 at; /* the point, or the direction towards a sun */
    bool is_sun;
} light;

typedef struct job {
    RTCScene scene;
    vec3 eye, corner, across, down; /* the direction through (x, y) is corner + x across + y down */
    light lights[LIGHTS_MAX];
    int light_count;
    atomic_int next_tile;
    _Atomic unsigned long camera_rays, shadow_rays, lit; /* told so that nothing is left out as unused */
} job;

static _Noreturn void die(const char *what) {
    fprintf(stderr, "bench_image_time: %s\n", what);
    exit(2);
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static vec3 add(vec3 a, float s, vec3 b) { return (vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z}; }
static float dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec3 unit(vec3 a) { return add((vec3){0, 0, 0}, 1 / sqrtf(dot(a, a)), a); }
static vec3 cross(vec3 a, vec3 b) {
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* ---- the mesh ---- */

typedef struct mesh {
    const unsigned char *bytes, *binary;
    json_t *json;
} mesh;

static mesh map_glb(const char *path) {
    int file = open(path, O_RDONLY);
    struct stat info;
    if (file < 0 || fstat(file, &info) != 0) die("the mesh cannot be opened");
    mesh m = {.bytes = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, file, 0)};
    if (m.bytes == MAP_FAILED || info.st_size < 20) die("the mesh cannot be mapped");
    uint32_t length; /* header: magic, version, length; then chunks of length, type, bytes */
    memcpy(&length, m.bytes + 12, sizeof length);
    m.json = json_loadb((const char *)m.bytes + 20, length, 0, NULL);
    m.binary = m.bytes + 20 + length + 8;
    if (!m.json) die("the mesh is no GLB");
    return m;
}

static json_t *item(const mesh *m, const char *list, const json_t *index) {
    return json_array_get(json_object_get(m->json, list), (size_t)json_integer_value(index));
}

static void set_buffer(RTCGeometry geometry, enum RTCBufferType type, enum RTCFormat format, size_t stride,
                       const mesh *m, const json_t *accessor, size_t per_item) {
    const json_t *view = item(m, "bufferViews", json_object_get(accessor, "bufferView"));
    size_t offset = (size_t)json_integer_value(json_object_get(view, "byteOffset"));
    size_t count = (size_t)json_integer_value(json_object_get(accessor, "count")) / per_item;
    rtcSetSharedGeometryBuffer(geometry, type, 0, format, m->binary, offset, stride, count);
}

static RTCScene build(const mesh *m, unsigned threads, const char *quality, const char *flags) {
    enum RTCBuildQuality q = quality[0] == 'l'   ? RTC_BUILD_QUALITY_LOW
                             : quality[0] == 'h' ? RTC_BUILD_QUALITY_HIGH
                                                 : RTC_BUILD_QUALITY_MEDIUM;
    char config[64];
    snprintf(config, sizeof config, "threads=%u", threads);
    RTCDevice device = rtcNewDevice(config);
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const json_t *first = json_array_get(json_object_get(m->json, "meshes"), 0);
    const json_t *part = json_array_get(json_object_get(first, "primitives"), 0);
    const json_t *position = json_object_get(json_object_get(part, "attributes"), "POSITION");
    set_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 12, m, item(m, "accessors", position), 1);
    set_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 12, m,
               item(m, "accessors", json_object_get(part, "indices")), 3);
    rtcSetGeometryBuildQuality(geometry, q);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcSetSceneFlags(scene, flags[0] == 'r' ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene, q);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) die("Embree failed to build");
    return scene;
}

/* ---- rays ---- */

#if FATHOM_EMBREE_MAJOR == 4
static void closest(RTCScene scene, const int *valid, struct RTCRayHit16 *rays) {
    struct RTCIntersectArguments args;
    rtcInitIntersectArguments(&args);
    args.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect16(valid, scene, rays, &args);
}
static void any(RTCScene scene, const int *valid, struct RTCRay16 *rays) {
    struct RTCOccludedArguments args;
    rtcInitOccludedArguments(&args);
    args.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcOccluded16(valid, scene, rays, &args);
}
#else
static void closest(RTCScene scene, const int *valid, struct RTCRayHit16 *rays) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect16(valid, scene, &context, rays);
}
static void any(RTCScene scene, const int *valid, struct RTCRay16 *rays) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded16(valid, scene, &context, rays);
}
#endif

static void set_ray(struct RTCRay16 *rays, int i, vec3 org, vec3 dir, float t_near, float t_far) {
    rays->org_x[i] = org.x, rays->org_y[i] = org.y, rays->org_z[i] = org.z;
    rays->dir_x[i] = dir.x, rays->dir_y[i] = dir.y, rays->dir_z[i] = dir.z;
    rays->tnear[i] = t_near, rays->tfar[i] = t_far;
    rays->time[i] = 0, rays->mask[i] = 1, rays->id[i] = 0, rays->flags[i] = 0;
}

/* Shadow rays of a packet's hits to one light, where it is on the viewer's side. */
static void shadows(job *j, const light *l, const struct RTCRayHit16 *seen) {
    _Alignas(64) struct RTCRay16 rays;
    _Alignas(64) int valid[16];
    unsigned long count = 0, lit = 0;
    for (int i = 0; i < 16; ++i) {
        valid[i] = 0;
        if (seen->hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
        vec3 dir = {seen->ray.dir_x[i], seen->ray.dir_y[i], seen->ray.dir_z[i]};
        vec3 normal = {seen->hit.Ng_x[i], seen->hit.Ng_y[i], seen->hit.Ng_z[i]};
        vec3 at = add(j->eye, seen->ray.tfar[i], dir);
        vec3 to = l->is_sun ? l->at : add(l->at, -1, at);
        if ((dot(normal, to) > 0) == (dot(normal, dir) > 0)) continue;
        float distance = l->is_sun ? INFINITY : sqrtf(dot(to, to));
        set_ray(&rays, i, at, unit(to), 1e-5f, distance);
        valid[i] = -1;
        ++count;
    }
    if (!count) return;
    any(j->scene, valid, &rays);
    for (int i = 0; i < 16; ++i) lit += valid[i] && rays.tfar[i] >= 0;
    atomic_fetch_add_explicit(&j->shadow_rays, count, memory_order_relaxed);
    atomic_fetch_add_explicit(&j->lit, lit, memory_order_relaxed);
}

static void square(job *j, int left, int top) {
    _Alignas(64) struct RTCRayHit16 rays;
    _Alignas(64) int valid[16];
    for (int i = 0; i < 16; ++i) {
        float x = (float)(left + i % 4) + 0.5f, y = (float)(top + i / 4) + 0.5f;
        set_ray(&rays.ray, i, j->eye, unit(add(add(j->corner, x, j->across), y, j->down)), 0, INFINITY);
        rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        valid[i] = -1;
    }
    closest(j->scene, valid, &rays);
    for (int k = 0; k < j->light_count; ++k) shadows(j, &j->lights[k], &rays);
    atomic_fetch_add_explicit(&j->camera_rays, 16, memory_order_relaxed);
}

static void *trace(void *user) {
    job *j = user;
    int across = (WIDTH + TILE - 1) / TILE, down = (HEIGHT + TILE - 1) / TILE, tile;
#if defined(__SSE2__)
    _mm_setcsr(_mm_getcsr() | 0x8040); /* denormals are zero, as Embree wants */
#endif
    while ((tile = atomic_fetch_add(&j->next_tile, 1)) < across * down) {
        int left = tile % across * TILE, top = tile / across * TILE;
        for (int y = top; y < top + TILE && y < HEIGHT; y += 4)
            for (int x = left; x < left + TILE && x < WIDTH; x += 4) square(j, x, y);
    }
    return NULL;
}

/* ---- the whole ---- */

static vec3 parse(const char *text) {
    vec3 v;
    if (sscanf(text, "%f,%f,%f", &v.x, &v.y, &v.z) != 3) die("expected x,y,z");
    return v;
}

static void set_camera(job *j, vec3 toward, float fovy) {
    vec3 z = unit(toward), x = unit(cross(z, (vec3){0, 1, 0})), y = cross(z, x); /* y is down */
    float pixel = 2 * tanf(fovy * 0.00872664626f) / HEIGHT;
    j->across = add((vec3){0, 0, 0}, pixel, x);
    j->down = add((vec3){0, 0, 0}, pixel, y);
    j->corner = add(add(z, -0.5f * WIDTH, j->across), -0.5f * HEIGHT, j->down);
}

static void run(job *j, int threads) {
    pthread_t others[THREADS_MAX];
    for (int i = 1; i < threads; ++i) pthread_create(&others[i], NULL, trace, j);
    trace(j);
    for (int i = 1; i < threads; ++i) pthread_join(others[i], NULL);
}

static int trace_glb(char **argv) {
    static job j;
    int threads = atoi(argv[1]);
    if (threads < 1 || threads > THREADS_MAX) die("expected 1 to 64 threads");
    double began = now();
    mesh m = map_glb(argv[0]);
    j.eye = parse(argv[4]);
    set_camera(&j, parse(argv[5]), (float)atof(argv[6]));
    for (char **arg = argv + 7; *arg && j.light_count < LIGHTS_MAX; ++arg) {
        bool is_sun = strncmp(*arg, "sun:", 4) == 0;
        j.lights[j.light_count++] = (light){parse(*arg + (is_sun ? 4 : 0)), is_sun};
    }
    double opened = now();
    j.scene = build(&m, (unsigned)threads, argv[2], argv[3]);
    double built = now();
    run(&j, threads);
    printf("read %.4f build %.4f trace %.4f camera %lu shadow %lu lit %lu\n", opened - began, built - opened,
           now() - built, j.camera_rays, j.shadow_rays, j.lit);
    fflush(stdout);
    _exit(0);
}

static int touch(void) {
    size_t bytes = (size_t)3 << 29;
    char *memory = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) die("out of memory");
    madvise(memory, bytes, MADV_HUGEPAGE);
    memset(memory, 1, bytes);
    _exit(memory[bytes / 2] == 1 ? 0 : 1);
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "touch") == 0) return touch();
    if (argc >= 10 && strcmp(argv[1], "trace") == 0) return trace_glb(argv + 2);
    if (argc != 3 || strcmp(argv[1], "load") != 0)
        die("expected trace, load or touch; see the first lines of its source");
    if (!dlopen(argv[2], RTLD_NOW | RTLD_LOCAL)) die(dlerror());
    _exit(0);
}
