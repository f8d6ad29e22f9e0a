/* Programs whose values mean something else than the format says, by the comments that they begin with. */
#include "read/obj/mtl.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

static bool says(const char *line, size_t length, const char *word) {
    return memmem(line, length, word, strlen(word)) != NULL;
}

mtl_writer mtl_writer_of(const text_file *file) {
    static const char blender[] = "# Blender ", older[] = "# Blender MTL File";
    const size_t version = sizeof blender - 1;
    for (const char *p = file->begin; p < file->end && (*p == '#' || isspace((unsigned char)*p));) {
        const char *newline = memchr(p, '\n', (size_t)(file->end - p)), *end = newline ? newline : file->end;
        const size_t length = (size_t)(end - p);
        if (length > version && memcmp(p, blender, version) == 0 && isdigit((unsigned char)p[version]))
            return MTL_BY_BLENDER;
        if (length >= sizeof older && memcmp(p, older, sizeof older - 1) == 0) return MTL_BY_OLDER_BLENDER;
        if (says(p, length, "3ds Max") || says(p, length, "AliceVision")) return MTL_BY_MAX;
        p = newline ? newline + 1 : end;
    }
    return MTL_BY_ANY;
}

bool mtl_is_principled(mtl_writer writer, const mtl_entry *m) {
    return writer == MTL_BY_BLENDER || (writer == MTL_BY_OLDER_BLENDER && m->ni > 1);
}

void mtl_settle_principled(mtl_entry *m) {
    const int illum = mtl_illum(m);
    if (illum == 0 || (illum > 3 && illum != 6 && illum != 9)) return; /* edited by hand */
    const double amplitude = sqrt(0.08 * fmin(m->ks[0], 1)), metal = (m->ka[0] + m->ka[1] + m->ka[2]) / 3;
    if (!mtl_given(m, MTL_PR)) m->pr = 1 - sqrt(fmin(m->ns, 1000) / 1000);
    if (!mtl_given(m, MTL_PM)) m->pm = illum == 3 || illum == 6 ? fmin(metal, 1) : 0;
    if (!(m->tf[0] > 0)) m->ni = (1 + amplitude) / (1 - amplitude);
    m->ps *= 0.104; /* see mtl_material.c */
    m->given |= 1u << MTL_PR | 1u << MTL_PM;
}
