/* The contents of a checkpoint, in memory and as bytes.
 *
 * A render consists of waves (film/squares.h). If all pixels get the same samples, a wave finishes square
 * after square of 4 × 4 pixels. A finished square is in the film and never changes again, so the film under
 * the bits of `squares` is all that must be saved. A wave that is sampled to an error or a time has a record
 * between two passes (adaptive_record.c). Once it is finished it is in the film as well.
 *
 * The file, little endian, floats as IEEE 754 has them:
 *
 *     8 bytes     "FTHMCKPT"
 *     u32         CHECKPOINT_FORMAT
 *     32 bytes    the program's version, a text with zeros after it
 *     128 bytes   the tracer, likewise
 *     u64         the scene's fingerprint
 *     1024 bytes  the settings that pixels depend on, a text likewise
 *     records     u32 wave, u32 0, then its bytes: of waves that are begun, in rising order
 *     u32 ~0, u32 0
 *     u64, u64    samples in the film; rays traced
 *     f64, f64    the largest error of a finished wave; seconds spent on rendering
 *     u64 each    squares, of every wave
 *     squares     for each wave, finished square and channel: 16 values, those beyond the film's rim 0
 *     u64         hash (base/hash.h) of all bytes before it */
#ifndef JOB_CHECKPOINT_STATE_H
#define JOB_CHECKPOINT_STATE_H

#include "job/adaptive.h"
#include "scene/settings.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "checkpoints are written as memory has them");

#define CHECKPOINT_FORMAT 6u
#define CHECKPOINT_MAGIC "FTHMCKPT"

typedef struct checkpoint_key {
    char version[32], tracer[128]; /* zeros after the text */
    uint64_t scene;                /* its fingerprint */
    char settings[SETTINGS_TEXT];  /* settings_print() */
} checkpoint_key;

typedef struct checkpoint_state {
    wave_grid grid;          /* that the film is made of */
    uint64_t *squares;       /* of each wave: those that are finished, bit y / 4 * 8 + x / 4 */
    unsigned char **records; /* of each wave; NULL: it is not begun, or finished */
    film_parts parts;        /* in the records */
    uint32_t spp;            /* the most of a pixel in a record */
    uint64_t samples, rays;
    double error, seconds;
} checkpoint_state;

/* scene: its fingerprint. The tracer is not in it yet. */
void checkpoint_key_of(const fathom_settings *settings, uint64_t scene, checkpoint_key *out);
void checkpoint_key_set_tracer(checkpoint_key *key, const char *tracer);
/* All its texts have an end, as the next needs it. */
bool checkpoint_key_is_whole(const checkpoint_key *key);
/* The first thing that differs, and both values. Tracers are compared where both are known. */
typedef struct key_difference {
    char name[64], saved[192], now[192];
} key_difference;
bool checkpoint_key_differs(const checkpoint_key *saved, const checkpoint_key *now, key_difference *out);
/* FATHOM_BAD_INPUT names it. path: of the file that `saved` is from. */
fathom_status checkpoint_key_compare(fathom_context *context, const char *path, const checkpoint_key *saved,
                                     const checkpoint_key *now);

/* Nothing is finished yet. False when out of memory. */
bool checkpoint_state_create(const fathom_settings *settings, const fathom_film *film, film_parts parts,
                             checkpoint_state *out);
void checkpoint_state_destroy(checkpoint_state *state);

/* Pixels of these squares of a wave that the film shows. */
uint64_t checkpoint_pixels(const wave_grid *grid, uint32_t wave, uint64_t squares);

/* The pixels of these squares, between the film and bytes: of each square and channel 16 values, those
 * beyond the film's rim 0. */
size_t checkpoint_pixel_bytes(uint32_t channels, uint64_t squares);
void checkpoint_pixels_save(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                            unsigned char *out);
void checkpoint_pixels_load(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                            const unsigned char *in);

/* Reads a file's bytes into a film and a state that are made for this render. `name` is the file's, for
 * messages; `tracer` gets what the file says of it. FATHOM_BAD_INPUT: no checkpoint, a damaged one, or one of
 * another render; then film and state may be half filled. Any bytes are safe. */
fathom_status checkpoint_read(fathom_context *context, const char *name, const unsigned char *bytes,
                              size_t size, const checkpoint_key *key, const fathom_film *film,
                              checkpoint_state *state, char tracer[128]);

#endif
