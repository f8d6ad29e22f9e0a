
#include "scene/scene.h"

static const fathom_map *map_of(const fathom_material *m, int kind) {
    return m->maps[kind].texture == FATHOM_NONE ? NULL : &m->maps[kind];
}

static void move_inside(const fathom_map *map, float *number) {
    if (map) *number = map->inverted ? (1 + *number) / 2 : *number / 2;
}

/* Only smooth surfaces mirror in the classic model. A surface that covers nothing does nothing. */
void mapped_between(const fathom_material *m, fathom_material *out) {
    const fathom_map *rough = map_of(m, FATHOM_MAP_ROUGHNESS), *cover = map_of(m, FATHOM_MAP_OPACITY);
    *out = *m;
    move_inside(map_of(m, FATHOM_MAP_METALLIC), &out->metallic);
    move_inside(map_of(m, FATHOM_MAP_TRANSMISSION), &out->transmission);
    move_inside(map_of(m, FATHOM_MAP_SPECULAR), &out->specular_factor);
    move_inside(map_of(m, FATHOM_MAP_CLEARCOAT), &out->clearcoat);
    move_inside(map_of(m, FATHOM_MAP_IRIDESCENCE), &out->iridescence);
    move_inside(map_of(m, FATHOM_MAP_DIFFUSE_TRANSMISSION), &out->diffuse_transmission);
    if (rough && !rough->inverted) out->roughness = 0;
    if (cover && cover->inverted) out->opacity = 1;
}

void mapped_between_classic(const fathom_material *m, fathom_material *out) {
    fathom_material between;
    mapped_between(m, &between);
    if (m->model == FATHOM_MODEL_METALLIC_ROUGHNESS)
        metallic_to_classic(&between, out);
    else
        *out = between;
}
