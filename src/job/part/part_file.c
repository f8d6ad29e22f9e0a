#include "job/part/part_file.h"

#include "base/hash.h"

#include <stdio.h>
#include <string.h>

_Static_assert(sizeof(part_record) == 12 * 8, "no bytes between the fields");

/* ---- the shape ---- */

static uint32_t common_divisor(uint32_t a, uint32_t b) {
    while (b) {
        const uint32_t remainder = a % b;
        a = b, b = remainder;
    }
    return a;
}

/* The stride must be coprime to the number of tiles, so that each tile gets its own place. */
static uint32_t stride_of(uint32_t count) {
    uint32_t stride = (uint32_t)(0.618033988749895 * count);
    while (common_divisor(stride, count) != 1) ++stride;
    return stride;
}

bool part_owns(const part_shape *s, uint32_t wave) {
    const uint64_t place = (uint64_t)wave * s->stride % s->grid.count;
    return s->sums || place * s->count / s->grid.count == s->index;
}

part_shape part_shape_of(const part_head *head) {
    const fathom_settings *settings = &head->settings;
    const settings_region r = settings_region_of(settings);
    part_shape s = {.index = head->index - 1,
                    .count = head->count,
                    .sums = head->split == FATHOM_SPLIT_SAMPLES,
                    .grid = wave_grid_of(r.x, r.y, r.x + r.width, r.y + r.height)};
    s.range = s.sums ? sum_part(settings->spp, s.index, s.count) : (sum_range){0, settings->spp};
    s.stride = stride_of(s.grid.count);
    s.square_bytes = s.sums
                         ? sum_list_nodes(s.range, NULL) *
                               sum_bytes(unit_groups(settings), film_parts_of(settings, &head->light_groups))
                         : film_channels(settings, &head->light_groups) * LANES * sizeof(uint32_t);
    return s;
}

size_t part_wave_bytes(const part_shape *s, uint32_t wave) {
    const uint64_t squares = wave_region_bits(wave_grid_region(&s->grid, wave));
    return (size_t)__builtin_popcountll(squares) * s->square_bytes;
}

/* ---- the head ---- */

size_t part_head_bytes(const part_head *head) {
    size_t bytes = sizeof *head;
    for (int k = 0; k < MATTE_KINDS; ++k) bytes += head->manifests[k];
    return bytes;
}

uint64_t part_head_hash(const part_head *head, const char *const manifests[MATTE_KINDS]) {
    hash h;
    hash_begin(&h);
    hash_put(&h, head, sizeof *head);
    for (int k = 0; k < MATTE_KINDS; ++k) {
        if (head->manifests[k]) hash_put(&h, manifests[k], head->manifests[k]);
    }
    return hash_end(&h);
}

void part_exposure_print(const part_head *head, char out[64]) {
    if (head->exposed)
        snprintf(out, 64, "%.9g", (double)head->exposure);
    else
        strcpy(out, "none");
}

const char *part_manifest(const part_head *head, const unsigned char *bytes, matte_kind kind) {
    size_t at = sizeof *head;
    for (int k = 0; k < (int)kind; ++k) at += head->manifests[k];
    return head->manifests[kind] ? (const char *)bytes + at : NULL;
}

static bool manifests_make_sense(const part_head *h, const unsigned char *bytes) {
    const film_parts parts = film_parts_of(&h->settings, &h->light_groups);
    for (int k = 0; k < MATTE_KINDS; ++k) {
        const char *text = part_manifest(h, bytes, (matte_kind)k);
        if ((text != NULL) != (parts.mattes[k] >= 0)) return false;
        if (text && memchr(text, 0, h->manifests[k]) != text + h->manifests[k] - 1) return false;
    }
    return true;
}

static bool ends(const char *text, size_t size) { return memchr(text, 0, size); }

static bool is_whole(const part_head *h) {
    return checkpoint_key_is_whole(&h->key) && ends(h->scene, sizeof h->scene) &&
           ends(h->stats.tracer, sizeof h->stats.tracer);
}

/* A correct hash does not prove that the values are valid, so check them. */
static bool makes_sense(const part_head *h) {
    const bool split = h->split == FATHOM_SPLIT_SAMPLES || h->split == FATHOM_SPLIT_TILES;
    if (!split || !h->index || h->index > h->count || h->count > PART_MOST || h->settings.tracer ||
        h->settings.size != sizeof h->settings)
        return false;
    if (h->octave > 2 || h->light_groups.count > LIGHT_GROUPS ||
        (h->exposed && !(fabs((double)h->exposure) < PART_EXPOSURE)))
        return false;
    for (uint32_t i = 0; i < h->light_groups.count; ++i) {
        if (!ends(h->light_groups.names[i], LIGHT_GROUP_NAME)) return false;
    }
    if (scene_check_settings(NULL, &h->settings) != FATHOM_OK || h->settings.max_time > 0) return false;
    return h->split == FATHOM_SPLIT_TILES ||
           (!(h->settings.target_error > 0) && h->count <= sum_leaves(h->settings.spp));
}

static fathom_status damaged(fathom_context *context, const char *path) {
    return fail_file(context, FATHOM_BAD_INPUT, path,
                     "the part is damaged at its beginning; remove it, and render it again");
}

fathom_status part_head_read(fathom_context *context, const char *path, const unsigned char *bytes,
                             size_t size, part_head *out) {
    uint64_t sum;
    if (size < sizeof out->magic || memcmp(bytes, PART_MAGIC, sizeof out->magic) != 0) {
        return fail_file(context, FATHOM_BAD_INPUT, path,
                         "is not a part of an image; expected a file that fathom render --part wrote");
    }
    if (size < sizeof *out + sizeof sum) return damaged(context, path);
    memcpy(out, bytes, sizeof *out);
    const char *now = fathom_version();
    if (out->format != PART_FORMAT || out->bytes != sizeof *out || strcmp(out->key.version, now) != 0) {
        return fail_file(
            context, FATHOM_BAD_INPUT, path,
            "the part is of Fathom %.31s, format %u, and this is Fathom %s, format %u; expected the "
            "same version for all parts and for merging them",
            out->key.version, out->format, now, PART_FORMAT);
    }
    const size_t whole = part_head_bytes(out);
    if (size < whole + sizeof sum) return damaged(context, path);
    memcpy(&sum, bytes + whole, sizeof sum);
    if (hash_of(bytes, whole) != sum || !is_whole(out) || !makes_sense(out) ||
        !manifests_make_sense(out, bytes))
        return damaged(context, path);
    return FATHOM_OK;
}

/* ---- records ---- */

bool part_record_next(const part_shape *shape, const unsigned char *bytes, size_t size, size_t *at,
                      bool *done, part_record *out, const unsigned char **payload) {
    const size_t left = size - *at;
    part_record r;
    uint64_t sum;
    if (left < sizeof r) return false;
    memcpy(&r, bytes + *at, sizeof r);
    if (r.magic != PART_RECORD || r.wave >= shape->grid.count || done[r.wave] || !part_owns(shape, r.wave) ||
        r.bytes != part_wave_bytes(shape, r.wave) || left - sizeof r < r.bytes + sizeof sum ||
        !(r.error >= 0) || !(r.seconds >= 0))
        return false;
    memcpy(&sum, bytes + *at + sizeof r + r.bytes, sizeof sum);
    if (hash_of(bytes + *at, sizeof r + r.bytes) != sum) return false;
    *out = r;
    *payload = bytes + *at + sizeof r;
    *at += sizeof r + r.bytes + sizeof sum;
    done[r.wave] = true;
    return true;
}
