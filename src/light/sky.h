/* Images of skies: where their light is, and how surfaces ask for it.
 *
 * Between the centres of four texels radiance is bilinear, in the turn and in the cosine to the pole: in
 * these a cell that they bound has as much solid angle to one place as to another. Cell (x, y) has the texels
 * x and x + 1, which wraps, of the rows y - 1 and y. There is a row of cells more than of texels: the first
 * and the last reach from a pole to the centres of the texels next to it, and have that row twice.
 *
 * A surface asks for a place by the light that comes from there, times about the cosine to its normal. A cell
 * is found by inversion: the row of blocks, the block, the row of cells in it, the cell. Unlike an alias
 * table that keeps samples that are even over the square even over the light.
 *
 * The choice of a block depends on the surface's normal. Normals fall into cells of an octahedron, each of
 * which has a table of the blocks: a product of light and cosine as coarse as that needs no table of all
 * pairs of normals and cells, and leaves out the half of the sky behind the surface. */
#ifndef LIGHT_SKY_H
#define LIGHT_SKY_H

#include "math/lanes.h"
#include "math/vec.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct sky_texel {
    float rgb[3], luminance;
} sky_texel;

enum {
    SKY_BLOCK_ROWS = 16,
    SKY_BLOCK_COLUMNS = 32,
    SKY_VIEW_SIDE = 16,
    SKY_VIEWS = SKY_VIEW_SIDE * SKY_VIEW_SIDE
};

/* An equirectangular image whose first row is around +y, and whose centre lies towards -z of its axes. Sums
 * are of all up to and with each. */
typedef struct sky_image {
    uint32_t width, height; /* of texels, less than 2^31 in all */
    vec3_f64 axes[3];       /* in the world: to the right and up in the image, and away from its centre */
    sky_texel *texels;      /* by row from the top; neither negative nor infinite */
    double power;           /* luminance times solid angle, over all directions */

    double *cosines; /* to the top, where rows of cells begin, and where the last one ends */
    /* Parts of a cell's width and height: so near to its edge a direction in float could lie in the next,
     * which may be in another block, of another density. */
    double margin[2];

    uint32_t rows, columns;                                                      /* of blocks */
    uint32_t row_first[SKY_BLOCK_ROWS + 1], column_first[SKY_BLOCK_COLUMNS + 1]; /* cells of the blocks */
    uint8_t *row_block, *column_block; /* of each row and column of cells */
    double *cells;                     /* mean luminance, along a row of cells of a block; by cell */
    double *lines; /* luminance times solid angle, over the rows of cells of a block; height + 1 to each
                      column of blocks */
    double *views; /* weights of the rows of blocks, then of the blocks along each, in each view; the last is
                      of no normal */
    float *scales; /* of the blocks in each view: the density of a place over its luminance */
} sky_image;

static inline uint32_t sky_view_size(const sky_image *s) { return s->rows * (1 + s->columns); }

/* width, height, axes and texels without their luminance are set, and become the sky's. False without memory.
 * Release with sky_close(). */
bool sky_open(sky_image *s);
void sky_close(sky_image *s);

/* The direction of the place (u, v) in [0,1]² of the image, in its axes. */
vec3_f64 sky_direction(double u, double v);

/* Radiance a lane, and the density per solid angle with which it is asked for. */
typedef struct sky_light {
    lanes3 radiance;
    double density[LANES];
} sky_light;

/* Both answer surfaces with the normals n, unit or 0: from all directions alike. lanes: bits; the answers to
 * others are left. */
typedef struct sky_kernels {
    /* From unit directions. */
    void (*at)(const sky_image *s, unsigned lanes, const lanes3_f64 n, const lanes3_f64 direction,
               sky_light *out);
    /* From directions that u chooses along the image's rows and v among them, both in [0,1). Where no light
     * comes from the side of n, radiance and density are 0. */
    void (*sample)(const sky_image *s, unsigned lanes, const lanes3_f64 n, const double u[LANES],
                   const double v[LANES], lanes3_f64 direction, sky_light *out);
} sky_kernels;

const sky_kernels *sky_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const sky_kernels *sky_kernels_at(unsigned index);

#endif
