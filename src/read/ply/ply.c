#include "read/ply/ply.h"

#include "read/mesh/compact.h"
#include "read/mesh/normals.h"
#include "read/mesh/strokes.h"

#include <float.h>
#include <stdio.h>
#include <stdlib.h>

/* Allocates the arrays that are present and have no values yet, and sets their values and strides. */
static fathom_status allocate_arrays(ply_reader *r) {
    for (int a = 0; a < PLY_ARRAYS; ++a) {
        ply_array *array = &r->arrays[a];
        if (!array->present || array->values) continue;
        void *memory;
        array->stride = (size_t)array->components * sizeof(float);
        fathom_status status = scene_allocate_items(r->scene, r->vertex_count, array->stride, &memory);
        if (status != FATHOM_OK) return status;
        array->values = array->own = memory;
    }
    return FATHOM_OK;
}

static void put_array(const ply_array *array, uint32_t i, const double values[PLY_ROLES]) {
    float *out = array->own + (size_t)i * (size_t)array->components;
    for (int k = 0; k < array->components; ++k) out[k] = (float)values[array->first_role + k];
}

/* The first spherical harmonic is sqrt(1 / (4 pi)). Splats store its factor, from the middle of sRGB
 * (3DGS, Kerbl et al. 2023). */
static double splat_linear(double value) {
    return (double)read_linear(fmin(fmax(0.5 + 0.28209479177387814 * value, 0), 1));
}

static void put_color(const ply_reader *r, uint32_t i, const double values[PLY_ROLES]) {
    double linear[PLY_ROLES];
    for (int role = PLY_R; role <= PLY_B; ++role) {
        linear[role] = r->whole_color > 0 ? (double)read_linear(values[role] / r->whole_color) : values[role];
        if (r->splats) linear[role] = splat_linear(values[role]);
    }
    linear[PLY_A] = r->whole_alpha > 0 ? values[PLY_A] / r->whole_alpha : values[PLY_A];
    put_array(&r->arrays[PLY_COLORS], i, linear);
}

static bool is_finite(double value) { return fabs(value) <= (double)FLT_MAX; }

/* True if the position is finite. */
static bool has_place(const double values[PLY_ROLES]) {
    return is_finite(values[PLY_X]) && is_finite(values[PLY_Y]) && is_finite(values[PLY_Z]);
}

/* Files of scanners and simulations hold such numbers. A lost vertex, which nothing uses then, lies where it
 * does not change the bounds. */
static void mend_vertex(ply_reader *r, uint32_t i, double values[PLY_ROLES]) {
    if (!has_place(values)) {
        r->lost[i] = 1;
        values[PLY_X] = r->bounds.lower.x, values[PLY_Y] = r->bounds.lower.y;
        values[PLY_Z] = r->bounds.lower.z;
    }
    for (int role = PLY_Z + 1; role < PLY_ROLES; ++role)
        values[role] = is_finite(values[role]) ? values[role] : 0;
}

static void put_arrays(const ply_reader *r, uint32_t i, const double values[PLY_ROLES]) {
    for (int a = PLY_POSITIONS + 1; a < PLY_ARRAYS; ++a) {
        if (a == PLY_COLORS && r->arrays[a].own)
            put_color(r, i, values);
        else if (r->arrays[a].own)
            put_array(&r->arrays[a], i, values);
    }
}

static void put_moved(ply_reader *r, uint32_t i, double values[PLY_ROLES]) {
    if (r->lost) {
        mend_vertex(r, i, values);
        put_arrays(r, i, values);
    }
    const double moved[PLY_ROLES] = {values[PLY_X] - r->origin.x, values[PLY_Y] - r->origin.y,
                                     values[PLY_Z] - r->origin.z};
    put_array(&r->arrays[PLY_POSITIONS], i, moved);
}

static void count_odd(ply_reader *r, const double values[PLY_ROLES]) {
    for (int role = 0; role < PLY_ROLES; ++role) {
        if (is_finite(values[role])) continue;
        atomic_store(&r->mends, true);
        if (role > PLY_Z) atomic_fetch_add(&r->odd, 1);
    }
}

void ply_put_vertex(ply_reader *r, uint32_t i, double values[PLY_ROLES], scene_bounds *bounds) {
    if (r->moving) {
        put_moved(r, i, values);
        return;
    }
    count_odd(r, values);
    if (!has_place(values)) return;
    bounds->lower.x = values[PLY_X] < bounds->lower.x ? values[PLY_X] : bounds->lower.x;
    bounds->lower.y = values[PLY_Y] < bounds->lower.y ? values[PLY_Y] : bounds->lower.y;
    bounds->lower.z = values[PLY_Z] < bounds->lower.z ? values[PLY_Z] : bounds->lower.z;
    bounds->upper.x = values[PLY_X] > bounds->upper.x ? values[PLY_X] : bounds->upper.x;
    bounds->upper.y = values[PLY_Y] > bounds->upper.y ? values[PLY_Y] : bounds->upper.y;
    bounds->upper.z = values[PLY_Z] > bounds->upper.z ? values[PLY_Z] : bounds->upper.z;
    if (r->arrays[PLY_POSITIONS].own) put_array(&r->arrays[PLY_POSITIONS], i, values);
    put_arrays(r, i, values);
}

void ply_join_bounds(ply_reader *r, const scene_bounds *bounds) {
    pthread_mutex_lock(&r->lock);
    bounds_join(&r->bounds, bounds);
    pthread_mutex_unlock(&r->lock);
}

/* The file's own bytes cannot be moved or mended. */
static fathom_status leave_file(ply_reader *r) {
    for (int a = 0; a < PLY_ARRAYS; ++a) {
        if (!r->arrays[a].own && (a == PLY_POSITIONS || r->lost)) r->arrays[a].values = NULL;
    }
    return allocate_arrays(r);
}

static fathom_status note_lost(ply_reader *r) {
    size_t lost = 0;
    for (uint32_t i = 0; i < r->vertex_count; ++i) lost += r->lost[i];
    if (lost == r->vertex_count)
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         "it has no vertex whose x, y and z are finite numbers that fit a float, of %zu",
                         lost);
    notes_add(&r->notes, lost, "",
              "a vertex with a NaN, an infinity or a number beyond float is left out, with what uses it");
    notes_add(&r->notes, r->odd, "", "a NaN or an infinity of a vertex, not in x, y or z, is taken as 0");
    return FATHOM_OK;
}

fathom_status ply_read_vertices(ply_reader *r, size_t count, size_t grain, loop_body body, void *user) {
    fathom_status status = allocate_arrays(r);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, count, grain, body, user);
    status = text_status(&r->file, &r->fault);
    if (status != FATHOM_OK) return status;
    if (r->mends) {
        r->lost = calloc(r->vertex_count, 1);
        if (!r->lost) return fail_memory(r->scene->context, r->vertex_count);
    }
    r->origin = origin_for(&r->bounds);
    r->moving = length_f64(r->origin) > 0 || r->lost;
    if (!r->moving) return FATHOM_OK;
    status = leave_file(r);
    if (status == FATHOM_OK) loop_parallel(r->threads, count, grain, body, user);
    return status == FATHOM_OK && r->lost ? note_lost(r) : status;
}

/* The number that means colour 1: integers are sRGB in the range of their type; 0 for floats, which are
 * linear. */
static double whole_of(const ply_reader *r, int role) {
    if (r->role[role] < 0) return 0;
    switch (r->header.elements.items[r->vertex_element].properties.items[r->role[role]].type) {
    case PLY_INT8:
    case PLY_UINT8: return 255;
    case PLY_INT16:
    case PLY_UINT16: return 65535;
    case PLY_INT32:
    case PLY_UINT32: return 4294967295.0;
    case PLY_FLOAT32:
    case PLY_FLOAT64: break;
    }
    return 0;
}

static void choose_arrays(ply_reader *r) {
    const ply_array kinds[PLY_ARRAYS] = {{.first_role = PLY_X, .components = 3},
                                         {.first_role = PLY_NX, .components = 3},
                                         {.first_role = PLY_U, .components = 2},
                                         {.first_role = PLY_U1, .components = 2},
                                         {.first_role = PLY_R, .components = r->role[PLY_A] < 0 ? 3 : 4}};
    for (int a = 0; a < PLY_ARRAYS; ++a) {
        r->arrays[a] = kinds[a];
        r->arrays[a].present = !((a == PLY_NORMALS && r->options.flat) ||
                                 ((a == PLY_UVS || a == PLY_UVS_1) && !scene_keeps_uvs(r->scene)));
        for (int k = 0; k < kinds[a].components; ++k) {
            if (r->role[kinds[a].first_role + k] < 0) r->arrays[a].present = false;
        }
        /* Properties of an absent array are not read. */
        for (int k = 0; k < kinds[a].components && !r->arrays[a].present; ++k) {
            int *property = &r->role[kinds[a].first_role + k];
            if (*property >= 0)
                r->header.elements.items[r->vertex_element].properties.items[*property].role = -1;
            *property = -1;
        }
    }
    r->whole_color = whole_of(r, PLY_R), r->whole_alpha = whole_of(r, PLY_A);
}

static void release_map(void *data) {
    file_close(data);
    free(data);
}

/* If meshes use bytes of the mapped file, the scene takes ownership of the mapping. */
static fathom_status keep_map(ply_reader *r) {
    bool used = false;
    for (int a = 0; a < PLY_ARRAYS; ++a) used = used || (r->arrays[a].values && !r->arrays[a].own);
    if (!used) return FATHOM_OK;
    file_map *kept = malloc(sizeof *kept);
    if (!kept) return fail_memory(r->scene->context, sizeof *kept);
    *kept = r->map;
    r->map = (file_map){0};
    return scene_adopt_file(r->scene, kept, release_map, kept);
}

static fathom_status look_at_vertices(const ply_reader *r, const fathom_mesh *mesh, mesh_facts *facts) {
    return mesh_look_at_vertices(r->scene->context, r->file.path, mesh->positions, mesh->position_stride,
                                 mesh->vertex_count, facts);
}

static fathom_status check_and_add(ply_reader *r, fathom_mesh *mesh) {
    mesh_facts facts;
    bool copied = false;
    fathom_status status = look_at_vertices(r, mesh, &facts);
    if (status == FATHOM_OK) status = mesh_compact(r->scene, true, &facts, mesh, &copied);
    if (status == FATHOM_OK && copied) status = look_at_vertices(r, mesh, &facts);
    if (status == FATHOM_OK) status = mesh_look_at_triangles(r->scene->context, r->file.path, mesh, &facts);
    uint64_t added = 0;
    if (status == FATHOM_OK) status = read_missing_uvs(r->scene, mesh, &added);
    notes_add(&r->notes, added > 0, "", READ_MISSING_UVS);
    return status == FATHOM_OK ? scene_add_mesh_checked(r->scene, r->group, mesh, &facts, NULL) : status;
}

/* A file without faces and edges is a point cloud. */
static bool is_cloud(const ply_reader *r) {
    return r->face_element == SIZE_MAX && r->edge_element == SIZE_MAX;
}

static uint64_t edge_count(const ply_reader *r) {
    return r->edge_element == SIZE_MAX ? 0 : r->header.elements.items[r->edge_element].count;
}

/* Adds the vertices of `mesh` as points, or its edges as rods. */
static fathom_status add_strokes(ply_reader *r, fathom_mesh mesh) {
    const uint64_t count = r->edges ? edge_count(r) : (uint64_t)mesh.vertex_count;
    if (count >= UINT32_MAX)
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         "has %llu edges; more than can be shown", (unsigned long long)count);
    const strokes s = {.positions = mesh.positions,
                       .position_stride = mesh.position_stride,
                       .colors = mesh.colors,
                       .color_stride = mesh.color_stride,
                       .color_channels = mesh.color_channels,
                       .indices = r->edges,
                       .count = (uint32_t)count,
                       .lines = r->edges,
                       .notes = &r->notes};
    notes_add(&r->notes, r->splats && !s.lines ? 0 : s.count, "",
              s.lines ? "edges have no width, and are shown as thin rods"
                      : "points have no size, and are shown as small spheres");
    fathom_status status = strokes_make(r->scene, &s, &mesh);
    if (status != FATHOM_OK)
        return fail_within(r->scene->context, status, &(fathom_place){.file = r->file.path});
    return strokes_any(&mesh) ? check_and_add(r, &mesh) : FATHOM_OK;
}

/* Uses the image that a comment of the header names as the surface's colour map. In these files v grows
 * upwards. */
static fathom_status read_texture(ply_reader *r) {
    const fathom_map map = {.transform = {1, 0, 0, 0, -1, 1}};
    fathom_material material;
    fathom_texture texture;
    const char *at = r->texture;
    char *path = NULL, name[512];
    if (!at || r->options.material != FATHOM_NONE) return FATHOM_OK;
    const size_t length = text_rest(&at, r->file.end);
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1), at);
    fathom_status status = read_image_beside(r->scene, r->file.path, name, &path);
    if (status != FATHOM_OK) return status;
    if (!path || r->role[PLY_U] < 0 || r->role[PLY_V] < 0) {
        notes_add_at(&r->notes, 1, &r->file, at, true, "a texture is left out: %s",
                     path ? "the vertices have no texture coordinates"
                          : "there is no such image that may be read");
        free(path);
        return FATHOM_OK;
    }
    fathom_texture_default(&texture);
    fathom_material_default(&material);
    texture.file = path;
    for (int c = 0; c < 3; ++c) material.k_d[c] = 1;
    material.maps[FATHOM_MAP_COLOR] = map;
    status = fathom_scene_add_texture(r->scene, &texture, &material.maps[FATHOM_MAP_COLOR].texture);
    free(path);
    if (status != FATHOM_OK) return status;
    return fathom_scene_add_material(r->scene, "texture", &material, &r->options.material);
}

static fathom_status add_surface(ply_reader *r, fathom_mesh mesh) {
    mesh.indices = r->indices;
    mesh.triangle_count = (uint32_t)r->triangle_count;
    ply_array *normals = &r->arrays[PLY_NORMALS];
    if (!normals->present && r->options.smooth && !r->options.flat) {
        normals->present = true;
        fathom_status status = allocate_arrays(r);
        if (status == FATHOM_OK)
            status = normals_smooth(r->scene->context, &mesh, NULL, r->vertex_count, normals->own);
        if (status != FATHOM_OK) return status;
    }
    if (normals->present) {
        mesh.normals = normals->values;
        mesh.normal_stride = normals->stride;
        mesh.normal_count = r->vertex_count;
    }
    if (r->arrays[PLY_UVS].present) {
        mesh.uvs = r->arrays[PLY_UVS].values;
        mesh.uv_stride = r->arrays[PLY_UVS].stride;
        mesh.uv_count = r->vertex_count;
    }
    if (r->arrays[PLY_UVS_1].present) {
        mesh.uvs_1 = r->arrays[PLY_UVS_1].values;
        mesh.uv_1_stride = r->arrays[PLY_UVS_1].stride;
    }
    return check_and_add(r, &mesh);
}

/* Opacities that are all 1 are not stored. Opacities that are all 0 are ignored: some programs never set
 * them. */
static unsigned color_channels(ply_reader *r) {
    const ply_array *colors = &r->arrays[PLY_COLORS];
    bool clear = true, whole = true;
    if (colors->components < 4) return 3;
    for (uint32_t i = 0; i < r->vertex_count && (clear || whole); ++i) {
        const float alpha = mesh_row(colors->values, colors->stride, i)[3];
        clear &= !(alpha > 0), whole &= alpha >= 1;
    }
    if (!clear) return whole ? 3 : 4;
    notes_add(&r->notes, r->vertex_count, "", "alpha is 0 at all vertices, and left out");
    return 3;
}

static fathom_status add_meshes(ply_reader *r) {
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = r->arrays[PLY_POSITIONS].values;
    mesh.position_stride = r->arrays[PLY_POSITIONS].stride;
    mesh.vertex_count = r->vertex_count;
    store_f64(mesh.origin, r->origin);
    mesh.material = r->options.material == FATHOM_NONE ? 0 : r->options.material;
    if (r->arrays[PLY_COLORS].present) {
        mesh.colors = r->arrays[PLY_COLORS].values;
        mesh.color_stride = r->arrays[PLY_COLORS].stride;
        mesh.color_channels = color_channels(r);
        if (r->options.material == FATHOM_NONE) {
            fathom_status status = read_colored_material(r->scene, &mesh.material);
            if (status != FATHOM_OK) return status;
        }
    }
    mesh.flags = r->options.flags;
    fathom_status status = r->triangle_count ? add_surface(r, mesh) : FATHOM_OK;
    return status == FATHOM_OK && (r->edges || is_cloud(r)) ? add_strokes(r, mesh) : status;
}

static fathom_status allocate_edges(ply_reader *r) {
    if (r->edge_element == SIZE_MAX) return FATHOM_OK;
    const uint64_t count =
        r->header.elements.items[r->edge_element].count; /* at most the bytes of the file */
    r->edges = calloc((size_t)count, PLY_ENDS * sizeof *r->edges);
    return r->edges ? FATHOM_OK : fail_memory(r->scene->context, (size_t)count * PLY_ENDS * sizeof *r->edges);
}

static fathom_status read_mapped(ply_reader *r) {
    fathom_status status = ply_read_header(r);
    if (status != FATHOM_OK) return status;
    ply_note_unused(r);
    status = read_texture(r);
    if (status != FATHOM_OK) return status;
    choose_arrays(r);
    status = allocate_edges(r);
    if (status == FATHOM_OK) status = r->header.format == PLY_ASCII ? ply_read_ascii(r) : ply_read_binary(r);
    if (status != FATHOM_OK) return status;
    if (r->lost) ply_drop_lost(r);
    if (!r->triangle_count && !edge_count(r) && !is_cloud(r)) {
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         r->lost ? "no faces remain: expected at least one whose corners are finite numbers "
                                   "that fit a float"
                                 : "no faces: expected at least one with 3 corners or more");
    }
    status = keep_map(r);
    return status == FATHOM_OK ? add_meshes(r) : status;
}

static void release(ply_reader *r) {
    for (size_t i = 0; i < r->piece_count; ++i) {
        array_free(&r->pieces[i].indices);
        array_free(&r->pieces[i].polygons);
        array_free(&r->pieces[i].row);
    }
    free(r->pieces);
    free(r->edges);
    free(r->lost);
    for (size_t i = 0; i < r->header.elements.count; ++i) array_free(&r->header.elements.items[i].properties);
    array_free(&r->header.elements);
    text_close(&r->file);
}

fathom_status read_ply(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options) {
    ply_reader r = {.scene = scene,
                    .group = group,
                    .options = *options,
                    .threads = fathom_context_threads(scene->context),
                    .lock = PTHREAD_MUTEX_INITIALIZER,
                    .bounds = bounds_empty()};
    fathom_status status = file_open(scene->context, path, &r.map);
    if (status != FATHOM_OK) return status;
    status = ply_open_text(&r, path);
    if (status == FATHOM_OK) status = read_mapped(&r);
    if (status == FATHOM_OK) notes_tell(&r.notes, scene->context, path);
    release(&r);
    return file_finish(scene->context, &r.map, status);
}
