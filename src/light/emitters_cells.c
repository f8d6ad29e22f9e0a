/* Cells of faces whose emission varies over many texels, as that of screens and of windows at night. Each
 * cell is an emitter of its own: light samples then go where the image is bright, and none go to dark cells.
 *
 * Each level divides a triangle by the midpoints of its edges into those at its corners, 0 to 2, and the
 * middle one, 3. A cell's number has a digit of base 4 for each level, the largest triangle's first. */
#include "light/emitters_inner.h"

#define LEVEL_MOST 5            /* 1024 cells a triangle */
#define CELL_TEXELS 8           /* least side of a cell */
#define CELLS_MOST (1u << 16)   /* of a run */
#define CELLS_OF_ALL (1u << 18) /* of all runs */
/* Choosing among many cells may double the time of a light sample. So cells are made only if they halve
 * the mean square of uniform samples. */
#define UNEVEN 2

static bool is_quads(const emitters *e, const emitter_run *run) {
    return e->w->geometries.items[run->geometry].kind == WORLD_QUADS;
}

static uint32_t cells_of_half(const emitter_run *run) { return 1u << 2 * run->level; }

/* 1 if the run's faces are whole. */
static uint32_t cells_of(const emitters *e, const emitter_run *run) {
    return run->level && is_quads(e, run) ? 2 * cells_of_half(run) : cells_of_half(run);
}

bool emitters_is_quad(const emitters *e, const emitter_run *run) {
    return run->paired || (!run->level && is_quads(e, run));
}

uint32_t emitters_primitive(const emitters *e, const emitter_run *run, uint32_t index) {
    if (run->paired) return 2 * index;
    return run->level ? index / cells_of(e, run) : index;
}

bool emitters_is_second(const emitters *e, const emitter_run *run, uint32_t index) {
    return run->level && index % cells_of(e, run) >= cells_of_half(run);
}

/* ---- cutting ---- */

static vec3_f64 between(vec3_f64 a, vec3_f64 b) { return scale_f64(0.5, add_f64(a, b)); }

/* The digits of the cell are the lowest of the index. */
void emitters_divide(vec3_f64 c[3], const emitter_run *run, uint32_t index) {
    for (unsigned level = run->level; level-- > 0;) {
        const vec3_f64 ab = between(c[0], c[1]), bc = between(c[1], c[2]), ca = between(c[2], c[0]);
        switch (index >> 2 * level & 3) {
        case 0: c[1] = ab, c[2] = ca; break;
        case 1: c[0] = ab, c[2] = bc; break;
        case 2: c[0] = ca, c[1] = bc; break;
        case 3: c[0] = bc, c[1] = ca, c[2] = ab; break;
        }
    }
}

/* The cell in which a point lies that has these weights of the corners. */
static uint32_t cell_at(const float weight[3], unsigned level) {
    float w[3] = {weight[0], weight[1], weight[2]};
    uint32_t cell = 0;
    while (level-- > 0) {
        const uint32_t digit = w[0] > 0.5f ? 0 : w[1] > 0.5f ? 1 : w[2] > 0.5f ? 2 : 3;
        for (uint32_t k = 0; k < 3; ++k)
            w[k] = digit == 3 ? 1 - 2 * w[k] : k == digit ? 2 * w[k] - 1 : 2 * w[k];
        cell = cell << 2 | digit;
    }
    return cell;
}

void emitters_cut(const emitters *e, const emitter_run *run, uint32_t index, vec3_f64 c[4]) {
    if (!run->level) return;
    vec3_f64 half[3] = {c[0], c[1], c[3]};
    if (emitters_is_second(e, run, index)) half[0] = c[2], half[1] = c[3], half[2] = c[1];
    emitters_divide(half, run, index);
    c[0] = half[0], c[1] = half[1], c[2] = c[3] = half[2];
}

uint32_t emitters_index_at(const emitters *e, const emitter_run *run, uint32_t primitive,
                           const texturing_place *place) {
    const uint32_t half = place->second ? cells_of_half(run) : 0;
    return primitive * cells_of(e, run) + half + cell_at(place->weight, run->level);
}

/* ---- levels ---- */

/* The most texels along a side of a face of the run. */
static float texels_of(const emitters *e, const emitter_run *run) {
    float most = 0;
    for (uint32_t i = 0; i < run->count; ++i) {
        texturing_place place = emitters_place(e, run, i);
        for (int half = 0; half < (is_quads(e, run) ? 2 : 1); ++half) {
            place.second = half;
            most = fmaxf(most, texturing_emission_texels(e->texturing, &place));
        }
    }
    return most;
}

/* Compares the means of squares. The count is still that of the primitives. */
static bool is_uneven(const emitters *e, const emitter_run *run) {
    const uint32_t cells = cells_of(e, run);
    double squares = 0, even = 0;
    for (uint32_t i = 0; i < run->count; ++i) {
        double sum = 0;
        for (uint32_t k = 0; k < cells; ++k) {
            const double power = (double)emitters_varied_power(e, run, i * cells + k);
            squares += power * power * cells, sum += power;
        }
        even += sum * sum;
    }
    return squares > UNEVEN * even;
}

/* How often the sides of the largest face can be halved; 0: the run's faces stay whole. */
static unsigned levels_of(const emitters *e, const emitter_run *run) {
    const world_kind kind = e->w->geometries.items[run->geometry].kind;
    if (!run->count || kind == WORLD_SPHERES || run->count > CELLS_MOST / 4) return 0;
    const float texels = texels_of(e, run) / CELL_TEXELS;
    unsigned level = 0;
    while (level < LEVEL_MOST && texels >= (float)(2u << level)) ++level;
    return level;
}

static void divide_run(const emitters *e, emitter_run *run, uint64_t most) {
    const uint64_t halves = is_quads(e, run) ? 2 * (uint64_t)run->count : run->count;
    unsigned level = levels_of(e, run);
    while (level && halves << 2 * level > most) --level;
    run->level = (uint8_t)level;
    if (!level) return;
    if (is_uneven(e, run))
        run->count *= cells_of(e, run);
    else
        run->level = 0;
}

void emitters_divide_runs(emitters *e) {
    uint32_t count = 0;
    for (uint32_t r = 0; e->texturing && r < e->run_count; ++r) count += levels_of(e, &e->runs[r]) > 0;
    if (!count) return;
    const uint32_t share = CELLS_OF_ALL / count, most = share < CELLS_MOST ? share : CELLS_MOST;
    for (uint32_t r = 0; r < e->run_count; ++r) divide_run(e, &e->runs[r], most);
}
