/* Materials of Wavefront MTL files. */
#ifndef READ_MTL_H
#define READ_MTL_H

#include "read/mesh/names.h"
#include "scene/scene.h"

typedef struct mtl_material {
    char *name;
    fathom_material value;
} mtl_material;

/* Zero it to start with; release with mtl_free(). */
typedef struct mtl_library {
    ARRAY(mtl_material) materials;
    name_table names; /* of materials[], in the same order */
} mtl_library;

/* Adds the materials of the file; one whose name is there already takes its place. What is not used is warned
 * about once. A file that cannot be opened is warned about and adds nothing. FATHOM_BAD_INPUT names the line.
 */
fathom_status mtl_read(fathom_context *context, const char *path, mtl_library *library);
void mtl_free(mtl_library *library);

#endif
