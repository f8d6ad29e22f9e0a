#include "light/environment.h"

#include "base/file.h"
#include "image/image.h"
#include "light/shape.h"
#include "light/sky_choice.h"
#include "light/studio.h"
#include "math/lane.h"

#include <stdlib.h>
#include <string.h>

struct environment {
    uint32_t width, height;
    vec3_f64 axes[3]; /* right, up and back of the image, in the world */
    float (*texels)[3];
    sky_choice *choice;
};

static double row_cosine(const environment *e, uint32_t row) {
    return 1 - 2 * pow(sin(SHAPE_PI / 2 * row / e->height), 2);
}

static environment *make(fathom_context *context, uint32_t width, uint32_t height) {
    const size_t count = (size_t)width * height;
    environment *e = calloc(1, sizeof *e);
    if (e) {
        e->width = width, e->height = height;
        e->texels = malloc(count * sizeof *e->texels);
        if (e->texels) return e;
    }
    environment_destroy(e);
    fail_memory(context, count * sizeof *e->texels);
    return NULL;
}

void environment_destroy(environment *e) {
    if (!e) return;
    sky_choice_destroy(e->choice);
    free(e->texels);
    free(e);
}

environment_image environment_image_of(const environment *e) {
    return (environment_image){
        e->width, e->height, {e->axes[0], e->axes[1], e->axes[2]}, (const float(*)[3])e->texels};
}

double environment_power(const environment *e) { return sky_choice_power(e->choice); }

/* ---- reading ---- */

static bool is_linear(const char *path) {
    char extension[16];
    file_extension(path, extension);
    static const char *const encoded[] = {"png", "jpg", "jpeg", "gif", "bmp", "webp", "tga"};
    for (size_t i = 0; i < sizeof encoded / sizeof *encoded; ++i) {
        if (strcmp(extension, encoded[i]) == 0) return false;
    }
    return true;
}

/* R, G and B, or one channel for all three. */
static bool find_channels(const image *img, const image_channel *rgb[3]) {
    static const char *const names[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        rgb[c] = NULL;
        for (size_t i = 0; i < img->channel_count; ++i) {
            const image_channel *channel = &img->channels[i];
            if (channel->type == IMAGE_FLOAT &&
                (strcmp(channel->name, names[c]) == 0 || img->channel_count == 1))
                rgb[c] = channel;
        }
    }
    return rgb[0] && rgb[1] && rgb[2];
}

static float channel_at(const image *img, const image_channel *channel, uint32_t x, uint32_t y) {
    float value;
    memcpy(&value, (const char *)channel->data + ((size_t)y * img->width + x) * channel->stride,
           sizeof value);
    return value;
}

static fathom_status bad_texel(fathom_context *context, const char *path, uint32_t x, uint32_t y, int c,
                               float value) {
    return fail_file(
        context, FATHOM_BAD_INPUT, path,
        "texel (%u, %u), counted from the top left, has %g in channel %s; expected finite radiance "
        "that stays finite times the light's intensity",
        x, y, (double)value, c == 0 ? "R" : (c == 1 ? "G" : "B"));
}

static fathom_status load_texels(fathom_context *context, const fathom_light *light, const image *img,
                                 environment *e) {
    const image_channel *rgb[3];
    size_t negative = 0;
    if (!find_channels(img, rgb))
        return fail_file(context, FATHOM_BAD_INPUT, light->file, "expected the channels R, G and B, or one");
    for (size_t i = 0; i < (size_t)e->width * e->height; ++i) {
        const uint32_t x = (uint32_t)(i % e->width), y = (uint32_t)(i / e->width);
        for (int c = 0; c < 3; ++c) {
            const float value = channel_at(img, rgb[c], x, y);
            e->texels[i][c] = value > 0 ? value * light->intensity[c] : 0;
            negative += value < 0;
            if (!isfinite(value) || !isfinite(e->texels[i][c]))
                return bad_texel(context, light->file, x, y, c, value);
        }
    }
    if (negative) warn(context, "%s: %zu numbers are negative; they count as 0", light->file, negative);
    return FATHOM_OK;
}

/* Once all texels are in. Destroys *e where memory lacks. */
static fathom_status finish(fathom_context *context, environment **e) {
    const uint32_t width = (*e)->width, height = (*e)->height;
    (*e)->choice = sky_choice_create(width, height, (const float(*)[3])(*e)->texels);
    if ((*e)->choice) return FATHOM_OK;
    environment_destroy(*e);
    *e = NULL;
    return fail_memory(context, (size_t)width * height * sizeof(double));
}

static fathom_status prepare(fathom_context *context, const fathom_light *light, const image *img,
                             environment **out) {
    const size_t count = (size_t)img->width * img->height;
    if (count > UINT32_MAX || !count)
        return fail_file(context, FATHOM_BAD_INPUT, light->file, "expected 1 to 2^32 - 1 texels, found %zu",
                         count);
    environment *e = make(context, img->width, img->height);
    if (!e) return FATHOM_OUT_OF_RESOURCES;
    const double cosine = cos(light->rotation), sine = sin(light->rotation);
    e->axes[0] = (vec3_f64){cosine, 0, -sine}, e->axes[1] = (vec3_f64){0, 1, 0};
    e->axes[2] = (vec3_f64){sine, 0, cosine};
    fathom_status status = load_texels(context, light, img, e);
    if (status != FATHOM_OK) {
        environment_destroy(e);
        return status;
    }
    *out = e;
    return finish(context, out);
}

fathom_status environment_create(fathom_context *context, const fathom_light *light, environment **out) {
    const image *img;
    *out = NULL;
    if (!is_linear(light->file))
        return fail_file(
            context, FATHOM_BAD_INPUT, light->file,
            "expected an image of linear radiance (.exr, .hdr, .pfm, .tif); this format holds colours "
            "for a display");
    fathom_status status = image_read(context, light->file, &img);
    if (status != FATHOM_OK) return status;
    status = prepare(context, light, img, out);
    image_release(img);
    return status;
}

void environment_brightest(const environment *e, float out[3]) {
    memset(out, 0, 3 * sizeof *out);
    for (size_t i = 0; i < (size_t)e->width * e->height; ++i) {
        for (int c = 0; c < 3; ++c) out[c] = fmaxf(out[c], e->texels[i][c]);
    }
}

/* ---- the studio ---- */

/* A texel is a third of a degree wide: less than the soft edges of the panels show. */
#define STUDIO_WIDTH 1024u
#define STUDIO_HEIGHT 512u

/* A viewer who looks along `up` sees the studio from where the image's z points. */
static void stand(environment *e, vec3_f64 z, vec3_f64 up) {
    vec3_f64 back = sub_f64(z, scale_f64(dot_f64(z, up), up));
    if (!(length_f64(back) > 0x1p-10)) back = fabs(up.z) < 0.9 ? vec_f64(0, 0, 1) : vec_f64(0, -1, 0);
    e->axes[1] = up;
    e->axes[0] = normalize_f64(cross_f64(up, back));
    e->axes[2] = cross_f64(e->axes[0], up);
}

fathom_status environment_studio(fathom_context *context, vec3_f64 z, vec3_f64 up, environment **out) {
    environment *e = *out = make(context, STUDIO_WIDTH, STUDIO_HEIGHT);
    studio made;
    if (!e) return FATHOM_OUT_OF_RESOURCES;
    stand(e, z, up);
    studio_open(&made);
    for (uint32_t i = 0; i < STUDIO_WIDTH * STUDIO_HEIGHT; ++i)
        studio_radiance(
            &made,
            sky_direction((i % STUDIO_WIDTH + 0.5) / STUDIO_WIDTH, (i / STUDIO_WIDTH + 0.5) / STUDIO_HEIGHT),
            e->texels[i]);
    return finish(context, out);
}

/* ---- directions ---- */

/* From the world to the image: its centre lies towards -z, its right half towards +x. */
static vec3_f64 to_image(const environment *e, vec3_f64 d) {
    return (vec3_f64){dot_f64(d, e->axes[0]), dot_f64(d, e->axes[1]), dot_f64(d, e->axes[2])};
}

static vec3_f64 to_world(const environment *e, vec3_f64 d) {
    return madd_f64(madd_f64(scale_f64(d.x, e->axes[0]), d.y, e->axes[1]), d.z, e->axes[2]);
}

static uint32_t cell(double u, uint32_t count) {
    const double at = u * count;
    return at < count - 1 ? (uint32_t)at : count - 1;
}

static void find_texel(const environment *e, vec3_f64 direction, uint32_t *column, uint32_t *row) {
    const vec3_f64 d = to_image(e, direction);
    const double half = shape_angle(fabs(d.x), -d.z) / (2 * SHAPE_PI), u = d.x < 0 ? 0.5 - half : 0.5 + half;
    const double v = shape_angle(sqrt(d.x * d.x + d.z * d.z), d.y) / SHAPE_PI;
    *column = cell(u, e->width), *row = cell(v, e->height);
}

static const float *texel(const environment *e, uint32_t column, uint32_t row) {
    return e->texels[(size_t)row * e->width + column];
}

/* n: in the image's axes. */
static void look_up(const environment *e, unsigned lanes, const lanes3_f64 n, const sky_texels *texels,
                    environment_light *out) {
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        __builtin_prefetch(texel(e, texels->column[i], texels->row[i]));
    }
    sky_choice_densities(e->choice, lanes, n, texels, out->density);
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const float *light = texel(e, texels->column[i], texels->row[i]);
        for (int c = 0; c < 3; ++c) out->radiance[c][i] = light[c];
        out->density[i] *= sky_luminance(light);
    }
}

static void turn_normals(const environment *e, unsigned lanes, const lanes3_f64 n, lanes3_f64 out) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        put_lane_f64(out, i, to_image(e, lane_f64(n, i)));
    }
}

void environment_at(const environment *e, unsigned lanes, const lanes3_f64 n, const lanes3_f64 direction,
                    environment_light *out) {
    lanes3_f64 turned;
    sky_texels texels;
    turn_normals(e, lanes, n, turned);
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        find_texel(e, lane_f64(direction, i), &texels.column[i], &texels.row[i]);
    }
    look_up(e, lanes, turned, &texels, out);
}

void environment_radiance(const environment *e, vec3_f64 direction, float radiance[3]) {
    uint32_t column, row;
    find_texel(e, direction, &column, &row);
    memcpy(radiance, texel(e, column, row), 3 * sizeof *radiance);
}

/* Not so near to the edge of a texel `angle` wide that a direction in float could lie in the next. */
static double inside(double u, double angle) {
    const double edge = fmin(4 * 0x1p-24 / angle, 0.25);
    return edge + (1 - 2 * edge) * u;
}

/* The place (u, v) of a texel, evenly over its solid angle. */
static vec3_f64 in_texel(const environment *e, uint32_t column, uint32_t row, double u, double v) {
    const double top = row_cosine(e, row), bottom = row_cosine(e, row + 1);
    const double place = (column + inside(u, 2 * SHAPE_PI / e->width)) / e->width;
    const double y = top + (bottom - top) * inside(v, SHAPE_PI / e->height), r = sqrt(fmax(1 - y * y, 0));
    double c, s;
    shape_turn(place, &c, &s);
    return to_world(e, (vec3_f64){r * s, y, -r * c});
}

static void no_light(unsigned lanes, lanes3_f64 direction, environment_light *out) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        put_lane_f64(direction, i, (vec3_f64){0, 0, 1});
        for (int c = 0; c < 3; ++c) out->radiance[c][i] = 0;
        out->density[i] = 0;
    }
}

void environment_sample(const environment *e, unsigned lanes, const lanes3_f64 n, const double u[LANES],
                        const double v[LANES], lanes3_f64 direction, environment_light *out) {
    lanes3_f64 turned;
    sky_texels texels;
    double place[2][LANES];
    memcpy(place[0], u, sizeof place[0]), memcpy(place[1], v, sizeof place[1]);
    turn_normals(e, lanes, n, turned);
    const unsigned taken = sky_choice_take(e->choice, lanes, turned, place[0], place[1], &texels);
    no_light(lanes & ~taken, direction, out);
    for (unsigned left = taken; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        put_lane_f64(direction, i, in_texel(e, texels.column[i], texels.row[i], place[0][i], place[1][i]));
    }
    look_up(e, taken, turned, &texels, out);
}
