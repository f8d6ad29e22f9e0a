#include "read/obj/obj.h"

#include <stdlib.h>

#ifndef OBJ_PIECE /* fuzzing cuts small files */
#define OBJ_PIECE ((size_t)1 << 18)
#endif

static fathom_status cut_pieces(obj_reader *r) {
    const char **starts = text_pieces(&r->file, OBJ_PIECE, &r->piece_count);
    r->pieces = starts ? calloc(r->piece_count + 1, sizeof *r->pieces) : NULL;
    for (size_t i = 0; r->pieces && i < r->piece_count; ++i)
        r->pieces[i].begin = starts[i], r->pieces[i].end = starts[i + 1];
    free(starts);
    return r->pieces ? FATHOM_OK : fail_memory(r->scene->context, r->piece_count * sizeof *r->pieces);
}

/* Joins what the pieces counted. */
static void note_tallies(obj_reader *r) {
    static const char *const texts[OBJ_TALLIES] = {
        [OBJ_T_LINES] = "lines and points are not rendered",
        [OBJ_T_SMALL] = "faces of less than 3 corners are left out",
        [OBJ_T_COLORS] = "vertex colours are not used",
        [OBJ_T_BEHIND] = "what follows x y z of a vertex is not read",
        [OBJ_T_NO_UV] = "vt: a face names texture coordinates that the file does not have; it gets none",
        [OBJ_T_NO_NORMAL] = "vn: a face names normals that the file does not have; it gets none",
        [OBJ_T_UNKNOWN] = "statements that are not read are left out"};
    for (int k = 0; k < OBJ_TALLIES; ++k) {
        for (size_t i = 0; i < r->piece_count; ++i) {
            const obj_tally *t = &r->pieces[i].tallies[k];
            notes_add_at(&r->notes, t->count, &r->file, t->first, true, "%s", texts[k]);
        }
    }
}

static fathom_status read_mapped(obj_reader *r) {
    fathom_status status = cut_pieces(r);
    if (status == FATHOM_OK) status = obj_scan(r);
    if (status == FATHOM_OK) status = obj_find_materials(r);
    if (status == FATHOM_OK) status = obj_parse(r);
    if (status == FATHOM_OK) status = obj_smooth(r);
    if (status == FATHOM_OK) status = obj_build(r);
    if (status != FATHOM_OK) return status;
    note_tallies(r);
    notes_tell(&r->notes, r->scene->context, r->file.path);
    return status;
}

static void release(obj_reader *r) {
    for (size_t i = 0; r->pieces && i < r->piece_count; ++i) {
        obj_piece *piece = &r->pieces[i];
        array_free(&piece->materials);
        array_free(&piece->libraries);
        array_free(&piece->runs);
        array_free(&piece->polygons);
        for (int k = 0; k < OBJ_KINDS; ++k) array_free(&piece->corners[k]);
    }
    free(r->pieces);
    for (int k = 0; k < OBJ_KINDS; ++k) {
        if (!r->adopted[k]) free(r->values[k]);
    }
    names_free(&r->names);
    array_free(&r->slots);
}

fathom_status read_obj(fathom_scene *scene, fathom_id group, const char *path,
                       const read_mesh_options *options) {
    file_map map;
    fathom_status status = file_open(scene->context, path, &map);
    if (status != FATHOM_OK) return status;
    obj_reader r = {.scene = scene,
                    .group = group,
                    .options = *options,
                    .threads = fathom_context_threads(scene->context)};
    status = text_open(scene->context, path, &map, &r.file);
    if (status == FATHOM_OK) status = read_mapped(&r);
    release(&r);
    text_close(&r.file);
    return file_finish(scene->context, &map, status);
}
