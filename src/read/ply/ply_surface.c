/* Makes meshes of the triangles, one for each texture. Texture coordinates of corners get their own
 * indices. Meshes have colours at vertices, so a vertex between faces of different colours becomes
 * several. */
#include "read/mesh/normals.h"
#include "read/mesh/strokes.h"
#include "read/mesh/weld.h"
#include "read/ply/ply.h"
#include "read/read.h"
#include "scene/mesh/mesh_array.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- materials ---- */

/* Uses the image that a comment of the header names as the surface's colour map. In these files v grows
 * upwards. */
static fathom_status add_textured_material(ply_reader *r, const char *file, fathom_id *out) {
    const fathom_map map = {.transform = {1, 0, 0, 0, -1, 1}};
    fathom_material material;
    fathom_texture texture;
    char name[32] = "texture";
    fathom_texture_default(&texture);
    fathom_material_default(&material);
    texture.file = file;
    for (int c = 0; c < 3; ++c) material.k_d[c] = 1;
    material.maps[FATHOM_MAP_COLOR] = map;
    fathom_status status =
        fathom_scene_add_texture(r->scene, &texture, &material.maps[FATHOM_MAP_COLOR].texture);
    if (status != FATHOM_OK) return status;
    if (r->textures.count > 1) snprintf(name, sizeof name, "texture %zu", r->materials.count);
    return fathom_scene_add_material(r->scene, name, &material, out);
}

/* *out: FATHOM_NONE with a note, if it cannot be shown. */
static fathom_status read_texture(ply_reader *r, const char *at, fathom_id *out) {
    const bool mapped = (r->role[PLY_U] >= 0 && r->role[PLY_V] >= 0) || r->uv_list != SIZE_MAX;
    char *path = NULL, name[512];
    const size_t length = text_rest(&at, r->file.end);
    *out = FATHOM_NONE;
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1), at);
    fathom_status status = read_image_beside(r->scene, r->file.path, name, &path);
    if (status == FATHOM_OK && path && mapped)
        status = add_textured_material(r, path, out);
    else if (status == FATHOM_OK)
        notes_add_at(&r->notes, 1, &r->file, at, true,
                     path ? "a texture is left out: there are no texture coordinates"
                     : read_is_outside(r->scene, r->file.path, name)
                         ? "a texture " READ_OUTSIDE
                         : "a texture is left out: there is no such image that may be read");
    free(path);
    return status;
}

fathom_status ply_read_textures(ply_reader *r) {
    fathom_status status = FATHOM_OK;
    if (r->options.material != FATHOM_NONE) r->textures.count = 0;
    for (size_t i = 0; i < r->textures.count && status == FATHOM_OK; ++i) {
        fathom_id material;
        status = read_texture(r, r->textures.items[i], &material);
        if (status == FATHOM_OK && !array_push(&r->materials, material))
            status = fail_memory(r->scene->context, sizeof material);
    }
    return status;
}

fathom_status ply_plain_material(ply_reader *r, bool colored, fathom_id *out) {
    fathom_status status = FATHOM_OK;
    const bool own = r->options.material == FATHOM_NONE;
    if (own && colored && r->colored == FATHOM_NONE) status = read_colored_material(r->scene, &r->colored);
    *out = !own ? r->options.material : colored ? r->colored : 0;
    return status;
}

/* ---- colours ---- */

/* Copies the rows of the pairs: of their vertices, or of their values. */
static fathom_status copy_pairs(ply_reader *r, const weld *w, mesh_array from, bool of_vertices,
                                fathom_mesh *mesh, mesh_kind kind) {
    const size_t bytes = from.width * sizeof(float);
    void *memory;
    const fathom_status status = scene_allocate_items(r->scene, w->pairs.count, bytes, &memory);
    for (size_t i = 0; status == FATHOM_OK && i < w->pairs.count; ++i) {
        const weld_pair *pair = &w->pairs.items[i];
        memcpy((char *)memory + bytes * i,
               mesh_row(from.values, from.stride, of_vertices ? pair->vertex : pair->row), bytes);
    }
    if (status == FATHOM_OK) mesh_array_set(mesh, kind, memory, bytes);
    return status;
}

static weld weld_of(const fathom_mesh *mesh) {
    return (weld){.vertices = mesh->indices,
                  .corners = 3 * (size_t)mesh->triangle_count,
                  .vertex_count = mesh->vertex_count};
}

/* The arrays of the mesh by the pairs, which are its vertices then. Normals and uvs keep the old indices. */
static fathom_status take_pairs(ply_reader *r, const weld *w, const uint32_t *indices, fathom_mesh *mesh) {
    const mesh_array colors = {
        .values = w->values, .stride = w->stride, .width = mesh->color_channels, .count = 0};
    fathom_status status = copy_pairs(r, w, mesh_array_of(mesh, MESH_POSITIONS), true, mesh, MESH_POSITIONS);
    if (status == FATHOM_OK && mesh->uvs_1)
        status = copy_pairs(r, w, mesh_array_of(mesh, MESH_UVS_1), true, mesh, MESH_UVS_1);
    if (status == FATHOM_OK) status = copy_pairs(r, w, colors, false, mesh, MESH_COLORS);
    if (!mesh->normal_indices && mesh->normals) mesh->normal_indices = mesh->indices;
    if (!mesh->uv_indices && mesh->uvs) mesh->uv_indices = mesh->indices;
    mesh->indices = indices;
    mesh->vertex_count = (uint32_t)w->pairs.count;
    return status;
}

/* Gives the colours of faces to their vertices. */
static fathom_status color_vertices(ply_reader *r, fathom_mesh *mesh) {
    if (r->face_color < 0) return FATHOM_OK;
    weld w = weld_of(mesh);
    void *memory;
    mesh->color_channels = r->face_alpha < 0 ? 3
                                             : ply_color_channels(r, r->looks->color, sizeof *r->looks,
                                                                  r->triangle_count, "faces");
    w.values = r->looks->color, w.stride = sizeof *r->looks;
    w.bytes = mesh->color_channels * sizeof(float);
    fathom_status status = scene_allocate_items(r->scene, w.corners, sizeof(uint32_t), &memory);
    if (status == FATHOM_OK) status = weld_corners(r->scene->context, &w, NULL, memory);
    if (status == FATHOM_OK) status = take_pairs(r, &w, memory, mesh);
    array_free(&w.pairs);
    return status;
}

/* ---- texture coordinates ---- */

/* Gives the corners' texture coordinates to the mesh. Equal ones of a vertex become one, so that tangents
 * are smooth there. */
static fathom_status set_corner_uvs(ply_reader *r, fathom_mesh *mesh) {
    weld w = weld_of(mesh);
    w.values = r->uvs, w.stride = w.bytes = 2 * sizeof *r->uvs;
    fathom_status status = weld_corners(r->scene->context, &w, r->uv_indices, r->uv_indices);
    const mesh_array uvs = {.values = r->uvs, .stride = w.stride, .width = 2};
    if (status == FATHOM_OK) status = copy_pairs(r, &w, uvs, false, mesh, MESH_UVS);
    mesh->uv_count = (uint32_t)w.pairs.count;
    mesh->uv_indices = r->uv_indices;
    array_free(&w.pairs);
    return status;
}

static fathom_status set_uvs(ply_reader *r, fathom_mesh *mesh) {
    if (r->arrays[PLY_UVS].present) {
        mesh->uvs = r->arrays[PLY_UVS].values;
        mesh->uv_stride = r->arrays[PLY_UVS].stride;
        mesh->uv_count = r->vertex_count;
    }
    if (r->arrays[PLY_UVS_1].present) {
        mesh->uvs_1 = r->arrays[PLY_UVS_1].values;
        mesh->uv_1_stride = r->arrays[PLY_UVS_1].stride;
    }
    return r->uv_indices ? set_corner_uvs(r, mesh) : FATHOM_OK;
}

/* ---- meshes ---- */

static fathom_status look_at_vertices(const ply_reader *r, const fathom_mesh *mesh, mesh_facts *facts) {
    return mesh_look_at_vertices(r->scene->context, r->file.path, mesh->positions, mesh->position_stride,
                                 mesh->vertex_count, facts);
}

fathom_status ply_add_mesh(ply_reader *r, fathom_mesh *mesh) {
    mesh_facts facts;
    bool copied = false;
    fathom_status status = look_at_vertices(r, mesh, &facts);
    const bool alone = r->face_color < 0; /* color_vertices() gives an array of indices to normals and uvs */
    if (status == FATHOM_OK) status = mesh_compact(r->scene, alone, &facts, mesh, &copied);
    if (status == FATHOM_OK && copied) status = look_at_vertices(r, mesh, &facts);
    return status == FATHOM_OK ? read_add_mesh(r->scene, r->group, r->file.path, mesh, facts, &r->notes)
                               : status;
}

/* The triangle's texture; their count: none that can be shown. */
static size_t texture_of(const ply_reader *r, size_t triangle) {
    const size_t texture = r->looks ? r->looks[triangle].texture : 0, count = r->textures.count;
    return texture < count && r->materials.items[texture] != FATHOM_NONE ? texture : count;
}

/* Sorts triangles by texture; begins: the first triangle of each, with one for none, and the end. */
static fathom_status sort_indices(ply_reader *r, const size_t *begins, size_t *next,
                                  const uint32_t **indices) {
    void *memory;
    if (!*indices) return FATHOM_OK;
    fathom_status status = scene_allocate_items(r->scene, r->triangle_count, 3 * sizeof **indices, &memory);
    if (status != FATHOM_OK) return status;
    memcpy(next, begins, (r->textures.count + 1) * sizeof *next);
    for (size_t i = 0; i < r->triangle_count; ++i)
        memcpy((uint32_t *)memory + 3 * next[texture_of(r, i)]++, *indices + 3 * i, 3 * sizeof **indices);
    *indices = memory;
    return FATHOM_OK;
}

/* Adds `count` triangles that have this texture, from the triangle `begin`. */
static fathom_status add_part(ply_reader *r, fathom_mesh mesh, size_t texture, size_t begin, size_t count) {
    fathom_status status = FATHOM_OK;
    const bool textured = texture < r->textures.count,
               twice = textured && mesh.uvs && mesh.colors && !r->by_fathom;
    notes_add(&r->notes, twice, "", READ_COLORS_TWICE);
    if (twice) mesh.colors = NULL, mesh.color_channels = 3;
    if (textured)
        mesh.material = r->materials.items[texture];
    else
        status = ply_plain_material(r, mesh.colors, &mesh.material);
    mesh.indices += 3 * begin;
    if (mesh.normal_indices) mesh.normal_indices += 3 * begin;
    if (mesh.uv_indices) mesh.uv_indices += 3 * begin;
    mesh.triangle_count = (uint32_t)count;
    return status == FATHOM_OK ? ply_add_mesh(r, &mesh) : status;
}

static fathom_status add_parts(ply_reader *r, fathom_mesh *mesh, size_t *begins, size_t *next) {
    const size_t parts = r->textures.count + 1;
    for (size_t i = 0; i < r->triangle_count; ++i) ++begins[texture_of(r, i) + 1];
    for (size_t i = 0; i < parts; ++i) begins[i + 1] += begins[i];
    fathom_status status = sort_indices(r, begins, next, &mesh->indices);
    if (status == FATHOM_OK) status = sort_indices(r, begins, next, &mesh->normal_indices);
    if (status == FATHOM_OK) status = sort_indices(r, begins, next, &mesh->uv_indices);
    for (size_t i = 0; i < parts && status == FATHOM_OK; ++i) {
        if (begins[i + 1] > begins[i]) status = add_part(r, *mesh, i, begins[i], begins[i + 1] - begins[i]);
    }
    return status;
}

/* Adds a mesh for each texture. */
static fathom_status add_textured(ply_reader *r, fathom_mesh *mesh) {
    bool same = true;
    for (size_t i = 1; r->looks && i < r->triangle_count; ++i) same &= texture_of(r, i) == texture_of(r, 0);
    if (same) return add_part(r, *mesh, texture_of(r, 0), 0, r->triangle_count);
    const size_t parts = r->textures.count + 1;
    size_t *begins = calloc(2 * parts + 1, sizeof *begins);
    if (!begins) return fail_memory(r->scene->context, (2 * parts + 1) * sizeof *begins);
    const fathom_status status = add_parts(r, mesh, begins, begins + parts + 1);
    free(begins);
    return status;
}

static fathom_status set_normals(ply_reader *r, fathom_mesh *mesh) {
    ply_array *normals = &r->arrays[PLY_NORMALS];
    if (!normals->present && r->options.smooth && !r->options.flat) {
        normals->present = true;
        fathom_status status = ply_allocate_arrays(r);
        if (status == FATHOM_OK)
            status = normals_smooth(r->scene->context, mesh, NULL, r->vertex_count, normals->own);
        if (status != FATHOM_OK) return status;
    }
    if (!normals->present) return FATHOM_OK;
    mesh->normals = normals->values;
    mesh->normal_stride = normals->stride;
    mesh->normal_count = r->vertex_count;
    return FATHOM_OK;
}

fathom_status ply_add_surface(ply_reader *r, fathom_mesh mesh) {
    mesh.indices = r->indices;
    mesh.triangle_count = (uint32_t)r->triangle_count;
    fathom_status status = set_normals(r, &mesh);
    if (status == FATHOM_OK) status = set_uvs(r, &mesh);
    if (status == FATHOM_OK) status = color_vertices(r, &mesh);
    return status == FATHOM_OK ? add_textured(r, &mesh) : status;
}
