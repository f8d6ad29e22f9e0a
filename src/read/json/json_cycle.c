/* Groups that contain each other: the scene finds them, this finds the line. */
#include "read/json/json_object.h"

#include <string.h>

/* Groups on the way from the one where the search began. */
typedef struct trail {
    const struct trail *parent;
    const char *name;
    unsigned depth;
} trail;

/* Longer ways than this, of groups and of children within them, are left to the message that names no line.
 */
enum { TRAIL_DEPTH = 256 };

static fathom_status search_group(const doc *d, json_t *groups, json_t *done, const trail *way);

static fathom_status follow(const doc *d, const where *at, json_t *groups, json_t *done, const trail *way,
                            const char *target) {
    for (const trail *step = way; step; step = step->parent) {
        if (strcmp(step->name, target) != 0) continue;
        return doc_fail(
            d, at, "group \"%.60s\" contains itself through this instance, which stands in group \"%.60s\"",
            target, way->name);
    }
    if (json_object_get(done, target)) return FATHOM_OK;
    const trail next = {way, target, way->depth + 1};
    return search_group(d, groups, done, &next);
}

static fathom_status search_list(const doc *d, const where *at, json_t *list, json_t *groups, json_t *done,
                                 const trail *way) {
    fathom_status status = FATHOM_OK;
    if (way->depth >= TRAIL_DEPTH) return FATHOM_OK;
    const trail deeper = {way->parent, way->name, way->depth + 1};
    for (size_t i = 0; i < json_array_size(list) && status == FATHOM_OK; ++i) {
        const where item = {at, NULL, i}, of = {&item, "of", 0}, children = {&item, "children", 0};
        json_t *value = json_array_get(list, i), *target = json_object_get(value, "of");
        if (target) status = follow(d, &of, groups, done, way, json_string_value(target));
        if (status == FATHOM_OK)
            status = search_list(d, &children, json_object_get(value, "children"), groups, done, &deeper);
    }
    return status;
}

static fathom_status search_group(const doc *d, json_t *groups, json_t *done, const trail *way) {
    const where map = {NULL, "groups", 0}, group = {&map, way->name, 0};
    fathom_status status = search_list(d, &group, json_object_get(groups, way->name), groups, done, way);
    json_object_set_new(done, way->name, json_true());
    return status;
}

fathom_status object_find_cycle(const doc *d, json_t *groups) {
    json_t *done = json_object();
    fathom_status status = FATHOM_OK;
    const char *name;
    json_t *list;
    json_object_foreach(groups, name, list) {
        const trail start = {NULL, name, 0};
        if (status == FATHOM_OK && !json_object_get(done, name))
            status = search_group(d, groups, done, &start);
    }
    json_decref(done);
    return status;
}
