/* Meshes to groups, a mesh of the scene for each primitive. */
#include "read/gltf/gltf.h"
#include "read/mesh/normals.h"
#include "read/mesh/strokes.h"

#include <stdlib.h>
#include <string.h>

enum { MODE_POINTS, MODE_LINES, MODE_LOOP, MODE_LINE_STRIP, MODE_TRIANGLES, MODE_STRIP, MODE_FAN };

typedef struct primitive {
    const gltf_value *at;
    const gltf_value *attributes;
    const gltf_shape *shapes; /* at each moment */
    uint32_t mode;
    bool blends;                      /* the material's alpha counts */
    gltf_elements positions, normals; /* as the file has them; values NULL: none */
    fathom_mesh mesh;
    mesh_facts facts;
} primitive;

/* 0, 1, 2… for a primitive without indices. */
static fathom_status count_up(gltf *g, const gltf_value *at, uint32_t count, const uint32_t **out) {
    void *memory;
    fathom_status status = gltf_allocate(g, at, NULL, (uint64_t)count * sizeof(uint32_t), &memory);
    if (status != FATHOM_OK) return status;
    uint32_t *indices = memory;
    for (uint32_t i = 0; i < count; ++i) indices[i] = i;
    *out = indices;
    return FATHOM_OK;
}

/* Triangle i of a strip is i, then the next two in the order that keeps the winding of triangle 0; of a fan,
 * the vertices i + 1, i + 2 and 0. */
static fathom_status unroll(gltf *g, const gltf_value *at, uint32_t mode, const uint32_t *from,
                            uint32_t triangles, const uint32_t **out) {
    void *memory;
    fathom_status status = gltf_allocate(g, at, NULL, (uint64_t)triangles * 3 * sizeof(uint32_t), &memory);
    if (status != FATHOM_OK) return status;
    uint32_t *to = memory;
    for (uint32_t i = 0; i < triangles; ++i, to += 3) {
        bool strip = mode == MODE_STRIP;
        to[0] = from[strip ? i : i + 1];
        to[1] = from[strip ? i + 1 + i % 2 : i + 2];
        to[2] = from[strip ? i + 2 - i % 2 : 0];
    }
    *out = memory;
    return FATHOM_OK;
}

static uint32_t triangles_of(uint32_t mode, uint32_t corners) {
    return mode == MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

/* The indices of whole triangles are checked later. Those of strips and fans, and any left over, are checked
 * here. */
static fathom_status read_corners(gltf *g, const primitive *p, const uint32_t **out, uint32_t *count) {
    bool present;
    gltf_elements indices;
    *count = p->mesh.vertex_count;
    fathom_status status =
        gltf_array_read(g, p->at, "indices", 1, GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT, &present, &indices);
    if (status != FATHOM_OK) return status;
    if (!present) return count_up(g, p->at, *count, out);
    *out = indices.values, *count = indices.count;
    if (p->mode == MODE_TRIANGLES && *count % 3 == 0) return FATHOM_OK;
    status = mesh_check_indices(g->context, "entry", *out, *count, p->mesh.vertex_count);
    return gltf_within(g, p->at, "indices", status);
}

static fathom_status read_indices(gltf *g, primitive *p) {
    const uint32_t *corners = NULL;
    uint32_t count;
    fathom_status status = read_corners(g, p, &corners, &count);
    if (status != FATHOM_OK) return status;
    p->mesh.triangle_count = triangles_of(p->mode, count);
    if (!p->mesh.triangle_count || (p->mode == MODE_TRIANGLES && count % 3)) {
        gltf_note(g, p->at, NULL, "a mesh has vertices that make up no whole triangle; they are left out");
    }
    p->mesh.indices = corners;
    if (!p->mesh.triangle_count) return FATHOM_OK;
    if (p->mode != MODE_TRIANGLES)
        status = unroll(g, p->at, p->mode, corners, p->mesh.triangle_count, &p->mesh.indices);
    if (status != FATHOM_OK) return status;
    status = mesh_look_at_triangles(g->context, "entry", &p->mesh, &p->facts);
    return gltf_within(g, p->at, "indices", status);
}

/* Deforms an attribute by a shape, into `to` or, where that is NULL, into memory of its own. */
static fathom_status deform(gltf *g, const primitive *p, const gltf_shape *shape, const char *key,
                            gltf_kind kind, gltf_elements *floats, float *to) {
    fathom_status status = gltf_morph(g, p->at, shape, key, kind == GLTF_TANGENT ? 4 : 3, floats, to);
    if (status != FATHOM_OK || !shape->joints) return status;
    return gltf_skin_carry(g, p->attributes, shape->joints, kind, floats, to);
}

static fathom_status read_positions(gltf *g, primitive *p, bool *present) {
    gltf_elements floats;
    fathom_status status =
        gltf_array_read(g, p->attributes, "POSITION", 3,
                        GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED | GLTF_TAKES_UNSIGNED, present, &floats);
    if (status != FATHOM_OK || !*present) return status;
    p->positions = floats;
    status = deform(g, p, p->shapes, "POSITION", GLTF_POINT, &floats, NULL);
    if (status == FATHOM_OK && floats.values != p->positions.values)
        status = gltf_within(g, p->attributes, "POSITION",
                             mesh_look_at_vertices(g->context, "deformed entry", floats.values, floats.stride,
                                                   floats.count, &floats.facts));
    p->mesh.positions = floats.values;
    p->mesh.position_stride = floats.stride;
    p->mesh.vertex_count = floats.count;
    p->facts = floats.facts;
    return status;
}

/* Reads an attribute that has as many entries as POSITION. */
static fathom_status read_attribute(gltf *g, const primitive *p, const char *key, unsigned components,
                                    unsigned takes, bool *present, gltf_elements *out) {
    fathom_status status = gltf_array_read(g, p->attributes, key, components, takes, present, out);
    if (status != FATHOM_OK || !*present || out->count == p->mesh.vertex_count) return status;
    return gltf_fail(g, p->attributes, key, "has %u entries; expected as many as POSITION has, %u",
                     out->count, p->mesh.vertex_count);
}

static fathom_status make_normals(gltf *g, primitive *p) {
    const uint64_t sums = p->mesh.vertex_count * (uint64_t)NORMALS_SMOOTH_BYTES;
    void *normals;
    fathom_status status =
        gltf_allocate(g, p->at, NULL, (uint64_t)p->mesh.vertex_count * 3 * sizeof(float), &normals);
    if (status == FATHOM_OK) status = gltf_charge(g, p->at, NULL, sums);
    if (status != FATHOM_OK) return status;
    p->mesh.normals = normals;
    p->mesh.normal_count = p->mesh.vertex_count;
    status = normals_smooth(g->context, &p->mesh, NULL, p->mesh.vertex_count, normals);
    g->charged -= sums; /* it is freed by now */
    return status;
}

/* A mesh without normals is flat by the standard, unless smooth ones are asked for. */
static fathom_status read_normals(gltf *g, primitive *p) {
    gltf_elements floats;
    bool present;
    fathom_status status =
        read_attribute(g, p, "NORMAL", 3, GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED, &present, &floats);
    if (status != FATHOM_OK) return status;
    if (!present) return g->options->smooth ? make_normals(g, p) : FATHOM_OK;
    p->normals = floats;
    status = deform(g, p, p->shapes, "NORMAL", GLTF_NORMAL, &floats, NULL);
    p->mesh.normals = floats.values;
    p->mesh.normal_stride = floats.stride;
    p->mesh.normal_count = floats.count;
    return status;
}

/* Both sets, and tangents. */
static fathom_status read_coordinates(gltf *g, primitive *p) {
    const unsigned takes = GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED | GLTF_TAKES_UNSIGNED;
    gltf_elements floats;
    bool present;
    fathom_status status = read_attribute(g, p, "TEXCOORD_0", 2, takes, &present, &floats);
    if (status == FATHOM_OK && present)
        p->mesh.uvs = floats.values, p->mesh.uv_stride = floats.stride, p->mesh.uv_count = floats.count;
    if (status == FATHOM_OK) status = read_attribute(g, p, "TEXCOORD_1", 2, takes, &present, &floats);
    if (status == FATHOM_OK && present) p->mesh.uvs_1 = floats.values, p->mesh.uv_1_stride = floats.stride;
    if (status == FATHOM_OK)
        status = read_attribute(g, p, "TANGENT", 4, GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED, &present, &floats);
    if (status != FATHOM_OK || !present || !p->mesh.normals) return status;
    status = deform(g, p, p->shapes, "TANGENT", GLTF_TANGENT, &floats, NULL);
    p->mesh.tangents = floats.values, p->mesh.tangent_stride = floats.stride;
    return status;
}

/* Alpha counts for materials alone whose alphaMode lets it. */
static fathom_status read_colors(gltf *g, primitive *p) {
    const unsigned takes = GLTF_TAKES_FLOAT | GLTF_TAKES_UNSIGNED;
    gltf_elements floats;
    bool present;
    unsigned components = 0;
    fathom_status status = gltf_components(g, p->attributes, "COLOR_0", &components);
    if (status != FATHOM_OK || !components) return status;
    if (components < 3) components = 3; /* refused below */
    status = read_attribute(g, p, "COLOR_0", components, takes, &present, &floats);
    if (status != FATHOM_OK) return status;
    p->mesh.colors = floats.values;
    p->mesh.color_stride = floats.stride;
    p->mesh.color_channels = p->blends ? components : 3;
    return FATHOM_OK;
}

static fathom_status read_material(gltf *g, primitive *p) {
    p->mesh.flags = g->options->flags;
    p->mesh.material = g->options->material;
    if (p->mesh.material != FATHOM_NONE) return FATHOM_OK;
    uint32_t index = GLTF_ABSENT;
    gltf_material material;
    fathom_status status = gltf_index(g, p->at, "material", &g->materials, &index);
    if (status == FATHOM_OK) status = gltf_variant_material(g, p->at, &index);
    if (status == FATHOM_OK) status = gltf_material_make(g, index, &material);
    if (status != FATHOM_OK) return status;
    p->mesh.material = material.id;
    p->blends = material.blends;
    p->mesh.flags |= material.flags;
    return FATHOM_OK;
}

static fathom_status read_mode(gltf *g, const gltf_value *at, uint32_t *mode) {
    uint64_t value = MODE_TRIANGLES;
    fathom_status status = gltf_integer(g, at, "mode", 0, MODE_FAN, &value);
    *mode = (uint32_t)value;
    return status;
}

/* Each line's two ends, of a strip or a loop. */
static fathom_status unroll_lines(gltf *g, const primitive *p, const uint32_t *from, strokes *s) {
    void *memory;
    const uint32_t corners = s->count;
    s->count = p->mode == MODE_LINES ? corners / 2 : corners < 2 ? 0 : corners - (p->mode == MODE_LINE_STRIP);
    s->indices = from;
    if (p->mode == MODE_LINES || !s->count) return FATHOM_OK;
    fathom_status status = gltf_allocate(g, p->at, NULL, (uint64_t)s->count * 2 * sizeof(uint32_t), &memory);
    if (status != FATHOM_OK) return status;
    uint32_t *to = memory;
    for (uint32_t i = 0; i < s->count; ++i) to[2 * i] = from[i], to[2 * i + 1] = from[(i + 1) % corners];
    s->indices = to;
    return FATHOM_OK;
}

/* Makes triangles of points and lines. */
static fathom_status read_strokes(gltf *g, primitive *p) {
    const uint32_t *corners = NULL;
    strokes s = {.positions = p->mesh.positions,
                 .position_stride = p->mesh.position_stride,
                 .colors = p->mesh.colors,
                 .color_stride = p->mesh.color_stride,
                 .color_channels = p->mesh.color_channels,
                 .lines = p->mode != MODE_POINTS};
    fathom_status status = read_corners(g, p, &corners, &s.count);
    if (status != FATHOM_OK) return status;
    s.indices = corners;
    if (s.lines) status = unroll_lines(g, p, corners, &s);
    if (status == FATHOM_OK) status = gltf_charge(g, p->at, NULL, (uint64_t)s.count * STROKES_BYTES);
    if (status == FATHOM_OK) status = gltf_within(g, p->at, NULL, strokes_make(g->scene, &s, &p->mesh));
    if (status != FATHOM_OK) return status;
    gltf_note(g, p->at, "mode",
              s.lines ? "lines have no width, and are shown as thin rods"
                      : "points have no size, and are shown as small balls");
    if (!p->mesh.triangle_count) return FATHOM_OK;
    status = mesh_look_at_vertices(g->context, "entry", p->mesh.positions, p->mesh.position_stride,
                                   p->mesh.vertex_count, &p->facts);
    if (status == FATHOM_OK) status = mesh_look_at_triangles(g->context, "entry", &p->mesh, &p->facts);
    return gltf_within(g, p->at, NULL, status);
}

static fathom_status read_surface(gltf *g, primitive *p) {
    fathom_status status = read_indices(g, p);
    if (status != FATHOM_OK || !p->mesh.triangle_count) return status;
    if (!g->options->flat) status = read_normals(g, p);
    if (status == FATHOM_OK) status = read_material(g, p);
    if (status == FATHOM_OK && scene_keeps_uvs(g->scene)) status = read_coordinates(g, p);
    if (status == FATHOM_OK && g->options->material == FATHOM_NONE) status = read_colors(g, p);
    return status;
}

/* ---- motion ---- */

static fathom_status new_keys(gltf *g, const primitive *p, float **out) {
    void *rows;
    fathom_status status = gltf_allocate(
        g, p->at, NULL, g->moments.count * (uint64_t)p->mesh.vertex_count * 3 * sizeof(float), &rows);
    if (status == FATHOM_OK) *out = rows;
    return status;
}

/* Rows of an attribute at each moment. */
static fathom_status read_keys(gltf *g, const primitive *p, const char *key, gltf_kind kind,
                               const gltf_elements *stored, const float **out) {
    const size_t row = 3 * (size_t)p->mesh.vertex_count;
    float *rows = NULL;
    fathom_status status = new_keys(g, p, &rows);
    *out = rows;
    for (size_t k = 0; k < g->moments.count && status == FATHOM_OK; ++k, rows += row) {
        gltf_elements floats = *stored;
        status = deform(g, p, &p->shapes[k], key, kind, &floats, rows);
        for (size_t i = 0; floats.values == stored->values && i < p->mesh.vertex_count; ++i)
            memcpy(rows + 3 * i, (const char *)stored->values + i * stored->stride, 3 * sizeof *rows);
    }
    return status;
}

/* Smooth normals of the positions at each moment. */
static fathom_status make_key_normals(gltf *g, const primitive *p, const float **out) {
    const size_t row = 3 * (size_t)p->mesh.vertex_count;
    float *rows = NULL;
    fathom_status status = new_keys(g, p, &rows);
    *out = rows;
    for (size_t k = 0; k < g->moments.count && status == FATHOM_OK; ++k) {
        fathom_mesh then = p->mesh;
        then.positions = p->mesh.key_positions + k * row, then.position_stride = 3 * sizeof(float);
        status = normals_smooth(g->context, &then, NULL, then.vertex_count, rows + k * row);
    }
    return status;
}

static fathom_status move_vertices(gltf *g, primitive *p) {
    fathom_mesh *m = &p->mesh;
    fathom_status status = read_keys(g, p, "POSITION", GLTF_POINT, &p->positions, &m->key_positions);
    if (status == FATHOM_OK && p->normals.values)
        status = read_keys(g, p, "NORMAL", GLTF_NORMAL, &p->normals, &m->key_normals);
    else if (status == FATHOM_OK && m->normals)
        status = make_key_normals(g, p, &m->key_normals);
    if (status != FATHOM_OK) return status;
    m->key_count = (uint32_t)g->moments.count, m->key_times = g->key_times;
    return mesh_check_vertex_keys(g->context, m, &p->facts);
}

static fathom_status add_primitive(gltf *g, const gltf_value *at, const gltf_shape *shapes, bool moves,
                                   fathom_id group) {
    gltf_value attributes;
    primitive p = {.at = at, .attributes = &attributes, .shapes = shapes};
    fathom_mesh_default(&p.mesh);
    bool present = false;
    fathom_status status = gltf_object(g, at, "attributes", &attributes);
    if (status == FATHOM_OK) status = read_mode(g, at, &p.mode);
    if (status != FATHOM_OK) return status;
    status = gltf_draco_read(g, at);
    if (status != FATHOM_OK) return status;
    status = read_positions(g, &p, &present);
    if (status != FATHOM_OK) return status;
    if (!present) {
        gltf_note(g, at, NULL, "a mesh without POSITION is left out");
        return FATHOM_OK;
    }
    if (p.mode < MODE_TRIANGLES) {
        status = read_material(g, &p);
        if (status == FATHOM_OK && g->options->material == FATHOM_NONE) status = read_colors(g, &p);
        if (status == FATHOM_OK) status = read_strokes(g, &p);
        if (status == FATHOM_OK && moves)
            gltf_note(g, at, NULL,
                      "points and lines that a skin or morph targets move are not blurred; they stand as the "
                      "shutter opens");
    } else {
        status = read_surface(g, &p);
        if (status == FATHOM_OK && moves && p.mesh.triangle_count) status = move_vertices(g, &p);
    }
    if (status != FATHOM_OK || !p.mesh.triangle_count) return status;
    return gltf_within(g, at, NULL, scene_add_mesh_checked(g->scene, group, &p.mesh, &p.facts, NULL));
}

static fathom_status make_group(gltf *g, const gltf_value *mesh, const gltf_shape *shapes, bool moves,
                                fathom_id *out) {
    gltf_value primitives, at;
    const char *name = NULL;
    fathom_status status = gltf_text(g, mesh, "name", &name);
    if (status == FATHOM_OK) status = gltf_array(g, mesh, "primitives", &primitives);
    if (status == FATHOM_OK) status = fathom_scene_add_group(g->scene, name, out);
    if (status != FATHOM_OK) return status;
    size_t before = g->scene->meshes.count;
    for (size_t i = 0; i < gltf_count(&primitives) && status == FATHOM_OK; ++i) {
        status = gltf_item(g, &primitives, i, &at);
        if (status == FATHOM_OK) status = add_primitive(g, &at, shapes, moves, *out);
    }
    if (g->scene->meshes.count == before) *out = GLTF_EMPTY;
    return status;
}

fathom_status gltf_mesh_group(gltf *g, uint32_t index, const gltf_shape *shapes, fathom_id *out) {
    gltf_value mesh;
    gltf_shape own = {.weights = NULL};
    *out = g->mesh_table[index];
    if (!shapes && *out != FATHOM_NONE) return FATHOM_OK;
    fathom_status status = gltf_item(g, &g->meshes, index, &mesh);
    if (status == FATHOM_OK && shapes)
        return make_group(g, &mesh, shapes, gltf_shapes_move(shapes, g->moments.count), out);
    if (status == FATHOM_OK) status = gltf_weights_read(g, NULL, NULL, &mesh, &own);
    if (status == FATHOM_OK) status = make_group(g, &mesh, &own, false, out);
    free(own.weights);
    g->mesh_table[index] = *out;
    return status;
}
