/* The file and its buffers: GLB chunks, the JSON text, files next to it, base64. Buffers are loaded when an
 * accessor first needs them. */
#include "read/gltf/gltf.h"
#include "read/json/json_where.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* ---- the file ---- */

enum { HEADER_SIZE = 12, CHUNK_HEADER_SIZE = 8 };
static const uint32_t chunk_json = 0x4E4F534A, chunk_bin = 0x004E4942;

static uint32_t word_at(const unsigned char *bytes, size_t at) {
    uint32_t word;
    memcpy(&word, bytes + at, sizeof word);
    return word;
}

#define fail_byte(g, position, ...)                                                                          \
    fail_at((g)->context, FATHOM_BAD_INPUT,                                                                  \
            &(const fathom_place){.file = (g)->path, .has_byte = true, .byte = position}, __VA_ARGS__)

/* `at`: where the text begins in a GLB; 0 for a .gltf file. */
static fathom_status parse_json(gltf *g, const char *text, size_t size, size_t at) {
    json_error_t error;
    g->text = text, g->text_at = at;
    /* Duplicate keys are an error: which of them counts would be a guess. */
    g->root = (gltf_value){.json = json_arena_read(&g->arena, text, size, JSON_REJECT_DUPLICATES, &error)};
    if (g->arena.lacked) return fail_memory(g->context, size);
    if (!g->root.json) {
        if (at) {
            return fail_byte(g, at + (size_t)(error.position > 0 ? error.position : 0),
                             "JSON chunk, line %d, column %d: %s", error.line, error.column,
                             json_syntax_text(&error));
        }
        return json_syntax_fail(g->context, g->path, &error);
    }
    if (json_is_object(g->root.json)) return FATHOM_OK;
    return fail_file(g->context, FATHOM_BAD_INPUT, g->path, "the JSON is an array; expected a glTF object");
}

static fathom_status check_header(gltf *g, const file_map *map, size_t *length) {
    if (map->size < HEADER_SIZE) return fail_byte(g, map->size, "the file ends inside the GLB header");
    uint32_t version = word_at(map->bytes, 4);
    if (version == 1)
        return fail_byte(
            g, 4,
            "the file is glTF 1.0, which is not read; expected glTF 2.0: export the model again, or "
            "convert it, for instance by gltf-pipeline");
    if (version != 2) return fail_byte(g, 4, "GLB version %u; expected 2", version);
    *length = word_at(map->bytes, 8);
    if (*length > map->size) {
        return fail_byte(g, 8, "the header says %zu bytes, the file ends after %zu: it is cut short", *length,
                         map->size);
    }
    if (*length < HEADER_SIZE + CHUNK_HEADER_SIZE)
        return fail_byte(g, 8, "the header's length leaves no room for a JSON chunk");
    return FATHOM_OK;
}

/* The JSON chunk comes first, the BIN chunk second; other chunks are skipped, as the format asks. */
static fathom_status read_chunks(gltf *g, const file_map *map, size_t length) {
    size_t json_at = 0, json_size = 0;
    for (size_t at = HEADER_SIZE, i = 0; at < length; ++i) {
        if (length - at < CHUNK_HEADER_SIZE) return fail_byte(g, at, "the file ends inside a chunk header");
        uint32_t size = word_at(map->bytes, at), type = word_at(map->bytes, at + 4);
        size_t data = at + CHUNK_HEADER_SIZE;
        if (size > length - data) {
            return fail_byte(g, at, "the chunk has %u bytes; only %zu are left", size, length - data);
        }
        if (i == 0 && type != chunk_json)
            return fail_byte(g, at + 4, "the first chunk is not JSON; expected the type 0x4E4F534A");
        if (i == 0) json_at = data, json_size = size;
        if (i == 1 && type == chunk_bin) g->binary = map->bytes + data, g->binary_size = size;
        at = data + size;
    }
    /* The standard pads with spaces, older writers with zeros, which no JSON parser takes. */
    while (json_size && map->bytes[json_at + json_size - 1] == 0) --json_size;
    return parse_json(g, (const char *)map->bytes + json_at, json_size, json_at);
}

static void release_source(void *data) {
    gltf_source *source = data;
    if (!source) return;
    file_close(&source->map);
    free(source);
}

fathom_status gltf_open(gltf *g) {
    g->source = calloc(1, sizeof *g->source);
    if (!g->source) return fail_memory(g->context, sizeof *g->source);
    fathom_status status = file_open(g->context, g->path, &g->source->map);
    if (status != FATHOM_OK) return status;
    const file_map *map = &g->source->map;
    g->file_bytes = map->size;
    if (map->size >= 4 && memcmp(map->bytes, "glTF", 4) == 0) {
        size_t length = 0;
        status = check_header(g, map, &length);
        return status == FATHOM_OK ? read_chunks(g, map, length) : status;
    }
    char extension[16];
    file_extension(g->path, extension);
    if (strcmp(extension, "glb") == 0)
        return fail_byte(g, 0, "expected the magic number \"glTF\" of a binary glTF file");
    /* A byte order mark is against the standard but harmless. */
    const char *end = (const char *)map->bytes + map->size;
    const char *text = text_after_mark((const char *)map->bytes, end);
    return parse_json(g, text, (size_t)(end - text), 0);
}

/* ---- buffers ---- */

/* The six bits of each base64 character; 0xff for other characters. */
static void make_base64_table(unsigned char table[256]) {
    static const char alphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    memset(table, 0xff, 256);
    for (unsigned i = 0; i < 64; ++i) table[(unsigned char)alphabet[i]] = (unsigned char)i;
}

/* Decodes into `out`, which has room for 3 bytes for each 4 characters begun. Returns the number of valid
 * characters, `length` on success. Padding is optional. */
static size_t decode_base64(const char *text, size_t length, unsigned char *out, size_t *size) {
    unsigned char table[256];
    make_base64_table(table);
    size_t end = length;
    while (end && length - end < 2 && text[end - 1] == '=') --end;
    *size = 0;
    for (size_t i = 0; i < end; i += 4) {
        size_t n = end - i < 4 ? end - i : 4;
        uint32_t bits = 0;
        for (size_t k = 0; k < n; ++k) {
            unsigned char six = table[(unsigned char)text[i + k]];
            if (six == 0xff) return i + k;
            bits |= (uint32_t)six << (18 - 6 * k);
        }
        if (n == 1) return i; /* six bits are no byte */
        for (size_t k = 0; k + 1 < n; ++k) out[(*size)++] = (unsigned char)(bits >> (16 - 8 * k));
    }
    return length;
}

bool gltf_is_data(const char *uri) { return strncasecmp(uri, "data:", 5) == 0; }

fathom_status gltf_data_uri(gltf *g, const gltf_value *at, const char *uri, gltf_buffer *out) {
    const char *comma = strchr(uri, ',');
    static const char mark[] = ";base64";
    const size_t mark_length = sizeof mark - 1;
    if (!comma || (size_t)(comma - uri) < mark_length ||
        strncasecmp(comma - mark_length, mark, mark_length) != 0) {
        return gltf_fail(g, at, "uri", "is a data URI without \";base64,\"; expected base64");
    }
    const char *text = comma + 1;
    size_t length = strlen(text), size;
    void *bytes;
    fathom_status status = scene_allocate(g->scene, (length + 3) / 4 * 3, &bytes);
    if (status != FATHOM_OK) return status;
    size_t good = decode_base64(text, length, bytes, &size);
    if (good != length) {
        return gltf_fail(g, at, "uri", "is not base64 from its character %zu on",
                         (size_t)(text - uri) + good);
    }
    out->bytes = bytes;
    out->size = size;
    return FATHOM_OK;
}

/* "my%20mesh.bin" -> "my mesh.bin", in place. */
static void decode_percent(char *text) {
    char *to = text;
    for (const char *from = text; *from; ++from) {
        const char code[3] = {from[1], from[1] ? from[2] : '\0', '\0'};
        bool coded = *from == '%' && isxdigit((unsigned char)code[0]) && isxdigit((unsigned char)code[1]) &&
                     strtoul(code, NULL, 16);
        *to++ = coded ? (char)strtoul(code, NULL, 16) : *from;
        if (coded) from += 2;
    }
    *to = '\0';
}

/* "http:", "file:"… */
static bool has_scheme(const char *uri) {
    const char *colon = strchr(uri, ':'), *slash = strchr(uri, '/');
    return colon && (!slash || colon < slash);
}

/* Wherever the file is. */
static fathom_status path_of(gltf *g, const gltf_value *at, const char *uri, char **path) {
    *path = NULL;
    if (has_scheme(uri)) {
        return gltf_fail(g, at, "uri", "is \"%.80s\"; expected a file next to this one or a data URI", uri);
    }
    char *name = strdup(uri);
    if (!name) return fail_memory(g->context, strlen(uri));
    decode_percent(name);
    fathom_status status = read_beside(g->scene, g->path, name, path);
    free(name);
    return gltf_within(g, at, "uri", status);
}

fathom_status gltf_file_path(gltf *g, const gltf_value *at, const char *uri, char **path) {
    fathom_status status = path_of(g, at, uri, path);
    if (status == FATHOM_OK && access(*path, F_OK) != 0) {
        free(*path);
        *path = NULL;
    }
    return status;
}

static fathom_status load_file(gltf *g, const gltf_value *at, const char *uri, gltf_buffer *out) {
    char *path;
    fathom_status status = path_of(g, at, uri, &path);
    if (status != FATHOM_OK) return status;
    gltf_source *source = calloc(1, sizeof *source);
    status = source ? file_open(g->context, path, &source->map) : fail_memory(g->context, sizeof *source);
    free(path);
    if (status != FATHOM_OK) {
        free(source);
        return gltf_within(g, at, "uri", status);
    }
    g->file_bytes += source->map.size;
    *out = (gltf_buffer){source->map.bytes, source->map.size, source, true};
    return FATHOM_OK;
}

static fathom_status load(gltf *g, const gltf_value *at, gltf_buffer *out) {
    const char *uri = NULL;
    fathom_status status = gltf_text(g, at, "uri", &uri);
    if (status != FATHOM_OK) return status;
    if (uri) return gltf_is_data(uri) ? gltf_data_uri(g, at, uri, out) : load_file(g, at, uri, out);
    if (at->index || !g->binary) {
        return gltf_fail(g, at, NULL, "has no uri%s",
                         at->index ? "; only the first buffer may lack one, as the GLB's BIN chunk"
                                   : ", and the file has no BIN chunk");
    }
    *out = (gltf_buffer){g->binary, g->binary_size, g->source, false};
    return FATHOM_OK;
}

fathom_status gltf_buffer_load(gltf *g, uint32_t index, gltf_buffer **out) {
    gltf_buffer *buffer = *out = &g->buffer_table[index];
    if (buffer->bytes) return FATHOM_OK;
    gltf_value at;
    fathom_status status = gltf_item(g, &g->buffers, index, &at);
    uint64_t size = 0;
    if (status == FATHOM_OK) status = gltf_integer(g, &at, "byteLength", 1, INT64_MAX, &size);
    if (status != FATHOM_OK) return status;
    if (!size) return gltf_fail(g, &at, "byteLength", "is missing; expected the buffer's size");
    status = load(g, &at, buffer);
    if (status != FATHOM_OK) return status;
    if (buffer->size < size) {
        return gltf_fail(g, &at, "byteLength", "is %llu; there are only %llu bytes: the data is cut short",
                         (unsigned long long)size, (unsigned long long)buffer->size);
    }
    buffer->size = size;
    return FATHOM_OK;
}

fathom_status gltf_buffer_share(gltf *g, gltf_buffer *buffer) {
    gltf_source *source = buffer ? buffer->source : NULL;
    if (!source || source->shared) return FATHOM_OK;
    source->shared = true;
    fathom_status status = scene_adopt_file(g->scene, source, release_source, &source->map);
    if (status == FATHOM_OK) return FATHOM_OK;
    /* It is released already. */
    buffer->source = NULL;
    buffer->bytes = NULL;
    if (!buffer->owns_source) g->source = NULL;
    return status;
}
