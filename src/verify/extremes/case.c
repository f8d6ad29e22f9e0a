#include "verify/extremes/case.h"

#include "scene/scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *case_memory(judged_scene *c, size_t bytes) {
    /* Embree reads vertices 16 bytes at a time. */
    void *memory = c->b.status == FATHOM_OK ? calloc(1, bytes + 16) : NULL;
    if (memory && array_push(&c->owned, memory)) return memory;
    free(memory);
    if (c->b.status == FATHOM_OK) c->b.status = fail_memory(c->b.context, bytes);
    return NULL;
}

void case_say(judged_scene *c, const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(c->words, sizeof c->words, format, list);
    va_end(list);
}

static fathom_status open_world(judged_scene *c) {
    if (c->b.status == FATHOM_OK) c->b.status = world_create(c->b.scene, &c->world);
    if (c->b.status == FATHOM_OK) c->world->one_sided = false; /* the nearest hit is judged */
    if (c->b.status == FATHOM_OK && c->patch) {
        c->patch(c);
        c->b.status = world_survey(c->world);
    }
    if (c->b.status == FATHOM_OK) c->b.status = search_create(c->b.context, c->world, &c->search);
    if (c->b.status == FATHOM_OK) c->b.status = rays_create(c->b.context, c->world, &c->source);
    if (c->b.status == FATHOM_OK && c->maker) c->source->own = c->maker, c->source->own_user = c;
    return c->b.status;
}

fathom_status case_open(fathom_context *context, void (*make)(judged_scene *c, double parameter),
                        unsigned shape, double parameter, judged_scene *out) {
    memset(out, 0, sizeof *out);
    out->families = CASE_FAMILIES, out->shape = shape;
    build_open(context, &out->b);
    if (out->b.status == FATHOM_OK) make(out, parameter);
    build_finish(&out->b);
    return open_world(out);
}

fathom_status judged_open(fathom_context *context, fathom_scene *scene, judged_scene *out) {
    memset(out, 0, sizeof *out);
    out->b = (builder){.context = context, .scene = scene};
    return open_world(out);
}

void judged_close(judged_scene *c) {
    rays_destroy(c->source);
    search_destroy(c->search);
    world_destroy(c->world);
    fathom_scene_destroy(c->b.scene);
    for (size_t i = 0; i < c->owned.count; ++i) free(c->owned.items[i]);
    array_free(&c->owned);
    memset(c, 0, sizeof *c);
}

/* ---- shapes ---- */

double case_scattered(unsigned i, unsigned k, double low, double high) {
    double x = (double)(i + 1) * 0.6180339887498949 + (double)(k + 1) * 0.7548776662466927;
    x += (double)(i * i % 97) * 0.1327;
    return low + (high - low) * (x - floor(x));
}

vec3_f64 case_scattered_point(unsigned i, unsigned k, double reach) {
    return vec_f64(case_scattered(i, k, -reach, reach), case_scattered(i, k + 1, -reach, reach),
                   case_scattered(i, k + 2, -reach, reach));
}

void case_triangles(judged_scene *c, vec3_f64 origin, const vec3_f64 *corners, uint32_t triangles) {
    uint32_t *indices = case_memory(c, triangles * 3 * sizeof *indices);
    if (!indices) return;
    for (uint32_t i = 0; i < 3 * triangles; ++i) indices[i] = i;
    build_triangles(&c->b, origin, corners, 3 * triangles, indices, triangles, 0);
}

void case_spheres(judged_scene *c, vec3_f64 at, double radius) {
    for (unsigned i = 0; i < 12; ++i)
        build_sphere(&c->b, add_f64(at, case_scattered_point(i, 0, radius)),
                     radius * pow(10, case_scattered(i, 3, -2, -0.5)), 0);
}

void case_quads(judged_scene *c, vec3_f64 at, double radius) {
    for (unsigned i = 0; i < 12; ++i) {
        double angle = case_scattered(i, 3, 0, 6.28), size = radius * pow(10, case_scattered(i, 4, -2, -0.3));
        vec3_f64 u = scale_f64(size, vec_f64(cos(angle), sin(angle), 0));
        build_quad(&c->b, add_f64(at, case_scattered_point(i + 40, 0, radius)), u,
                   scale_f64(size, vec_f64(-0.3 * sin(angle), 0.3 * cos(angle), 0.8)), 0);
    }
}

/* ---- a ball of rings between two poles ---- */

static vec3_f64 ball_vertex(double theta, double phi, double radius) {
    double r = radius * (1 + 0.05 * sin(9 * theta) * cos(7 * phi));
    return scale_f64(r, vec_f64(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)));
}

static uint32_t *add_triangle(uint32_t *at, uint32_t x, uint32_t y, uint32_t z) {
    at[0] = x, at[1] = y, at[2] = z;
    return at + 3;
}

void case_ball_of(judged_scene *c, vec3_f64 at, double radius, unsigned rings, unsigned around) {
    const uint32_t top = rings * around, bottom = top + 1, last = top - around;
    vec3_f64 *positions = case_memory(c, (bottom + 1) * sizeof *positions);
    uint32_t *indices = case_memory(c, 6 * (size_t)top * sizeof *indices), *next = indices;
    if (!positions || !indices) return;
    for (unsigned k = 0; k < top; ++k)
        positions[k] = ball_vertex(3.141592653589793 * (k / around + 1) / (rings + 1),
                                   6.283185307179586 * (k % around) / around, radius);
    positions[top] = vec_f64(0, radius, 0), positions[bottom] = vec_f64(0, -radius, 0);
    for (unsigned i = 0; i < around; ++i) {
        uint32_t j = (i + 1) % around;
        next = add_triangle(next, top, j, i);
        next = add_triangle(next, bottom, last + i, last + j);
        for (unsigned k = 0; k < last; k += around) {
            next = add_triangle(next, k + i, k + j, k + around + i);
            next = add_triangle(next, k + j, k + around + j, k + around + i);
        }
    }
    build_triangles(&c->b, at, positions, bottom + 1, indices, (uint32_t)(next - indices) / 3, 0);
}

void case_ball(judged_scene *c, vec3_f64 at, double radius) { case_ball_of(c, at, radius, 7, 12); }

void case_shapes(judged_scene *c, double radius) {
    const vec3_f64 middle = {0, 0, 0};
    switch (c->shape) {
    case CASE_SPHERES: case_spheres(c, middle, radius); break;
    case CASE_QUADS: case_quads(c, middle, radius); break;
    default: case_ball(c, middle, radius);
    }
}
