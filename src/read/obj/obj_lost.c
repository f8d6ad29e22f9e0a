/* Removes vertices that are not finite, and what uses them. The parse makes all three numbers NaN. */
#include "read/mesh/lost.h"
#include "read/obj/obj.h"

static void drop_faces(const obj_reader *r, obj_piece *piece) {
    for (size_t k = 0; k < piece->runs.count; ++k) {
        obj_run *run = &piece->runs.items[k];
        lost_rows corners[OBJ_KINDS];
        for (int kind = 0; kind < OBJ_KINDS; ++kind) {
            uint32_t *all = piece->corners[kind].count ? piece->corners[kind].items : NULL;
            corners[kind] = (lost_rows){all ? all + 3 * run->first : NULL, 3 * sizeof *all};
        }
        run->count = lost_drop(r->values[OBJ_POSITION], corners[OBJ_POSITION].rows, 3, run->count,
                               &corners[OBJ_POSITION + 1]);
    }
}

/* each: corners of a point or a line. */
static void drop_strokes(const obj_reader *r, obj_strokes *strokes, size_t each) {
    static const lost_rows none[2] = {{NULL, 0}, {NULL, 0}};
    for (size_t k = 0; k < strokes->runs.count; ++k) {
        obj_stroke_run *run = &strokes->runs.items[k];
        run->count = each * lost_drop(r->values[OBJ_POSITION], strokes->corners.items + run->first, each,
                                      run->count / each, none);
    }
}

fathom_status obj_drop_lost(obj_reader *r) {
    const lost_rows colors = {r->colors, 3 * sizeof(float)};
    float *positions = r->values[OBJ_POSITION];
    size_t lost = 0;
    for (size_t i = 0; i < r->piece_count; ++i) lost += r->pieces[i].tallies[OBJ_T_LOST].count;
    if (!lost) return FATHOM_OK;
    for (size_t i = 0; i < r->piece_count; ++i) {
        drop_faces(r, &r->pieces[i]);
        drop_strokes(r, &r->pieces[i].strokes[OBJ_POINTS], 1);
        drop_strokes(r, &r->pieces[i].strokes[OBJ_LINES], 2);
    }
    if (r->cloud) r->total[OBJ_POSITION] = lost_drop_points(positions, r->total[OBJ_POSITION], &colors);
    if (lost_mend(positions, r->total[OBJ_POSITION])) return FATHOM_OK;
    return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                     "it has no vertex of finite numbers that fit a float, of %zu", lost);
}
