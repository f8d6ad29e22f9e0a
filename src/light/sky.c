/* Builds the sampling tables of sky images. */
#include "light/sky.h"

#include "base/kernel.h"
#include "light/shape.h"

#include <math.h>
#include <stdlib.h>

KERNEL_BEST(sky_kernels)

enum { SIDE = SKY_VIEW_SIDE };

/* The part of the difference between light and cosine by which light samples avoid what scattered rays find,
 * and the least part of the light that a block keeps. Occluders hide parts, so the whole difference is too
 * much (bench/path_tracing.md). */
#define SKY_AVOID 0.5
#define SKY_KEEP (1.0 / 16)

typedef struct sky_view {
    vec3_f64 normal; /* the centre of the cell of normals */
    double radius;   /* angle around `normal` that contains the cell */
} sky_view;

vec3_f64 sky_direction(double u, double v) {
    double c, s;
    shape_turn(u, &c, &s);
    return (vec3_f64){sin(SHAPE_PI * v) * s, cos(SHAPE_PI * v), -sin(SHAPE_PI * v) * c};
}

/* ---- cells ---- */

static uint32_t min_u32(uint32_t a, uint32_t b) { return a < b ? a : b; }

static uint32_t cell_rows(const sky_image *s) { return s->height + 1; }

/* The angle to +y at which a row of cells begins and the row before it ends. */
static double row_angle(const sky_image *s, uint32_t row) {
    return row == 0 ? 0 : (row > s->height ? SHAPE_PI : SHAPE_PI * (row - 0.5) / s->height);
}

/* A row of cells; rows at the poles are half as high. */
typedef struct sky_row {
    double angle; /* to +y, of the row's middle */
    double solid; /* solid angle of a cell: cos a - cos b = 2 sin((a+b)/2) sin((b-a)/2) */
} sky_row;

static sky_row row_at(const sky_image *s, uint32_t row) {
    const double top = row_angle(s, row), bottom = row_angle(s, row + 1), middle = (top + bottom) / 2;
    return (sky_row){middle, 2 * SHAPE_PI / s->width * 2 * sin(middle) * sin((bottom - top) / 2)};
}

/* ---- blocks: cell x lies in block x * blocks / cells, rounded down ---- */

static void find_firsts(uint32_t cells, uint32_t blocks, uint32_t *first, uint8_t *block) {
    for (uint32_t i = 0; i <= blocks; ++i) first[i] = (uint32_t)(((uint64_t)i * cells + blocks - 1) / blocks);
    for (uint32_t x = 0; x < cells; ++x) block[x] = (uint8_t)((uint64_t)x * blocks / cells);
}

/* Horizontal directions of the centres of the columns of cells, computed once for all rows. */
typedef struct sky_turn {
    double cosine, sine;
} sky_turn;

/* Sums, as fractions of the last one. */
static void normalize_sums(const double *sums, uint32_t count, float *out) {
    const double all = sums[count - 1];
    for (uint32_t i = 0; i < count; ++i) out[i] = all > 0 ? (float)(sums[i] / all) : 0;
}

/* Memory for sums before they are normalised. */
typedef struct sky_sums {
    sky_turn *turns; /* by column of cells */
    double *cells;   /* of a row */
    double *lines;   /* as in sky_image */
} sky_sums;

static void add_light(sky_amount *to, double solid, double power, vec3_f64 sum) {
    to->power += power * solid, to->sum = madd_f64(to->sum, solid, sum);
}

/* The mean of a bilinear function is the mean of its corners. above, below: rows of texels. */
static void sum_block(sky_image *s, const sky_texel *above, const sky_texel *below, const sky_sums *sums,
                      uint32_t y, uint32_t column, sky_block *out) {
    const sky_row row = row_at(s, y);
    const uint32_t first = s->column_first[column], end = s->column_first[column + 1];
    double line = 0, ahead = 0, right = 0, even_ahead = 0, even_right = 0;
    for (uint32_t x = first; x < end; ++x) {
        const uint32_t next = x + 1 < s->width ? x + 1 : 0;
        const double light = ((double)above[x].luminance + (double)above[next].luminance +
                              (double)below[x].luminance + (double)below[next].luminance) /
                             4;
        sums->cells[x] = line += light;
        right += light * sums->turns[x].sine, ahead += light * sums->turns[x].cosine;
        even_right += sums->turns[x].sine, even_ahead += sums->turns[x].cosine;
    }
    normalize_sums(sums->cells + first, end - first, s->cells + (size_t)y * s->width + first);
    const double round = sin(row.angle), up = cos(row.angle), wide = end - first;
    add_light(&out->light, row.solid, line, (vec3_f64){right * round, line * up, -ahead * round});
    add_light(&out->even, row.solid, wide, (vec3_f64){even_right * round, wide * up, -even_ahead * round});
    sums->lines[(size_t)column * cell_rows(s) + y] = out->light.power;
}

static sky_block new_block(const sky_image *s, uint32_t row, uint32_t column) {
    const double top = row_angle(s, s->row_first[row]) / SHAPE_PI,
                 bottom = row_angle(s, s->row_first[row + 1]) / SHAPE_PI,
                 wide = (double)(s->column_first[column + 1] - s->column_first[column]) / s->width,
                 middle = (s->column_first[column] + 0.5) / s->width + wide / 2;
    return (sky_block){.radius = SHAPE_PI * hypot(wide, (bottom - top) / 2),
                       .centre = sky_direction(middle < 1 ? middle : middle - 1, (top + bottom) / 2)};
}

static void sum_blocks(sky_image *s, const sky_sums *sums) {
    const uint32_t count = s->rows * s->columns;
    for (uint32_t i = 0; i < count; ++i) s->blocks[i] = new_block(s, i / s->columns, i % s->columns);
    for (uint32_t y = 0; y < cell_rows(s); ++y) {
        const sky_texel *above = s->texels + (size_t)(y ? y - 1 : 0) * s->width,
                        *below = s->texels + (size_t)min_u32(y, s->height - 1) * s->width;
        for (uint32_t column = 0; column < s->columns; ++column)
            sum_block(s, above, below, sums, y, column, &s->blocks[s->row_block[y] * s->columns + column]);
    }
    s->power = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t row = i / s->columns, first = s->row_first[row];
        const size_t line = (size_t)(i % s->columns) * cell_rows(s) + first;
        normalize_sums(sums->lines + line, s->row_first[row + 1] - first, s->lines + line);
        s->power += s->blocks[i].light.power;
    }
}

/* ---- views ---- */

/* Maps a point of [-1,1]², the unfolded octahedron, to a unit normal. */
static vec3_f64 unfold(double a, double b) {
    const double z = 1 - fabs(a) - fabs(b);
    if (z >= 0) return normalize_f64((vec3_f64){a, b, z});
    return normalize_f64((vec3_f64){copysign(1 - fabs(b), a), copysign(1 - fabs(a), b), z});
}

/* A quarter of a cell lies in one face of the octahedron, or two faces share it along its diagonal; in both
 * cases its farthest points are corners. Cells at the rim of the square have parts beyond it, which no normal
 * reaches. 1e-3 covers rounding errors. */
static sky_view view_at(uint32_t index) {
    const double step = 2.0 / (SIDE - 1), a = index % SIDE * step - 1, b = index / SIDE * step - 1;
    sky_view view = {unfold(a, b), 0};
    for (int i = 0; i < 9; ++i) {
        const double x = a + (i % 3 - 1) * step / 2, y = b + (i / 3 - 1) * step / 2;
        if (fabs(x) > 1 || fabs(y) > 1) continue;
        const double cosine = dot_f64(view.normal, unfold(x, y));
        view.radius = fmax(view.radius, acos(fmin(cosine, 1)) + 1e-3);
    }
    return view;
}

/* The mean of the positive part of a cosine that varies by ±`spread`, as it does over a block and a cell. The
 * weight is never 0 for a block that some normal of the cell faces. */
static double weight(const sky_block *block, const sky_amount *of, const sky_view *view) {
    static const double spread = 0.25, least = 1.0 / 64;
    if (!(of->power > 0)) return 0;
    const double most = block->radius + view->radius, mean = dot_f64(view->normal, of->sum) / of->power;
    if (most < SHAPE_PI / 2 && dot_f64(view->normal, block->centre) < -sin(most)) return 0;
    const double cosine = mean > spread ? mean : pow(fmax(mean + spread, 0), 2) / (4 * spread);
    return of->power * fmax(cosine, least);
}

static void scale_to_one(const sky_image *s, double parts[SKY_BLOCKS]) {
    double sum = 0;
    for (uint32_t i = 0; i < s->rows * s->columns; ++i) sum += parts[i];
    for (uint32_t i = 0; sum > 0 && i < s->rows * s->columns; ++i) parts[i] /= sum;
}

void sky_parts(const sky_image *s, uint32_t view, double parts[SKY_BLOCKS]) {
    const sky_view from = view_at(view % SKY_VIEWS);
    for (uint32_t i = 0; i < s->rows * s->columns; ++i) {
        const sky_block *block = &s->blocks[i];
        parts[i] = view == SKY_VIEWS ? block->light.power : weight(block, &block->light, &from);
    }
    scale_to_one(s, parts);
}

void sky_avoid(const sky_image *s, uint32_t view, double parts[SKY_BLOCKS]) {
    if (view == SKY_VIEWS) return;
    const sky_view from = view_at(view);
    double cosines[SKY_BLOCKS];
    for (uint32_t i = 0; i < s->rows * s->columns; ++i)
        cosines[i] = weight(&s->blocks[i], &s->blocks[i].even, &from);
    scale_to_one(s, cosines);
    for (uint32_t i = 0; i < s->rows * s->columns; ++i)
        parts[i] = fmax(parts[i] + SKY_AVOID * (parts[i] - cosines[i]), SKY_KEEP * parts[i]);
    scale_to_one(s, parts);
}

/* Densities are those before the sums are rounded. */
void sky_table(sky_image *s, const double parts[SKY_BLOCKS], uint32_t index) {
    float *rows = s->views + (size_t)index * sky_view_size(s), *columns = rows + s->rows;
    float *scales = s->scales + (size_t)index * s->rows * s->columns;
    double all[SKY_BLOCK_ROWS] = {0}, row[SKY_BLOCK_COLUMNS] = {0}, sum = 0;
    for (uint32_t y = 0; y < s->rows; ++y) {
        const uint32_t first = y * s->columns;
        double line = 0;
        for (uint32_t i = first; i < first + s->columns; ++i) {
            row[i - first] = line += parts[i];
            const double power = s->blocks[i].light.power;
            scales[i] = power > 0 ? (float)(parts[i] / power) : 0;
        }
        normalize_sums(row, s->columns, columns + first);
        all[y] = sum += line;
    }
    normalize_sums(all, s->rows, rows);
    for (uint32_t i = 0; sum > 0 && i < s->rows * s->columns; ++i)
        scales[i] = (float)((double)scales[i] / sum);
}

/* ---- the whole ---- */

static bool allocate(sky_image *s) {
    const size_t rows = cell_rows(s), blocks = (size_t)s->rows * s->columns;
    s->cosines = malloc((rows + 1) * sizeof *s->cosines);
    s->row_block = malloc(rows);
    s->column_block = malloc(s->width);
    s->cells = malloc(rows * s->width * sizeof *s->cells);
    s->lines = malloc(rows * s->columns * sizeof *s->lines);
    s->blocks = malloc(blocks * sizeof *s->blocks);
    s->views = malloc((SKY_VIEWS + 1) * (size_t)sky_view_size(s) * sizeof *s->views);
    s->scales = malloc((SKY_VIEWS + 1) * blocks * sizeof *s->scales);
    return s->cosines && s->row_block && s->column_block && s->cells && s->lines && s->blocks && s->views &&
           s->scales;
}

static bool fill(sky_image *s) {
    const sky_sums sums = {malloc(s->width * sizeof *sums.turns), malloc(s->width * sizeof *sums.cells),
                           malloc((size_t)cell_rows(s) * s->columns * sizeof *sums.lines)};
    const bool there = sums.turns && sums.cells && sums.lines;
    for (uint32_t x = 0; there && x < s->width; ++x)
        shape_turn((x + 1.0) / s->width, &sums.turns[x].cosine, &sums.turns[x].sine);
    if (there) sum_blocks(s, &sums);
    for (uint32_t view = 0; there && view <= SKY_VIEWS; ++view) {
        double parts[SKY_BLOCKS];
        sky_parts(s, view, parts);
        sky_avoid(s, view, parts);
        sky_table(s, parts, view);
    }
    free(sums.lines);
    free(sums.cells);
    free(sums.turns);
    return there;
}

static double margin_of(double angle) { return fmin(4 * 0x1p-24 / angle, 0.25); }

bool sky_open(sky_image *s) {
    s->rows = min_u32(cell_rows(s), SKY_BLOCK_ROWS), s->columns = min_u32(s->width, SKY_BLOCK_COLUMNS);
    s->margin[0] = margin_of(2 * SHAPE_PI / s->width), s->margin[1] = margin_of(SHAPE_PI / s->height);
    if (!allocate(s)) return false;
    find_firsts(cell_rows(s), s->rows, s->row_first, s->row_block);
    find_firsts(s->width, s->columns, s->column_first, s->column_block);
    for (uint32_t row = 0; row <= cell_rows(s); ++row)
        s->cosines[row] = 1 - 2 * pow(sin(row_angle(s, row) / 2), 2);
    for (size_t i = 0; i < (size_t)s->width * s->height; ++i) {
        const float *c = s->texels[i].rgb;
        s->texels[i].luminance =
            (float)(0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2]);
    }
    return fill(s);
}

void sky_close(sky_image *s) {
    free(s->texels);
    free(s->cosines);
    free(s->row_block);
    free(s->column_block);
    free(s->cells);
    free(s->lines);
    free(s->blocks);
    free(s->views);
    free(s->scales);
    free(s->roots);
    free(s->splits);
}
