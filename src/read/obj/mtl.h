/* Shared by the mtl*.c files: the values of an MTL material, and their conversion to a fathom_material. */
#pragma once

#include "read/obj/obj.h"

/* A material's values as written in the file. */
typedef struct mtl_entry {
    double ka[3], kd[3], ks[3], ke[3], tf[3], ns, ni, d, illum, pr, pm, pc, pcr, ps, aniso, anisor;
    unsigned given; /* bits of the kinds below */
    const char *at[17];
} mtl_entry;

enum {
    MTL_KA,
    MTL_KD,
    MTL_KS,
    MTL_KE,
    MTL_TF,
    MTL_NS,
    MTL_NI,
    MTL_D,
    MTL_TR,
    MTL_ILLUM,
    MTL_PR,
    MTL_PM,
    MTL_PC,
    MTL_PCR,
    MTL_PS,
    MTL_ANISO,
    MTL_ANISOR,
    MTL_KINDS
};
_Static_assert(sizeof(((mtl_entry *)0)->at) == MTL_KINDS * sizeof(char *), "a place for each kind");

/* The statement of each kind. */
typedef struct mtl_field {
    const char *keyword;
    size_t offset; /* in mtl_entry */
    int numbers;
    double lowest, highest;
} mtl_field;
extern const mtl_field mtl_fields[MTL_KINDS];

static inline double *mtl_value(mtl_entry *m, int kind) {
    return (double *)(void *)((char *)m + mtl_fields[kind].offset);
}
static inline bool mtl_given(const mtl_entry *m, int kind) { return m->given >> kind & 1; }
static inline bool mtl_is_white(const double rgb[3]) { return rgb[0] == 1 && rgb[1] == 1 && rgb[2] == 1; }
static inline bool mtl_is_black(const double rgb[3]) { return rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0; }

/* The program that wrote the file, if it does not follow the format. */
typedef enum mtl_writer {
    MTL_BY_ANY,
    MTL_BY_BLENDER,
    MTL_BY_OLDER_BLENDER, /* the exporter before that of 3.2; it writes the colour that an image replaces */
    MTL_BY_MAX            /* 3ds Max or AliceVision, which do so too */
} mtl_writer;
mtl_writer mtl_writer_of(const text_file *file);
/* True if the values are those of Blender's Principled BSDF, as since 2.8; before, Ni was 1 except for glass.
 */
bool mtl_is_principled(mtl_writer writer, const mtl_entry *m);
/* Makes such an entry metallic-roughness. */
void mtl_settle_principled(mtl_entry *m);

/* True if the name of a bump image says that it holds normals; current exporters write such names. */
bool mtl_says_normal(const char *path);
int mtl_illum(const mtl_entry *m);
/* True if its illumination model (4, 6, 7 or 9) transmits light; 9 with d < 1 only if Tf is given. */
bool mtl_is_glass(const mtl_entry *m);
/* True if it has keys of the metallic-roughness model. */
bool mtl_is_metallic(const mtl_entry *m);
/* The material without its maps. */
fathom_material mtl_material_from(const mtl_entry *m);
