/* The image files of textures. Writers embed them, or put them next to the file that they write. */
#pragma once

#include "base/file.h"
#include "scene/scene.h"

typedef struct write_image {
    const fathom_texture *texture; /* the first texture with this image */
    const unsigned char *bytes;    /* of the file */
    size_t size;
    file_map map; /* the mapping, if the bytes are those of a file */
    char *name;   /* of the file that write_images_beside() wrote or found, relative to the written file's
                     folder */
} write_image;

/* Each image once, even if several textures use it with different wrap modes or filters. */
typedef struct write_images {
    write_image *items;
    uint32_t count;
    uint32_t *of_texture; /* image of each texture of the scene, then of each environment with `skies` */
    fathom_texture *skies;
    size_t sky_count; /* environments */
    char **faces;     /* of each: the name with "<FACE>" of its six files, or NULL: it has one image */
} write_images;

/* Release with write_images_close() even after a failure. */
fathom_status write_images_open(const fathom_scene *scene, bool skies, write_images *out);
/* The image of one texture only. */
fathom_status write_image_open_one(const fathom_scene *scene, fathom_id texture, write_images *out);
/* Names each image for a file at `path`. Images in or below the folder of `path` stay in place; others are
 * copied to that folder. lines: the name will end a line of text, so that files with other names are copied.
 */
fathom_status write_images_beside(const fathom_scene *scene, const char *path, bool lines,
                                  write_images *images);
/* A prefix for names that begin with '-' or a blank: readers would take the name for an option, or drop
 * the blanks. */
static inline const char *write_before_name(const char *name) {
    return *name == '-' || *name == ' ' ? "./" : "";
}
void write_images_close(write_images *images);

/* The media type, such as "image/png", by the first bytes; NULL: not a type that glTF allows. */
const char *write_image_type(const write_image *image);
