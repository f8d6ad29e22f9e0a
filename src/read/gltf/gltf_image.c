/* Images: in files, data URIs and buffer views. */
#include "image/helper/helper.h"
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_material.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The bytes of an image in a buffer view. */
static void view_image(gltf *g, uint32_t index, fathom_texture *out) {
    gltf_value at;
    gltf_view view;
    gltf_view_open(g, index, &at, &view);
    out->bytes = view.bytes, out->byte_count = (size_t)view.length;
}

void gltf_image_open(gltf *g, const gltf_value *at, fathom_texture *out, char **path) {
    const char *uri = NULL;
    uint32_t view = GLTF_ABSENT;
    gltf_text(g, at, "uri", &uri);
    gltf_text(g, at, "name", &out->name);
    gltf_text(g, at, "mimeType", &out->mime);
    gltf_index(g, at, "bufferView", &g->views, &view);
    if (!gltf_fine(g)) return;
    if (view != GLTF_ABSENT) {
        view_image(g, view, out);
    } else if (!uri) {
        gltf_note(g, at, NULL, "an image with neither uri nor bufferView is left out");
    } else if (gltf_is_data(uri)) {
        gltf_buffer *bytes = &g->image_table[at->at.index].data;
        if (!bytes->bytes) gltf_data_uri(g, at, uri, true, bytes);
        out->bytes = bytes->bytes, out->byte_count = (size_t)bytes->size;
    } else {
        out->file = *path = gltf_image_path(g, at, uri);
    }
}

/* ---- images that another one may replace ---- */

#define ROWS_MOST ((size_t)1 << 20) /* bytes */

/* Most formats of extensions are unpacked whole for their first row. Rows that take much memory are left to
 * the render. */
static fathom_status read_all_rows(image_texture *open, const image_texture_info *info, image_message *why) {
    const size_t row = (size_t)info->width * info->channels * image_texel_size(info->sent);
    const uint32_t most = (uint32_t)(ROWS_MOST / row / info->band) * info->band;
    if (info->mipmapped || !most) return FATHOM_OK;
    void *texels = malloc(row * most);
    fathom_status status = texels ? FATHOM_OK : FATHOM_OUT_OF_RESOURCES;
    for (uint32_t y = 0; y < info->height && status == FATHOM_OK; y += most) {
        const uint32_t count = info->height - y < most ? info->height - y : most;
        const image_region rows = {.x1 = info->width, .y0 = y, .y1 = y + count};
        status = image_calls.texture.read(open, &rows, texels, row * count, why);
    }
    free(texels);
    return status;
}

static fathom_status try_image(const gltf *g, const fathom_texture *t, image_message *why) {
    image_texture *open;
    image_texture_info info;
    image_texture_request request = {.path = t->file,
                                     .descriptor = -1,
                                     .most_side = FATHOM_TEXTURE_SIDE,
                                     .most_texels = FATHOM_TEXTURE_TEXELS,
                                     .threads = fathom_context_threads(g->context)};
    if (!t->file && (request.descriptor = file_in_memory(t->bytes, t->byte_count)) < 0)
        return FATHOM_OUT_OF_RESOURCES;
    fathom_status status = image_calls.texture.open(&request, &open, &info, why);
    if (!t->file) close(request.descriptor);
    if (status != FATHOM_OK) return status;
    status = read_all_rows(open, &info, why);
    image_calls.texture.close(open);
    return status;
}

static void note_replaced(gltf *g, const gltf_value *at, const fathom_texture *t, const char *why) {
    char place[128];
    const char *name = t->file ? t->file : t->name, *folder = name ? strrchr(name, '/') : NULL;
    const int length = snprintf(place, sizeof place, ": images[%zu]", at->at.index);
    if (name) snprintf(place + length, sizeof place - (size_t)length, " (%.80s)", folder ? folder + 1 : name);
    notes_add(&g->notes, 1, place,
              "cannot be read as a texture: %.200s; the other image of its texture is used", why);
}

/* If memory is lacking, the image may still be valid: the render tries it again, and then fails with a
 * message. */
bool gltf_image_opens(gltf *g, uint32_t index) {
    gltf_image *known = &g->image_table[index];
    gltf_value at;
    fathom_texture t;
    char *path = NULL;
    image_message why = {"there is no image"};
    if (known->tried) return !known->broken;
    fathom_texture_default(&t);
    gltf_item(g, &g->images, index, &at);
    gltf_image_open(g, &at, &t, &path);
    if (gltf_fine(g)) {
        known->tried = true;
        known->broken = !t.file && !t.bytes ? true : try_image(g, &t, &why) == FATHOM_BAD_INPUT;
        if (known->broken) note_replaced(g, &at, &t, why.text);
    }
    free(path);
    return !known->broken;
}
