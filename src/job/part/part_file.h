/* The file of a part (fathom/part.h): a head, then the finished tiles ("waves", film/squares.h) in any order.
 * The file grows only at its end, so earlier tiles stay whole, however the process ends.
 *
 * Little endian, with structs as in this machine's memory: only the same version reads them. Each piece ends
 * with the hash (base/hash.h) of its bytes.
 *
 *     part_head, the manifests of mattes, u64 hash
 *     part_record, its bytes, u64 hash     for each tile
 *
 * The bytes of a tile are its squares of 4 × 4 pixels inside the film, one after another. Split by tiles: for
 * each channel 16 values, 0 outside the film. Split by samples: the sums of each node of the part
 * (sum_list_nodes(), sum_save()). */
#pragma once

#include "job/checkpoint/checkpoint_state.h"
#include "job/job.h"

#define PART_MAGIC "FTHMPART"
#define PART_FORMAT 6u
#define PART_MOST 65536u /* maximum number of parts of a render */
#define PART_EXPOSURE 128.0
#define PART_RECORD 0x45564157u /* "WAVE" */

typedef struct part_head {
    char magic[8];
    uint32_t format, bytes;                  /* bytes: size of this struct */
    uint32_t index, count, split, in_studio; /* in_studio: true or false */
    uint32_t exposed;                        /* true or false: `exposure` was given */
    float exposure;
    uint32_t octave; /* see film_parts */
    checkpoint_key key;
    /* Needed by the merged film. */
    fathom_settings settings; /* `tracer` is NULL */
    fathom_camera camera;
    fathom_stats stats; /* of the scene; counts of the rendering are in the records */
    float background[3], brightest[3];
    light_group_names light_groups;
    uint32_t manifests[MATTE_KINDS]; /* sizes in bytes of these texts, which follow the head, with their
                                        terminators */
    char scene[1024];                /* its name, truncated */
} part_head;

typedef struct part_record {
    uint32_t magic, wave;
    uint64_t samples, bytes;
    double error, seconds; /* seconds: processor time of one thread */
    ray_counts rays;
} part_record;

/* Which tiles belong to a part, and their size in its file. */
typedef struct part_shape {
    uint32_t index, count; /* index: from 0 */
    bool sums;
    sum_range range;
    wave_grid grid;
    uint32_t stride;     /* see part_owns() */
    size_t square_bytes; /* size in the file */
} part_shape;

part_shape part_shape_of(const part_head *head);
/* Each part gets the same number of tiles (± 1), from all over the image: neighbours along a row go to parts
 * that are a golden section apart. Split by samples, every tile belongs to every part. */
bool part_owns(const part_shape *shape, uint32_t wave);
size_t part_wave_bytes(const part_shape *shape, uint32_t wave);

/* Size of the head and its manifests. Their hash follows, then the records. */
size_t part_head_bytes(const part_head *head);
uint64_t part_head_hash(const part_head *head, const char *const manifests[MATTE_KINDS]);
/* "none", if it was not given. */
void part_exposure_print(const part_head *head, char out[64]);
/* A manifest in the bytes of a file whose head was read; NULL: there is none. */
const char *part_manifest(const part_head *head, const unsigned char *bytes, matte_kind kind);

/* FATHOM_BAD_INPUT: the bytes do not begin with a whole head of a part that this version can read. */
fathom_status part_head_read(fathom_context *context, const char *path, const unsigned char *bytes,
                             size_t size, part_head *out);

/* Reads the next whole record at *at, and moves *at behind it. False: the end, or no record of this part.
 * `done` marks the tiles of earlier records; this tile is added. *payload: the bytes of the tile. */
bool part_record_next(const part_shape *shape, const unsigned char *bytes, size_t size, size_t *at,
                      bool *done, part_record *out, const unsigned char **payload);
