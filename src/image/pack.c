#include "image/pack.h"

#include <string.h>

/* ---- sRGB ---- */

#define GAMMA 2.4
#define OFFSET 0.055

typedef struct curve {
    float end, slope; /* end and slope of the linear part, which is tangent to the power curve */
} curve;

/* IEC 61966-2-1 without rounded constants: a slope of 12.9232 instead of 12.92. */
static curve curve_of_srgb(void) {
    double end = pow(OFFSET * GAMMA / ((GAMMA - 1) * (1 + OFFSET)), GAMMA);
    return (curve){(float)end, (float)(OFFSET / (GAMMA - 1) / end)};
}

/* Constants and steps are in float, as in OpenColorIO. OpenColorIO also computes the power in float. Here it
 * is rounded from double, which is as accurate and gives the same result on every machine. */
static unsigned char code_of(curve c, float value) {
    const double exponent = (double)(float)(1 / GAMMA);
    float power = (float)pow((double)value, exponent) * (float)(1 + OFFSET) - (float)OFFSET;
    return byte_from_float(value > c.end ? power : value * c.slope);
}

/* The smallest value whose code is above `code`. The search starts where the curve passes the middle between
 * the two codes. */
static float next_of(curve c, unsigned char code) {
    double shown = (code + 0.5) / 255, knee = (double)c.end * (double)c.slope;
    float at = (float)(shown > knee ? pow((shown + OFFSET) / (1 + OFFSET), GAMMA) : shown / (double)c.slope);
    while (code_of(c, at) <= code) at = nextafterf(at, 1);
    for (float below; code_of(c, below = nextafterf(at, 0)) > code;) at = below;
    return at;
}

void srgb_codes_fill(srgb_codes *out) {
    curve c = curve_of_srgb();
    for (unsigned code = 0; code < 255; ++code) out->next[code] = next_of(c, (unsigned char)code);
    out->next[255] = INFINITY;
    unsigned char code = 0;
    for (uint32_t bucket = 0; bucket < SRGB_BUCKETS; ++bucket) {
        uint32_t bits = (bucket + SRGB_FIRST_BUCKET) << 16;
        float least;
        memcpy(&least, &bits, sizeof least);
        while (least >= out->next[code]) ++code;
        out->first[bucket] = code;
    }
}

/* ---- rows ---- */

static const unsigned char *row_of(const image *img, const image_channel *channel, uint32_t y) {
    return (const unsigned char *)channel->data + (size_t)y * img->width * channel->stride;
}

static float load(const unsigned char *from) {
    float value;
    memcpy(&value, from, sizeof value);
    return value;
}

/* Clamps values for views, because some turn infinity into NaN and 1e30 into black. The largest half is white
 * in all views. */
static float viewable(float value) {
    const float largest = 65504.0f;
    if (!(value > -largest)) return value <= -largest ? -largest : 0.0f; /* NaN is 0 */
    return value < largest ? value : largest;
}

static const image_channel *alpha_of(const image *img) {
    return img->channel_count > 3 ? &img->channels[3] : NULL;
}

static float load_at(const image *img, const image_channel *channel, uint32_t y, size_t x) {
    return load(row_of(img, channel, y) + x * channel->stride);
}

/* The factor that removes premultiplied alpha from linear light, before the view. With alpha 0 the colour is
 * kept. */
static float scale_by(const image_packing *packing, float alpha) {
    return alpha > 0.0f && alpha < 1.0f ? packing->gain / alpha : packing->gain;
}

void pack_row_for_view(const image_packing *packing, uint32_t y, float *rgba) {
    const image *img = packing->img;
    const image_channel *alpha = alpha_of(img);
    for (size_t x = 0; x < img->width; ++x) {
        float scale = scale_by(packing, alpha ? load_at(img, alpha, y, x) : 1.0f);
        for (size_t c = 0; c < 3; ++c)
            rgba[4 * x + c] = viewable(load_at(img, &img->channels[c], y, x) * scale);
        rgba[4 * x + 3] = 1.0f;
    }
}

void pack_row_srgb(const image_packing *packing, uint32_t y, unsigned char *out) {
    const image *img = packing->img;
    const image_channel *alpha = alpha_of(img);
    for (size_t x = 0; x < img->width; ++x) {
        float a = alpha ? load_at(img, alpha, y, x) : 1.0f, scale = scale_by(packing, a);
        for (size_t c = 0; c < 3; ++c)
            *out++ = srgb_code(packing->srgb, load_at(img, &img->channels[c], y, x) * scale);
        if (alpha) *out++ = byte_from_float(a);
    }
}

void pack_row_from_view(const image_packing *packing, uint32_t y, const float *rgba, unsigned char *out) {
    const image *img = packing->img;
    const image_channel *alpha = alpha_of(img);
    for (size_t x = 0; x < img->width; ++x) {
        for (size_t c = 0; c < 3; ++c) *out++ = byte_from_float(rgba[4 * x + c]);
        if (alpha) *out++ = byte_from_float(load_at(img, alpha, y, x));
    }
}
