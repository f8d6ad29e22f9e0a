/* Removes unused vertices from meshes. */
#pragma once

#include "scene/scene.h"

/* In a file, many meshes may share one list of vertices: an OBJ file has one list for all its materials. Code
 * that loops over the vertices of each mesh, or writes them, would then process the whole list for each mesh.
 * So a mesh that has fewer than four corners per vertex and uses at most half of its vertices gets copies of
 * the used ones, in the same order, in memory of the scene. So does a mesh with unused vertices outside the
 * bounds of the used ones, because bounds are those of all vertices. The same is done for normals and uvs
 * with indices of their own. Other meshes, points and meshes with keys are unchanged. in_place: the mesh's
 * indices may be overwritten; otherwise they are copied, too. facts: those that
 * mesh_look_at_vertices() sets. *copied: whether the mesh was changed; its facts are then others. All indices
 * must be in range. */
fathom_status mesh_compact(fathom_scene *scene, bool in_place, const mesh_facts *facts, fathom_mesh *mesh,
                           bool *copied);
