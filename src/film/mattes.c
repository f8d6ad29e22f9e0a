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

/* Ids are hashes of these names: the shape's own name; otherwise that of the instance that places it,
 * otherwise of its group; otherwise kind and number, which are written to `made`. */
/* Flags of groups. */
#define GROUP_PLACED 1u   /* it is the root, or an instance without a name places it */
#define GROUP_NAMELESS 2u /* a shape in it has no name */

typedef struct naming {
    const fathom_scene *scene;
    matte_kind kind;
    uint8_t *groups;
    size_t count; /* of objects and instances, or of materials */
} naming;

static bool is_named(const char *name) { return name && *name; }

static bool naming_create(const fathom_scene *scene, matte_kind kind, naming *out) {
    *out = (naming){scene, kind, calloc(scene->groups.count + 1, 1),
                    kind == MATTE_OBJECT ? scene->objects.count + scene->instances.count
                                         : scene->materials.count};
    if (!out->groups) return false;
    out->groups[FATHOM_ROOT] = GROUP_PLACED;
    for (size_t i = 0; i < scene->objects.count; ++i) {
        const scene_object *o = &scene->objects.items[i];
        if (!is_named(o->name)) out->groups[o->group] |= GROUP_NAMELESS;
    }
    for (size_t i = 0; i < scene->instances.count; ++i) {
        const fathom_instance *placed = &scene->instances.items[i];
        if (!is_named(placed->name)) out->groups[placed->group] |= GROUP_PLACED;
    }
    return true;
}

static const char *object_name(const naming *n, size_t object, char made[SCENE_NUMBERED]) {
    const scene_object *o = &n->scene->objects.items[object];
    if (is_named(o->name)) return o->name;
    if (!(n->groups[o->group] & GROUP_PLACED)) return NULL;
    const char *group = o->group == FATHOM_ROOT ? NULL : n->scene->groups.items[o->group];
    return is_named(group) ? group : scene_numbered(o, made);
}

static const char *material_name(const naming *n, size_t material, char made[SCENE_NUMBERED]) {
    const char *name = n->scene->materials.items[material].name;
    if (!is_named(name)) snprintf(made, SCENE_NUMBERED, "material %zu", material);
    return is_named(name) ? name : made;
}

/* NULL: no shape has this name. */
static const char *name_of(const naming *n, size_t i, char made[SCENE_NUMBERED]) {
    if (n->kind == MATTE_MATERIAL) return material_name(n, i, made);
    if (i < n->scene->objects.count) return object_name(n, i, made);
    const fathom_instance *placed = &n->scene->instances.items[i - n->scene->objects.count];
    return is_named(placed->name) && n->groups[placed->group] & GROUP_NAMELESS ? placed->name : NULL;
}

uint32_t *matte_ids(const fathom_scene *scene, matte_kind kind) {
    naming n;
    uint32_t *ids = naming_create(scene, kind, &n) ? malloc((n.count + 1) * sizeof *ids) : NULL;
    for (size_t i = 0; ids && i < n.count; ++i) {
        char made[SCENE_NUMBERED];
        const char *name = name_of(&n, i, made);
        ids[i] = name ? matte_id(name) : 0;
    }
    free(n.groups);
    return ids;
}

uint32_t matte_of_object(const fathom_scene *scene, const uint32_t *ids, fathom_id object,
                         fathom_id instance) {
    const uint32_t placed = instance == FATHOM_NONE || is_named(scene->objects.items[object].name)
                                ? 0
                                : ids[scene->objects.count + instance];
    return placed ? placed : ids[object];
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
static void put_entries(FILE *to, const naming *n, manifest_entry *all, size_t count) {
    char made[SCENE_NUMBERED];
    qsort(all, count, sizeof *all, by_hash);
    putc('{', to);
    for (size_t i = 0, put = 0; i < count; ++i) {
        if (i && all[i].hash == all[i - 1].hash) continue;
        fputs(put++ ? ",\"" : "\"", to);
        put_escaped(to, name_of(n, all[i].item, made));
        fprintf(to, "\":\"%08x\"", all[i].hash);
    }
    putc('}', to);
}

static size_t list_entries(const naming *n, manifest_entry *out) {
    size_t count = 0;
    for (size_t i = 0; i < n->count; ++i) {
        char made[SCENE_NUMBERED];
        const char *name = name_of(n, i, made);
        if (name) out[count++] = (manifest_entry){matte_id(name), (uint32_t)i};
    }
    return count;
}

char *matte_manifest(const fathom_scene *scene, matte_kind kind) {
    naming n;
    manifest_entry *all = naming_create(scene, kind, &n) ? malloc((n.count + 1) * sizeof *all) : NULL;
    char *text = NULL;
    size_t size;
    FILE *to = all ? open_memstream(&text, &size) : NULL;
    if (to) put_entries(to, &n, all, list_entries(&n, all));
    free(all);
    free(n.groups);
    if (to && (ferror(to) | fclose(to)) == 0) return text;
    free(text);
    return NULL;
}

const char *matte_layer(matte_kind kind) { return kind == MATTE_OBJECT ? "CryptoObject" : "CryptoMaterial"; }
