/* A matrix/curve display profile as ICC.1:2004-10 (version 4.2) lays it down: a header, a table of tags, the
 * tags' data; all big-endian. Written out rather than carried as bytes, so that it can be read. */
#include "image/icc.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { HEADER = 128, TAGS = 10, TABLE = 4 + 12 * TAGS };

typedef struct icc {
    unsigned char *bytes;
    size_t end; /* of the tags' data so far */
    unsigned tags;
} icc;

static void put32(unsigned char *at, uint32_t value) {
    for (int i = 0; i < 4; ++i) at[i] = (unsigned char)(value >> (24 - 8 * i));
}

/* Four letters. */
static void put_name(unsigned char *at, const char *name) { memcpy(at, name, 4); }

/* A tag with `size` bytes of data of the type named; returns where its values go. */
static unsigned char *add_tag(icc *profile, const char *name, const char *type, uint32_t size) {
    unsigned char *entry = profile->bytes + HEADER + 4 + (size_t)12 * profile->tags++;
    unsigned char *data = profile->bytes + profile->end;
    put_name(entry, name);
    put32(entry + 4, (uint32_t)profile->end);
    put32(entry + 8, size);
    put_name(data, type);
    profile->end += (size + 3) / 4 * 4;
    return data + 8;
}

/* s15Fixed16Number */
static void put_fixed(unsigned char *at, const double *values, size_t count) {
    for (size_t i = 0; i < count; ++i) put32(at + 4 * i, (uint32_t)(int32_t)lrint(values[i] * 65536));
}

static void add_xyz(icc *profile, const char *name, double x, double y, double z) {
    const double xyz[3] = {x, y, z};
    put_fixed(add_tag(profile, name, "XYZ ", 20), xyz, 3);
}

/* One record, in American English, UTF-16. */
static void add_text(icc *profile, const char *name, const char *text) {
    uint32_t length = (uint32_t)strlen(text);
    unsigned char *at = add_tag(profile, name, "mluc", 28 + 2 * length);
    put32(at, 1), put32(at + 4, 12);
    memcpy(at + 8, "enUS", 4);
    put32(at + 12, 2 * length), put32(at + 16, 28);
    for (uint32_t i = 0; i < length; ++i) at[20 + 2 * i + 1] = (unsigned char)text[i];
}

static void add_curves(icc *profile) {
    /* Y = (aX + b)^g for X >= d, else cX: parametric curve type 3. */
    const double curve[5] = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
    size_t offset = profile->end;
    unsigned char *at = add_tag(profile, "rTRC", "para", 32);
    at[1] = 3;
    put_fixed(at + 4, curve, 5);
    static const char *const same[] = {"gTRC", "bTRC"};
    for (size_t i = 0; i < 2; ++i) {
        unsigned char *entry = profile->bytes + HEADER + 4 + (size_t)12 * profile->tags++;
        put_name(entry, same[i]);
        put32(entry + 4, (uint32_t)offset);
        put32(entry + 8, 32);
    }
}

void icc_srgb(unsigned char out[ICC_SRGB_SIZE]) {
    memset(out, 0, ICC_SRGB_SIZE);
    icc profile = {out, HEADER + TABLE, 0};
    /* What ICC profiles speak of is seen under D50: BT.709's primaries and D65, adapted by Bradford's matrix.
     */
    const double bradford[9] = {1.047886,   0.0229188,  -0.0502161, 0.0295818, 0.9904835,
                                -0.0170787, -0.0092519, 0.0150726,  0.7516781};
    add_text(&profile, "desc", "sRGB");
    add_text(&profile, "cprt", "No copyright");
    add_xyz(&profile, "wtpt", 0.9642, 1, 0.8249);
    put_fixed(add_tag(&profile, "chad", "sf32", 44), bradford, 9);
    add_xyz(&profile, "rXYZ", 0.4360413, 0.2224845, 0.0139202);
    add_xyz(&profile, "gXYZ", 0.3851129, 0.7169051, 0.0970672);
    add_xyz(&profile, "bXYZ", 0.1430458, 0.0606104, 0.7139126);
    add_curves(&profile);
    put32(out + HEADER, profile.tags);
    put32(out, (uint32_t)profile.end);
    put32(out + 8, 0x04200000u);
    put_name(out + 12, "mntr"), put_name(out + 16, "RGB "), put_name(out + 20, "XYZ "),
        put_name(out + 36, "acsp");
    const uint16_t date[6] = {2024, 1, 1, 0, 0, 0};
    for (size_t i = 0; i < 6; ++i)
        out[24 + 2 * i] = (unsigned char)(date[i] >> 8), out[25 + 2 * i] = (unsigned char)date[i];
    const double d50[3] = {0.9642, 1, 0.8249};
    put_fixed(out + 68, d50, 3);
}
