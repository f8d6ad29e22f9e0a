#include "film/mattes.h"

#include "base/murmur.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- lists ---- */

void matte_add(matte_list *to, uint32_t id, uint32_t count) {
    uint32_t i = 0;
    while (i < MATTE_MOST && to->id[i] && to->id[i] != id) ++i;
    if (!id || i == MATTE_MOST) return;
    to->id[i] = id, to->count[i] += count;
}

void matte_add_all(matte_list *to, const matte_list *from) {
    for (uint32_t i = 0; i < MATTE_MOST && from->id[i]; ++i) matte_add(to, from->id[i], from->count[i]);
}

static bool is_before(const matte_list *list, uint32_t a, uint32_t b) {
    return list->count[a] != list->count[b] ? list->count[a] > list->count[b] : list->id[a] < list->id[b];
}

void matte_rank(const matte_list *list, uint32_t samples, float out[2 * MATTE_RANKS]) {
    uint32_t order[MATTE_MOST], count = 0;
    for (; count < MATTE_MOST && list->id[count]; ++count) {
        uint32_t at = count;
        for (; at > 0 && is_before(list, count, order[at - 1]); --at) order[at] = order[at - 1];
        order[at] = count;
    }
    memset(out, 0, 2 * MATTE_RANKS * sizeof *out);
    for (uint32_t k = 0; k < MATTE_RANKS && k < count; ++k) {
        memcpy(&out[2 * k], &list->id[order[k]], sizeof *out);
        out[2 * k + 1] = (float)((double)list->count[order[k]] / samples);
    }
}

/* ---- names and ids ---- */

/* Avoids the exponents 0 and 255, which would give zeros, denormals, infinities and NaN. */
static uint32_t float_bits(uint32_t hash) {
    const uint32_t exponent = hash >> 23 & 255, kept = exponent < 1 ? 1 : exponent > 254 ? 254 : exponent;
    return (hash & 0x807fffffu) | kept << 23;
}

uint32_t matte_id(const char *name) { return float_bits(murmur_hash(name, strlen(name))); }

/* Ids are hashes of these names: the shape's own name, otherwise its group's; otherwise kind and number, such
 * as "sphere 3", which are written to `made`. */
#define MADE_NAME 32

static const char *name_or(const char *name, const char *kind, size_t number, char made[MADE_NAME]) {
    if (name && *name) return name;
    snprintf(made, MADE_NAME, "%s %zu", kind, number);
    return made;
}

static const char *object_name(const fathom_scene *scene, fathom_id object, char made[MADE_NAME]) {
    static const char *const kinds[] = {
        [SCENE_SPHERE] = "sphere", [SCENE_QUAD] = "quad", [SCENE_PLANE] = "plane", [SCENE_MESH] = "mesh"};
    const scene_object *o = &scene->objects.items[object];
    const char *group = o->group == FATHOM_ROOT ? NULL : scene->groups.items[o->group];
    return name_or(o->name ? o->name : group, kinds[o->kind], o->index, made);
}

static const char *material_name(const fathom_scene *scene, fathom_id material, char made[MADE_NAME]) {
    return name_or(scene->materials.items[material].name, "material", material, made);
}

static size_t count_of(const fathom_scene *scene, matte_kind kind) {
    return kind == MATTE_OBJECT ? scene->objects.count : scene->materials.count;
}

static const char *name_of(const fathom_scene *scene, matte_kind kind, size_t i, char made[MADE_NAME]) {
    return (kind == MATTE_OBJECT ? object_name : material_name)(scene, (fathom_id)i, made);
}

uint32_t *matte_ids(const fathom_scene *scene, matte_kind kind) {
    const size_t count = count_of(scene, kind);
    uint32_t *ids = malloc((count + 1) * sizeof *ids);
    for (size_t i = 0; ids && i < count; ++i) {
        char made[MADE_NAME];
        ids[i] = matte_id(name_of(scene, kind, i, made));
    }
    return ids;
}

/* ---- the manifest ---- */

/* Escapes quotes, backslashes and control characters, as JSON requires. */
static void put_escaped(FILE *to, const char *text) {
    for (; *text; ++text) {
        const unsigned char c = (unsigned char)*text;
        if (c < 0x20)
            fprintf(to, "\\u%04x", c);
        else
            fprintf(to, "%s%c", c == '"' || c == '\\' ? "\\" : "", c);
    }
}

typedef struct manifest_entry {
    uint32_t hash;
    uint32_t item;
} manifest_entry;

static int by_hash(const void *a, const void *b) {
    const manifest_entry *x = a, *y = b;
    if (x->hash != y->hash) return x->hash < y->hash ? -1 : 1;
    return x->item < y->item ? -1 : x->item > y->item;
}

/* Writes each id once, in the order of the ids. */
static void put_entries(FILE *to, const fathom_scene *scene, matte_kind kind, manifest_entry *all,
                        size_t count) {
    char made[MADE_NAME];
    qsort(all, count, sizeof *all, by_hash);
    putc('{', to);
    for (size_t i = 0, put = 0; i < count; ++i) {
        if (i && all[i].hash == all[i - 1].hash) continue;
        fputs(put++ ? ",\"" : "\"", to);
        put_escaped(to, name_of(scene, kind, all[i].item, made));
        fprintf(to, "\":\"%08x\"", all[i].hash);
    }
    putc('}', to);
}

char *matte_manifest(const fathom_scene *scene, matte_kind kind) {
    const size_t count = count_of(scene, kind);
    manifest_entry *all = malloc((count + 1) * sizeof *all);
    char *text = NULL, made[MADE_NAME];
    size_t size;
    FILE *to = all ? open_memstream(&text, &size) : NULL;
    for (size_t i = 0; to && i < count; ++i) {
        all[i] = (manifest_entry){matte_id(name_of(scene, kind, i, made)), (uint32_t)i};
    }
    if (to) put_entries(to, scene, kind, all, count);
    free(all);
    if (to && (ferror(to) | fclose(to)) == 0) return text;
    free(text);
    return NULL;
}

const char *matte_layer(matte_kind kind) { return kind == MATTE_OBJECT ? "CryptoObject" : "CryptoMaterial"; }
