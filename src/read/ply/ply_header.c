#include "base/text.h"
#include "read/mesh/number.h"
#include "read/ply/ply.h"

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

static bool read_type(ply_reader *r, const char **p, scalar_type *out) {
    /* Two names for each type, in the order of scalar_type. PLY has no integers of 64 bits; trimesh and other
     * programs of Python write those of NumPy. */
    static const char names[] = "char|int8|uchar|uint8|short|int16|ushort|uint16|int|int32|uint|uint32|"
                                "int64|int64|uint64|uint64|float|float32|double|float64";
    char word[PLY_NAME], quote[48];
    const char *at = read_word(p, word);
    int found = words_find(names, word, strlen(word));
    if (found < 0)
        return text_wrong(&r->fault, at, "property",
                          "the type %s is not known; expected char, uchar, short, ushort, int, uint, float, "
                          "double, or int8 to float64",
                          text_quote(at, quote));
    *out = (scalar_type)(found / 2);
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

const char *ply_element_field(const ply_element *element, char out[52]) {
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
        return text_found(&r->fault, at, ply_element_field(&element, field), "expected a count");
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
            bytes += scalar_size(property->is_list ? property->count_type : property->type);
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
            return text_wrong(&r->fault, element->line, ply_element_field(element, field),
                              "it has no properties");
        if (element->count > left / row) {
            return text_wrong(&r->fault, element->line, ply_element_field(element, field),
                              "%llu rows of at least %llu bytes do not fit into the %llu bytes that follow",
                              (unsigned long long)element->count, (unsigned long long)row,
                              (unsigned long long)left);
        }
        left -= element->count * row;
    }
    return true;
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
        if (ply_find_roles(r)) check_counts(r);
    }
    return text_status(&r->file, &r->fault);
}
