#include "read/mesh/number.h"
#include "read/ply/ply.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The longest header line. A file without a header may have no line end at all. */
#define LINE_MAX_BYTES ((size_t)1 << 16)

size_t ply_size(ply_type type) {
    switch (type) {
    case PLY_INT8:
    case PLY_UINT8: return 1;
    case PLY_INT16:
    case PLY_UINT16: return 2;
    case PLY_INT32:
    case PLY_UINT32:
    case PLY_FLOAT32: return 4;
    case PLY_FLOAT64: return 8;
    }
    return 0;
}

/* A word of the header, "" at the end of the line. Long words are cut; no known word is that long. */
static const char *read_word(const char **p, char out[PLY_NAME]) {
    const char *at = *p;
    while (text_is_blank(*at)) ++at;
    const char *word = at;
    size_t length = 0;
    for (; !text_is_blank(*at) && !text_is_end(*at); ++at) {
        if (length + 1 < PLY_NAME) out[length++] = *at;
    }
    out[length] = '\0';
    *p = at;
    return word;
}

static bool read_type(ply_reader *r, const char **p, ply_type *out) {
    static const struct {
        const char *name;
        ply_type type;
    } types[] = {
        {"char", PLY_INT8},     {"int8", PLY_INT8},       {"uchar", PLY_UINT8},    {"uint8", PLY_UINT8},
        {"short", PLY_INT16},   {"int16", PLY_INT16},     {"ushort", PLY_UINT16},  {"uint16", PLY_UINT16},
        {"int", PLY_INT32},     {"int32", PLY_INT32},     {"uint", PLY_UINT32},    {"uint32", PLY_UINT32},
        {"float", PLY_FLOAT32}, {"float32", PLY_FLOAT32}, {"double", PLY_FLOAT64}, {"float64", PLY_FLOAT64}};
    char word[PLY_NAME], quote[48];
    const char *at = read_word(p, word);
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
        if (strcmp(word, types[i].name) != 0) continue;
        *out = types[i].type;
        return true;
    }
    return ply_wrong(r, at, "property",
                     "the type %s is not known; expected char, uchar, short, ushort, int, uint, float, "
                     "double, or int8 to float64",
                     text_quote(at, quote));
}

static bool read_format(ply_reader *r, const char *p) {
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    char word[PLY_NAME], quote[48];
    const char *at = read_word(&p, word);
    for (int i = 0; i < 3; ++i) {
        if (strcmp(word, formats[i]) != 0) continue;
        r->header.format = (ply_format)i;
        at = read_word(&p, word);
        return strcmp(word, "1.0") == 0 ||
               ply_wrong(r, at, "format", "expected version 1.0, found %s", text_quote(at, quote));
    }
    return ply_wrong(r, at, "format", "expected ascii, binary_little_endian or binary_big_endian, found %s",
                     text_quote(at, quote));
}

/* Returns `out`. */
static const char *element_field(const ply_element *element, char out[52]) {
    snprintf(out, 52, "element %.40s", element->name);
    return out;
}

static bool read_element(ply_reader *r, const char *line, const char *p) {
    char quote[48], field[52];
    ply_element element = {.line = line};
    const char *at = read_word(&p, element.name);
    if (!element.name[0]) return ply_wrong(r, at, "element", "expected a name and a count");
    while (text_is_blank(*p)) ++p;
    int64_t count;
    at = p;
    if (!number_read_integer(&p, &count) || count < 0 || !text_is_break(*p)) {
        return ply_wrong(r, at, element_field(&element, field), "expected a count, found %s",
                         text_quote(at, quote));
    }
    element.count = (uint64_t)count;
    if (!array_push(&r->header.elements, element)) ply_no_memory(r);
    return !r->out_of_memory;
}

static bool read_property(ply_reader *r, const char *line, const char *p) {
    if (!r->header.elements.count) return ply_wrong(r, line, "property", "expected an element before it");
    ply_element *element = &r->header.elements.items[r->header.elements.count - 1];
    ply_property property = {.count_type = PLY_UINT8};
    char word[PLY_NAME];
    const char *after = p;
    read_word(&after, word);
    property.is_list = strcmp(word, "list") == 0;
    if (property.is_list) {
        p = after;
        if (!read_type(r, &p, &property.count_type)) return false;
    }
    if (!read_type(r, &p, &property.type)) return false;
    const char *at = read_word(&p, property.name);
    if (!property.name[0]) return ply_wrong(r, at, "property", "expected a name");
    if (!array_push(&element->properties, property)) ply_no_memory(r);
    return !r->out_of_memory;
}

/* MeshLab names its textures in comments. */
static void read_comment(ply_reader *r, const char *p) {
    char word[PLY_NAME];
    const char *at = read_word(&p, word);
    if (strcmp(word, "TextureFile") == 0)
        notes_add_at(&r->notes, 1, &r->file, at, "textures are not read; the surface has the default grey");
}

/* Returns the line after the header, NULL after a fault. */
static const char *read_lines(ply_reader *r) {
    bool has_format = false;
    char word[PLY_NAME], quote[48];
    const char *end = r->file.end, *line = r->file.begin;
    for (size_t number = 0;; ++number) {
        size_t left = (size_t)(end - line), most = left < LINE_MAX_BYTES ? left : LINE_MAX_BYTES;
        const char *newline = memchr(line, '\n', most);
        const char *p = line, *at = read_word(&p, word);
        bool good = true;
        if (number == 0 && strcmp(word, "ply") != 0) {
            good = ply_wrong(r, line, NULL, "expected \"ply\" as the first line of a PLY file, found %s",
                             text_quote(at, quote));
        } else if (!newline && most < left) {
            good = ply_wrong(r, line, NULL,
                             "a line of more than %zu characters; expected a header's, or end_header",
                             LINE_MAX_BYTES);
        } else if (!newline) {
            good = ply_wrong(r, end, NULL, "the file ends inside the header; expected end_header");
        } else if (strcmp(word, "end_header") == 0) {
            if (has_format) return newline + 1;
            good = ply_wrong(r, line, "end_header", "expected a format statement before it");
        } else if (strcmp(word, "format") == 0) {
            has_format = good = read_format(r, p);
        } else if (strcmp(word, "element") == 0) {
            good = read_element(r, line, p);
        } else if (strcmp(word, "property") == 0) {
            good = read_property(r, line, p);
        } else if (strcmp(word, "comment") == 0) {
            read_comment(r, p);
        } else if (number > 0 && word[0] && strcmp(word, "obj_info") != 0) {
            good =
                ply_wrong(r, at, NULL, "expected format, comment, element, property or end_header, found %s",
                          text_quote(at, quote));
        }
        if (!good) return NULL;
        line = newline + 1;
    }
}

/* The bytes of the shortest row: numbers of one digit, empty lists. */
static uint64_t smallest_row(const ply_reader *r, const ply_element *element) {
    uint64_t bytes = 0;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        if (r->header.format == PLY_ASCII)
            bytes += 2;
        else
            bytes += ply_size(property->is_list ? property->count_type : property->type);
    }
    return bytes;
}

/* Refuses counts that the file has no bytes for, before anything is allocated. */
static bool check_counts(ply_reader *r) {
    char field[52];
    uint64_t left = (uint64_t)(r->file.end - r->header.body);
    if (r->header.format == PLY_ASCII) ++left; /* the last line need not end */
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        const ply_element *element = &r->header.elements.items[i];
        if (!element->count) continue;
        uint64_t row = smallest_row(r, element);
        if (!row) return ply_wrong(r, element->line, element_field(element, field), "it has no properties");
        if (element->count > left / row) {
            return ply_wrong(r, element->line, element_field(element, field),
                             "%llu rows of at least %llu bytes do not fit into the %llu bytes that follow",
                             (unsigned long long)element->count, (unsigned long long)row,
                             (unsigned long long)left);
        }
        left -= element->count * row;
    }
    return true;
}

static size_t find_element(const ply_header *header, const char *name) {
    for (size_t i = 0; i < header->elements.count; ++i) {
        if (strcmp(header->elements.items[i].name, name) == 0) return i;
    }
    return SIZE_MAX;
}

static int find_property(const ply_element *element, const char *name) {
    for (size_t i = 0; i < element->properties.count; ++i) {
        if (strcmp(element->properties.items[i].name, name) == 0) return (int)i;
    }
    return -1;
}

static bool find_roles(ply_reader *r) {
    static const char *const names[PLY_ROLES][4] = {{"x"},
                                                    {"y"},
                                                    {"z"},
                                                    {"nx"},
                                                    {"ny"},
                                                    {"nz"},
                                                    {"u", "s", "texture_u", "texture_s"},
                                                    {"v", "t", "texture_v", "texture_t"}};
    r->vertex_element = find_element(&r->header, "vertex");
    if (r->vertex_element == SIZE_MAX)
        return ply_wrong(r, r->file.begin, "element vertex", "the header has none");
    const ply_element *vertex = &r->header.elements.items[r->vertex_element];
    if (vertex->count >= UINT32_MAX) {
        return ply_wrong(r, vertex->line, "element vertex", "%llu rows; at most 2^32 - 2 can be indexed",
                         (unsigned long long)vertex->count);
    }
    r->vertex_count = (uint32_t)vertex->count;
    for (int role = 0; role < PLY_ROLES; ++role) {
        r->role[role] = -1;
        for (int k = 0; k < 4 && names[role][k] && r->role[role] < 0; ++k) {
            r->role[role] = find_property(vertex, names[role][k]);
        }
        bool found = r->role[role] >= 0 && !vertex->properties.items[r->role[role]].is_list;
        if (!found) r->role[role] = -1;
        if (!found && role <= PLY_Z) {
            return ply_wrong(r, vertex->line, "element vertex", "it has no number %s; expected x, y and z",
                             names[role][0]);
        }
    }
    return true;
}

static bool find_faces(ply_reader *r) {
    char field[52];
    const ply_element *elements = r->header.elements.items;
    r->face_element = find_element(&r->header, "face");
    if (r->face_element == SIZE_MAX || !elements[r->face_element].count) {
        size_t strips = find_element(&r->header, "tristrips");
        r->strips = strips != SIZE_MAX && elements[strips].count > 0;
        if (r->strips) r->face_element = strips;
    }
    if (r->face_element == SIZE_MAX || !elements[r->face_element].count || !r->vertex_count) {
        return ply_wrong(
            r, r->file.begin, NULL,
            "no faces: a cloud of %u points has no surface to render; expected an element face or "
            "tristrips that is not empty",
            r->vertex_count);
    }
    const ply_element *face = &elements[r->face_element];
    int list = find_property(face, "vertex_indices");
    if (list < 0) list = find_property(face, "vertex_index");
    if (list < 0 || !face->properties.items[list].is_list) {
        return ply_wrong(r, face->line, element_field(face, field),
                         "it has no list vertex_indices or vertex_index");
    }
    r->index_list = (size_t)list;
    return true;
}

/* Mends header lines that end in a carriage return alone, and the rows after them if they are text. */
static void mend_lines(char *text, const char *end) {
    bool is_text = false;
    for (char *line = text, *cr; (cr = memchr(line, '\r', (size_t)(end - line))) != NULL; line = cr + 1) {
        char word[PLY_NAME];
        const char *p = line;
        if (cr[1] != '\n') *cr = '\n';
        read_word(&p, word);
        if (strcmp(word, "format") == 0) {
            read_word(&p, word);
            is_text = strcmp(word, "ascii") == 0;
        }
        if (strcmp(word, "end_header") != 0) continue;
        if (is_text) text_mend_line_ends(cr + 1, end);
        return;
    }
}

fathom_status ply_open_text(ply_reader *r, const char *path) {
    const char *text = (const char *)r->map.bytes, *end = text + r->map.size;
    const char *begin = text_after_mark(text, end);
    const size_t size = (size_t)(end - begin);
    r->file = (text_file){.context = r->scene->context, .path = path, .begin = begin, .end = end};
    if (!text_ends_lines_in_cr(begin, begin + (size < LINE_MAX_BYTES ? size : LINE_MAX_BYTES)))
        return FATHOM_OK;
    fathom_status status = text_copy(&r->file);
    if (status == FATHOM_OK) mend_lines(r->file.copy, r->file.end);
    return status;
}

fathom_status ply_read_header(ply_reader *r) {
    r->header.body = r->file.end;
    const char *body = read_lines(r);
    if (body) {
        r->header.body = body;
        if (find_roles(r) && find_faces(r)) check_counts(r);
    }
    return ply_status(r);
}

void ply_free_header(ply_header *header) {
    for (size_t i = 0; i < header->elements.count; ++i) array_free(&header->elements.items[i].properties);
    array_free(&header->elements);
}

/* ---- parts that are not read ---- */

static bool is_color(const char *name) {
    static const char *const names[] = {"red", "green", "blue",        "alpha",         "r",           "g",
                                        "b",   "a",     "diffuse_red", "diffuse_green", "diffuse_blue"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        if (strcmp(names[i], name) == 0) return true;
    }
    return false;
}

static bool has_role(const ply_reader *r, size_t property) {
    for (int role = 0; role < PLY_ROLES; ++role) {
        if (r->role[role] == (int)property) return true;
    }
    return false;
}

static void note_properties(ply_reader *r, const ply_element *element, bool vertices) {
    bool colors = false;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const char *name = element->properties.items[i].name;
        if (vertices ? has_role(r, i) : i == r->index_list) continue;
        if (is_color(name))
            colors = true;
        else
            notes_add_line(&r->notes, (size_t)element->count, &r->file, element->line,
                           "element %.40s: the property %s is not used", element->name, name);
    }
    if (colors)
        notes_add_line(&r->notes, (size_t)element->count, &r->file, element->line, "%s colours are not used",
                       vertices ? "vertex" : "face");
}

void ply_note_unused(ply_reader *r) {
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        const ply_element *element = &r->header.elements.items[i];
        if (i == r->vertex_element || i == r->face_element)
            note_properties(r, element, i == r->vertex_element);
        else
            notes_add_line(&r->notes, (size_t)element->count, &r->file, element->line,
                           "element %.40s is not read", element->name);
    }
}
