/* PLY: little-endian binary, with instances expanded to meshes in world space. Normals, uvs and colours are
 * written if any mesh has them, and opacities as alpha. Colours include those of the materials, and are also
 * written if these differ. The second uv set is s1 and t1; no other program is known to read it. A vertex has
 * one normal, so if other meshes are smooth, flat meshes get a vertex for each corner, with the facet's
 * normal. If all triangles have the same image, a comment names it, and the uvs include its transform. v
 * grows upwards. Points become the vertices of a file without faces; together with triangles, they cannot be
 * written. */
#include "write/image.h"
#include "write/write.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ply {
    const fathom_scene *scene;
    const scene_graph *graph;
    const char *path;
    write_stream stream;
    write_mesh *meshes;                              /* one for each of the scene's meshes */
    bool normals, uvs, uvs_1, colors, alpha, points; /* points: they can be written */
    const float *first_color;                        /* of the first mesh's material */
    const fathom_map *map;                           /* the map with the image; NULL: none */
    write_images images;                             /* only this image */
    size_t vertices, triangles;                      /* total numbers */
    size_t first_vertex;                             /* first vertex of the current mesh */
} ply;

/* ---- counting ---- */

/* Records which arrays a mesh has; with `prepare`, when those of all meshes are known, prepares it. */
static fathom_status count_mesh(ply *p, uint32_t index, size_t ways, bool prepare) {
    const fathom_mesh *mesh = &p->scene->meshes.items[index];
    write_mesh *m = &p->meshes[index];
    p->normals |= mesh->normals != NULL;
    p->uvs |= mesh->uvs != NULL;
    p->uvs_1 |= mesh->uvs_1 != NULL;
    p->colors |= mesh->colors != NULL;
    p->alpha |= mesh->colors && mesh->color_channels > 3;
    if (!prepare) return FATHOM_OK;
    fathom_status status = write_mesh_prepare(p->scene->context, mesh, p->normals && !mesh->normals, m);
    m->flips = !p->map && write_flips(p->scene);
    p->vertices = write_add(p->vertices, write_multiply(ways, m->vertex_count));
    p->triangles = write_add(p->triangles, write_multiply(ways, mesh->triangle_count));
    return status;
}

static bool has_place(const ply *p, const fathom_mesh *mesh) {
    return p->points || !(mesh->point_radius > 0);
}

static fathom_status count_meshes(ply *p, const size_t *ways, bool prepare) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < p->scene->objects.count && status == FATHOM_OK; ++i) {
        scene_object object = p->scene->objects.items[i];
        if (object.kind == SCENE_MESH && ways[object.group] &&
            has_place(p, &p->scene->meshes.items[object.index]))
            status = count_mesh(p, object.index, ways[object.group], prepare);
    }
    return status;
}

size_t write_ply_lost_points(const fathom_scene *scene, const size_t *ways) {
    size_t points = 0, triangles = 0;
    for (size_t i = 0; i < scene->objects.count; ++i) {
        const scene_object object = scene->objects.items[i];
        if (object.kind != SCENE_MESH) continue;
        const fathom_mesh *mesh = &scene->meshes.items[object.index];
        const size_t count = mesh->point_radius > 0 ? mesh->vertex_count : mesh->triangle_count;
        size_t *sum = mesh->point_radius > 0 ? &points : &triangles;
        *sum = write_add(*sum, write_multiply(ways[object.group], count));
    }
    return triangles ? points : 0;
}

/* A surface that only emits, such as an unlit one of glTF, has the colour of its emission. */
static const float *color_of(const ply *p, const write_placement *at) {
    const fathom_material *m = &p->scene->materials.items[at->material].value;
    const bool classic = m->model == FATHOM_MODEL_CLASSIC, emits = material_only_emits(m);
    return classic ? (emits ? m->k_e : m->k_d) : emits ? m->emissive : m->base_color;
}

/* Materials that do not all have the same grey need colours. */
static fathom_status look_at_color(void *user, const write_placement *at) {
    ply *p = user;
    const float *c = color_of(p, at);
    if (!p->first_color) p->first_color = c;
    p->colors |= c[0] != c[1] || c[1] != c[2] || memcmp(c, p->first_color, 3 * sizeof *c) != 0;
    return FATHOM_OK;
}

static fathom_status count_all(ply *p) {
    size_t *ways;
    fathom_status status = write_each_placement(p->scene, p->graph, look_at_color, p);
    if (status == FATHOM_OK) status = write_count_ways(p->scene, p->graph, &ways);
    if (status != FATHOM_OK) return status;
    p->points = !write_ply_lost_points(p->scene, ways);
    status = count_meshes(p, ways, false);
    if (status == FATHOM_OK) status = count_meshes(p, ways, true);
    free(ways);
    if (status == FATHOM_OK && (p->vertices > UINT32_MAX || p->triangles > UINT32_MAX)) {
        return fail_file(p->scene->context, FATHOM_BAD_USAGE, p->path,
                         "with all instances placed there are %zu vertices and %zu triangles, and PLY counts "
                         "to 4294967295; .glb keeps instances as they are",
                         p->vertices, p->triangles);
    }
    return status;
}

/* ---- the image ---- */

typedef struct image_search {
    const fathom_scene *scene;
    fathom_id material; /* the common material; FATHOM_NONE: no triangles so far */
    bool differs;       /* triangles have several materials, or some have no uvs */
} image_search;

static fathom_status look_at_placement(void *user, const write_placement *at) {
    image_search *search = user;
    if (at->mesh->point_radius > 0) return FATHOM_OK;
    if (search->material == FATHOM_NONE) search->material = at->material;
    search->differs |= search->material != at->material || !at->mesh->uvs;
    return FATHOM_OK;
}

const fathom_map *write_ply_image(const fathom_scene *scene, const scene_graph *graph) {
    image_search search = {scene, FATHOM_NONE, false};
    if (write_each_placement(scene, graph, look_at_placement, &search) != FATHOM_OK || search.differs ||
        search.material == FATHOM_NONE)
        return NULL;
    const fathom_material *m = &scene->materials.items[search.material].value;
    const fathom_map *map = &m->maps[material_only_emits(m) ? FATHOM_MAP_EMISSIVE : FATHOM_MAP_COLOR];
    return map->texture == FATHOM_NONE || map->uv_set ? NULL : map;
}

static fathom_status put_image(ply *p) {
    if (!p->map) return FATHOM_OK;
    fathom_status status = write_image_open_one(p->scene, p->map->texture, &p->images);
    return status == FATHOM_OK ? write_images_beside(p->scene, p->path, true, &p->images) : status;
}

/* If a file names an image, readers assume that v grows upwards. */
static void place_on_image(const ply *p, float uv[2]) {
    const float *m = p->map->transform, u = uv[0], v = uv[1];
    uv[0] = m[0] * u + m[1] * v + m[2];
    uv[1] = 1 - (m[3] * u + m[4] * v + m[5]);
}

/* ---- writing ---- */

#define HEADER_BYTES 1024

/* Returns the length of the header. `blanks`: number of spaces after the comment. */
static int format_header(const ply *p, int blanks, char text[HEADER_BYTES]) {
    char faces[128] = "";
    if (p->triangles)
        snprintf(faces, sizeof faces, "element face %zu\nproperty list uchar uint vertex_indices\n",
                 p->triangles);
    return snprintf(
        text, HEADER_BYTES,
        "ply\nformat binary_little_endian 1.0\n%s%s%.255s%scomment Fathom %s%*s\nelement vertex %zu\n"
        "property float x\nproperty float y\nproperty float z\n%s%s%s%s%s%send_header\n",
        p->map ? "comment TextureFile " : "", p->map ? write_before_name(p->images.items[0].name) : "",
        p->map ? p->images.items[0].name : "", p->map ? "\n" : "", fathom_version(), blanks, "", p->vertices,
        p->normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
        p->uvs ? "property float s\nproperty float t\n" : "",
        p->uvs_1 ? "property float s1\nproperty float t1\n" : "",
        p->colors ? "property float red\nproperty float green\nproperty float blue\n" : "",
        p->alpha ? "property float alpha\n" : "", faces);
}

/* The header is padded to a multiple of 4 bytes, so that readers can use the vertices in the mapped file. */
static void put_header(ply *p) {
    char text[HEADER_BYTES];
    int length = format_header(p, 0, text);
    length = format_header(p, (4 - length % 4) % 4, text);
    file_writer_put(p->stream.file, text, (size_t)length);
}

typedef struct ply_part {
    const ply *p;
    const write_mesh *mesh;
    const write_placement *at;
} ply_part;

/* The vertex colour times that of the material, which the file cannot hold. */
static void put_color(const ply_part *part, uint32_t vertex, float out[4]) {
    const float *base = color_of(part->p, part->at);
    out[0] = out[1] = out[2] = out[3] = 1;
    if (part->mesh->mesh->colors) write_mesh_entry(part->mesh, MESH_COLORS, vertex, out);
    for (int c = 0; c < 3; ++c) out[c] *= base[c];
}

#define PLY_NUMBERS 14 /* maximum numbers per vertex */

static size_t format_vertices(const void *user, size_t begin, size_t end, char *out) {
    const ply_part *part = user;
    char *start = out;
    for (uint32_t i = (uint32_t)begin; i < end; ++i) {
        float numbers[PLY_NUMBERS] = {0};
        size_t count = 3;
        store_f32(numbers, write_placed_position(part->at, write_mesh_position(part->mesh, i)));
        if (part->p->normals) {
            store_f32(numbers + count, write_placed_normal(part->at, write_mesh_normal(part->mesh, i)));
            count += 3;
        }
        const mesh_kind sets[] = {MESH_UVS, MESH_UVS_1};
        for (unsigned k = 0; k < 2; ++k) {
            if (!(k ? part->p->uvs_1 : part->p->uvs)) continue;
            if (write_mesh_width(part->mesh->mesh, sets[k]))
                write_mesh_entry(part->mesh, sets[k], i, numbers + count);
            if (part->p->map && !k) place_on_image(part->p, numbers + count);
            count += 2;
        }
        if (part->p->colors) put_color(part, i, numbers + count), count += part->p->alpha ? 4 : 3;
        memcpy(out, numbers, count * sizeof *numbers);
        out += count * sizeof *numbers;
    }
    return (size_t)(out - start);
}

#define FACE_BYTES 13

static size_t format_faces(const void *user, size_t begin, size_t end, char *out) {
    const ply_part *part = user;
    uint32_t first = (uint32_t)part->p->first_vertex;
    size_t second = part->at->mirrored ? 2 : 1;
    for (size_t t = begin; t < end; ++t, out += FACE_BYTES) {
        uint32_t corners[3] = {first + write_mesh_index(part->mesh, 3 * t),
                               first + write_mesh_index(part->mesh, 3 * t + second),
                               first + write_mesh_index(part->mesh, 3 * t + 3 - second)};
        *out = 3;
        memcpy(out + 1, corners, sizeof corners);
    }
    return (end - begin) * FACE_BYTES;
}

static fathom_status put_vertices(void *user, const write_placement *at) {
    ply *p = user;
    ply_part part = {p, &p->meshes[at->mesh_index], at};
    write_items(&p->stream, part.mesh->vertex_count, PLY_NUMBERS * sizeof(float), format_vertices, &part);
    return FATHOM_OK;
}

static fathom_status put_faces(void *user, const write_placement *at) {
    ply *p = user;
    ply_part part = {p, &p->meshes[at->mesh_index], at};
    write_items(&p->stream, at->mesh->triangle_count, FACE_BYTES, format_faces, &part);
    p->first_vertex += part.mesh->vertex_count;
    return FATHOM_OK;
}

static fathom_status put_all(ply *p) {
    fathom_status status = write_stream_open(p->scene->context, p->path, &p->stream);
    if (status != FATHOM_OK) return status;
    put_header(p);
    status = write_each_placement(p->scene, p->graph, put_vertices, p);
    if (status == FATHOM_OK) status = write_each_placement(p->scene, p->graph, put_faces, p);
    return write_stream_close(&p->stream, status);
}

fathom_status write_ply(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes) {
    (void)notes;
    ply p = {.scene = scene, .graph = graph, .path = path, .map = write_ply_image(scene, graph)};
    p.meshes = calloc(scene->meshes.count, sizeof *p.meshes);
    if (!p.meshes) return fail_memory(scene->context, scene->meshes.count * sizeof *p.meshes);
    fathom_status status = count_all(&p);
    if (status == FATHOM_OK) status = put_image(&p);
    if (status == FATHOM_OK) status = put_all(&p);
    write_images_close(&p.images);
    for (size_t i = 0; i < scene->meshes.count; ++i) write_mesh_free(&p.meshes[i]);
    free(p.meshes);
    return status;
}
