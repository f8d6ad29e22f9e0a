/* The library of materials next to an OBJ file. */
#pragma once

#include "write/image.h"
#include "write/write.h"

typedef struct write_library {
    const fathom_scene *scene;
    const write_images *images; /* named */
    char *const *names;         /* of the materials */
    bool flips;                 /* write_flips() */
    note_list *notes;
} write_library;

/* Writes the whole file or none. */
fathom_status write_mtl(const write_library *l, const char *path);
