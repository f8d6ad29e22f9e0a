#include "read/obj/obj.h"

#include "read/mesh/normals.h"
#include "read/mesh/weld.h"

#include <stdlib.h>
#include <string.h>

/* A vertex gets one normal for each smoothing group of its faces. */
typedef struct smooth_faces {
    size_t triangle_count;
    uint32_t group;    /* of the first run */
    bool one_group;    /* all runs are in it; then a normal has the index of its vertex */
    uint32_t *indices; /* of the triangles to smooth, in the order of the file */
    uint32_t *slots;   /* for each index, then the group of each triangle; NULL with one group */
    uint32_t slot_count;
} smooth_faces;

typedef struct run_cursor {
    size_t piece, run;
} run_cursor;

/* The next run to smooth, NULL after the last. Start from {0, 0}. */
static obj_run *next_run(const obj_reader *r, run_cursor *c, obj_piece **piece) {
    for (; c->piece < r->piece_count; ++c->piece, c->run = 0) {
        *piece = &r->pieces[c->piece];
        while (c->run < (*piece)->runs.count) {
            obj_run *run = &(*piece)->runs.items[c->run++];
            if (run->group) return run;
        }
    }
    return NULL;
}

static void count_faces(const obj_reader *r, smooth_faces *faces) {
    faces->one_group = true;
    run_cursor cursor = {0, 0};
    obj_piece *piece;
    for (const obj_run *run; (run = next_run(r, &cursor, &piece)) != NULL;) {
        if (!faces->triangle_count) faces->group = run->group;
        if (run->group != faces->group) faces->one_group = false;
        faces->triangle_count += run->count;
    }
}

static fathom_status gather_indices(const obj_reader *r, smooth_faces *faces) {
    size_t bytes = faces->triangle_count * 3 * sizeof *faces->indices;
    faces->indices = malloc(bytes);
    if (!faces->indices) return fail_memory(r->scene->context, bytes);
    run_cursor cursor = {0, 0};
    obj_piece *piece;
    uint32_t *out = faces->indices;
    for (const obj_run *run; (run = next_run(r, &cursor, &piece)) != NULL; out += 3 * run->count) {
        memcpy(out, piece->corners[OBJ_POSITION].items + 3 * run->first, 3 * run->count * sizeof *out);
    }
    faces->slot_count = (uint32_t)r->total[OBJ_POSITION];
    return FATHOM_OK;
}

static void gather_groups(const obj_reader *r, uint32_t *out) {
    run_cursor cursor = {0, 0};
    obj_piece *piece;
    for (const obj_run *run; (run = next_run(r, &cursor, &piece)) != NULL;) {
        for (size_t i = 0; i < run->count; ++i) *out++ = run->group;
    }
}

static fathom_status make_slots(const obj_reader *r, smooth_faces *faces) {
    if (faces->one_group) return FATHOM_OK;
    const size_t corners = 3 * faces->triangle_count,
                 bytes = 4 * faces->triangle_count * sizeof *faces->slots;
    faces->slots = malloc(bytes);
    if (!faces->slots) return fail_memory(r->scene->context, bytes);
    uint32_t *groups = faces->slots + corners;
    gather_groups(r, groups);
    weld w = {.vertices = faces->indices,
              .corners = corners,
              .vertex_count = (uint32_t)r->total[OBJ_POSITION],
              .values = groups,
              .stride = sizeof *groups,
              .bytes = sizeof *groups};
    const fathom_status status = weld_corners(r->scene->context, &w, NULL, faces->slots);
    faces->slot_count = (uint32_t)w.pairs.count;
    array_free(&w.pairs);
    return status;
}

/* Appends the normals to the file's own. */
static fathom_status make_normals(obj_reader *r, const smooth_faces *faces) {
    fathom_context *context = r->scene->context;
    size_t before = (size_t)r->total[OBJ_NORMAL], count = before + faces->slot_count;
    if (count >= UINT32_MAX || faces->triangle_count >= UINT32_MAX)
        return fail_file(context, FATHOM_BAD_INPUT, r->file.path,
                         "too many smooth triangles or normals: expected at most 2^32 - 2");
    size_t bytes = count * 3 * sizeof(float) + 16;
    float *normals = realloc(r->values[OBJ_NORMAL], bytes);
    if (!normals) return fail_memory(context, bytes);
    r->values[OBJ_NORMAL] = normals;
    r->total[OBJ_NORMAL] = count;
    const fathom_mesh mesh = {.positions = r->values[OBJ_POSITION],
                              .position_stride = 3 * sizeof(float),
                              .indices = faces->indices,
                              .triangle_count = (uint32_t)faces->triangle_count};
    return normals_smooth(context, &mesh, faces->slots, faces->slot_count, normals + 3 * before);
}

static fathom_status point_at_normals(obj_reader *r, const smooth_faces *faces) {
    uint32_t before = (uint32_t)(r->total[OBJ_NORMAL] - faces->slot_count);
    const uint32_t *slots = faces->slots ? faces->slots : faces->indices;
    bool same = !faces->slots && before == 0;
    run_cursor cursor = {0, 0};
    obj_piece *piece;
    for (obj_run *run; (run = next_run(r, &cursor, &piece)) != NULL; slots += 3 * run->count) {
        run->has[OBJ_NORMAL] = true;
        run->same[OBJ_NORMAL] = same;
        if (same) continue;
        if (!obj_keep_indices(piece, OBJ_NORMAL))
            return fail_memory(r->scene->context, piece->corners[OBJ_POSITION].count);
        uint32_t *out = piece->corners[OBJ_NORMAL].items + 3 * run->first;
        for (size_t i = 0; i < 3 * run->count; ++i) out[i] = before + slots[i];
    }
    return FATHOM_OK;
}

fathom_status obj_smooth(obj_reader *r) {
    smooth_faces faces = {0};
    count_faces(r, &faces);
    if (!faces.triangle_count) return FATHOM_OK;
    fathom_status status = gather_indices(r, &faces);
    if (status == FATHOM_OK) status = make_slots(r, &faces);
    if (status == FATHOM_OK) status = make_normals(r, &faces);
    if (status == FATHOM_OK) status = point_at_normals(r, &faces);
    free(faces.indices);
    free(faces.slots);
    return status;
}
