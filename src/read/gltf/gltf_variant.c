/* KHR_materials_variants: one mesh, several looks. */
#include "read/gltf/gltf.h"

static const char name[] = "KHR_materials_variants";

fathom_status gltf_variant_choose(gltf *g) {
    const char *wanted = g->scene->asked ? g->scene->asked->variant : NULL;
    char list[GLTF_LIST];
    g->variant = GLTF_ABSENT;
    fathom_status status = gltf_extension(g, &g->root, name, &g->extensions, &g->varying);
    if (status == FATHOM_OK) status = gltf_array(g, &g->varying, "variants", &g->variants);
    if (status != FATHOM_OK || !gltf_count(&g->variants)) return status;
    g->scene->has_variants = true;
    if (wanted) return gltf_choose(g, &g->variants, "variant", wanted, &g->variant);
    gltf_print_names(&g->variants, list);
    gltf_note_all(g, &g->variants, "variants are not shown; --variant NAME|N takes one of %s", list);
    return FATHOM_OK;
}

static fathom_status names_variant(gltf *g, const gltf_value *mapping, bool *out) {
    gltf_value list;
    fathom_status status = gltf_array(g, mapping, "variants", &list);
    *out = false;
    for (size_t i = 0; i < gltf_count(&list) && status == FATHOM_OK; ++i) {
        uint32_t variant = GLTF_ABSENT;
        status = gltf_index_item(g, &list, i, &g->variants, &variant);
        *out = *out || variant == g->variant;
    }
    return status;
}

fathom_status gltf_variant_material(gltf *g, const gltf_value *primitive, uint32_t *material) {
    gltf_value holder, at, mappings, mapping;
    if (g->variant == GLTF_ABSENT) return FATHOM_OK;
    fathom_status status = gltf_extension(g, primitive, name, &holder, &at);
    if (status == FATHOM_OK) status = gltf_array(g, &at, "mappings", &mappings);
    for (size_t i = 0; i < gltf_count(&mappings) && status == FATHOM_OK; ++i) {
        bool chosen = false;
        status = gltf_item(g, &mappings, i, &mapping);
        if (status == FATHOM_OK) status = names_variant(g, &mapping, &chosen);
        if (status == FATHOM_OK && chosen)
            return gltf_index(g, &mapping, "material", &g->materials, material);
    }
    return status;
}
