#include "scene/scene.h"

#include "base/file.h"
#include "base/hash.h"
#include "base/threads.h"
#include "scene/mesh/mesh_array.h"
#include "scene/settings.h"

#include <stdlib.h>
#include <string.h>

/* ---- plain values, field by field: padding between the fields of a struct is undefined ---- */

#define PUT(hash, field) hash_put(hash, &(field), sizeof(field))

/* Adds nothing without keys, so that scenes without motion keep their fingerprint. */
static void hash_keys(hash *h, uint32_t count, const double *times, const double *maps) {
    if (!count) return;
    PUT(h, count);
    hash_put(h, times, count * sizeof *times);
    hash_put(h, maps, 12 * (size_t)count * sizeof *maps);
}

static void hash_camera(hash *h, const fathom_camera *c) {
    PUT(h, c->origin), PUT(h, c->x), PUT(h, c->y), PUT(h, c->z);
    PUT(h, c->d), PUT(h, c->h), PUT(h, c->w);
    PUT(h, c->lens_radius), PUT(h, c->focus_distance);
    if (c->shutter[0] != 0 || c->shutter[1] != 0) PUT(h, c->shutter);
    if (c->orthographic) PUT(h, c->orthographic);
    if (c->near_clip > 0 || c->far_clip > 0) PUT(h, c->near_clip), PUT(h, c->far_clip);
    if (c->blades) PUT(h, c->blades), PUT(h, c->blade_rotation);
    hash_keys(h, c->key_count, c->key_times, c->key_frames);
}

static void hash_material(hash *h, const fathom_material *m) {
    const parameter_table table = material_table(m->model);
    const unsigned model = (unsigned)m->model;
    PUT(h, model);
    for (size_t i = 0; i < table.count; ++i) {
        for (unsigned k = 0; k < parameter_count(&table.rows[i]); ++k) {
            const double number = parameter_number(&table.rows[i], m, k);
            PUT(h, number);
        }
    }
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        const fathom_map *map = &m->maps[k];
        if (map->texture == FATHOM_NONE) continue;
        PUT(h, k), PUT(h, map->texture), PUT(h, map->uv_set), PUT(h, map->channel), PUT(h, map->inverted),
            PUT(h, map->transform);
    }
}

static void hash_light(hash *h, const fathom_light *l) {
    const unsigned type = (unsigned)l->type;
    PUT(h, type), PUT(h, l->position), PUT(h, l->direction), PUT(h, l->intensity);
    PUT(h, l->inner_angle), PUT(h, l->outer_angle);
    PUT(h, l->radius), PUT(h, l->angular_radius);
}

/* Leaves out the path of the file, whose contents are hashed. */
static void hash_environment(hash *h, const fathom_light *l) {
    PUT(h, l->intensity), PUT(h, l->rotation);
    if (l->up[0] != 0 || l->up[1] != 1 || l->up[2] != 0) PUT(h, l->up);
}

/* Leaves out the path of the image, too. */
static void hash_texture(hash *h, const fathom_texture *t) {
    const unsigned modes[] = {(unsigned)t->color_space, (unsigned)t->wrap_u, (unsigned)t->wrap_v,
                              (unsigned)t->filter};
    PUT(h, modes);
    if (t->color_space_name) hash_put(h, t->color_space_name, strlen(t->color_space_name));
    hash_put(h, t->bytes, t->byte_count);
}

static void hash_grouped(hash *h, const scene_grouped_light *g) {
    const unsigned source = (unsigned)g->source;
    PUT(h, source), PUT(h, g->id), PUT(h, g->group);
}

/* Cryptomatte's ids are those of names. */
static void hash_name(hash *h, const char *name) {
    const size_t bytes = name ? strlen(name) + 1 : 0;
    PUT(h, bytes);
    hash_put(h, name, bytes);
}

static void hash_instance(hash *h, const fathom_instance *i) {
    PUT(h, i->group), PUT(h, i->parent), PUT(h, i->material);
    if (!i->key_count) PUT(h, i->transform);
    hash_keys(h, i->key_count, i->key_times, i->key_transforms);
    hash_name(h, i->name);
}

static void hash_object(hash *h, const scene_object *o) {
    const unsigned kind = (unsigned)o->kind;
    PUT(h, kind), PUT(h, o->index), PUT(h, o->group);
    hash_name(h, o->name);
}

static void hash_sphere(hash *h, const fathom_sphere *s) {
    PUT(h, s->center), PUT(h, s->radius), PUT(h, s->material), PUT(h, s->flags);
}

static void hash_quad(hash *h, const fathom_quad *q) {
    PUT(h, q->corners), PUT(h, q->material), PUT(h, q->flags);
}

static void hash_plane(hash *h, const fathom_plane *p) {
    PUT(h, p->point), PUT(h, p->normal), PUT(h, p->material), PUT(h, p->flags);
}

static void hash_mesh(hash *h, const fathom_mesh *m) {
    const unsigned has = (m->normals ? 1u : 0u) + (m->normal_indices ? 2u : 0u) +
                         (m->colors ? 4u * m->color_channels : 0u) + (m->tangents ? 32u : 0u);
    PUT(h, m->vertex_count), PUT(h, m->triangle_count), PUT(h, m->normal_count), PUT(h, has);
    PUT(h, m->origin), PUT(h, m->material), PUT(h, m->flags);
    if (m->key_count) PUT(h, m->key_count);
    if (m->point_radius > 0) PUT(h, m->point_radius);
}

#define PUT_ALL(hash, array, put)                                                                            \
    do {                                                                                                     \
        const uint64_t count = (array)->count;                                                               \
        PUT(hash, count);                                                                                    \
        for (size_t i = 0; i < (array)->count; ++i) put(hash, &(array)->items[i]);                           \
    } while (0)

static void hash_values(hash *h, const fathom_scene *scene) {
    const uint64_t materials = scene->materials.count, groups = scene->groups.count;
    hash_camera(h, &scene->camera);
    PUT(h, scene->background), PUT(h, scene->ambient);
    PUT(h, materials), PUT(h, groups);
    for (size_t i = 0; i < materials; ++i) {
        hash_material(h, &scene->materials.items[i].value);
        hash_material(h, &scene->materials.items[i].classic);
        hash_name(h, scene->materials.items[i].name);
    }
    for (size_t i = 0; i < groups; ++i) hash_name(h, scene->groups.items[i]);
    PUT_ALL(h, &scene->lights, hash_light);
    PUT_ALL(h, &scene->environments, hash_environment);
    PUT(h, scene->in_studio), PUT(h, scene->made.ambient), PUT(h, scene->studio_up);
    PUT_ALL(h, &scene->textures, hash_texture);
    PUT_ALL(h, &scene->objects, hash_object);
    PUT_ALL(h, &scene->instances, hash_instance);
    PUT_ALL(h, &scene->spheres, hash_sphere);
    PUT_ALL(h, &scene->quads, hash_quad);
    PUT_ALL(h, &scene->planes, hash_plane);
    PUT_ALL(h, &scene->meshes, hash_mesh);
    PUT_ALL(h, &scene->grouped_lights, hash_grouped);
    for (uint32_t i = 0; i < scene->light_groups.count; ++i)
        hash_put(h, scene->light_groups.names[i], strlen(scene->light_groups.names[i]) + 1);
}

/* ---- arrays, in pieces that threads share ---- */

/* Rows of `row` bytes, `stride` apart. */
typedef struct piece {
    const char *data;
    size_t rows, row, stride;
} piece;

typedef struct pieces {
    ARRAY(piece) list;
    uint64_t *hashes; /* one for each */
} pieces;

#define PIECE_BYTES ((size_t)1 << 20)

static bool add_array(pieces *p, const void *data, size_t rows, size_t row, size_t stride) {
    const size_t whole = PIECE_BYTES / row;
    for (size_t first = 0; data && first < rows; first += whole) {
        const piece next = {(const char *)data + first * stride, rows - first < whole ? rows - first : whole,
                            row, stride};
        if (!array_push(&p->list, next)) return false;
    }
    return true;
}

/* Adds the arrays that are read only if materials use texture coordinates (mapped), or the others. */
static bool add_arrays(pieces *p, const fathom_mesh *m, bool mapped) {
    const size_t corners = (size_t)m->triangle_count * 3, each = sizeof(uint32_t);
    for (int k = 0; k < MESH_ARRAYS; ++k) {
        const mesh_array a = mesh_array_of(m, (mesh_kind)k);
        if (a.mapped != mapped) continue;
        if (!add_array(p, a.values, a.count, a.width * sizeof(float), a.stride) ||
            !add_array(p, a.indices, corners, each, each))
            return false;
    }
    return true;
}

static bool add_keys(pieces *p, const fathom_mesh *m) {
    const size_t vector = 3 * sizeof(float);
    if (!m->key_count) return true;
    return add_array(p, m->key_times, m->key_count, sizeof(double), sizeof(double)) &&
           add_array(p, m->key_positions, m->key_count * (size_t)m->vertex_count, vector, vector) &&
           add_array(p, m->key_normals, m->key_count * (size_t)m->normal_count, vector, vector);
}

/* Rows with gaps are packed first, because the bytes between them belong to other arrays or to none. */
static uint64_t hash_piece(const piece *p) {
    if (p->stride == p->row) return hash_of(p->data, p->rows * p->row);
    hash h;
    hash_begin(&h);
    enum { TOGETHER = 256 };
    char near[TOGETHER * 4 * sizeof(float)];
    for (size_t first = 0; first < p->rows; first += TOGETHER) {
        size_t count = p->rows - first < TOGETHER ? p->rows - first : TOGETHER;
        const char *from = p->data + first * p->stride;
        for (size_t i = 0; i < count; ++i) memcpy(near + i * p->row, from + i * p->stride, p->row);
        hash_put(&h, near, count * p->row);
    }
    return hash_end(&h);
}

static void hash_pieces(void *user, size_t begin, size_t end) {
    const pieces *p = user;
    for (size_t i = begin; i < end; ++i) p->hashes[i] = hash_piece(&p->list.items[i]);
}

static bool hash_arrays(const fathom_scene *scene, pieces *p) {
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *m = &scene->meshes.items[i];
        if (!add_arrays(p, m, false) || !add_keys(p, m)) return false;
        if (scene->uses_uvs && !add_arrays(p, m, true)) return false;
    }
    p->hashes = malloc((p->list.count + 1) * sizeof *p->hashes);
    if (!p->hashes) return false;
    loop_parallel(fathom_context_threads(scene->context), p->list.count, 1, hash_pieces, p);
    return true;
}

static fathom_status hash_file(const fathom_scene *scene, const char *path, hash *h) {
    file_map map;
    fathom_status status = file_open(scene->context, path, &map);
    if (status != FATHOM_OK) return status;
    hash_put(h, map.bytes, map.size);
    return file_finish(scene->context, &map, FATHOM_OK);
}

static fathom_status hash_sky_files(const fathom_scene *scene, const char *path, hash *h) {
    file_faces files;
    fathom_status status = file_faces_open(scene->context, path, &files);
    for (unsigned i = 0; status == FATHOM_OK && i < files.count; ++i)
        status = hash_file(scene, files.paths[i], h);
    file_faces_close(&files);
    return status;
}

/* The config decides what a named colour space means. Opening the images reports a config that cannot be
 * read. */
static void hash_config(const fathom_scene *scene, hash *h) {
    const char *config = getenv("OCIO");
    bool named = false;
    for (size_t i = 0; i < scene->textures.count; ++i)
        named |= scene->textures.items[i].color_space == FATHOM_COLOR_NAMED;
    if (named && config && hash_file(scene, config, h) != FATHOM_OK) hash_put(h, config, strlen(config));
}

static fathom_status hash_images(const fathom_scene *scene, hash *h) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; status == FATHOM_OK && i < scene->environments.count; ++i)
        status = hash_sky_files(scene, scene->environments.items[i].file, h);
    for (size_t i = 0; status == FATHOM_OK && i < scene->textures.count; ++i) {
        const char *path = scene->textures.items[i].file;
        if (path) status = hash_file(scene, path, h);
    }
    hash_config(scene, h);
    return status;
}

fathom_status scene_fingerprint(const fathom_scene *scene, uint64_t *out) {
    hash h;
    pieces p = {.hashes = NULL};
    hash_begin(&h);
    fathom_status status = hash_images(scene, &h);
    if (status != FATHOM_OK) return status;
    bool fine = hash_arrays(scene, &p);
    if (fine) {
        hash_values(&h, scene);
        hash_put(&h, p.hashes, p.list.count * sizeof *p.hashes);
        *out = hash_end(&h);
    }
    array_free(&p.list);
    free(p.hashes);
    return fine ? FATHOM_OK : fail_memory(scene->context, p.list.count * sizeof *p.list.items);
}
