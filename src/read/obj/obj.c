#include "read/obj/obj.h"

#include <stdlib.h>

#ifndef OBJ_PIECE /* fuzzing cuts small files */
#define OBJ_PIECE ((size_t)1 << 18)
#endif

static fathom_status cut_pieces(obj_reader *r) {
    size_t *starts = text_pieces(&r->file, OBJ_PIECE, &r->piece_count);
    r->pieces = starts ? calloc(r->piece_count, sizeof *r->pieces) : NULL;
    for (size_t i = 0; r->pieces && i < r->piece_count; ++i) {
        r->pieces[i].begin = r->file.begin + starts[i];
        r->pieces[i].end = r->file.begin + starts[i + 1];
    }
    free(starts);
    return r->pieces ? FATHOM_OK : fail_memory(r->scene->context, r->piece_count * sizeof *r->pieces);
}

static void add_tally(obj_tally *sum, const obj_tally *of_piece) {
    if (!sum->count) sum->first = of_piece->first;
    sum->count += of_piece->count;
}

static void warn_tally(const obj_reader *r, const obj_tally *t, const char *what) {
    if (!t->count) return;
    char quote[48];
    warn(r->scene->context, "%s:%zu: %s (%zu such, the first here: %s)", r->file.path,
         text_line(&r->file, t->first), what, t->count, text_quote(t->first, quote));
}

/* What was passed over, once for each kind. */
static void warn_of_rest(const obj_reader *r) {
    obj_tally lines = {0}, small = {0}, unknown = {0};
    for (size_t i = 0; i < r->piece_count; ++i) {
        add_tally(&lines, &r->pieces[i].lines);
        add_tally(&small, &r->pieces[i].small);
        add_tally(&unknown, &r->pieces[i].unknown);
    }
    warn_tally(r, &lines, "lines and points are not rendered");
    warn_tally(r, &small, "faces of less than 3 corners are left out");
    warn_tally(r, &unknown, "statements that are not read are left out");
}

static fathom_status read_mapped(obj_reader *r) {
    fathom_status status = cut_pieces(r);
    if (status == FATHOM_OK) status = obj_scan(r);
    if (status == FATHOM_OK) status = obj_find_materials(r);
    if (status == FATHOM_OK) status = obj_parse(r);
    if (status == FATHOM_OK) status = obj_smooth(r);
    if (status == FATHOM_OK) status = obj_build(r);
    if (status == FATHOM_OK) warn_of_rest(r);
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
    const char *text = (const char *)map.bytes;
    obj_reader r = {.scene = scene,
                    .group = group,
                    .options = *options,
                    .file = {scene->context, path, text, text + map.size},
                    .threads = fathom_context_threads(scene->context)};
    status = text_check_hole(&r.file, &map);
    if (status == FATHOM_OK) status = read_mapped(&r);
    release(&r);
    return file_finish(scene->context, &map, status);
}
