/* Which place of an image of the sky a surface asks for: by the light that comes from there, times about the
 * cosine to the surface's normal.
 *
 * Between the centres of four texels radiance is bilinear, in the turn and in the cosine to the pole: in
 * these a cell that they bound has as much solid angle to one place as to another. Cell (x, y) has the texels
 * x and x + 1, which wraps, of the rows y - 1 and y. There is a row of cells more than of texels: the first
 * and the last reach from a pole to the centres of the texels next to it, and have that row twice. */
#ifndef LIGHT_SKY_CHOICE_H
#define LIGHT_SKY_CHOICE_H

#include "math/lanes.h"
#include "math/vec.h"

#include <stdint.h>

typedef struct sky_choice sky_choice;

typedef union sky_texel {
    struct {
        float rgb[3], luminance;
    };
    float all[4];
} sky_texel;

/* Takes an equirectangular image whose first row is around +y, and whose centre lies towards -z. texels: by
 * row; neither negative nor infinite. NULL: out of memory. */
sky_choice *sky_choice_create(uint32_t width, uint32_t height, const sky_texel *texels);
void sky_choice_destroy(sky_choice *c);

/* Luminance times solid angle of all. */
double sky_choice_power(const sky_choice *c);

/* A cell a lane. */
typedef struct sky_cells {
    uint32_t column[LANES], row[LANES];
} sky_cells;

/* Cells for the unit normals of `lanes`, or for all directions alike where n is 0. u chooses along the rows,
 * v among them, both in [0,1); they come to be numbers that choose in the cell. Cells without light are never
 * chosen. Returns the lanes that have one: others face no light. */
unsigned sky_choice_take(const sky_choice *c, unsigned lanes, const lanes3_f64 n, double u[LANES],
                         double v[LANES], sky_cells *out);

/* The densities per solid angle, over the luminance of the place, with which places in the cells are taken.
 */
void sky_choice_densities(const sky_choice *c, unsigned lanes, const lanes3_f64 n, const sky_cells *cells,
                          double density[LANES]);

/* The angle to +y where a row of cells begins, and the one before ends; row <= height + 1. */
double sky_row_angle(uint32_t row, uint32_t height);
double sky_luminance(const float rgb[3]);
/* The direction of the place (u, v) in [0,1]² of the image. */
vec3_f64 sky_direction(double u, double v);

#endif
