#include "base/file.h"
#include "image/loader.h"

#include <string.h>

/* A PNG without its last chunk. libpng would print an error, and OpenImageIO lose memory over it. */
static bool png_is_cut(const file_map *map) {
    static const char start[] = "\x89PNG\r\n\x1a\n", end[] = "IEND\xae\x42\x60\x82";
    return map->size >= 8 && memcmp(map->bytes, start, 8) == 0 && !memmem(map->bytes, map->size, end, 8);
}

/* Whether the libraries' words tell of memory or threads that could not be had. */
static bool tells_lack(const char *words) {
    static const char *const signs[] = {"annot allocate", "to allocate", "temporarily unavailable"};
    for (size_t i = 0; i < sizeof signs / sizeof *signs; ++i) {
        if (strstr(words, signs[i])) return true;
    }
    return false;
}

/* The libraries take some of what they could not be given for a broken file, or say so in words alone. What
 * is broken is so the second time. */
static fathom_status read_by(const image_module *module, fathom_context *context, const char *path,
                             const image **out, image_message *message) {
    fathom_status status = FATHOM_OK;
    for (int i = 0; i < 2; ++i) {
        message->text[0] = '\0';
        status = module->read(path, fathom_context_threads(context), out, message);
        if (status != FATHOM_BAD_INPUT) return status;
    }
    return tells_lack(message->text) ? FATHOM_OUT_OF_RESOURCES : status;
}

fathom_status image_read(fathom_context *context, const char *path, const image **out) {
    *out = NULL;
    /* Missing files, folders and empty files are told apart here, in the words of all other readers. */
    file_map map;
    fathom_status status = file_open(context, path, &map);
    if (status != FATHOM_OK) return status;
    bool cut = png_is_cut(&map);
    file_close(&map);
    if (cut) return fail(context, FATHOM_BAD_INPUT, "%s: the PNG file is cut short", path);
    const image_module *module;
    status = loader_module(context, &module);
    if (status != FATHOM_OK) return status;
    image_message message;
    status = read_by(module, context, path, out, &message);
    if (status == FATHOM_OK) return status;
    return fail(context, status, "%s: cannot be read as an image: %s", path, message.text);
}

void image_release(const image *img) {
    const image_module *module = img ? loader_loaded() : NULL;
    if (module) module->release(img);
}
