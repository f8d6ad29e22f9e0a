/* Conversion of metallic-roughness materials to the classic model. */
#ifndef SCENE_METALLIC_H
#define SCENE_METALLIC_H

#include <fathom/scene.h>

void metallic_to_classic(const fathom_material *material, fathom_material *out);

#endif
