/* Conversion of metallic-roughness materials to the classic model. */
#pragma once

#include <fathom/scene.h>

void metallic_to_classic(const fathom_material *material, fathom_material *out);
