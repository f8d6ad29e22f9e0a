/* Colours of vertices: numbers after their positions, or ZBrush's comments. */
#include "read/obj/obj.h"

#include "base/srgb.h"

#include <string.h>

/* ---- ZBrush's polypaint: comments with eight hexadecimal digits for each vertex, one after another. The
 * first two are a mask, the others red, green and blue as sRGB bytes. ---- */

static int digit(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* False if these are not eight digits. */
static bool read_paint(const char *p, float out[3]) {
    for (int k = 0; k < 4; ++k) {
        const int high = digit(p[2 * k]), low = digit(p[2 * k + 1]);
        if (high < 0 || low < 0) return false;
        if (k) out[k - 1] = (float)srgb_decoded((16 * high + low) / 255.0);
    }
    return true;
}

static bool is_painted(const obj_reader *r) {
    bool any = false;
    for (size_t i = 0; i < r->piece_count; ++i) any |= r->pieces[i].paint.count > 0;
    return any;
}

static void paint(obj_reader *r) {
    uint64_t vertex = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        for (size_t k = 0; k < r->pieces[i].paint.count; ++k) {
            const obj_mention *line = &r->pieces[i].paint.items[k];
            const char *p = line->at, *end = p + line->length;
            float color[3];
            for (; end - p >= 8 && vertex < r->total[OBJ_POSITION] && read_paint(p, color); p += 8)
                memcpy(r->colors + 3 * vertex++, color, sizeof color);
        }
    }
}

/* ---- any colours ---- */

/* Blender does not write what is linked to a colour, but the grey that the link replaces. */
static void show_colors(obj_reader *r) {
    size_t count = 0;
    for (size_t i = 0; i < r->slots.count; ++i) {
        scene_named_material *m = &r->scene->materials.items[r->slots.items[i].material];
        if (!r->slots.items[i].hidden) continue;
        for (int k = 0; k < 3; ++k) m->value.base_color[k] = 1;
        metallic_to_classic(&m->value, &m->classic);
        ++count;
    }
    notes_add(&r->notes, count, "",
              "Kd 0.8 of Blender with colours of vertices is read as 1: they replace it");
}

/* Colours are numbers from 0 to 1, but some programs write bytes. Returns whether there are any. */
static bool find_white(obj_reader *r) {
    bool finely = false;
    uint64_t count = 0;
    double brightest = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        count += r->pieces[i].colored, finely |= r->pieces[i].finely;
        brightest = fmax(brightest, r->pieces[i].brightest);
    }
    r->white = finely || brightest <= 1 ? 1 : 255;
    if (brightest > 1)
        notes_add(&r->notes, 1, "", "colours of vertices %s",
                  finely ? "above 1 are read as 1" : "are whole numbers up to 255; they are read as bytes");
    if (count == r->total[OBJ_POSITION]) show_colors(r);
    return count > 0;
}

fathom_status obj_begin_colors(obj_reader *r) {
    void *memory;
    const bool colored = find_white(r);
    if (!colored && !is_painted(r)) return FATHOM_OK;
    fathom_status status = scene_allocate_items(r->scene, r->total[OBJ_POSITION], 3 * sizeof(float), &memory);
    if (status != FATHOM_OK) return status;
    r->colors = memory;
    for (uint64_t i = 0; i < 3 * r->total[OBJ_POSITION]; ++i) r->colors[i] = 1;
    if (!colored) paint(r);
    return FATHOM_OK;
}
