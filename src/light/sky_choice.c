#include "light/sky_choice.h"

#include "light/shape.h"
#include "math/lane.h"

#include <stdlib.h>
#include <string.h>

/* A cell is found by inversion: the row of blocks, the block, the row of cells in it, the cell. Unlike an
 * alias table that keeps samples that are even over the square even over the light.
 *
 * The choice of a block depends on the surface's normal. Normals fall into cells of an octahedron, each of
 * which has a table of the blocks: a product of light and cosine as coarse as that needs no table of all
 * pairs of normals and cells, and leaves out the half of the sky behind the surface. */
enum { BLOCK_ROWS = 16, BLOCK_COLUMNS = 32, SIDE = 16, VIEWS = SIDE * SIDE };

/* Sums are of all up to and with each. */
struct sky_choice {
    uint32_t width, height, rows, columns; /* of cells, of blocks */
    double power;
    double *cells; /* mean luminance, along a row of cells of a block; by cell */
    double *lines; /* luminance times solid angle, over the rows of cells of a block; height to each column of
                      blocks */
    float *scales; /* of the blocks in each view: the density of a place over its luminance */
    double *views; /* weights of the rows of blocks, then of the blocks along each, in each view; the last is
                      of n = 0 */
    uint32_t row_first[BLOCK_ROWS + 1], column_first[BLOCK_COLUMNS + 1]; /* cells of the blocks */
};

/* Light of a block, as seen from a point. */
typedef struct sky_block {
    double power;
    vec3_f64 sum;    /* of directions times power */
    vec3_f64 centre; /* unit */
    double radius;   /* angle around the centre that holds the block, at least */
} sky_block;

typedef struct sky_view {
    vec3_f64 normal; /* the middle of the cell */
    double radius;   /* angle around it that holds the cell */
} sky_view;

double sky_luminance(const float rgb[3]) {
    return 0.2126 * (double)rgb[0] + 0.7152 * (double)rgb[1] + 0.0722 * (double)rgb[2];
}

vec3_f64 sky_direction(double u, double v) {
    double c, s;
    shape_turn(u, &c, &s);
    return (vec3_f64){sin(SHAPE_PI * v) * s, cos(SHAPE_PI * v), -sin(SHAPE_PI * v) * c};
}

/* ---- blocks ---- */

static uint32_t min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }

/* Cell x lies in block x * blocks / cells, rounded down. */
static uint32_t block_of(uint32_t x, uint32_t cells, uint32_t blocks) {
    return (uint32_t)((uint64_t)x * blocks / cells);
}
static void find_firsts(uint32_t cells, uint32_t blocks, uint32_t *first) {
    for (uint32_t i = 0; i <= blocks; ++i) first[i] = (uint32_t)(((uint64_t)i * cells + blocks - 1) / blocks);
}

double sky_row_angle(uint32_t row, uint32_t height) {
    return row == 0 ? 0 : (row > height ? SHAPE_PI : SHAPE_PI * (row - 0.5) / height);
}

/* Of a row of cells: half as high at the poles. */
typedef struct sky_row {
    double angle; /* to +y, of its middle */
    double solid; /* angle of a cell: cos a - cos b = 2 sin((a+b)/2) sin((b-a)/2) */
} sky_row;

static sky_row row_at(const sky_choice *c, uint32_t row) {
    const double top = sky_row_angle(row, c->height - 1), bottom = sky_row_angle(row + 1, c->height - 1),
                 middle = (top + bottom) / 2;
    return (sky_row){middle, 2 * SHAPE_PI / c->width * 2 * sin(middle) * sin((bottom - top) / 2)};
}

/* Horizontal directions of the middles of the columns of cells, so that no cell needs sines of its own. */
typedef struct sky_turn {
    double cosine, sine;
} sky_turn;

/* Luminances of the row of texels above the cells, and below. */
typedef struct sky_lights {
    double *above, *below;
} sky_lights;

/* The mean of a bilinear function is that of its corners. */
static void sum_block(sky_choice *c, const sky_lights *lights, const sky_turn *turns, uint32_t y,
                      uint32_t column, sky_block *out) {
    const sky_row row = row_at(c, y);
    double line = 0, ahead = 0, right = 0;
    for (uint32_t x = c->column_first[column]; x < c->column_first[column + 1]; ++x) {
        const uint32_t next = x + 1 < c->width ? x + 1 : 0;
        const double light =
            (lights->above[x] + lights->above[next] + lights->below[x] + lights->below[next]) / 4;
        c->cells[(size_t)y * c->width + x] = line += light;
        right += light * turns[x].sine, ahead += light * turns[x].cosine;
    }
    const double s = sin(row.angle);
    out->sum = madd_f64(out->sum, row.solid, (vec3_f64){right * s, line * cos(row.angle), -ahead * s});
    c->lines[(size_t)column * c->height + y] = out->power += line * row.solid;
}

static sky_block new_block(const sky_choice *c, uint32_t row, uint32_t column) {
    const double top = sky_row_angle(c->row_first[row], c->height - 1) / SHAPE_PI,
                 bottom = sky_row_angle(c->row_first[row + 1], c->height - 1) / SHAPE_PI,
                 wide = (double)(c->column_first[column + 1] - c->column_first[column]) / c->width,
                 middle = (c->column_first[column] + 0.5) / c->width + wide / 2;
    return (sky_block){.radius = SHAPE_PI * hypot(wide, (bottom - top) / 2),
                       .centre = sky_direction(middle < 1 ? middle : middle - 1, (top + bottom) / 2)};
}

static void find_lights(const sky_choice *c, const sky_texel *texels, uint32_t row, double *out) {
    for (uint32_t x = 0; x < c->width; ++x) out[x] = (double)texels[(size_t)row * c->width + x].luminance;
}

/* Row by row from the top, so that each texel is looked at once. */
static void sum_blocks(sky_choice *c, const sky_texel *texels, sky_lights lights, const sky_turn *turns,
                       sky_block *blocks) {
    for (uint32_t i = 0; i < c->rows * c->columns; ++i)
        blocks[i] = new_block(c, i / c->columns, i % c->columns);
    find_lights(c, texels, 0, lights.below);
    for (uint32_t y = 0; y < c->height; ++y) {
        double *const above = lights.below;
        lights.below = lights.above, lights.above = above;
        /* Both rows of texels are one at the poles. */
        if (y == 0 || y + 1 == c->height)
            memcpy(lights.below, lights.above, c->width * sizeof *lights.below);
        else
            find_lights(c, texels, y, lights.below);
        sky_block *row = blocks + (size_t)block_of(y, c->height, c->rows) * c->columns;
        for (uint32_t column = 0; column < c->columns; ++column)
            sum_block(c, &lights, turns, y, column, &row[column]);
    }
    for (uint32_t i = 0; i < c->rows * c->columns; ++i) c->power += blocks[i].power;
}

/* ---- views ---- */

/* The octahedron's faces, unfolded to [-1,1]². */
static vec3_f64 unfold(double a, double b) {
    const double z = 1 - fabs(a) - fabs(b);
    if (z >= 0) return normalize_f64((vec3_f64){a, b, z});
    return normalize_f64((vec3_f64){copysign(1 - fabs(b), a), copysign(1 - fabs(a), b), z});
}

static uint32_t cell_of(double a) {
    const double at = (a + 1) * (SIDE / 2);
    return at < SIDE - 1 ? (uint32_t)at : SIDE - 1;
}

static uint32_t view_of(vec3_f64 n) {
    const double size = fabs(n.x) + fabs(n.y) + fabs(n.z);
    if (!(size > 0)) return VIEWS;
    double a = n.x / size, b = n.y / size;
    if (n.z < 0) {
        const double folded = copysign(1 - fabs(b), a);
        b = copysign(1 - fabs(a), b), a = folded;
    }
    return cell_of(b) * SIDE + cell_of(a);
}

/* A cell lies in one face of the octahedron, or two of them meet along its diagonal; either way its farthest
 * points are corners. A thousandth stands for roundings. */
static sky_view view_at(uint32_t index) {
    const double step = 2.0 / SIDE, a = index % SIDE * step - 1, b = index / SIDE * step - 1;
    sky_view view = {unfold(a + step / 2, b + step / 2), 0};
    for (int i = 0; i < 4; ++i) {
        const double cosine = dot_f64(view.normal, unfold(a + (i & 1) * step, b + (i >> 1) * step));
        view.radius = fmax(view.radius, acos(fmin(cosine, 1)) + 1e-3);
    }
    return view;
}

/* The mean of the cosine above 0 where it varies by `spread` either way, as it does over a block and a cell.
 * A block that some normal of the cell faces is never left out. */
static double weight(const sky_block *block, const sky_view *view) {
    static const double spread = 0.25, least = 1.0 / 64;
    if (!(block->power > 0)) return 0;
    const double most = block->radius + view->radius, mean = dot_f64(view->normal, block->sum) / block->power;
    if (most < SHAPE_PI / 2 && dot_f64(view->normal, block->centre) < -sin(most)) return 0;
    const double cosine = mean > spread ? mean : pow(fmax(mean + spread, 0), 2) / (4 * spread);
    return block->power * fmax(cosine, least);
}

static size_t view_size(const sky_choice *c) { return (size_t)c->rows * (1 + c->columns); }

static void sum_view(sky_choice *c, const sky_block *blocks, uint32_t index) {
    const uint32_t count = c->rows * c->columns;
    double *rows = c->views + index * view_size(c), *columns = rows + c->rows, all = 0;
    float *scales = c->scales + (size_t)index * count;
    const sky_view view = view_at(index % VIEWS);
    for (uint32_t row = 0; row < c->rows; ++row) {
        double sum = 0;
        for (uint32_t i = row * c->columns; i < (row + 1) * c->columns; ++i)
            columns[i] = sum += index == VIEWS ? blocks[i].power : weight(&blocks[i], &view);
        rows[row] = all += sum;
    }
    for (uint32_t i = 0; i < count; ++i) {
        const double before = i % c->columns ? columns[i - 1] : 0, light = blocks[i].power * all;
        scales[i] = light > 0 ? (float)((columns[i] - before) / light) : 0;
    }
}

/* ---- making ---- */

static bool fill(sky_choice *c, const sky_texel *texels) {
    const uint32_t count = c->rows * c->columns;
    sky_block *blocks = malloc(count * sizeof *blocks);
    sky_turn *turns = malloc(c->width * sizeof *turns);
    const sky_lights lights = {malloc(c->width * sizeof(double)), malloc(c->width * sizeof(double))};
    c->cells = malloc((size_t)c->width * c->height * sizeof *c->cells);
    c->lines = malloc((size_t)c->columns * c->height * sizeof *c->lines);
    c->views = malloc((VIEWS + 1) * view_size(c) * sizeof *c->views);
    c->scales = malloc((VIEWS + 1) * (size_t)count * sizeof *c->scales);
    const bool there =
        blocks && turns && lights.above && lights.below && c->cells && c->lines && c->views && c->scales;
    for (uint32_t x = 0; there && x < c->width; ++x)
        shape_turn((x + 1.0) / c->width, &turns[x].cosine, &turns[x].sine);
    if (there) sum_blocks(c, texels, lights, turns, blocks);
    for (uint32_t i = 0; there && i <= VIEWS; ++i) sum_view(c, blocks, i);
    free(lights.above);
    free(lights.below);
    free(turns);
    free(blocks);
    return there;
}

sky_choice *sky_choice_create(uint32_t width, uint32_t height, const sky_texel *texels) {
    sky_choice *c = calloc(1, sizeof *c);
    if (!c) return NULL;
    c->width = width, c->height = height + 1;
    c->rows = min_u32(c->height, BLOCK_ROWS), c->columns = min_u32(width, BLOCK_COLUMNS);
    find_firsts(c->height, c->rows, c->row_first);
    find_firsts(width, c->columns, c->column_first);
    if (fill(c, texels)) return c;
    sky_choice_destroy(c);
    return NULL;
}

void sky_choice_destroy(sky_choice *c) {
    if (!c) return;
    free(c->cells);
    free(c->lines);
    free(c->views);
    free(c->scales);
    free(c);
}

double sky_choice_power(const sky_choice *c) { return c->power; }

/* ---- choosing ---- */

/* The first of the sums that exceeds the share u of the last one, which is not 0; u comes to be how far that
 * share reaches into it. A weight of 0 is never taken. */
static uint32_t choose(const double *sums, uint32_t count, double *u) {
    const double all = sums[count - 1], at = fmin(*u * all, nextafter(all, 0));
    uint32_t first = 0;
    for (uint32_t left = count; left > 1;) {
        const uint32_t half = left / 2;
        first +=
            half & -(uint32_t)(sums[first + half - 1] <= at); /* no branch: half would be guessed wrong */
        left -= half;
    }
    const double before = first ? sums[first - 1] : 0;
    *u = (at - before) / (sums[first] - before);
    return first;
}

/* Each step reads what the one before has asked for in all lanes: the tables are larger than caches. */
unsigned sky_choice_take(const sky_choice *c, unsigned lanes, const lanes3_f64 n, double u[LANES],
                         double v[LANES], sky_cells *out) {
    unsigned taken = 0;
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const double *rows = c->views + view_of(lane_f64(n, i)) * view_size(c);
        if (!(rows[c->rows - 1] > 0)) continue;
        const uint32_t row = choose(rows, c->rows, &v[i]);
        out->row[i] = row;
        out->column[i] = choose(rows + c->rows + (size_t)row * c->columns, c->columns, &u[i]);
        __builtin_prefetch(c->lines + (size_t)out->column[i] * c->height + c->row_first[row]);
        taken |= 1u << i;
    }
    for (unsigned left = taken; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const uint32_t first = c->row_first[out->row[i]], end = c->row_first[out->row[i] + 1];
        out->row[i] =
            first + choose(c->lines + (size_t)out->column[i] * c->height + first, end - first, &v[i]);
        __builtin_prefetch(c->cells + (size_t)out->row[i] * c->width + c->column_first[out->column[i]]);
    }
    for (unsigned left = taken; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const uint32_t first = c->column_first[out->column[i]], end = c->column_first[out->column[i] + 1];
        out->column[i] =
            first + choose(c->cells + (size_t)out->row[i] * c->width + first, end - first, &u[i]);
    }
    return taken;
}

void sky_choice_densities(const sky_choice *c, unsigned lanes, const lanes3_f64 n, const sky_cells *cells,
                          double density[LANES]) {
    for (; lanes; lanes &= lanes - 1) {
        const unsigned i = lane_first(lanes);
        const uint32_t row = block_of(cells->row[i], c->height, c->rows),
                       column = block_of(cells->column[i], c->width, c->columns);
        density[i] =
            (double)c->scales[((size_t)view_of(lane_f64(n, i)) * c->rows + row) * c->columns + column];
    }
}
