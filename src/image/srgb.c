#include "image/srgb.h"

#include "image/byte.h"

#define GAMMA 2.4
#define OFFSET 0.055

typedef struct curve {
    float end, slope; /* of the line, which ends where it meets the power without a bend */
} curve;

/* IEC 61966-2-1 before its constants were rounded: a slope of 12.9232 rather than 12.92. */
static curve curve_of_srgb(void) {
    double end = pow(OFFSET * GAMMA / ((GAMMA - 1) * (1 + OFFSET)), GAMMA);
    return (curve){(float)end, (float)(OFFSET / (GAMMA - 1) / end)};
}

/* Each constant and step in float, as OpenColorIO has them. Its power is in float too; rounded from double it
 * is as good, and the same on every machine. */
static unsigned char code_of(curve c, float value) {
    const double exponent = (double)(float)(1 / GAMMA);
    float power = (float)pow((double)value, exponent) * (float)(1 + OFFSET) - (float)OFFSET;
    return byte_from_float(value > c.end ? power : value * c.slope);
}

/* The least value whose code is above `code`, by steps from where the curve itself passes the middle of the
 * two. */
static float next_of(curve c, unsigned char code) {
    double shown = (code + 0.5) / 255, bend = (double)c.end * (double)c.slope;
    float at = (float)(shown > bend ? pow((shown + OFFSET) / (1 + OFFSET), GAMMA) : shown / (double)c.slope);
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
