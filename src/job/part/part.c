#include "job/part/part.h"

#include "base/file.h"
#include "base/hash.h"
#include "base/sized.h"
#include "job/part/part_file.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

SIZED_DEFAULT_OWN(fathom_part, {.split = FATHOM_SPLIT_AUTO})

/* Bytes that may wait for the next tick; more are written at once. */
#define WAITING ((size_t)1 << 20)

struct part {
    fathom_context *context;
    const char *path;
    file_lock *lock;
    int file;   /* < 0: not open */
    off_t size; /* bytes of whole records in the file; 0: no head yet */
    part_head head;
    part_shape shape;
    fathom_film *film;
    bool *done; /* for each tile */
    wave_share share;
    pthread_mutex_t mutex; /* guards the following */
    ARRAY(unsigned char) waiting;
    int error; /* errno of the failed write */
};

/* ---- what can be split, and how ---- */

/* FATHOM_BAD_USAGE: the numbers are invalid; FATHOM_OUT_OF_RESOURCES: the file could not be written. */
static fathom_status part_check(fathom_context *context, const fathom_part *options) {
    if (!options->path) return fail_null(context, "part: path");
    if (!options->index || options->index > options->count || options->count > PART_MOST) {
        return fail(context, FATHOM_BAD_USAGE, "part: expected 1 <= part <= parts <= %u, found part %u of %u",
                    PART_MOST, options->index, options->count);
    }
    if (options->split > FATHOM_SPLIT_TILES)
        return fail(context, FATHOM_BAD_USAGE, "part: there is no split %u", (unsigned)options->split);
    if (options->exposure && !(fabs((double)*options->exposure) < PART_EXPOSURE))
        return fail(context, FATHOM_BAD_USAGE, "part: expected an exposure below %g stops, found %g",
                    PART_EXPOSURE, (double)*options->exposure);
    return fathom_file_check(context, options->path);
}

static fathom_status choose_split(fathom_context *context, const fathom_part *options,
                                  const fathom_settings *s, uint32_t *out) {
    const uint32_t leaves = sum_leaves(s->spp);
    const bool even = !(s->target_error > 0);
    *out = options->split;
    if (s->max_time > 0) {
        return fail(
            context, FATHOM_BAD_USAGE,
            "a render to a time cannot be split: the clock decides which samples are taken; expected a "
            "target error, or a number of samples");
    }
    if (options->split == FATHOM_SPLIT_AUTO)
        *out = even && options->count <= leaves ? FATHOM_SPLIT_SAMPLES : FATHOM_SPLIT_TILES;
    if (*out == FATHOM_SPLIT_TILES) return FATHOM_OK;
    if (!even) {
        return fail(
            context, FATHOM_BAD_USAGE,
            "a render to an error cannot be split by samples: all of a tile's samples decide how many it "
            "gets; split it by tiles");
    }
    if (options->count <= leaves) return FATHOM_OK;
    return fail(
        context, FATHOM_BAD_USAGE,
        "%u samples a pixel cannot be split into %u parts: samples are handed out in runs of %u; expected "
        "at most %u parts, or a split by tiles",
        s->spp, options->count, SUM_LEAF, leaves);
}

/* ---- an existing file ---- */

static fathom_status of_another(const part *p, const char *name, const char *theirs, const char *ours) {
    return fail_file(p->context, FATHOM_BAD_INPUT, p->path,
                     "the existing part was rendered with %s %s, and this render has %s; expected the same "
                     "render, or another file",
                     name, theirs, ours);
}

static void print_part(const part_head *h, char out[64]) {
    snprintf(out, 64, "%u of %u, by %s", h->index, h->count,
             h->split == FATHOM_SPLIT_SAMPLES ? "samples" : "tiles");
}

static fathom_status compare(const part *p, const part_head *theirs) {
    key_difference d;
    char a[64], b[64];
    print_part(theirs, a), print_part(&p->head, b);
    if (strcmp(a, b) != 0) return of_another(p, "the number", a, b);
    if (checkpoint_key_differs(&theirs->key, &p->head.key, &d)) return of_another(p, d.name, d.saved, d.now);
    part_exposure_print(theirs, a), part_exposure_print(&p->head, b);
    return p->head.exposed && strcmp(a, b) != 0 ? of_another(p, "the exposure", a, b) : FATHOM_OK;
}

static void count_before(part *p, const part_record *r) {
    checkpoint_past *b = &p->share.before;
    b->pixels += checkpoint_pixels(&p->shape.grid, r->wave, ~0ull);
    b->samples += r->samples;
    b->error = fmax(b->error, r->error);
    b->seconds += r->seconds / fathom_context_threads(p->context);
    b->rays += ray_counts_total(&r->rays);
}

/* Bytes after the last whole record are discarded: the process ended while it wrote them. */
static fathom_status read_map(part *p, const file_map *map) {
    part_head theirs;
    fathom_status status = part_head_read(p->context, p->path, map->bytes, map->size, &theirs);
    if (status == FATHOM_OK) status = compare(p, &theirs);
    if (status != FATHOM_OK) return status;
    checkpoint_key_set_tracer(&p->head.key, theirs.key.tracer);
    const unsigned char *payload;
    size_t at = part_head_bytes(&theirs) + sizeof(uint64_t);
    for (part_record r; part_record_next(&p->shape, map->bytes, map->size, &at, p->done, &r, &payload);)
        count_before(p, &r);
    p->size = (off_t)at;
    p->film->stats.resumed_seconds = p->share.before.seconds;
    p->film->stats.resumed_samples = p->share.before.samples;
    return FATHOM_OK;
}

/* False if the writer was killed before the head was complete: the file then holds no data. */
static bool is_begun(const part *p) {
    char bytes[sizeof(part_head) + sizeof(uint64_t)] = "";
    const ssize_t size = read(p->file, bytes, sizeof bytes);
    const size_t magic = size < (ssize_t)strlen(PART_MAGIC) ? (size_t)size : strlen(PART_MAGIC);
    if (size < 0 || memcmp(bytes, PART_MAGIC, magic) != 0) return true;
    if (size < (ssize_t)sizeof bytes) return false;
    part_head head;
    struct stat now;
    memcpy(&head, bytes, sizeof head);
    return head.format != PART_FORMAT || fstat(p->file, &now) != 0 ||
           now.st_size >= (off_t)(part_head_bytes(&head) + sizeof(uint64_t));
}

static fathom_status cannot_write(const part *p, int error) {
    return fail_file(
        p->context, FATHOM_OUT_OF_RESOURCES, p->path,
        "cannot be written: %s; what was finished before is kept; run the same command again to continue",
        strerror(error));
}

static fathom_status open_file(part *p) {
    p->file = open(p->path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (p->file < 0) return cannot_write(p, errno);
    if (!is_begun(p)) return FATHOM_OK;
    file_map map;
    fathom_status status = file_open(p->context, p->path, &map);
    if (status != FATHOM_OK) return status;
    return file_finish(p->context, &map, read_map(p, &map));
}

/* ---- beginning ---- */

static void fill_head(part *p, const fathom_part *options, const fathom_settings *settings) {
    part_head *h = &p->head;
    memcpy(h->magic, PART_MAGIC, sizeof h->magic);
    h->format = PART_FORMAT, h->bytes = sizeof *h;
    h->index = options->index, h->count = options->count;
    checkpoint_key_of(settings, p->film->stats.scene_fingerprint, &h->key);
    h->settings = *settings;
    h->settings.tracer = NULL;
    h->camera = p->film->camera;
    h->light_groups = p->film->light_groups;
    for (int k = 0; k < MATTE_KINDS; ++k) {
        const char *text = p->film->manifests[k];
        h->manifests[k] = text ? (uint32_t)strlen(text) + 1 : 0;
    }
    memcpy(h->background, p->film->background, sizeof h->background);
    h->in_studio = p->film->in_studio, h->octave = p->film->parts.octave;
    h->exposed = options->exposure != NULL;
    if (h->exposed) h->exposure = *options->exposure;
    snprintf(h->scene, sizeof h->scene, "%s", p->film->scene_name);
}

static fathom_status prepare(part *p, const fathom_part *options, const fathom_settings *settings) {
    fathom_status status = part_check(p->context, options);
    if (status == FATHOM_OK) status = choose_split(p->context, options, settings, &p->head.split);
    if (status == FATHOM_OK) status = file_lock_take(p->context, p->path, &p->lock);
    if (status != FATHOM_OK) return status;
    fill_head(p, options, settings);
    p->shape = part_shape_of(&p->head);
    p->done = calloc(p->shape.grid.count, sizeof *p->done);
    return p->done ? open_file(p) : fail_memory(p->context, p->shape.grid.count);
}

fathom_status part_open(fathom_context *context, const fathom_part *options, const fathom_settings *settings,
                        fathom_film *film, part **out) {
    *out = NULL;
    part *p = calloc(1, sizeof *p);
    if (!p) return fail_memory(context, sizeof *p);
    p->context = context, p->path = options->path, p->film = film, p->file = -1;
    pthread_mutex_init(&p->mutex, NULL);
    fathom_status status = prepare(p, options, settings);
    if (status == FATHOM_OK)
        *out = p;
    else
        part_close(p, status);
    return status;
}

/* ---- writing ---- */

static bool write_all(part *p, const void *bytes, size_t size) {
    if (!p->error && !file_write_at(p->file, (uint64_t)p->size, bytes, size)) p->error = errno;
    if (!p->error) p->size += (off_t)size;
    return !p->error;
}

static void flush(part *p) {
    write_all(p, p->waiting.items, p->waiting.count);
    p->waiting.count = 0;
}

static bool add_record(part *p, const wave_result *w) {
    const size_t bytes = part_wave_bytes(&p->shape, w->unit.wave), whole = sizeof(part_record) + bytes;
    const part_record r = {PART_RECORD, w->unit.wave, w->samples, bytes, w->error, w->seconds, w->rays};
    if (!array_room(&p->waiting, whole + sizeof(uint64_t))) return false;
    unsigned char *to = p->waiting.items + p->waiting.count;
    p->waiting.count += whole + sizeof(uint64_t);
    memcpy(to, &r, sizeof r);
    if (w->sums)
        memcpy(to + sizeof r, w->sums, bytes);
    else
        checkpoint_pixels_save(&p->shape.grid, p->film, w->unit.wave, w->unit.squares, to + sizeof r);
    const uint64_t sum = hash_of(to, whole);
    memcpy(to + whole, &sum, sizeof sum);
    return true;
}

static bool take(void *user, const wave_result *w) {
    part *p = user;
    pthread_mutex_lock(&p->mutex);
    if (!p->error && !add_record(p, w)) p->error = ENOMEM;
    if (p->waiting.count > WAITING) flush(p);
    const bool fine = !p->error;
    pthread_mutex_unlock(&p->mutex);
    return fine;
}

static void tick(void *user) {
    part *p = user;
    pthread_mutex_lock(&p->mutex);
    flush(p);
    pthread_mutex_unlock(&p->mutex);
}

static bool wants(void *user, uint32_t wave) {
    const part *p = user;
    return part_owns(&p->shape, wave) && !p->done[wave];
}

static uint64_t count_pixels(const part_shape *s) {
    uint64_t pixels = 0;
    for (uint32_t i = 0; i < s->grid.count; ++i) {
        if (part_owns(s, i)) pixels += checkpoint_pixels(&s->grid, i, ~0ull);
    }
    return pixels;
}

fathom_status part_begin(part *p, const char *tracer, wave_share **share) {
    part_head theirs = p->head;
    checkpoint_key_set_tracer(&p->head.key, tracer);
    fathom_status status = compare(p, &theirs);
    if (status != FATHOM_OK) return status;
    p->share.user = p;
    p->share.sums = p->shape.sums, p->share.range = p->shape.range;
    p->share.pixels = count_pixels(&p->shape);
    p->share.wants = wants, p->share.take = take, p->share.tick = tick;
    *share = &p->share;
    if (ftruncate(p->file, p->size) != 0) return cannot_write(p, errno);
    if (p->size) return FATHOM_OK;
    p->head.stats = p->film->stats;
    memcpy(p->head.brightest, p->film->brightest, sizeof p->head.brightest);
    const char *const manifests[MATTE_KINDS] = {p->film->manifests[0], p->film->manifests[1]};
    const uint64_t sum = part_head_hash(&p->head, manifests);
    bool fine = write_all(p, &p->head, sizeof p->head);
    for (int k = 0; k < MATTE_KINDS && fine; ++k) fine = write_all(p, manifests[k], p->head.manifests[k]);
    return fine && write_all(p, &sum, sizeof sum) ? FATHOM_OK : cannot_write(p, p->error);
}

static fathom_status finish(part *p, fathom_status status) {
    if (!p->share.take) return status; /* not begun */
    flush(p);
    if (!p->error && fsync(p->file) != 0 && errno != EINVAL) p->error = errno;
    return p->error ? cannot_write(p, p->error) : status;
}

fathom_status part_close(part *p, fathom_status status) {
    if (!p) return status;
    status = finish(p, status);
    if (p->file >= 0) close(p->file);
    file_lock_release(p->lock);
    pthread_mutex_destroy(&p->mutex);
    array_free(&p->waiting);
    free(p->done);
    free(p);
    return status;
}
