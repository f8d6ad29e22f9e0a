/* Regions are halved as long as both halves have enough rays. The estimates of a region are the priors of its
 * halves; those of a group of blocks are the priors of the groups in it. */
#include "light/learn.h"

#include <math.h>
#include <string.h>

/* Maximum depth of splits: outliers could cause many. */
#define MOST_DEPTH 16u
/* A prior counts as much as this many rays. */
#define PRIOR_RAYS 32.0
#define LEAST_SEEN 1e-8

/* Corrects the fractions that are seen, group by group: the number of rays that arrived, divided by the
 * number expected. */
static void correct(const learner *l, learn_looks looks, const uint16_t groups[LEARN_BLOCKS],
                    double seen[LEARN_BLOCKS]) {
    double expected[LEARN_BLOCKS] = {0}, arrived[LEARN_BLOCKS] = {0};
    uint32_t count[LEARN_BLOCKS] = {0};
    for (size_t k = 0; k < looks.count; ++k) {
        const uint32_t block = looks.items[k].block, group = groups[block];
        if (group == LEARN_NONE) continue;
        expected[group] += seen[block], ++count[group];
        arrived[group] += (double)looks.items[k].seen;
    }
    for (uint32_t block = 0; block < l->blocks; ++block) {
        const uint32_t group = groups[block];
        if (group == LEARN_NONE || !count[group]) continue;
        const double prior = PRIOR_RAYS * expected[group] / count[group],
                     factor = (arrived[group] + prior) / (expected[group] + prior);
        seen[block] = fmin(fmax(seen[block] * factor, LEAST_SEEN), 1);
    }
}

/* known: the fractions that the enclosing region sees. */
static uint32_t divide(learner *l, learn_looks looks, const double known[LEARN_BLOCKS], unsigned depth) {
    double seen[LEARN_BLOCKS];
    memcpy(seen, known, sizeof seen);
    for (int level = 0; level < LEARN_LEVELS; ++level) correct(l, looks, l->groups[level], seen);
    if (looks.count < 2 * l->least || depth == MOST_DEPTH)
        return REGION_LEAF + l->settle(l->user, looks, seen);
    const region_items items = {looks.items, sizeof *looks.items, looks.count};
    region_split split = region_choose(&items, l->axes, l->scales);
    const size_t below = region_part(&items, &split), above = looks.count - below;
    if (below < l->least / 2 || above < l->least / 2) return REGION_LEAF + l->settle(l->user, looks, seen);
    split.below = divide(l, (learn_looks){looks.items, below}, seen, depth + 1);
    split.above = divide(l, (learn_looks){looks.items + below, above}, seen, depth + 1);
    if (split.below == split.above) return split.below;
    if (!array_push(&l->splits, split)) l->fails = true;
    return (uint32_t)l->splits.count - 1;
}

uint32_t learn_regions(learner *l, learn_looks looks) {
    double unknown[LEARN_BLOCKS];
    for (uint32_t i = 0; i < LEARN_BLOCKS; ++i) unknown[i] = 1;
    return divide(l, looks, unknown, 0);
}
