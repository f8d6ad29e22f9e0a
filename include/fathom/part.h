/* One image on many machines: each renders a part to a file. The merged parts have the same bits as a render
 * on one machine. */
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
     * file holds sums: 24 bytes per pixel. AOVs of first hits add 108, each layer of light 24, each
     * Cryptomatte 128, and FATHOM_AOV_ERROR 72. The file is several times as large if the number of parts is
     * not a power of two. FATHOM_BAD_USAGE with a target_error or max_time, and with more parts than runs of
     * samples. */
    FATHOM_SPLIT_SAMPLES,
    /* Each part has some of the tiles of 32 × 32 pixels, with all their samples, from all over the image.
     * The file holds pixels: 4 bytes a channel. FATHOM_BAD_USAGE with max_time, because the time is
     * divided among all tiles. */
    FATHOM_SPLIT_TILES
} fathom_split;

/* The part that a session renders. The result is the file at `path`, not the session's film; finished tiles
 * are added to the file at once. If a file of the same part exists, the session adds the missing tiles. So
 * after a killed process, make the same call again. */
typedef struct fathom_part {
    size_t size;
    const char *path;
    uint32_t index, count; /* from 1 to count; count up to 65536 */
    fathom_split split;
    const float *exposure; /* stops, below 128: to write the merged film with, which tells it
                              (fathom_film_exposure()). A file with another one is refused. NULL (default):
                              none, or that of the file */
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
