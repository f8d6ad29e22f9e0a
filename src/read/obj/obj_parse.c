#include "read/obj/obj.h"

#include "base/srgb.h"
#include "base/threads.h"
#include "read/mesh/number.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

typedef struct obj_corner {
    uint32_t index[OBJ_KINDS];
} obj_corner;

static const char *const kinds[] = {"v", "vt", "vn"};

/* The state of the parse of a piece. */
typedef struct obj_parser {
    obj_reader *r;
    obj_piece *piece;
    uint64_t seen[OBJ_KINDS]; /* in the whole file */
    uint32_t slot, object, group;
    const char *keyword; /* of the current element: f, l or p */
    unsigned absent;     /* bits of the kinds of indices that the element has, but the file has no data for */
    size_t next_material, next_object;
    ARRAY(obj_corner) face;
} obj_parser;

static void tally(obj_parser *s, int kind, size_t times, const char *at) {
    obj_tally *t = &s->piece->tallies[kind];
    if (!t->count) t->first = text_skip(at);
    t->count += times;
}

/* Reads `count` numbers of a vertex; those after `required` may be missing and are then 0. What is no number
 * is 0, but in a position NaN. NULL after a fault. */
static const char *read_values(obj_parser *s, const char *what, const char *p, int required, int count,
                               double *out) {
    const bool position = what == kinds[OBJ_POSITION];
    for (int i = 0; i < count; ++i) {
        const char *at = text_skip(p);
        p = at;
        out[i] = 0;
        if (i >= required && (text_is_end(*at) || *at == '#')) continue;
        const bool read = number_read(&p, &out[i]) && text_is_break(*p);
        if (read && fabs(out[i]) <= (double)FLT_MAX) continue;
        if (!number_is_odd(at) && !(read && position)) {
            text_found(&s->r->fault, at, what, "number %d of %d: expected %s", i + 1, count,
                       read ? "a finite number that fits a float" : "a number");
            return NULL;
        }
        if (!position) tally(s, OBJ_T_ODD, 1, at);
        out[i] = position ? (double)NAN : 0;
        for (p = at; !text_is_break(*p);) ++p;
    }
    return p;
}

/* Checks that there is room for one more vertex: another process may have changed the file since the scan. */
static bool has_room(obj_parser *s, int kind, const char *at) {
    return s->seen[kind] < s->r->total[kind] ||
           text_wrong(&s->r->fault, at, NULL, "the file has changed since it was counted through");
}

/* Such a vertex is left out later. Vertices may be read again. */
static void lose_odd(obj_parser *s, double v[3], const char *at) {
    if (!isnan(v[0]) && !isnan(v[1]) && !isnan(v[2])) return;
    v[0] = v[1] = v[2] = (double)NAN;
    if (!s->r->again) tally(s, OBJ_T_LOST, 1, at);
}

static const int components[OBJ_KINDS] = {3, 2, 3};

/* A position, uv or normal; the v of a uv may be missing. */
static const char *read_vector(obj_parser *s, int kind, const char *p) {
    double v[3];
    const char *at = p;
    p = read_values(s, kinds[kind], p, kind == OBJ_UV ? 1 : 3, components[kind], v);
    if (!p || !has_room(s, kind, at)) return NULL;
    if (kind == OBJ_POSITION) lose_odd(s, v, at);
    float *out = s->r->values[kind] + (uint64_t)components[kind] * s->seen[kind]++;
    const double origin[3] = {s->r->origin.x, s->r->origin.y, s->r->origin.z};
    for (int k = 0; k < components[kind]; ++k) {
        out[k] = (float)(kind == OBJ_POSITION ? v[k] - origin[k] : v[k]);
        if (kind != OBJ_POSITION) continue;
        s->piece->lower[k] = v[k] < s->piece->lower[k] ? v[k] : s->piece->lower[k];
        s->piece->upper[k] = v[k] > s->piece->upper[k] ? v[k] : s->piece->upper[k];
    }
    return p;
}

/* Stores the colour of the vertex that was read last. */
static void put_color(const obj_parser *s, const double v[3]) {
    float *out = s->r->colors + 3 * (s->seen[OBJ_POSITION] - 1);
    for (int k = 0; k < 3; ++k) out[k] = (float)srgb_decoded(fmin(fmax(v[k], 0), s->r->white) / s->r->white);
}

static void find_color(obj_piece *piece, const double v[3]) {
    ++piece->colored;
    for (int k = 0; k < 3; ++k) {
        piece->brightest = fmax(piece->brightest, v[k]);
        piece->finely |= !(v[k] >= 0 && v[k] <= 255) || v[k] != floor(v[k]);
    }
}

/* Reads the numbers after x, y and z: a weight, which only curves use, or a colour, perhaps with an alpha. */
static void read_behind(obj_parser *s, const char *at) {
    const char *p = text_skip(at);
    double v[3], weight = 0, alpha = 1;
    int count = 0;
    if (text_is_end(*p) || *p == '#') return;
    while (count < 3 && number_read(&p, &v[count])) {
        if (!count++) weight = v[0];
        p = text_skip(p);
    }
    if (count == 3 && s->r->colors)
        put_color(s, v);
    else if (count == 3)
        find_color(s->piece, v);
    else if (weight != 1 && !s->r->again)
        tally(s, OBJ_T_BEHIND, 1, at);
    if (count == 3 && !s->r->again && number_read(&p, &alpha) && alpha != 1 && alpha != 255)
        tally(s, OBJ_T_ALPHA, 1, at);
}

/* Reads an index of a corner: from 1, or negative, counted backwards from the last vertex so far. */
static bool read_index(obj_parser *s, int kind, const char **p, uint32_t *out) {
    int64_t index;
    const char *at = *p;
    text_fault *fault = &s->r->fault;
    size_t corner = s->face.count + 1;
    if (!number_read_integer(p, &index))
        return text_found(fault, at, s->keyword, "corner %zu: %s: expected an index", corner, kinds[kind]);
    int64_t found = index > 0 ? index - 1 : (int64_t)s->seen[kind] + index;
    if (index == 0 && kind == OBJ_POSITION)
        return text_wrong(fault, at, s->keyword, "corner %zu: %s: 0 is no index; the first is 1", corner,
                          kinds[kind]);
    if (index < 0 ? found >= 0 : index > 0 && (uint64_t)found < s->r->total[kind]) {
        *out = (uint32_t)found;
        return true;
    }
    if (kind != OBJ_POSITION) {
        s->absent |= 1u << kind;
        return true;
    }
    if (index < 0)
        return text_wrong(fault, at, s->keyword,
                          "corner %zu: %s: index %lld goes back beyond the first; there are %llu above",
                          corner, kinds[kind], (long long)index, (unsigned long long)s->seen[kind]);
    return text_wrong(fault, at, s->keyword, "corner %zu: %s: index %lld is out of range; the file has %llu",
                      corner, kinds[kind], (long long)index, (unsigned long long)s->r->total[kind]);
}

/* Reads v, v/vt, v//vn or v/vt/vn; *parts gets a bit for each kind. */
static bool read_corner(obj_parser *s, const char **p, obj_corner *out, unsigned *parts) {
    const char *at = *p;
    *parts = 1u << OBJ_POSITION;
    if (!read_index(s, OBJ_POSITION, p, &out->index[OBJ_POSITION])) return false;
    for (int kind = OBJ_UV; kind < OBJ_KINDS && **p == '/'; ++kind) {
        ++*p;
        if (**p == '/' || text_is_break(**p)) continue;
        if (!read_index(s, kind, p, &out->index[kind])) return false;
        *parts |= 1u << kind;
    }
    if (text_is_break(**p)) return true;
    return text_found(&s->r->fault, at, s->keyword, "corner %zu: expected v, v/vt, v//vn or v/vt/vn",
                      s->face.count + 1);
}

/* The last run if the face belongs to it, else a new one. */
static obj_run *run_for(obj_parser *s, unsigned parts) {
    obj_piece *piece = s->piece;
    const read_mesh_options *options = &s->r->options;
    obj_run run = {.first = piece->corners[OBJ_POSITION].count / 3,
                   .slot = s->slot,
                   .object = s->object,
                   .same = {true, true, true}};
    run.has[OBJ_UV] = scene_keeps_uvs(s->r->scene) && parts >> OBJ_UV & 1;
    run.has[OBJ_NORMAL] = !options->flat && parts >> OBJ_NORMAL & 1;
    if (!options->flat && !run.has[OBJ_NORMAL]) {
        run.group = s->group ? s->group : options->smooth ? OBJ_ALL_GROUPS : 0;
    }
    obj_run *last = piece->runs.count ? &piece->runs.items[piece->runs.count - 1] : NULL;
    if (last && last->slot == run.slot && last->object == run.object && last->group == run.group &&
        last->has[OBJ_UV] == run.has[OBJ_UV] && last->has[OBJ_NORMAL] == run.has[OBJ_NORMAL]) {
        return last;
    }
    return array_push(&piece->runs, run) ? &piece->runs.items[piece->runs.count - 1] : NULL;
}

/* Appends the fan's indices of one kind, taken from the indices of kind `from`. */
static bool push_fan(obj_parser *s, int kind, int from) {
    const obj_corner *c = s->face.items;
    const size_t n = s->face.count;
    if (!array_room(&s->piece->corners[kind], 3 * (n - 2))) return false;
    uint32_t *out = s->piece->corners[kind].items + s->piece->corners[kind].count;
    for (size_t i = 2; i < n; ++i) {
        *out++ = c[0].index[from];
        *out++ = c[i - 1].index[from];
        *out++ = c[i].index[from];
    }
    s->piece->corners[kind].count += 3 * (n - 2);
    return true;
}

bool obj_keep_indices(obj_piece *piece, int kind) {
    const size_t have = piece->corners[kind].count, count = piece->corners[OBJ_POSITION].count;
    if (have == count) return true;
    if (!array_room(&piece->corners[kind], count - have)) return false;
    memcpy(piece->corners[kind].items + have, piece->corners[OBJ_POSITION].items + have,
           (count - have) * sizeof(uint32_t));
    piece->corners[kind].count = count;
    return true;
}

/* Appends the fan's indices of uvs or normals, once any in the piece differ from those of the positions. */
static bool push_kind(obj_parser *s, obj_run *run, int kind) {
    const obj_corner *c = s->face.items;
    int from = run->has[kind] ? kind : OBJ_POSITION;
    bool same = true;
    for (size_t i = 0; i < s->face.count; ++i) same &= c[i].index[from] == c[i].index[OBJ_POSITION];
    if (!same) run->same[kind] = false;
    if (same && !s->piece->corners[kind].count) return true;
    return obj_keep_indices(s->piece, kind) && push_fan(s, kind, from);
}

static bool push_face(obj_parser *s, const char *at, unsigned parts) {
    obj_piece *piece = s->piece;
    size_t n = s->face.count;
    if (n < 3) {
        tally(s, OBJ_T_SMALL, 1, at);
        return true;
    }
    if (s->absent >> OBJ_UV & 1) tally(s, OBJ_T_NO_UV, 1, at);
    if (s->absent >> OBJ_NORMAL & 1) tally(s, OBJ_T_NO_NORMAL, 1, at);
    obj_run *run = run_for(s, parts);
    polygon_fan polygon = {piece->corners[OBJ_POSITION].count / 3, (uint32_t)n};
    if (!run || !push_kind(s, run, OBJ_UV) || !push_kind(s, run, OBJ_NORMAL) ||
        !push_fan(s, OBJ_POSITION, OBJ_POSITION) || (n > 3 && !array_push(&piece->polygons, polygon)))
        return false;
    run->count += n - 2;
    return true;
}

/* Reads the corners of an element up to the end of its line. *parts: the kinds of indices that all corners of
 * a face have. NULL after a fault. */
static const char *read_corners(obj_parser *s, const char *keyword, const char *p, unsigned *parts) {
    const char *first = p;
    bool mixed = false;
    s->keyword = keyword;
    s->face.count = 0;
    s->absent = 0;
    *parts = 0;
    for (;;) {
        const char *at = text_skip(p);
        p = at;
        if (text_is_end(*p) || *p == '#') break;
        obj_corner corner = {{0}};
        unsigned of_corner;
        if (!read_corner(s, &p, &corner, &of_corner)) return NULL;
        mixed |= s->face.count && of_corner != *parts;
        *parts = s->face.count ? *parts & of_corner : of_corner;
        if (s->face.count == s->face.capacity && !array_room(&s->face, 1)) {
            text_no_memory(&s->r->fault);
            return NULL;
        }
        s->face.items[s->face.count++] = corner;
    }
    if (mixed && *keyword == 'f') tally(s, OBJ_T_MIXED, 1, first);
    return p;
}

static const char *read_face(obj_parser *s, const char *first) {
    unsigned parts;
    const char *p = read_corners(s, "f", first, &parts);
    return p && (push_face(s, first, parts & ~s->absent) || text_no_memory(&s->r->fault)) ? p : NULL;
}

static bool push_strokes(obj_parser *s, int kind) {
    const size_t count = kind == OBJ_LINES ? 2 * (s->face.count - 1) : s->face.count;
    obj_strokes *strokes = &s->piece->strokes[kind];
    const obj_stroke_run run = {strokes->corners.count, 0, s->slot};
    const bool goes_on = strokes->runs.count && strokes->runs.items[strokes->runs.count - 1].slot == s->slot;
    if ((!goes_on && !array_push(&strokes->runs, run)) || !array_room(&strokes->corners, count)) return false;
    for (size_t i = 0; i < count; ++i)
        strokes->corners.items[strokes->corners.count++] =
            s->face.items[kind == OBJ_LINES ? (i + 1) / 2 : i].index[OBJ_POSITION];
    strokes->runs.items[strokes->runs.count - 1].count += count;
    return true;
}

/* Reads a line or points; texture coordinates are not used. */
static const char *read_stroke(obj_parser *s, int kind, const char *first) {
    unsigned parts;
    const char *p = read_corners(s, kind == OBJ_LINES ? "l" : "p", first, &parts);
    if (!p) return NULL;
    if (kind == OBJ_LINES && s->face.count < 2) {
        tally(s, OBJ_T_SHORT, 1, first);
        return p;
    }
    tally(s, kind == OBJ_LINES ? OBJ_T_LINES : OBJ_T_POINTS, kind == OBJ_LINES ? 1 : s->face.count, first);
    return !s->face.count || push_strokes(s, kind) || text_no_memory(&s->r->fault) ? p : NULL;
}

static const char *read_smoothing(obj_parser *s, const char *p) {
    bool good = obj_smoothing_group(p, &s->group) ||
                text_found(&s->r->fault, text_skip(p), "s", "expected a number, on or off");
    return good ? p : NULL;
}

static const char *read_statement(obj_parser *s, obj_statement statement, const char *p) {
    switch (statement) {
    case OBJ_S_POSITION:
        p = read_vector(s, OBJ_POSITION, p);
        if (p) read_behind(s, p);
        return p;
    case OBJ_S_UV:
        if (scene_keeps_uvs(s->r->scene)) return read_vector(s, OBJ_UV, p);
        ++s->seen[OBJ_UV]; /* negative indices count it */
        return p;
    case OBJ_S_NORMAL: return read_vector(s, OBJ_NORMAL, p);
    case OBJ_S_FACE: return read_face(s, p);
    case OBJ_S_SMOOTHING: return read_smoothing(s, p);
    case OBJ_S_MATERIAL:
        if (s->next_material < s->piece->materials.count)
            s->slot = s->piece->materials.items[s->next_material++].slot;
        return p;
    case OBJ_S_OBJECT:
    case OBJ_S_GROUP:
        if (s->next_object < s->piece->objects.count)
            s->object = s->piece->objects.items[s->next_object++].slot;
        return p;
    case OBJ_S_LINE: return read_stroke(s, OBJ_LINES, p);
    case OBJ_S_POINT: return read_stroke(s, OBJ_POINTS, p);
    case OBJ_S_UNKNOWN:
        if (p < s->piece->end) tally(s, OBJ_T_UNKNOWN, 1, p);
        return p;
    case OBJ_S_EMPTY:
    case OBJ_S_PAINT:
    case OBJ_S_LIBRARY: return p;
    }
    return p;
}

static void parse_piece(obj_reader *r, obj_piece *piece) {
    obj_parser s = {.r = r,
                    .piece = piece,
                    .slot = piece->first_slot,
                    .object = piece->first_object,
                    .group = piece->first_group};
    for (int k = 0; k < 3; ++k) {
        s.seen[k] = piece->base[k];
        piece->lower[k] = (double)INFINITY;
        piece->upper[k] = -(double)INFINITY;
    }
    for (const char *p = piece->begin; p < piece->end;) {
        obj_statement statement = obj_classify(&p);
        if (!r->again || statement == OBJ_S_POSITION) p = read_statement(&s, statement, p);
        if (!p) break;
        p = obj_next(statement, p, piece->end);
    }
    array_free(&s.face);
}

static void parse_pieces(void *user, size_t begin, size_t end) {
    obj_reader *r = user;
    for (size_t i = begin; i < end; ++i) parse_piece(r, &r->pieces[i]);
}

static void split_polygons(void *user, size_t begin, size_t end) {
    obj_reader *r = user;
    polygon_work work = {0};
    const polygon_vertices vertices = {r->values[OBJ_POSITION], 3 * sizeof(float)};
    for (size_t i = begin; i < end; ++i) {
        obj_piece *piece = &r->pieces[i];
        for (size_t k = 0; k < piece->polygons.count; ++k) {
            polygon_fan polygon = piece->polygons.items[k];
            uint32_t *fan[OBJ_KINDS];
            for (int kind = 0; kind < OBJ_KINDS; ++kind) {
                fan[kind] =
                    piece->corners[kind].count ? piece->corners[kind].items + 3 * polygon.first : NULL;
            }
            if (!polygon_split(&work, &vertices, polygon.corners, fan[0], fan[1], fan[2]))
                text_no_memory(&r->fault);
        }
    }
    polygon_work_free(&work);
}

static fathom_status allocate_values(obj_reader *r) {
    for (int k = 0; k < OBJ_KINDS; ++k) {
        if (!r->total[k] || (k == OBJ_UV && !scene_keeps_uvs(r->scene))) continue;
        size_t bytes = (size_t)r->total[k] * (size_t)components[k] * sizeof(float) + 16;
        r->values[k] = malloc(bytes);
        if (!r->values[k]) return fail_memory(r->scene->context, bytes);
    }
    return FATHOM_OK;
}

static bool is_cloud(const obj_reader *r) {
    for (size_t i = 0; i < r->piece_count; ++i) {
        const obj_piece *piece = &r->pieces[i];
        if (piece->runs.count || piece->tallies[OBJ_T_SMALL].count || piece->tallies[OBJ_T_SHORT].count ||
            piece->strokes[OBJ_POINTS].runs.count || piece->strokes[OBJ_LINES].runs.count)
            return false;
    }
    return r->total[OBJ_POSITION] > 0;
}

static vec3_f64 choose_origin(const obj_reader *r) {
    scene_bounds bounds = bounds_empty();
    for (size_t i = 0; i < r->piece_count; ++i) {
        scene_bounds of_piece = {load_f64(r->pieces[i].lower), load_f64(r->pieces[i].upper)};
        bounds_join(&bounds, &of_piece);
    }
    return origin_for(&bounds);
}

fathom_status obj_parse(obj_reader *r) {
    fathom_status status = allocate_values(r);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, r->piece_count, 1, parse_pieces, r);
    status = text_status(&r->file, &r->fault);
    if (status == FATHOM_OK) status = obj_begin_colors(r);
    if (status != FATHOM_OK) return status;
    r->origin = choose_origin(r);
    r->again = r->colors || length_f64(r->origin) > 0;
    if (r->again) loop_parallel(r->threads, r->piece_count, 1, parse_pieces, r);
    r->cloud = is_cloud(r);
    status = text_status(&r->file, &r->fault);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, r->piece_count, 1, split_polygons, r);
    status = text_status(&r->file, &r->fault);
    return status == FATHOM_OK ? obj_drop_lost(r) : status;
}
