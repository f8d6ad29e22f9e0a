/* Reads rows of text, one line each; blank lines are skipped. */
#include "read/mesh/number.h"
#include "read/ply/ply.h"

#include <stdlib.h>
#include <string.h>

#ifndef PLY_PIECE /* fuzzing sets a small size, so that small files have several pieces */
#define PLY_PIECE ((size_t)1 << 18)
#endif

typedef struct ascii_piece {
    uint64_t rows, base; /* rows in the piece, rows before it */
    size_t longer;       /* rows with more numbers than properties */
    const char *first_longer;
} ascii_piece;

typedef struct ascii_reader {
    ply_reader *r;
    const char **starts; /* start of each piece, and the end of the last one */
    ascii_piece *pieces;
    uint64_t vertex_begin, face_begin, edge_begin, rows; /* row numbers and total by the header's counts */
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

static void count_rows(void *user, size_t begin, size_t end) {
    ascii_reader *a = user;
    for (size_t i = begin; i < end; ++i) {
        const char *stop = a->starts[i + 1];
        text_has_no_zeros(&a->r->fault, a->starts[i], stop);
        const char *p = next_row(a->starts[i], stop);
        for (; p < stop; p = next_row(line_after(p, stop), stop)) ++a->pieces[i].rows;
    }
}

static bool read_number(ply_reader *r, const ply_property *property, const char **p, double *out) {
    const char *at = *p = skip_blanks(*p);
    if (number_read(p, out) && text_is_break(**p)) return true;
    if (number_is_odd(at)) {
        *out = (double)NAN;
        for (*p = at; !text_is_break(**p);) ++*p;
        return true;
    }
    return text_found(&r->fault, at, property->name, "expected a number");
}

static bool read_whole(ply_reader *r, const ply_property *property, const char **p, int64_t *out) {
    const char *at = *p = skip_blanks(*p);
    if (number_read_integer(p, out) && text_is_break(**p)) return true;
    return text_found(&r->fault, at, property->name, "expected a whole number");
}

/* keep: receives the numbers of list `index` of a face; NULL skips them. */
static bool read_list(ply_reader *r, const ply_property *property, const char **p, ply_faces *keep,
                      size_t index) {
    int64_t count, whole;
    double number;
    const char *at = *p;
    if (!read_whole(r, property, p, &count)) return false;
    if (count < 0)
        return text_wrong(&r->fault, at, property->name, "a list of %lld numbers", (long long)count);
    for (int64_t i = 0; i < count; ++i) {
        bool good;
        if (keep && index == r->index_list)
            good = read_whole(r, property, p, &whole) && ply_push_index(r, keep, whole, *p);
        else
            good = read_number(r, property, p, &number) &&
                   (!keep || index != r->uv_list || ply_push_uv(r, keep, number));
        if (!good) return false;
    }
    return true;
}

/* Skips extra numbers after the last property. */
static bool end_row(ply_reader *r, const ply_element *element, ascii_piece *piece, const char *p) {
    double number;
    const char *first = skip_blanks(p);
    for (p = first; !text_is_end(*p); p = skip_blanks(p)) {
        const char *at = p;
        if (!number_read(&p, &number) || !text_is_break(*p))
            return text_found(&r->fault, at, element->name, "expected the end of the row");
    }
    if (p != first && !piece->longer++) piece->first_longer = first;
    return true;
}

/* Reads the numbers of a row: those with a role, and the lists of a face. */
static bool read_properties(ply_reader *r, size_t index, ascii_piece *piece, const char *p, ply_faces *faces,
                            double values[PLY_ROLES]) {
    const ply_element *element = &r->header.elements.items[index];
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        double value;
        bool good =
            property->is_list ? read_list(r, property, &p, faces, i) : read_number(r, property, &p, &value);
        if (!good) return false;
        if (!property->is_list && property->role >= 0) values[property->role] = value;
    }
    return r->moving || end_row(r, element, piece, p);
}

/* True if the element has this row, counted from its first row. Numbers of rows before it wrap around to
 * large values. */
static bool is_of(const ply_reader *r, size_t element, uint64_t row) {
    return element != SIZE_MAX && row < r->header.elements.items[element].count;
}

static bool read_row(const ascii_reader *a, size_t piece, uint64_t row, const char *at,
                     scene_bounds *bounds) {
    ply_reader *r = a->r;
    const uint64_t vertex = row - a->vertex_begin, edge = row - a->edge_begin;
    double values[PLY_ROLES] = {0};
    if (vertex < r->vertex_count) {
        if (!read_properties(r, r->vertex_element, &a->pieces[piece], at, NULL, values)) return false;
        ply_put_vertex(r, (uint32_t)vertex, values, bounds);
        return true;
    }
    if (r->moving) return true;
    if (is_of(r, r->edge_element, edge))
        return read_properties(r, r->edge_element, &a->pieces[piece], at, NULL, values) &&
               ply_put_edge(r, edge, values, at);
    if (!is_of(r, r->face_element, row - a->face_begin)) return true;
    return read_properties(r, r->face_element, &a->pieces[piece], at, &r->pieces[piece], values) &&
           ply_end_row(r, &r->pieces[piece], values);
}

static void read_pieces(void *user, size_t begin, size_t end) {
    const ascii_reader *a = user;
    for (size_t i = begin; i < end; ++i) {
        scene_bounds bounds = bounds_empty();
        uint64_t row = a->pieces[i].base;
        const char *stop = a->starts[i + 1], *p = next_row(a->starts[i], stop);
        while (p < stop && read_row(a, i, row++, p, &bounds)) p = next_row(line_after(p, stop), stop);
        ply_join_bounds(a->r, &bounds);
    }
}

static fathom_status cut_pieces(ascii_reader *a) {
    ply_reader *r = a->r;
    text_file body = r->file;
    size_t count = 0;
    body.begin = r->header.body;
    a->starts = text_pieces(&body, PLY_PIECE, &count);
    a->pieces = calloc(count + 1, sizeof *a->pieces);
    if (!a->starts || !a->pieces) return fail_memory(r->scene->context, (count + 1) * sizeof *a->pieces);
    return ply_make_pieces(r, count);
}

/* Finds each element's rows, and checks their number against the header. */
static fathom_status place_rows(ascii_reader *a) {
    ply_reader *r = a->r;
    uint64_t rows = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        a->pieces[i].base = rows;
        rows += a->pieces[i].rows;
    }
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        if (i == r->vertex_element) a->vertex_begin = a->rows;
        if (i == r->face_element) a->face_begin = a->rows;
        if (i == r->edge_element) a->edge_begin = a->rows;
        a->rows += r->header.elements.items[i].count;
    }
    if (rows < a->rows)
        text_wrong(&r->fault, r->file.end, NULL, "the file ends after %llu rows; its header promises %llu",
                   (unsigned long long)rows, (unsigned long long)a->rows);
    else
        notes_add(&r->notes, (size_t)(rows - a->rows), "",
                  "rows after the %llu that the header promises are left out", (unsigned long long)a->rows);
    return text_status(&r->file, &r->fault);
}

static fathom_status read_rows(ascii_reader *a) {
    ply_reader *r = a->r;
    loop_parallel(r->threads, r->piece_count, 1, count_rows, a);
    fathom_status status = text_status(&r->file, &r->fault);
    if (status == FATHOM_OK) status = place_rows(a);
    if (status == FATHOM_OK) status = ply_read_vertices(r, r->piece_count, 1, read_pieces, a);
    for (size_t i = 0; status == FATHOM_OK && i < r->piece_count; ++i)
        notes_add_at(&r->notes, a->pieces[i].longer, &r->file, a->pieces[i].first_longer, true,
                     "numbers beyond the properties of the header are left out");
    return status == FATHOM_OK ? ply_join_faces(r) : status;
}

fathom_status ply_read_ascii(ply_reader *r) {
    ascii_reader a = {.r = r};
    fathom_status status = cut_pieces(&a);
    if (status == FATHOM_OK) status = read_rows(&a);
    free(a.starts);
    free(a.pieces);
    return status;
}
