/* Reads the images of an environment. */
#pragma once

#include "base/status.h"
#include "light/sky.h"

#include <fathom/scene.h>

/* Sets *out to width, height and texels of an equirectangular image, times the light's intensity; everything
 * else is 0. The caller frees the texels. The light's file is such an image, or holds the faces of a cube
 * (cube.h), or names six files of them (base/file_faces.h). Negative texels count as 0, with a warning.
 * FATHOM_BAD_INPUT, with the file: it cannot be read, has no colours or is not linear; or with the texel: a
 * NaN or an infinity. */
fathom_status environment_read(fathom_context *context, const fathom_light *light, sky_image *out);
