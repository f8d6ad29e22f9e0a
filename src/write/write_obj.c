/* OBJ: instances are expanded to meshes in world space, normals and uvs have their own indices, materials are
 * in a library next to the file (write_mtl.c). */
#include "write/write_obj.h"

#include "base/srgb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct obj {
    const fathom_scene *scene;
    const scene_graph *graph;
    write_stream stream;
    char **names; /* of materials */
    bool flips;   /* v is written as 1 - v */
    bool far;     /* from the origin: floats would lose digits of positions */
    note_list *notes;
    fathom_id material; /* current material */
    size_t objects;
    size_t positions, normals, uvs; /* lines before the current mesh */
} obj;

/* ---- lines ---- */

static char *put_line(char *out, const char *key, const float *numbers, int count) {
    while (*key) *out++ = *key++;
    for (int k = 0; k < count; ++k) {
        *out++ = ' ';
        out += write_float(out, numbers[k]);
    }
    *out++ = '\n';
    return out;
}

/* Encodes the colour as sRGB, because readers decode it. */
static void put_color(const fathom_mesh *m, size_t vertex, float out[3]) {
    const float *linear = mesh_row(m->colors, m->color_stride, vertex);
    for (int k = 0; k < 3; ++k) out[k] = (float)srgb_encoded(fmin((double)linear[k], 1));
}

/* The lines of one kind of a placed mesh. */
typedef struct obj_part {
    const obj *o;
    const write_placement *at;
    enum { POSITIONS, NORMALS, UVS } kind; /* of vertices */
} obj_part;

static char *put_far(char *out, const write_placement *at, size_t i) {
    const fathom_mesh *m = at->mesh;
    const vec3_f64 p = affine_point(&at->map, widen(write_item(m->positions, m->position_stride, i)));
    return out + snprintf(out, 3 * WRITE_NUMBER_BYTES + 4, "v %.17g %.17g %.17g", p.x, p.y, p.z);
}

static size_t format_vertices(const void *user, size_t begin, size_t end, char *out) {
    static const char *const keys[] = {"v", "vn", "vt"};
    const obj_part *part = user;
    const write_placement *at = part->at;
    const fathom_mesh *m = at->mesh;
    char *start = out;
    for (size_t i = begin; i < end; ++i) {
        float v[6];
        if (part->kind == POSITIONS)
            store_f32(v, write_placed_position(at, write_item(m->positions, m->position_stride, i)));
        else if (part->kind == NORMALS)
            store_f32(v, write_placed_normal(at, write_item(m->normals, m->normal_stride, i)));
        else
            memcpy(v, (const char *)m->uvs + m->uv_stride * i, 2 * sizeof *v);
        if (part->kind == UVS && part->o->flips) v[1] = 1 - v[1];
        if (part->kind == POSITIONS && m->colors) put_color(m, i, v + 3);
        const int count = part->kind == UVS ? 2 : part->kind == POSITIONS && m->colors ? 6 : 3;
        if (part->kind == POSITIONS && part->o->far)
            out = put_line(put_far(out, at, i), "", v + 3, count - 3);
        else
            out = put_line(out, keys[part->kind], v, count);
    }
    return (size_t)(out - start);
}

/* Writes a, a/t, a//n or a/t/n, with indices from 1 over the whole file. */
static char *put_corner(char *out, const obj_part *f, size_t corner) {
    const fathom_mesh *m = f->at->mesh;
    uint32_t position = m->indices[corner];
    *out++ = ' ';
    out += write_integer(out, f->o->positions + position + 1);
    if (!m->uvs && !m->normals) return out;
    *out++ = '/';
    if (m->uvs) out += write_integer(out, f->o->uvs + (m->uv_indices ? m->uv_indices[corner] : position) + 1);
    if (!m->normals) return out;
    *out++ = '/';
    return out +
           write_integer(out, f->o->normals + (m->normal_indices ? m->normal_indices[corner] : position) + 1);
}

static size_t format_faces(const void *user, size_t begin, size_t end, char *out) {
    const obj_part *f = user;
    size_t second = f->at->mirrored ? 2 : 1;
    char *start = out;
    for (size_t t = begin; t < end; ++t) {
        *out++ = 'f';
        out = put_corner(out, f, 3 * t);
        out = put_corner(out, f, 3 * t + second);
        out = put_corner(out, f, 3 * t + 3 - second);
        *out++ = '\n';
    }
    return (size_t)(out - start);
}

static size_t format_points(const void *user, size_t begin, size_t end, char *out) {
    const obj_part *f = user;
    char *start = out;
    for (size_t i = begin; i < end; ++i) {
        *out++ = 'p', *out++ = ' ';
        out += write_integer(out, f->o->positions + i + 1);
        *out++ = '\n';
    }
    return (size_t)(out - start);
}

/* ---- file ---- */

/* Writes the object's name, or one with that of its group, as one word. */
static void put_head(obj *o, const write_placement *at) {
    const scene_object *object = &o->scene->objects.items[at->object];
    const char *group = o->scene->groups.items[object->group], *name = object->name ? object->name : group;
    file_writer *file = o->stream.file;
    file_writer_print(file, "o ");
    if (!object->name) file_writer_print(file, "object_%zu%s", o->objects, name && *name ? "_" : "");
    for (const char *c = name ? name : ""; *c; ++c)
        file_writer_put(file, (unsigned char)*c <= ' ' ? "_" : c, 1);
    if (o->material != at->material) file_writer_print(file, "\nusemtl %s", o->names[at->material]);
    file_writer_print(file, "\n");
    ++o->objects, o->material = at->material;
}

static fathom_status put_placement(void *user, const write_placement *at) {
    obj *o = user;
    const fathom_mesh *m = at->mesh;
    const size_t line = (m->colors ? 6 : 3) * WRITE_NUMBER_BYTES + 8;
    put_head(o, at);
    obj_part part = {o, at, POSITIONS};
    write_items(&o->stream, m->vertex_count, line, format_vertices, &part);
    part.kind = UVS;
    if (m->uvs) write_items(&o->stream, m->uv_count, line, format_vertices, &part);
    part.kind = NORMALS;
    if (m->normals) write_items(&o->stream, m->normal_count, line, format_vertices, &part);
    write_items(&o->stream, m->triangle_count, 9 * 22 + 8, format_faces, &part);
    if (m->point_radius > 0) write_items(&o->stream, m->vertex_count, 22 + 8, format_points, &part);
    o->positions += m->vertex_count;
    o->uvs += m->uvs ? m->uv_count : 0;
    o->normals += m->normals ? m->normal_count : 0;
    return FATHOM_OK;
}

/* Checks that all indices fit into 32 bits, the size in readers. */
static fathom_status check_count(const obj *o, const char *path) {
    size_t *ways, vertices = 0;
    fathom_status status = write_count_ways(o->scene, o->graph, &ways);
    if (status != FATHOM_OK) return status;
    for (size_t i = 0; i < o->scene->objects.count; ++i) {
        scene_object object = o->scene->objects.items[i];
        if (object.kind != SCENE_MESH) continue;
        const fathom_mesh *m = &o->scene->meshes.items[object.index];
        size_t most = m->vertex_count > m->normal_count ? m->vertex_count : m->normal_count;
        if (m->uv_count > most) most = m->uv_count;
        vertices = write_add(vertices, write_multiply(ways[object.group], most));
    }
    free(ways);
    if (vertices <= UINT32_MAX) return FATHOM_OK;
    return fail_file(o->scene->context, FATHOM_BAD_USAGE, path,
                     "with all instances placed there are %zu vertices, and readers of OBJ count to "
                     "4294967295; .glb keeps instances as they are",
                     vertices);
}

/* "models/bunny.obj" -> "models/bunny.mtl" */
static char *library_path(const char *path) {
    size_t stem = strlen(path) - strlen("obj");
    char *library = strdup(path);
    if (library) memcpy(library + stem, "mtl", 3);
    return library;
}

static fathom_status put_library(const obj *o, const char *path, const char *library) {
    write_images images;
    fathom_status status = write_images_open(o->scene, false, &images);
    if (status == FATHOM_OK) status = write_images_beside(o->scene, path, true, &images);
    if (status == FATHOM_OK)
        status = write_mtl(&(write_library){o->scene, &images, o->names, o->flips, o->notes}, library);
    write_images_close(&images);
    return status;
}

static fathom_status put_all(obj *o, const char *path, const char *library) {
    fathom_status status = write_stream_open(o->scene->context, path, &o->stream);
    if (status != FATHOM_OK) return status;
    file_writer_print(o->stream.file, "# Fathom %s\nmtllib %s%s\n", fathom_version(),
                      write_before_name(file_name(library)), file_name(library));
    status = write_each_placement(o->scene, o->graph, put_placement, o);
    /* Writes images and library before the file that names the library. */
    if (status == FATHOM_OK) status = put_library(o, path, library);
    return write_stream_close(&o->stream, status);
}

fathom_status write_obj(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes) {
    obj o = {.scene = scene, .graph = graph, .material = FATHOM_NONE, .notes = notes};
    o.flips = write_flips(scene);
    char *library = library_path(path);
    fathom_status status = library ? check_count(&o, path) : fail_memory(scene->context, strlen(path));
    scene_bounds world;
    if (status == FATHOM_OK) status = scene_world_bounds(scene, &world);
    o.far = status == FATHOM_OK && write_is_far(&world);
    if (status == FATHOM_OK) status = write_names(scene, false, true, notes, &o.names);
    if (status == FATHOM_OK) status = put_all(&o, path, library);
    write_names_free(o.names, scene->materials.count);
    free(library);
    return status;
}
