/* The maps of an instance, and the error bound for a tracer that inverts to_world itself in float.
 *
 * Let u = 2^-24. The inverse is the adjugate divided by the determinant. An entry of the adjugate is the
 * difference of two products. Its error is 2 u P, where P is the sum of their magnitudes. The determinant D
 * is the sum of three products of an entry of the matrix and one of the adjugate. Its error is 5 u S, where S
 * is the sum of the magnitudes of its six products. The reciprocal of D and the last product add rounding
 * errors of at most 4 u. So the error of an entry a of the inverse is 2 u P / |D| + |a| (5 S / |D| + 4) u,
 * and rounding to_object itself adds u |a|. */
#include "scene/world/world.h"

static const double unit_round = 0x1p-24;

/* P of entry (i, j) of the inverse. That entry is, divided by D, the determinant of all rows but j and all
 * columns but i, in cyclic order. */
static double minor_size(const affine_f64 *a, int i, int j) {
    int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
    return fabs(a->m[r][c] * a->m[s][d]) + fabs(a->m[r][d] * a->m[s][c]);
}

static void set_error(world_instance *instance, const affine_f64 *to_world, const affine_f64 *inverse) {
    double d = fabs(affine_determinant(to_world)), sum = 0;
    for (int j = 0; j < 3; ++j) sum += fabs(to_world->m[0][j]) * minor_size(to_world, j, 0);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            double entry = fabs(inverse->m[i][j]);
            instance->to_object_error[i][j] =
                (float)(unit_round * (2 * minor_size(to_world, i, j) / d + entry * (5 * sum / d + 5)));
        }
    }
}

/* Smaller numbers may be flushed to zero. */
static const double least = 0x1p-126;
/* In box tests, Embree raises components of a direction to a magnitude of at least 1e-18. If no vector grows
 * by more than this factor, a direction that is transformed to the object and back turns by at most 2^-24 of
 * its length. Then no product of three entries overflows. */
static const double growth_most = 0x1p35;

static double row_sum(const double row[4]) { return fabs(row[0]) + fabs(row[1]) + fabs(row[2]); }

/* Flushing to zero changes the products of a determinant by up to 6 `least`, which must be negligible
 * compared with 2^-24 of it. It changes an entry of the adjugate by up to 2 `least`, which must be negligible
 * compared with 2^-24 of the largest entry in its row. */
bool world_instance_fits_float(const world_instance *instance) {
    const affine_f64 map = affine_widen(instance->to_world);
    double d = fabs(affine_determinant(&map));
    if (!(d >= 8 * least / unit_round)) return false;
    for (int i = 0; i < 3; ++i) {
        const float *a = instance->to_object[i];
        double entry = fmax(fabs((double)a[0]), fmax(fabs((double)a[1]), fabs((double)a[2])));
        if (!(entry * d >= 2 * least / unit_round) || !(row_sum(map.m[i]) <= growth_most)) return false;
    }
    return true;
}

/* to_object is the inverse of the rounded to_world, so that both describe the same transform. */
bool world_instance_set(world_instance *instance, const affine_f64 *to_world) {
    affine_f64 rounded, inverse;
    for (int i = 0; i < 12; ++i) {
        instance->to_world[i / 4][i % 4] = (float)to_world->m[i / 4][i % 4];
        rounded.m[i / 4][i % 4] = (double)instance->to_world[i / 4][i % 4];
    }
    if (!affine_invert(&rounded, &inverse)) return false;
    for (int i = 0; i < 12; ++i) instance->to_object[i / 4][i % 4] = (float)inverse.m[i / 4][i % 4];
    set_error(instance, &rounded, &inverse);
    return true;
}
