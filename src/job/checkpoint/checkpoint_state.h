/* The contents of a checkpoint, in memory and as bytes.
 *
 * A render consists of waves (film/squares.h). If all pixels get the same number of samples, a wave finishes
 * its squares of 4 × 4 pixels one after another. A finished square is in the film and never changes again, so
 * only the film's pixels in the squares marked in `squares` must be saved. A wave that is sampled to an error
 * or a time has a record between two passes (adaptive_record.c). Once the wave is finished it is in the film
 * as well.
 *
 * The file is little endian, with IEEE 754 floats:
 *
 *     8 bytes     "FTHMCKPT"
 *     u32         CHECKPOINT_FORMAT
 *     32 bytes    version of the program, a text padded with zeros
 *     128 bytes   the tracer, a text padded with zeros
 *     u64         fingerprint of the scene
 *     1024 bytes  the settings that pixels depend on, a text padded with zeros
 *     records     for each wave that is begun, in ascending order: u32 wave, u32 0, the bytes of its record
 *     u32 ~0, u32 0
 *     u64, u64    samples in the film; rays traced
 *     f64, f64    largest error of a finished wave; seconds spent on rendering
 *     u64 each    finished squares, for every wave
 *     squares     for each wave, finished square and channel: 16 values, 0 outside the film
 *     u64         hash (base/hash.h) of all bytes before it */
#pragma once

#include "job/adaptive.h"
#include "scene/settings.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "checkpoints are written as memory has them");

#define CHECKPOINT_FORMAT 7u
#define CHECKPOINT_MAGIC "FTHMCKPT"

typedef struct checkpoint_key {
    char version[32], tracer[128]; /* zeros after the text */
    uint64_t scene;                /* its fingerprint */
    char settings[SETTINGS_TEXT];  /* settings_print() */
} checkpoint_key;
_Static_assert(sizeof(checkpoint_key) == 32 + 128 + 8 + SETTINGS_TEXT, "no bytes between the fields");

typedef struct checkpoint_state {
    wave_grid grid;          /* the grid of the film */
    uint64_t *squares;       /* for each wave: its finished squares, bit y / 4 * 8 + x / 4 */
    unsigned char **records; /* for each wave; NULL: the wave is not begun, or is finished */
    film_parts parts;        /* parts that the records hold */
    uint32_t spp;            /* maximum of a pixel in a record */
    uint64_t samples, rays;
    double error, seconds;
} checkpoint_state;

/* scene: its fingerprint. Leaves the tracer empty. */
void checkpoint_key_of(const fathom_settings *settings, uint64_t scene, checkpoint_key *out);
void checkpoint_key_set_tracer(checkpoint_key *key, const char *tracer);
/* True if all its texts are terminated; the functions below require this. */
bool checkpoint_key_is_whole(const checkpoint_key *key);
/* The first difference, with both values. Tracers are compared only if both are known. */
typedef struct key_difference {
    char name[64], saved[192], now[192];
} key_difference;
bool checkpoint_key_differs(const checkpoint_key *saved, const checkpoint_key *now, key_difference *out);
/* FATHOM_BAD_INPUT: the keys differ; the message names the first difference. path: the file of `saved`. */
fathom_status checkpoint_key_compare(fathom_context *context, const char *path, const checkpoint_key *saved,
                                     const checkpoint_key *now);

/* Creates a state in which nothing is finished. False: out of memory. */
bool checkpoint_state_create(const fathom_settings *settings, const fathom_film *film, film_parts parts,
                             checkpoint_state *out);
void checkpoint_state_destroy(checkpoint_state *state);

/* Number of pixels of these squares of a wave, clipped to the film. */
uint64_t checkpoint_pixels(const wave_grid *grid, uint32_t wave, uint64_t squares);

/* Copies the pixels of these squares between the film and bytes: for each square and channel 16 values, 0
 * outside the film. */
size_t checkpoint_pixel_bytes(uint32_t channels, uint64_t squares);
void checkpoint_pixels_save(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                            unsigned char *out);
void checkpoint_pixels_load(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                            const unsigned char *in);

/* Reads a file's bytes into a film and a state that were created for this render. `name` is the file's name
 * for messages; `tracer` receives the tracer's name in the file. FATHOM_BAD_INPUT: no checkpoint, damaged, or
 * of another render; film and state may then be partly filled. Safe for any bytes. */
fathom_status checkpoint_read(fathom_context *context, const char *name, const unsigned char *bytes,
                              size_t size, const checkpoint_key *key, const fathom_film *film,
                              checkpoint_state *state, char tracer[128]);
