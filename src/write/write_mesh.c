/* Converts meshes for formats with one index per vertex, and computes their positions in the world. */
#include "write/write.h"

#include "read/read.h"

#include "scene/motion/motion.h"

#include <stdlib.h>
#include <string.h>

/* ---- one index for each vertex: corners with the same position, normal and uv are merged ---- */

typedef struct welder {
    const fathom_mesh *mesh;
    uint32_t *newest;      /* for each position: the last vertex made for it; FATHOM_NONE: none */
    ARRAY(uint32_t) older; /* for each vertex: the previous vertex with the same position */
    ARRAY(uint32_t) positions;
    ARRAY(uint32_t) normals;
    ARRAY(uint32_t) uvs;
    uint32_t *indices;
} welder;

static bool push_vertex(welder *w, uint32_t p, uint32_t n, uint32_t t) {
    return w->positions.count < UINT32_MAX - 1 && array_push(&w->older, w->newest[p]) &&
           array_push(&w->positions, p) && array_push(&w->normals, n) && array_push(&w->uvs, t);
}

/* The chain has one vertex for each different pair of normal and uv at a position, so it is short. */
static bool weld_corner(welder *w, size_t corner) {
    const fathom_mesh *m = w->mesh;
    uint32_t p = m->indices[corner], n = m->normal_indices ? m->normal_indices[corner] : p;
    uint32_t t = m->uv_indices ? m->uv_indices[corner] : p, v = w->newest[p];
    while (v != FATHOM_NONE && (w->normals.items[v] != n || w->uvs.items[v] != t)) v = w->older.items[v];
    if (v == FATHOM_NONE) {
        if (!push_vertex(w, p, n, t)) return false;
        v = w->newest[p] = (uint32_t)(w->positions.count - 1);
    }
    w->indices[corner] = v;
    return true;
}

static fathom_status weld(fathom_context *context, const fathom_mesh *mesh, write_mesh *out) {
    size_t corners = (size_t)mesh->triangle_count * 3, head = mesh->vertex_count * sizeof(uint32_t);
    welder w = {.mesh = mesh, .newest = malloc(head), .indices = malloc(corners * sizeof *w.indices)};
    bool good = w.newest && w.indices;
    if (good) memset(w.newest, 0xff, head);
    for (size_t c = 0; c < corners && good; ++c) good = weld_corner(&w, c);
    free(w.newest);
    array_free(&w.older);
    *out = (write_mesh){.mesh = mesh,
                        .vertex_count = (uint32_t)w.positions.count,
                        .positions = w.positions.items,
                        .normals = w.normals.items,
                        .uvs = w.uvs.items,
                        .indices = w.indices};
    if (good) return FATHOM_OK;
    write_mesh_free(out);
    return fail_memory(context, corners * sizeof(uint32_t));
}

fathom_status write_mesh_prepare(fathom_context *context, const fathom_mesh *mesh, bool facets,
                                 write_mesh *out) {
    if (facets) {
        if (mesh->triangle_count > UINT32_MAX / 3) {
            return fail(context, FATHOM_OUT_OF_RESOURCES,
                        "a mesh of %u triangles without normals has too many corners for 32-bit indices",
                        mesh->triangle_count);
        }
        *out = (write_mesh){.mesh = mesh, .vertex_count = 3 * mesh->triangle_count, .facets = true};
        return FATHOM_OK;
    }
    if (mesh->normal_indices || mesh->uv_indices) return weld(context, mesh, out);
    *out = (write_mesh){.mesh = mesh, .vertex_count = mesh->vertex_count};
    return FATHOM_OK;
}

void write_mesh_free(write_mesh *m) {
    free(m->positions);
    free(m->normals);
    free(m->uvs);
    free(m->indices);
    *m = (write_mesh){.mesh = NULL};
}

static uint32_t position_index(const write_mesh *m, uint32_t vertex) {
    if (m->facets) return m->mesh->indices[vertex];
    return m->positions ? m->positions[vertex] : vertex;
}

vec3_f32 write_mesh_position(const write_mesh *m, uint32_t vertex) {
    return write_item(m->mesh->positions, m->mesh->position_stride, position_index(m, vertex));
}

static vec3_f32 facet_normal(const fathom_mesh *mesh, uint32_t triangle) {
    const uint32_t *t = mesh->indices + (size_t)triangle * 3;
    vec3_f64 p[3];
    for (int k = 0; k < 3; ++k) p[k] = widen(write_item(mesh->positions, mesh->position_stride, t[k]));
    return narrow(normalize_f64(cross_f64(sub_f64(p[1], p[0]), sub_f64(p[2], p[0]))));
}

vec3_f32 write_mesh_normal(const write_mesh *m, uint32_t vertex) {
    if (m->facets) return facet_normal(m->mesh, vertex / 3);
    return write_item(m->mesh->normals, m->mesh->normal_stride, m->normals ? m->normals[vertex] : vertex);
}

static void read_uv(const write_mesh *m, uint32_t vertex, float uv[2]) {
    uint32_t i = m->uvs ? m->uvs[vertex] : vertex;
    if (m->facets) i = m->mesh->uv_indices ? m->mesh->uv_indices[vertex] : m->mesh->indices[vertex];
    memcpy(uv, (const char *)m->mesh->uvs + m->mesh->uv_stride * i, 2 * sizeof *uv);
}

unsigned write_mesh_width(const fathom_mesh *mesh, mesh_kind kind) {
    const mesh_array a = mesh_array_of(mesh, kind);
    return a.values ? a.width : 0;
}

void write_mesh_entry(const write_mesh *m, mesh_kind kind, uint32_t vertex, float out[4]) {
    const mesh_array a = mesh_array_of(m->mesh, kind);
    if (kind == MESH_NORMALS)
        store_f32(out, write_mesh_normal(m, vertex));
    else if (kind == MESH_UVS)
        read_uv(m, vertex, out);
    else
        memcpy(out, (const char *)a.values + a.stride * position_index(m, vertex), a.width * sizeof *out);
    if (m->flips && (kind == MESH_UVS || kind == MESH_UVS_1)) out[1] = 1 - out[1];
}

bool write_flips(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->materials.count; ++i) {
        for (int k = 0; k < FATHOM_MAPS; ++k) {
            const fathom_map *map = &scene->materials.items[i].value.maps[k];
            if (map->texture != FATHOM_NONE) return map->transform[4] > 0;
        }
    }
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        if (scene->meshes.items[i].uvs) return !scene->mesh_facts.items[i].upwards;
    }
    return false;
}

bool write_flips_back(const fathom_scene *scene, uint32_t mesh) {
    return !scene->uses_uvs && scene->mesh_facts.items[mesh].upwards;
}

uint32_t write_mesh_index(const write_mesh *m, size_t corner) {
    if (m->facets) return (uint32_t)corner;
    return m->indices ? m->indices[corner] : m->mesh->indices[corner];
}

vec3_f32 write_unit(vec3_f32 v) {
    const double length = length_f64(widen(v));
    return length > 0 && fabs(length - 1) > 0.00674 ? narrow(normalize_f64(widen(v))) : v;
}

bool write_has_lengths(const fathom_mesh *mesh, mesh_kind kind) {
    const mesh_array a = mesh_array_of(mesh, kind);
    if (!a.values || (kind != MESH_NORMALS && kind != MESH_TANGENTS)) return false;
    for (uint32_t i = 0; i < a.count; ++i) {
        const vec3_f32 v = write_item(a.values, a.stride, i), unit = write_unit(v);
        if (unit.x != v.x || unit.y != v.y || unit.z != v.z) return true;
    }
    return false;
}

/* ---- instances ---- */

size_t write_add(size_t a, size_t b) { return a > SIZE_MAX - b ? SIZE_MAX : a + b; }
size_t write_multiply(size_t a, size_t b) { return b && a > SIZE_MAX / b ? SIZE_MAX : a * b; }

fathom_status write_count_ways(const fathom_scene *scene, const scene_graph *graph, size_t **out) {
    size_t *ways = calloc(scene->groups.count, sizeof *ways);
    *out = ways;
    if (!ways) return fail_memory(scene->context, scene->groups.count * sizeof *ways);
    ways[FATHOM_ROOT] = 1;
    for (uint32_t k = 0; k < graph->order_count; ++k) {
        uint32_t g = graph->order[k];
        for (uint32_t i = graph->instances.first[g]; i < graph->instances.first[g + 1]; ++i) {
            size_t *child = &ways[scene->instances.items[graph->instances.items[i]].group];
            *child = write_add(*child, ways[g]);
        }
    }
    return FATHOM_OK;
}

vec3_f32 write_placed_position(const write_placement *p, vec3_f32 position) {
    return p->plain ? position : narrow(affine_point(&p->map, widen(position)));
}

vec3_f32 write_placed_normal(const write_placement *p, vec3_f32 normal) {
    return p->plain ? normal : narrow(normalize_f64(affine_transposed_vector(&p->inverse, widen(normal))));
}

bool write_is_far(const scene_bounds *bounds) {
    const vec3_f64 origin = origin_for(bounds);
    return origin.x != 0 || origin.y != 0 || origin.z != 0;
}

typedef struct placer {
    const fathom_scene *scene;
    const scene_graph *graph;
    write_visit visit;
    void *user;
} placer;

/* The determinant after normalising the rows, which avoids overflow. Only its sign is used. */
static double determinant(const affine_f64 *a) {
    vec3_f64 x = {a->m[0][0], a->m[0][1], a->m[0][2]}, y = {a->m[1][0], a->m[1][1], a->m[1][2]};
    vec3_f64 z = {a->m[2][0], a->m[2][1], a->m[2][2]};
    return dot_f64(cross_f64(normalize_f64(x), normalize_f64(y)), normalize_f64(z));
}

static fathom_status place_object(const placer *p, fathom_id id, const affine_f64 *to_world,
                                  fathom_id material) {
    scene_object object = p->scene->objects.items[id];
    if (object.kind != SCENE_MESH) return FATHOM_OK;
    const fathom_mesh *mesh = &p->scene->meshes.items[object.index];
    affine_f64 origin = affine_translation(load_f64(mesh->origin));
    write_placement placed = {.object = id, .mesh = mesh, .mesh_index = object.index};
    placed.map = affine_compose(to_world, &origin);
    placed.material = material != FATHOM_NONE ? material : mesh->material;
    placed.plain = affine_is_identity(&placed.map);
    placed.mirrored = determinant(&placed.map) < 0;
    if (!affine_invert(&placed.map, &placed.inverse)) {
        return fail(p->scene->context, FATHOM_BAD_INPUT,
                    "object %u: the frames around it flatten space or leave the range of numbers", id);
    }
    return p->visit(p->user, &placed);
}

static fathom_status place_group(const placer *p, uint32_t group, const affine_f64 *to_world,
                                 fathom_id material) {
    fathom_status status = FATHOM_OK;
    const graph_lists *objects = &p->graph->objects, *instances = &p->graph->instances;
    for (uint32_t i = objects->first[group]; i < objects->first[group + 1] && status == FATHOM_OK; ++i)
        status = place_object(p, objects->items[i], to_world, material);
    for (uint32_t i = instances->first[group]; i < instances->first[group + 1] && status == FATHOM_OK; ++i) {
        const fathom_instance *instance = &p->scene->instances.items[instances->items[i]];
        affine_f64 map = motion_place(instance, p->scene->camera.shutter[0]);
        map = affine_compose(to_world, &map);
        status =
            place_group(p, instance->group, &map, material != FATHOM_NONE ? material : instance->material);
    }
    return status;
}

fathom_status write_each_placement(const fathom_scene *scene, const scene_graph *graph, write_visit visit,
                                   void *user) {
    placer p = {scene, graph, visit, user};
    affine_f64 identity = affine_identity();
    return place_group(&p, FATHOM_ROOT, &identity, FATHOM_NONE);
}
