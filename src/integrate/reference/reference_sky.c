/* Images of skies, and the studio: their light, interpolated between the centres of texels, and directions
 * towards it. The choice of a direction does not depend on the surface: first a cell, bounded by four texels,
 * in proportion to the texels' mean luminance times the cell's solid angle. Cell (x, y) lies between the
 * columns x and x + 1 of texels, and between the rows y - 1 and y. */
#include "integrate/reference/reference_inner.h"
#include "light/environment.h"

#include <stdlib.h>

struct reference_sky {
    environment *owner;
    const sky_image *image;
    double *before; /* prefix sums of luminance times solid angle: of all cells before each cell; the last is
                       the total */
};

static size_t cells_of(const sky_image *m) { return (size_t)m->width * (m->height + 1); }

/* The cosine at the beginning of a row of cells. */
static double cosine_of(const sky_image *m, size_t row) {
    return cos(M_PI * fmin(fmax((double)row - 0.5, 0), m->height) / m->height);
}

static double solid_angle(const sky_image *m, size_t cell) {
    const size_t row = cell / m->width;
    return 2 * M_PI / m->width * (cosine_of(m, row) - cosine_of(m, row + 1));
}

static vec3_f64 texel_at(const sky_image *m, size_t column, size_t row) {
    return color_of(m->texels[row * m->width + column % m->width].rgb);
}

/* The colour at the fraction u of the way to the next column, and v to the next row. */
static vec3_f64 color_in(const sky_image *m, size_t cell, double u, double v) {
    const size_t x = cell % m->width, y = cell / m->width, above = y ? y - 1 : 0,
                 below = y < m->height ? y : m->height - 1;
    const vec3_f64 top = madd_f64(scale_f64(1 - u, texel_at(m, x, above)), u, texel_at(m, x + 1, above)),
                   bottom = madd_f64(scale_f64(1 - u, texel_at(m, x, below)), u, texel_at(m, x + 1, below));
    return madd_f64(scale_f64(1 - v, top), v, bottom);
}

static double weight_of(const sky_image *m, size_t cell) {
    const vec3_f64 c = color_in(m, cell, 0.5, 0.5);
    return (0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z) * solid_angle(m, cell);
}

static void close_sky(reference_sky *sky) {
    environment_destroy(sky->owner);
    free(sky->before);
}

/* Sums up the light. False if out of memory. */
static bool add_up(reference_sky *sky) {
    const sky_image *m = sky->image;
    const size_t count = cells_of(m);
    sky->before = malloc((count + 1) * sizeof *sky->before);
    if (!sky->before) return false;
    sky->before[0] = 0;
    for (size_t i = 0; i < count; ++i) sky->before[i + 1] = sky->before[i] + weight_of(m, i);
    return true;
}

static double all_of(const reference_sky *sky) { return sky->before[cells_of(sky->image)]; }

/* id: of the environment; FATHOM_NONE for the studio. A black image is left out. */
static fathom_status add_sky(reference_scene *r, fathom_id id) {
    const fathom_scene *scene = r->scene;
    reference_sky sky = {.owner = NULL};
    fathom_status status = id != FATHOM_NONE ? environment_open(scene->context, scene, id, &sky.owner)
                                             : environment_studio(scene->context, load_f64(scene->camera.z),
                                                                  scene->studio_up, &sky.owner);
    if (status != FATHOM_OK) return status;
    sky.image = environment_sky(sky.owner);
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
    r->skies = calloc(scene->environments.count + 1, sizeof *r->skies);
    if (!r->skies) return fail_memory(scene->context, sizeof *r->skies);
    if (scene->in_studio) status = add_sky(r, FATHOM_NONE);
    for (size_t i = 0; i < scene->environments.count && status == FATHOM_OK; ++i)
        status = add_sky(r, (fathom_id)i);
    return status;
}

void reference_skies_close(reference_scene *r) {
    for (unsigned i = 0; i < r->sky_count; ++i) close_sky(&r->skies[i]);
    free(r->skies);
}

/* The cell of a direction: the image's centre is towards -z, its top row around +y. */
static size_t cell_of(const sky_image *m, vec3_f64 d, double *u, double *v) {
    const double x = dot_f64(d, m->axes[0]), y = fmin(fmax(dot_f64(d, m->axes[1]), -1), 1),
                 z = dot_f64(d, m->axes[2]);
    const double across = fmod((0.5 + atan2(x, -z) / (2 * M_PI)) * m->width - 0.5 + m->width, m->width);
    const size_t column = (size_t)fmin(across, m->width - 1.0),
                 row = (size_t)fmin(acos(y) / M_PI * m->height + 0.5, m->height);
    const double top = cosine_of(m, row), bottom = cosine_of(m, row + 1);
    *u = across - (double)column, *v = (top - y) / (top - bottom);
    return row * m->width + column;
}

vec3_f64 reference_sky_light(const reference_scene *r, vec3_f64 direction) {
    vec3_f64 sum = r->scene->in_studio ? gray(0) : color_of(r->scene->background);
    for (unsigned i = 0; i < r->sky_count; ++i) {
        double u, v;
        const size_t cell = cell_of(r->skies[i].image, direction, &u, &v);
        sum = add_f64(sum, color_in(r->skies[i].image, cell, u, v));
    }
    return sum;
}

double reference_sky_density(const reference_scene *r, vec3_f64 direction) {
    double sum = 0;
    for (unsigned i = 0; i < r->sky_count; ++i) {
        const sky_image *m = r->skies[i].image;
        double u, v;
        const size_t cell = cell_of(m, direction, &u, &v);
        sum += weight_of(m, cell) / solid_angle(m, cell) / all_of(&r->skies[i]);
    }
    return sum / r->sky_count;
}

/* Uniform over the cell: in the azimuth, and in the cosine to the pole. */
static vec3_f64 within(const sky_image *m, size_t cell, reference_random *random) {
    const double column = (double)(cell % m->width) + 0.5;
    const double top = cosine_of(m, cell / m->width), bottom = cosine_of(m, cell / m->width + 1);
    const double turn = 2 * M_PI * ((column + reference_uniform(random)) / m->width - 0.5),
                 y = top + (bottom - top) * reference_uniform(random), around = sqrt(fmax(1 - y * y, 0));
    const vec3_f64 flat = madd_f64(scale_f64(around * sin(turn), m->axes[0]), y, m->axes[1]);
    return normalize_f64(madd_f64(flat, -around * cos(turn), m->axes[2]));
}

vec3_f64 reference_to_sky(const reference_scene *r, reference_random *random) {
    const reference_sky *sky = &r->skies[(size_t)(reference_uniform(random) * r->sky_count)];
    size_t low = 0, high = cells_of(sky->image);
    const double wanted = reference_uniform(random) * sky->before[high];
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (sky->before[middle] <= wanted)
            low = middle;
        else
            high = middle;
    }
    return within(sky->image, low, random);
}
