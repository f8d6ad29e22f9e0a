#include "read/obj/obj.h"

#include "base/threads.h"
#include "read/mesh/number.h"

#include <stdlib.h>
#include <string.h>

/* ---- the scan ---- */

static bool is_keyword(const char *p, const char *keyword, size_t length) {
    for (size_t i = 0; i < length; ++i) {
        if (p[i] != keyword[i]) return false;
    }
    return text_is_break(p[length]);
}

obj_statement obj_classify(const char **p) {
    static const char paint[] = "#MRGB";
    static const struct {
        const char *keyword;
        size_t length;
        obj_statement statement;
    } keywords[] = {
        {"v", 1, OBJ_S_POSITION},     {"vt", 2, OBJ_S_UV},           {"vn", 2, OBJ_S_NORMAL},
        {"f", 1, OBJ_S_FACE},         {"g", 1, OBJ_S_GROUP},         {"o", 1, OBJ_S_OBJECT},
        {"s", 1, OBJ_S_SMOOTHING},    {"usemtl", 6, OBJ_S_MATERIAL}, {"l", 1, OBJ_S_LINE},
        {"mtllib", 6, OBJ_S_LIBRARY}, {"p", 1, OBJ_S_POINT},         {paint, sizeof paint - 1, OBJ_S_PAINT}};
    const char *at = text_skip(*p);
    *p = at;
    if (*at == '\n') return OBJ_S_EMPTY;
    if (*at == '#' && !is_keyword(at, paint, sizeof paint - 1)) return OBJ_S_EMPTY;
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; ++i) {
        if (!is_keyword(at, keywords[i].keyword, keywords[i].length)) continue;
        *p = at + keywords[i].length;
        return keywords[i].statement;
    }
    return OBJ_S_UNKNOWN;
}

const char *obj_next(obj_statement statement, const char *p, const char *end) {
    if (statement != OBJ_S_EMPTY && statement != OBJ_S_PAINT) return text_next(p, end);
    const char *newline = memchr(p, '\n', (size_t)(end - p));
    return newline ? newline + 1 : end;
}

bool obj_smoothing_group(const char *p, uint32_t *group) {
    p = text_skip(p);
    int64_t number = 0;
    if (text_is_end(*p))
        ; /* not a number; some programs write this instead of "off" */
    else if (strncmp(p, "off", 3) == 0)
        p += 3;
    else if (strncmp(p, "on", 2) == 0)
        number = 1, p += 2;
    else if (!number_read_integer(&p, &number))
        return false;
    if (!text_is_break(*p) || number < 0 || number >= OBJ_ALL_GROUPS) return false;
    *group = (uint32_t)number;
    return true;
}

static obj_mention mention(obj_statement statement, const char *p, const char *end) {
    size_t length = text_rest(&p, end);
    return (obj_mention){.at = p, .length = length, .slot = statement};
}

static void scan_piece(obj_reader *r, obj_piece *piece) {
    if (!text_has_no_zeros(&r->fault, piece->begin, piece->end)) return;
    for (const char *p = piece->begin; p < piece->end;) {
        obj_statement statement = obj_classify(&p);
        bool fine = true;
        switch (statement) {
        case OBJ_S_POSITION: ++piece->count[OBJ_POSITION]; break;
        case OBJ_S_UV: ++piece->count[OBJ_UV]; break;
        case OBJ_S_NORMAL: ++piece->count[OBJ_NORMAL]; break;
        case OBJ_S_MATERIAL: fine = array_push(&piece->materials, mention(statement, p, piece->end)); break;
        case OBJ_S_LIBRARY: fine = array_push(&piece->libraries, mention(statement, p, piece->end)); break;
        case OBJ_S_PAINT: fine = array_push(&piece->paint, mention(statement, p, piece->end)); break;
        case OBJ_S_OBJECT:
        case OBJ_S_GROUP: fine = array_push(&piece->objects, mention(statement, p, piece->end)); break;
        case OBJ_S_SMOOTHING:
            /* The parse reports an invalid group. */
            if (obj_smoothing_group(p, &piece->last_group)) piece->sets_group = true;
            break;
        case OBJ_S_EMPTY:
        case OBJ_S_FACE:
        case OBJ_S_LINE:
        case OBJ_S_POINT:
        case OBJ_S_UNKNOWN: break;
        }
        if (!fine) text_no_memory(&r->fault);
        p = obj_next(statement, p, piece->end);
    }
}

static void scan_pieces(void *user, size_t begin, size_t end) {
    obj_reader *r = user;
    for (size_t i = begin; i < end; ++i) scan_piece(r, &r->pieces[i]);
}

/* Numbers the objects. Groups are objects in a file without any: some programs write only those. */
static bool number_object(obj_reader *r, obj_statement kind, obj_mention *named) {
    const obj_mention *last = r->objects.count ? &r->objects.items[r->objects.count - 1] : NULL;
    const bool counts = named->slot == kind && !(last && obj_same_mention(last, named));
    if (counts && !array_push(&r->objects, *named)) return false;
    named->slot = (uint32_t)r->objects.count;
    return true;
}

static obj_statement object_kind(const obj_reader *r) {
    for (size_t i = 0; i < r->piece_count; ++i) {
        for (size_t k = 0; k < r->pieces[i].objects.count; ++k)
            if (r->pieces[i].objects.items[k].slot == OBJ_S_OBJECT) return OBJ_S_OBJECT;
    }
    return OBJ_S_GROUP;
}

/* Finds the state at the start of each piece: number of vertices, material, object, smoothing group. */
static fathom_status carry_over(obj_reader *r) {
    uint32_t slot = 0, group = 0;
    const obj_statement kind = object_kind(r);
    for (size_t i = 0; i < r->piece_count; ++i) {
        obj_piece *piece = &r->pieces[i];
        for (int k = 0; k < OBJ_KINDS; ++k) {
            piece->base[k] = r->total[k];
            r->total[k] += piece->count[k];
        }
        piece->first_slot = slot;
        piece->first_object = (uint32_t)r->objects.count;
        piece->first_group = group;
        for (size_t m = 0; m < piece->materials.count; ++m) {
            obj_mention *named = &piece->materials.items[m];
            uint32_t name = names_add(&r->names, named->at, named->length);
            if (name == UINT32_MAX) return fail_memory(r->scene->context, named->length);
            slot = named->slot = name + 1;
        }
        for (size_t m = 0; m < piece->objects.count; ++m) {
            if (!number_object(r, kind, &piece->objects.items[m]))
                return fail_memory(r->scene->context, sizeof(obj_mention));
        }
        if (piece->sets_group) group = piece->last_group;
    }
    return FATHOM_OK;
}

static fathom_status scan(obj_reader *r) {
    static const char *const kinds[] = {"vertices", "texture coordinates", "normals"};
    loop_parallel(r->threads, r->piece_count, 1, scan_pieces, r);
    fathom_status status = text_status(&r->file, &r->fault);
    if (status == FATHOM_OK) status = carry_over(r);
    for (int k = 0; k < OBJ_KINDS && status == FATHOM_OK; ++k) {
        if (r->total[k] < UINT32_MAX) continue;
        status = fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                           "it has %llu %s; at most 2^32 - 2 can be indexed", (unsigned long long)r->total[k],
                           kinds[k]);
    }
    return status;
}

/* ---- the file ---- */

#ifndef OBJ_PIECE /* fuzzing sets a small size, so that small files have several pieces */
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

/* Adds up the tallies of the pieces as notes. */
static void note_tallies(obj_reader *r) {
    static const char *const texts[OBJ_TALLIES] = {
        [OBJ_T_LINES] = "lines have no width, and are shown as thin rods",
        [OBJ_T_POINTS] = "points have no size, and are shown as small spheres",
        [OBJ_T_SHORT] = "lines of less than 2 corners are left out",
        [OBJ_T_SMALL] = "faces of less than 3 corners are left out",
        [OBJ_T_MIXED] = "a face has uvs or normals at some corners and not at others; it gets none",
        [OBJ_T_ODD] = "a NaN or an infinity in vt or vn is taken as 0",
        [OBJ_T_LOST] =
            "a vertex with a NaN, an infinity or a number beyond float is left out, with what uses it",
        [OBJ_T_ALPHA] = "the alpha of a vertex is left out; glTF and PLY files can have one",
        [OBJ_T_BEHIND] = "what follows x y z of a vertex is not read",
        [OBJ_T_NO_UV] = "vt: a face names texture coordinates that the file does not have; it gets none",
        [OBJ_T_NO_NORMAL] = "vn: a face names normals that the file does not have; it gets none",
        [OBJ_T_UNKNOWN] = "statements that are not read are left out"};
    for (int k = 0; k < OBJ_TALLIES; ++k) {
        for (size_t i = 0; i < r->piece_count; ++i) {
            const obj_tally *t = &r->pieces[i].tallies[k];
            notes_add_at(&r->notes, t->count, &r->file, t->first, k >= OBJ_T_ODD, "%s", texts[k]);
        }
    }
}

static fathom_status read_mapped(obj_reader *r) {
    fathom_status status = cut_pieces(r);
    if (status == FATHOM_OK) status = scan(r);
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
        array_free(&piece->paint);
        array_free(&piece->objects);
        array_free(&piece->runs);
        array_free(&piece->polygons);
        for (int k = 0; k < OBJ_KINDS; ++k) array_free(&piece->corners[k]);
        for (int k = 0; k < OBJ_STROKES; ++k)
            array_free(&piece->strokes[k].corners), array_free(&piece->strokes[k].runs);
    }
    free(r->pieces);
    for (int k = 0; k < OBJ_KINDS; ++k) {
        if (!r->adopted[k]) free(r->values[k]);
    }
    names_free(&r->names);
    array_free(&r->slots);
    array_free(&r->objects);
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
