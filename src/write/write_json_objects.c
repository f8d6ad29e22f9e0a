/* Groups and objects of scene JSON: meshes with their arrays, other shapes, instances. */
#include "write/write_json.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const form_object_values usual = {.casts_shadow = true,
                                         .place.matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};

/* ---- meshes ---- */

/* Rows of one array of a mesh: `count` numbers each, starting at number `from`. */
typedef struct rows {
    const write_mesh *mesh;
    mesh_kind kind;
    unsigned from, count;
    const double *origin; /* added in double; NULL: floats are written unchanged */
    const form_key *key;
    size_t *changed; /* counts the numbers that the reader would refuse */
} rows;

enum { NUMBER_MOST = WRITE_NUMBER_BYTES, ROW_MOST = 4 * NUMBER_MOST + 4 };

static size_t put_row_start(char *out, size_t row) {
    size_t length = 0;
    if (row) out[length++] = ',';
    out[length++] = '[';
    return length;
}

static size_t format_rows(const void *user, size_t begin, size_t end, char *out) {
    const rows *r = user;
    char *start = out;
    for (size_t i = begin; i < end; ++i) {
        float v[4];
        write_mesh_entry(r->mesh, r->kind, (uint32_t)i, v);
        out += put_row_start(out, i);
        for (unsigned k = 0; k < r->count; ++k) {
            const double own = (double)v[r->from + k], number = r->origin ? r->origin[k] + own : own;
            const double near = form_nearest(r->key, number, !r->origin);
            if (near != number) __atomic_fetch_add(r->changed, 1, __ATOMIC_RELAXED);
            if (k) *out++ = ',';
            if (r->origin)
                out += snprintf(out, NUMBER_MOST, "%.17g", near);
            else
                out += write_float(out, (float)near);
        }
        *out++ = ']';
    }
    return (size_t)(out - start);
}

static const form_key *mesh_key(const char *name) {
    return form_find(form_variant(&form_object, FORM_MESH), name);
}

static void put_rows(json_out *o, const char *name, rows r) {
    size_t changed = 0;
    r.key = mesh_key(name), r.changed = &changed;
    file_writer_print(o->stream.file, ",\n\"%s\":[", name);
    write_items(&o->stream, r.mesh->vertex_count, ROW_MOST, format_rows, &r);
    file_writer_print(o->stream.file, "]");
    form_note_nearest(r.key, changed, o->notes);
}

static size_t format_triangles(const void *user, size_t begin, size_t end, char *out) {
    const write_mesh *m = user;
    char *start = out;
    for (size_t i = begin; i < end; ++i) {
        out += put_row_start(out, i);
        for (size_t k = 0; k < 3; ++k) {
            if (k) *out++ = ',';
            out += write_integer(out, write_mesh_index(m, 3 * i + k));
        }
        *out++ = ']';
    }
    return (size_t)(out - start);
}

/* Numbers are written as floats, which are short, unless the mesh has an origin or its reader will choose
 * one. The reader then converts to its origin in double; only the full number in double gives the same float
 * again. */
static const double *origin_of(const fathom_scene *scene, fathom_id object, const fathom_mesh *mesh) {
    const scene_bounds box = scene_object_bounds(scene, object);
    const vec3_f64 own = load_f64(mesh->origin);
    const bool plain = !write_is_far(&box) && own.x == 0 && own.y == 0 && own.z == 0;
    return plain ? NULL : mesh->origin;
}

/* Writes the vertices at each key. A key has an entry for each of the mesh's own vertices, so it is written
 * like a mesh without motion. */
static void put_keys(json_out *o, const write_mesh *m, const double *origin) {
    const fathom_mesh *mesh = m->mesh;
    for (uint32_t k = 0; k < mesh->key_count; ++k) {
        fathom_mesh then = *mesh;
        write_mesh at = *m;
        at.mesh = &then;
        then.positions = mesh->key_positions + (size_t)3 * k * mesh->vertex_count;
        then.position_stride = then.normal_stride = 3 * sizeof(float);
        if (mesh->normals) then.normals = mesh->key_normals + (size_t)3 * k * mesh->normal_count;
        file_writer_print(o->stream.file, "%s{\"time\":", k ? ",\n" : ",\n\"vertexKeys\":[");
        form_put_number(o->stream.file, mesh->key_times[k]);
        put_rows(o, "positions", (rows){.mesh = &at, .kind = MESH_POSITIONS, .count = 3, .origin = origin});
        if (mesh->normals) put_rows(o, "normals", (rows){.mesh = &at, .kind = MESH_NORMALS, .count = 3});
        file_writer_print(o->stream.file, "}");
    }
    if (mesh->key_count) file_writer_print(o->stream.file, "]");
}

static fathom_status put_mesh(json_out *o, fathom_id object, const fathom_mesh *mesh) {
    static const struct {
        const char *key;
        mesh_kind kind;
        unsigned from, count;
    } arrays[] = {{"normals", MESH_NORMALS, 0, 3},  {"uvs", MESH_UVS, 0, 2},
                  {"uvs1", MESH_UVS_1, 0, 2},       {"colors", MESH_COLORS, 0, 3},
                  {"opacities", MESH_COLORS, 3, 1}, {"tangents", MESH_TANGENTS, 0, 4}};
    const double *origin = origin_of(o->scene, object, mesh);
    write_mesh m;
    fathom_status status = write_mesh_prepare(o->scene->context, mesh, false, &m);
    if (status != FATHOM_OK) return status;
    m.flips = write_flips_back(o->scene, o->scene->objects.items[object].index);
    put_rows(o, "positions", (rows){.mesh = &m, .kind = MESH_POSITIONS, .count = 3, .origin = origin});
    if (mesh->point_radius > 0) {
        file_writer_print(o->stream.file, ",\n\"pointRadius\":");
        form_put_numbers(o->stream.file, mesh_key("pointRadius"), &mesh->point_radius, o->notes);
    } else {
        file_writer_print(o->stream.file, ",\n\"indices\":[");
        write_items(&o->stream, mesh->triangle_count, ROW_MOST, format_triangles, &m);
        file_writer_print(o->stream.file, "]");
    }
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; ++i) {
        if (write_mesh_width(mesh, arrays[i].kind) > arrays[i].from)
            put_rows(
                o, arrays[i].key,
                (rows){.mesh = &m, .kind = arrays[i].kind, .from = arrays[i].from, .count = arrays[i].count});
    }
    put_keys(o, &m, origin);
    write_mesh_free(&m);
    return FATHOM_OK;
}

/* ---- objects ---- */

static form_object_id object_id(scene_kind kind) {
    switch (kind) {
    case SCENE_SPHERE: return FORM_SPHERE;
    case SCENE_QUAD: return FORM_QUAD;
    case SCENE_PLANE: return FORM_PLANE;
    case SCENE_MESH: return FORM_MESH;
    }
    return FORM_MESH;
}

/* Returns the flags. */
static unsigned set_shape(const fathom_scene *scene, const scene_object *object, form_object_values *v) {
    switch (object->kind) {
    case SCENE_SPHERE: v->as.sphere = scene->spheres.items[object->index]; return v->as.sphere.flags;
    case SCENE_PLANE: v->as.plane = scene->planes.items[object->index]; return v->as.plane.flags;
    case SCENE_MESH: return scene->meshes.items[object->index].flags;
    case SCENE_QUAD: {
        const fathom_quad *quad = &scene->quads.items[object->index];
        memcpy(v->as.quad.corners, quad->corners, sizeof quad->corners);
        return quad->flags;
    }
    }
    return 0;
}

static fathom_status put_object(json_out *o, fathom_id id, const char **comma) {
    const scene_object *object = &o->scene->objects.items[id];
    const fathom_id material = scene_object_material(o->scene, id);
    fathom_status status = FATHOM_OK;
    char numbered[SCENE_NUMBERED];
    form_object_values v = usual;
    v.name = object->name || !o->numbered[object->group] ? object->name : scene_numbered(object, numbered);
    v.material = material ? o->materials[material] : NULL;
    v.light_group = json_light_group(o->scene, FATHOM_SOURCE_OBJECT, id);
    v.casts_shadow = !(set_shape(o->scene, object, &v) & FATHOM_CASTS_NO_SHADOW);
    file_writer_print(o->stream.file, "%s\n{", *comma);
    form_put(o->stream.file, form_variant(&form_object, (int)object_id(object->kind)), &v, &usual, o->notes);
    if (object->kind == SCENE_MESH) status = put_mesh(o, id, &o->scene->meshes.items[object->index]);
    file_writer_print(o->stream.file, "}");
    *comma = ",";
    return status;
}

static void put_motion(file_writer *t, const fathom_instance *instance) {
    for (uint32_t k = 0; k < instance->key_count; ++k) {
        file_writer_print(t, "%s{\"time\":", k ? "," : ",\"motion\":[");
        form_put_number(t, instance->key_times[k]);
        file_writer_print(t, ",\"matrix\":");
        json_put_matrix(t, instance->key_transforms + (size_t)12 * k);
        file_writer_print(t, "}");
    }
    if (instance->key_count) file_writer_print(t, "]");
}

static void put_instance(json_out *o, const fathom_instance *instance, const char **comma) {
    form_object_values v = usual;
    v.material = instance->material != FATHOM_NONE ? o->materials[instance->material] : NULL;
    v.name = instance->name;
    v.as.instance.of = o->groups[instance->group];
    for (int i = 0; i < 12 && !instance->key_count; ++i)
        v.place.matrix[i % 4 * 4 + i / 4] = instance->transform[i];
    file_writer_print(o->stream.file, "%s\n{", *comma);
    form_put(o->stream.file, form_variant(&form_object, FORM_INSTANCE), &v, &usual, o->notes);
    put_motion(o->stream.file, instance);
    file_writer_print(o->stream.file, "}");
    *comma = ",";
}

static fathom_status put_group(json_out *o, uint32_t group) {
    const graph_lists *objects = &o->graph->objects, *instances = &o->graph->instances;
    const char *comma = "";
    fathom_status status = FATHOM_OK;
    file_writer_print(o->stream.file, "[");
    for (uint32_t i = objects->first[group]; i < objects->first[group + 1] && status == FATHOM_OK; ++i)
        status = put_object(o, objects->items[i], &comma);
    for (uint32_t i = instances->first[group]; i < instances->first[group + 1]; ++i)
        put_instance(o, &o->scene->instances.items[instances->items[i]], &comma);
    file_writer_print(o->stream.file, "]");
    return status;
}

/* The file's groups need names, and shapes come in another order. Shapes that Cryptomatte knows by kind and
 * number keep these as their names. */
static fathom_status find_numbered(json_out *o) {
    const fathom_scene *scene = o->scene;
    const size_t count = scene->groups.count;
    o->numbered = calloc(count, sizeof *o->numbered);
    if (!o->numbered) return fail_memory(scene->context, count * sizeof *o->numbered);
    for (size_t g = 0; g < count && count > 1; ++g)
        o->numbered[g] = g == FATHOM_ROOT || !scene->groups.items[g] || !*scene->groups.items[g];
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const fathom_instance *instance = &scene->instances.items[i];
        if (instance->name && *instance->name) o->numbered[instance->group] = false;
    }
    return FATHOM_OK;
}

fathom_status json_put_objects(json_out *o) {
    file_writer *t = o->stream.file;
    fathom_status status = find_numbered(o);
    const size_t count = o->scene->groups.count;
    if (status != FATHOM_OK) return status;
    if (count > 1) file_writer_print(t, ",\n\"groups\":{");
    for (uint32_t g = FATHOM_ROOT + 1; g < count && status == FATHOM_OK; ++g) {
        file_writer_print(t, g > FATHOM_ROOT + 1 ? ",\n" : "\n");
        write_quoted(t, o->groups[g]);
        file_writer_print(t, ":");
        status = put_group(o, g);
    }
    if (count > 1) file_writer_print(t, "}");
    file_writer_print(t, ",\n\"objects\":");
    return status == FATHOM_OK ? put_group(o, FATHOM_ROOT) : status;
}
