#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

typedef struct fuzz_file {
    const char *name;
    const void *bytes;
    size_t size;
} fuzz_file;

#define TEXT(name, text)                                                                                     \
    { name, text, sizeof(text) - 1 }
#define SLOTS 2

/* What scenes and models may name. data.bin: a square's four corners and six indices of 16 bits. */
static fuzz_file files[] = {
    {NULL, NULL, 0},
    {NULL, NULL, 0},
    TEXT("data.bin", "\0\0\0\0\0\0\0\0\0\0\0\0"
                     "\0\0\x80\x3f\0\0\0\0\0\0\0\0"
                     "\0\0\x80\x3f\0\0\x80\x3f\0\0\0\0"
                     "\0\0\0\0\0\0\x80\x3f\0\0\0\0"
                     "\0\0\1\0\2\0\0\0\2\0\3\0"),
    TEXT("b.obj", "mtllib b.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n"),
    TEXT("b.mtl", "newmtl red\nKd 1 0 0\n"),
    TEXT("b.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
                  "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 "
                  "0\n0 1 0\n3 0 1 2\n"),
    TEXT(
        "b.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"data.bin\",\"byteLength\":60}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}"
        "],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},{"
        "\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],\"meshes\":[{"
        "\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],\"nodes\":[{\"mesh\":0}]}"),
};

void fuzz_put_file(unsigned slot, const char *name, const uint8_t *data, size_t size) {
    if (slot >= SLOTS) abort();
    files[slot] = (fuzz_file){name, data, size};
}

static const fuzz_file *find(const char *path) {
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        if (files[i].name && strcmp(files[i].name, path) == 0) return &files[i];
    }
    return NULL;
}

bool fuzz_names_file(const char *text) {
    for (size_t i = 0; i < sizeof files / sizeof *files; ++i) {
        size_t length = files[i].name ? strlen(files[i].name) : 0;
        if (length && strncmp(files[i].name, text, length) == 0 && text[length] == ':') return true;
    }
    return false;
}

/* Declared by the originals' types: a change of theirs that is not followed here does not compile. */
__typeof__(file_open) __wrap_file_open;
__typeof__(file_close) __wrap_file_close;
__typeof__(file_finish) __wrap_file_finish;
__typeof__(file_rest) __wrap_file_rest;
int __wrap_access(const char *path, int mode);

fathom_status __wrap_file_open(fathom_context *context, const char *path, file_map *out) {
    *out = (file_map){0};
    const fuzz_file *file = find(path);
    if (!file) return fail(context, FATHOM_BAD_INPUT, "%s: No such file or directory", path);
    if (!file->size) return fail(context, FATHOM_BAD_INPUT, "%s: the file is empty", path);
    if (file >= &files[SLOTS]) fuzz_add_size(file->size + FILE_PADDING);
    unsigned char *bytes = malloc(file->size + FILE_PADDING);
    if (!bytes) return fail_memory(context, file->size);
    memcpy(bytes, file->bytes, file->size);
    memset(bytes + file->size, 0, FILE_PADDING);
    *out = (file_map){.bytes = bytes, .size = file->size};
    return FATHOM_OK;
}

void __wrap_file_close(file_map *map) {
    free((void *)(uintptr_t)map->bytes);
    *map = (file_map){0};
}

fathom_status __wrap_file_finish(fathom_context *context, file_map *map, fathom_status status) {
    (void)context;
    __wrap_file_close(map);
    return status;
}

void __wrap_file_rest(const file_map *map, size_t begin, size_t end) { (void)map, (void)begin, (void)end; }

int __wrap_access(const char *path, int mode) {
    (void)mode;
    return find(path) ? 0 : -1;
}
