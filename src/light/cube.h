/* Cube maps, which are converted to equirectangular images (sky.h).
 *
 * Faces are oriented as in OpenGL's cube maps, seen from inside. For a direction (x, y, z) in the image's
 * axes, let r = (x, y, -z). Its face is that of the coordinate with the largest magnitude. Its position on
 * the face is
 *
 *     face     +x    -x    +y    -y    +z    -z
 *     across   -rz   +rz   +rx   +rx   +rx   -rx
 *     down     -ry   -ry   +rz   -rz   -ry   -ry
 *
 * divided by that magnitude, from -1 to 1. So +z is at the centre of the equirectangular image.
 *
 * One image holds all six faces, in squares of equal size, if its aspect ratio is exactly one of these:
 *
 *     4:3      +y          3:4      +y        6:1  +x -x +y -y +z -z
 *           -x +z +x -z          -x +z +x     1:6  the same from the top
 *              -y                   -y
 *                                   -z, turned by 180 degrees */
#pragma once

#include "light/sky.h"

/* The longest edge: the equirectangular image has 8 side² texels, of which sky.h takes less than 2^31. */
#define CUBE_SIDE_MOST 16383u

typedef struct cube {
    const struct cube_layout *layout;
    uint32_t side; /* of a face, in texels */
} cube;

/* False: images of this shape hold no cube. */
bool cube_find(uint32_t width, uint32_t height, cube *out);
/* Whether the texel is part of a face: a cross has others. */
bool cube_covers(const cube *c, uint32_t x, uint32_t y);

/* Makes 4 side x 2 side texels of those of the cube's image. Each is the mean of 3 x 3 directions, spread
 * evenly over the texel. Within a face a direction's radiance is bilinear between the centres of texels, and
 * constant from the outermost ones to the edge. False without memory. */
bool cube_unfold(const cube *c, const sky_texel *image, unsigned threads, sky_texel *out);
