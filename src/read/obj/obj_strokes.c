/* Turns points and lines into spheres and rods: one mesh for each material. */
#include "read/mesh/strokes.h"
#include "read/obj/obj.h"

#include <stdlib.h>
#include <string.h>

/* Points or lines of the whole file, by material. */
typedef struct stroke_sorter {
    obj_reader *r;
    int kind;
    size_t *ends;      /* end of each slot's corners; during the sort, the next free position */
    uint32_t *corners; /* indices of positions */
} stroke_sorter;

static fathom_status add_slot(const stroke_sorter *s, uint32_t slot, const uint32_t *corners, size_t count) {
    obj_reader *r = s->r;
    const size_t each = s->kind == OBJ_LINES ? 2 : 1;
    const strokes drawn = {.positions = r->values[OBJ_POSITION],
                           .position_stride = 3 * sizeof(float),
                           .colors = r->colors,
                           .color_stride = 3 * sizeof(float),
                           .color_channels = 3,
                           .indices = corners,
                           .count = (uint32_t)(count / each),
                           .lines = s->kind == OBJ_LINES,
                           .notes = &s->r->notes};
    fathom_mesh mesh;
    mesh_facts facts;
    fathom_mesh_default(&mesh);
    fathom_status status =
        count / each < UINT32_MAX
            ? strokes_make(r->scene, &drawn, &mesh)
            : fail(r->scene->context, FATHOM_BAD_INPUT,
                   "has %zu points or lines of one material; more than can be shown", count / each);
    if (status != FATHOM_OK)
        return fail_within(r->scene->context, status, &(fathom_place){.file = r->file.path});
    if (!strokes_any(&mesh)) return FATHOM_OK;
    status = mesh_look_at_vertices(r->scene->context, r->file.path, mesh.positions, mesh.position_stride,
                                   mesh.vertex_count, &facts);
    return status == FATHOM_OK ? obj_add_mesh(r, slot, &mesh, facts) : status;
}

/* Sorts the corners by material, in the order of the file: counts, then copies. */
static void sort_corners(stroke_sorter *s) {
    const obj_slot *slots = s->r->slots.items;
    size_t before = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (size_t i = 0; i < s->r->piece_count; ++i) {
            const obj_strokes *from = &s->r->pieces[i].strokes[s->kind];
            for (size_t k = 0; k < from->runs.count; ++k) {
                const obj_stroke_run *run = &from->runs.items[k];
                size_t *at = &s->ends[slots[run->slot].same_as];
                if (pass)
                    memcpy(s->corners + *at, from->corners.items + run->first,
                           run->count * sizeof *s->corners);
                *at += run->count;
            }
        }
        for (size_t slot = 0; !pass && slot < s->r->slots.count; ++slot) {
            const size_t count = s->ends[slot];
            s->ends[slot] = before;
            before += count;
        }
    }
}

static fathom_status add_kind(obj_reader *r, int kind, bool *added) {
    stroke_sorter s = {.r = r, .kind = kind};
    size_t count = 0, begin = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        for (size_t k = 0; k < r->pieces[i].strokes[kind].runs.count; ++k)
            count += r->pieces[i].strokes[kind].runs.items[k].count;
    }
    if (!count) return FATHOM_OK;
    s.ends = calloc(r->slots.count, sizeof *s.ends);
    s.corners = malloc(count * sizeof *s.corners);
    fathom_status status =
        s.ends && s.corners ? FATHOM_OK : fail_memory(r->scene->context, count * sizeof *s.corners);
    if (status == FATHOM_OK) sort_corners(&s);
    for (uint32_t slot = 0; status == FATHOM_OK && slot < r->slots.count; begin = s.ends[slot++]) {
        if (s.ends[slot] > begin) status = add_slot(&s, slot, s.corners + begin, s.ends[slot] - begin);
    }
    free(s.ends);
    free(s.corners);
    *added = true;
    return status;
}

/* Adds all vertices as points: scanning software writes files with only vertices. */
static fathom_status add_cloud(obj_reader *r) {
    const stroke_sorter s = {.r = r, .kind = OBJ_POINTS};
    notes_add(&r->notes, (size_t)r->total[OBJ_POSITION], "",
              "vertices without faces are points; they have no size, and are shown as small spheres");
    r->adopted[OBJ_POSITION] = true;
    const fathom_status status = scene_adopt(r->scene, r->values[OBJ_POSITION], free);
    return status != FATHOM_OK ? status : add_slot(&s, 0, NULL, (size_t)r->total[OBJ_POSITION]);
}

fathom_status obj_add_strokes(obj_reader *r, bool *added) {
    *added = false;
    fathom_status status = add_kind(r, OBJ_POINTS, added);
    if (status == FATHOM_OK) status = add_kind(r, OBJ_LINES, added);
    if (status != FATHOM_OK || *added || !r->cloud) return status;
    *added = true;
    return add_cloud(r);
}
