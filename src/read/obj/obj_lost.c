/* Removes vertices that are not finite, which scanners and simulations write, and the faces that use them. */
#include "read/obj/obj.h"

#include <string.h>

static const float *position_of(const obj_reader *r, uint64_t vertex) {
    return r->values[OBJ_POSITION] + 3 * vertex;
}

/* The parse makes all three numbers NaN. */
static bool is_lost(const obj_reader *r, uint64_t vertex) { return isnan(*position_of(r, vertex)); }

static bool uses_lost(const obj_reader *r, const uint32_t *vertices, size_t count) {
    bool any = false;
    for (size_t i = 0; i < count; ++i) any |= is_lost(r, vertices[i]);
    return any;
}

static void move_triangles(obj_piece *piece, size_t from, size_t to, size_t count) {
    for (int kind = 0; kind < OBJ_KINDS; ++kind) {
        uint32_t *corners = piece->corners[kind].items;
        if (piece->corners[kind].count)
            memmove(corners + 3 * to, corners + 3 * from, 3 * count * sizeof *corners);
    }
}

/* Drops whole faces, whose polygons are still fans. */
static void drop_faces(const obj_reader *r, obj_piece *piece) {
    size_t kept = 0, runs = 0, polygon = 0, polygons = 0, count;
    for (size_t k = 0; k < piece->runs.count; ++k) {
        obj_run run = piece->runs.items[k];
        const size_t end = run.first + run.count;
        size_t from = run.first;
        run.first = kept;
        for (; from < end; from += count) {
            const bool is_polygon =
                polygon < piece->polygons.count && piece->polygons.items[polygon].first == from;
            const uint32_t corners = is_polygon ? piece->polygons.items[polygon++].corners : 3;
            count = corners - 2;
            if (uses_lost(r, piece->corners[OBJ_POSITION].items + 3 * from, 3 * count)) continue;
            if (is_polygon) piece->polygons.items[polygons++] = (polygon_fan){kept, corners};
            move_triangles(piece, from, kept, count);
            kept += count;
        }
        run.count = kept - run.first;
        if (run.count) piece->runs.items[runs++] = run;
    }
    piece->runs.count = runs, piece->polygons.count = polygons;
    for (int kind = 0; kind < OBJ_KINDS; ++kind) {
        if (piece->corners[kind].count) piece->corners[kind].count = 3 * kept;
    }
}

/* each: corners of a point or a line. */
static void drop_strokes(const obj_reader *r, obj_strokes *strokes, size_t each) {
    uint32_t *corners = strokes->corners.items;
    size_t kept = 0;
    for (size_t k = 0; k < strokes->runs.count; ++k) {
        obj_stroke_run *run = &strokes->runs.items[k];
        const size_t from = run->first, end = from + run->count;
        run->first = kept;
        for (size_t i = from; i < end; i += each) {
            if (uses_lost(r, corners + i, each)) continue;
            memmove(corners + kept, corners + i, each * sizeof *corners);
            kept += each;
        }
        run->count = kept - run->first;
    }
    strokes->corners.count = kept;
}

/* A cloud's points have no indices: the later ones move down. */
static void drop_points(obj_reader *r) {
    uint64_t kept = 0;
    for (uint64_t i = 0; i < r->total[OBJ_POSITION]; ++i) {
        if (is_lost(r, i)) continue;
        memmove(r->values[OBJ_POSITION] + 3 * kept, position_of(r, i), 3 * sizeof(float));
        if (r->colors) memmove(r->colors + 3 * kept, r->colors + 3 * i, 3 * sizeof(float));
        ++kept;
    }
    r->total[OBJ_POSITION] = kept;
}

/* Nothing uses them any more; where another vertex is, they change no bounds. False when all are lost. */
static bool mend(obj_reader *r) {
    uint64_t good = 0;
    while (good < r->total[OBJ_POSITION] && is_lost(r, good)) ++good;
    if (good == r->total[OBJ_POSITION]) return false;
    for (uint64_t i = 0; i < r->total[OBJ_POSITION]; ++i) {
        if (is_lost(r, i)) memcpy(r->values[OBJ_POSITION] + 3 * i, position_of(r, good), 3 * sizeof(float));
    }
    return true;
}

fathom_status obj_drop_lost(obj_reader *r) {
    size_t lost = 0;
    for (size_t i = 0; i < r->piece_count; ++i) lost += r->pieces[i].tallies[OBJ_T_LOST].count;
    if (!lost) return FATHOM_OK;
    for (size_t i = 0; i < r->piece_count; ++i) {
        drop_faces(r, &r->pieces[i]);
        drop_strokes(r, &r->pieces[i].strokes[OBJ_POINTS], 1);
        drop_strokes(r, &r->pieces[i].strokes[OBJ_LINES], 2);
    }
    if (r->cloud) drop_points(r);
    if (mend(r)) return FATHOM_OK;
    return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                     "it has no vertex of finite numbers that fit a float, of %zu", lost);
}
