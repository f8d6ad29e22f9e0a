/* Images of skies: their light, and sampling of it for surfaces.
 *
 * Between the centres of four texels, radiance is bilinear in the azimuth and in the cosine to the pole: in
 * these coordinates, solid angle is uniform over the cell that the texels bound. Cell (x, y) has the texels x
 * and x + 1, which wraps around, of the rows y - 1 and y. There is one more row of cells than of texels: the
 * first and the last row reach from a pole to the centres of the nearest texels, and use that row of texels
 * twice.
 *
 * A direction is sampled in proportion to its light times roughly the cosine to the surface's normal. A cell
 * is found by inverting sums: the row of blocks, the block, the row of cells in it, the cell. Unlike an alias
 * table, this keeps samples that are well distributed over the square well distributed over the light.
 *
 * The choice of a block depends on the surface's normal. Normals fall into cells around the points of a grid
 * on an octahedron. The axes are among these points, because floors and walls are frequent. Each cell has a
 * table of the blocks. A product of light and cosine at this resolution needs no table of all pairs of
 * normals and cells, and excludes the half of the sky behind the surface.
 *
 * Scattered rays find the sky, too, and the balance heuristic weighs both kinds of samples. The variance of
 * their sum is least if their densities add up to twice the product of light and cosine (MIS compensation,
 * Karlik et al. 2019). A diffuse surface scatters rays by the cosine. So light samples prefer blocks that are
 * brighter than the mean, and leave most of the others to scattered rays.
 *
 * In a room, most of the sky is hidden. The rays of a few paths show which parts the surfaces see.
 * Surfaces with normals in one cell are divided by position into regions, each with its own table:
 * sky_learn(). */
#pragma once

#include "light/regions.h"
#include "math/lanes.h"
#include "math/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct sky_texel {
    float rgb[3], luminance;
} sky_texel;

enum {
    SKY_BLOCK_ROWS = 16,
    SKY_BLOCK_COLUMNS = 32,
    SKY_BLOCKS = SKY_BLOCK_ROWS * SKY_BLOCK_COLUMNS,
    SKY_VIEW_SIDE = 17, /* odd: the axes are at the middles of cells */
    SKY_VIEWS = SKY_VIEW_SIDE * SKY_VIEW_SIDE
};

/* Directions of a block, with weights: power: the sum of the weights; sum: of directions times weights. */
typedef struct sky_amount {
    double power;
    vec3_f64 sum;
} sky_amount;

/* A block of cells. */
typedef struct sky_block {
    sky_amount light, even; /* weights: luminance times solid angle, and solid angle */
    vec3_f64 centre;        /* unit */
    double radius;          /* upper bound of the angle around the centre that contains the block */
} sky_block;

/* An equirectangular image whose first row is around +y, and whose centre lies towards -z of its axes. Sums
 * are inclusive prefix sums as fractions of the last one, which is 1, or 0 if there is no light. As floats
 * they are as fine as the numbers that choose by them, and take half of the caches. */
typedef struct sky_image {
    uint32_t width, height; /* in texels, less than 2^31 texels in all */
    vec3_f64 axes[3];       /* in world space: to the right and up in the image, and away from its centre */
    sky_texel *texels;      /* by row from the top; neither negative nor infinite */
    double power;           /* luminance times solid angle, over all directions */

    double *cosines; /* cosines to +y at the beginning of each row of cells, and at the end of the last one */
    /* Fractions of a cell's width and height: a direction this near to the cell's edge could fall into the
     * next cell when rounded to float, which may be in another block, with another density. */
    double margin[2];

    uint32_t rows, columns;                                                      /* of blocks */
    uint32_t row_first[SKY_BLOCK_ROWS + 1], column_first[SKY_BLOCK_COLUMNS + 1]; /* cells of the blocks */
    uint8_t *row_block, *column_block; /* of each row and column of cells */
    float *cells;                      /* sums of mean luminance, along a row of cells of a block; by cell */
    float *lines; /* sums of luminance times solid angle, over the rows of cells of a block; height + 1 for
                     each column of blocks */
    sky_block *blocks;
    float *views;    /* tables: sums of weights of the rows of blocks, then of the blocks along each row; for
                        each view, of which the last one is without a normal, then for each region */
    float *scales;   /* of the blocks in each table: density of a direction divided by its luminance */
    uint32_t *roots; /* by view: as region_split.below; leaves are tables; NULL: there are no regions */
    region_split *splits;
} sky_image;

static inline uint32_t sky_view_size(const sky_image *s) { return s->rows * (1 + s->columns); }

/* The caller sets width, height, axes and the texels except their luminance; the sky takes ownership. False:
 * out of memory. Release with sky_close(). */
bool sky_open(sky_image *s);
void sky_close(sky_image *s);

/* A ray from a surface to the sky. */
typedef struct sky_ray {
    vec3_f32 p, n, direction; /* from p; n and direction: unit, or n is 0 */
    float seen;               /* fraction of its light that arrives at p, in [0, 1] */
} sky_ray;

/* sky_open() and sky_learn() make tables of these. view: of the surfaces, or SKY_VIEWS. parts: by block, with
 * the sum 1, or 0 if there is no light: the fractions of light times cosine that surfaces get from the
 * blocks. */
void sky_parts(const sky_image *s, uint32_t view, double parts[SKY_BLOCKS]);
/* Turns fractions of the light into probabilities of light samples, which avoid what scattered rays find. */
void sky_avoid(const sky_image *s, uint32_t view, double parts[SKY_BLOCKS]);
/* Makes a table from probabilities. */
void sky_table(sky_image *s, const double parts[SKY_BLOCKS], uint32_t index);

/* Call at most once. False: out of memory; the sky remains usable. */
bool sky_learn(sky_image *s, const sky_ray *rays, size_t count);

/* The direction of the image position (u, v) in [0,1]², in the image's axes. */
vec3_f64 sky_direction(double u, double v);

/* Radiance per lane, and the density per solid angle with which its direction is sampled. */
typedef struct sky_light {
    lanes3 radiance;
    double density[LANES];
} sky_light;

/* For surfaces at p with the normals n, unit or 0 (no preferred side). lanes: bits; results of other lanes
 * are not written. */
typedef struct sky_kernels {
    /* Evaluates unit directions. */
    void (*at)(const sky_image *s, unsigned lanes, const lanes3 p, const lanes3_f64 n,
               const lanes3_f64 direction, sky_light *out);
    /* Samples directions; u chooses along the image's rows and v between rows, both in [0,1). If no light
     * comes from the side of n, radiance and density are 0. */
    void (*sample)(const sky_image *s, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                   const float u[LANES], const float v[LANES], lanes3_f64 direction, sky_light *out);
    /* The views of the normals, and the blocks of unit directions; of all lanes. */
    void (*find)(const sky_image *s, const lanes3_f64 n, const lanes3_f64 direction, uint32_t view[LANES],
                 uint32_t block[LANES]);
} sky_kernels;

const sky_kernels *sky_kernels_best(void);
