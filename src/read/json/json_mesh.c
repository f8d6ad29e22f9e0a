#include "read/json/json_scene.h"

#include "read/mesh/normals.h"
#include "read/read.h"

#include <stdlib.h>
#include <string.h>

typedef struct mesh_arrays {
    double *positions, *normals, *uvs, *uvs_1, *colors, *tangents; /* for each vertex; all but the first may
                                                                      be NULL */
    unsigned channels;                                             /* of colours */
    uint32_t *indices;
    size_t vertices, triangles;
    float point_radius; /* > 0: a point cloud */
    bool smooth;        /* make normals if there are none */
    size_t keys; /* number of keys; the arrays hold all vertices and normals of one key after another; 0: no
                    motion */
    double *key_times, *key_positions, *key_normals;
} mesh_arrays;

/* `width` numbers for each vertex, relative to `origin`. NULL stays NULL. */
static fathom_status narrow_all(const object_reader *r, const double *from, size_t vertices, unsigned width,
                                const double *origin, float **out) {
    *out = NULL;
    if (!from) return FATHOM_OK;
    size_t count = vertices * width;
    float *to = *out = malloc(count * sizeof *to);
    if (!to) return fail_memory(r->scene->context, count * sizeof *to);
    for (size_t i = 0; i < count; ++i) to[i] = (float)(from[i] - origin[i % width]);
    return FATHOM_OK;
}

static vec3_f64 choose_origin(const mesh_arrays *a) {
    const double *points = a->keys ? a->key_positions : a->positions;
    const size_t count = a->keys ? a->keys * a->vertices : a->vertices;
    scene_bounds box = bounds_empty();
    for (size_t i = 0; i < count; ++i) bounds_add(&box, load_f64(points + 3 * i));
    return origin_for(&box);
}

/* Normals are computed as for the mesh, or are those in the file. */
static fathom_status add_keys(const object_reader *r, const mesh_arrays *a, fathom_mesh *mesh,
                              float **positions, float **normals) {
    static const double zero[3] = {0, 0, 0};
    const size_t vertices = a->keys * a->vertices;
    fathom_status status = narrow_all(r, a->key_positions, vertices, 3, mesh->origin, positions);
    if (status == FATHOM_OK) status = narrow_all(r, a->key_normals, vertices, 3, zero, normals);
    mesh->key_count = (uint32_t)a->keys, mesh->key_times = a->key_times;
    mesh->key_positions = *positions, mesh->key_normals = *normals;
    if (status != FATHOM_OK || *normals || !mesh->normals || !a->smooth) return status;
    mesh->key_normals = *normals = malloc(3 * vertices * sizeof **normals);
    if (!*normals) return fail_memory(r->scene->context, 3 * vertices * sizeof **normals);
    fathom_mesh there = *mesh;
    for (size_t k = 0; k < a->keys && status == FATHOM_OK; ++k) {
        there.positions = *positions + 3 * k * a->vertices;
        status = normals_smooth(r->scene->context, &there, NULL, mesh->vertex_count,
                                *normals + 3 * k * a->vertices);
    }
    return status;
}

static fathom_status add_arrays(const object_reader *r, fathom_id group, const mesh_arrays *a,
                                fathom_id material, unsigned flags) {
    if (a->vertices >= UINT32_MAX || a->triangles >= UINT32_MAX)
        return fail(r->scene->context, FATHOM_BAD_INPUT, "more than 2^32 - 2 vertices or triangles");
    static const double none[4] = {0, 0, 0, 0};
    float *positions = NULL, *normals = NULL, *uvs = NULL, *uvs_1 = NULL, *colors = NULL, *tangents = NULL,
          *key_positions = NULL, *key_normals = NULL;
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    store_f64(mesh.origin, choose_origin(a));
    fathom_status status = narrow_all(r, a->positions, a->vertices, 3, mesh.origin, &positions);
    if (status == FATHOM_OK) status = narrow_all(r, a->normals, a->vertices, 3, none, &normals);
    if (status == FATHOM_OK) status = narrow_all(r, a->uvs, a->vertices, 2, none, &uvs);
    if (status == FATHOM_OK) status = narrow_all(r, a->uvs_1, a->vertices, 2, none, &uvs_1);
    if (status == FATHOM_OK) status = narrow_all(r, a->colors, a->vertices, a->channels, none, &colors);
    if (status == FATHOM_OK) status = narrow_all(r, a->tangents, a->vertices, 4, none, &tangents);
    mesh.positions = positions, mesh.indices = a->indices;
    mesh.position_stride = 3 * sizeof *positions;
    mesh.vertex_count = (uint32_t)a->vertices, mesh.triangle_count = (uint32_t)a->triangles;
    mesh.point_radius = a->point_radius;
    if (status == FATHOM_OK && a->smooth && !normals) {
        normals = malloc(3 * a->vertices * sizeof *normals);
        status = normals ? normals_smooth(r->scene->context, &mesh, NULL, mesh.vertex_count, normals)
                         : fail_memory(r->scene->context, 3 * a->vertices * sizeof *normals);
    }
    if (status == FATHOM_OK) {
        mesh.normals = normals, mesh.normal_count = normals ? mesh.vertex_count : 0;
        mesh.uvs = uvs, mesh.uv_count = uvs ? mesh.vertex_count : 0;
        mesh.uvs_1 = uvs_1, mesh.colors = colors, mesh.color_channels = a->channels;
        mesh.tangents = tangents;
        mesh.material = material;
        mesh.flags = flags;
        if (a->keys) status = add_keys(r, a, &mesh, &key_positions, &key_normals);
    }
    if (status == FATHOM_OK) {
        status = fathom_scene_add_mesh(r->scene, group, &mesh, NULL);
    }
    free(positions), free(normals), free(uvs), free(uvs_1), free(colors), free(tangents);
    free(key_positions), free(key_normals);
    return status;
}

/* ---- single triangles ---- */

void mesh_batch_free(mesh_batch *batch) {
    array_free(&batch->positions);
    array_free(&batch->normals);
    array_free(&batch->uvs);
}

static bool same_text(const char *a, const char *b) { return a == b || (a && b && strcmp(a, b) == 0); }

fathom_status mesh_batch_flush(const object_reader *r, mesh_batch *batch) {
    size_t vertices = batch->positions.count / 3;
    if (!vertices) return FATHOM_OK;
    uint32_t *indices = malloc(vertices * sizeof *indices);
    if (!indices) return fail_memory(r->scene->context, vertices * sizeof *indices);
    for (size_t i = 0; i < vertices; ++i) indices[i] = (uint32_t)i;
    const mesh_arrays arrays = {.positions = batch->positions.items,
                                .normals = batch->normals.count ? batch->normals.items : NULL,
                                .uvs = batch->uvs.count ? batch->uvs.items : NULL,
                                .indices = indices,
                                .vertices = vertices,
                                .triangles = vertices / 3};
    const size_t first = r->scene->objects.count;
    fathom_status status = add_arrays(r, batch->group, &arrays, batch->material, batch->flags);
    for (size_t i = first; status == FATHOM_OK && i < r->scene->objects.count; ++i) {
        if (batch->light_group)
            status = fathom_scene_set_light_group(r->scene, FATHOM_SOURCE_OBJECT, (fathom_id)i,
                                                  batch->light_group);
        if (batch->name && status == FATHOM_OK)
            status = fathom_scene_name_object(r->scene, (fathom_id)i, batch->name);
    }
    free(indices);
    batch->positions.count = batch->normals.count = batch->uvs.count = 0;
    return status;
}

fathom_status mesh_batch_add(const object_reader *r, json_t *value, const form_object_values *o,
                             fathom_id group, fathom_id material, unsigned flags, mesh_batch *batch) {
    bool normals = doc_has(value, "normals"), uvs = doc_has(value, "uvs");
    if (batch->group != group || batch->material != material || batch->flags != flags ||
        !same_text(batch->light_group, o->light_group) || !same_text(batch->name, o->name) ||
        normals != (batch->normals.count > 0) || uvs != (batch->uvs.count > 0)) {
        fathom_status status = mesh_batch_flush(r, batch);
        if (status != FATHOM_OK) return status;
    }
    batch->group = group, batch->material = material, batch->flags = flags;
    batch->light_group = o->light_group, batch->name = o->name;
    if (!array_room(&batch->positions, 9) || !array_room(&batch->normals, 9) || !array_room(&batch->uvs, 6))
        return fail_memory(r->scene->context, batch->positions.count * sizeof(double));
    memcpy(batch->positions.items + batch->positions.count, o->as.triangle.vertices, 9 * sizeof(double));
    memcpy(batch->normals.items + batch->normals.count, o->as.triangle.normals, 9 * sizeof(double));
    memcpy(batch->uvs.items + batch->uvs.count, o->as.triangle.uvs, 6 * sizeof(double));
    batch->positions.count += 9;
    batch->normals.count += normals ? 9 : 0;
    batch->uvs.count += uvs ? 6 : 0;
    return FATHOM_OK;
}

/* ---- meshes with arrays ---- */

static fathom_status load_rows(const object_reader *r, json_t *rows, unsigned count, double **out) {
    size_t numbers = json_array_size(rows) * count;
    *out = malloc((numbers ? numbers : 1) * sizeof **out);
    if (!*out) return fail_memory(r->scene->context, numbers * sizeof **out);
    doc_rows(rows, count, *out);
    return FATHOM_OK;
}

static fathom_status load_indices(const object_reader *r, const where *at, json_t *rows, size_t vertices,
                                  uint32_t **out) {
    size_t triangles = json_array_size(rows);
    uint32_t *indices = *out = malloc(triangles * 3 * sizeof *indices);
    if (!indices) return fail_memory(r->scene->context, triangles * 3 * sizeof *indices);
    for (size_t i = 0; i < triangles * 3; ++i) {
        json_t *index = json_array_get(json_array_get(rows, i / 3), i % 3);
        double x = json_number_value(index);
        if (x >= (double)vertices) {
            const where list = {at, "indices", 0}, row = {&list, NULL, i / 3}, item = {&row, NULL, i % 3};
            return doc_fail(r->doc, &item, "expected an integer < %zu, the number of positions, found %.0f",
                            vertices, x);
        }
        indices[i] = (uint32_t)x;
    }
    return FATHOM_OK;
}

/* Colours, each followed by its opacity. */
static fathom_status load_colors(const object_reader *r, const form_object_values *o, mesh_arrays *out) {
    json_t *rows = o->as.mesh.colors, *opacities = o->as.mesh.opacities;
    out->channels = opacities ? 4 : 3;
    if (!rows || !opacities) return rows ? load_rows(r, rows, 3, &out->colors) : FATHOM_OK;
    out->colors = malloc(4 * out->vertices * sizeof *out->colors);
    if (!out->colors) return fail_memory(r->scene->context, 4 * out->vertices * sizeof *out->colors);
    for (size_t i = 0; i < 4 * out->vertices; ++i) {
        json_t *row = json_array_get(i % 4 < 3 ? rows : opacities, i / 4);
        out->colors[i] = json_number_value(json_array_get(row, i % 4 < 3 ? i % 4 : 0));
    }
    return FATHOM_OK;
}

static fathom_status check_same_count(const object_reader *r, const where *at, const char *key, json_t *rows,
                                      size_t vertices) {
    if (!rows || json_array_size(rows) == vertices) return FATHOM_OK;
    const where list = {at, key, 0};
    return doc_fail(r->doc, &list, "expected one for each of the %zu positions, found %zu", vertices,
                    json_array_size(rows));
}

static fathom_status load_key(const object_reader *r, const where *at, json_t *value, bool normals, size_t k,
                              mesh_arrays *out) {
    form_vertex_values key = {.time = 0};
    fathom_status status = doc_read(r->doc, at, value, &form_vertex_key, &key);
    if (status == FATHOM_OK) status = check_same_count(r, at, "positions", key.positions, out->vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "normals", key.normals, out->vertices);
    if (status == FATHOM_OK && normals && !key.normals)
        status =
            doc_fail(r->doc, at, "\"normals\" is missing; the mesh has normals, so each key needs its own");
    if (status != FATHOM_OK) return status;
    out->key_times[k] = key.time;
    doc_rows(key.positions, 3, out->key_positions + 3 * k * out->vertices);
    if (normals) doc_rows(key.normals, 3, out->key_normals + 3 * k * out->vertices);
    return FATHOM_OK;
}

static fathom_status load_keys(const object_reader *r, const where *at, json_t *list, bool normals,
                               mesh_arrays *out) {
    const where keys = {at, "vertexKeys", 0};
    const size_t numbers = 3 * json_array_size(list) * out->vertices;
    out->keys = json_array_size(list);
    if (!out->keys) return doc_fail(r->doc, &keys, "expected one or more keys, found none");
    out->key_times = malloc(out->keys * sizeof(double));
    out->key_positions = malloc(numbers * sizeof(double));
    out->key_normals = normals ? malloc(numbers * sizeof(double)) : NULL;
    if (!out->key_times || !out->key_positions || (normals && !out->key_normals))
        return fail_memory(r->scene->context, numbers * sizeof(double));
    fathom_status status = FATHOM_OK;
    for (size_t k = 0; k < out->keys && status == FATHOM_OK; ++k) {
        const where item = {&keys, NULL, k};
        status = load_key(r, &item, json_array_get(list, k), normals, k, out);
    }
    return status;
}

/* The caller owns the arrays of *out, even after a failure. */
static fathom_status load_inline(const object_reader *r, const where *at, const form_object_values *o,
                                 mesh_arrays *out) {
    size_t vertices = json_array_size(o->as.mesh.positions);
    json_t *normals = o->as.mesh.shading == FORM_FLAT ? NULL : o->as.mesh.normals;
    *out = (mesh_arrays){.vertices = vertices,
                         .triangles = json_array_size(o->as.mesh.indices),
                         .point_radius = o->as.mesh.point_radius,
                         .smooth = o->as.mesh.shading == FORM_SMOOTH && o->as.mesh.indices};
    fathom_status status = check_same_count(r, at, "normals", o->as.mesh.normals, vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "uvs", o->as.mesh.uvs, vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "uvs1", o->as.mesh.uvs_1, vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "colors", o->as.mesh.colors, vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "opacities", o->as.mesh.opacities, vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "tangents", o->as.mesh.tangents, vertices);
    if (status == FATHOM_OK) status = load_rows(r, o->as.mesh.positions, 3, &out->positions);
    if (status == FATHOM_OK && normals) status = load_rows(r, normals, 3, &out->normals);
    if (status == FATHOM_OK && o->as.mesh.uvs) status = load_rows(r, o->as.mesh.uvs, 2, &out->uvs);
    if (status == FATHOM_OK && o->as.mesh.uvs_1) status = load_rows(r, o->as.mesh.uvs_1, 2, &out->uvs_1);
    if (status == FATHOM_OK) status = load_colors(r, o, out);
    if (status == FATHOM_OK && o->as.mesh.tangents)
        status = load_rows(r, o->as.mesh.tangents, 4, &out->tangents);
    if (status == FATHOM_OK && o->as.mesh.indices)
        status = load_indices(r, at, o->as.mesh.indices, vertices, &out->indices);
    if (status == FATHOM_OK && o->as.mesh.keys)
        status = load_keys(r, at, o->as.mesh.keys, normals != NULL, out);
    return status;
}

fathom_status mesh_inline(const object_reader *r, const where *at, const form_object_values *o,
                          fathom_id group, fathom_id material, unsigned flags) {
    mesh_arrays arrays;
    fathom_status status = load_inline(r, at, o, &arrays);
    if (status == FATHOM_OK) {
        status = add_arrays(r, group, &arrays, material, flags);
        if (status != FATHOM_OK) status = place_within(r, at, "vertexKeys", status);
    }
    free(arrays.positions), free(arrays.normals), free(arrays.uvs), free(arrays.indices);
    free(arrays.uvs_1), free(arrays.colors), free(arrays.tangents);
    free(arrays.key_times), free(arrays.key_positions), free(arrays.key_normals);
    return status;
}
