#include "film/sum_tree.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* ---- a square of a wave's sums ---- */

/* Moves a square out of the wave, leaving zeros, or into it. */
typedef struct move {
    const film_kernels *kernels;
    uint32_t slot;
    bool out;
} move;

static void move_doubles(const move *m, double *wave, double *square) {
    if (m->out)
        m->kernels->move_sums(wave + m->slot, square);
    else
        memcpy(wave + m->slot, square, LANES * sizeof *square);
}

static void move_words(const move *m, void *wave, void *square) {
    char *at = (char *)wave + m->slot * sizeof(uint32_t);
    memcpy(m->out ? square : (void *)at, m->out ? (void *)at : square, LANES * sizeof(uint32_t));
}

static void move_mattes(const move *m, matte_list *wave, matte_list *square) {
    const size_t bytes = LANES * sizeof *square;
    memcpy(m->out ? square : wave, m->out ? wave : square, bytes);
    if (m->out) memset(wave, 0, bytes);
}

static void move_hits(const move *m, hit_sums *hits, square_sums *square) {
    move_doubles(m, hits->alpha, square->alpha);
    move_doubles(m, hits->nearest, square->nearest);
    for (int c = 0; c < 3; ++c) {
        move_doubles(m, hits->n[c], square->n[c]);
        move_doubles(m, hits->albedo[c], square->albedo[c]);
        move_words(m, hits->centre.p[c], square->p[c]);
    }
    move_words(m, hits->centre.z, square->z);
    for (int c = 0; c < 4; ++c) move_words(m, hits->centre.motion[c], square->motion[c]);
    move_words(m, hits->centre.object, square->object);
    move_words(m, hits->centre.primitive, square->primitive);
    move_words(m, hits->centre.instance, square->instance);
}

static void move_sums(const move *m, pixel_sums *sums, square_sums *square) {
    for (uint32_t g = 0; g < sums->groups; ++g) {
        for (int c = 0; c < 3; ++c) move_doubles(m, sums->rgb[g][c], square->rgb[g][c]);
    }
    if (sums->hits) move_hits(m, sums->hits, square);
    for (uint32_t k = 0; k < 3 * film_part_sums(sums->parts); ++k)
        move_doubles(m, sums->layers[k], square->layers[k]);
    for (uint32_t k = 0; k < sums->parts.matte_count; ++k)
        move_mattes(m, sums->mattes[k] + m->slot, square->mattes[k]);
}

void sum_take(pixel_sums *from, uint32_t square, square_sums *out) {
    const uint32_t slot = square * LANES;
    move_sums(&(move){from->kernels, slot, true}, from, out);
    for (uint32_t k = 0; k < LANES && from->hits; ++k) from->hits->nearest[slot + k] = INFINITY;
}

void sum_give(const square_sums *from, uint32_t square, pixel_sums *to) {
    move_sums(&(move){to->kernels, square * LANES, false}, to, (square_sums *)(uintptr_t)from);
}

/* ---- adding ---- */

/* At equal distances, keeps the earlier sample. */
static void keep_nearest(const square_sums *from, square_sums *to) {
    for (int k = 0; k < LANES; ++k) {
        if (from->nearest[k] >= to->nearest[k]) continue;
        to->nearest[k] = from->nearest[k];
        to->z[k] = from->z[k];
        for (int c = 0; c < 3; ++c) to->p[c][k] = from->p[c][k];
        for (int c = 0; c < 4; ++c) to->motion[c][k] = from->motion[c][k];
        to->object[k] = from->object[k];
        to->primitive[k] = from->primitive[k];
        to->instance[k] = from->instance[k];
    }
}

static void add_node(const pixel_sums *like, const square_sums *from, square_sums *to) {
    void (*const add)(const double *, double *) = like->kernels->add_sums;
    for (uint32_t g = 0; g < like->groups; ++g) {
        for (int c = 0; c < 3; ++c) add(from->rgb[g][c], to->rgb[g][c]);
    }
    for (uint32_t k = 0; k < 3 * film_part_sums(like->parts); ++k) add(from->layers[k], to->layers[k]);
    for (uint32_t k = 0; k < like->parts.matte_count; ++k) {
        for (int i = 0; i < LANES; ++i) matte_add_all(&to->mattes[k][i], &from->mattes[k][i]);
    }
    if (!like->hits) return;
    add(from->alpha, to->alpha);
    for (int c = 0; c < 3; ++c) {
        add(from->n[c], to->n[c]);
        add(from->albedo[c], to->albedo[c]);
    }
    keep_nearest(from, to);
}

/* True if the top node is the right sibling of the one below it. */
static bool is_pair(const sum_stack *s) {
    if (s->count < 2) return false;
    const sum_node *left = &s->nodes[s->count - 2], *right = left + 1;
    return left->level == right->level && !(left->first >> left->level & 1) &&
           right->first == left->first + (1u << left->level);
}

void sum_push(const pixel_sums *like, sum_stack *s) {
    for (++s->count; is_pair(s); --s->count) {
        sum_node *left = &s->nodes[s->count - 2];
        add_node(like, &left[1].sums, &left->sums);
        ++left->level;
    }
}

void sum_fold(const pixel_sums *like, sum_stack *s) {
    for (; s->count > 1; --s->count)
        add_node(like, &s->nodes[s->count - 1].sums, &s->nodes[s->count - 2].sums);
}

sum_node *sum_nodes_create(film_parts parts, size_t count) {
    const size_t each = 3 * film_part_sums(parts), lists = parts.matte_count;
    sum_node *nodes =
        calloc(count, sizeof *nodes + each * LANES * sizeof(double) + lists * LANES * sizeof(matte_list));
    if (!nodes) return NULL;
    double(*layers)[LANES] = (double(*)[LANES])(void *)(nodes + count);
    matte_list(*mattes)[LANES] = (matte_list(*)[LANES])(void *)(layers + count * each);
    for (size_t i = 0; i < count; ++i)
        nodes[i].sums.layers = layers + i * each, nodes[i].sums.mattes = mattes + i * lists;
    return nodes;
}

/* ---- which nodes there are ---- */

#define SUM_LEVELS 16u /* for 65536 samples */

uint32_t sum_list_nodes(sum_range range, sum_node *out) {
    const uint32_t end = sum_leaves(range.end);
    uint32_t count = 0;
    for (uint32_t first = range.begin / SUM_LEAF, level; first < end; first += 1u << level, ++count) {
        for (level = 0; level < SUM_LEVELS; ++level) {
            if (first >> level & 1 || first + (2u << level) > end) break;
        }
        if (out) out[count].first = first, out[count].level = level;
    }
    return count;
}

/* Up to two nodes of each level wait until a node of the next level is complete. */
uint32_t sum_stack_depth(sum_range range) {
    uint32_t depth = 2;
    for (uint32_t leaves = sum_leaves(range.end) - range.begin / SUM_LEAF; leaves > 1; leaves /= 2)
        depth += 2;
    return depth;
}

/* ---- as bytes ---- */

#define RGB_BYTES (3 * LANES * sizeof(double))

_Static_assert(offsetof(square_sums, alpha) == SAMPLE_GROUPS * RGB_BYTES, "no bytes between the fields");
_Static_assert(offsetof(square_sums, layers) == offsetof(square_sums, alpha) + LANES * (8 * 8 + 11 * 4),
               "nor behind the hits");

#define HITS_AT offsetof(square_sums, alpha)
#define HIT_BYTES (offsetof(square_sums, layers) - HITS_AT)

static size_t hit_bytes(film_parts parts) { return parts.hits ? HIT_BYTES : 0; }

static size_t layer_bytes(film_parts parts) { return film_part_sums(parts) * RGB_BYTES; }

static size_t matte_bytes(film_parts parts) { return parts.matte_count * LANES * sizeof(matte_list); }

/* Order: the groups in use, then the hits, the layers and cascades, and the mattes, if any. */
size_t sum_bytes(uint32_t groups, film_parts parts) {
    return groups * RGB_BYTES + hit_bytes(parts) + layer_bytes(parts) + matte_bytes(parts);
}

void sum_save(const square_sums *from, uint32_t groups, film_parts parts, unsigned char *out) {
    memcpy(out, from->rgb, groups * RGB_BYTES);
    out += groups * RGB_BYTES;
    memcpy(out, (const char *)from + HITS_AT, hit_bytes(parts));
    out += hit_bytes(parts);
    if (layer_bytes(parts)) memcpy(out, from->layers, layer_bytes(parts));
    if (parts.matte_count) memcpy(out + layer_bytes(parts), from->mattes, matte_bytes(parts));
}

void sum_load(const unsigned char *in, uint32_t groups, film_parts parts, square_sums *to) {
    memcpy(to->rgb, in, groups * RGB_BYTES);
    in += groups * RGB_BYTES;
    memcpy((char *)to + HITS_AT, in, hit_bytes(parts));
    in += hit_bytes(parts);
    if (layer_bytes(parts)) memcpy(to->layers, in, layer_bytes(parts));
    if (parts.matte_count) memcpy(to->mattes, in + layer_bytes(parts), matte_bytes(parts));
}
