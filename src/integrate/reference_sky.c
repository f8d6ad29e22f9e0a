/* Images of skies, and the studio: their light, and directions to it. A direction is chosen by its texel, in
 * proportion to luminance times solid angle, whatever the surface. */
#include "integrate/reference_inner.h"
#include "light/environment.h"

#include <stdlib.h>

struct reference_sky {
    environment *owner;
    environment_image image;
    double *before; /* luminance times solid angle of all texels before each; at the end, of all */
};

/* Each texel of a row has this one. */
static double solid_angle(const environment_image *m, uint32_t row) {
    return 2 * PI / m->width * (cos(PI * row / m->height) - cos(PI * (row + 1.0) / m->height));
}

static double weight_of(const environment_image *m, size_t texel) {
    const vec3_f64 c = color_of(m->texels[texel]);
    return (0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z) * solid_angle(m, (uint32_t)(texel / m->width));
}

static void close_sky(reference_sky *sky) {
    environment_destroy(sky->owner);
    free(sky->before);
}

/* Sums up the light. False without memory. */
static bool add_up(reference_sky *sky) {
    const environment_image *m = &sky->image;
    const size_t count = (size_t)m->width * m->height;
    sky->before = malloc((count + 1) * sizeof *sky->before);
    if (!sky->before) return false;
    sky->before[0] = 0;
    for (size_t i = 0; i < count; ++i) sky->before[i + 1] = sky->before[i] + weight_of(m, i);
    return true;
}

static double all_of(const reference_sky *sky) {
    return sky->before[(size_t)sky->image.width * sky->image.height];
}

/* light: NULL for the studio. A black image is left out. */
static fathom_status add_sky(reference_scene *r, const fathom_light *light) {
    const fathom_scene *scene = r->scene;
    reference_sky sky = {.owner = NULL};
    fathom_status status =
        light ? environment_create(scene->context, light, &sky.owner)
              : environment_studio(scene->context, load_f64(scene->camera.z), scene->studio_up, &sky.owner);
    if (status != FATHOM_OK) return status;
    sky.image = environment_image_of(sky.owner);
    if (!add_up(&sky)) status = fail_memory(scene->context, sizeof *sky.before);
    if (status == FATHOM_OK && all_of(&sky) > 0)
        r->skies[r->sky_count++] = sky;
    else
        close_sky(&sky);
    return status;
}

fathom_status reference_skies_open(reference_scene *r) {
    const fathom_scene *scene = r->scene;
    fathom_status status = FATHOM_OK;
    if (r->settings.environment) return FATHOM_OK;
    r->skies = calloc(scene->environments.count + 1, sizeof *r->skies);
    if (!r->skies) return fail_memory(scene->context, sizeof *r->skies);
    if (scene->in_studio) status = add_sky(r, NULL);
    for (size_t i = 0; i < scene->environments.count && status == FATHOM_OK; ++i)
        status = add_sky(r, &scene->environments.items[i]);
    return status;
}

void reference_skies_close(reference_scene *r) {
    for (unsigned i = 0; i < r->sky_count; ++i) close_sky(&r->skies[i]);
    free(r->skies);
}

/* The image's centre is in front, its top row above. */
static size_t texel_of(const environment_image *m, vec3_f64 d) {
    const double x = dot_f64(d, m->axes[0]), y = dot_f64(d, m->axes[1]), z = dot_f64(d, m->axes[2]);
    const double u = 0.5 + atan2(x, -z) / (2 * PI), v = acos(fmin(fmax(y, -1), 1)) / PI;
    const size_t column = (size_t)fmin(u * m->width, m->width - 1.0),
                 row = (size_t)fmin(v * m->height, m->height - 1.0);
    return row * m->width + column;
}

vec3_f64 reference_sky_light(const reference_scene *r, vec3_f64 direction) {
    vec3_f64 sum = r->scene->in_studio ? gray(0) : color_of(r->scene->background);
    for (unsigned i = 0; i < r->sky_count; ++i) {
        const environment_image *m = &r->skies[i].image;
        sum = add_f64(sum, color_of(m->texels[texel_of(m, direction)]));
    }
    return sum;
}

double reference_sky_density(const reference_scene *r, vec3_f64 direction) {
    double sum = 0;
    for (unsigned i = 0; i < r->sky_count; ++i) {
        const environment_image *m = &r->skies[i].image;
        const size_t texel = texel_of(m, direction);
        sum += weight_of(m, texel) / solid_angle(m, (uint32_t)(texel / m->width)) / all_of(&r->skies[i]);
    }
    return sum / r->sky_count;
}

/* Even over the texel: over its turn, and over the cosine to the pole. */
static vec3_f64 within(const environment_image *m, size_t texel, reference_random *random) {
    const double column = (double)(texel % m->width), row = (double)(texel / m->width);
    const double top = cos(PI * row / m->height), bottom = cos(PI * (row + 1) / m->height);
    const double turn = 2 * PI * ((column + reference_uniform(random)) / m->width - 0.5),
                 y = top + (bottom - top) * reference_uniform(random), around = sqrt(fmax(1 - y * y, 0));
    const vec3_f64 flat = madd_f64(scale_f64(around * sin(turn), m->axes[0]), y, m->axes[1]);
    return normalize_f64(madd_f64(flat, -around * cos(turn), m->axes[2]));
}

vec3_f64 reference_to_sky(const reference_scene *r, reference_random *random) {
    const reference_sky *sky = &r->skies[(size_t)(reference_uniform(random) * r->sky_count)];
    size_t low = 0, high = (size_t)sky->image.width * sky->image.height;
    const double wanted = reference_uniform(random) * sky->before[high];
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (sky->before[middle] <= wanted)
            low = middle;
        else
            high = middle;
    }
    return within(&sky->image, low, random);
}
