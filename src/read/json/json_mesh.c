#include "read/json/json_scene.h"

#include "read/mesh/normals.h"
#include "read/read.h"
#include "scene/mesh/mesh_array.h"

#include <string.h>

/* Rows of numbers: a list of the document, or what each of successive triangles lists under a key. */
typedef struct mesh_rows {
    json_t *list;
    json_t *const *triangles; /* if there is no list; NULL: no rows */
    const char *key;
} mesh_rows;

static double number_at(const mesh_rows *rows, size_t i, size_t k) {
    json_t *row = rows->list ? json_array_get(rows->list, i)
                             : json_array_get(json_object_get(rows->triangles[i / 3], rows->key), i % 3);
    return json_number_value(json_array_get(row, k));
}

/* origin: what the numbers are relative to; NULL: 0. stride: floats from a row of *out to the next. */
static void load_rows(const mesh_rows *rows, size_t count, unsigned width, const double *origin,
                      unsigned stride, float *out) {
    for (size_t i = 0; i < count * width; ++i)
        out[i / width * stride + i % width] =
            (float)(number_at(rows, i / width, i % width) - (origin ? origin[i % width] : 0));
}

static void add_bounds(const mesh_rows *rows, size_t count, scene_bounds *box) {
    for (size_t i = 0; i < count; ++i)
        bounds_add(box, (vec3_f64){number_at(rows, i, 0), number_at(rows, i, 1), number_at(rows, i, 2)});
}

/* An object of the document with its arrays. */
typedef struct mesh_source {
    mesh_rows rows[MESH_ARRAYS], opacities;
    bool smooth; /* makes normals if there are none */
    json_t *keys;
} mesh_source;

static mesh_rows key_rows(const mesh_source *s, size_t k, const char *name) {
    return (mesh_rows){.list = json_object_get(json_array_get(s->keys, k), name)};
}

static void choose_origin(const mesh_source *s, fathom_mesh *mesh) {
    scene_bounds box = bounds_empty();
    for (size_t k = 0; k < json_array_size(s->keys); ++k) {
        const mesh_rows positions = key_rows(s, k, "positions");
        add_bounds(&positions, mesh->vertex_count, &box);
    }
    if (!s->keys) add_bounds(&s->rows[MESH_POSITIONS], mesh->vertex_count, &box);
    store_f64(mesh->origin, origin_for(&box));
}

static fathom_status load_arrays(fathom_scene *scene, const mesh_source *s, fathom_mesh *mesh) {
    for (int kind = 0; kind < MESH_ARRAYS; ++kind) {
        const mesh_rows *rows = &s->rows[kind];
        const unsigned width = mesh_array_of(mesh, (mesh_kind)kind).width;
        void *values;
        if ((!rows->list && !rows->triangles) || (kind == MESH_UVS && !scene_keeps_uvs(scene))) continue;
        const fathom_status status =
            scene_allocate_items(scene, mesh->vertex_count, width * sizeof(float), &values);
        if (status != FATHOM_OK) return status;
        load_rows(rows, mesh->vertex_count, kind == MESH_COLORS ? 3 : width,
                  kind == MESH_POSITIONS ? mesh->origin : NULL, width, values);
        if (kind == MESH_COLORS && width > 3)
            load_rows(&s->opacities, mesh->vertex_count, 1, NULL, width, (float *)values + 3);
        mesh_array_set(mesh, (mesh_kind)kind, values, width * sizeof(float));
    }
    return FATHOM_OK;
}

/* Normals for each of `times` poses of the vertices, one after another. */
static fathom_status make_normals(fathom_scene *scene, const fathom_mesh *mesh, const float *positions,
                                  size_t times, const float **out) {
    void *memory;
    const size_t row = 3 * (size_t)mesh->vertex_count;
    fathom_mesh then = *mesh;
    fathom_status status = scene_allocate_items(scene, times * row, sizeof(float), &memory);
    for (size_t k = 0; k < times && status == FATHOM_OK; ++k) {
        then.positions = positions + k * row, then.position_stride = 3 * sizeof(float);
        status = normals_smooth(scene->context, &then, NULL, mesh->vertex_count, (float *)memory + k * row);
    }
    *out = memory;
    return status;
}

static fathom_status load_keys(fathom_scene *scene, const mesh_source *s, fathom_mesh *mesh) {
    const size_t count = json_array_size(s->keys), row = 3 * (size_t)mesh->vertex_count;
    const bool normals = s->rows[MESH_NORMALS].list != NULL;
    void *times, *arrays[2] = {NULL, NULL};
    fathom_status status = scene_allocate_items(scene, count, sizeof(double), &times);
    for (int i = 0; i < 1 + normals && status == FATHOM_OK; ++i)
        status = scene_allocate_items(scene, count * row, sizeof(float), &arrays[i]);
    for (size_t k = 0; k < count && status == FATHOM_OK; ++k) {
        const mesh_rows rows[2] = {key_rows(s, k, "positions"), key_rows(s, k, "normals")};
        ((double *)times)[k] = json_number_value(json_object_get(json_array_get(s->keys, k), "time"));
        for (int i = 0; i < 1 + normals; ++i)
            load_rows(&rows[i], mesh->vertex_count, 3, i ? NULL : mesh->origin, 3,
                      (float *)arrays[i] + k * row);
    }
    mesh->key_count = (uint32_t)count, mesh->key_times = times;
    mesh->key_positions = arrays[0], mesh->key_normals = arrays[1];
    return status == FATHOM_OK && s->smooth && !normals
               ? make_normals(scene, mesh, mesh->key_positions, count, &mesh->key_normals)
               : status;
}

/* The mesh has all but arrays of numbers. */
static fathom_status add_mesh(fathom_scene *scene, fathom_id group, const mesh_source *s, fathom_mesh *mesh) {
    choose_origin(s, mesh);
    fathom_status status = load_arrays(scene, s, mesh);
    if (status == FATHOM_OK && s->smooth && !mesh->normals)
        status = make_normals(scene, mesh, mesh->positions, 1, &mesh->normals);
    if (mesh->normals) mesh->normal_count = mesh->vertex_count;
    if (mesh->uvs) mesh->uv_count = mesh->vertex_count;
    if (status == FATHOM_OK && s->keys) status = load_keys(scene, s, mesh);
    return status == FATHOM_OK ? fathom_scene_add_mesh_shared(scene, group, mesh, NULL) : status;
}

/* ---- single triangles ---- */

void mesh_batch_free(mesh_batch *batch) { array_free(&batch->triangles); }

static bool same_text(const char *a, const char *b) { return a == b || (a && b && strcmp(a, b) == 0); }

fathom_status mesh_batch_flush(const object_reader *r, mesh_batch *batch) {
    static const char *const keys[MESH_ARRAYS] = {
        [MESH_POSITIONS] = "vertices", [MESH_NORMALS] = "normals", [MESH_UVS] = "uvs"};
    const size_t count = batch->triangles.count, first = r->scene->objects.count;
    void *indices;
    if (!count) return FATHOM_OK;
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh_source source = {.smooth = false};
    for (int k = 0; k < MESH_ARRAYS; ++k) {
        if (keys[k] && doc_has(*batch->triangles.items, keys[k]))
            source.rows[k] = (mesh_rows){.triangles = batch->triangles.items, .key = keys[k]};
    }
    fathom_status status = scene_allocate_items(r->scene, 3 * count, sizeof(uint32_t), &indices);
    for (size_t i = 0; i < 3 * count && status == FATHOM_OK; ++i) ((uint32_t *)indices)[i] = (uint32_t)i;
    mesh.indices = indices;
    mesh.vertex_count = (uint32_t)(3 * count), mesh.triangle_count = (uint32_t)count;
    mesh.material = batch->material, mesh.flags = batch->flags;
    if (status == FATHOM_OK) status = add_mesh(r->scene, batch->group, &source, &mesh);
    for (size_t i = first; status == FATHOM_OK && i < r->scene->objects.count; ++i) {
        if (batch->light_group)
            status = fathom_scene_set_light_group(r->scene, FATHOM_SOURCE_OBJECT, (fathom_id)i,
                                                  batch->light_group);
        if (batch->name && status == FATHOM_OK)
            status = fathom_scene_name_object(r->scene, (fathom_id)i, batch->name);
    }
    batch->triangles.count = 0;
    return status;
}

fathom_status mesh_batch_add(const object_reader *r, json_t *value, const form_object_values *o,
                             fathom_id group, fathom_id material, unsigned flags, mesh_batch *batch) {
    json_t *last = batch->triangles.count ? *batch->triangles.items : value;
    if (batch->group != group || batch->material != material || batch->flags != flags ||
        !same_text(batch->light_group, o->light_group) || !same_text(batch->name, o->name) ||
        doc_has(value, "normals") != doc_has(last, "normals") ||
        doc_has(value, "uvs") != doc_has(last, "uvs")) {
        fathom_status status = mesh_batch_flush(r, batch);
        if (status != FATHOM_OK) return status;
    }
    batch->group = group, batch->material = material, batch->flags = flags;
    batch->light_group = o->light_group, batch->name = o->name;
    return array_push(&batch->triangles, value) ? FATHOM_OK : fail_memory(r->scene->context, sizeof value);
}

/* ---- meshes with arrays ---- */

static fathom_status load_indices(const object_reader *r, const where *at, json_t *rows, fathom_mesh *mesh) {
    const size_t corners = 3 * json_array_size(rows);
    void *memory;
    const fathom_status status = scene_allocate_items(r->scene, corners, sizeof(uint32_t), &memory);
    if (status != FATHOM_OK) return status;
    uint32_t *indices = memory;
    for (size_t i = 0; i < corners; ++i) {
        const double x = json_number_value(json_array_get(json_array_get(rows, i / 3), i % 3));
        if (x >= mesh->vertex_count) {
            const where list = {at, "indices", 0}, row = {&list, NULL, i / 3}, item = {&row, NULL, i % 3};
            return doc_fail(r->doc, &item, "expected an integer < %u, the number of positions, found %.0f",
                            mesh->vertex_count, x);
        }
        indices[i] = (uint32_t)x;
    }
    mesh->indices = indices, mesh->triangle_count = (uint32_t)(corners / 3);
    return FATHOM_OK;
}

/* Whole numbers up to 255, of which one is above 2, as in PLY files. */
static bool are_bytes(json_t *rows) {
    bool above = false;
    for (size_t i = 0; i < 3 * json_array_size(rows); ++i) {
        const double x = json_number_value(json_array_get(json_array_get(rows, i / 3), i % 3));
        if (x != floor(x) || x > 255) return false;
        above = above || x > 2;
    }
    return above;
}

static fathom_status check_same_count(const object_reader *r, const where *at, const char *key, json_t *rows,
                                      size_t vertices) {
    if (!rows || json_array_size(rows) == vertices) return FATHOM_OK;
    const where list = {at, key, 0};
    return doc_fail(r->doc, &list, "expected one for each of the %zu positions, found %zu", vertices,
                    json_array_size(rows));
}

static fathom_status check_key(const object_reader *r, const where *at, json_t *value, bool normals,
                               size_t vertices) {
    form_vertex_values key = {.time = 0};
    fathom_status status = doc_read(r->doc, at, value, &form_vertex_key, &key);
    if (status == FATHOM_OK) status = check_same_count(r, at, "positions", key.positions, vertices);
    if (status == FATHOM_OK) status = check_same_count(r, at, "normals", key.normals, vertices);
    if (status == FATHOM_OK && normals && !key.normals)
        status =
            doc_fail(r->doc, at, "\"normals\" is missing; the mesh has normals, so each key needs its own");
    return status;
}

static fathom_status check_keys(const object_reader *r, const where *at, json_t *list, bool normals,
                                size_t vertices) {
    const where keys = {at, "vertexKeys", 0};
    fathom_status status = FATHOM_OK;
    for (size_t k = 0; k < json_array_size(list) && status == FATHOM_OK; ++k) {
        const where item = {&keys, NULL, k};
        status = check_key(r, &item, json_array_get(list, k), normals, vertices);
    }
    return status;
}

fathom_status mesh_inline(const object_reader *r, const where *at, const form_object_values *o,
                          fathom_id group, fathom_id material, unsigned flags) {
    const struct {
        const char *key;
        mesh_kind kind;
        json_t *rows;
    } arrays[] = {{"positions", MESH_POSITIONS, o->as.mesh.positions},
                  {"normals", MESH_NORMALS, o->as.mesh.normals},
                  {"uvs", MESH_UVS, o->as.mesh.uvs},
                  {"uvs1", MESH_UVS_1, o->as.mesh.uvs_1},
                  {"colors", MESH_COLORS, o->as.mesh.colors},
                  {"tangents", MESH_TANGENTS, o->as.mesh.tangents}};
    const size_t vertices = json_array_size(o->as.mesh.positions);
    mesh_source source = {.opacities = {.list = o->as.mesh.opacities},
                          .smooth = o->as.mesh.shading == FORM_SMOOTH && o->as.mesh.indices,
                          .keys = o->as.mesh.keys};
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.vertex_count = (uint32_t)vertices, mesh.point_radius = o->as.mesh.point_radius;
    mesh.color_channels = o->as.mesh.opacities ? 4 : 3;
    mesh.material = material, mesh.flags = flags;
    fathom_status status = check_same_count(r, at, FORM_OPACITIES, o->as.mesh.opacities, vertices);
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays && status == FATHOM_OK; ++i) {
        status = check_same_count(r, at, arrays[i].key, arrays[i].rows, vertices);
        source.rows[arrays[i].kind].list = arrays[i].rows;
    }
    if (o->as.mesh.shading == FORM_FLAT) source.rows[MESH_NORMALS].list = NULL;
    if (status == FATHOM_OK && o->as.mesh.indices) status = load_indices(r, at, o->as.mesh.indices, &mesh);
    if (status == FATHOM_OK && source.keys)
        status = check_keys(r, at, source.keys, source.rows[MESH_NORMALS].list != NULL, vertices);
    if (status != FATHOM_OK) return status;
    const where colors = {at, "colors", 0};
    if (are_bytes(o->as.mesh.colors))
        doc_warn(r->doc, &colors, "expected factors, such as 0.5; the numbers seem to be bytes up to 255");
    status = add_mesh(r->scene, group, &source, &mesh);
    return status == FATHOM_OK ? status : place_within(r, at, "vertexKeys", status);
}
