/* The record that a finished image of a sequence leaves in place of its checkpoint. */
#include "base/file.h"
#include "base/hash.h"
#include "base/sized.h"
#include "image/image.h"
#include "job/checkpoint/checkpoint_state.h"
#include "job/render.h"
#include "scene/scene.h"

#include <fathom/session.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FINISHED_MAGIC "FTHMDONE"

/* The file, little endian. */
typedef struct finished_record {
    char magic[8];
    checkpoint_key key;
    double exposure;
    uint64_t images; /* hash of the files and of how they were written */
    uint64_t sum;    /* hash of all bytes before it */
} finished_record;

_Static_assert(sizeof(finished_record) == 4 * 8 + sizeof(checkpoint_key), "no padding");

static uint64_t sum_of(const finished_record *record) {
    return hash_of(record, offsetof(finished_record, sum));
}

static void put_text(hash *h, const char *text) {
    hash_put(h, text ? text : "", text ? strlen(text) + 1 : 1);
}

/* A file that is missing or empty counts as no bytes. Its name does not count: the files may be moved. */
static void put_file(hash *h, fathom_context *context, const char *path) {
    file_map map = {.size = 0};
    const bool there = file_open(context, path, &map) == FATHOM_OK;
    hash_put(h, &map.size, sizeof map.size);
    if (!there) return;
    hash_put(h, map.bytes, map.size);
    file_close(&map);
}

static fathom_status hash_images(fathom_context *context, const fathom_write_options *write,
                                 const char *const *files, size_t count, uint64_t *out) {
    fathom_context *own; /* the caller's context keeps its message */
    hash h;
    if (fathom_context_create(&own) != FATHOM_OK) return fail_memory(context, 1);
    hash_begin(&h);
    const char *ocio = write->ocio ? write->ocio : getenv("OCIO");
    put_text(&h, ocio);
    if (ocio) put_file(&h, own, ocio);
    put_text(&h, write->display);
    put_text(&h, write->view);
    hash_put(&h, &write->float_color, sizeof write->float_color);
    uint64_t luts = 0;
    for (size_t i = 0; i < count; ++i) {
        put_file(&h, own, files[i]);
        if (!luts && image_needs_module(files[i], write)) luts = image_config_files(write);
    }
    if (luts) hash_put(&h, &luts, sizeof luts);
    fathom_context_destroy(own);
    *out = hash_end(&h);
    return FATHOM_OK;
}

fathom_status fathom_finished_keep(fathom_context *context, const fathom_film *film, const char *path,
                                   const fathom_write_options *options, const char *const *files,
                                   size_t count) {
    if (!context || !film) return fail_null(context, "film");
    if (!path || !files) return fail_null(context, path ? "files" : "path");
    fathom_write_options write;
    fathom_status status = SIZED_OWN(context, fathom_write_options, options, &write);
    if (status != FATHOM_OK) return status;
    finished_record record = {.magic = {0}, .exposure = (double)write.exposure};
    memcpy(record.magic, FINISHED_MAGIC, sizeof record.magic);
    checkpoint_key_of(&film->settings, film->stats.scene_fingerprint, &record.key);
    checkpoint_key_set_tracer(&record.key, film->stats.tracer);
    status = hash_images(context, &write, files, count, &record.images);
    record.sum = sum_of(&record);
    file_writer *file;
    if (status == FATHOM_OK) status = file_writer_open(context, path, &file);
    if (status != FATHOM_OK) return status;
    file_writer_put(file, &record, sizeof record);
    return file_writer_commit(file);
}

/* *there: the file is a record. A checkpoint, or no file, is none. */
static fathom_status read_record(fathom_context *context, const char *path, finished_record *out,
                                 bool *there) {
    file_map map;
    *there = access(path, F_OK) == 0;
    if (!*there) return FATHOM_OK;
    fathom_status status = file_open(context, path, &map);
    if (status != FATHOM_OK) return status;
    *there = map.size >= sizeof out->magic && !memcmp(map.bytes, FINISHED_MAGIC, sizeof out->magic);
    const bool whole = *there && map.size == sizeof *out;
    if (whole) memcpy(out, map.bytes, sizeof *out);
    if (*there && !(whole && out->sum == sum_of(out) && checkpoint_key_is_whole(&out->key)))
        status = fail_file(context, FATHOM_BAD_INPUT, path,
                           "the record of a finished image is damaged; remove it to render the image again");
    return file_finish(context, &map, status);
}

static fathom_status compare(fathom_context *context, const fathom_scene *scene,
                             const fathom_settings *settings, const char *path,
                             const finished_record *record) {
    uint64_t fingerprint;
    checkpoint_key now;
    const fathom_scene view = scene_through(scene, context);
    fathom_status status = render_fingerprint(&view, &fingerprint);
    if (status != FATHOM_OK) return status;
    checkpoint_key_of(settings, fingerprint, &now);
    return checkpoint_key_compare(context, path, &record->key, &now);
}

fathom_status fathom_finished_find(fathom_context *context, const fathom_scene *scene,
                                   const fathom_settings *settings, const char *path,
                                   fathom_write_options *options, const char *const *files, size_t count,
                                   bool *finished) {
    if (!context || !scene || !settings) return fail_null(context, settings ? "scene" : "settings");
    if (!path || !files) return fail_null(context, path ? "files" : "path");
    if (!options || !finished) return fail_null(context, options ? "finished" : "write");
    *finished = false;
    finished_record record;
    fathom_write_options write;
    uint64_t images = 0;
    bool there = false;
    fathom_status status = SIZED_OWN(context, fathom_write_options, options, &write);
    if (status == FATHOM_OK) status = read_record(context, path, &record, &there);
    if (status != FATHOM_OK || !there) return status;
    status = compare(context, scene, settings, path, &record);
    if (status == FATHOM_OK) status = hash_images(context, &write, files, count, &images);
    if (status != FATHOM_OK) return status;
    const bool same_exposure = isnan(write.exposure) || (double)write.exposure == record.exposure;
    *finished = images == record.images && same_exposure;
    if (*finished)
        options->exposure = (float)record.exposure;
    else if (unlink(path) != 0)
        return fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be removed");
    return FATHOM_OK;
}
