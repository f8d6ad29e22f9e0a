#include "scene/scene.h"

#include <stdlib.h>

typedef struct buffer {
    const void *start;
    uint64_t bytes;
} buffer;

static int by_start(const void *a, const void *b) {
    uintptr_t left = (uintptr_t)((const buffer *)a)->start, right = (uintptr_t)((const buffer *)b)->start;
    return (left > right) - (left < right);
}

/* Meshes of one file often share their vertices: each array counts once, by its start. */
fathom_status scene_buffer_bytes(const fathom_scene *scene, uint64_t *out) {
    size_t room = scene->meshes.count * 6, count = 0;
    buffer *all = malloc((room + 1) * sizeof *all);
    if (!all) return fail_memory(scene->context, room * sizeof *all);
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *m = &scene->meshes.items[i];
        const uint64_t index_bytes = (uint64_t)m->triangle_count * 3 * sizeof(uint32_t);
        const buffer buffers[] = {{m->positions, (uint64_t)m->vertex_count * m->position_stride},
                                  {m->indices, index_bytes},
                                  {m->normals, (uint64_t)m->normal_count * m->normal_stride},
                                  {m->normal_indices, index_bytes},
                                  {m->uvs, (uint64_t)m->uv_count * m->uv_stride},
                                  {m->uv_indices, index_bytes}};
        for (size_t k = 0; k < 6; ++k) {
            if (buffers[k].start) all[count++] = buffers[k];
        }
    }
    qsort(all, count, sizeof *all, by_start);
    *out = 0;
    for (size_t i = 0; i < count; ++i) {
        if (i + 1 == count || all[i + 1].start != all[i].start) *out += all[i].bytes;
    }
    free(all);
    return FATHOM_OK;
}
