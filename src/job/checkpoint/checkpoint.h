/* Saves a render at intervals. checkpoint_state.h describes the file, fathom/session.h the public calls.
 *
 * Rendering never waits for a save. Finished pixels do not change. A separate thread writes them, and a lock
 * guards the list of finished squares. */
#pragma once

#include "job/adaptive.h"

#include <fathom/session.h>

typedef struct checkpoint checkpoint;

/* Checks only the path, as checkpoint_open() does. */
fathom_status checkpoint_check_path(fathom_context *context, const fathom_checkpoint *options, bool *exists);

/* If the render is to be continued, fills the film from the file. FATHOM_BAD_USAGE: the file exists but the
 * render is not to be continued, or another render saves to it; FATHOM_BAD_INPUT: the file is unusable;
 * FATHOM_OUT_OF_RESOURCES: it could not be written. On FATHOM_OK release with checkpoint_close(). */
fathom_status checkpoint_open(fathom_context *context, const fathom_checkpoint *options,
                              const fathom_scene *scene, const fathom_settings *settings, fathom_film *film,
                              checkpoint **out);
/* Adds what was saved to the film's statistics. NULL is fine. */
void checkpoint_close(checkpoint *c);

/* Call once the tracer is known, before anything is rendered. FATHOM_BAD_INPUT: the file is of another
 * tracer. */
fathom_status checkpoint_begin(checkpoint *c, const char *tracer);

/* The work of the renders that this one continues: seconds of rendering, rays, finished pixels, their samples
 * and their largest error. */
typedef struct checkpoint_past {
    double seconds, error;
    uint64_t rays, pixels, samples;
} checkpoint_past;
checkpoint_past checkpoint_before(const checkpoint *c);

/* ---- on the calling thread ---- */

/* About ten times a second. fraction: of the whole render; rays: all so far. */
void checkpoint_tick(checkpoint *c, double fraction, uint64_t rays);
/* Call after the last thread has ended. Saves if the render is not complete. */
void checkpoint_end(checkpoint *c, bool interrupted, double fraction, uint64_t rays);

/* ---- on the threads that render; each square on one ---- */

uint32_t checkpoint_wave(const checkpoint *c, uint32_t x, uint32_t y);
/* Finished squares of a wave: see checkpoint_state.h. */
uint64_t checkpoint_finished(const checkpoint *c, uint32_t place);
/* Records which squares are in the film; runs after the film's own sink. */
unit_sink checkpoint_sink(checkpoint *c);
/* Records that these squares, which were not finished, are now in the film. samples: of their pixels. */
void checkpoint_take(checkpoint *c, uint32_t place, uint64_t squares, uint64_t samples, double error);
/* True if earlier calls have begun the wave, and not finished it. */
bool checkpoint_is_begun(const checkpoint *c, uint32_t place);
/* Loads the samples of a wave, if earlier calls have begun it. a: after adaptive_begin(). */
void checkpoint_resume(checkpoint *c, uint32_t place, adaptive_wave *a);
/* Seconds between two calls of checkpoint_keep() at which they cost little. */
double checkpoint_keep_seconds(const checkpoint *c);
/* Records the samples of a wave between two passes. If memory runs out, the previous record stays. */
void checkpoint_keep(checkpoint *c, uint32_t place, const adaptive_wave *a);

/* Bytes for each wave that is begun and not finished. */
size_t checkpoint_wave_bytes(const checkpoint *c);
