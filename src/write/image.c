#include "write/image.h"

#include "base/file.h"
#include "base/text.h"
#include "read/mesh/text.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- content ---- */

static bool same_image(const write_image *a, const write_image *b) {
    if (a->texture->file && b->texture->file) return strcmp(a->texture->file, b->texture->file) == 0;
    return a->size == b->size && memcmp(a->bytes, b->bytes, a->size) == 0;
}

static fathom_status open_image(fathom_context *context, const fathom_texture *texture, write_image *out) {
    *out = (write_image){.texture = texture, .bytes = texture->bytes, .size = texture->byte_count};
    if (!texture->file) return FATHOM_OK;
    fathom_status status = file_open(context, texture->file, &out->map);
    out->bytes = out->map.bytes, out->size = out->map.size;
    return status;
}

/* Adds the image unless it was added before. */
static fathom_status add_image(fathom_context *context, const fathom_texture *texture, write_images *to,
                               uint32_t *index) {
    write_image *image = &to->items[to->count];
    fathom_status status = open_image(context, texture, image);
    if (status != FATHOM_OK) return status;
    for (*index = 0; *index < to->count && !same_image(&to->items[*index], image);) ++*index;
    if (*index == to->count)
        ++to->count;
    else
        file_close(&image->map);
    return FATHOM_OK;
}

fathom_status write_images_open(const fathom_scene *scene, bool skies, write_images *out) {
    const size_t textures = scene->textures.count, more = skies ? scene->environments.count : 0;
    fathom_status status = FATHOM_OK;
    out->count = 0;
    out->items = calloc(textures + more + 1, sizeof *out->items);
    out->of_texture = calloc(textures + more + 1, sizeof *out->of_texture);
    out->skies = calloc(more + 1, sizeof *out->skies);
    out->sky_count = more;
    out->faces = calloc(more + 1, sizeof *out->faces);
    if (!out->items || !out->of_texture || !out->skies || !out->faces)
        return fail_memory(scene->context, (textures + more) * sizeof *out->items);
    for (size_t i = 0; i < textures && status == FATHOM_OK; ++i)
        status = add_image(scene->context, &scene->textures.items[i], out, &out->of_texture[i]);
    for (size_t i = 0; i < more && status == FATHOM_OK; ++i) {
        out->skies[i].file = scene->environments.items[i].file;
        if (strstr(out->skies[i].file, FILE_FACE)) continue;
        status = add_image(scene->context, &out->skies[i], out, &out->of_texture[textures + i]);
    }
    return status;
}

fathom_status write_image_open_one(const fathom_scene *scene, fathom_id texture, write_images *out) {
    uint32_t index;
    *out = (write_images){.items = calloc(2, sizeof *out->items)};
    if (!out->items) return fail_memory(scene->context, 2 * sizeof *out->items);
    return add_image(scene->context, &scene->textures.items[texture], out, &index);
}

void write_images_close(write_images *images) {
    for (uint32_t i = 0; i < images->count; ++i) {
        file_close(&images->items[i].map);
        free(images->items[i].name);
    }
    free(images->items);
    free(images->of_texture);
    for (size_t i = 0; images->faces && i < images->sky_count; ++i) free(images->faces[i]);
    free(images->faces);
    free(images->skies);
}

static bool begins(const write_image *image, size_t at, const char *with) {
    return image->size >= at + strlen(with) && memcmp(image->bytes + at, with, strlen(with)) == 0;
}

const char *write_image_type(const write_image *image) {
    if (begins(image, 0, "\x89PNG\r\n")) return "image/png";
    if (begins(image, 0, "\xff\xd8\xff")) return "image/jpeg";
    if (begins(image, 0, "RIFF") && begins(image, 8, "WEBP")) return "image/webp";
    if (begins(image, 4, "ftypavif")) return "image/avif";
    /* glTF has KTX 2.0 for Basis Universal alone, whose vkFormat is 0. */
    if (begins(image, 0, "\xabKTX 20\xbb\r\n\x1a\n") && image->size >= 16 &&
        memcmp(image->bytes + 12, "\0\0\0", 4) == 0)
        return "image/ktx2";
    return NULL;
}

/* ---- files ---- */

/* The path of `file` relative to the folder of `path`, if it lies in or below this folder; otherwise NULL.
 * Symbolic links are resolved first. */
static char *name_within(const char *path, const char *file) {
    char *folder = file_beside(path, "."), *from = folder ? realpath(folder, NULL) : NULL,
         *to = from ? realpath(file, NULL) : NULL, *name = NULL;
    const size_t length = from ? strlen(from) : 0;
    if (to && strncmp(to, from, length) == 0 && (to[length] == '/' || length == 1))
        name = strdup(to + length + (length > 1));
    free(folder), free(from), free(to);
    return name;
}

/* "out/scene.json" with the tag "3" and the extension "png" gives "scene-3.png". */
static char *name_from(const char *path, const char *tag, const char *extension) {
    const char *file = file_name(path);
    char name[PATH_MAX];
    snprintf(name, sizeof name, "%.*s-%s%s%s", (int)(file_stem_length(path) - (size_t)(file - path)), file,
             tag, *extension ? "." : "", extension);
    text_disarm(name);
    return strdup(name);
}

static bool is_taken(const write_images *images, const char *name) {
    for (uint32_t i = 0; i < images->count; ++i) {
        if (images->items[i].name && strcmp(images->items[i].name, name) == 0) return true;
    }
    for (size_t i = 0; i < images->sky_count; ++i) {
        if (images->faces[i] && strcmp(images->faces[i], name) == 0) return true;
    }
    return false;
}

/* A name that no other image has: files of the scene that stay in place may have the first ones. */
static char *new_name(const char *path, const write_images *images, const char *before, size_t number,
                      const char *after, const char *extension) {
    for (char tag[48], *name;; free(name)) {
        snprintf(tag, sizeof tag, "%s%zu%s", before, number++, after);
        name = name_from(path, tag, extension);
        if (!name || !is_taken(images, name)) return name;
    }
}

/* Readers of text end a name where the line or a comment begins. PLY's lines are short. */
static bool ends_line(const char *name) {
    const char *from = name, *end = name + strlen(name);
    for (const char *c = name; c < end; ++c) {
        if ((unsigned char)*c < ' ') return false;
    }
    const size_t length = text_rest(&from, end);
    return end - name < 256 && from + length == end;
}

/* As JSON is. */
static bool is_utf8(const char *name) {
    size_t length = 1;
    unsigned code;
    for (; *name && length; name += length) length = text_character(name, &code);
    return length;
}

static char *copied_name(const char *path, const write_images *images, uint32_t index) {
    const write_image *image = &images->items[index];
    const char *type = write_image_type(image);
    char extension[16] = "";
    if (image->texture->file) file_extension(image->texture->file, extension);
    if (!ends_line(extension)) *extension = '\0';
    if (!*extension && type) snprintf(extension, sizeof extension, "%s", strchr(type, '/') + 1);
    return new_name(path, images, "", index, "", extension);
}

static fathom_status copy_bytes(fathom_context *context, const char *path, const char *name,
                                const unsigned char *bytes, size_t size) {
    char *to = file_beside(path, name);
    file_writer *file;
    if (!to) return fail_memory(context, strlen(path));
    fathom_status status = file_writer_open(context, to, &file);
    free(to);
    if (status != FATHOM_OK) return status;
    file_writer_put(file, bytes, size);
    return file_writer_commit(file);
}

/* ---- environments of six files ---- */

/* The name with "<FACE>" of files that stay in place; NULL: they do not lie in or below the folder of
 * `path`. */
static char *faces_within(const char *path, const char *pattern, const file_faces *files) {
    const char *word = strstr(pattern, FILE_FACE);
    char *first = word < file_name(pattern) ? NULL : name_within(path, files->paths[0]);
    char *out = first ? file_beside(first, file_name(pattern)) : NULL;
    free(first);
    return out;
}

static fathom_status copy_face(fathom_context *context, const char *path, const char *name,
                               const char *from) {
    file_map map;
    fathom_status status = file_open(context, from, &map);
    if (status != FATHOM_OK) return status;
    status = copy_bytes(context, path, name, map.bytes, map.size);
    file_close(&map);
    return status;
}

/* "out/scene.json" gets "scene-sky-0-px.hdr" and so on. */
static char *copied_faces(const char *path, const write_images *images, size_t sky, const file_faces *files) {
    char extension[16] = "";
    file_extension(files->paths[0], extension);
    return new_name(path, images, "sky-", sky, "-" FILE_FACE, extension);
}

static fathom_status copy_faces(fathom_context *context, const char *path, const char *pattern,
                                const file_faces *files) {
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < FILE_FACES && status == FATHOM_OK; ++i) {
        char *face = file_face_name(pattern, i);
        status =
            face ? copy_face(context, path, face, files->paths[i]) : fail_memory(context, strlen(pattern));
        free(face);
    }
    return status;
}

/* Names the six files of each environment that has them. copies: those that do not stay in place, which are
 * copied; otherwise those that do. */
static fathom_status place_faces(fathom_context *context, const char *path, write_images *images,
                                 bool copies) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < images->sky_count && status == FATHOM_OK; ++i) {
        const char *pattern = images->skies[i].file;
        char **name = &images->faces[i];
        file_faces files;
        if (!strstr(pattern, FILE_FACE) || *name) continue;
        status = file_faces_open(context, pattern, &files);
        if (status != FATHOM_OK) return status;
        *name = copies ? copied_faces(path, images, i, &files) : faces_within(path, pattern, &files);
        if (copies)
            status = *name ? copy_faces(context, path, *name, &files) : fail_memory(context, strlen(path));
        file_faces_close(&files);
    }
    return status;
}

fathom_status write_images_beside(const fathom_scene *scene, const char *path, bool lines,
                                  write_images *images) {
    fathom_status status = FATHOM_OK;
    for (uint32_t i = 0; i < images->count; ++i) {
        write_image *image = &images->items[i];
        if (image->texture->file) image->name = name_within(path, image->texture->file);
        if (!image->name || (lines ? ends_line(image->name) : is_utf8(image->name))) continue;
        free(image->name);
        image->name = NULL;
    }
    for (uint32_t i = 0; i < images->count && status == FATHOM_OK; ++i) {
        write_image *image = &images->items[i];
        if (image->name) continue;
        image->name = copied_name(path, images, i);
        status = image->name ? copy_bytes(scene->context, path, image->name, image->bytes, image->size)
                             : fail_memory(scene->context, strlen(path));
    }
    if (status == FATHOM_OK) status = place_faces(scene->context, path, images, false);
    return status == FATHOM_OK ? place_faces(scene->context, path, images, true) : status;
}
