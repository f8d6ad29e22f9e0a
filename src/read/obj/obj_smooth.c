#include "read/obj/obj.h"

#include "read/mesh/normals.h"

#include <stdlib.h>
#include <string.h>

/* A vertex gets one normal for each smoothing group of its faces. The index of a key is the index of its
 * normal. */
typedef struct smooth_key {
    uint32_t vertex, group;
} smooth_key;

typedef struct smooth_faces {
    size_t triangle_count;
    uint32_t group;    /* of the first run */
    bool one_group;    /* all runs are in it; then a normal has the index of its vertex */
    uint32_t *indices; /* of the triangles to smooth, in the order of the file */
    uint32_t *slots;   /* for each index; NULL with one group */
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

/* A hash table. The file determines the keys, so the hash uses a secret that no file can know, against many
 * collisions. */
typedef struct smooth_table {
    uint32_t *places; /* index of a key + 1; 0: free */
    size_t mask;      /* number of places, a power of two, minus 1 */
    uint64_t secret;
    ARRAY(smooth_key) keys;
} smooth_table;

/* Every bit of the key affects every bit of the place (the finalizer of MurmurHash3). */
static size_t place_of(const smooth_table *t, smooth_key key) {
    uint64_t h = ((uint64_t)key.vertex << 32 | key.group) ^ t->secret;
    h = (h ^ h >> 33) * 0xff51afd7ed558ccdu;
    h = (h ^ h >> 33) * 0xc4ceb9fe1a85ec53u;
    return (size_t)(h ^ h >> 33) & t->mask;
}

/* The index of the key's normal; adds the key if it is new. UINT32_MAX when out of memory, or out of 32-bit
 * indices. */
static uint32_t number_of(smooth_table *t, smooth_key key) {
    size_t place = place_of(t, key);
    for (; t->places[place]; place = (place + 1) & t->mask) {
        const smooth_key *there = &t->keys.items[t->places[place] - 1];
        if (there->vertex == key.vertex && there->group == key.group) return t->places[place] - 1;
    }
    if (t->keys.count >= UINT32_MAX - 1 || !array_push(&t->keys, key)) return UINT32_MAX;
    t->places[place] = (uint32_t)t->keys.count;
    return t->places[place] - 1;
}

static bool fill_slots(const obj_reader *r, smooth_faces *faces, smooth_table *t) {
    run_cursor cursor = {0, 0};
    obj_piece *piece;
    size_t corner = 0;
    for (const obj_run *run; (run = next_run(r, &cursor, &piece)) != NULL;) {
        for (size_t i = 0; i < 3 * run->count; ++i, ++corner) {
            const smooth_key key = {faces->indices[corner], run->group};
            faces->slots[corner] = number_of(t, key);
            if (faces->slots[corner] == UINT32_MAX) return false;
        }
    }
    faces->slot_count = (uint32_t)t->keys.count;
    return true;
}

/* Uses at least twice as many places as corners, because each corner may have its own normal. */
static bool make_table(size_t corners, smooth_table *t) {
    size_t places = 8;
    while (places < 2 * corners) places *= 2;
    t->mask = places - 1;
    t->places = calloc(places, sizeof *t->places);
    t->secret = (uintptr_t)t->places * UINT64_C(0x9e3779b97f4a7c15); /* addresses are randomised */
    return t->places != NULL;
}

static fathom_status make_slots(const obj_reader *r, smooth_faces *faces) {
    if (faces->one_group) return FATHOM_OK;
    smooth_table table = {0};
    size_t corners = faces->triangle_count * 3, bytes = corners * sizeof *faces->slots;
    faces->slots = malloc(bytes);
    bool done = faces->slots && make_table(corners, &table) && fill_slots(r, faces, &table);
    free(table.places);
    array_free(&table.keys);
    return done ? FATHOM_OK : fail_memory(r->scene->context, bytes);
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
