/* Makes a sampling table of a sky for each region of surfaces, from the parts that the region sees. */
#include "light/learn.h"
#include "light/sky.h"
#include "math/lane.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Minimum number of rays of a region: smaller regions would know too little of the sky. */
#define LEAST_RAYS 512u
/* A table of its own must reduce the variance of light samples at least to this, by the estimate below. */
#define WORTH 0.9
/* A block counts as at least this fraction as visible as its neighbours. */
#define NEIGHBOUR 0.01
/* The fraction of samples that use the table of the whole sky: it bounds the variance where the rays
 * missed something. */
#define DEFENCE 0.05

_Static_assert((int)SKY_BLOCKS <= (int)LEARN_BLOCKS, "");

typedef struct sky_pupil {
    sky_image *s;
    const sky_ray *rays;
    learn_look *looks; /* by view */
    learner learner;
    uint32_t view;             /* of the regions that are being made */
    uint32_t tables, capacity; /* in s->views and s->scales */
} sky_pupil;

/* ---- what rays tell ---- */

/* Groups are squares of 8, 4, 2 and 1 blocks a side. */
static void set_groups(sky_pupil *p) {
    const uint32_t columns = p->s->columns;
    for (uint32_t level = 0, side = 8; level < LEARN_LEVELS; ++level, side /= 2) {
        const uint32_t across = (columns + side - 1) / side;
        for (uint32_t block = 0; block < p->s->rows * columns; ++block)
            p->learner.groups[level][block] =
                (uint16_t)(block / columns / side * across + block % columns / side);
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
static uint32_t make_table(void *user, learn_looks looks, const double seen[LEARN_BLOCKS]) {
    sky_pupil *p = user;
    double parts[SKY_BLOCKS];
    (void)looks;
    if (weigh(p->s, p->view, seen, parts) > WORTH) return p->view;
    if (!reserve_table(p)) {
        p->learner.fails = true;
        return p->view;
    }
    sky_table(p->s, parts, p->tables);
    return p->tables++;
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
        p->looks[at[views[k]]++] =
            (learn_look){.at = {ray->p.x, ray->p.y, ray->p.z}, .seen = ray->seen, .block = blocks[k]};
    }
    free(views), free(blocks);
    return views && blocks;
}

static void divide_views(sky_pupil *p, const size_t first[SKY_VIEWS + 2], uint32_t roots[SKY_VIEWS + 1]) {
    for (p->view = 0; p->view <= SKY_VIEWS; ++p->view) {
        const learn_looks looks = {p->looks + first[p->view], first[p->view + 1] - first[p->view]};
        roots[p->view] = looks.count < LEAST_RAYS ? REGION_LEAF + p->view : learn_regions(&p->learner, looks);
    }
}

bool sky_learn(sky_image *s, const sky_ray *rays, size_t count) {
    sky_pupil p = {.s = s, .rays = rays, .tables = SKY_VIEWS + 1, .capacity = SKY_VIEWS + 1};
    size_t first[SKY_VIEWS + 2];
    uint32_t *roots = malloc((SKY_VIEWS + 1) * sizeof *roots);
    p.learner = (learner){.blocks = s->rows * s->columns,
                          .axes = 3,
                          .scales = {1, 1, 1},
                          .least = LEAST_RAYS,
                          .settle = make_table,
                          .user = &p};
    set_groups(&p);
    p.looks = malloc((count + 1) * sizeof *p.looks);
    p.learner.fails = !roots || !p.looks || !sort_looks(&p, count, first);
    if (!p.learner.fails) divide_views(&p, first, roots);
    free(p.looks);
    if (p.learner.fails || p.tables == SKY_VIEWS + 1) {
        free(roots);
        array_free(&p.learner.splits);
        return !p.learner.fails;
    }
    s->roots = roots, s->splits = p.learner.splits.items;
    return true;
}
