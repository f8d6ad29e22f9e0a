/* Cryptomatte (Friedman and Jones, SIGGRAPH 2015; github.com/Psyop/Cryptomatte, specification 1.2): which
 * objects and materials cover a pixel, and how much of it each. A thing's id is the hash of its name. */
#ifndef FILM_MATTES_H
#define FILM_MATTES_H

#include "math/lanes.h"
#include "scene/scene.h"

/* Kinds of things, in the order of their AOVs' bits. */
typedef enum matte_kind { MATTE_OBJECT, MATTE_MATERIAL, MATTE_KINDS } matte_kind;

/* Ranks in a file: pairs of id and coverage, two to a layer of R, G, B and A. */
#define MATTE_RANKS 6u
/* Objects or materials that a pixel counts; further ones are in no matte. */
#define MATTE_MOST 16u

/* How many samples of a pixel met which things, in the order in which they were met. Ids are never 0. */
typedef struct matte_list {
    uint32_t id[MATTE_MOST], count[MATTE_MOST]; /* an id of 0 ends it */
} matte_list;

/* Lists that are full keep what they have. */
void matte_add(matte_list *to, uint32_t id, uint32_t count);
void matte_add_all(matte_list *to, const matte_list *from);
/* Ids, as floats, and coverages of the ranks: largest first, equal ones by their ids. */
void matte_rank(const matte_list *list, uint32_t samples, float out[2 * MATTE_RANKS]);

/* The bits of a float that is a number and not 0 (the specification's uint32_to_float32). */
uint32_t matte_id(const char *name);

/* The id of each object or material; free() it. NULL: out of memory. */
uint32_t *matte_ids(const fathom_scene *scene, matte_kind kind);
/* {"name":"hash", …}: names of the scene with their ids' hashes; free() it. NULL: out of memory. */
char *matte_manifest(const fathom_scene *scene, matte_kind kind);

/* "CryptoObject", "CryptoMaterial". */
const char *matte_layer(matte_kind kind);

#endif
