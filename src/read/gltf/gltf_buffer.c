/* The file and its buffers: GLB chunks, the JSON text, files next to it, base64. A buffer is loaded when an
 * accessor first needs it. */
#include "read/gltf/gltf_data.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* ---- the file ---- */

enum { HEADER_SIZE = 12, CHUNK_HEADER_SIZE = 8 };
enum { ZEROS_MOST = 4096 }; /* zeros skipped at the end of a JSON text: a sparse file may have any number */
static const uint32_t chunk_json = 0x4E4F534A, chunk_bin = 0x004E4942;

static uint32_t word_at(const unsigned char *bytes, size_t at) {
    uint32_t word;
    memcpy(&word, bytes + at, sizeof word);
    return word;
}

#define fail_byte(g, position, ...)                                                                          \
    ((g)->status =                                                                                           \
         fail_at((g)->context, FATHOM_BAD_INPUT,                                                             \
                 &(const fathom_place){.file = (g)->path, .has_byte = true, .byte = position}, __VA_ARGS__))

/* Like other programs, takes the last of two equal keys. */
static void parse_with_equal_keys(gltf *g, const char *text, size_t size, json_error_t *error) {
    char place[32] = "";
    if (!g->text_at) snprintf(place, sizeof place, ":%d", error->line);
    notes_add(&g->notes, 1, place, "an object has a key twice, which is against the format; the last counts");
    g->root.json = json_arena_read(&g->arena, text, size, 0, error);
}

/* `at`: where the text begins in a GLB; 0 for a .gltf file. */
static void parse_json(gltf *g, const char *begin, size_t size, size_t at) {
    json_error_t error;
    /* A byte order mark is against the standard but harmless. So are zeros at the end, which some exporters
     * use as padding. */
    const char *text = text_after_mark(begin, begin + size), *end = begin + size;
    for (int i = 0; i < ZEROS_MOST && end > text && end[-1] == 0; ++i) --end;
    size = (size_t)(end - text), at += at ? (size_t)(text - begin) : 0;
    g->text = text, g->text_at = at;
    g->root = (gltf_value){.json = json_arena_read(&g->arena, text, size, JSON_REJECT_DUPLICATES, &error)};
    if (!g->arena.lacked && !g->root.json && json_error_code(&error) == json_error_duplicate_key)
        parse_with_equal_keys(g, text, size, &error);
    if (g->arena.lacked)
        gltf_fail_memory(g, size);
    else if (!g->root.json && at)
        fail_byte(g, at + (size_t)(error.position > 0 ? error.position : 0),
                  "JSON chunk, line %d, column %d: %s", error.line, error.column, json_syntax_text(&error));
    else if (!g->root.json)
        g->status = json_syntax_fail(g->context, g->path, &error);
    else if (!json_is_object(g->root.json))
        g->status =
            fail_file(g->context, FATHOM_BAD_INPUT, g->path, "the JSON is an array; expected a glTF object");
}

/* The length in the header. Fails if it is below the minimum or above the file's size. */
static size_t read_header(gltf *g, const file_map *map) {
    const uint32_t version = map->size < HEADER_SIZE ? 0 : word_at(map->bytes, 4);
    const size_t length = map->size < HEADER_SIZE ? 0 : word_at(map->bytes, 8);
    if (map->size < HEADER_SIZE)
        fail_byte(g, map->size, "the file ends inside the GLB header");
    else if (version == 1)
        fail_byte(g, 4,
                  "the file is glTF 1.0, which is not read; expected glTF 2.0: export the model again, or "
                  "convert it, for instance by gltf-pipeline");
    else if (version != 2)
        fail_byte(g, 4, "GLB version %u; expected 2", version);
    else if (length > map->size)
        fail_byte(g, 8, "the header says %zu bytes, the file ends after %zu: it is cut short", length,
                  map->size);
    else if (length < HEADER_SIZE + CHUNK_HEADER_SIZE)
        fail_byte(g, 8, "the header's length leaves no room for a JSON chunk");
    return length;
}

/* The JSON chunk comes first, the BIN chunk second; other chunks are skipped, as the format requires. */
static void read_chunks(gltf *g, const file_map *map) {
    const size_t length = read_header(g, map);
    size_t json_at = 0, json_size = 0;
    for (size_t at = HEADER_SIZE, i = 0; at < length && gltf_fine(g); ++i) {
        if (length - at < CHUNK_HEADER_SIZE) {
            fail_byte(g, at, "the file ends inside a chunk header");
            break;
        }
        const uint32_t size = word_at(map->bytes, at), type = word_at(map->bytes, at + 4);
        const size_t data = at + CHUNK_HEADER_SIZE;
        if (size > length - data)
            fail_byte(g, at, "the chunk has %u bytes; only %zu are left", size, length - data);
        else if (i == 0 && type != chunk_json)
            fail_byte(g, at + 4, "the first chunk is not JSON; expected the type 0x4E4F534A");
        if (i == 0) json_at = data, json_size = size;
        if (i == 1 && type == chunk_bin) g->binary = map->bytes + data, g->binary_size = size;
        at = data + size;
    }
    if (!gltf_fine(g)) return;
    parse_json(g, (const char *)map->bytes + json_at, json_size, json_at);
}

static void release_source(void *data) {
    gltf_source *source = data;
    if (!source) return;
    file_close(&source->map);
    free(source);
}

/* True for JSON, which some programs give the name of a binary file. */
static bool begins_object(const file_map *map) {
    const char *text = (const char *)map->bytes, *end = text + map->size, *p = text_after_mark(text, end);
    while (p < end && isspace((unsigned char)*p)) ++p;
    return p < end && *p == '{';
}

void gltf_open(gltf *g) {
    char extension[16];
    g->source = calloc(1, sizeof *g->source);
    g->status = g->source ? file_open(g->context, g->path, &g->source->map)
                          : fail_memory(g->context, sizeof *g->source);
    if (!gltf_fine(g)) return;
    const file_map *map = &g->source->map;
    g->file_bytes = map->size;
    file_extension(g->path, extension);
    if (map->size >= 4 && memcmp(map->bytes, "glTF", 4) == 0) {
        read_chunks(g, map);
    } else if (strcmp(extension, "glb") == 0 && !begins_object(map)) {
        fail_byte(g, 0, "expected the magic number \"glTF\" of a binary glTF file");
    } else {
        parse_json(g, (const char *)map->bytes, map->size, 0);
    }
}

/* ---- buffers ---- */

/* The character that a uri codes as %2F at p; 0: none. */
static char percent_code(const char *p) {
    if (*p != '%' || !isxdigit((unsigned char)p[1]) || !isxdigit((unsigned char)p[2])) return '\0';
    return (char)strtoul((const char[]){p[1], p[2], '\0'}, NULL, 16);
}

/* The next character of base64 in a uri; 0 at the end. Some programs break it into lines. */
static char next_character(const char **p) {
    for (;;) {
        const char coded = percent_code(*p), c = coded ? coded : **p;
        *p += coded ? 3 : c != '\0';
        if (c != ' ' && c != '\t' && c != '\r' && c != '\n') return c;
    }
}

/* Decodes into `out`, which has room for 3 bytes for every 4 characters, rounded up. Returns the first
 * character that is wrong, NULL on success. Padding is optional. */
static const char *decode_base64(const char *text, unsigned char *out, size_t *size) {
    static const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char table[256] = {0}; /* the six bits of each character, plus 1 */
    const char *p = text, *at = p, *before = p;
    uint32_t bits = 0;
    unsigned count = 0;
    char c;
    for (unsigned i = 0; i < 64; ++i) table[(unsigned char)alphabet[i]] = (unsigned char)(i + 1);
    for (*size = 0; (c = next_character(&p)) != '\0' && table[(unsigned char)c]; before = at, at = p) {
        bits = bits << 6 | (table[(unsigned char)c] - 1u);
        count += 6;
        if (count >= 8) out[(*size)++] = (unsigned char)(bits >> (count -= 8));
    }
    if (count == 6) return before; /* six bits do not make a byte */
    for (int i = 0; i < 2 && c == '='; ++i) c = next_character(&p);
    return c ? at : NULL;
}

bool gltf_is_data(const char *uri) { return strncasecmp(uri, "data:", 5) == 0; }

/* An image is left out, as one is whose file is missing. */
static void reject_data(gltf *g, const gltf_value *at, bool image, const char *why) {
    if (image)
        gltf_note(g, at, "uri", "%s; the image is left out", why);
    else
        gltf_fail(g, at, "uri", "%s", why);
}

void gltf_data_uri(gltf *g, const gltf_value *at, const char *uri, bool image, gltf_buffer *out) {
    static const char mark[] = ";base64";
    const size_t mark_length = sizeof mark - 1;
    const char *comma = strchr(uri, ',');
    if (!comma || (size_t)(comma - uri) < mark_length ||
        strncasecmp(comma - mark_length, mark, mark_length) != 0) {
        reject_data(g, at, image, "is a data URI without \";base64,\"; expected base64");
        return;
    }
    char why[64];
    size_t size;
    void *bytes;
    if (gltf_fine(g)) g->status = scene_allocate(g->scene, (strlen(comma + 1) + 3) / 4 * 3, &bytes);
    if (!gltf_fine(g)) return;
    const char *wrong = decode_base64(comma + 1, bytes, &size);
    if (wrong) snprintf(why, sizeof why, "is not base64 from its character %zu on", (size_t)(wrong - uri));
    if (wrong)
        reject_data(g, at, image, why);
    else
        *out = (gltf_buffer){.bytes = bytes, .size = size};
}

/* "my%20mesh.bin" -> "my mesh.bin"; release it with free(). NULL: reading has failed. */
static char *decoded(gltf *g, const char *uri) {
    char *text = gltf_fine(g) ? strdup(uri) : NULL, *to = text;
    if (!text) {
        gltf_fail_memory(g, strlen(uri));
        return NULL;
    }
    for (const char *from = uri; *from; ++from) {
        const char coded = percent_code(from);
        *to++ = coded ? coded : *from;
        if (coded) from += 2;
    }
    *to = '\0';
    return text;
}

/* "http:", "file:"… */
static bool has_scheme(const char *uri) {
    const char *colon = strchr(uri, ':'), *slash = strchr(uri, '/');
    return colon && (!slash || colon < slash);
}

/* True if the image gets a note of its own: the first few do. */
static bool names_lost_image(gltf *g, size_t image) {
    for (unsigned i = 0; i < g->lost_image_count; ++i)
        if (g->lost_images[i] == image) return true;
    if (g->lost_image_count == GLTF_LOST_IMAGES) return false;
    g->lost_images[g->lost_image_count++] = (uint32_t)image;
    return true;
}

char *gltf_image_path(gltf *g, const gltf_value *at, const char *uri) {
    enum { SHOWN = 60 }; /* the end of a long uri has the file's name */
    const size_t length = strlen(uri);
    const bool cut = length > SHOWN;
    const char *name = NULL;
    char place[128];
    char *path = NULL, *file = decoded(g, uri);
    if (file) gltf_within(g, at, "uri", read_image_beside(g->scene, g->path, file, &path));
    const bool outside = file && !path && read_is_outside(g->scene, g->path, file);
    free(file);
    gltf_text(g, at, "name", &name);
    if (path || !gltf_fine(g)) return path;
    const char *told = outside ? READ_OUTSIDE : "there is no such file that may be read; it is left out";
    snprintf(place, sizeof place, "images[%zu].uri: \"%s%s\"%s%.30s%s", at->at.index, cut ? "..." : "",
             uri + (cut ? length - SHOWN : 0), name ? " (named \"" : "", name ? name : "", name ? "\")" : "");
    if (names_lost_image(g, at->at.index))
        notes_add(&g->notes, 1, "", "%s: %s", place, told);
    else
        notes_add(&g->notes, 1, "", "images beyond the first %d: %s", GLTF_LOST_IMAGES, told);
    return NULL;
}

static void load_file(gltf *g, const gltf_value *at, const char *uri, gltf_buffer *out) {
    if (has_scheme(uri))
        gltf_fail(g, at, "uri", "is \"%.80s\"; expected a file next to this one or a data URI", uri);
    char *path = NULL, *file = decoded(g, uri);
    if (file) gltf_within(g, at, "uri", read_beside(g->scene, g->path, file, &path));
    free(file);
    if (!path) return;
    gltf_source *source = calloc(1, sizeof *source);
    if (source)
        gltf_within(g, at, "uri", file_open(g->context, path, &source->map));
    else
        gltf_fail_memory(g, sizeof *source);
    free(path);
    if (!gltf_fine(g)) {
        free(source);
        return;
    }
    g->file_bytes += source->map.size;
    *out = (gltf_buffer){source->map.bytes, source->map.size, source, true};
}

static void load(gltf *g, const gltf_value *at, gltf_buffer *out) {
    const char *uri = NULL;
    gltf_text(g, at, "uri", &uri);
    if (uri && gltf_is_data(uri))
        gltf_data_uri(g, at, uri, false, out);
    else if (uri)
        load_file(g, at, uri, out);
    else if (at->at.index || !g->binary)
        gltf_fail(g, at, NULL, "has no uri%s",
                  at->at.index ? "; only the first buffer may lack one, as the GLB's BIN chunk"
                               : ", and the file has no BIN chunk");
    else
        *out = (gltf_buffer){g->binary, g->binary_size, g->source, false};
}

/* Checks byteLength. Views are checked against the buffer's actual size, not against byteLength. */
static void check_length(gltf *g, const gltf_value *at, const gltf_buffer *buffer) {
    uint64_t size = 0;
    gltf_integer(g, at, "byteLength", 0, INT64_MAX, &size);
    if (!json_object_get(at->json, "byteLength"))
        gltf_note(g, at, "byteLength", "a buffer's length is missing; all its bytes count");
    else if (buffer->size < size && gltf_fine(g))
        gltf_note(g, at, "byteLength", "a buffer has fewer bytes than it says: it may be cut short");
}

fathom_status gltf_buffer_load(gltf *g, uint32_t index, gltf_buffer **out) {
    gltf_value at;
    gltf_buffer *buffer = *out = &g->buffer_table[index];
    if (!gltf_fine(g) || buffer->bytes) return g->status;
    gltf_item(g, &g->buffers, index, &at);
    if (gltf_fine(g)) load(g, &at, buffer);
    if (gltf_fine(g)) check_length(g, &at, buffer);
    return g->status;
}

void gltf_buffer_share(gltf *g, gltf_buffer *buffer) {
    gltf_source *source = buffer ? buffer->source : NULL;
    if (!gltf_fine(g) || !source || source->shared) return;
    source->shared = true;
    g->status = scene_adopt_file(g->scene, source, release_source, &source->map);
    if (gltf_fine(g)) return;
    /* On failure, the call has released it already. */
    buffer->source = NULL;
    buffer->bytes = NULL;
    if (!buffer->owns_source) g->source = NULL;
}
