/* Saves a render on the way. checkpoint_state.h describes the file, fathom/render.h the public calls.
 *
 * Rendering never waits for a save. Finished pixels do not change; a thread of its own writes them, and a
 * lock guards the list of what is finished. */
#ifndef JOB_CHECKPOINT_H
#define JOB_CHECKPOINT_H

#include "job/adaptive.h"

#include <fathom/session.h>

typedef struct checkpoint checkpoint;

/* Checks the path alone, as checkpoint_open() does. */
fathom_status checkpoint_check_path(fathom_context *context, const fathom_checkpoint *options, bool *exists);

/* Fills the film with what the file holds when it is to be continued. FATHOM_BAD_USAGE: there is a file, and
 * it is not, or another render saves to it; FATHOM_BAD_INPUT: the file is of no use; FATHOM_OUT_OF_RESOURCES:
 * it could not be written. On FATHOM_OK release with checkpoint_close(). */
fathom_status checkpoint_open(fathom_context *context, const fathom_checkpoint *options,
                              const fathom_scene *scene, const fathom_settings *settings, fathom_film *film,
                              checkpoint **out);
/* NULL is fine. The film's statistics get what was saved. */
void checkpoint_close(checkpoint *c);

/* Once the tracer is known, before anything is rendered. FATHOM_BAD_INPUT: the file was of another. */
fathom_status checkpoint_begin(checkpoint *c, const char *tracer);

/* The work of the renders that this one continues: seconds of rendering, rays, pixels that are finished,
 * samples in them and their largest error. */
typedef struct checkpoint_past {
    double seconds, error;
    uint64_t rays, pixels, samples;
} checkpoint_past;
checkpoint_past checkpoint_before(const checkpoint *c);

/* ---- on the calling thread ---- */

/* About ten times a second. fraction: of the whole render; rays: all so far. */
void checkpoint_tick(checkpoint *c, double fraction, uint64_t rays);
/* After the last thread has ended. Saves when there is more to do. */
void checkpoint_end(checkpoint *c, bool interrupted, double fraction, uint64_t rays);

/* ---- on the threads that render; each square on one ---- */

uint32_t checkpoint_wave(const checkpoint *c, uint32_t x, uint32_t y);
/* Squares of a wave that are finished: see checkpoint_state.h. */
uint64_t checkpoint_finished(const checkpoint *c, uint32_t place);
/* Notes the squares that are in the film: after the film's own sink. */
unit_sink checkpoint_sink(checkpoint *c);
/* These squares, which were not finished, are in the film; samples: of their pixels. */
void checkpoint_take(checkpoint *c, uint32_t place, uint64_t squares, uint64_t samples, double error);
/* Calls before this one have begun the wave, and not finished it. */
bool checkpoint_is_begun(const checkpoint *c, uint32_t place);
/* Loads what earlier calls sampled of a wave; false when they had not begun it. a: after adaptive_begin(). */
bool checkpoint_resume(checkpoint *c, uint32_t place, adaptive_wave *a);
/* Seconds between two such saves that cost little. */
double checkpoint_keep_seconds(const checkpoint *c);
/* Keeps what a wave has sampled, between two passes. Without memory for it the last record stays. */
void checkpoint_keep(checkpoint *c, uint32_t place, const adaptive_wave *a);

/* Bytes that it takes for each wave that is begun, and not finished. */
size_t checkpoint_wave_bytes(const checkpoint *c);

#endif
