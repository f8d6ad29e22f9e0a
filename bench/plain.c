/* What being ready for any scene costs a plain one: processor time of rendering, against a loop written for
 * scenes of one mesh, one material, point lights and nothing else.
 * usage: plain SCENE SPP REPEATS
 *
 * The loop takes a square of 4 x 4 pixels all the way from camera rays to its sums before the next, with no
 * plan, queues or lists; what it does to a block is done by the renderer's own kernels. Its pixels have to be
 * the renderer's, bit by bit: both do the same work. Both run on one thread and take turns. */
#include "base/clock.h"
#include "measure/statistics.h"
#include "render/job.h"
#include "render/surface_point.h"
#include "scene/scene.h"

#include <fathom/fathom.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define REPEATS_MAX 99
#define WHOLE ((1u << LANES) - 1)

typedef struct plain {
    fathom_context *context;
    fathom_scene *scene;
    fathom_settings settings;
    world *world;
    trace_tracer *tracer;
    render_plan *plan;
    const fathom_mesh *mesh;
    fathom_id material;
    const shade_kernels *shade;
    const render_kernels *blocks;
    uint64_t shadow_rays;
} plain;

static _Noreturn void die(const char *what) {
    fprintf(stderr, "plain: %s\n", what);
    exit(1);
}

static void check(const plain *p, fathom_status status) {
    if (status != FATHOM_OK) die(fathom_context_message(p->context));
}

/* ---- the loop ---- */

/* What one light adds. A light that is behind the surface casts no rays; lanes without a hit gain nothing. */
static void add_light(plain *p, const shade_light *light, const surface_block *s, uint32_t met,
                      float *const radiance[3]) {
    material_block materials;
    light_block arriving;
    trace_rays rays;
    p->shade->material_gather(p->scene->materials.items, s, &materials);
    p->shade->light_evaluate(light, s, &materials, &arriving);
    uint32_t lanes = p->blocks->shadow_rays(&arriving, 0, p->plan->t_near, &rays) & met;
    if (!lanes) return;
    for (uint32_t i = 0; i < LANES; ++i) rays.t_far[i] = lanes >> i & 1 ? rays.t_far[i] : -1;
    trace_any(p->tracer, &rays, LANES, TRACE_COHERENT);
    p->shadow_rays += (uint32_t)__builtin_popcount(lanes);
    p->blocks->add_seen(&rays, arriving.radiance, s->slot, LANES, radiance);
}

/* Lanes without a hit stand in for one that has one. */
static void fill_up(trace_hits *hits, uint32_t met) {
    uint32_t first = (uint32_t)__builtin_ctz(met);
    for (uint32_t i = 0; i < LANES && met != WHOLE; ++i) {
        bool mine = met >> i & 1;
        hits->primitive[i] = mine ? hits->primitive[i] : hits->primitive[first];
    }
}

static void add_square(plain *p, uint32_t left, uint32_t top, const square_samples *at,
                       float radiance[3][LANES]) {
    static const uint8_t depth[LANES];
    facet_block facets;
    local_block local;
    surface_block s;
    trace_block block;
    p->blocks->camera_rays(&p->plan->camera, p->plan->t_near, left, top, at, &block.rays);
    trace_closest(p->tracer, &block, LANES, TRACE_COHERENT);
    if (p->plan->watertight) watertight_closest(p->plan->watertight, &block, depth, LANES);
    uint32_t met = p->blocks->met(&block.hits);
    if (!met) return;
    fill_up(&block.hits, met);
    facets.smooth = false;
    p->shade->facet_gather(p->mesh, block.hits.primitive, trace_origins(&block.rays),
                           trace_directions(&block.rays), &facets, &local);
    memcpy(local.ray, trace_directions(&block.rays), sizeof local.ray);
    p->shade->facets(&facets, p->settings.terminator_fix, &local);
    p->shade->surfaces(&local, true, &s);
    for (uint32_t i = 0; i < LANES; ++i) {
        s.weight[0][i] = s.weight[1][i] = s.weight[2][i] = 1;
        s.slot[i] = i, s.material[i] = p->material;
    }
    s.count = LANES;
    float *const rows[3] = {radiance[0], radiance[1], radiance[2]};
    for (uint32_t i = 0; i < p->plan->light_count; ++i) add_light(p, &p->plan->lights[i], &s, met, rows);
}

static void render_square(plain *p, uint32_t left, uint32_t top, fathom_film *film) {
    _Alignas(64) double sums[3][LANES] = {{0}};
    for (uint32_t index = 0; index < p->settings.spp; ++index) {
        _Alignas(64) float radiance[3][LANES] = {{0}};
        square_samples at = {.alike = true};
        wave_sample_position(p->plan, left, top, index, &at.x[0], &at.y[0]);
        add_square(p, left, top, &at, radiance);
        p->blocks->add_samples(radiance[0], LANES, sums[0]);
        p->blocks->add_samples(radiance[1], LANES, sums[1]);
        p->blocks->add_samples(radiance[2], LANES, sums[2]);
    }
    for (int c = 0; c < 3; ++c)
        p->blocks->store_square(sums[c], 1.0 / p->settings.spp, film->width,
                                film->rgb[c] + (size_t)top * film->width + left);
}

/* In the renderer's order: tiles, in them squares of 32 x 32 pixels. */
static void render_plain(plain *p, fathom_film *film) {
    const uint32_t side = p->settings.tile_size;
    unsigned state = trace_thread_begin();
    for (uint32_t y = 0; y < film->height; y += side) {
        for (uint32_t x = 0; x < film->width; x += side) {
            for (uint32_t k = 0; k < side * side / WAVE_SLOTS * WAVE_SQUARES; ++k) {
                uint32_t region = k / WAVE_SQUARES, square = k % WAVE_SQUARES, across = side / WAVE_SIDE;
                uint32_t left = x + region % across * WAVE_SIDE + square % 8 * 4;
                uint32_t top = y + region / across * WAVE_SIDE + square / 8 * 4;
                if (left < film->width && top < film->height) render_square(p, left, top, film);
            }
        }
    }
    trace_thread_end(state);
}

/* ---- against the renderer ---- */

static fathom_film *new_film(plain *p) {
    fathom_film *film;
    check(p, film_create(p->context, p->scene, &p->settings, &film));
    return film;
}

static double time_plain(plain *p, fathom_film **out) {
    *out = new_film(p);
    p->shadow_rays = 0;
    double began = clock_thread_seconds();
    render_plain(p, *out);
    return clock_thread_seconds() - began;
}

static double time_renderer(plain *p, job_result *result, fathom_film **out) {
    *out = new_film(p);
    double began = clock_process_seconds();
    check(p, job_run(p->context, p->plan, NULL, *out, result));
    return clock_process_seconds() - began;
}

static void compare(const fathom_film *a, const fathom_film *b) {
    for (int c = 0; c < 3; ++c) {
        size_t bytes = (size_t)a->width * a->height * sizeof(float);
        if (memcmp(a->rgb[c], b->rgb[c], bytes)) die("the images differ");
    }
}

static void open_scene(plain *p, const char *path, uint32_t spp) {
    check(p, fathom_scene_read(p->context, path, &p->scene));
    fathom_settings_default(&p->settings);
    p->settings.width = 1280, p->settings.height = 720, p->settings.spp = spp;
    p->settings.terminator_fix = false; /* it can take a second shadow ray */
    fathom_context_set_threads(p->context, 1);
    check(p, world_create(p->scene, &p->world));
    check(p, world_check(p->world));
    const trace_options options = {
        .kind = FATHOM_TRACER_EMBREE, .width = TRACE_WIDTH, .threads = 2, .quality = TRACE_QUALITY_LOW};
    check(p, trace_create(p->context, p->world, &options, &p->tracer));
    check(p, plan_create(p->context, p->world, p->tracer, &p->settings, &p->plan));
    p->shade = p->plan->kernels, p->blocks = p->plan->blocks;
    p->mesh = &p->world->meshes.items[0];
    p->material = world_material(p->world, 0, 0, FATHOM_NONE);
    bool plain_scene = p->world->geometries.count == 1 && p->world->meshes.count == 1 &&
                       !p->world->instances.count && !p->world->planes.count && !p->plan->max_depth &&
                       !p->plan->eye_depth && !p->plan->background;
    if (!plain_scene) die("expected one mesh, no mirror or glass, no background");
}

int main(int argc, char **argv) {
    static plain p;
    static double ratio[REPEATS_MAX];
    if (argc != 4) die("expected SCENE SPP REPEATS");
    unsigned repeats = (unsigned)atoi(argv[3]);
    if (repeats < 1 || repeats > REPEATS_MAX) die("expected 1 to 99 repeats");
    if (fathom_context_create(&p.context) != FATHOM_OK) die("out of memory");
    open_scene(&p, argv[1], (uint32_t)atoi(argv[2]));
    for (unsigned k = 0; k < repeats; ++k) {
        fathom_film *mine, *film;
        job_result result = {.samples = 0};
        double first = k % 2 ? time_renderer(&p, &result, &film) : 0, alone = time_plain(&p, &mine);
        double whole = k % 2 ? first : time_renderer(&p, &result, &film);
        compare(film, mine);
        if (result.rays.shadow != p.shadow_rays) die("the shadow rays differ");
        ratio[k] = whole / alone;
        fathom_film_destroy(mine);
        fathom_film_destroy(film);
    }
    quartiles q = quartiles_of(ratio, repeats);
    printf("renderer over the loop for plain scenes alone: %.3f (%.3f-%.3f)\n", q.median, q.low, q.high);
    return 0;
}
