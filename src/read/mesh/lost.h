/* Lost vertices: those without finite numbers, which scanners and simulations write. Readers store NaN for x,
 * y and z of one. polygon_split() makes all corners of a polygon that has one the same lost vertex. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Rows that triangles, lines or points have, one each; NULL: none. */
typedef struct lost_rows {
    void *rows;
    size_t bytes; /* of a row */
} lost_rows;

/* Leaves out the elements, of `each` vertices, that use a lost one. Their rows move with the others. Returns
 * how many remain. positions: x y z, tightly packed. */
size_t lost_drop(const float *positions, uint32_t *vertices, size_t each, size_t count,
                 const lost_rows others[2]);
/* The same for points without indices: their positions and colours. */
size_t lost_drop_points(float *positions, size_t count, const lost_rows *colors);
/* Moves the lost vertices, which nothing uses then, to another, so that they change no bounds. False if all
 * are lost. */
bool lost_mend(float *positions, size_t count);
