#include "base/file.h"
#include "image/helper/loader.h"

#include <string.h>

/* A PNG without its last chunk. libpng would print an error, and OpenImageIO lose memory over it. */
static bool png_is_cut(const file_map *map) {
    static const char start[] = "\x89PNG\r\n\x1a\n", end[] = "IEND\xae\x42\x60\x82";
    return map->size >= 8 && memcmp(map->bytes, start, 8) == 0 && !memmem(map->bytes, map->size, end, 8);
}

fathom_status image_read(fathom_context *context, const char *path, const image **out) {
    *out = NULL;
    /* Missing files, folders and empty files are told apart here, in the words of all other readers. */
    file_map map;
    fathom_status status = file_open(context, path, &map);
    if (status != FATHOM_OK) return status;
    bool cut = png_is_cut(&map);
    file_close(&map);
    if (cut) return fail_file(context, FATHOM_BAD_INPUT, path, "the PNG file is cut short");
    image_message message = {""};
    status = image_calls.read(path, fathom_context_threads(context), out, &message);
    if (status == FATHOM_OK) return status;
    return fail_file(context, status, path, "cannot be read as an image: %s", message.text);
}

void image_release(const image *img) { image_calls.release(img); }
