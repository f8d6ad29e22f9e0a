#include "job/checkpoint/checkpoint_write.h"

#include "base/file.h"
#include "base/hash.h"
#include "job/adaptive_record.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

bool checkpoint_write_create(const checkpoint_state *state, const fathom_film *film, checkpoint_write *out) {
    const size_t pixels = film->channel_count * sizeof(uint32_t) * WAVE_SLOTS,
                 record = adaptive_record_bytes(state->parts);
    *out = (checkpoint_write){.squares = malloc(state->grid.count * sizeof *out->squares),
                              .wave = malloc(pixels > record ? pixels : record)};
    if (out->squares && out->wave) return true;
    checkpoint_write_destroy(out);
    return false;
}

void checkpoint_write_destroy(checkpoint_write *w) {
    free(w->squares);
    free(w->wave);
    *w = (checkpoint_write){.rays = 0};
}

typedef struct output {
    file_writer *file;
    hash hash;
    checkpoint_write *room;
    const fathom_film *film;
    const checkpoint_state *state;
    pthread_mutex_t *lock;
    const atomic_bool *give_up;
} output;

static void put(output *o, const void *bytes, size_t size) {
    hash_put(&o->hash, bytes, size);
    file_writer_put(o->file, bytes, size);
}

static void put_head(output *o, const checkpoint_key *key) {
    static const uint32_t format = CHECKPOINT_FORMAT;
    put(o, CHECKPOINT_MAGIC, strlen(CHECKPOINT_MAGIC));
    put(o, &format, sizeof format);
    put(o, key, sizeof *key);
}

/* Copies the record under the lock; the lock is not held while the file is written. */
static bool copy_record(output *o, uint32_t place, size_t bytes) {
    pthread_mutex_lock(o->lock);
    const unsigned char *record = o->state->records[place];
    if (record) memcpy(o->room->wave, record, bytes);
    pthread_mutex_unlock(o->lock);
    return record;
}

static void put_records(output *o) {
    const size_t bytes = adaptive_record_bytes(o->state->parts);
    static const uint32_t last[] = {UINT32_MAX, 0};
    for (uint32_t i = 0; i < o->state->grid.count && !atomic_load(o->give_up); ++i) {
        if (!copy_record(o, i, bytes)) continue;
        const uint32_t head[] = {i, 0};
        put(o, head, sizeof head);
        put(o, o->room->wave, bytes);
    }
    put(o, last, sizeof last);
}

/* Comes after the records: a wave that finished in the meantime is in the film, and any other has its
 * record. */
static void put_progress(output *o) {
    const size_t bytes = o->state->grid.count * sizeof *o->room->squares;
    pthread_mutex_lock(o->lock);
    const uint64_t samples = o->state->samples;
    const double error = o->state->error;
    memcpy(o->room->squares, o->state->squares, bytes);
    pthread_mutex_unlock(o->lock);
    put(o, &samples, sizeof samples);
    put(o, &o->room->rays, sizeof o->room->rays);
    put(o, &error, sizeof error);
    put(o, &o->room->seconds, sizeof o->room->seconds);
    put(o, o->room->squares, bytes);
}

static void put_film(output *o) {
    for (uint32_t i = 0; i < o->state->grid.count && !atomic_load(o->give_up); ++i) {
        const uint64_t squares = o->room->squares[i];
        checkpoint_pixels_save(&o->state->grid, o->film, i, squares, o->room->wave);
        put(o, o->room->wave, checkpoint_pixel_bytes(o->film->channel_count, squares));
    }
}

fathom_status checkpoint_write_file(fathom_context *context, checkpoint_write *w, const char *path,
                                    const checkpoint_key *key, const fathom_scene *scene,
                                    const fathom_film *film, const checkpoint_state *state,
                                    pthread_mutex_t *lock, const atomic_bool *give_up) {
    output o = {.room = w, .film = film, .state = state, .lock = lock, .give_up = give_up};
    fathom_status status = file_writer_open(context, path, &o.file);
    if (status != FATHOM_OK) return status;
    hash_begin(&o.hash);
    put_head(&o, key);
    put_records(&o);
    put_progress(&o);
    put_film(&o);
    const uint64_t sum = hash_end(&o.hash);
    put(&o, &sum, sizeof sum);
    const fathom_scene view = scene ? scene_through(scene, context) : (fathom_scene){.context = context};
    status = atomic_load(give_up) ? FATHOM_INTERRUPTED : fathom_scene_check_files(&view);
    if (status == FATHOM_OK) return file_writer_commit(o.file);
    file_writer_abort(o.file);
    return status;
}
