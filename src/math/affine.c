#include "math/affine.h"

affine_f64 affine_identity(void) { return (affine_f64){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}; }

void affine_load(affine_f64 *out, const double rows[12]) {
    for (int i = 0; i < 12; ++i) out->m[i / 4][i % 4] = rows[i];
}

affine_f64 affine_translation(vec3_f64 t) {
    return (affine_f64){{{1, 0, 0, t.x}, {0, 1, 0, t.y}, {0, 0, 1, t.z}}};
}

affine_f64 affine_scaling(vec3_f64 s) {
    return (affine_f64){{{s.x, 0, 0, 0}, {0, s.y, 0, 0}, {0, 0, s.z, 0}}};
}

affine_f64 affine_rotation(const double q[4]) {
    double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], s = 2 / n;
    double x = q[0], y = q[1], z = q[2], w = q[3];
    return (affine_f64){{{1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), 0},
                         {s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w), 0},
                         {s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y), 0}}};
}

affine_f64 affine_rotation_axis(vec3_f64 axis, double angle) {
    vec3_f64 a = scale_f64(sin(angle / 2), normalize_f64(axis));
    return affine_rotation((double[4]){a.x, a.y, a.z, cos(angle / 2)});
}

affine_f64 affine_compose(const affine_f64 *a, const affine_f64 *b) {
    affine_f64 out;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j) {
            double sum = j == 3 ? a->m[i][3] : 0;
            for (int k = 0; k < 3; ++k) sum += a->m[i][k] * b->m[k][j];
            out.m[i][j] = sum;
        }
    }
    return out;
}

/* Inverts by cofactors. The columns and then the rows are first scaled to unit length, so that the
 * determinant of a map that rotates and scales neither underflows nor overflows. */
bool affine_invert(const affine_f64 *a, affine_f64 *out) {
    double column[3], row[3];
    vec3_f64 r[3];
    for (int j = 0; j < 3; ++j) {
        column[j] = length_f64((vec3_f64){a->m[0][j], a->m[1][j], a->m[2][j]});
        if (!(column[j] > 0) || !isfinite(column[j])) return false;
    }
    for (int i = 0; i < 3; ++i) {
        r[i] = (vec3_f64){a->m[i][0] / column[0], a->m[i][1] / column[1], a->m[i][2] / column[2]};
        row[i] = length_f64(r[i]);
        if (!(row[i] > 0)) return false;
        r[i] = (vec3_f64){r[i].x / row[i], r[i].y / row[i], r[i].z / row[i]};
    }
    vec3_f64 c[3] = {cross_f64(r[1], r[2]), cross_f64(r[2], r[0]), cross_f64(r[0], r[1])};
    double det = dot_f64(r[0], c[0]);
    /* With unit rows, |det| is the volume that they span. It has 16 rounding errors of 2^-53, so a smaller
     * value cannot be told from no volume. */
    if (!(fabs(det) > 0x1p-49)) return false;
    for (int j = 0; j < 3; ++j) {
        double s = 1 / (det * row[j]);
        out->m[0][j] = c[j].x * s / column[0];
        out->m[1][j] = c[j].y * s / column[1];
        out->m[2][j] = c[j].z * s / column[2];
    }
    vec3_f64 t = affine_vector(out, (vec3_f64){a->m[0][3], a->m[1][3], a->m[2][3]});
    out->m[0][3] = -t.x;
    out->m[1][3] = -t.y;
    out->m[2][3] = -t.z;
    return finite_f64(t) && isfinite(out->m[0][0]) && isfinite(out->m[1][1]) && isfinite(out->m[2][2]);
}

bool affine_is_identity(const affine_f64 *a) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 4; ++j)
            if (a->m[i][j] != (i == j ? 1.0 : 0.0)) return false;
    }
    return true;
}
