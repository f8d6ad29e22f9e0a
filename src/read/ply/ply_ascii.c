/* Rows of text, one line each; blank lines are skipped. */
#include "read/mesh/number.h"
#include "read/ply/ply.h"

#include "base/threads.h"

#include <stdlib.h>
#include <string.h>

#ifndef PLY_PIECE /* fuzzing cuts small files */
#define PLY_PIECE ((size_t)1 << 18)
#endif

typedef struct ascii_piece {
    const char *begin, *end;
    uint64_t rows, base; /* rows in it, rows before it */
    size_t longer;       /* rows with more numbers than properties */
    const char *first_longer;
    ply_faces faces;
} ascii_piece;

typedef struct ascii_reader {
    ply_reader *r;
    ascii_piece *pieces;
    size_t piece_count;
    uint64_t rows;
    uint64_t vertex_begin, vertex_end, face_begin, face_end; /* rows */
    const int *role_of;                                      /* the vertex element's properties; -1: none */
    bool moving; /* vertices are stored a second time, from the origin */
} ascii_reader;

static const char *line_after(const char *p, const char *end) {
    const char *newline = memchr(p, '\n', (size_t)(end - p));
    return newline ? newline + 1 : end;
}

static const char *skip_blanks(const char *p) {
    while (text_is_blank(*p)) ++p;
    return p;
}

/* The next row of the piece, or its end. */
static const char *next_row(const char *p, const char *end) {
    while (p < end) {
        const char *first = skip_blanks(p);
        if (*first != '\n' && first < end) return first;
        p = line_after(p, end);
    }
    return end;
}

static void count_rows(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    ascii_reader *a = user;
    for (size_t i = begin; i < end; ++i) {
        ascii_piece *piece = &a->pieces[i];
        text_fault zero = {NULL, "", ""};
        if (!text_has_no_zeros(&zero, piece->begin, piece->end))
            ply_wrong(a->r, zero.at, NULL, "%s", zero.what);
        const char *p = next_row(piece->begin, piece->end);
        for (; p < piece->end; p = next_row(line_after(p, piece->end), piece->end)) ++piece->rows;
    }
}

static bool read_number(ply_reader *r, const ply_property *property, const char **p, double *out) {
    char quote[48];
    const char *at = skip_blanks(*p);
    *p = at;
    if (number_read(p, out) && text_is_break(**p)) return true;
    return ply_wrong(r, at, property->name, "expected a number, found %s", text_quote(at, quote));
}

static bool read_whole(ply_reader *r, const ply_property *property, const char **p, int64_t *out) {
    char quote[48];
    const char *at = skip_blanks(*p);
    *p = at;
    if (number_read_integer(p, out) && text_is_break(**p)) return true;
    return ply_wrong(r, at, property->name, "expected a whole number, found %s", text_quote(at, quote));
}

/* `keep`: receives the numbers; NULL skips them. */
static bool read_list(ply_reader *r, const ply_property *property, const char **p, ply_faces *keep) {
    int64_t count;
    const char *at = *p;
    if (!read_whole(r, property, p, &count)) return false;
    if (count < 0) return ply_wrong(r, at, property->name, "a list of %lld numbers", (long long)count);
    if (keep) keep->row.count = 0;
    for (int64_t i = 0; i < count; ++i) {
        double number;
        int64_t whole;
        if (!keep) {
            if (!read_number(r, property, p, &number)) return false;
            continue;
        }
        if (!read_whole(r, property, p, &whole)) return false;
        if (keep->row.count == keep->row.capacity && !array_room(&keep->row, 1)) {
            ply_no_memory(r);
            return false;
        }
        keep->row.items[keep->row.count++] = whole;
    }
    return true;
}

/* Skips numbers beyond the properties. */
static bool end_row(ply_reader *r, const ply_element *element, ascii_piece *piece, const char *p) {
    char quote[48];
    double number;
    const char *first = skip_blanks(p);
    for (p = first; !text_is_end(*p); p = skip_blanks(p)) {
        const char *at = p;
        if (number_read(&p, &number) && text_is_break(*p)) continue;
        return ply_wrong(r, at, element->name, "expected the end of the row, found %s",
                         text_quote(at, quote));
    }
    if (p != first && !piece->longer++) piece->first_longer = first;
    return true;
}

static bool read_vertex(const ascii_reader *a, ascii_piece *piece, uint32_t number, const char *at,
                        scene_bounds *bounds) {
    ply_reader *r = a->r;
    const ply_element *element = &r->header.elements.items[r->vertex_element];
    double values[PLY_ROLES] = {0}, value;
    const char *p = at;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        if (property->is_list) {
            if (!read_list(r, property, &p, NULL)) return false;
            continue;
        }
        if (!read_number(r, property, &p, &value)) return false;
        if (a->role_of[i] >= 0) values[a->role_of[i]] = value;
    }
    if (!a->moving) return end_row(r, element, piece, p) && ply_put_vertex(r, number, values, at, bounds);
    ply_put_position(r, number, values);
    return true;
}

static bool read_face(const ascii_reader *a, ascii_piece *piece, const char *at) {
    ply_reader *r = a->r;
    const ply_element *element = &r->header.elements.items[r->face_element];
    const char *p = at;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        double value;
        bool good = property->is_list ? read_list(r, property, &p, i == r->index_list ? &piece->faces : NULL)
                                      : read_number(r, property, &p, &value);
        if (!good) return false;
    }
    return end_row(r, element, piece, p) && ply_push_row(r, &piece->faces, at);
}

static void read_pieces(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    ascii_reader *a = user;
    for (size_t i = begin; i < end; ++i) {
        ascii_piece *piece = &a->pieces[i];
        scene_bounds bounds = bounds_empty();
        uint64_t row = piece->base;
        const char *p = next_row(piece->begin, piece->end);
        for (; p < piece->end; p = next_row(line_after(p, piece->end), piece->end), ++row) {
            bool good = true;
            if (row >= a->vertex_begin && row < a->vertex_end) {
                good = read_vertex(a, piece, (uint32_t)(row - a->vertex_begin), p, &bounds);
            } else if (!a->moving && row >= a->face_begin && row < a->face_end) {
                good = read_face(a, piece, p);
            }
            if (!good) break;
        }
        ply_join_bounds(a->r, &bounds);
    }
}

static fathom_status cut_pieces(ascii_reader *a) {
    const ply_reader *r = a->r;
    text_file body = r->file;
    body.begin = r->header.body;
    size_t *starts = text_pieces(&body, PLY_PIECE, &a->piece_count);
    /* A header without a body has no pieces. */
    a->pieces = starts ? calloc(a->piece_count + 1, sizeof *a->pieces) : NULL;
    for (size_t i = 0; a->pieces && i < a->piece_count; ++i) {
        a->pieces[i].begin = body.begin + starts[i];
        a->pieces[i].end = body.begin + starts[i + 1];
    }
    free(starts);
    return a->pieces ? FATHOM_OK : fail_memory(r->scene->context, (a->piece_count + 1) * sizeof *a->pieces);
}

/* Finds each element's rows, and checks that there are as many as the header promises. */
static fathom_status place_rows(ascii_reader *a) {
    ply_reader *r = a->r;
    for (size_t i = 0; i < a->piece_count; ++i) {
        a->pieces[i].base = a->rows;
        a->rows += a->pieces[i].rows;
    }
    uint64_t promised = 0;
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        uint64_t next = promised + r->header.elements.items[i].count;
        if (i == r->vertex_element) a->vertex_begin = promised, a->vertex_end = next;
        if (i == r->face_element) a->face_begin = promised, a->face_end = next;
        promised = next;
    }
    if (a->rows < promised) {
        ply_wrong(r, r->file.end, NULL, "the file ends after %llu rows; its header promises %llu",
                  (unsigned long long)a->rows, (unsigned long long)promised);
    } else if (a->rows > promised) {
        notes_add(&r->notes, (size_t)(a->rows - promised), "",
                  "rows after the %llu that the header promises are left out", (unsigned long long)promised);
    }
    return ply_status(r);
}

static fathom_status read_rows(ascii_reader *a) {
    ply_reader *r = a->r;
    loop_parallel(r->threads, a->piece_count, 1, count_rows, a);
    fathom_status status = ply_status(r);
    if (status == FATHOM_OK) status = place_rows(a);
    if (status == FATHOM_OK) status = ply_allocate_arrays(r);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, a->piece_count, 1, read_pieces, a);
    status = ply_status(r);
    for (size_t i = 0; i < a->piece_count; ++i) {
        notes_add_at(&r->notes, a->pieces[i].longer, &r->file, a->pieces[i].first_longer,
                     "numbers beyond the properties of the header are left out");
    }
    if (status == FATHOM_OK) status = ply_choose_origin(r, &a->moving);
    if (status != FATHOM_OK) return status;
    if (a->moving) loop_parallel(r->threads, a->piece_count, 1, read_pieces, a);
    return FATHOM_OK;
}

static fathom_status join_faces(ascii_reader *a) {
    ply_faces *faces = malloc((a->piece_count + 1) * sizeof *faces);
    if (!faces) return fail_memory(a->r->scene->context, a->piece_count * sizeof *faces);
    for (size_t i = 0; i < a->piece_count; ++i) faces[i] = a->pieces[i].faces;
    fathom_status status = ply_join_faces(a->r, faces, a->piece_count);
    free(faces);
    return status;
}

fathom_status ply_read_ascii(ply_reader *r) {
    const ply_element *vertex = &r->header.elements.items[r->vertex_element];
    int *role_of = malloc(vertex->properties.count * sizeof *role_of);
    if (!role_of) return fail_memory(r->scene->context, vertex->properties.count * sizeof *role_of);
    for (size_t i = 0; i < vertex->properties.count; ++i) role_of[i] = -1;
    for (int role = 0; role < PLY_ROLES; ++role) {
        if (r->role[role] >= 0) role_of[r->role[role]] = role;
    }
    ascii_reader a = {.r = r, .role_of = role_of};
    fathom_status status = cut_pieces(&a);
    if (status == FATHOM_OK) status = read_rows(&a);
    if (status == FATHOM_OK) status = join_faces(&a);
    for (size_t i = 0; a.pieces && i < a.piece_count; ++i) ply_free_faces(&a.pieces[i].faces);
    free(a.pieces);
    free(role_of);
    return status;
}
