#include "light/environment.h"

#include "base/file.h"
#include "image/image.h"
#include "light/studio.h"

#include <stdlib.h>
#include <string.h>

struct environment {
    sky_image sky;
    const sky_kernels *kernels;
};

/* Allocates an environment and its texels. */
static environment *make(fathom_context *context, uint32_t width, uint32_t height) {
    const size_t count = (size_t)width * height;
    environment *e = calloc(1, sizeof *e);
    if (e) {
        e->kernels = sky_kernels_best();
        e->sky.width = width, e->sky.height = height;
        e->sky.texels = malloc(count * sizeof *e->sky.texels);
        if (e->sky.texels) return e;
    }
    environment_destroy(e);
    fail_memory(context, count * sizeof *e->sky.texels);
    return NULL;
}

void environment_destroy(environment *e) {
    if (!e) return;
    sky_close(&e->sky);
    free(e);
}

const sky_image *environment_sky(const environment *e) { return &e->sky; }

double environment_power(const environment *e) { return e->sky.power; }

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

/* Finds R, G and B, or one channel for all three. */
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
    for (size_t i = 0; i < (size_t)e->sky.width * e->sky.height; ++i) {
        const uint32_t x = (uint32_t)(i % e->sky.width), y = (uint32_t)(i / e->sky.width);
        float *rgb_at = e->sky.texels[i].rgb;
        for (int c = 0; c < 3; ++c) {
            const float value = channel_at(img, rgb[c], x, y);
            rgb_at[c] = value > 0 ? value * light->intensity[c] : 0;
            negative += value < 0;
            if (!isfinite(value) || !isfinite(rgb_at[c]))
                return bad_texel(context, light->file, x, y, c, value);
        }
    }
    if (negative) warn(context, "%s: %zu numbers are negative; they count as 0", light->file, negative);
    return FATHOM_OK;
}

/* Call once all texels are set. Destroys *e if memory runs out. */
static fathom_status finish(fathom_context *context, environment **e) {
    const size_t bytes = (size_t)(*e)->sky.width * (*e)->sky.height * sizeof(double);
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

static fathom_status prepare(fathom_context *context, const fathom_light *light, const image *img,
                             environment **out) {
    const size_t count = (size_t)img->width * img->height;
    if (count > INT32_MAX || !count)
        return fail_file(context, FATHOM_BAD_INPUT, light->file, "expected 1 to 2^31 - 1 texels, found %zu",
                         count);
    environment *e = make(context, img->width, img->height);
    if (!e) return FATHOM_OUT_OF_RESOURCES;
    const double cosine = cos(light->rotation), sine = sin(light->rotation);
    const vec3_f64 up = normalize_f64(load_f64(light->up));
    e->sky.axes[0] = turned_up((vec3_f64){cosine, 0, -sine}, up), e->sky.axes[1] = up;
    e->sky.axes[2] = turned_up((vec3_f64){sine, 0, cosine}, up);
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
    for (size_t i = 0; i < (size_t)e->sky.width * e->sky.height; ++i) {
        for (int c = 0; c < 3; ++c) out[c] = fmaxf(out[c], e->sky.texels[i].rgb[c]);
    }
}

/* ---- the studio ---- */

/* A texel is a third of a degree wide: finer than the panels' soft edges. */
#define STUDIO_WIDTH 1024u
#define STUDIO_HEIGHT 512u

/* Sets the axes. If the viewer looks along `up`, the direction of the image's z is arbitrary. */
static void stand(environment *e, vec3_f64 z, vec3_f64 up) {
    vec3_f64 back = sub_f64(z, scale_f64(dot_f64(z, up), up));
    if (!(length_f64(back) > 0x1p-10)) back = fabs(up.z) < 0.9 ? vec_f64(0, 0, 1) : vec_f64(0, -1, 0);
    e->sky.axes[1] = up;
    e->sky.axes[0] = normalize_f64(cross_f64(up, back));
    e->sky.axes[2] = cross_f64(e->sky.axes[0], up);
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
            e->sky.texels[i].rgb);
    return finish(context, out);
}

/* ---- asking ---- */

void environment_at(const environment *e, unsigned lanes, const lanes3_f64 n, const lanes3_f64 direction,
                    sky_light *out) {
    e->kernels->at(&e->sky, lanes, n, direction, out);
}

void environment_radiance(const environment *e, vec3_f64 direction, float radiance[3]) {
    const lanes3_f64 d = {{direction.x}, {direction.y}, {direction.z}}, n = {{0}};
    sky_light light;
    e->kernels->at(&e->sky, 1, n, d, &light);
    for (int c = 0; c < 3; ++c) radiance[c] = light.radiance[c][0];
}

void environment_sample(const environment *e, unsigned lanes, const lanes3_f64 n, const double u[LANES],
                        const double v[LANES], lanes3_f64 direction, sky_light *out) {
    e->kernels->sample(&e->sky, lanes, n, u, v, direction, out);
}
