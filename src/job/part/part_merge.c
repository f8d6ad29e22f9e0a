/* Merges parts into a film. Their files stay mapped; each tile is read from all parts before the next one. */
#include "base/file.h"
#include "base/sized.h"
#include "job/part/part_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct source {
    const char *path;
    file_map map;
    part_head *head;
    part_shape shape;
    size_t *tiles; /* for each tile, the offset of its bytes; only with samples */
} source;

typedef struct merging {
    fathom_context *context;
    source *sources; /* by part, after order() */
    size_t count;
    fathom_film *film;
    bool *done;
} merging;

/* ---- which parts there are ---- */

static fathom_status of_another(const merging *m, const source *s, const char *name, const char *theirs,
                                const char *first) {
    return fail_file(m->context, FATHOM_BAD_INPUT, s->path,
                     "the part was rendered with %s %s, and %s with %s; expected parts of one render", name,
                     theirs, m->sources[0].path, first);
}

static fathom_status compare(const merging *m, const source *s) {
    const part_head *a = s->head, *b = m->sources[0].head;
    key_difference d;
    char texts[2][32];
    snprintf(texts[0], sizeof texts[0], "%u", a->count), snprintf(texts[1], sizeof texts[1], "%u", b->count);
    if (a->count != b->count) return of_another(m, s, "a number of parts of", texts[0], texts[1]);
    if (a->split != b->split)
        return a->split == FATHOM_SPLIT_TILES ? of_another(m, s, "a split by", "tiles", "samples")
                                              : of_another(m, s, "a split by", "samples", "tiles");
    if (checkpoint_key_differs(&a->key, &b->key, &d)) return of_another(m, s, d.name, d.saved, d.now);
    return FATHOM_OK;
}

static fathom_status open_source(const merging *m, source *s) {
    fathom_status status = file_open(m->context, s->path, &s->map);
    if (status != FATHOM_OK) return status;
    s->head = malloc(sizeof *s->head);
    if (!s->head) return fail_memory(m->context, sizeof *s->head);
    status = part_head_read(m->context, s->path, s->map.bytes, s->map.size, s->head);
    if (status != FATHOM_OK) return status;
    s->shape = part_shape_of(s->head);
    return compare(m, s);
}

#define LISTED 200

/* "3, 7, 9"; ends with "…" if more are missing than fit. */
static void list_missing(const source *const *by_part, uint32_t count, char out[LISTED + 8]) {
    size_t used = 0;
    out[0] = '\0';
    for (uint32_t i = 0; i < count; ++i) {
        if (by_part[i]) continue;
        if (used > LISTED - 16) {
            snprintf(out + used, 8, ", …");
            return;
        }
        used += (size_t)snprintf(out + used, 16, "%s%u", used ? ", " : "", i + 1);
    }
}

static fathom_status find_parts(const merging *m, const source **by_part) {
    char missing[LISTED + 8];
    const uint32_t count = m->sources[0].head->count;
    for (size_t i = 0; i < m->count; ++i) {
        const source *s = &m->sources[i], **place = &by_part[s->shape.index];
        if (*place) {
            return fail_file(m->context, FATHOM_BAD_INPUT, s->path,
                             "is part %u of %u, and so is %s; expected each part once", s->head->index, count,
                             (*place)->path);
        }
        *place = s;
    }
    if (m->count == count) return FATHOM_OK;
    list_missing(by_part, count, missing);
    return fail_file(m->context, FATHOM_BAD_INPUT, m->sources[0].path,
                     "is one of %u parts, and missing are: %s", count, missing);
}

/* Sorts the parts, and checks that each occurs once. */
static fathom_status order(merging *m) {
    const uint32_t count = m->sources[0].head->count;
    const source **by_part = calloc(count, sizeof *by_part);
    source *sorted = malloc(m->count * sizeof *sorted);
    fathom_status status = by_part && sorted ? find_parts(m, by_part) : fail_memory(m->context, count);
    for (size_t i = 0; i < m->count && status == FATHOM_OK; ++i) sorted[i] = *by_part[i];
    if (status == FATHOM_OK) memcpy(m->sources, sorted, m->count * sizeof *sorted);
    free(by_part);
    free(sorted);
    return status;
}

/* ---- one part ---- */

static void count_record(fathom_stats *stats, const part_record *r) {
    ray_counts_add(&r->rays, 1, (ray_counts *)(void *)&stats->camera_rays);
    stats->samples += r->samples;
    stats->render_seconds += r->seconds;
    stats->error_estimate = fmax(stats->error_estimate, r->error);
}

static fathom_status check_whole(const merging *m, const source *s, size_t end) {
    uint32_t tiles = 0, finished = 0;
    for (uint32_t i = 0; i < s->shape.grid.count; ++i) {
        tiles += part_owns(&s->shape, i);
        finished += m->done[i];
    }
    if (finished == tiles && end == s->map.size) return FATHOM_OK;
    return fail_file(m->context, FATHOM_BAD_INPUT, s->path,
                     "part %u of %u holds %u of its %u tiles%s; run the same command again to complete it",
                     s->head->index, s->head->count, finished, tiles,
                     end == s->map.size ? "" : ", and then bytes that are damaged or cut off");
}

static fathom_status read_part(merging *m, source *s) {
    const unsigned char *payload;
    size_t at = part_head_bytes(s->head) + sizeof(uint64_t);
    memset(m->done, 0, s->shape.grid.count * sizeof *m->done);
    for (part_record r; part_record_next(&s->shape, s->map.bytes, s->map.size, &at, m->done, &r, &payload);) {
        count_record(&m->film->stats, &r);
        if (s->tiles)
            s->tiles[r.wave] = (size_t)(payload - s->map.bytes);
        else
            checkpoint_pixels_load(&s->shape.grid, m->film, r.wave,
                                   wave_region_bits(wave_grid_region(&s->shape.grid, r.wave)), payload);
    }
    return check_whole(m, s, at);
}

static fathom_status read_parts(merging *m) {
    const part_shape *shape = &m->sources[0].shape;
    fathom_status status = FATHOM_OK;
    m->done = malloc(shape->grid.count * sizeof *m->done);
    if (!m->done) return fail_memory(m->context, shape->grid.count);
    for (size_t i = 0; i < m->count && status == FATHOM_OK; ++i) {
        source *s = &m->sources[i];
        if (shape->sums && !(s->tiles = calloc(shape->grid.count, sizeof *s->tiles)))
            return fail_memory(m->context, shape->grid.count * sizeof *s->tiles);
        status = read_part(m, s);
    }
    return status;
}

/* ---- samples ---- */

typedef struct adding {
    pixel_sums sums;
    sum_stack stack;
    sum_node *nodes;  /* of one part, then the stack's */
    size_t square_at; /* number of squares of the tile before this one */
    uint32_t samples[WAVE_SQUARES];
} adding;

static void add_part(const source *s, uint32_t wave, adding *a) {
    const film_parts parts = a->sums.parts;
    const uint32_t count = sum_list_nodes(s->shape.range, a->nodes);
    const unsigned char *from = s->map.bytes + s->tiles[wave] + a->square_at * s->shape.square_bytes;
    for (uint32_t i = 0; i < count; ++i, from += sum_bytes(a->sums.groups, parts)) {
        sum_node *top = &a->stack.nodes[a->stack.count];
        top->first = a->nodes[i].first, top->level = a->nodes[i].level;
        sum_load(from, a->sums.groups, parts, &top->sums);
        sum_push(&a->sums, &a->stack);
    }
}

static void add_wave(const merging *m, uint32_t wave, adding *a) {
    const wave_region region = wave_grid_region(&m->sources[0].shape.grid, wave);
    const unit_sink film = unit_film_sink(m->film);
    const unit_result result = {.region = region,
                                .squares = wave_region_bits(region),
                                .sums = &a->sums,
                                .samples = a->samples,
                                .hits = a->samples};
    a->square_at = 0;
    for (uint64_t left = result.squares; left; left &= left - 1, ++a->square_at) {
        const uint32_t square = (uint32_t)__builtin_ctzll(left);
        a->stack.count = 0;
        for (size_t i = 0; i < m->count; ++i) add_part(&m->sources[i], wave, a);
        sum_fold(&a->sums, &a->stack);
        sum_give(&a->stack.nodes[0].sums, square, &a->sums);
    }
    film.take(film.user, &result);
}

static bool prepare_adding(const fathom_film *film, adding *a) {
    const fathom_settings *s = &film->settings;
    const sampler none = {FATHOM_PATTERN_GRID, 1, 0};
    const uint32_t depth = sum_stack_depth((sum_range){0, s->spp});
    for (uint32_t i = 0; i < WAVE_SQUARES; ++i) a->samples[i] = s->spp;
    a->nodes = sum_nodes_create(film->parts, 2 * depth);
    a->stack.nodes = a->nodes + depth;
    return a->nodes && pixel_sums_create(&none, unit_groups(s), film->parts, &a->sums);
}

static fathom_status add_samples(const merging *m) {
    adding *a = calloc(1, sizeof *a);
    const bool fine = a && prepare_adding(m->film, a);
    if (fine) pixel_sums_clear(&a->sums);
    for (uint32_t i = 0; fine && i < m->sources[0].shape.grid.count; ++i) add_wave(m, i, a);
    if (a) {
        pixel_sums_destroy(&a->sums);
        free(a->nodes);
    }
    free(a);
    return fine ? FATHOM_OK : fail_memory(m->context, sizeof *a);
}

/* Pixels do not depend on it, so the parts fit. */
static void compare_exposures(const merging *m) {
    char first[64], other[64];
    part_exposure_print(m->sources[0].head, first);
    for (size_t i = 1; i < m->count; ++i) {
        part_exposure_print(m->sources[i].head, other);
        if (strcmp(first, other) == 0) continue;
        warn(m->context,
             "%s: was rendered with the exposure %s, and %s with %s; the image takes that of part 1 unless "
             "it is given one",
             m->sources[0].path, first, m->sources[i].path, other);
        return;
    }
}

static fathom_status make_film(merging *m) {
    part_head *head = m->sources[0].head;
    const part_shape *shape = &m->sources[0].shape;
    fathom_film like = {.width = shape->grid.x1 - shape->grid.x0,
                        .height = shape->grid.y1 - shape->grid.y0,
                        .x = shape->grid.x0,
                        .y = shape->grid.y0,
                        .full_width = head->settings.width,
                        .full_height = head->settings.height,
                        .settings = head->settings,
                        .parts = {.octave = head->octave},
                        .camera = head->camera,
                        .light_groups = head->light_groups,
                        .in_studio = head->in_studio != 0,
                        .exposed = head->exposed != 0,
                        .exposure = head->exposure,
                        .scene_name = head->scene};
    memcpy(like.background, head->background, sizeof like.background);
    memcpy(like.brightest, head->brightest, sizeof like.brightest);
    for (int k = 0; k < MATTE_KINDS; ++k)
        like.manifests[k] =
            (char *)(uintptr_t)part_manifest(head, m->sources[0].map.bytes, (matte_kind)k); /* is copied */
    compare_exposures(m);
    fathom_status status = film_create_like(m->context, &like, &m->film);
    if (status != FATHOM_OK) return status;
    m->film->stats = head->stats;
    m->film->stats.finished = 1;
    return FATHOM_OK;
}

static fathom_status merge(merging *m, const char *const *paths) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < m->count && status == FATHOM_OK; ++i) {
        m->sources[i].path = paths[i];
        status = open_source(m, &m->sources[i]);
    }
    if (status == FATHOM_OK) status = order(m);
    if (status == FATHOM_OK) status = make_film(m);
    if (status == FATHOM_OK) status = read_parts(m);
    if (status == FATHOM_OK && m->sources[0].shape.sums) status = add_samples(m);
    if (status == FATHOM_OK) film_settle_errors(m->film);
    for (size_t i = 0; i < m->count && status == FATHOM_OK; ++i)
        status = file_check(m->context, &m->sources[i].map);
    return status;
}

static void close_sources(merging *m) {
    for (size_t i = 0; i < m->count; ++i) {
        file_close(&m->sources[i].map);
        free(m->sources[i].head);
        free(m->sources[i].tiles);
    }
    free(m->sources);
    free(m->done);
}

fathom_status fathom_parts_merge(fathom_context *context, const char *const *paths, size_t count,
                                 fathom_stats *stats, fathom_film **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !paths) return fail_null(context, "paths");
    if (!count) return fail(context, FATHOM_BAD_USAGE, "paths: expected one part or more");
    fathom_status status = stats ? sized_check(context, "stats", stats, sizeof *stats) : FATHOM_OK;
    if (status != FATHOM_OK) return status;
    merging m = {.context = context, .count = count, .sources = calloc(count, sizeof *m.sources)};
    if (!m.sources) return fail_memory(context, count * sizeof *m.sources);
    status = merge(&m, paths);
    close_sources(&m);
    if (status == FATHOM_OK && stats) sized_write(stats, &m.film->stats, sizeof m.film->stats);
    if (status == FATHOM_OK)
        *out = m.film;
    else
        fathom_film_destroy(m.film);
    return status;
}
