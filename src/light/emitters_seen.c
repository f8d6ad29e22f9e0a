/* The light tree knows no walls. The samples of a few paths tell which fraction of the light of each block of
 * lights arrives in a region of surfaces; factors of the tree's weights follow from that. */
#include "light/emitters_inner.h"

#include "light/learn.h"

#include <stdlib.h>
#include <string.h>

/* Minimum number of light samples of a region. */
#define LEAST_RAYS 256u
/* A block has at least this many samples, unless it is a child of the root. */
#define LEAST_ASKED 128u
#define MOST_ROWS ((unsigned)LEARN_BLOCKS / TREE_WIDE)
/* Factors of its own must reduce the mean square of a region's light samples at least to this, and those of
 * all regions in the geometric mean to WORTH_ALL: finding a region's factors takes time. */
#define WORTH 0.9
#define WORTH_ALL 0.6
/* Minimum factor: no light is chosen with less than this fraction of the probability before. It bounds the
 * variance where the samples missed something. */
#define DEFENCE 0.05

double emitters_seen_change(const emitters *e, const emitter_glance *g) {
    const vec3_f32 p = load_f32(g->at), n = load_f32(g->at + 3);
    const tree_view *view = emitters_view(e, p, n);
    if (!view || !view->factors || !(g->light > 0)) return 1;
    const uint32_t slot = e->slot_of[g->emitter];
    const double now = tree_chance(&e->lights, p, n, view, slot);
    return now > 0 ? tree_chance(&e->lights, p, n, NULL, slot) / now : 1;
}

typedef struct seen_pupil {
    const tree *lights;
    learner learner;
    ARRAY(float) tables;
    double gain, count; /* sums over regions: logarithms of the changes of the mean square times rays, rays */
} seen_pupil;

/* ---- factors ---- */

/* The square root minimises the variance if light from a block either arrives or does not. */
static double factor_of(double seen) { return fmax(sqrt(seen), DEFENCE); }

/* Returns the mean square of samples with factors, divided by that without. */
static double weigh(const learner *l, learn_looks looks, const double seen[LEARN_BLOCKS]) {
    double asked[LEARN_BLOCKS] = {0}, before = 0, after = 0, sum = 0;
    for (size_t k = 0; k < looks.count; ++k) ++asked[looks.items[k].block];
    for (uint32_t i = 0; i < l->blocks; ++i) {
        const double factor = factor_of(seen[i]);
        before += asked[i] * seen[i], after += asked[i] * seen[i] / factor, sum += asked[i] * factor;
    }
    return after * sum / (before * (double)looks.count);
}

/* Leaf 0: none of its own. */
static uint32_t make_factors(void *user, learn_looks looks, const double seen[LEARN_BLOCKS]) {
    seen_pupil *p = user;
    const size_t size = p->learner.blocks;
    const double change = weigh(&p->learner, looks, seen);
    p->count += (double)looks.count;
    if (!(change < WORTH)) return 0;
    p->gain += (double)looks.count * log(change);
    if (!array_room(&p->tables, size)) {
        p->learner.fails = true;
        return 0;
    }
    float *table = p->tables.items + p->tables.count;
    for (size_t i = 0; i < size; ++i) table[i] = (float)factor_of(seen[i]);
    tree_average(p->lights, table);
    p->tables.count += size;
    return (uint32_t)(p->tables.count / size);
}

/* ---- blocks ---- */

/* Gives rows to nodes whose lights were asked most. False: out of memory. */
static bool set_rows(emitters *e, const emitter_lesson *from) {
    tree *t = &e->lights;
    uint32_t *asked = calloc((size_t)t->count * TREE_WIDE, sizeof *asked);
    if (!asked) return false;
    for (size_t k = 0; k < from->glance_count; ++k) {
        const emitter_glance *g = &from->glances[k];
        if (g->part != EMITTER_FINITE || g->seen < 0) continue;
        uint32_t slot = e->slot_of[g->emitter];
        for (++asked[slot]; slot >= TREE_WIDE; ++asked[slot]) slot = t->parent[slot / TREE_WIDE];
    }
    const bool fine = tree_set_rows(t, asked, LEAST_ASKED, MOST_ROWS);
    free(asked);
    return fine;
}

/* Groups are all lights, and those below a slot of the first and second level; the last are the blocks. */
static void set_groups(const tree *t, uint16_t groups[LEARN_LEVELS][LEARN_BLOCKS]) {
    for (uint32_t block = 0; block < t->rows * TREE_WIDE; ++block) {
        uint32_t chain[MOST_ROWS], depth = 0; /* from the block up to the root */
        for (uint32_t at = block;; at = tree_factor_at(t, t->parent[t->row_node[at / TREE_WIDE]])) {
            chain[depth++] = at;
            if (at < TREE_WIDE) break;
        }
        groups[0][block] = 0;
        for (uint32_t level = 1; level < LEARN_LEVELS; ++level)
            groups[level][block] = level > depth               ? LEARN_NONE
                                   : level == LEARN_LEVELS - 1 ? (uint16_t)block
                                                               : (uint16_t)chain[depth - level];
    }
}

/* The samples of lights that would bring light if they were seen. Returns their number. */
static size_t list_looks(const emitters *e, const emitter_lesson *from, learn_look *looks) {
    size_t count = 0;
    for (size_t k = 0; k < from->glance_count; ++k) {
        const emitter_glance *g = &from->glances[k];
        if (g->part != EMITTER_FINITE || g->seen < 0) continue;
        learn_look *look = &looks[count++];
        memcpy(look->at, g->at, sizeof look->at);
        look->seen = g->seen, look->block = tree_block(&e->lights, e->slot_of[g->emitter]);
    }
    return count;
}

/* ---- the whole ---- */

static void divide(emitters *e, seen_pupil *p, learn_looks looks) {
    p->learner = (learner){.blocks = e->lights.rows * TREE_WIDE,
                           .axes = 6,
                           .least = LEAST_RAYS,
                           .settle = make_factors,
                           .user = p};
    set_groups(&e->lights, p->learner.groups);
    region_scales(&(region_items){looks.items, sizeof *looks.items, looks.count}, p->learner.scales);
    e->seen.root = learn_regions(&p->learner, looks);
}

bool emitters_learn_seen(emitters *e, const emitter_lesson *from) {
    seen_pupil p = {.lights = &e->lights};
    if (e->finite_count < 2 || from->glance_count < LEAST_RAYS) return true;
    learn_looks looks = {.items = malloc(from->glance_count * sizeof *looks.items)};
    bool fine = looks.items && set_rows(e, from);
    if (fine) looks.count = list_looks(e, from, looks.items);
    if (fine && looks.count >= LEAST_RAYS) divide(e, &p, looks);
    free(looks.items);
    fine = fine && !p.learner.fails;
    if (fine && p.gain < log(WORTH_ALL) * p.count) {
        e->seen.tables = p.tables.items, e->seen.splits = p.learner.splits.items;
    } else {
        array_free(&p.tables);
        array_free(&p.learner.splits);
    }
    return fine;
}
