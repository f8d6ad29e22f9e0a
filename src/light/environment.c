#include "light/environment.h"

#include "light/studio.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

struct environment {
    sky_image sky;
    const sky_kernels *kernels;
};

/* Takes the texels, also on failure. */
static environment *wrap(fathom_context *context, sky_image *sky) {
    environment *e = calloc(1, sizeof *e);
    if (!e) {
        free(sky->texels);
        fail_memory(context, sizeof *e);
        return NULL;
    }
    e->kernels = sky_kernels_best();
    e->sky = *sky;
    return e;
}

void environment_destroy(environment *e) {
    if (!e) return;
    sky_close(&e->sky);
    free(e);
}

const sky_image *environment_sky(const environment *e) { return &e->sky; }

bool environment_learn(environment *e, const sky_ray *rays, size_t count) {
    return sky_learn(&e->sky, rays, count);
}

double environment_power(const environment *e) { return e->sky.power; }

/* Call once all texels are set. Destroys *e if memory runs out. */
static fathom_status finish(fathom_context *context, environment **e) {
    const size_t bytes = (size_t)(*e)->sky.width * (*e)->sky.height * sizeof *(*e)->sky.cells;
    if (sky_open(&(*e)->sky)) return FATHOM_OK;
    environment_destroy(*e);
    *e = NULL;
    return fail_memory(context, bytes);
}

/* Rotates v by the shortest rotation from y to the unit vector `up`. */
static vec3_f64 turned_up(vec3_f64 v, vec3_f64 up) {
    const vec3_f64 both = {up.x, up.y + 1, up.z};
    if (!(both.y > 1e-12)) return (vec3_f64){v.x, -v.y, -v.z};
    return madd_f64(madd_f64(v, -dot_f64(both, v) / both.y, both), 2 * v.y, up);
}

fathom_status environment_create(fathom_context *context, const fathom_light *light, environment **out) {
    environment *e = *out = NULL;
    sky_image read;
    fathom_status status = environment_read(context, light, &read);
    if (status != FATHOM_OK) return status;
    e = wrap(context, &read);
    if (!e) return FATHOM_OUT_OF_RESOURCES;
    const double cosine = cos(light->rotation), sine = sin(light->rotation);
    const vec3_f64 up = normalize_f64(load_f64(light->up));
    e->sky.axes[0] = turned_up((vec3_f64){cosine, 0, -sine}, up), e->sky.axes[1] = up;
    e->sky.axes[2] = turned_up((vec3_f64){sine, 0, cosine}, up);
    *out = e;
    return finish(context, out);
}

static fathom_status place_status(fathom_context *context, const fathom_scene *scene, fathom_id id,
                                  fathom_status status) {
    const fathom_place *place = scene_origin_find(scene, SCENE_PART_ENVIRONMENT, id);
    return status == FATHOM_BAD_INPUT && place ? fail_within(context, status, place) : status;
}

fathom_status environment_open(fathom_context *context, const fathom_scene *scene, fathom_id id,
                               environment **out) {
    const fathom_status status = environment_create(context, &scene->environments.items[id], out);
    return place_status(context, scene, id, status);
}

fathom_status environment_check(fathom_context *context, const fathom_scene *scene) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < scene->environments.count && status == FATHOM_OK; ++i) {
        sky_image read;
        status = environment_read(context, &scene->environments.items[i], &read);
        status = place_status(context, scene, (fathom_id)i, status);
        free(read.texels);
    }
    return status;
}

void environment_brightest(const environment *e, float out[3]) {
    memset(out, 0, 3 * sizeof *out);
    for (size_t i = 0; i < (size_t)e->sky.width * e->sky.height; ++i) {
        for (int c = 0; c < 3; ++c) out[c] = fmaxf(out[c], e->sky.texels[i].rgb[c]);
    }
}

/* ---- the studio ---- */

/* A texel is 0.7 degrees wide, and the soft edges of the panels are 6. Larger tables would leave the caches.
 */
#define STUDIO_WIDTH 512u
#define STUDIO_HEIGHT 256u

/* Sets the axes. If the viewer looks along `up`, the direction of the image's z is arbitrary. */
static void stand(environment *e, vec3_f64 z, vec3_f64 up) {
    vec3_f64 back = sub_f64(z, scale_f64(dot_f64(z, up), up));
    if (!(length_f64(back) > 0x1p-10)) back = fabs(up.z) < 0.9 ? vec_f64(0, 0, 1) : vec_f64(0, -1, 0);
    e->sky.axes[1] = up;
    e->sky.axes[0] = normalize_f64(cross_f64(up, back));
    e->sky.axes[2] = cross_f64(e->sky.axes[0], up);
}

fathom_status environment_studio(fathom_context *context, vec3_f64 z, vec3_f64 up, environment **out) {
    sky_image sky = {.width = STUDIO_WIDTH, .height = STUDIO_HEIGHT};
    const size_t bytes = (size_t)STUDIO_WIDTH * STUDIO_HEIGHT * sizeof *sky.texels;
    studio made;
    *out = NULL;
    sky.texels = malloc(bytes);
    if (!sky.texels) return fail_memory(context, bytes);
    environment *e = *out = wrap(context, &sky);
    if (!e) return FATHOM_OUT_OF_RESOURCES;
    stand(e, z, up);
    studio_open(&made);
    for (uint32_t i = 0; i < STUDIO_WIDTH * STUDIO_HEIGHT; ++i)
        studio_radiance(
            &made,
            sky_direction((i % STUDIO_WIDTH + 0.5) / STUDIO_WIDTH, (i / STUDIO_WIDTH + 0.5) / STUDIO_HEIGHT),
            e->sky.texels[i].rgb);
    return finish(context, out);
}

/* ---- an even sky ---- */

/* Every block has cells of its own. */
enum { EVEN_WIDTH = SKY_BLOCK_COLUMNS, EVEN_HEIGHT = SKY_BLOCK_ROWS };

fathom_status environment_even(fathom_context *context, const float radiance[3], environment **out) {
    sky_image sky = {.width = EVEN_WIDTH, .height = EVEN_HEIGHT, .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    const size_t bytes = EVEN_WIDTH * EVEN_HEIGHT * sizeof *sky.texels;
    *out = NULL;
    sky.texels = malloc(bytes);
    if (!sky.texels) return fail_memory(context, bytes);
    for (uint32_t i = 0; i < EVEN_WIDTH * EVEN_HEIGHT; ++i)
        memcpy(sky.texels[i].rgb, radiance, sizeof sky.texels[i].rgb);
    *out = wrap(context, &sky);
    return *out ? finish(context, out) : FATHOM_OUT_OF_RESOURCES;
}

/* ---- asking ---- */

void environment_at(const environment *e, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                    const lanes3_f64 direction, sky_light *out) {
    e->kernels->at(&e->sky, lanes, p, n, direction, out);
}

void environment_radiance(const environment *e, vec3_f64 direction, float radiance[3]) {
    const lanes3_f64 d = {{direction.x}, {direction.y}, {direction.z}}, n = {{0}};
    const lanes3 p = {{0}};
    sky_light light;
    e->kernels->at(&e->sky, 1, p, n, d, &light);
    for (int c = 0; c < 3; ++c) radiance[c] = light.radiance[c][0];
}

void environment_sample(const environment *e, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                        const float u[LANES], const float v[LANES], lanes3_f64 direction, sky_light *out) {
    e->kernels->sample(&e->sky, lanes, p, n, u, v, direction, out);
}
