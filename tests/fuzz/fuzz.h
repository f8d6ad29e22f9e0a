/* What the fuzz targets share. Each target is one file with LLVMFuzzerTestOneInput(); what is wrong ends the
 * process, as libFuzzer wants it.
 *
 * Files are in memory: the linker hands the readers' calls of file_open(), file_close(), file_finish(),
 * file_rest() and access() to the ones of fuzz_files.c (--wrap), so that no byte of src/ knows of fuzzing. A
 * file ends exactly FILE_PADDING zeros after its last byte: AddressSanitizer sees a read beyond. */
#pragma once

#include "base/file.h"

#include <fathom/render.h>

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What one execution may take besides what its input pays for. */
#define FUZZ_MEMORY_FREE ((size_t)131072)
/* Of the processor, an execution; the sanitizers make it up to twelve times as long. */
#define FUZZ_SECONDS 1.0
#define FUZZ_SECONDS_SANITIZED 12.0

/* ---- fuzz_limit.c ---- */

/* From here to fuzz_end(), memory in use beyond FUZZ_MEMORY_FREE + factor × size ends the process, and so
 * does fuzz_end() itself after more than FUZZ_SECONDS. Without AddressSanitizer memory is not watched. */
void fuzz_begin(size_t size, size_t factor);
void fuzz_end(void);
/* Makes the input larger by what it asks for by name: a fixed file of the folder, generated triangles. */
void fuzz_add_size(size_t bytes);
/* Says what is wrong and ends the process. */
_Noreturn void fuzz_wrong(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* ---- fuzz_files.c ---- */

/* The folder that readers see: this file, and the fixed ones of fuzz_files.c. The bytes stay the caller's. */
void fuzz_put_file(unsigned slot, const char *name, const uint8_t *data, size_t size);
/* Whether the text begins with the name of one of them and a colon. */
bool fuzz_names_file(const char *text);

/* ---- fuzz_film.c ---- */

/* A film of 12 × 12 pixels that lies in four waves, with its settings. */
void fuzz_film_make(fathom_film *film, fathom_settings *settings);
void fuzz_film_free(fathom_film *film);

/* ---- fuzz_scene.c ---- */

/* One context for all executions, with one thread. */
fathom_context *fuzz_context(void);
/* Holds a reader to its word: `status` is FATHOM_OK or FATHOM_BAD_INPUT, the latter with a message that
 * begins with a file's name and holds no control characters. */
void fuzz_judge(fathom_status status);
/* Reads and checks a scene from the file put as `path`, and a mesh file with smooth normals once more, within
 * the limits. */
void fuzz_scene(const char *path, size_t size, size_t factor);
