#include "light/cube.h"

#include "base/threads.h"

#include <math.h>
#include <stdlib.h>

enum { FACES = 6, ACROSS = 3 /* directions, along a texel */ };

struct cube_layout {
    unsigned columns, rows; /* of squares */
    unsigned places[FACES]; /* of +x, -x, +y, -y, +z, -z: a square, counted along the rows */
    bool back_turned;       /* -z, by 180 degrees */
};

static const struct cube_layout layouts[] = {{4, 3, {6, 4, 1, 9, 5, 7}, false},
                                             {3, 4, {5, 3, 1, 7, 4, 10}, true},
                                             {6, 1, {0, 1, 2, 3, 4, 5}, false},
                                             {1, 6, {0, 1, 2, 3, 4, 5}, false}};

bool cube_find(uint32_t width, uint32_t height, cube *out) {
    for (size_t i = 0; i < sizeof layouts / sizeof *layouts; ++i) {
        const struct cube_layout *layout = &layouts[i];
        const uint32_t side = width / layout->columns;
        if (side && side * layout->columns == width && (uint64_t)side * layout->rows == height) {
            *out = (cube){layout, side};
            return true;
        }
    }
    return false;
}

bool cube_covers(const cube *c, uint32_t x, uint32_t y) {
    const unsigned place = y / c->side * c->layout->columns + x / c->side;
    for (unsigned face = 0; face < FACES; ++face) {
        if (c->layout->places[face] == place) return true;
    }
    return false;
}

/* The face of a direction, and the place on it in [-1,1], to the right and down. */
static unsigned face_of(vec3_f64 d, double *across, double *down) {
    const vec3_f64 r = {d.x, d.y, -d.z};
    const double x = fabs(r.x), y = fabs(r.y), z = fabs(r.z);
    if (x >= y && x >= z) {
        *across = -r.z / r.x, *down = -r.y / x;
        return r.x < 0;
    }
    if (y >= z) {
        *across = r.x / y, *down = r.z / r.y;
        return 2 + (r.y < 0);
    }
    *across = r.x / r.z, *down = -r.y / z;
    return 4 + (r.z < 0);
}

typedef struct unfolding {
    const cube *cube;
    const sky_texel *image;
    vec3_f64 *columns; /* directions on the horizon, ACROSS to each column of texels */
    sky_texel *out;
} unfolding;

static const float *texel_at(const unfolding *u, unsigned face, uint32_t x, uint32_t y) {
    const struct cube_layout *layout = u->cube->layout;
    const uint32_t side = u->cube->side, place = layout->places[face];
    if (face == 5 && layout->back_turned) x = side - 1 - x, y = side - 1 - y;
    const size_t row = (size_t)(place / layout->columns) * side + y;
    return u->image[row * layout->columns * side + (place % layout->columns) * side + x].rgb;
}

static void add_radiance(const unfolding *u, vec3_f64 direction, double sum[3]) {
    double across, down;
    const unsigned face = face_of(direction, &across, &down);
    const uint32_t last = u->cube->side - 1;
    const double s = fmin(fmax((across + 1) / 2 * u->cube->side - 0.5, 0), last),
                 t = fmin(fmax((down + 1) / 2 * u->cube->side - 0.5, 0), last);
    const uint32_t x = (uint32_t)s, y = (uint32_t)t, right = x < last ? x + 1 : x,
                   below = y < last ? y + 1 : y;
    const float *corners[4] = {texel_at(u, face, x, y), texel_at(u, face, right, y),
                               texel_at(u, face, x, below), texel_at(u, face, right, below)};
    for (int c = 0; c < 3; ++c) {
        const double top = (double)corners[0][c] + (s - x) * ((double)corners[1][c] - (double)corners[0][c]),
                     bottom =
                         (double)corners[2][c] + (s - x) * ((double)corners[3][c] - (double)corners[2][c]);
        sum[c] += top + (t - y) * (bottom - top);
    }
}

static void unfold_rows(void *user, size_t begin, size_t end) {
    const unfolding *u = user;
    const size_t width = 4 * (size_t)u->cube->side;
    for (size_t i = begin * width; i < end * width; ++i) {
        double sum[3] = {0};
        for (unsigned k = 0; k < ACROSS * ACROSS; ++k) {
            const double row = (double)(i / width * ACROSS + k / ACROSS) + 0.5;
            const vec3_f64 meridian = sky_direction(0.5, row / ((double)width / 2 * ACROSS)),
                           column = u->columns[i % width * ACROSS + k % ACROSS];
            const double around = -meridian.z;
            add_radiance(u, (vec3_f64){around * column.x, meridian.y, around * column.z}, sum);
        }
        for (int c = 0; c < 3; ++c) u->out[i].rgb[c] = (float)(sum[c] / (ACROSS * ACROSS));
    }
}

bool cube_unfold(const cube *c, const sky_texel *image, unsigned threads, sky_texel *out) {
    const size_t columns = 4 * (size_t)c->side * ACROSS;
    unfolding u = {c, image, malloc(columns * sizeof *u.columns), out};
    if (!u.columns) return false;
    for (size_t i = 0; i < columns; ++i)
        u.columns[i] = sky_direction(((double)i + 0.5) / (double)columns, 0.5);
    loop_parallel(threads, 2 * (size_t)c->side, 1, unfold_rows, &u);
    free(u.columns);
    return true;
}
