/* One image on many machines: each renders a part to a file, and the parts are merged to the very bits that
 * one machine would have rendered. */
#ifndef FATHOM_PART_H
#define FATHOM_PART_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum fathom_split {
    /* Samples if every part then gets some, and all pixels get the same number; tiles otherwise. */
    FATHOM_SPLIT_AUTO,
    /* Each part has some of the samples of all pixels, in runs of four. Parts take about the same time. The
     * file holds sums: 24 bytes a pixel, or 112 for paths; with AOVs 108 more; up to some times that where
     * the number of parts is no power of two. FATHOM_BAD_USAGE with a target_error or max_time, and with more
     * parts than runs of samples. */
    FATHOM_SPLIT_SAMPLES,
    /* Each part has some of the tiles of 32 × 32 pixels, with all their samples, from all over the image. The
     * file holds pixels: 4 bytes a channel. FATHOM_BAD_USAGE with max_time, since the clock sees all tiles.
     */
    FATHOM_SPLIT_TILES
} fathom_split;

/* The part of a render that a session is to do. Its film is of no use; the part is in the file at `path`,
 * where tiles are added as they are finished. If there is a file of the same part, what is missing is added
 * to it: a part that was killed is done by the same call again. */
typedef struct fathom_part {
    size_t size;
    const char *path;
    uint32_t index, count; /* from 1 to count; count up to 65536 */
    fathom_split split;
} fathom_part;

FATHOM_DEFAULT(fathom_part)

/* Merges all parts of a render, in any order, into its film. Takes memory for the film and the list of tiles:
 * the files are mapped. stats may be NULL; it gets the sums of the parts' rays and seconds.
 * FATHOM_BAD_INPUT: a file is no part, damaged, not finished, or of another render than the first one
 * (another scene, version, tracer with its instruction set, or other settings); or a part is missing, or
 * there twice. The message names it. On FATHOM_OK release *out with fathom_film_destroy(). */
FATHOM_API fathom_status fathom_parts_merge(fathom_context *context, const char *const *paths, size_t count,
                                            fathom_stats *stats, fathom_film **out);

#ifdef __cplusplus
}
#endif
#endif
