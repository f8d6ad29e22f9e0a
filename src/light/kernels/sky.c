/* Images of skies, evaluated and sampled for sixteen surfaces. */
#include "light/sky.h"
#include "base/kernel.h"
#include "light/shape.h"
#include "math/lane.h"

#include <math.h>

typedef struct sky_cells {
    uint32_t column[LANES], row[LANES];
} sky_cells;

typedef struct sky_places {
    sky_cells cells;
    double u[LANES], v[LANES]; /* [0,1], position between this and the next column and row of texels */
} sky_places;

/* ---- into the image's axes, and from there ---- */

/* Lanes without a query get the direction z. */
static void turn(const sky_image *s, unsigned lanes, const lanes3_f64 from, double (*restrict to)[LANES]) {
    const vec3_f64 a = s->axes[0], b = s->axes[1], c = s->axes[2];
    lanes3_f64 v;
    for (unsigned i = 0; i < LANES; ++i) put_lane_f64(v, i, (vec3_f64){0, 0, 1});
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        put_lane_f64(v, i, lane_f64(from, i));
    }
    for (unsigned i = 0; i < LANES; ++i) {
        to[0][i] = v[0][i] * a.x + v[1][i] * a.y + v[2][i] * a.z;
        to[1][i] = v[0][i] * b.x + v[1][i] * b.y + v[2][i] * b.z;
        to[2][i] = v[0][i] * c.x + v[1][i] * c.y + v[2][i] * c.z;
    }
}

/* ---- views ---- */

SHAPE_INLINE double least(double a, double b) { return a < b ? a : b; }
SHAPE_INLINE double most(double a, double b) { return a > b ? a : b; }

/* The inverse of unfold() in sky.c. */
static void find_views(const lanes3_f64 n, uint32_t *restrict view) {
    int none = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        const double x = n[0][i], y = n[1][i], z = n[2][i], size = fabs(x) + fabs(y) + fabs(z);
        const double inverse = 1 / (size + 0x1p-1000), a = x * inverse, b = y * inverse,
                     c = copysign(1 - fabs(b), a), d = copysign(1 - fabs(a), b);
        const double across = ((z < 0 ? c : a) + 1) * (SKY_VIEW_SIDE / 2) + 0.5,
                     along = ((z < 0 ? d : b) + 1) * (SKY_VIEW_SIDE / 2) + 0.5;
        view[i] = (uint32_t)((int32_t)least(along, SKY_VIEW_SIDE - 1) * SKY_VIEW_SIDE +
                             (int32_t)least(across, SKY_VIEW_SIDE - 1));
        none |= !(size > 0);
    }
    for (unsigned i = 0; none && i < LANES; ++i)
        if (!(fabs(n[0][i]) + fabs(n[1][i]) + fabs(n[2][i]) > 0)) view[i] = SKY_VIEWS;
}

/* The tables of regions replace those of views. */
static void find_tables(const sky_image *s, unsigned lanes, const lanes3 p, uint32_t *view) {
    for (; s->roots && lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        view[i] = region_find(s->splits, s->roots[view[i]], &p[0][i], LANES);
    }
}

/* ---- image positions of directions ---- */

static void find_places(const sky_image *s, const lanes3_f64 d, sky_places *restrict out) {
    const double width = s->width, height = s->height;
    double down[LANES];
    for (unsigned i = 0; i < LANES; ++i) {
        const double x = d[0][i], y = d[1][i], z = d[2][i],
                     half = shape_angle(fabs(x), -z) * (0.5 / SHAPE_PI), u = x < 0 ? 0.5 - half : 0.5 + half,
                     before = u * width - 0.5, across = before < 0 ? before + width : before;
        const int32_t column = (int32_t)least(across, width - 1);
        out->cells.column[i] = (uint32_t)column;
        out->u[i] = least(across - column, 1);
        down[i] = shape_angle(sqrt(x * x + z * z), y) * (height / SHAPE_PI) + 0.5;
    }
    for (unsigned i = 0; i < LANES; ++i) {
        const int32_t row = (int32_t)least(down[i], height);
        const double top = s->cosines[row], bottom = s->cosines[row + 1];
        out->cells.row[i] = (uint32_t)row;
        out->v[i] = least(most((top - d[1][i]) / (top - bottom), 0), 1);
    }
}

/* ---- light of image positions ---- */

/* The texels at a cell's corners: the upper row, then the lower one. */
typedef struct sky_corners {
    const sky_texel *at[2][2];
} sky_corners;

static inline sky_corners corners_of(const sky_image *s, const sky_cells *cells, unsigned i) {
    const uint32_t column = cells->column[i], row = cells->row[i],
                   next = column + 1 < s->width ? column + 1 : 0;
    const sky_texel *above = s->texels + (size_t)(row ? row - 1 : 0) * s->width,
                    *below = s->texels + (size_t)(row < s->height ? row : row - 1) * s->width;
    return (sky_corners){{{above + column, above + next}, {below + column, below + next}}};
}

static void prefetch(const sky_image *s, const sky_cells *cells, unsigned lanes) {
    for (; lanes; lanes &= lanes - 1) {
        const sky_corners corners = corners_of(s, cells, lane_first(lanes));
        __builtin_prefetch(corners.at[0][0]);
        __builtin_prefetch(corners.at[1][0]);
    }
}

/* A texel. gcc does not vectorise a loop of four. */
typedef float texel_f32 __attribute__((vector_size(16)));

static inline texel_f32 load(const sky_texel *t) {
    texel_f32 out;
    memcpy(&out, t, sizeof out);
    return out;
}

/* Red, green, blue and luminance. */
static inline texel_f32 blend(const sky_corners *from, float u, float v) {
    const texel_f32 a = load(from->at[0][0]), b = load(from->at[0][1]), c = load(from->at[1][0]),
                    d = load(from->at[1][1]);
    const texel_f32 above = a + u * (b - a), below = c + u * (d - c);
    return above + v * (below - above);
}

static void look_up(const sky_image *s, unsigned lanes, const uint32_t table[LANES], const sky_places *places,
                    sky_light *out) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const sky_corners corners = corners_of(s, &places->cells, i);
        const texel_f32 light = blend(&corners, (float)places->u[i], (float)places->v[i]);
        const uint32_t row = s->row_block[places->cells.row[i]],
                       column = s->column_block[places->cells.column[i]];
        const float scale = s->scales[((size_t)table[i] * s->rows + row) * s->columns + column];
        for (int c = 0; c < 3; ++c) out->radiance[c][i] = light[c];
        out->density[i] = (double)scale * (double)light[3];
    }
}

static void at(const sky_image *s, unsigned lanes, const lanes3 p, const lanes3_f64 n,
               const lanes3_f64 direction, sky_light *out) {
    lanes3_f64 turned;
    sky_places places;
    uint32_t view[LANES];
    turn(s, lanes, direction, turned);
    find_places(s, turned, &places);
    prefetch(s, &places.cells, lanes);
    turn(s, lanes, n, turned);
    find_views(turned, view);
    find_tables(s, lanes, p, view);
    look_up(s, lanes, view, &places, out);
}

static void find(const sky_image *s, const lanes3_f64 n, const lanes3_f64 direction, uint32_t view[LANES],
                 uint32_t block[LANES]) {
    lanes3_f64 turned;
    sky_places places;
    turn(s, (1u << LANES) - 1, direction, turned);
    find_places(s, turned, &places);
    turn(s, (1u << LANES) - 1, n, turned);
    find_views(turned, view);
    for (unsigned i = 0; i < LANES; ++i)
        block[i] = s->row_block[places.cells.row[i]] * s->columns + s->column_block[places.cells.column[i]];
}

/* ---- cells by light ---- */

/* The first of the sums, whose last one is 1, that exceeds u; u becomes the position of that value within the
 * chosen interval. A weight of 0 is never chosen. Counting is faster than bisection: no step depends on
 * another, and the comparison vectorises. */
static inline uint32_t choose(const float *sums, uint32_t count, float *u) {
    const float at = *u < 1 ? *u : 1 - 0x1p-24f; /* rounding of the position may have led to 1 */
    uint32_t passed = 0;
    for (uint32_t i = 0; i + 1 < count; ++i) passed += sums[i] <= at;
    const float before = passed ? sums[passed - 1] : 0;
    *u = (at - before) / (sums[passed] - before);
    return passed;
}

static inline void prefetch_sums(const float *sums, uint32_t count) {
    for (uint32_t i = 0; i < count; i += 16) __builtin_prefetch(sums + i);
    __builtin_prefetch(sums + count - 1);
}

/* Each step reads what the step before prefetched for all lanes: the tables are larger than caches. Returns
 * the lanes that have a cell: the others face no light. */
static unsigned choose_cells(const sky_image *s, unsigned lanes, const uint32_t table[LANES], float u[LANES],
                             float v[LANES], sky_cells *out) {
    const size_t rows = (size_t)s->height + 1;
    unsigned taken = 0;
    uint32_t row[LANES], column[LANES];
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const float *sums = s->views + (size_t)table[i] * sky_view_size(s);
        if (!(sums[s->rows - 1] > 0)) continue;
        row[i] = choose(sums, s->rows, &v[i]);
        column[i] = choose(sums + s->rows + (size_t)row[i] * s->columns, s->columns, &u[i]);
        const uint32_t first = s->row_first[row[i]];
        prefetch_sums(s->lines + column[i] * rows + first, s->row_first[row[i] + 1] - first);
        taken |= 1u << i;
    }
    for (unsigned left = taken; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const uint32_t first = s->row_first[row[i]], end = s->row_first[row[i] + 1];
        out->row[i] = first + choose(s->lines + column[i] * rows + first, end - first, &v[i]);
        const uint32_t start = s->column_first[column[i]];
        prefetch_sums(s->cells + (size_t)out->row[i] * s->width + start,
                      s->column_first[column[i] + 1] - start);
    }
    for (unsigned left = taken; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const uint32_t first = s->column_first[column[i]], end = s->column_first[column[i] + 1];
        const float *cells = s->cells + (size_t)out->row[i] * s->width + first;
        out->column[i] = first + choose(cells, end - first, &u[i]);
    }
    return taken;
}

/* ---- positions in cells ---- */

/* Maps u in [0,1) to a position in [0,1] whose density is linear, from a to b. */
SHAPE_INLINE double along_slope(double u, double a, double b) {
    const double root = a + sqrt(a * a + u * (b * b - a * a));
    return least(u * (a + b) / (root + 0x1p-1000), 1);
}

SHAPE_INLINE double between(double u, double a, double b) { return a + u * (b - a); }

SHAPE_INLINE double inside(double u, double margin) { return margin + (1 - 2 * margin) * u; }

/* Chooses positions in proportion to luminance, then their directions. Other lanes are computed from
 * arbitrary cells. */
static void choose_places(const sky_image *s, unsigned lanes, const float across[LANES],
                          const float down[LANES], sky_places *restrict p,
                          double (*restrict direction)[LANES]) {
    double light[4][LANES] = {{0}}, ends[2][LANES] = {{0}}, column[LANES] = {0};
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const sky_corners corners = corners_of(s, &p->cells, i);
        for (int k = 0; k < 4; ++k) light[k][i] = (double)corners.at[k >> 1][k & 1]->luminance;
        for (int k = 0; k < 2; ++k) ends[k][i] = s->cosines[p->cells.row[i] + (uint32_t)k];
        column[i] = p->cells.column[i];
    }
    const vec3_f64 a = s->axes[0], b = s->axes[1], c = s->axes[2];
    const double part = 1 / (double)s->width;
    for (unsigned i = 0; i < LANES; ++i) {
        const double v = along_slope((double)down[i], light[0][i] + light[1][i], light[2][i] + light[3][i]);
        const double u = along_slope((double)across[i], between(v, light[0][i], light[2][i]),
                                     between(v, light[1][i], light[3][i]));
        p->u[i] = u, p->v[i] = v;
        const double turn = (column[i] + 0.5 + inside(u, s->margin[0])) * part,
                     folded = turn < 1 ? turn : turn - 1,
                     y = between(inside(v, s->margin[1]), ends[0][i], ends[1][i]),
                     round = sqrt(most(1 - y * y, 0));
        double cosine, sine;
        shape_turn(folded, &cosine, &sine);
        const double x = round * sine, z = -round * cosine;
        direction[0][i] = x * a.x + y * b.x + z * c.x;
        direction[1][i] = x * a.y + y * b.y + z * c.y;
        direction[2][i] = x * a.z + y * b.z + z * c.z;
    }
}

static void no_light(unsigned lanes, sky_light *out) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        for (int c = 0; c < 3; ++c) out->radiance[c][i] = 0;
        out->density[i] = 0;
    }
}

static void sample(const sky_image *s, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                   const float u[LANES], const float v[LANES], lanes3_f64 direction, sky_light *out) {
    lanes3_f64 turned, found;
    sky_places places = {.cells = {{0}}}; /* gcc 14 does not see that only chosen lanes are read */
    uint32_t view[LANES];
    float across[LANES], down[LANES];
    memcpy(across, u, sizeof across), memcpy(down, v, sizeof down);
    turn(s, lanes, n, turned);
    find_views(turned, view);
    find_tables(s, lanes, p, view);
    const unsigned taken = choose_cells(s, lanes, view, across, down, &places.cells);
    prefetch(s, &places.cells, taken);
    choose_places(s, taken, across, down, &places, found);
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        put_lane_f64(direction, i, lane_f64(found, i));
    }
    no_light(lanes & ~taken, out);
    look_up(s, taken, view, &places, out);
}

const sky_kernels KERNEL(sky_kernels) = {.at = at, .sample = sample, .find = find};
