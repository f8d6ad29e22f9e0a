/* Regions of surfaces, and the probabilities with which their light samples choose classes of emitters. The
 * samples of a few paths tell how much the light of each class varies there. Probabilities p of samples with
 * the variances v have the least variance of all, the sum of v / p, where p is proportional to the root of v.
 */
#include "light/emitters_inner.h"

#include "base/array.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Minimum number of light samples of a region: fewer would miss rare bright ones. */
#define LEAST_GLANCES 512u
#define MOST_DEPTH 24u
/* Prior: the variances of the enclosing region have the weight of this many samples. */
#define PRIOR 32.0
/* Regions must reduce the variance of light samples at least to this in the geometric mean, which a few
 * regions with rare bright light do not decide. */
#define WORTH 0.9
/* Probabilities are multiples of 1/8: runs of a net's points in each class are then nets. */
enum { PARTS_OF_ONE = 8 };

const emitter_shares *emitters_region(const emitters *e, vec3_f32 p, vec3_f32 n) {
    const float at[6] = {p.x, p.y, p.z, n.x, n.y, n.z};
    return &e->regions[region_find(e->splits, e->root, at, 1)];
}

/* Sums over the light of samples, as if their class were the only one. */
typedef struct class_moments {
    double count, sum, squares;
} class_moments;

typedef struct region_pupil {
    const emitters *e;
    const emitter_shares *scout; /* of the paths */
    emitter_glance *glances;
    float scales[6];
    ARRAY(region_split) splits;
    emitter_shares *choices;
    uint32_t choice_count, whole; /* whole: the choice of the whole scene */
    double gain, count; /* sums over regions: logarithms of the changes of variance times samples, samples */
    bool fails;         /* out of memory */
} region_pupil;

typedef struct glance_span {
    size_t begin, end;
} glance_span;

/* ---- variances ---- */

/* known: variances in the enclosing region; become those in this region. */
static void learn(const region_pupil *p, glance_span span, double known[EMITTER_PARTS]) {
    class_moments m[EMITTER_PARTS] = {{0}};
    for (size_t k = span.begin; k < span.end; ++k) {
        const emitter_glance *g = &p->glances[k];
        const double light = (double)g->light;
        ++m[g->part].count, m[g->part].sum += light, m[g->part].squares += light * light * (double)g->density;
    }
    for (int c = 0; c < EMITTER_PARTS; ++c) {
        if (!(m[c].count > 0)) continue;
        const double average = m[c].sum / m[c].count,
                     variance = fmax(m[c].squares / m[c].count - average * average, 0);
        known[c] = (m[c].count * variance + PRIOR * known[c]) / (m[c].count + PRIOR);
    }
}

static double variance_with(const double of[EMITTER_PARTS], const emitter_shares *shares) {
    double sum = 0;
    for (int c = 0; c < EMITTER_PARTS; ++c)
        if (shares->of[c] > 0) sum += of[c] / shares->of[c];
    return sum;
}

static uint32_t best_choice(const region_pupil *p, const double of[EMITTER_PARTS]) {
    uint32_t best = 0;
    for (uint32_t k = 1; k < p->choice_count; ++k)
        if (variance_with(of, &p->choices[k]) < variance_with(of, &p->choices[best])) best = k;
    return best;
}

/* Returns the region's choice, as a leaf. */
static uint32_t settle(region_pupil *p, glance_span span, const double of[EMITTER_PARTS]) {
    const uint32_t best = best_choice(p, of);
    const double before = variance_with(of, &p->choices[p->whole]),
                 after = variance_with(of, &p->choices[best]), count = (double)(span.end - span.begin);
    p->count += count;
    if (before > 0) p->gain += count * log(after / before);
    return REGION_LEAF + best;
}

/* ---- regions ---- */

/* Returns the region or its parts, as region_split.below. */
static uint32_t divide(region_pupil *p, glance_span span, const double around[EMITTER_PARTS],
                       unsigned depth) {
    double known[EMITTER_PARTS];
    memcpy(known, around, sizeof known);
    learn(p, span, known);
    if (!depth) p->whole = best_choice(p, known);
    if (span.end - span.begin < 2 * LEAST_GLANCES || depth == MOST_DEPTH) return settle(p, span, known);
    const region_items items = {p->glances + span.begin, sizeof *p->glances, span.end - span.begin};
    region_split split = region_choose(&items, 6, p->scales);
    const size_t middle = span.begin + region_part(&items, &split);
    if (middle - span.begin < LEAST_GLANCES / 2 || span.end - middle < LEAST_GLANCES / 2)
        return settle(p, span, known);
    split.below = divide(p, (glance_span){span.begin, middle}, known, depth + 1);
    split.above = divide(p, (glance_span){middle, span.end}, known, depth + 1);
    if (split.below == split.above) return split.below;
    if (!array_push(&p->splits, split)) p->fails = true;
    return (uint32_t)p->splits.count - 1;
}

/* ---- the whole ---- */

/* All probabilities, at least 1/8 for each class that is there. */
static bool list_choices(region_pupil *p) {
    const emitter_shares *now = &p->e->shares;
    p->choices = malloc((size_t)PARTS_OF_ONE * PARTS_OF_ONE * sizeof *p->choices);
    for (int a = 0; p->choices && a <= PARTS_OF_ONE; ++a) {
        for (int b = 0; a + b <= PARTS_OF_ONE; ++b) {
            const int of[EMITTER_PARTS] = {a, b, PARTS_OF_ONE - a - b};
            bool fits = true;
            for (int c = 0; c < EMITTER_PARTS; ++c) fits &= (of[c] > 0) == (now->of[c] > 0);
            if (!fits) continue;
            for (int c = 0; c < EMITTER_PARTS; ++c)
                p->choices[p->choice_count].of[c] = of[c] / (double)PARTS_OF_ONE;
            ++p->choice_count;
        }
    }
    return p->choices != NULL;
}

/* The densities with which light from outside is sampled now, without the choice of the class. */
static void look_up(const region_pupil *p, size_t first, unsigned lanes, float density[LANES]) {
    lanes3 at, n, direction, radiance;
    for (unsigned left = lanes; left; left &= left - 1) {
        const unsigned i = lane_first(left);
        const emitter_glance *g = &p->glances[first + i];
        for (int c = 0; c < 3; ++c)
            at[c][i] = g->at[c], n[c][i] = g->at[3 + c], direction[c][i] = g->direction[c];
    }
    emitters_outside(p->e, lanes, at, n, direction, radiance, density);
    for (unsigned i = 0; i < LANES; ++i) density[i] /= (float)p->e->shares.of[EMITTER_OUTSIDE];
}

/* Rescales samples as if their class were the only one. density becomes the factor of their squares: 1,
 * unless learning has changed how the class is sampled. */
static void adapt(const region_pupil *p, size_t count) {
    for (size_t done = 0; done < count; done += LANES) {
        float now[LANES] = {0};
        unsigned outside = 0;
        for (unsigned i = 0; i < LANES && done + i < count; ++i) {
            emitter_glance *g = &p->glances[done + i];
            const float share = (float)p->scout->of[g->part];
            g->light *= share, g->density /= share;
            outside |= g->part == EMITTER_OUTSIDE && g->light > 0 ? 1u << i : 0;
        }
        if (outside) look_up(p, done, outside, now);
        for (unsigned i = 0; i < LANES && done + i < count; ++i) {
            emitter_glance *g = &p->glances[done + i];
            g->density = g->part == EMITTER_FINITE ? (float)emitters_seen_change(p->e, g)
                         : now[i] > 0              ? g->density / now[i]
                                                   : 1;
        }
    }
}

static bool keep(emitters *e, region_pupil *p, uint32_t root) {
    const bool worth = p->splits.count && p->gain < log(WORTH) * p->count;
    if (!p->fails) e->shares = p->choices[p->whole];
    if (!p->fails && worth) {
        e->splits = p->splits.items, e->regions = p->choices, e->root = root;
        return true;
    }
    array_free(&p->splits);
    free(p->choices);
    return !p->fails;
}

bool emitters_learn_regions(emitters *e, const emitter_lesson *from) {
    const size_t count = from->glance_count;
    const double unknown[EMITTER_PARTS] = {0};
    region_pupil p = {.e = e, .scout = &from->by->shares, .glances = from->glances};
    if (count < LEAST_GLANCES) return true;
    if (!list_choices(&p)) return false;
    if (p.choice_count < 2) {
        free(p.choices);
        return true;
    }
    adapt(&p, count);
    region_scales(&(region_items){p.glances, sizeof *p.glances, count}, p.scales);
    return keep(e, &p, divide(&p, (glance_span){0, count}, unknown, 0));
}
