/* What slips through closed meshes, and what it costs that nothing does. See watertight.sh.
 *   watertight count FILE RAYS SPEC…     rays at vertices from inside: missed before and after the repair
 *   watertight cost FILE REPEATS         a frame's camera rays with and without the repair, interleaved */
#include "trace/watertight/watertight.h"
#include "base/clock.h"
#include "camera/camera.h"
#include "trace/search.h"
#include "verify/search/rays.h"

#include <fathom/fathom.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void need(bool fine, fathom_context *context) {
    if (fine) return;
    fprintf(stderr, "watertight: %s\n", fathom_context_message(context));
    exit(1);
}

/* Of this thread alone: other processes are not counted. */
static double thread_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

typedef struct subject {
    fathom_context *context;
    fathom_scene *scene;
    world *world;
    trace_tracer *tracer;
    watertight *water;
} subject;

static void read_scene(subject *s, const char *file) {
    memset(s, 0, sizeof *s);
    need(fathom_context_create(&s->context) == FATHOM_OK, s->context);
    need(fathom_scene_read(s->context, file, &s->scene) == FATHOM_OK, s->context);
    need(world_create(s->scene, &s->world) == FATHOM_OK, s->context);
}

/* Returns the seconds that the search for closed meshes took. */
static double make_tracer(subject *s, const char *words) {
    trace_spec spec;
    need(trace_spec_parse(s->context, words, &spec) == FATHOM_OK, s->context);
    trace_options options = {.spec = &spec, .width = LANES};
    need(trace_create(s->context, s->world, &options, &s->tracer) == FATHOM_OK, s->context);
    double began = clock_seconds();
    need(watertight_create(s->context, s->tracer, &s->water) == FATHOM_OK, s->context);
    return clock_seconds() - began;
}

static void drop_tracer(subject *s) {
    watertight_destroy(s->water);
    trace_destroy(s->tracer);
}

static void close_scene(subject *s) {
    world_destroy(s->world);
    fathom_scene_destroy(s->scene);
    fathom_context_destroy(s->context);
}

/* ---- count ---- */

typedef struct counts {
    uint64_t rays, missed, left, lit, lit_left;
} counts;

/* From the middle half of the first mesh's box at its vertices: all of these rays must hit. */
static void aim(const fathom_mesh *m, rays_random *r, vec3_f64 center, double radius, trace_rays *rays) {
    for (unsigned i = 0; i < LANES; ++i) {
        uint32_t vertex = (uint32_t)(rays_unit(r) * m->vertex_count);
        const char *at = (const char *)m->positions + (size_t)vertex * m->position_stride;
        vec3_f32 org = narrow(rays_in_ball(r, center, radius));
        vec3_f32 dir = narrow(sub_f64(widen(load_f32((const float *)(const void *)at)), widen(org)));
        rays->org_x[i] = org.x, rays->org_y[i] = org.y, rays->org_z[i] = org.z;
        rays->dir_x[i] = dir.x, rays->dir_y[i] = dir.y, rays->dir_z[i] = dir.z;
        rays->t_near[i] = 0, rays->t_far[i] = INFINITY;
    }
}

static void count_block(const subject *s, const trace_rays *rays, const uint8_t *depth, counts *c) {
    static const uint8_t outside[LANES];
    trace_block block = {.rays = *rays};
    trace_rays shadow = *rays;
    trace_closest(s->tracer, &block, LANES, TRACE_INCOHERENT);
    trace_any(s->tracer, &shadow, LANES, TRACE_INCOHERENT);
    for (unsigned i = 0; i < LANES; ++i) {
        c->missed += block.hits.geometry[i] == FATHOM_NONE;
        c->lit += shadow.t_far[i] > 0;
    }
    watertight_closest(s->water, &block, depth, LANES);
    watertight_any(s->water, &shadow, depth, outside, LANES);
    for (unsigned i = 0; i < LANES; ++i) {
        c->left += block.hits.geometry[i] == FATHOM_NONE;
        c->lit_left += shadow.t_far[i] > 0;
    }
    c->rays += LANES;
}

static void count(subject *s, uint64_t rays, const char *words) {
    double seconds = make_tracer(s, words);
    if (!s->water) {
        printf("| %s | nothing is closed, or nothing is missed |\n", words);
        drop_tracer(s);
        return;
    }
    scene_bounds box;
    if (scene_world_bounds(s->scene, &box) != FATHOM_OK) exit(4);
    vec3_f64 center = sub_f64(bounds_center(&box), s->world->origin);
    uint8_t depth[LANES];
    memset(depth, watertight_depth(s->water, narrow(center)), sizeof depth);
    rays_random random = rays_random_of(1, 0, 0);
    counts c = {0};
    unsigned state = trace_thread_begin();
    while (c.rays < rays) {
        trace_rays block;
        aim(&s->world->meshes.items[0], &random, center, 0.2 * bounds_radius(&box), &block);
        count_block(s, &block, depth, &c);
    }
    trace_thread_end(state);
    printf("| %s, %s | %llu | %llu | %llu | %llu | %llu | %.3f |\n", words, trace_name(s->tracer),
           (unsigned long long)c.rays, (unsigned long long)c.missed, (unsigned long long)c.left,
           (unsigned long long)c.lit, (unsigned long long)c.lit_left, seconds);
    drop_tracer(s);
}

/* ---- cost ---- */

#define FRAME_WIDTH 1280
#define FRAME_HEIGHT 720
#define BLOCKS (FRAME_WIDTH / 4 * FRAME_HEIGHT / 4)

static void camera_block(const shade_camera *camera, unsigned b, trace_rays *rays) {
    unsigned left = b % (FRAME_WIDTH / 4) * 4, top = b / (FRAME_WIDTH / 4) * 4;
    for (unsigned i = 0; i < LANES; ++i) {
        vec3_f32 d = camera_direction(camera, left + i % 4 + 0.5, top + i / 4 + 0.5);
        rays->org_x[i] = camera->eye.x, rays->org_y[i] = camera->eye.y, rays->org_z[i] = camera->eye.z;
        rays->dir_x[i] = d.x, rays->dir_y[i] = d.y, rays->dir_z[i] = d.z;
        rays->t_near[i] = 0, rays->t_far[i] = INFINITY;
    }
}

/* Blocks as the wave has them: 64 made, traced and looked through at a time. Seconds of tracing and repair.
 */
static double frame(const subject *s, const shade_camera *camera, uint8_t eye, bool repair, uint64_t *again) {
    static trace_block blocks[64];
    uint8_t depth[LANES];
    double seconds = 0;
    memset(depth, eye, sizeof depth);
    for (unsigned first = 0; first < BLOCKS; first += 64) {
        unsigned n = BLOCKS - first < 64 ? BLOCKS - first : 64;
        for (unsigned b = 0; b < n; ++b) camera_block(camera, first + b, &blocks[b].rays);
        double began = thread_seconds();
        trace_closest(s->tracer, blocks, n * LANES, TRACE_COHERENT);
        for (unsigned b = 0; b < n && repair; ++b)
            *again += watertight_closest(s->water, &blocks[b], depth, LANES);
        seconds += thread_seconds() - began;
    }
    return seconds;
}

static int by_value(const void *a, const void *b) {
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

static void cost(subject *s, int repeats) {
    double search = make_tracer(s, "embree:low"), *ratio = calloc((size_t)repeats, sizeof *ratio),
           least = 1e9;
    shade_camera camera;
    uint64_t again = 0;
    need(fathom_scene_complete(s->scene) == FATHOM_OK, s->context);
    camera_prepare(&s->scene->camera, FRAME_WIDTH, FRAME_HEIGHT, s->world->origin, &camera);
    if (!s->water) {
        printf("nothing is closed: no cost but %.4f s to find that out\n", search);
        drop_tracer(s);
        free(ratio);
        return;
    }
    uint8_t eye = watertight_depth(s->water, camera.eye);
    unsigned state = trace_thread_begin();
    for (int k = 0; k < repeats; ++k) {
        double without = frame(s, &camera, eye, false, &again), with = frame(s, &camera, eye, true, &again);
        double without_2 = frame(s, &camera, eye, false, &again);
        ratio[k] = 2 * with / (without + without_2);
        least = without < least ? without : least;
    }
    trace_thread_end(state);
    qsort(ratio, (size_t)repeats, sizeof *ratio, by_value);
    printf("%.4f s a frame (least); with the repair median %.3f, quartiles %.3f to %.3f; %llu rays repaired; "
           "closed meshes found in %.4f s\n",
           least, ratio[repeats / 2], ratio[repeats / 4], ratio[3 * repeats / 4], (unsigned long long)again,
           search);
    free(ratio);
    drop_tracer(s);
}

int main(int argc, char **argv) {
    subject s;
    if (argc < 4) {
        fprintf(stderr, "usage: watertight count FILE RAYS SPEC… | cost FILE REPEATS\n");
        return 2;
    }
    read_scene(&s, argv[2]);
    if (strcmp(argv[1], "cost") == 0) {
        cost(&s, atoi(argv[3]));
    } else {
        for (int i = 4; i < argc; ++i) count(&s, strtoull(argv[3], NULL, 10), argv[i]);
    }
    close_scene(&s);
    return 0;
}
