/* The file of a part (fathom/part.h): a head, and behind it the tiles ("waves", film/squares.h) that are
 * finished, in any order. It grows at its end; whatever ends the process leaves the tiles before whole.
 *
 * Little endian, structs as memory has them on this machine: only the same version reads them. Each piece
 * ends with the hash (base/hash.h) of its bytes.
 *
 *     part_head, the manifests of mattes, u64 hash
 *     part_record, its bytes, u64 hash     of each tile
 *
 * The bytes of a tile are, square after square of those that the film shows, of 4 × 4 pixels each:
 * with tiles, of each channel 16 values, those beyond the film's rim 0; with samples, the sums of each node
 * of the part (sum_list_nodes(), sum_save()). */
#ifndef JOB_PART_FILE_H
#define JOB_PART_FILE_H

#include "job/checkpoint/checkpoint_state.h"
#include "job/job.h"

#define PART_MAGIC "FTHMPART"
#define PART_FORMAT 4u
#define PART_MOST 65536u        /* of a render */
#define PART_RECORD 0x45564157u /* "WAVE" */

typedef struct part_head {
    char magic[8];
    uint32_t format, bytes;                  /* the second: of this struct */
    uint32_t index, count, split, in_studio; /* the last: true or false */
    checkpoint_key key;
    /* What the merged film needs. */
    fathom_settings settings; /* without the tracer's words */
    fathom_camera camera;
    fathom_stats stats; /* of the scene; what is counted while rendering is in the records */
    float background[3], brightest[3];
    light_group_names light_groups;
    uint32_t manifests[MATTE_KINDS]; /* bytes of these texts, their ends included, which follow the head */
    char scene[1024];                /* its name, cut */
} part_head;

typedef struct part_record {
    uint32_t magic, wave;
    uint64_t samples, bytes;
    double error, seconds; /* the second: of one thread's processor time */
    ray_counts rays;
} part_record;

/* Which tiles are of a part, and how large they are in its file. */
typedef struct part_shape {
    uint32_t index, count; /* from 0 */
    bool sums;
    sum_range range;
    wave_grid grid;
    uint32_t stride;     /* see part_owns() */
    size_t square_bytes; /* in the file */
} part_shape;

part_shape part_shape_of(const part_head *head);
/* Equally many tiles for each part, from all over the image: neighbours along a row go to parts that lie a
 * golden section apart. With samples every tile is of every part. */
bool part_owns(const part_shape *shape, uint32_t wave);
size_t part_wave_bytes(const part_shape *shape, uint32_t wave);

/* The head with what follows it; behind all that is its hash, and then the records. */
size_t part_head_bytes(const part_head *head);
uint64_t part_head_hash(const part_head *head, const char *const manifests[MATTE_KINDS]);
/* Where a manifest is, in the bytes of a file whose head was read; NULL: there is none. */
const char *part_manifest(const part_head *head, const unsigned char *bytes, matte_kind kind);

/* FATHOM_BAD_INPUT: the bytes do not begin with the whole head of a part that this version reads. */
fathom_status part_head_read(fathom_context *context, const char *path, const unsigned char *bytes,
                             size_t size, part_head *out);
uint64_t part_hash(const void *bytes, size_t size);

/* The next whole record at *at, which moves behind it; false: the end, or no record of this part. `done`
 * marks tiles that were there before, and gets this one. *payload: its bytes. */
bool part_record_next(const part_shape *shape, const unsigned char *bytes, size_t size, size_t *at,
                      bool *done, part_record *out, const unsigned char **payload);

#endif
