#include "job/checkpoint/checkpoint_state.h"

#include <stdlib.h>
#include <string.h>

static uint32_t minimum(uint32_t a, uint32_t b) { return a < b ? a : b; }
static uint32_t maximum(uint32_t a, uint32_t b) { return a > b ? a : b; }

static uint32_t waves_across(uint32_t begin, uint32_t length) {
    return (begin + length + WAVE_SIDE - 1) / WAVE_SIDE - begin / WAVE_SIDE;
}

bool checkpoint_state_create(const fathom_settings *settings, const fathom_film *film, bool hits,
                             checkpoint_state *out) {
    *out = (checkpoint_state){.hits = hits, .spp = settings->spp};
    checkpoint_grid *grid = &out->grid;
    grid->first_x = film->x / WAVE_SIDE * WAVE_SIDE, grid->first_y = film->y / WAVE_SIDE * WAVE_SIDE;
    grid->across = waves_across(film->x, film->width);
    grid->count = grid->across * waves_across(film->y, film->height);
    out->squares = calloc(grid->count, sizeof *out->squares);
    out->records = calloc(grid->count, sizeof *out->records);
    if (out->squares && out->records) return true;
    checkpoint_state_destroy(out);
    return false;
}

void checkpoint_state_destroy(checkpoint_state *state) {
    for (uint32_t i = 0; i < state->grid.count && state->records; ++i) free(state->records[i]);
    free(state->records);
    free(state->squares);
    *state = (checkpoint_state){.squares = NULL};
}

uint32_t checkpoint_wave_at(const checkpoint_grid *grid, uint32_t x, uint32_t y) {
    return (y - grid->first_y) / WAVE_SIDE * grid->across + (x - grid->first_x) / WAVE_SIDE;
}

/* Of a square, in the image; what the film shows of it is from (x0, y0) up to but without (x1, y1). */
typedef struct part {
    uint32_t left, top, x0, y0, x1, y1;
} part;

static part shown_part(const checkpoint_grid *grid, const fathom_film *film, uint32_t place,
                       unsigned square) {
    part p;
    p.left = grid->first_x + place % grid->across * WAVE_SIDE + square % 8 * 4;
    p.top = grid->first_y + place / grid->across * WAVE_SIDE + square / 8 * 4;
    p.x0 = maximum(p.left, film->x), p.x1 = minimum(p.left + 4, film->x + film->width);
    p.y0 = maximum(p.top, film->y), p.y1 = minimum(p.top + 4, film->y + film->height);
    return p;
}

static uint32_t area(const part *p) {
    return p->x0 < p->x1 && p->y0 < p->y1 ? (p->x1 - p->x0) * (p->y1 - p->y0) : 0;
}

uint64_t checkpoint_shown(const checkpoint_grid *grid, const fathom_film *film, uint32_t place) {
    uint64_t shown = 0;
    for (unsigned s = 0; s < WAVE_SQUARES; ++s) {
        const part p = shown_part(grid, film, place, s);
        shown |= (uint64_t)(area(&p) > 0) << s;
    }
    return shown;
}

uint64_t checkpoint_pixels(const checkpoint_grid *grid, const fathom_film *film, uint32_t place,
                           uint64_t squares) {
    uint64_t pixels = 0;
    for (; squares; squares &= squares - 1) {
        const part p = shown_part(grid, film, place, (unsigned)__builtin_ctzll(squares));
        pixels += area(&p);
    }
    return pixels;
}

static char *pixels_of(const fathom_film *film, uint32_t channel, uint32_t x, uint32_t y) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    return (char *)film->channels[channel].data + pixel * sizeof(float);
}

void checkpoint_square_save(const checkpoint_grid *grid, const fathom_film *film, uint32_t place,
                            unsigned square, uint32_t channel, uint32_t out[LANES]) {
    const part p = shown_part(grid, film, place, square);
    if (area(&p) < LANES) memset(out, 0, LANES * sizeof *out);
    for (uint32_t y = p.y0; y < p.y1; ++y) {
        memcpy(out + (y - p.top) * 4 + (p.x0 - p.left), pixels_of(film, channel, p.x0, y),
               (p.x1 - p.x0) * sizeof *out);
    }
}

void checkpoint_square_load(const checkpoint_grid *grid, const fathom_film *film, uint32_t place,
                            unsigned square, uint32_t channel, const uint32_t in[LANES]) {
    const part p = shown_part(grid, film, place, square);
    for (uint32_t y = p.y0; y < p.y1; ++y) {
        memcpy(pixels_of(film, channel, p.x0, y), in + (y - p.top) * 4 + (p.x0 - p.left),
               (p.x1 - p.x0) * sizeof *in);
    }
}
