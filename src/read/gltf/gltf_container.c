/* GLB chunks and the JSON text. Which of the two a file is, its first four bytes say. */
#include "read/gltf/gltf.h"
#include "read/json/json_syntax.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_SIZE = 12, CHUNK_HEADER_SIZE = 8 };
static const uint32_t chunk_json = 0x4E4F534A, chunk_bin = 0x004E4942;

static uint32_t word_at(const unsigned char *bytes, size_t at) {
    uint32_t word;
    memcpy(&word, bytes + at, sizeof word);
    return word;
}

static fathom_status fail_byte(gltf *g, size_t at, const char *format, ...) {
    const fathom_place place = {.file = g->path, .has_byte = true, .byte = at};
    char text[256];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return fail_at(g->context, FATHOM_BAD_INPUT, &place, "%s", text);
}

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
    if (version != 2) {
        return fail_byte(g, 4, "GLB version %u; expected 2", version);
    }
    *length = word_at(map->bytes, 8);
    if (*length > map->size) {
        return fail_byte(g, 8, "the header says %zu bytes, the file ends after %zu: it is cut short", *length,
                         map->size);
    }
    if (*length < HEADER_SIZE + CHUNK_HEADER_SIZE)
        return fail_byte(g, 8, "the header's length leaves no room for a JSON chunk");
    return FATHOM_OK;
}

/* The JSON chunk comes first, the BIN chunk second; chunks of other types are skipped, as the format asks. */
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
    /* Padding is spaces by the standard; older writers pad with zeros, which no JSON parser takes. */
    while (json_size && map->bytes[json_at + json_size - 1] == 0) --json_size;
    return parse_json(g, (const char *)map->bytes + json_at, json_size, json_at);
}

void gltf_source_release(void *data) {
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
    size_t mark = map->size >= 3 && memcmp(map->bytes, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    return parse_json(g, (const char *)map->bytes + mark, map->size - mark, 0);
}
