#include "read/ply/ply.h"

#include "base/threads.h"

#include <stdatomic.h>
#include <stdlib.h>

static bool is_big(const ply_reader *r) { return r->header.format == PLY_BIG; }

static size_t bytes_left(const ply_reader *r, const unsigned char *p) {
    return (size_t)((const unsigned char *)r->file.end - p);
}

bool ply_list_count(ply_reader *r, const ply_property *list, const unsigned char **p, uint64_t *out) {
    size_t size = ply_size(list->count_type), left = bytes_left(r, *p);
    if (left < size) return ply_wrong(r, *p, list->name, "the file ends before the list's length");
    double count = ply_load(*p, list->count_type, is_big(r));
    if (!(count >= 0 && count < 0x1p32) || count != floor(count)) {
        return ply_wrong(r, *p, list->name, "a list of length %g", count);
    }
    *out = (uint64_t)count;
    if (*out > (left - size) / ply_size(list->type)) {
        return ply_wrong(r, *p, list->name,
                         "a list of %llu numbers does not fit into the %zu bytes that follow",
                         (unsigned long long)*out, left - size);
    }
    *p += size;
    return true;
}

/* The end of the row at `p`, NULL after a fault. */
static const unsigned char *walk_row(ply_reader *r, const ply_element *element, const unsigned char *p,
                                     size_t *offsets) {
    const unsigned char *begin = p;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        offsets[i] = (size_t)(p - begin);
        uint64_t count = 1;
        if (property->is_list && !ply_list_count(r, property, &p, &count)) return NULL;
        size_t bytes = (size_t)count * ply_size(property->type);
        if (bytes > bytes_left(r, p)) {
            ply_wrong(r, p, property->name, "the file ends before it");
            return NULL;
        }
        p += bytes;
    }
    return p;
}

/* Whether all rows have lists as long as the first row's, so that all rows have one size. By induction: a row
 * that starts at its assumed place and has those lengths ends where the next one is assumed to start. */
typedef struct likeness {
    const ply_rows *rows;
    atomic_bool differs;
} likeness;

static void compare_rows(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    likeness *all = user;
    const ply_rows *rows = all->rows;
    bool differs = false;
    for (size_t k = 0; k < rows->element->properties.count; ++k) {
        const ply_property *property = &rows->element->properties.items[k];
        if (!property->is_list) continue;
        const unsigned char *count = rows->begin + rows->offsets[k];
        size_t size = ply_size(property->count_type);
        if (size == 1) {
            for (size_t i = begin; i < end; ++i) differs |= count[i * rows->row] != *count;
        } else {
            for (size_t i = begin; i < end; ++i) differs |= memcmp(count + i * rows->row, count, size) != 0;
        }
    }
    if (differs) atomic_store(&all->differs, true);
}

static bool rows_are_alike(ply_reader *r, const ply_rows *rows) {
    likeness all = {.rows = rows};
    if (rows->element->count > bytes_left(r, rows->begin) / rows->row) return false;
    loop_parallel(r->threads, (size_t)rows->element->count, 1u << 16, compare_rows, &all);
    return !all.differs;
}

static bool walk_rows(ply_reader *r, ply_rows *rows) {
    const unsigned char *p = rows->begin;
    rows->row = 0;
    rows->blocks = malloc(rows->block_count * sizeof *rows->blocks);
    if (!rows->blocks) {
        ply_no_memory(r);
        return false;
    }
    for (uint64_t i = 0; i < rows->element->count; ++i) {
        if (i % PLY_BLOCK == 0) rows->blocks[i / PLY_BLOCK] = p;
        p = walk_row(r, rows->element, p, rows->offsets);
        if (!p) return false;
    }
    rows->end = p;
    return true;
}

fathom_status ply_find_rows(ply_reader *r, const ply_element *element, const unsigned char *begin,
                            ply_rows *out) {
    *out = (ply_rows){.element = element, .begin = begin, .end = begin};
    if (!element->count) return FATHOM_OK;
    out->block_count = (size_t)((element->count + PLY_BLOCK - 1) / PLY_BLOCK);
    out->offsets = malloc(element->properties.count * sizeof *out->offsets);
    if (!out->offsets)
        return fail_memory(r->scene->context, element->properties.count * sizeof *out->offsets);
    const unsigned char *second = walk_row(r, element, begin, out->offsets);
    if (!second) return ply_status(r);
    out->row = (size_t)(second - begin);
    if (rows_are_alike(r, out))
        out->end = begin + element->count * out->row;
    else
        walk_rows(r, out);
    return ply_status(r);
}

void ply_free_rows(ply_rows *rows) {
    free(rows->offsets);
    free(rows->blocks);
    *rows = (ply_rows){0};
}

static bool measure_row(ply_reader *r, const ply_rows *rows, ply_row *row) {
    return !row->own_offsets || walk_row(r, rows->element, row->at, row->own_offsets);
}

bool ply_first_row(ply_reader *r, const ply_rows *rows, size_t block, ply_row *row) {
    uint64_t first = (uint64_t)block * PLY_BLOCK, left = rows->element->count - first;
    *row = (ply_row){
        .number = first, .end = first + (left < PLY_BLOCK ? left : PLY_BLOCK), .offsets = rows->offsets};
    if (!rows->blocks) {
        row->at = rows->begin + first * rows->row;
        return true;
    }
    row->at = rows->blocks[block];
    row->offsets = row->own_offsets = malloc(rows->element->properties.count * sizeof *row->own_offsets);
    if (row->own_offsets) return measure_row(r, rows, row);
    ply_no_memory(r);
    return false;
}

bool ply_next_row(ply_reader *r, const ply_rows *rows, ply_row *row) {
    if (++row->number >= row->end) return false;
    if (!row->own_offsets) {
        row->at += rows->row;
        return true;
    }
    row->at = walk_row(r, rows->element, row->at, row->own_offsets);
    return measure_row(r, rows, row);
}

void ply_free_row(ply_row *row) { free(row->own_offsets); }
