/* The mesh arrays as ranges of memory. */
#include "scene/scene.h"

#include "base/clock.h"
#include "scene/mesh/mesh_array.h"
#include "scene/world/world.h"

#include <stdlib.h>

typedef struct piece {
    uintptr_t start, end;
} piece;

typedef struct piece_list {
    piece *items;
    size_t count;
} piece_list;

static int by_start(const void *a, const void *b) {
    uintptr_t left = ((const piece *)a)->start, right = ((const piece *)b)->start;
    return (left > right) - (left < right);
}

static void add(piece_list *list, const void *start, uint64_t bytes) {
    if (start) list->items[list->count++] = (piece){(uintptr_t)start, (uintptr_t)start + bytes};
}

/* mapped: shading reads texture coordinates. */
static void add_mesh(piece_list *list, const fathom_mesh *m, unsigned which, bool mapped) {
    for (int k = 0; k < MESH_ARRAYS; ++k) {
        const mesh_array a = mesh_array_of(m, (mesh_kind)k);
        const unsigned use = k == MESH_POSITIONS   ? SCENE_TRACED
                             : a.mapped && !mapped ? SCENE_UNREAD
                                                   : SCENE_SHADED;
        if (!(which & use) || !a.count) continue;
        add(list, a.values, (uint64_t)(a.count - 1) * a.stride + a.width * sizeof(float));
        add(list, a.indices, (uint64_t)m->triangle_count * 3 * sizeof(uint32_t));
    }
}

/* Merges ranges that overlap, such as interleaved vertex attributes. */
static void merge(piece_list *list) {
    size_t kept = 0;
    if (list->count) qsort(list->items, list->count, sizeof *list->items, by_start);
    for (size_t i = 0; i < list->count; ++i) {
        const piece *next = &list->items[i];
        piece *last = kept ? &list->items[kept - 1] : NULL;
        if (!last || next->start > last->end)
            list->items[kept++] = *next;
        else if (next->end > last->end)
            last->end = next->end;
    }
    list->count = kept;
}

/* Lists the ranges in ascending order, without overlap. Release the items with free(). */
static fathom_status list_pieces(const fathom_scene *scene, const fathom_mesh *meshes, size_t count,
                                 unsigned which, piece_list *out) {
    const size_t room = count * 9;
    *out = (piece_list){malloc((room + 1) * sizeof *out->items), 0};
    if (!out->items) return fail_memory(scene->context, room * sizeof *out->items);
    for (size_t i = 0; i < count; ++i) add_mesh(out, &meshes[i], which, scene->uses_uvs);
    merge(out);
    return FATHOM_OK;
}

fathom_status scene_buffer_bytes(const fathom_scene *scene, unsigned which, uint64_t *out) {
    piece_list list;
    fathom_status status = list_pieces(scene, scene->meshes.items, scene->meshes.count, which, &list);
    *out = 0;
    for (size_t i = 0; i < list.count; ++i) *out += list.items[i].end - list.items[i].start;
    if (which & SCENE_TRACED) *out += scene_points(scene) * WORLD_POINT_BYTES;
    free(list.items);
    return status;
}

/* Reading a page also loads its neighbours, by default this many bytes on Linux, so dropping a smaller gap
 * would save nothing. */
#define LEAST_GAP 65536u

static void rest_gap(const file_map *map, uintptr_t begin, uintptr_t end) {
    uintptr_t base = (uintptr_t)map->bytes;
    if (begin < end && end - begin >= LEAST_GAP) file_rest(map, begin - base, end - base);
}

static void rest_around(const file_map *map, const piece_list *list) {
    uintptr_t at = (uintptr_t)map->bytes, end = at + map->size;
    for (size_t i = 0; i < list->count && at < end; ++i) {
        const piece *p = &list->items[i];
        if (p->end <= at) continue;
        rest_gap(map, at, p->start < end ? p->start : end);
        at = p->end;
    }
    rest_gap(map, at, end);
}

fathom_status scene_rest_files(const fathom_scene *scene, const fathom_mesh *traced, size_t count) {
    piece_list list;
    fathom_status status = list_pieces(scene, traced, count, SCENE_TRACED, &list);
    for (size_t i = 0; i < scene->blobs.count && status == FATHOM_OK; ++i)
        rest_around(&scene->blobs.items[i].map, &list);
    free(list.items);
    return status;
}

fathom_status fathom_scene_check_files(const fathom_scene *scene) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < scene->blobs.count && status == FATHOM_OK; ++i)
        status = file_check(scene->context, &scene->blobs.items[i].map);
    return status;
}

#define WATCH_SECONDS 1.0

fathom_status scene_watch_files(const fathom_scene *scene, double *next) {
    double now = clock_seconds();
    if (now < *next) return FATHOM_OK;
    *next = now + WATCH_SECONDS;
    return fathom_scene_check_files(scene);
}
