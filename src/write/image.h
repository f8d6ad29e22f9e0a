/* The files of images that textures use, as writers embed them or put them next to what they write. */
#ifndef WRITE_IMAGE_H
#define WRITE_IMAGE_H

#include "base/file.h"
#include "scene/scene.h"

typedef struct write_image {
    const fathom_texture *texture; /* the first of this image */
    const unsigned char *bytes;    /* of the file */
    size_t size;
    file_map map; /* where the bytes are those of a file */
    char *name;   /* of the file that write_images_beside() made or found: as another file next to it says */
} write_image;

/* Each image once, although several textures look it up in different ways. */
typedef struct write_images {
    write_image *items;
    uint32_t count;
    uint32_t *of_texture; /* one for each of the scene's textures, and with `skies` of its environments */
    fathom_texture *skies;
} write_images;

/* Release with write_images_close() even after a failure. */
fathom_status write_images_open(const fathom_scene *scene, bool skies, write_images *out);
/* That of one texture alone. */
fathom_status write_image_open_one(const fathom_scene *scene, fathom_id texture, write_images *out);
/* Names each image for a file at `path`: images in its folder, or below it, stay where they are; others are
 * copied next to it. */
fathom_status write_images_beside(const fathom_scene *scene, const char *path, write_images *images);
void write_images_close(write_images *images);

/* "image/png" and the like, by the first bytes; NULL: none of those that glTF knows. */
const char *write_image_type(const write_image *image);

#endif
