/* glTF files of arrays, made array by array: put() each, then build_read() with the other members. */
#pragma once

#include "gltf_file.h"

#include <stdarg.h>

typedef struct build {
    unsigned char bytes[16384];
    size_t size;
    char views[8192], accessors[8192];
    int count;
} build;

/* The number of the new accessor and view. */
static inline int put_typed(build *b, int component, const char *type, unsigned count, const void *data,
                            size_t size, const char *more) {
    const char *comma = b->count ? "," : "";
    assert_true(b->size + size + 4 <= sizeof b->bytes);
    memcpy(b->bytes + b->size, data, size);
    snprintf(b->views + strlen(b->views), 256, "%s{'buffer':0,'byteOffset':%zu,'byteLength':%zu}", comma,
             b->size, size);
    snprintf(b->accessors + strlen(b->accessors), 256,
             "%s{'bufferView':%d,'componentType':%d,'type':'%s','count':%u%s}", comma, b->count, component,
             type, count, more);
    b->size += (size + 3) / 4 * 4;
    return b->count++;
}

#define PUT_FLOATS(b, type, count, ...)                                                                      \
    put_typed(b, 5126, type, count, (const float[]){__VA_ARGS__}, sizeof((const float[]){__VA_ARGS__}), "")
#define PUT_BYTES(b, type, count, ...)                                                                       \
    put_typed(b, 5121, type, count, (const uint8_t[]){__VA_ARGS__}, sizeof((const uint8_t[]){__VA_ARGS__}),  \
              "")

/* Writes the file; `members`: the JSON besides buffers, views and accessors. */
__attribute__((format(printf, 2, 3))) static inline void build_write(const build *b, const char *members,
                                                                     ...) {
    char tail[8192], json[32768];
    va_list args;
    va_start(args, members);
    vsnprintf(tail, sizeof tail, members, args);
    va_end(args);
    snprintf(json, sizeof json,
             "{" ASSET ",'buffers':[{'byteLength':%zu}],'bufferViews':[%s],'accessors':[%s],%s}", b->size,
             b->views, b->accessors, tail);
    write_glb(json, b->bytes, b->size);
}

/* Reads file_path as a user does. */
static inline fathom_status read_asked(const fathom_read_options *asked, fathom_scene **out) {
    forget_warnings();
    const fathom_status status = fathom_scene_read_with(context, file_path, asked, out);
    if (status == FATHOM_OK) own_scene(*out);
    return status;
}

static inline fathom_scene *read_as(const fathom_read_options *asked) {
    fathom_scene *scene;
    assert_ok(context, read_asked(asked, &scene));
    return scene;
}

static inline fathom_scene *read_at(double time) {
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = time;
    return read_as(&asked);
}

/* Reads file_path, which is refused with this text in the message. */
static inline void assert_bad_input(const char *text) {
    fathom_scene *scene;
    fathom_read_options asked = default_read_options();
    assert_int_equal(read_asked(&asked, &scene), FATHOM_BAD_INPUT);
    if (!strstr(fathom_context_message(context), text)) fail_msg("%s", fathom_context_message(context));
}

/* Corner c of the first triangle of mesh m, where instance i places it. */
static inline vec3_f64 placed_corner(const fathom_scene *scene, size_t i, size_t m, int c) {
    affine_f64 map;
    affine_load(&map, scene->instances.items[i].transform);
    return affine_point(&map, corner(scene, m, 0, c));
}
