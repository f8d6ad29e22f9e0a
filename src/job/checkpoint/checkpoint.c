#include "job/checkpoint/checkpoint.h"

#include "base/clock.h"
#include "base/file.h"
#include "base/pool.h"
#include "base/sized.h"
#include "job/adaptive_record.h"
#include "job/checkpoint/checkpoint_write.h"

#include <pthread.h>
#include <stdlib.h>
#include <sys/stat.h>

SIZED_DEFAULT_OWN(fathom_checkpoint, {.every = 60})

struct checkpoint {
    fathom_context *context, *saving; /* saving: for the thread that saves */
    fathom_checkpoint options;
    file_lock *file; /* held so that no other render overwrites the file */
    fathom_settings settings;
    const fathom_scene *scene;
    fathom_film *film;
    checkpoint_key key;
    pthread_mutex_t lock; /* guards the state */
    checkpoint_state state;
    checkpoint_past before;
    double began, next; /* clock_seconds() at the start of rendering, and of the next save */

    /* The save in progress. */
    pool_task task;
    bool is_saving;
    atomic_bool give_up;
    checkpoint_write write;
    fathom_status status;
    double fraction, seconds;
};

/* ---- beginning ---- */

fathom_status checkpoint_check_path(fathom_context *context, const fathom_checkpoint *options, bool *exists) {
    struct stat info;
    if (!(options->every >= 0))
        return fail(context, FATHOM_BAD_USAGE, "checkpoint: every: expected seconds >= 0, found %g",
                    options->every);
    *exists = lstat(options->path, &info) == 0;
    if (*exists && !options->resume) {
        return fail_file(context, FATHOM_BAD_USAGE, options->path,
                         "the file exists, and may hold hours of work; continue it (--resume), or remove it");
    }
    return fathom_file_check(context, options->path);
}

static fathom_status read_file(checkpoint *c) {
    file_map map;
    fathom_status status = file_open(c->context, c->options.path, &map);
    if (status != FATHOM_OK) return status;
    status = checkpoint_read(c->context, c->options.path, map.bytes, map.size, &c->key, c->film, &c->state,
                             c->key.tracer);
    return file_finish(c->context, &map, status);
}

static void count_before(checkpoint *c) {
    const checkpoint_state *s = &c->state;
    c->before = (checkpoint_past){s->seconds, s->error, s->rays, 0, s->samples};
    for (uint32_t i = 0; i < s->grid.count; ++i)
        c->before.pixels += checkpoint_pixels(&s->grid, i, s->squares[i]);
    c->film->stats.resumed_seconds = s->seconds;
    c->film->stats.resumed_samples = s->samples;
}

static fathom_status prepare(checkpoint *c) {
    bool exists = false;
    fathom_status status = checkpoint_check_path(c->context, &c->options, &exists);
    if (status == FATHOM_OK) status = file_lock_take(c->context, c->options.path, &c->file);
    if (status != FATHOM_OK) return status;
    checkpoint_key_of(&c->settings, c->film->stats.scene_fingerprint, &c->key);
    if (!checkpoint_state_create(&c->settings, c->film, c->film->parts, &c->state) ||
        !checkpoint_write_create(&c->state, c->film, &c->write) ||
        fathom_context_create(&c->saving) != FATHOM_OK)
        return fail_memory(c->context, c->state.grid.count * sizeof(uint64_t));
    if (exists) status = read_file(c);
    count_before(c);
    if (!exists && c->options.resume) {
        warn(c->context, "%s: there is no checkpoint yet; rendering from the beginning", c->options.path);
    }
    return status;
}

fathom_status checkpoint_open(fathom_context *context, const fathom_checkpoint *options,
                              const fathom_scene *scene, const fathom_settings *settings, fathom_film *film,
                              checkpoint **out) {
    *out = NULL;
    checkpoint *c = calloc(1, sizeof *c);
    if (!c) return fail_memory(context, sizeof *c);
    c->context = context;
    c->options = *options;
    c->settings = *settings;
    c->scene = scene;
    c->film = film;
    pthread_mutex_init(&c->lock, NULL);
    fathom_status status = prepare(c);
    if (status == FATHOM_OK)
        *out = c;
    else
        checkpoint_close(c);
    return status;
}

void checkpoint_close(checkpoint *c) {
    if (!c) return;
    file_lock_release(c->file);
    checkpoint_state_destroy(&c->state);
    checkpoint_write_destroy(&c->write);
    pthread_mutex_destroy(&c->lock);
    fathom_context_destroy(c->saving);
    free(c);
}

fathom_status checkpoint_begin(checkpoint *c, const char *tracer) {
    const checkpoint_key saved = c->key;
    checkpoint_key_set_tracer(&c->key, tracer);
    c->began = clock_seconds();
    c->next = c->began + c->options.every;
    return checkpoint_key_compare(c->context, c->options.path, &saved, &c->key);
}

checkpoint_past checkpoint_before(const checkpoint *c) { return c->before; }

/* ---- saving ---- */

static void save(void *user) {
    checkpoint *c = user;
    const double began = clock_seconds();
    c->status = checkpoint_write_file(c->saving, &c->write, c->options.path, &c->key, c->scene, c->film,
                                      &c->state, &c->lock, &c->give_up);
    c->seconds = clock_seconds() - began;
}

static void prepare_save(checkpoint *c, double fraction, uint64_t rays) {
    c->fraction = fraction;
    c->write.rays = c->before.rays + rays;
    c->write.seconds = c->before.seconds + clock_seconds() - c->began;
    atomic_store(&c->give_up, false);
}

static void finish_save(checkpoint *c) {
    c->is_saving = false;
    c->next = clock_seconds() + c->options.every;
    c->film->stats.checkpoint_seconds += c->seconds;
    /* These are not reported: the save was cancelled, or the scene's files changed, which ends the render. */
    if (c->status == FATHOM_INTERRUPTED || c->status == FATHOM_BAD_INPUT) return;
    if (c->status == FATHOM_OK) ++c->film->stats.checkpoints;
    if (c->options.saved) {
        const char *message = c->status == FATHOM_OK ? "" : fathom_context_message(c->saving);
        c->options.saved(c->options.user, c->status, message, c->fraction);
    }
}

void checkpoint_tick(checkpoint *c, double fraction, uint64_t rays) {
    if (c->is_saving) {
        if (!pool_wait(&c->task, 0)) return;
        finish_save(c);
    }
    bool wanted = c->options.wanted && c->options.wanted(c->options.user);
    if (!wanted && clock_seconds() < c->next) return;
    prepare_save(c, fraction, rays);
    c->task = (pool_task){.run = save, .user = c};
    c->is_saving = pool_run(&c->task);
    if (c->is_saving) return;
    save(c);
    finish_save(c);
}

/* Cancels a save in progress: a newer save or the finished image replaces it. */
void checkpoint_end(checkpoint *c, bool interrupted, double fraction, uint64_t rays) {
    if (c->is_saving) {
        atomic_store(&c->give_up, true);
        pool_wait(&c->task, -1);
        finish_save(c);
    }
    if (!interrupted) return;
    prepare_save(c, fraction, rays);
    save(c);
    finish_save(c);
}

/* ---- waves ---- */

uint32_t checkpoint_wave(const checkpoint *c, uint32_t x, uint32_t y) {
    return wave_grid_at(&c->state.grid, x, y);
}

uint64_t checkpoint_finished(const checkpoint *c, uint32_t place) { return c->state.squares[place]; }

void checkpoint_take(checkpoint *c, uint32_t place, uint64_t squares, uint64_t samples, double error) {
    pthread_mutex_lock(&c->lock);
    unsigned char *record = c->state.records[place];
    c->state.records[place] = NULL;
    c->state.squares[place] |= squares;
    c->state.samples += samples;
    c->state.error = fmax(c->state.error, error);
    pthread_mutex_unlock(&c->lock);
    free(record);
}

static void finish(void *user, const unit_result *result) {
    checkpoint *c = user;
    checkpoint_take(c, checkpoint_wave(c, result->region.left, result->region.top),
                    result->squares & wave_region_bits(result->region), unit_samples(result), result->error);
}

unit_sink checkpoint_sink(checkpoint *c) { return (unit_sink){finish, c}; }

bool checkpoint_is_begun(const checkpoint *c, uint32_t place) { return c->state.records[place]; }

/* Needs no lock: only rendering threads store records, each for its own waves. */
void checkpoint_resume(checkpoint *c, uint32_t place, adaptive_wave *a) {
    const unsigned char *record = c->state.records[place];
    if (record) adaptive_record_load(&c->settings, record, a);
}

void checkpoint_keep(checkpoint *c, uint32_t place, const adaptive_wave *a) {
    unsigned char **record = &c->state.records[place];
    pthread_mutex_lock(&c->lock);
    if (!*record) *record = malloc(checkpoint_wave_bytes(c));
    if (*record) adaptive_record_save(a, *record);
    pthread_mutex_unlock(&c->lock);
}

double checkpoint_keep_seconds(const checkpoint *c) { return fmin(0.5, c->options.every); }

size_t checkpoint_wave_bytes(const checkpoint *c) { return adaptive_record_bytes(c->state.parts); }
