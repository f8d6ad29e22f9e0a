/* Meshes without the vertices that they do not use. */
#ifndef READ_COMPACT_H
#define READ_COMPACT_H

#include "scene/scene.h"

/* Files let many meshes share their vertices: an OBJ file has one list for all of its materials. Whoever
 * walks through the vertices of each mesh, or writes them, would then walk through all of the file's. A mesh
 * that uses at most half of its vertices gets copies of those that it uses, in their order, in memory of the
 * scene; so do normals and uvs with indices of their own. in_place: its indices may be written over, else
 * they are copied, too. *copied: whether it did. Others, points and meshes with keys stay as they are. The
 * indices are in range. */
fathom_status mesh_compact(fathom_scene *scene, bool in_place, fathom_mesh *mesh, bool *copied);

#endif
