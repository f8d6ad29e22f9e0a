/* Writes a checkpoint to its file; checkpoint_state.h describes the format. */
#pragma once

#include "job/checkpoint/checkpoint_state.h"

#include <pthread.h>

typedef struct checkpoint_write {
    uint64_t rays;
    double seconds;      /* rays and seconds are written in place of the state's */
    uint64_t *squares;   /* buffer: the finished squares at the time the film is written */
    unsigned char *wave; /* buffer for the record or the pixels of one wave */
} checkpoint_write;

/* False when out of memory. */
bool checkpoint_write_create(const checkpoint_state *state, const fathom_film *film, checkpoint_write *out);
void checkpoint_write_destroy(checkpoint_write *w);

/* Writes a whole file or none, and flushes it to the disk before it returns. Writes none if files of the
 * scene have changed, since pixels may depend on the new contents: FATHOM_BAD_INPUT. scene: NULL when it has
 * none. Other threads may finish squares during the call, and change the state under the lock.
 * FATHOM_INTERRUPTED: give_up was set; FATHOM_OUT_OF_RESOURCES: cannot be written. */
fathom_status checkpoint_write_file(fathom_context *context, checkpoint_write *w, const char *path,
                                    const checkpoint_key *key, const fathom_scene *scene,
                                    const fathom_film *film, const checkpoint_state *state,
                                    pthread_mutex_t *lock, const atomic_bool *give_up);
