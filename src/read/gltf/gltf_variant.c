/* KHR_materials_variants: one mesh with several sets of materials. */
#include "read/gltf/gltf_material.h"

static const char name[] = "KHR_materials_variants";

void gltf_variant_choose(gltf *g) {
    const char *wanted = g->scene->asked ? g->scene->asked->variant : NULL;
    char list[GLTF_LIST];
    g->variant = GLTF_ABSENT;
    gltf_extension(g, &g->root, name, &g->extensions, &g->varying);
    gltf_array(g, &g->varying, "variants", &g->variants);
    if (!gltf_fine(g) || !gltf_count(&g->variants)) return;
    g->scene->has_variants = true;
    if (wanted) {
        g->variant = gltf_choose(g, &g->variants, "variant", wanted);
        return;
    }
    gltf_print_names(&g->variants, list);
    notes_add(&g->notes, gltf_count(&g->variants), "",
              "variants are not shown; --variant NAME|N takes one of %s", list);
}

static bool names_variant(gltf *g, const gltf_value *mapping) {
    gltf_value list;
    bool named = false;
    gltf_array(g, mapping, "variants", &list);
    for (size_t i = 0; i < gltf_count(&list); ++i) {
        uint32_t variant = GLTF_ABSENT;
        gltf_index_item(g, &list, i, &g->variants, &variant);
        named |= variant == g->variant;
    }
    return named;
}

void gltf_variant_material(gltf *g, const gltf_value *primitive, uint32_t *material) {
    gltf_value holder, at, mappings, mapping;
    bool chosen = false;
    if (g->variant == GLTF_ABSENT) return;
    gltf_extension(g, primitive, name, &holder, &at);
    gltf_array(g, &at, "mappings", &mappings);
    for (size_t i = 0; i < gltf_count(&mappings) && !chosen && gltf_fine(g); ++i) {
        gltf_item(g, &mappings, i, &mapping);
        chosen = names_variant(g, &mapping);
        if (chosen) gltf_index(g, &mapping, "material", &g->materials, material);
    }
}
