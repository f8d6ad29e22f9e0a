/* The entries of an EXR file's header, as the file has them. */
#pragma once

#include "unit.h"

#include <stdio.h>
#include <string.h>

typedef struct exr_entry {
    char type[32];
    uint32_t size;
    unsigned char bytes[512]; /* its value, and zeros */
} exr_entry;

static inline void exr_read_word(FILE *file, char out[256]) {
    size_t length = 0;
    for (int c; (c = getc(file)) > 0 && length < 255;) out[length++] = (char)c;
    out[length] = '\0';
}

/* The test fails if the file has no such entry. A header is a list of names, types, sizes and values. */
static inline exr_entry exr_entry_of(const char *path, const char *name) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 8, SEEK_SET), 0);
    for (char found[256], type[256];;) {
        exr_entry e = {.size = 0};
        exr_read_word(file, found);
        if (!*found) fail_msg("the file has no entry %s", name);
        exr_read_word(file, type);
        snprintf(e.type, sizeof e.type, "%.31s", type);
        assert_int_equal(fread(&e.size, sizeof e.size, 1, file), 1);
        if (strcmp(found, name) != 0) {
            assert_int_equal(fseek(file, (long)e.size, SEEK_CUR), 0);
            continue;
        }
        assert_in_range(e.size, 1, sizeof e.bytes - 1);
        assert_int_equal(fread(e.bytes, e.size, 1, file), 1);
        assert_int_equal(fclose(file), 0);
        return e;
    }
}

static inline void assert_exr_text(const char *path, const char *name, const char *text) {
    const exr_entry e = exr_entry_of(path, name);
    assert_string_equal(e.type, "string");
    assert_string_equal((const char *)e.bytes, text);
}

static inline void assert_exr_bytes(const char *path, const char *name, const char *type, const void *bytes,
                                    size_t size) {
    const exr_entry e = exr_entry_of(path, name);
    assert_string_equal(e.type, type);
    assert_int_equal(e.size, size);
    assert_memory_equal(e.bytes, bytes, size);
}
