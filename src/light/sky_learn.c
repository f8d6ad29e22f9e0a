/* Estimates which parts of a sky surfaces see, by region of surfaces, and makes a sampling table for each
 * region. */
#include "base/array.h"
#include "light/sky.h"
#include "math/lane.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Minimum number of rays of a region: smaller regions would know too little of the sky. */
#define LEAST_RAYS 512u
/* Maximum depth of splits: outliers could cause many. */
#define MOST_DEPTH 16u
/* A table of its own must reduce the variance of light samples at least to this, by the estimate below. */
#define WORTH 0.9
/* A prior counts as much as this many rays. */
#define PRIOR_RAYS 32.0
#define LEAST_SEEN 1e-8
/* A block counts as at least this fraction as visible as its neighbours. */
#define NEIGHBOUR 0.01
/* The fraction of samples that use the table of the whole sky: it bounds the variance where the rays
 * missed something. */
#define DEFENCE 0.05

/* A ray, once rays are sorted by view. */
typedef struct sky_look {
    float p[3], seen;
    uint32_t block;
} sky_look;

enum { LEVELS = 4 };

typedef struct sky_pupil {
    sky_image *s;
    uint16_t groups[LEVELS][SKY_BLOCKS]; /* by block */
    const sky_ray *rays;
    sky_look *looks;
    ARRAY(region_split) splits;
    uint32_t tables, capacity; /* in s->views and s->scales */
    bool fails;                /* out of memory */
} sky_pupil;

/* Looks [begin, end) of one view. */
typedef struct sky_span {
    size_t begin, end;
    uint32_t view;
} sky_span;

/* ---- what rays tell ---- */

/* Groups are squares of 8, 4, 2 and 1 blocks a side. */
static void set_groups(sky_pupil *p) {
    const uint32_t columns = p->s->columns;
    for (uint32_t level = 0, side = 8; level < LEVELS; ++level, side /= 2) {
        const uint32_t across = (columns + side - 1) / side;
        for (uint32_t block = 0; block < p->s->rows * columns; ++block)
            p->groups[level][block] = (uint16_t)(block / columns / side * across + block % columns / side);
    }
}

/* Corrects the fractions that are seen, group by group: the number of rays that arrived, divided by the
 * number expected. */
static void correct(const sky_pupil *p, sky_span span, const uint16_t groups[SKY_BLOCKS],
                    double seen[SKY_BLOCKS]) {
    double expected[SKY_BLOCKS] = {0}, arrived[SKY_BLOCKS] = {0};
    uint32_t count[SKY_BLOCKS] = {0};
    for (size_t k = span.begin; k < span.end; ++k) {
        const uint32_t block = p->looks[k].block, group = groups[block];
        expected[group] += seen[block], ++count[group];
        arrived[group] += (double)p->looks[k].seen;
    }
    for (uint32_t block = 0; block < p->s->rows * p->s->columns; ++block) {
        const uint32_t group = groups[block];
        if (!count[group]) continue;
        const double prior = PRIOR_RAYS * expected[group] / count[group],
                     factor = (arrived[group] + prior) / (expected[group] + prior);
        seen[block] = fmin(fmax(seen[block] * factor, LEAST_SEEN), 1);
    }
}

/* A region may see some of a block next to one that its rays saw. */
static double seen_near(const sky_image *s, const double seen[SKY_BLOCKS], uint32_t i) {
    const uint32_t x = i % s->columns, right = x + 1 < s->columns ? i + 1 : i - x,
                   left = x ? i - 1 : i + s->columns - 1;
    double most = fmax(seen[left], seen[right]);
    if (i >= s->columns) most = fmax(most, seen[i - s->columns]);
    if (i + s->columns < s->rows * s->columns) most = fmax(most, seen[i + s->columns]);
    return fmax(seen[i], NEIGHBOUR * most);
}

/* The square root minimises the variance if light from a block either arrives or does not. Returns the
 * variance with these weights, divided by that with the weights of the view. */
static double weigh(const sky_image *s, uint32_t view, const double seen[SKY_BLOCKS],
                    double parts[SKY_BLOCKS]) {
    double whole[SKY_BLOCKS], arrives = 0, sum = 0;
    sky_parts(s, view, whole);
    for (uint32_t i = 0; i < s->rows * s->columns; ++i) {
        parts[i] = whole[i] * sqrt(seen_near(s, seen, i));
        arrives += whole[i] * seen[i], sum += parts[i];
    }
    for (uint32_t i = 0; sum > 0 && i < s->rows * s->columns; ++i) parts[i] /= sum;
    sky_avoid(s, view, parts), sky_avoid(s, view, whole);
    for (uint32_t i = 0; i < s->rows * s->columns; ++i)
        parts[i] = (1 - DEFENCE) * parts[i] + DEFENCE * whole[i];
    return sum > 0 ? sum * sum / arrives : 1;
}

/* ---- regions ---- */

static bool reserve_table(sky_pupil *p) {
    sky_image *s = p->s;
    if (p->tables < p->capacity) return true;
    const size_t capacity = 2 * (size_t)p->capacity;
    float *views = realloc(s->views, capacity * sky_view_size(s) * sizeof *views);
    if (views) s->views = views;
    float *scales = realloc(s->scales, capacity * s->rows * s->columns * sizeof *scales);
    if (scales) s->scales = scales;
    if (!views || !scales) return false;
    p->capacity = (uint32_t)capacity;
    return true;
}

/* Returns the region's table, or that of its view if its own would gain too little. */
static uint32_t make_table(sky_pupil *p, uint32_t view, const double seen[SKY_BLOCKS]) {
    double parts[SKY_BLOCKS];
    if (weigh(p->s, view, seen, parts) > WORTH) return REGION_LEAF + view;
    if (!reserve_table(p)) {
        p->fails = true;
        return REGION_LEAF + view;
    }
    sky_table(p->s, parts, p->tables);
    return REGION_LEAF + p->tables++;
}

/* Returns the region or its parts, as region_split.below. known: the fractions that a larger region sees. */
static uint32_t divide(sky_pupil *p, sky_span span, const double known[SKY_BLOCKS], unsigned depth) {
    double seen[SKY_BLOCKS];
    memcpy(seen, known, sizeof seen);
    for (int level = 0; level < LEVELS; ++level) correct(p, span, p->groups[level], seen);
    if (span.end - span.begin < 2 * LEAST_RAYS || depth == MOST_DEPTH) return make_table(p, span.view, seen);
    static const float scales[3] = {1, 1, 1};
    const region_items items = {p->looks + span.begin, sizeof *p->looks, span.end - span.begin};
    region_split split = region_choose(&items, 3, scales);
    const size_t middle = span.begin + region_part(&items, &split);
    if (middle - span.begin < LEAST_RAYS / 2 || span.end - middle < LEAST_RAYS / 2)
        return make_table(p, span.view, seen);
    split.below = divide(p, (sky_span){span.begin, middle, span.view}, seen, depth + 1);
    split.above = divide(p, (sky_span){middle, span.end, span.view}, seen, depth + 1);
    if (split.below == split.above) return split.below;
    if (!array_push(&p->splits, split)) p->fails = true;
    return (uint32_t)p->splits.count - 1;
}

/* ---- the whole ---- */

/* Sorts the rays by view; first: the index of each view's first ray. */
static bool sort_looks(sky_pupil *p, size_t count, size_t first[SKY_VIEWS + 2]) {
    const sky_kernels *kernels = sky_kernels_best();
    uint32_t *views = malloc((count + LANES) * sizeof *views),
             *blocks = malloc((count + LANES) * sizeof *blocks);
    size_t at[SKY_VIEWS + 2] = {0};
    for (size_t done = 0; views && blocks && done < count; done += LANES) {
        lanes3_f64 n, direction;
        for (unsigned i = 0; i < LANES; ++i) {
            const sky_ray *ray = &p->rays[done + i < count ? done + i : done];
            put_lane_f64(n, i, widen(ray->n));
            put_lane_f64(direction, i, widen(ray->direction));
        }
        kernels->find(p->s, n, direction, views + done, blocks + done);
    }
    for (size_t k = 0; views && blocks && k < count; ++k) ++at[views[k] + 1];
    for (unsigned v = 0; v <= SKY_VIEWS; ++v) at[v + 1] += at[v];
    memcpy(first, at, sizeof at);
    for (size_t k = 0; views && blocks && k < count; ++k) {
        const sky_ray *ray = &p->rays[k];
        p->looks[at[views[k]]++] = (sky_look){{ray->p.x, ray->p.y, ray->p.z}, ray->seen, blocks[k]};
    }
    free(views), free(blocks);
    return views && blocks;
}

static void divide_views(sky_pupil *p, const size_t first[SKY_VIEWS + 2], uint32_t roots[SKY_VIEWS + 1]) {
    double unknown[SKY_BLOCKS];
    for (uint32_t i = 0; i < SKY_BLOCKS; ++i) unknown[i] = 1;
    for (uint32_t view = 0; view <= SKY_VIEWS; ++view) {
        const sky_span span = {first[view], first[view + 1], view};
        roots[view] = span.end - span.begin < LEAST_RAYS ? REGION_LEAF + view : divide(p, span, unknown, 0);
    }
}

bool sky_learn(sky_image *s, const sky_ray *rays, size_t count) {
    sky_pupil p = {.s = s, .rays = rays, .tables = SKY_VIEWS + 1, .capacity = SKY_VIEWS + 1};
    size_t first[SKY_VIEWS + 2];
    uint32_t *roots = malloc((SKY_VIEWS + 1) * sizeof *roots);
    set_groups(&p);
    p.looks = malloc((count + 1) * sizeof *p.looks);
    p.fails = !roots || !p.looks || !sort_looks(&p, count, first);
    if (!p.fails) divide_views(&p, first, roots);
    free(p.looks);
    if (p.fails || p.tables == SKY_VIEWS + 1) {
        free(roots);
        array_free(&p.splits);
        return !p.fails;
    }
    s->roots = roots, s->splits = p.splits.items;
    return true;
}
