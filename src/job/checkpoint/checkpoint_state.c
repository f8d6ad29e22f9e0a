#include "job/checkpoint/checkpoint_state.h"

#include <stdlib.h>
#include <string.h>

bool checkpoint_state_create(const fathom_settings *settings, const fathom_film *film, film_parts parts,
                             checkpoint_state *out) {
    *out = (checkpoint_state){.parts = parts, .spp = settings->spp};
    out->grid = film_waves(film);
    out->squares = calloc(out->grid.count, sizeof *out->squares);
    out->records = calloc(out->grid.count, sizeof *out->records);
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

uint64_t checkpoint_pixels(const wave_grid *grid, uint32_t wave, uint64_t squares) {
    const unit_result unit = {.region = wave_grid_region(grid, wave), .squares = squares};
    return unit_pixels(&unit);
}

/* A square in the image. The film shows its part [x0, x1) × [y0, y1). */
typedef struct part {
    uint32_t left, top, x0, y0, x1, y1;
} part;

static part shown_part(const wave_grid *grid, uint32_t wave, unsigned square) {
    const wave_region r = wave_grid_region(grid, wave);
    const wave_square s = wave_square_at(&r, square);
    return (part){s.left,
                  s.top,
                  max_u32(s.left, r.x0),
                  max_u32(s.top, r.y0),
                  min_u32(s.left + 4, r.x1),
                  min_u32(s.top + 4, r.y1)};
}

static bool is_whole(const part *p) { return p->x1 == p->x0 + 4 && p->y1 == p->y0 + 4; }

static char *pixels_of(const fathom_film *film, uint32_t channel, uint32_t x, uint32_t y) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    return (char *)film->channels[channel].data + pixel * sizeof(float);
}

/* Copies one channel of a square from the film to its 16 values, or back. */
static void copy_square(const part *p, const fathom_film *film, uint32_t channel, bool save,
                        unsigned char *values) {
    const size_t bytes = (p->x1 - p->x0) * sizeof(float);
    if (save && !is_whole(p)) memset(values, 0, LANES * sizeof(float));
    for (uint32_t y = p->y0; y < p->y1; ++y) {
        char *pixels = pixels_of(film, channel, p->x0, y);
        unsigned char *row = values + ((y - p->top) * 4 + (p->x0 - p->left)) * sizeof(float);
        memcpy(save ? (void *)row : pixels, save ? (void *)pixels : row, bytes);
    }
}

static void copy_squares(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                         bool save, unsigned char *values) {
    for (; squares; squares &= squares - 1) {
        const part p = shown_part(grid, wave, (unsigned)__builtin_ctzll(squares));
        for (uint32_t channel = 0; channel < film->channel_count; ++channel, values += LANES * sizeof(float))
            copy_square(&p, film, channel, save, values);
    }
}

size_t checkpoint_pixel_bytes(uint32_t channels, uint64_t squares) {
    return (size_t)__builtin_popcountll(squares) * channels * LANES * sizeof(float);
}

void checkpoint_pixels_save(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                            unsigned char *out) {
    copy_squares(grid, film, wave, squares, true, out);
}

void checkpoint_pixels_load(const wave_grid *grid, const fathom_film *film, uint32_t wave, uint64_t squares,
                            const unsigned char *in) {
    copy_squares(grid, film, wave, squares, false, (unsigned char *)(uintptr_t)in); /* is only read */
}
