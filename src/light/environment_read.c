#include "light/environment.h"

#include "base/file.h"
#include "image/helper/helper.h"
#include "light/cube.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- one file ---- */

static bool is_linear(const char *path) { return !file_ends_in(path, "png|jpg|jpeg|gif|bmp|webp|tga|ktx2"); }

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

/* Sets the image's texels in `out`, whose rows are `stride` long. Squares of a cross that are not faces
 * stay 0, and so do pixels without data in the file. Data outside of the full image are not used. */
static fathom_status load_texels(fathom_context *context, const fathom_light *light, const char *path,
                                 const image *img, size_t stride, sky_texel *out) {
    const image_channel *rgb[3];
    size_t negative = 0;
    cube faces;
    const bool cross = cube_find(img->full_width, img->full_height, &faces);
    if (!find_channels(img, rgb))
        return fail_file(context, FATHOM_BAD_INPUT, path, "expected the channels R, G and B, or one");
    for (size_t i = 0; i < (size_t)img->width * img->height; ++i) {
        const uint32_t column = (uint32_t)(i % img->width), row = (uint32_t)(i / img->width);
        const uint32_t x = img->x + column, y = img->y + row;
        if (x >= img->full_width || y >= img->full_height) continue;
        float *to = out[y * stride + x].rgb;
        for (int c = 0; c < 3; ++c) {
            const float value =
                cross && !cube_covers(&faces, x, y) ? 0 : channel_at(img, rgb[c], column, row);
            to[c] = value > 0 ? value * light->intensity[c] : 0;
            negative += value < 0;
            if (!isfinite(value) || !isfinite(to[c])) return bad_texel(context, path, x, y, c, value);
        }
    }
    if (negative) warn(context, "%s: %zu numbers are negative; they count as 0", path, negative);
    return FATHOM_OK;
}

static fathom_status fail_display(fathom_context *context, const char *path, const char *what) {
    return fail_file(
        context, FATHOM_BAD_INPUT, path,
        "expected an image of linear radiance (.exr, .hdr, .pfm, .tif); %s colours for a display", what);
}

static fathom_status open_image(fathom_context *context, const char *path, const image **out) {
    if (!is_linear(path)) return fail_display(context, path, "this format holds");
    fathom_status status = image_read(context, path, out);
    if (status != FATHOM_OK) return status;
    const uint64_t count = (uint64_t)(*out)->full_width * (*out)->full_height;
    if ((*out)->bits == 8) /* nobody stores radiance in so few steps */
        status = fail_display(context, path, "this one has 8 bits, and so");
    else if (!count || count > INT32_MAX)
        status = fail_file(context, FATHOM_BAD_INPUT, path, "expected 1 to 2^31 - 1 texels, found %llu",
                           (unsigned long long)count);
    if (status != FATHOM_OK) image_release(*out);
    return status;
}

static fathom_status allocate(fathom_context *context, uint32_t width, uint32_t height, sky_image *out) {
    const size_t count = (size_t)width * height, size = sizeof *out->texels;
    *out = (sky_image){.width = width, .height = height, .texels = calloc(count, size)};
    return out->texels ? FATHOM_OK : fail_memory(context, count * size);
}

static fathom_status read_one(fathom_context *context, const fathom_light *light, sky_image *out) {
    const image *img;
    fathom_status status = open_image(context, light->file, &img);
    if (status != FATHOM_OK) return status;
    status = allocate(context, img->full_width, img->full_height, out);
    if (status == FATHOM_OK)
        status = load_texels(context, light, light->file, img, img->full_width, out->texels);
    image_release(img);
    return status;
}

/* ---- cubes ---- */

/* Reads face k to the strip of all six, which the first one makes. */
static fathom_status read_face(fathom_context *context, const fathom_light *light, const char *path,
                               unsigned k, sky_image *strip) {
    const image *img;
    fathom_status status = open_image(context, path, &img);
    if (status != FATHOM_OK) return status;
    const uint32_t side = k ? strip->height : img->full_width;
    if (img->full_width != side || img->full_height != side)
        status = fail_file(context, FATHOM_BAD_INPUT, path,
                           "the image is %u x %u; expected the square face of a cube, %u x %u",
                           img->full_width, img->full_height, side, side);
    else if (!k && side <= CUBE_SIDE_MOST)
        status = allocate(context, FILE_FACES * side, side, strip);
    else if (!k)
        status = fail_file(context, FATHOM_BAD_INPUT, path,
                           "expected at most %u texels along an edge, found %u", CUBE_SIDE_MOST, side);
    if (status == FATHOM_OK)
        status = load_texels(context, light, path, img, (size_t)FILE_FACES * side,
                             strip->texels + (size_t)k * side);
    image_release(img);
    return status;
}

/* Replaces the image of a cube by an equirectangular one. */
static fathom_status unfold(fathom_context *context, const cube *c, sky_image *sky) {
    sky_image round;
    if (c->side > CUBE_SIDE_MOST)
        return fail(context, FATHOM_BAD_INPUT, "expected at most %u texels along an edge of a cube, found %u",
                    CUBE_SIDE_MOST, c->side);
    fathom_status status = allocate(context, 4 * c->side, 2 * c->side, &round);
    if (status == FATHOM_OK && !cube_unfold(c, sky->texels, fathom_context_threads(context), round.texels))
        status = fail_memory(context, c->side * sizeof(vec3_f64));
    free(sky->texels);
    *sky = round;
    return status;
}

fathom_status environment_read(fathom_context *context, const fathom_light *light, sky_image *out) {
    file_faces files;
    cube faces;
    *out = (sky_image){.texels = NULL};
    fathom_status status = file_faces_open(context, light->file, &files);
    if (status == FATHOM_OK && files.count == 1) status = read_one(context, light, out);
    for (unsigned k = 0; status == FATHOM_OK && files.count > 1 && k < files.count; ++k)
        status = read_face(context, light, files.paths[k], k, out);
    file_faces_close(&files);
    if (status == FATHOM_OK && cube_find(out->width, out->height, &faces))
        status = unfold(context, &faces, out);
    if (status == FATHOM_OK) return status;
    free(out->texels);
    *out = (sky_image){.texels = NULL};
    return status;
}

/* ---- memory ---- */

/* A sky has a texel and a sum for each texel of the image. While it is read, each channel is there as a float
 * twice: in memory shared with the helper, and copied. */
static fathom_status measure_file(fathom_context *context, const char *path, uint64_t *bytes) {
    const image_texture_request request = {.path = path,
                                           .descriptor = -1,
                                           .most_side = INT32_MAX,
                                           .most_texels = INT32_MAX,
                                           .threads = fathom_context_threads(context)};
    image_texture *file;
    image_texture_info info;
    image_message why = {""};
    if (!is_linear(path)) return fail_display(context, path, "this format holds");
    const fathom_status status = image_calls.texture.open(&request, &file, &info, &why);
    if (status != FATHOM_OK)
        return fail_file(context, status, path, "cannot be read as an image: %s", why.text);
    image_calls.texture.close(file);
    *bytes += (uint64_t)info.width * info.height *
              (sizeof(sky_texel) + sizeof(float) + 2 * sizeof(float) * info.channels);
    return FATHOM_OK;
}

fathom_status environment_measure(fathom_context *context, const fathom_scene *scene, uint64_t *bytes) {
    fathom_status status = FATHOM_OK;
    *bytes = 0;
    for (size_t i = 0; i < scene->environments.count && status == FATHOM_OK; ++i) {
        const fathom_place *place = scene_origin_find(scene, SCENE_PART_ENVIRONMENT, (fathom_id)i);
        file_faces files;
        status = file_faces_open(context, scene->environments.items[i].file, &files);
        for (unsigned k = 0; k < files.count && status == FATHOM_OK; ++k)
            status = measure_file(context, files.paths[k], bytes);
        file_faces_close(&files);
        if (status == FATHOM_BAD_INPUT && place) fail_within(context, status, place);
    }
    return status;
}
