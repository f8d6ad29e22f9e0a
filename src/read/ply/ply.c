#include "read/ply/ply.h"

#include "read/mesh/strokes.h"

#include <float.h>
#include <stdlib.h>

fathom_status ply_allocate_arrays(ply_reader *r) {
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

static bool is_finite(double value) { return fabs(value) <= (double)FLT_MAX; }

static bool has_place(const double values[PLY_ROLES]) {
    return is_finite(values[PLY_X]) && is_finite(values[PLY_Y]) && is_finite(values[PLY_Z]);
}

/* Files of scanners and simulations hold such numbers. */
static void mend_vertex(double values[PLY_ROLES]) {
    if (!has_place(values)) values[PLY_X] = values[PLY_Y] = values[PLY_Z] = (double)NAN;
    for (int role = PLY_Z + 1; role < PLY_ROLES; ++role)
        values[role] = is_finite(values[role]) ? values[role] : 0;
}

static void put_arrays(const ply_reader *r, uint32_t i, const double values[PLY_ROLES]) {
    for (int a = PLY_POSITIONS + 1; a < PLY_ARRAYS; ++a) {
        if (r->arrays[a].own) put_array(&r->arrays[a], i, values);
    }
}

static void put_moved(ply_reader *r, uint32_t i, double values[PLY_ROLES]) {
    if (r->mends) {
        mend_vertex(values);
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
        if (!r->arrays[a].own && (a == PLY_POSITIONS || r->mends)) r->arrays[a].values = NULL;
    }
    return ply_allocate_arrays(r);
}

static fathom_status note_lost(ply_reader *r) {
    size_t lost = 0;
    const float *positions = r->arrays[PLY_POSITIONS].own;
    for (uint32_t i = 0; i < r->vertex_count; ++i) lost += isnan(positions[3 * (size_t)i]) != 0;
    r->loses = lost > 0;
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
    fathom_status status = ply_allocate_arrays(r);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, count, grain, body, user);
    status = text_status(&r->file, &r->fault);
    if (status != FATHOM_OK) return status;
    r->origin = origin_for(&r->bounds);
    r->moving = length_f64(r->origin) > 0 || r->mends;
    if (!r->moving) return FATHOM_OK;
    status = leave_file(r);
    if (status == FATHOM_OK) loop_parallel(r->threads, count, grain, body, user);
    return status == FATHOM_OK && r->mends ? note_lost(r) : status;
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
        for (int k = 0; k < kinds[a].components && !r->arrays[a].present; ++k)
            ply_drop_role(r, kinds[a].first_role + k);
    }
    if (!scene_keeps_uvs(r->scene)) r->uv_list = SIZE_MAX;
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
    if (status == FATHOM_OK) status = ply_plain_material(r, mesh.colors, &mesh.material);
    return status == FATHOM_OK && strokes_any(&mesh) ? ply_add_mesh(r, &mesh) : status;
}

static fathom_status add_meshes(ply_reader *r) {
    const ply_array *colors = &r->arrays[PLY_COLORS];
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = r->arrays[PLY_POSITIONS].values;
    mesh.position_stride = r->arrays[PLY_POSITIONS].stride;
    mesh.vertex_count = r->vertex_count;
    store_f64(mesh.origin, r->origin);
    if (colors->present) {
        mesh.colors = colors->values;
        mesh.color_stride = colors->stride;
        mesh.color_channels = 3;
        if (colors->components > 3)
            mesh.color_channels =
                ply_color_channels(r, colors->values, colors->stride, r->vertex_count, "vertices");
    }
    mesh.flags = r->options.flags;
    fathom_status status = r->triangle_count ? ply_add_surface(r, mesh) : FATHOM_OK;
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
    status = ply_read_textures(r);
    if (status != FATHOM_OK) return status;
    choose_arrays(r);
    status = allocate_edges(r);
    if (status == FATHOM_OK) status = r->header.format == PLY_ASCII ? ply_read_ascii(r) : ply_read_binary(r);
    if (status != FATHOM_OK) return status;
    if (r->loses) ply_drop_lost(r);
    if (!r->triangle_count && !edge_count(r) && !is_cloud(r)) {
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         r->loses ? "no faces remain: expected at least one whose corners are finite numbers "
                                    "that fit a float"
                                  : "no faces: expected at least one with 3 corners or more");
    }
    status = ply_decode_colors(r);
    if (status == FATHOM_OK) status = keep_map(r);
    return status == FATHOM_OK ? add_meshes(r) : status;
}

static void release(ply_reader *r) {
    for (size_t i = 0; i < r->piece_count; ++i) {
        array_free(&r->pieces[i].indices);
        array_free(&r->pieces[i].polygons);
        array_free(&r->pieces[i].row);
        array_free(&r->pieces[i].row_uvs);
        array_free(&r->pieces[i].uvs);
        array_free(&r->pieces[i].uv_indices);
        array_free(&r->pieces[i].looks);
    }
    free(r->pieces);
    free(r->edges);
    free(r->uvs);
    free(r->looks);
    array_free(&r->textures);
    array_free(&r->materials);
    for (size_t i = 0; i < r->header.elements.count; ++i) array_free(&r->header.elements.items[i].properties);
    array_free(&r->header.elements);
    text_close(&r->file);
}

fathom_status read_ply(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options) {
    ply_reader r = {.scene = scene,
                    .group = group,
                    .options = *options,
                    .colored = FATHOM_NONE,
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
