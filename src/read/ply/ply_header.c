#include "base/text.h"
#include "read/mesh/number.h"
#include "read/ply/ply.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

/* The longest header line. A file without a header may have no line end at all. */
#define LINE_MAX_BYTES ((size_t)1 << 16)

/* Reads a word of the header; "" at the end of the line. Longer words are truncated; no known word is that
 * long. */
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
    /* Two names for each type, in the order of ply_type. */
    static const char names[] = "char|int8|uchar|uint8|short|int16|ushort|uint16|int|int32|uint|uint32|"
                                "float|float32|double|float64";
    char word[PLY_NAME], quote[48];
    const char *at = read_word(p, word);
    int found = words_find(names, word, strlen(word));
    if (found < 0)
        return text_wrong(&r->fault, at, "property",
                          "the type %s is not known; expected char, uchar, short, ushort, int, uint, float, "
                          "double, or int8 to float64",
                          text_quote(at, quote));
    *out = (ply_type)(found / 2);
    return true;
}

static bool read_format(ply_reader *r, const char *p) {
    char word[PLY_NAME];
    const char *at = read_word(&p, word);
    int found = words_find("ascii|binary_little_endian|binary_big_endian", word, strlen(word));
    if (found < 0)
        return text_found(&r->fault, at, "format",
                          "expected ascii, binary_little_endian or binary_big_endian");
    r->header.format = (ply_format)found;
    at = read_word(&p, word);
    return strcmp(word, "1.0") == 0 || text_found(&r->fault, at, "format", "expected version 1.0");
}

/* Returns `out`. */
static const char *element_field(const ply_element *element, char out[52]) {
    snprintf(out, 52, "element %.40s", element->name);
    return out;
}

static bool read_element(ply_reader *r, const char *line, const char *p) {
    char field[52];
    ply_element element = {.line = line};
    const char *at = read_word(&p, element.name);
    if (!element.name[0]) return text_wrong(&r->fault, at, "element", "expected a name and a count");
    while (text_is_blank(*p)) ++p;
    int64_t count;
    at = p;
    if (!number_read_integer(&p, &count) || count < 0 || !text_is_break(*p))
        return text_found(&r->fault, at, element_field(&element, field), "expected a count");
    element.count = (uint64_t)count;
    return array_push(&r->header.elements, element) || text_no_memory(&r->fault);
}

static bool read_property(ply_reader *r, const char *line, const char *p) {
    if (!r->header.elements.count)
        return text_wrong(&r->fault, line, "property", "expected an element before it");
    ply_element *element = &r->header.elements.items[r->header.elements.count - 1];
    ply_property property = {.role = -1};
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
    if (!property.name[0]) return text_wrong(&r->fault, at, "property", "expected a name");
    return array_push(&element->properties, property) || text_no_memory(&r->fault);
}

/* MeshLab stores names of textures in comments. Fathom's own files have a comment with its name. */
static bool read_comment(ply_reader *r, const char *p) {
    char word[PLY_NAME];
    read_word(&p, word);
    r->by_fathom |= strcmp(word, "Fathom") == 0;
    return strcmp(word, "TextureFile") != 0 || array_push(&r->textures, p) || text_no_memory(&r->fault);
}

/* Blender 2.4 writes "Created by Blender" without the word "comment" before it. */
static bool is_remark(const char *word) {
    static const char *const words[] = {"", "comment", "obj_info", "Created"};
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        if (strcmp(word, words[i]) == 0) return true;
    }
    return false;
}

/* at: the first word of a line, `word`; p: the end of this word. */
static bool read_statement(ply_reader *r, const char *word, const char *at, const char *p) {
    if (strcmp(word, "format") == 0) return read_format(r, p);
    if (strcmp(word, "element") == 0) return read_element(r, at, p);
    if (strcmp(word, "property") == 0) return read_property(r, at, p);
    if (strcmp(word, "comment") == 0) return read_comment(r, p);
    return is_remark(word) ||
           text_found(&r->fault, at, NULL, "expected format, comment, element, property or end_header");
}

/* Returns the line after the header, NULL after a fault. */
static const char *read_lines(ply_reader *r) {
    bool has_format = false, good = true;
    char word[PLY_NAME];
    const char *end = r->file.end, *line = r->file.begin;
    for (size_t number = 0; good; ++number) {
        size_t left = (size_t)(end - line), most = left < LINE_MAX_BYTES ? left : LINE_MAX_BYTES;
        const char *newline = memchr(line, '\n', most), *p = line, *at = read_word(&p, word);
        if (number == 0 && strcmp(word, "ply") != 0)
            good = text_found(&r->fault, at, NULL, "expected \"ply\" as the first line of a PLY file");
        else if (!newline && most < left)
            good = text_wrong(&r->fault, line, NULL,
                              "a line of more than %zu characters; expected a header's, or end_header",
                              LINE_MAX_BYTES);
        else if (!newline)
            good = text_wrong(&r->fault, end, NULL, "the file ends inside the header; expected end_header");
        else if (strcmp(word, "end_header") == 0 && has_format)
            return newline + 1;
        else if (strcmp(word, "end_header") == 0)
            good = text_wrong(&r->fault, line, "end_header", "expected a format statement before it");
        else if (number > 0)
            good = read_statement(r, word, at, p);
        has_format |= strcmp(word, "format") == 0;
        if (good) line = newline + 1;
    }
    return NULL;
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

/* Rejects counts that are too large for the file's size, before anything is allocated. */
static bool check_counts(ply_reader *r) {
    char field[52];
    uint64_t left = (uint64_t)(r->file.end - r->header.body);
    if (r->header.format == PLY_ASCII) ++left; /* the last line may lack a line end */
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        const ply_element *element = &r->header.elements.items[i];
        if (!element->count) continue;
        uint64_t row = smallest_row(r, element);
        if (!row)
            return text_wrong(&r->fault, element->line, element_field(element, field),
                              "it has no properties");
        if (element->count > left / row) {
            return text_wrong(&r->fault, element->line, element_field(element, field),
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

/* The first property that has the earliest possible name of the list; -1: none. */
static int find_property(const ply_element *element, const char *names) {
    int found = -1, best = INT_MAX;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const char *name = element->properties.items[i].name;
        int word = words_find(names, name, strlen(name));
        if (word >= 0 && word < best) best = word, found = (int)i;
    }
    return found;
}

/* Colours need all three channels; without them, an opacity is ignored too. */
static void drop_partial_colors(ply_reader *r, const ply_element *vertex) {
    if (r->role[PLY_R] >= 0 && r->role[PLY_G] >= 0 && r->role[PLY_B] >= 0) return;
    for (int role = PLY_R; role <= PLY_A; ++role) {
        if (r->role[role] >= 0) vertex->properties.items[r->role[role]].role = -1;
        r->role[role] = -1;
    }
}

/* The colour of splats is that of their first spherical harmonic, the mean over all directions. */
static void find_splats(ply_reader *r, const ply_element *vertex) {
    static const char *const names[] = {"f_dc_0", "f_dc_1", "f_dc_2", "scale_0", "rot_0"};
    int found[5];
    for (int i = 0; i < 5; ++i) {
        found[i] = find_property(vertex, names[i]);
        if (found[i] < 0 || vertex->properties.items[found[i]].is_list) return;
    }
    r->splats = r->role[PLY_R] < 0;
    for (int c = 0; c < 3 && r->splats; ++c) {
        r->role[PLY_R + c] = found[c];
        vertex->properties.items[found[c]].role = PLY_R + c;
    }
}

static const char *const color_names[] = {"red|diffuse_red|r", "green|diffuse_green|g", "blue|diffuse_blue|b",
                                          "alpha|a"};

static bool find_roles(ply_reader *r) {
    const char *const names[PLY_ROLES] = {"x",
                                          "y",
                                          "z",
                                          "nx",
                                          "ny",
                                          "nz",
                                          "u|s|texture_u|texture_s",
                                          "v|t|texture_v|texture_t",
                                          "u1|s1",
                                          "v1|t1",
                                          color_names[0],
                                          color_names[1],
                                          color_names[2],
                                          color_names[3]};
    r->vertex_element = find_element(&r->header, "vertex");
    if (r->vertex_element == SIZE_MAX)
        return text_wrong(&r->fault, r->file.begin, "element vertex", "the header has none");
    const ply_element *vertex = &r->header.elements.items[r->vertex_element];
    if (vertex->count >= UINT32_MAX) {
        return text_wrong(&r->fault, vertex->line, "element vertex",
                          "%llu rows; at most 2^32 - 2 can be indexed", (unsigned long long)vertex->count);
    }
    r->vertex_count = (uint32_t)vertex->count;
    for (int role = 0; role < PLY_ROLES; ++role) {
        r->role[role] = find_property(vertex, names[role]);
        bool found = r->role[role] >= 0 && !vertex->properties.items[r->role[role]].is_list;
        if (found)
            vertex->properties.items[r->role[role]].role = role;
        else
            r->role[role] = -1;
        if (!found && role <= PLY_Z) {
            return text_wrong(&r->fault, vertex->line, "element vertex",
                              "it has no number %s; expected x, y and z", names[role]);
        }
    }
    drop_partial_colors(r, vertex);
    find_splats(r, vertex);
    return r->vertex_count ||
           text_wrong(&r->fault, r->file.begin, NULL,
                      "no vertices: expected an element vertex that is not empty, and an element face or "
                      "tristrips");
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
    if (r->face_element == SIZE_MAX || !elements[r->face_element].count) {
        r->face_element = SIZE_MAX;
        return true;
    }
    const ply_element *face = &elements[r->face_element];
    int list = find_property(face, "vertex_indices|vertex_index");
    if (list < 0 || !face->properties.items[list].is_list) {
        return text_wrong(&r->fault, face->line, element_field(face, field),
                          "it has no list vertex_indices or vertex_index");
    }
    r->index_list = (size_t)list;
    return true;
}

/* The property with one of the names; -1: there is none, or it is a list. */
static int find_number(const ply_element *element, const char *names) {
    const int found = find_property(element, names);
    return found >= 0 && !element->properties.items[found].is_list ? found : -1;
}

/* Colours of faces are read if vertices have none, and need all three channels. */
static void find_face_colors(ply_reader *r, const ply_element *face) {
    int found[4];
    for (int c = 0; c < 4; ++c) {
        found[c] = find_number(face, color_names[c]);
        if (r->role[PLY_R] >= 0 || (c < 3 && found[c] < 0)) return;
    }
    for (int c = 0; c < 4; ++c) {
        if (found[c] >= 0) face->properties.items[found[c]].role = PLY_FACE_R + c;
    }
    r->face_color = found[0], r->face_alpha = found[3];
    r->looks_read = true;
}

/* The number of a face's texture. False: faces have none. */
static bool find_texture_numbers(ply_reader *r, const ply_element *face) {
    const int found = find_number(face, "texnumber");
    if (!r->textures.count || found < 0) return false;
    face->properties.items[found].role = PLY_TEXNUMBER;
    r->looks_read = true;
    return true;
}

static void keep_one_texture(ply_reader *r) {
    if (r->textures.count > 1) {
        notes_add_at(&r->notes, r->textures.count - 1, &r->file, r->textures.items[1], true,
                     "textures after the first one are left out, because faces have no texnumber");
        r->textures.count = 1;
    }
}

/* Texture coordinates of the faces' corners go before those of vertices. */
static void find_face_uvs(ply_reader *r, const ply_element *face) {
    const int list = find_property(face, "texcoord");
    if (list < 0 || !face->properties.items[list].is_list) return;
    r->uv_list = (size_t)list;
    for (int role = PLY_U; role <= PLY_V; ++role) {
        if (r->role[role] < 0) continue;
        r->header.elements.items[r->vertex_element].properties.items[r->role[role]].role = -1;
        r->role[role] = -1;
    }
}

static void find_looks(ply_reader *r) {
    r->uv_list = SIZE_MAX;
    r->face_color = r->face_alpha = -1;
    bool numbered = false;
    if (r->face_element != SIZE_MAX && !r->strips) {
        const ply_element *face = &r->header.elements.items[r->face_element];
        find_face_uvs(r, face);
        find_face_colors(r, face);
        numbered = find_texture_numbers(r, face);
    }
    if (!numbered) keep_one_texture(r);
}

/* An element "edge" without both vertices is not read, and gets a note. */
static void find_edges(ply_reader *r) {
    static const char *const names[PLY_ENDS] = {"vertex1", "vertex2"};
    r->edge_element = find_element(&r->header, "edge");
    if (r->edge_element == SIZE_MAX) return;
    const ply_element *edge = &r->header.elements.items[r->edge_element];
    int found[PLY_ENDS];
    bool good = edge->count > 0;
    for (int end = 0; end < PLY_ENDS; ++end) {
        found[end] = find_property(edge, names[end]);
        good = good && found[end] >= 0 && !edge->properties.items[found[end]].is_list;
    }
    for (int end = 0; good && end < PLY_ENDS; ++end) edge->properties.items[found[end]].role = end;
    if (!good) r->edge_element = SIZE_MAX;
}

/* Replaces carriage returns that end lines by line feeds: in the header, and in the rows if they are text. */
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
    r->file = (text_file){
        .context = r->scene->context, .path = path, .begin = begin, .end = end, .size = r->map.size};
    if (!text_ends_lines_in_cr(begin, begin + (size < LINE_MAX_BYTES ? size : LINE_MAX_BYTES)))
        return FATHOM_OK;
    fathom_status status = text_copy(&r->file);
    if (status == FATHOM_OK) mend_lines(r->file.copy, r->file.end);
    return status;
}

fathom_status ply_read_header(ply_reader *r) {
    r->header.body = read_lines(r);
    if (r->header.body) {
        if (r->header.format != PLY_ASCII) r->file.binary = r->header.body;
        if (find_roles(r) && find_faces(r)) {
            find_looks(r);
            find_edges(r);
            check_counts(r);
        }
    }
    return text_status(&r->file, &r->fault);
}

/* ---- unused parts ---- */

static bool is_color(const char *name) {
    return words_find("red|green|blue|alpha|r|g|b|a|diffuse_red|diffuse_green|diffuse_blue", name,
                      strlen(name)) >= 0;
}

static void note_properties(ply_reader *r, size_t index) {
    const ply_element *element = &r->header.elements.items[index];
    bool colors = false;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const char *name = element->properties.items[i].name;
        if (element->properties.items[i].role >= 0 ||
            (index == r->face_element && (i == r->index_list || i == r->uv_list)))
            continue;
        if (is_color(name))
            colors = true;
        else
            notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                         "element %.40s: the property %s is not used", element->name, name);
    }
    if (colors)
        notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                     "%.40s colours are not used", element->name);
}

void ply_note_unused(ply_reader *r) {
    for (size_t i = 0; i < r->header.elements.count; ++i) {
        const ply_element *element = &r->header.elements.items[i];
        if (i == r->vertex_element && r->splats)
            notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                         "Gaussian splats are shown as points of their mean colours");
        else if (i == r->vertex_element || i == r->face_element || i == r->edge_element)
            note_properties(r, i);
        else
            notes_add_at(&r->notes, (size_t)element->count, &r->file, element->line, false,
                         "element %.40s is not read", element->name);
    }
}
