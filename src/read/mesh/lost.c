#include "read/mesh/lost.h"

#include <math.h>
#include <string.h>

static bool uses_lost(const float *positions, const uint32_t *vertices, size_t count) {
    bool any = false;
    for (size_t i = 0; i < count; ++i) any |= isnan(positions[3 * (size_t)vertices[i]]) != 0;
    return any;
}

static void move(const lost_rows *of, size_t to, size_t from) {
    if (of->rows) memmove((char *)of->rows + of->bytes * to, (char *)of->rows + of->bytes * from, of->bytes);
}

size_t lost_drop(const float *positions, uint32_t *vertices, size_t each, size_t count,
                 const lost_rows others[2]) {
    const lost_rows own = {vertices, each * sizeof *vertices};
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        if (uses_lost(positions, vertices + each * i, each)) continue;
        move(&own, kept, i), move(&others[0], kept, i), move(&others[1], kept, i);
        ++kept;
    }
    return kept;
}

size_t lost_drop_points(float *positions, size_t count, const lost_rows *colors) {
    const lost_rows own = {positions, 3 * sizeof *positions};
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        if (isnan(positions[3 * i])) continue;
        move(&own, kept, i), move(colors, kept, i);
        ++kept;
    }
    return kept;
}

bool lost_mend(float *positions, size_t count) {
    size_t good = 0;
    while (good < count && isnan(positions[3 * good])) ++good;
    for (size_t i = 0; i < count && good < count; ++i) {
        if (isnan(positions[3 * i])) memcpy(positions + 3 * i, positions + 3 * good, 3 * sizeof *positions);
    }
    return good < count;
}
