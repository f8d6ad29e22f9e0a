/* Accessors as arrays that meshes can use, each converted once, whoever shares it, and floats looked through.
 */
#include "read/gltf/gltf.h"

static fathom_status look_at_floats(gltf *g, unsigned components, gltf_floats *floats) {
    if (components == 3)
        return mesh_look_at_vertices(g->context, "entry", floats->values, floats->stride, floats->count,
                                     &floats->facts);
    return mesh_check_finite(g->context, "entry", floats->values, floats->stride, components, floats->count);
}

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
        status = gltf_accessor_floats(g, user, key, &accessor, &made.values, &made.stride);
        if (status != FATHOM_OK) return status;
        status = look_at_floats(g, components, &made);
        if (status != FATHOM_OK) return gltf_within(g, user, key, status);
        *kept = made;
    }
    *out = *kept;
    return FATHOM_OK;
}

fathom_status gltf_array_indices(gltf *g, const gltf_value *user, const char *key, bool *present,
                                 const uint32_t **out, uint32_t *count) {
    gltf_accessor accessor;
    uint32_t index = GLTF_ABSENT;
    fathom_status status =
        gltf_accessor_open(g, user, key, 1, GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT, &index, &accessor);
    *present = index != GLTF_ABSENT;
    if (status != FATHOM_OK || !*present) return status;
    const uint32_t **kept = &g->array_table[index].indices;
    if (!*kept) status = gltf_accessor_indices(g, user, key, &accessor, kept);
    if (status != FATHOM_OK) return status;
    *out = *kept;
    *count = accessor.count;
    return FATHOM_OK;
}
