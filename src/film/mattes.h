/* Cryptomatte (Friedman and Jones, SIGGRAPH 2015; github.com/Psyop/Cryptomatte, specification 1.2): the
 * objects and materials that cover a pixel, and the fraction that each covers. An id is the hash of a
 * name. */
#pragma once

#include "math/lanes.h"
#include "scene/scene.h"

/* In the order of the bits of their AOVs. */
typedef enum matte_kind { MATTE_OBJECT, MATTE_MATERIAL, MATTE_KINDS } matte_kind;

/* Ranks in a file: pairs of id and coverage, two to a layer of R, G, B and A. */
#define MATTE_RANKS 6u
/* Maximum number of objects or materials that a pixel counts; further ones are in no matte. */
#define MATTE_MOST 16u

/* The number of samples of a pixel that hit each object or material, in the order of the first hits. Ids are
 * never 0. */
typedef struct matte_list {
    uint32_t id[MATTE_MOST], count[MATTE_MOST]; /* an id of 0 ends the list */
} matte_list;

/* A full list ignores further ids. */
void matte_add(matte_list *to, uint32_t id, uint32_t count);
void matte_add_all(matte_list *to, const matte_list *from);
/* Pairs of id (as a float) and coverage, largest coverage first; equal coverages by their ids. */
void matte_rank(const matte_list *list, uint32_t samples, float out[2 * MATTE_RANKS]);

/* An id: the bits of a float that is finite and not 0 (the specification's uint32_to_float32). */
uint32_t matte_id(const char *name);

/* The id of each object, and then of each instance, for its shapes without names; 0: none. Or the id of each
 * material. Release with free(). NULL: out of memory. */
uint32_t *matte_ids(const fathom_scene *scene, matte_kind kind);
/* ids: of objects. instance: the innermost around the object, or FATHOM_NONE. */
uint32_t matte_of_object(const fathom_scene *scene, const uint32_t *ids, fathom_id object,
                         fathom_id instance);
/* {"name":"hash", …}: names of the scene with the hashes of their ids. Release with free(). NULL: out of
 * memory. */
char *matte_manifest(const fathom_scene *scene, matte_kind kind);

/* "CryptoObject", "CryptoMaterial". */
const char *matte_layer(matte_kind kind);
