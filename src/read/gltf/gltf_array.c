/* Accessors as arrays that meshes can use, each converted and looked through once, whoever shares it. */
#include "read/gltf/gltf.h"
#include "scene/array_check.h"

fathom_status gltf_array_floats(gltf *g, const gltf_value *user, const char *key, unsigned components,
                                unsigned takes, bool *present, gltf_floats *out) {
    gltf_accessor accessor;
    uint32_t index = GLTF_ABSENT;
    fathom_status status = gltf_accessor_open(g, user, key, components, takes, &index, &accessor);
    *present = index != GLTF_ABSENT;
    if (status != FATHOM_OK || !*present) return status;
    gltf_floats *kept = &g->array_table[index].floats;
    if (!kept->values) {
        gltf_floats made = {.count = accessor.count};
        status = gltf_accessor_floats(g, &accessor, &made.values, &made.stride);
        if (status != FATHOM_OK) return status;
        status = array_check_finite(g->context, "entry", made.values, made.stride, components, made.count);
        if (status != FATHOM_OK) return gltf_within(g, user, key, status);
        *kept = made;
    }
    *out = *kept;
    return FATHOM_OK;
}

fathom_status gltf_array_indices(gltf *g, const gltf_value *user, const char *key, uint32_t vertices,
                                 bool *present, const uint32_t **out, uint32_t *count) {
    gltf_accessor accessor;
    uint32_t index = GLTF_ABSENT;
    fathom_status status =
        gltf_accessor_open(g, user, key, 1, GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT, &index, &accessor);
    *present = index != GLTF_ABSENT;
    if (status != FATHOM_OK || !*present) return status;
    gltf_array_entry *kept = &g->array_table[index];
    if (!kept->indices) {
        status = gltf_accessor_indices(g, &accessor, &kept->indices);
        if (status != FATHOM_OK) return status;
    }
    /* Held against the fewest vertices so far: shared indices are looked through once as a rule. */
    if (!kept->vertices || vertices < kept->vertices) {
        status = array_check_indices(g->context, "entry", kept->indices, accessor.count, vertices);
        if (status != FATHOM_OK) return gltf_within(g, user, key, status);
        kept->vertices = vertices;
    }
    *out = kept->indices;
    *count = accessor.count;
    return FATHOM_OK;
}
