#include "base/file.h"
#include "image/loader.h"

fathom_status image_read(fathom_context *context, const char *path, const image **out) {
    *out = NULL;
    /* Missing files, folders and empty files are told apart here, in the words of all other readers. */
    file_map map;
    fathom_status status = file_open(context, path, &map);
    if (status != FATHOM_OK) return status;
    file_close(&map);
    const image_module *module;
    status = loader_module(context, &module);
    if (status != FATHOM_OK) return status;
    image_message message = {""};
    status = module->read(path, fathom_context_threads(context), out, &message);
    if (status == FATHOM_OK) return status;
    return fail(context, status, "%s: cannot be read as an image: %s", path, message.text);
}

void image_release(const image *img) {
    const image_module *module = img ? loader_loaded() : NULL;
    if (module) module->release(img);
}
