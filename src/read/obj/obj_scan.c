#include "read/obj/obj.h"

#include "base/threads.h"
#include "read/mesh/number.h"

#include <string.h>

static bool is_keyword(const char *p, const char *keyword, size_t length) {
    for (size_t i = 0; i < length; ++i) {
        if (p[i] != keyword[i]) return false;
    }
    return text_is_break(p[length]);
}

obj_statement obj_classify(const char **p) {
    static const struct {
        const char *keyword;
        size_t length;
        obj_statement statement;
    } keywords[] = {{"v", 1, OBJ_S_POSITION},     {"vt", 2, OBJ_S_UV},           {"vn", 2, OBJ_S_NORMAL},
                    {"f", 1, OBJ_S_FACE},         {"g", 1, OBJ_S_NAME},          {"o", 1, OBJ_S_NAME},
                    {"s", 1, OBJ_S_SMOOTHING},    {"usemtl", 6, OBJ_S_MATERIAL}, {"l", 1, OBJ_S_LINE},
                    {"mtllib", 6, OBJ_S_LIBRARY}, {"p", 1, OBJ_S_LINE}};
    const char *at = text_skip(*p);
    *p = at;
    if (*at == '\n' || *at == '#') return OBJ_S_EMPTY;
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; ++i) {
        if (!is_keyword(at, keywords[i].keyword, keywords[i].length)) continue;
        *p = at + keywords[i].length;
        return keywords[i].statement;
    }
    return OBJ_S_UNKNOWN;
}

const char *obj_next(obj_statement statement, const char *p, const char *end) {
    if (statement != OBJ_S_EMPTY) return text_next(p, end);
    const char *newline = memchr(p, '\n', (size_t)(end - p));
    return newline ? newline + 1 : end;
}

bool obj_smoothing_group(const char *p, uint32_t *group) {
    p = text_skip(p);
    int64_t number = 0;
    if (strncmp(p, "off", 3) == 0)
        p += 3;
    else if (strncmp(p, "on", 2) == 0)
        number = 1, p += 2;
    else if (!number_read_integer(&p, &number))
        return false;
    if (!text_is_break(*p) || number < 0 || number >= OBJ_ALL_GROUPS) return false;
    *group = (uint32_t)number;
    return true;
}

static obj_mention mention(const char *p, const char *end) {
    size_t length = text_rest(&p, end);
    return (obj_mention){.at = p, .length = length};
}

static void scan_piece(obj_reader *r, obj_piece *piece) {
    if (!text_has_no_zeros(&r->fault, piece->begin, piece->end)) return;
    for (const char *p = piece->begin; p < piece->end;) {
        obj_statement statement = obj_classify(&p);
        switch (statement) {
        case OBJ_S_POSITION: ++piece->count[OBJ_POSITION]; break;
        case OBJ_S_UV: ++piece->count[OBJ_UV]; break;
        case OBJ_S_NORMAL: ++piece->count[OBJ_NORMAL]; break;
        case OBJ_S_MATERIAL:
            if (!array_push(&piece->materials, mention(p, piece->end))) text_no_memory(&r->fault);
            break;
        case OBJ_S_LIBRARY:
            if (!array_push(&piece->libraries, mention(p, piece->end))) text_no_memory(&r->fault);
            break;
        case OBJ_S_SMOOTHING:
            /* A wrong one is reported by the parse. */
            if (obj_smoothing_group(p, &piece->last_group)) piece->sets_group = true;
            break;
        case OBJ_S_EMPTY:
        case OBJ_S_FACE:
        case OBJ_S_LINE:
        case OBJ_S_NAME:
        case OBJ_S_UNKNOWN: break;
        }
        p = obj_next(statement, p, piece->end);
    }
}

static void scan_pieces(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    obj_reader *r = user;
    for (size_t i = begin; i < end; ++i) scan_piece(r, &r->pieces[i]);
}

/* Finds what precedes each piece: vertices, material, smoothing group. */
static fathom_status carry_over(obj_reader *r) {
    uint32_t slot = 0, group = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        obj_piece *piece = &r->pieces[i];
        for (int k = 0; k < OBJ_KINDS; ++k) {
            piece->base[k] = r->total[k];
            r->total[k] += piece->count[k];
        }
        piece->first_slot = slot;
        piece->first_group = group;
        for (size_t m = 0; m < piece->materials.count; ++m) {
            obj_mention *named = &piece->materials.items[m];
            uint32_t name = names_add(&r->names, named->at, named->length);
            if (name == UINT32_MAX) return fail_memory(r->scene->context, named->length);
            slot = named->slot = name + 1;
        }
        if (piece->sets_group) group = piece->last_group;
    }
    return FATHOM_OK;
}

fathom_status obj_scan(obj_reader *r) {
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
