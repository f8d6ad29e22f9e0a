/* Makes each mesh a group, with a mesh of the scene for each primitive. */
#include "read/gltf/gltf_mesh.h"
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_material.h"
#include "read/mesh/normals.h"
#include "read/mesh/strokes.h"
#include "read/read.h"
#include "scene/mesh/mesh_array.h"

#include <string.h>

enum { MODE_POINTS, MODE_LINES, MODE_LOOP, MODE_LINE_STRIP, MODE_TRIANGLES, MODE_STRIP, MODE_FAN };

typedef struct primitive {
    const gltf_value *at;
    const gltf_value *attributes;
    const gltf_shape *shapes; /* at each moment */
    uint64_t mode;
    bool blends;                      /* the material uses alpha */
    gltf_elements positions, normals; /* as in the file; values NULL: none */
    fathom_mesh mesh;
    mesh_facts facts;
} primitive;

/* The facts about vertices that are not those of the file. */
static void look_at(gltf *g, primitive *p) {
    gltf_within(g, p->at, NULL,
                mesh_look_at_vertices(g->context, "entry", p->mesh.positions, p->mesh.position_stride,
                                      p->mesh.vertex_count, &p->facts));
    if (gltf_fine(g))
        gltf_within(g, p->at, NULL, mesh_look_at_triangles(g->context, "entry", &p->mesh, &p->facts));
}

static uint32_t *new_indices(gltf *g, const gltf_value *at, uint64_t count) {
    void *memory;
    gltf_allocate(g, at, NULL, count * sizeof(uint32_t), &memory);
    return memory;
}

/* 0, 1, 2… for a primitive without indices. */
static const uint32_t *count_up(gltf *g, const gltf_value *at, uint32_t count) {
    uint32_t *indices = new_indices(g, at, count);
    for (uint32_t i = 0; indices && i < count; ++i) indices[i] = i;
    return indices;
}

/* Turns a strip or fan into triangles. Triangle i of a strip is i, then the next two in the order that keeps
 * the winding of triangle 0; of a fan, the vertices i + 1, i + 2 and 0. */
static const uint32_t *unroll(gltf *g, const gltf_value *at, uint64_t mode, const uint32_t *from,
                              uint32_t triangles) {
    uint32_t *indices = new_indices(g, at, (uint64_t)triangles * 3), *to = indices;
    for (uint32_t i = 0; indices && i < triangles; ++i, to += 3) {
        bool strip = mode == MODE_STRIP;
        to[0] = from[strip ? i : i + 1];
        to[1] = from[strip ? i + 1 + i % 2 : i + 2];
        to[2] = from[strip ? i + 2 - i % 2 : 0];
    }
    return indices;
}

static uint32_t triangles_of(uint64_t mode, uint32_t corners) {
    return mode == MODE_TRIANGLES ? corners / 3 : corners < 3 ? 0 : corners - 2;
}

/* The indices of mode TRIANGLES are checked later, if their number is a multiple of 3. All others are checked
 * here. NULL: points without indices, or reading has failed. */
static const uint32_t *read_corners(gltf *g, const primitive *p, uint32_t *count) {
    gltf_elements indices;
    *count = p->mesh.vertex_count;
    if (!gltf_array_read(g, p->at, "indices", 1, GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT, &indices))
        return gltf_fine(g) && p->mode != MODE_POINTS ? count_up(g, p->at, *count) : NULL;
    *count = indices.count;
    if (p->mode != MODE_TRIANGLES || *count % 3)
        gltf_within(g, p->at, "indices",
                    mesh_check_indices(g->context, "entry", indices.values, *count, p->mesh.vertex_count));
    return indices.values;
}

static void read_indices(gltf *g, primitive *p) {
    uint32_t count;
    const uint32_t *corners = read_corners(g, p, &count);
    if (!gltf_fine(g)) return;
    p->mesh.triangle_count = triangles_of(p->mode, count);
    if (!p->mesh.triangle_count || (p->mode == MODE_TRIANGLES && count % 3))
        gltf_note(g, p->at, NULL, "a mesh has vertices that do not complete a triangle; they are left out");
    p->mesh.indices = corners;
    if (!p->mesh.triangle_count) return;
    if (p->mode != MODE_TRIANGLES)
        p->mesh.indices = unroll(g, p->at, p->mode, corners, p->mesh.triangle_count);
    if (gltf_fine(g))
        gltf_within(g, p->at, "indices", mesh_look_at_triangles(g->context, "entry", &p->mesh, &p->facts));
}

/* Deforms an attribute by a shape, into `to`, or into new memory if `to` is NULL. */
static void deform(gltf *g, const primitive *p, const gltf_shape *shape, const char *key, gltf_kind kind,
                   gltf_elements *floats, float *to) {
    const void *stored = floats->values;
    gltf_morph(g, p->at, shape, key, kind == GLTF_TANGENT ? 4 : 3, floats, to);
    if (shape->joints && gltf_fine(g)) gltf_skin_carry(g, p->attributes, shape->joints, kind, floats, to);
    if (!to && kind != GLTF_POINT && floats->values != stored && gltf_fine(g))
        gltf_within(g, p->attributes, key,
                    mesh_check_finite(g->context, "deformed entry", floats->values, floats->stride,
                                      kind == GLTF_TANGENT ? 4 : 3, floats->count));
}

static void read_positions(gltf *g, primitive *p) {
    gltf_elements floats;
    if (!gltf_array_read(g, p->attributes, "POSITION", 3, GLTF_TAKES_QUANTIZED, &floats)) return;
    p->positions = floats;
    deform(g, p, p->shapes, "POSITION", GLTF_POINT, &floats, NULL);
    if (gltf_fine(g) && floats.values != p->positions.values)
        gltf_within(g, p->attributes, "POSITION",
                    mesh_look_at_vertices(g->context, "deformed entry", floats.values, floats.stride,
                                          floats.count, &floats.facts));
    p->mesh.positions = floats.values;
    p->mesh.position_stride = floats.stride;
    p->mesh.vertex_count = floats.count;
    p->facts = floats.facts;
}

/* Reads an attribute, and checks that it has an entry for each vertex. */
static bool read_attribute(gltf *g, const primitive *p, const char *key, unsigned components, unsigned takes,
                           gltf_elements *out) {
    if (!gltf_array_read(g, p->attributes, key, components, takes, out)) return false;
    const bool enough = out->count >= p->mesh.vertex_count;
    if (out->count != p->mesh.vertex_count)
        gltf_note(g, p->attributes, key, "%s has another number of entries than POSITION; %s", key,
                  enough ? "those beyond are left out" : "it is left out");
    out->count = p->mesh.vertex_count;
    return enough && gltf_fine(g);
}

static void make_normals(gltf *g, primitive *p) {
    const uint64_t sums = p->mesh.vertex_count * (uint64_t)NORMALS_SMOOTH_BYTES;
    void *normals;
    gltf_allocate(g, p->at, NULL, (uint64_t)p->mesh.vertex_count * 3 * sizeof(float), &normals);
    if (gltf_charge(g, p->at, NULL, sums) != FATHOM_OK) return;
    p->mesh.normals = normals;
    p->mesh.normal_count = p->mesh.vertex_count;
    g->status = normals_smooth(g->context, &p->mesh, NULL, p->mesh.vertex_count, normals);
    g->charged[g->posing] -= sums; /* normals_smooth() has freed it */
}

/* By the standard, a mesh without normals is flat. The option `smooth` makes smooth normals. */
static void read_normals(gltf *g, primitive *p) {
    gltf_elements floats;
    if (!read_attribute(g, p, "NORMAL", 3, GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED, &floats)) {
        if (gltf_fine(g) && g->options->smooth) make_normals(g, p);
        return;
    }
    p->normals = floats;
    deform(g, p, p->shapes, "NORMAL", GLTF_NORMAL, &floats, NULL);
    p->mesh.normals = floats.values;
    p->mesh.normal_stride = floats.stride;
    p->mesh.normal_count = floats.count;
}

/* Reads both sets of texture coordinates, and tangents. */
static void read_coordinates(gltf *g, primitive *p) {
    gltf_elements floats;
    if (read_attribute(g, p, "TEXCOORD_0", 2, GLTF_TAKES_QUANTIZED, &floats))
        p->mesh.uvs = floats.values, p->mesh.uv_stride = floats.stride, p->mesh.uv_count = floats.count;
    if (read_attribute(g, p, "TEXCOORD_1", 2, GLTF_TAKES_QUANTIZED, &floats))
        p->mesh.uvs_1 = floats.values, p->mesh.uv_1_stride = floats.stride;
    if (!read_attribute(g, p, "TANGENT", 4, GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED, &floats) ||
        !p->mesh.normals)
        return;
    deform(g, p, p->shapes, "TANGENT", GLTF_TANGENT, &floats, NULL);
    p->mesh.tangents = floats.values, p->mesh.tangent_stride = floats.stride;
}

/* Colours also multiply a material that replaces the file's. Alpha is used only for materials of the file
 * whose alphaMode is not OPAQUE. */
static void read_colors(gltf *g, primitive *p) {
    gltf_elements floats;
    unsigned components = gltf_components(g, p->attributes, "COLOR_0");
    if (!components) return;
    if (components < 3) components = 3; /* read_attribute() rejects it */
    if (!read_attribute(g, p, "COLOR_0", components, GLTF_TAKES_FLOAT | GLTF_TAKES_UNSIGNED, &floats)) return;
    p->mesh.colors = floats.values;
    p->mesh.color_stride = floats.stride;
    p->mesh.color_channels = p->blends ? components : 3;
}

static void read_material(gltf *g, primitive *p) {
    p->mesh.flags = g->options->flags;
    p->mesh.material = g->options->material;
    if (p->mesh.material != FATHOM_NONE) return;
    uint32_t index = GLTF_ABSENT;
    gltf_material material;
    gltf_index(g, p->at, "material", &g->materials, &index);
    gltf_variant_material(g, p->at, &index);
    if (!gltf_material_make(g, index, &material)) return;
    p->mesh.material = material.id;
    p->blends = material.blends;
    p->mesh.flags |= material.flags;
}

/* Makes two indices for each line of a strip or a loop. */
static void unroll_lines(gltf *g, const primitive *p, const uint32_t *from, strokes *s) {
    const uint32_t corners = s->count;
    s->count = p->mode == MODE_LINES ? corners / 2
               : corners < 2         ? 0
                                     : corners - (p->mode == MODE_LINE_STRIP ? 1 : 0);
    if (p->mode == MODE_LINES || !s->count) return;
    uint32_t *to = new_indices(g, p->at, (uint64_t)s->count * 2);
    for (uint32_t i = 0; to && i < s->count; ++i)
        to[2 * i] = from[i], to[2 * i + 1] = from[(i + 1) % corners];
    s->indices = to;
}

/* Points and lines have the normals of their spheres and rods, and no textures. */
static void note_unread(gltf *g, const primitive *p) {
    static const char *const keys[] = {"NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; ++i) {
        if (gltf_components(g, p->attributes, keys[i]))
            gltf_note(g, p->attributes, keys[i], "%s of points and lines is left out", keys[i]);
    }
}

/* Turns points into a point cloud, and lines into triangles. */
static void read_strokes(gltf *g, primitive *p) {
    strokes s = {.positions = p->mesh.positions,
                 .position_stride = p->mesh.position_stride,
                 .colors = p->mesh.colors,
                 .color_stride = p->mesh.color_stride,
                 .color_channels = p->mesh.color_channels,
                 .lines = p->mode != MODE_POINTS,
                 .notes = &g->notes};
    s.indices = read_corners(g, p, &s.count);
    if (s.lines && gltf_fine(g)) unroll_lines(g, p, s.indices, &s);
    if (s.indices) gltf_charge(g, p->at, NULL, (uint64_t)s.count * (s.lines ? ROD_BYTES : POINT_BYTES));
    if (gltf_fine(g)) gltf_within(g, p->at, NULL, strokes_make(g->scene, &s, &p->mesh));
    if (!gltf_fine(g)) return;
    gltf_note(g, p->at, "mode",
              s.lines ? "lines have no width, and are shown as thin rods"
                      : "points have no size, and are shown as small spheres");
    if (!strokes_any(&p->mesh)) return;
    look_at(g, p);
}

static void read_surface(gltf *g, primitive *p) {
    read_indices(g, p);
    if (!gltf_fine(g) || !p->mesh.triangle_count) return;
    if (!g->options->flat) read_normals(g, p);
    read_material(g, p);
    if (scene_keeps_uvs(g->scene)) read_coordinates(g, p);
    read_colors(g, p);
}

/* ---- motion ---- */

static float *new_keys(gltf *g, const primitive *p) {
    void *rows;
    gltf_allocate(g, p->at, NULL, g->moments.count * (uint64_t)p->mesh.vertex_count * 3 * sizeof(float),
                  &rows);
    return rows;
}

/* Rows of an attribute at each moment. */
static float *read_keys(gltf *g, const primitive *p, const char *key, gltf_kind kind,
                        const gltf_elements *stored) {
    const size_t row = 3 * (size_t)p->mesh.vertex_count;
    float *all = new_keys(g, p), *rows = all;
    for (size_t k = 0; k < g->moments.count && gltf_fine(g); ++k, rows += row) {
        gltf_elements floats = *stored;
        deform(g, p, &p->shapes[k], key, kind, &floats, rows);
        for (size_t i = 0; floats.values == stored->values && i < p->mesh.vertex_count; ++i)
            memcpy(rows + 3 * i, (const char *)stored->values + i * stored->stride, 3 * sizeof *rows);
    }
    return all;
}

/* Smooth normals of the positions at each moment. */
static const float *make_key_normals(gltf *g, const primitive *p) {
    const size_t row = 3 * (size_t)p->mesh.vertex_count;
    float *rows = new_keys(g, p);
    for (size_t k = 0; k < g->moments.count && gltf_fine(g); ++k) {
        fathom_mesh then = p->mesh;
        then.positions = p->mesh.key_positions + k * row, then.position_stride = 3 * sizeof(float);
        g->status = normals_smooth(g->context, &then, NULL, then.vertex_count, rows + k * row);
    }
    return rows;
}

static void move_vertices(gltf *g, primitive *p) {
    fathom_mesh *m = &p->mesh;
    m->key_positions = read_keys(g, p, "POSITION", GLTF_POINT, &p->positions);
    if (p->normals.values)
        m->key_normals = read_keys(g, p, "NORMAL", GLTF_NORMAL, &p->normals);
    else if (m->normals)
        m->key_normals = make_key_normals(g, p);
    m->key_count = (uint32_t)g->moments.count, m->key_times = g->key_times;
    if (gltf_fine(g)) gltf_within(g, p->at, NULL, mesh_check_vertex_keys(g->context, m, &p->facts));
}

/* Sets the positions of points and lines to those of the middle of the shutter time. As gltf_way_middle(). */
static void hold_vertices(gltf *g, primitive *p) {
    const size_t row = 3 * (size_t)p->mesh.vertex_count, moments = g->moments.count;
    float *rows = read_keys(g, p, "POSITION", GLTF_POINT, &p->positions);
    float *middle = gltf_fine(g) ? rows + moments / 2 * row : NULL;
    for (size_t i = 0; middle && moments == 2 && i < row; ++i) middle[i] = (rows[i] + middle[i]) / 2;
    p->mesh.positions = middle, p->mesh.position_stride = 3 * sizeof *middle;
    gltf_note(g, p->at, NULL,
              "points and lines that a skin or morph targets move are not blurred; they are shown as "
              "they are in the middle of the shutter time");
}

static uint64_t bytes_of(const fathom_mesh *mesh) {
    uint64_t row = 0;
    for (int kind = 0; kind < MESH_ARRAYS; ++kind) {
        const mesh_array a = mesh_array_of(mesh, (mesh_kind)kind);
        row += a.values ? a.width * sizeof(float) : 0;
    }
    return row * mesh->vertex_count + 3 * sizeof(uint32_t) * (uint64_t)mesh->triangle_count;
}

/* Removes unused vertices: primitives may share large arrays. */
static void compact(gltf *g, primitive *p) {
    bool copied;
    gltf_within(g, p->at, NULL, mesh_compact(g->scene, false, &p->facts, &p->mesh, &copied));
    if (!gltf_fine(g) || !copied || gltf_charge(g, p->at, NULL, bytes_of(&p->mesh)) != FATHOM_OK) return;
    look_at(g, p);
}

static void add_missing_uvs(gltf *g, primitive *p) {
    uint64_t added = 0;
    gltf_within(g, p->at, NULL, read_missing_uvs(g->scene, &p->mesh, &added));
    if (!added || gltf_charge(g, p->at, NULL, added) != FATHOM_OK) return;
    gltf_note(g, p->at, NULL, READ_MISSING_UVS);
}

static void add_primitive(gltf *g, const gltf_value *at, const gltf_shape *shapes, bool moves,
                          fathom_id group) {
    gltf_value attributes;
    primitive p = {.at = at, .attributes = &attributes, .shapes = shapes, .mode = MODE_TRIANGLES};
    fathom_mesh_default(&p.mesh);
    gltf_object(g, at, "attributes", &attributes);
    gltf_integer(g, at, "mode", 0, MODE_FAN, &p.mode);
    gltf_draco_read(g, at);
    read_positions(g, &p);
    if (gltf_fine(g)) gltf_morph_note(g, at, shapes, moves ? g->moments.count : 1);
    if (!gltf_fine(g)) return;
    if (!p.positions.values) {
        gltf_note(g, at, NULL, "a mesh without POSITION is left out");
    } else if (p.mode < MODE_TRIANGLES) {
        read_material(g, &p);
        read_colors(g, &p);
        if (gltf_fine(g) && moves) hold_vertices(g, &p);
        if (gltf_fine(g)) read_strokes(g, &p);
        note_unread(g, &p);
    } else {
        read_surface(g, &p);
        if (gltf_fine(g) && moves && p.mesh.triangle_count) move_vertices(g, &p);
        if (gltf_fine(g)) compact(g, &p);
    }
    if (!gltf_fine(g) || !strokes_any(&p.mesh)) return;
    add_missing_uvs(g, &p);
    if (gltf_fine(g)) gltf_within(g, at, NULL, strokes_add(g->scene, group, &p.mesh, &p.facts, &g->notes));
}

fathom_id gltf_mesh_group(gltf *g, uint32_t index, const gltf_shape *shapes, bool moves) {
    gltf_value mesh, primitives, at;
    const char *name = NULL;
    fathom_id group = GLTF_EMPTY;
    gltf_item(g, &g->meshes, index, &mesh);
    gltf_text(g, &mesh, "name", &name);
    gltf_array(g, &mesh, "primitives", &primitives);
    g->posing = shapes->weight_count || shapes->joints;
    if (gltf_fine(g)) g->status = fathom_scene_add_group(g->scene, name, &group);
    const size_t before = g->scene->meshes.count;
    for (size_t i = 0; i < gltf_count(&primitives) && gltf_fine(g); ++i) {
        gltf_item(g, &primitives, i, &at);
        add_primitive(g, &at, shapes, moves, group);
    }
    g->posing = false, g->unpacked = 0;
    return g->scene->meshes.count > before ? group : GLTF_EMPTY;
}
