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
    vec3_f64 axes[3];  /* right, up and back of the image, in the world */
    sky_texel *texels; /* by row from the top */
    double *cosines;   /* to the image's top, where rows of cells begin, and where the last one ends */
    /* Parts of a cell's width and height: so near to its edge a direction in float could lie in the next,
     * which may be in another block, of another density. */
    double margin[2];
    sky_choice *choice;
};

static double margin_of(double angle) { return fmin(4 * 0x1p-24 / angle, 0.25); }

static environment *make(fathom_context *context, uint32_t width, uint32_t height) {
    const size_t count = (size_t)width * height;
    environment *e = calloc(1, sizeof *e);
    if (e) {
        e->width = width, e->height = height;
        e->margin[0] = margin_of(2 * SHAPE_PI / width), e->margin[1] = margin_of(SHAPE_PI / height);
        e->texels = malloc(count * sizeof *e->texels);
        e->cosines = malloc(((size_t)height + 2) * sizeof *e->cosines);
        for (uint32_t row = 0; e->cosines && row < height + 2; ++row)
            e->cosines[row] = 1 - 2 * pow(sin(sky_row_angle(row, height) / 2), 2);
        if (e->texels && e->cosines) return e;
    }
    environment_destroy(e);
    fail_memory(context, count * sizeof *e->texels);
    return NULL;
}

void environment_destroy(environment *e) {
    if (!e) return;
    sky_choice_destroy(e->choice);
    free(e->texels);
    free(e->cosines);
    free(e);
}

environment_image environment_image_of(const environment *e) {
    return (environment_image){e->width, e->height, {e->axes[0], e->axes[1], e->axes[2]}, e->texels};
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
            e->texels[i].rgb[c] = value > 0 ? value * light->intensity[c] : 0;
            negative += value < 0;
            if (!isfinite(value) || !isfinite(e->texels[i].rgb[c]))
                return bad_texel(context, light->file, x, y, c, value);
        }
    }
    if (negative) warn(context, "%s: %zu numbers are negative; they count as 0", light->file, negative);
    return FATHOM_OK;
}

/* Once all texels are in. Destroys *e where memory lacks. */
static fathom_status finish(fathom_context *context, environment **e) {
    const uint32_t width = (*e)->width, height = (*e)->height;
    for (size_t i = 0; i < (size_t)width * height; ++i)
        (*e)->texels[i].luminance = (float)sky_luminance((*e)->texels[i].rgb);
    (*e)->choice = sky_choice_create(width, height, (*e)->texels);
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
        for (int c = 0; c < 3; ++c) out[c] = fmaxf(out[c], e->texels[i].rgb[c]);
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
            e->texels[i].rgb);
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

/* ---- places: cells, and how far into them ---- */

typedef struct sky_places {
    sky_cells cells;
    double u[LANES], v[LANES]; /* [0,1], to the next column and row of texels */
} sky_places;

static uint32_t least(uint32_t a, uint32_t b) { return a < b ? a : b; }

static void find_place(const environment *e, vec3_f64 direction, unsigned i, sky_places *out) {
    const vec3_f64 d = to_image(e, direction);
    const double half = shape_angle(fabs(d.x), -d.z) / (2 * SHAPE_PI), u = d.x < 0 ? 0.5 - half : 0.5 + half,
                 v = shape_angle(sqrt(d.x * d.x + d.z * d.z), d.y) / SHAPE_PI;
    double across = u * e->width - 0.5;
    across += across < 0 ? e->width : 0;
    const uint32_t column = least((uint32_t)across, e->width - 1),
                   row = least((uint32_t)(v * e->height + 0.5), e->height);
    const double *ends = e->cosines + row, down = (ends[0] - d.y) / (ends[0] - ends[1]);
    out->cells.column[i] = column, out->cells.row[i] = row;
    out->u[i] = fmin(across - column, 1), out->v[i] = fmin(fmax(down, 0), 1);
}

/* The texels at the corners: above, then below. */
typedef struct sky_corners {
    const sky_texel *at[2][2];
} sky_corners;

static sky_corners corners_of(const environment *e, const sky_cells *cells, unsigned i) {
    const uint32_t column = cells->column[i], row = cells->row[i];
    const uint32_t next = column + 1 < e->width ? column + 1 : 0;
    const sky_texel *above = e->texels + (size_t)(row ? row - 1 : 0) * e->width,
                    *below = e->texels + (size_t)least(row, e->height - 1) * e->width;
    return (sky_corners){{{above + column, above + next}, {below + column, below + next}}};
}

/* Of two rows and columns. */
static sky_texel blend(const sky_corners *from, float u, float v) {
    const sky_texel *a = from->at[0][0], *b = from->at[0][1], *c = from->at[1][0], *d = from->at[1][1];
    sky_texel out;
    for (int k = 0; k < 4; ++k) {
        const float above = a->all[k] + u * (b->all[k] - a->all[k]),
                    below = c->all[k] + u * (d->all[k] - c->all[k]);
        out.all[k] = above + v * (below - above);
    }
    return out;
}

static double between(double u, double a, double b) { return a + u * (b - a); }

/* The number u in [0,1) to a place in [0,1] with a density that goes from a to b. */
static double along_slope(double u, double a, double b) {
    const double root = a + sqrt(between(u, a * a, b * b));
    return root > 0 ? fmin(u * (a + b) / root, 1) : u;
}

/* The cell's place by luminance, from two numbers in [0,1). */
static void choose_place(const environment *e, unsigned i, double u, double v, sky_places *out) {
    const sky_corners corners = corners_of(e, &out->cells, i);
    double light[2][2];
    for (int k = 0; k < 4; ++k) light[k >> 1][k & 1] = (double)corners.at[k >> 1][k & 1]->luminance;
    const double down = along_slope(v, light[0][0] + light[0][1], light[1][0] + light[1][1]);
    out->v[i] = down;
    out->u[i] =
        along_slope(u, between(down, light[0][0], light[1][0]), between(down, light[0][1], light[1][1]));
}

static double inside(double u, double margin) { return margin + (1 - 2 * margin) * u; }

static vec3_f64 direction_of(const environment *e, const sky_places *p, unsigned i) {
    const double *ends = e->cosines + p->cells.row[i],
                 turn = (p->cells.column[i] + 0.5 + inside(p->u[i], e->margin[0])) / e->width,
                 y = between(inside(p->v[i], e->margin[1]), ends[0], ends[1]), r = sqrt(fmax(1 - y * y, 0));
    double c, s;
    shape_turn(turn < 1 ? turn : turn - 1, &c, &s);
    return to_world(e, (vec3_f64){r * s, y, -r * c});
}

/* ---- light ---- */

static void prefetch(const environment *e, const sky_cells *cells, unsigned i) {
    const sky_corners corners = corners_of(e, cells, i);
    __builtin_prefetch(corners.at[0][0]);
    __builtin_prefetch(corners.at[1][0]);
}

/* n: in the image's axes. */
static void look_up(const environment *e, unsigned lanes, const lanes3_f64 n, const sky_places *places,
                    environment_light *out) {
    sky_choice_densities(e->choice, lanes, n, &places->cells, out->density);
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const sky_corners corners = corners_of(e, &places->cells, i);
        const sky_texel light = blend(&corners, (float)places->u[i], (float)places->v[i]);
        for (int c = 0; c < 3; ++c) out->radiance[c][i] = light.rgb[c];
        out->density[i] *= (double)light.luminance;
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
    sky_places places;
    turn_normals(e, lanes, n, turned);
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        find_place(e, lane_f64(direction, i), i, &places);
        prefetch(e, &places.cells, i);
    }
    look_up(e, lanes, turned, &places, out);
}

void environment_radiance(const environment *e, vec3_f64 direction, float radiance[3]) {
    sky_places place;
    find_place(e, direction, 0, &place);
    const sky_corners corners = corners_of(e, &place.cells, 0);
    const sky_texel light = blend(&corners, (float)place.u[0], (float)place.v[0]);
    memcpy(radiance, light.rgb, sizeof light.rgb);
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
    sky_places places;
    memcpy(places.u, u, sizeof places.u), memcpy(places.v, v, sizeof places.v);
    turn_normals(e, lanes, n, turned);
    const unsigned taken = sky_choice_take(e->choice, lanes, turned, places.u, places.v, &places.cells);
    no_light(lanes & ~taken, direction, out);
    for (unsigned left = taken; left; left &= left - 1) prefetch(e, &places.cells, lane_first(left));
    for (unsigned left = taken; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        choose_place(e, i, places.u[i], places.v[i], &places);
        put_lane_f64(direction, i, direction_of(e, &places, i));
    }
    look_up(e, taken, turned, &places, out);
}
