/* Materials whose numbers vary by images, before any point of them is known. */
#pragma once

#include <fathom/scene.h>

/* The material with each number that an image changes inside its range, not at the end where a part of the
 * light is missing: whatever some point of the surface can do with light, *out does. An image multiplies a
 * number, or raises it towards 1 (fathom_map.inverted). Without images it is the same material. */
void mapped_between(const fathom_material *material, fathom_material *out);
/* The same by the classic model. */
void mapped_between_classic(const fathom_material *material, fathom_material *out);
