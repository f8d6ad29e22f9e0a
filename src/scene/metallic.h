/* Metallic-roughness materials as the classic model has them. */
#ifndef SCENE_METALLIC_H
#define SCENE_METALLIC_H

#include <fathom/scene.h>

void metallic_to_classic(const fathom_material *material, fathom_material *out);

#endif
