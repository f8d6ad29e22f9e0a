/* A checkpoint to its file; checkpoint_state.h describes it. */
#ifndef JOB_CHECKPOINT_WRITE_H
#define JOB_CHECKPOINT_WRITE_H

#include "job/checkpoint/checkpoint_state.h"

#include <pthread.h>

typedef struct checkpoint_write {
    uint64_t rays;
    double seconds;      /* these two go to the file instead of the state's */
    uint64_t *squares;   /* room for what is finished when the film is written */
    unsigned char *wave; /* room for one wave's record, or pixels */
} checkpoint_write;

/* False when out of memory. */
bool checkpoint_write_create(const checkpoint_state *state, const fathom_film *film, checkpoint_write *out);
void checkpoint_write_destroy(checkpoint_write *w);

/* Whole or not at all, and on the disk when it returns; not at all when the scene's files have changed, since
 * pixels may have been made of that: FATHOM_BAD_INPUT then. scene: NULL when it has none. Others may finish
 * squares meanwhile, and change the state under the lock. FATHOM_INTERRUPTED: give_up was set;
 * FATHOM_OUT_OF_RESOURCES: cannot be written. */
fathom_status checkpoint_write_file(fathom_context *context, checkpoint_write *w, const char *path,
                                    const checkpoint_key *key, const fathom_scene *scene,
                                    const fathom_film *film, const checkpoint_state *state,
                                    pthread_mutex_t *lock, const atomic_bool *give_up);

#endif
