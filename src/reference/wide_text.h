/* The fallbacks that the inline intersectors call in the next wider precision. Defined before: REAL, VEC3,
 * FN(name), and for the wider precision WIDE, WIDE_VEC3, WIDE_FN(name), WIDER(v) (converts a VEC3) and
 * WIDE_UNIT. */

static bool FN(plain_wide)(WIDE_VEC3 center, WIDE radius, VEC3 org, VEC3 dir, REAL roots[2]) {
    WIDE wide[2];
    bool sure;
    if (!WIDE_FN(sphere_plain)(center, radius, WIDER(org), WIDER(dir), wide, &sure)) return false;
    roots[0] = (REAL)wide[0], roots[1] = (REAL)wide[1];
    return true;
}

bool FN(sphere_roots_wide)(VEC3 center, REAL radius, VEC3 org, VEC3 dir, REAL roots[2]) {
    return FN(plain_wide)(WIDER(center), radius, org, dir, roots);
}

bool FN(sphere_roots_split)(const VEC3 center[2], const REAL radius[2], VEC3 org, VEC3 dir, REAL roots[2]) {
    WIDE_VEC3 c = WIDE_FN(add)(WIDER(center[0]), WIDER(center[1]));
    return FN(plain_wide)(c, (WIDE)radius[0] + (WIDE)radius[1], org, dir, roots);
}

bool FN(triangle_weights_wide)(VEC3 a, VEC3 b, VEC3 c, REAL weights[2]) {
    WIDE ax = a.x, ay = a.y, bx = b.x, by = b.y, cx = c.x, cy = c.y;
    WIDE u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax, sum = u + v + w;
    bool negative = u < 0 || v < 0 || w<0, positive = u> 0 || v > 0 || w > 0;
    if (negative == positive) return false; /* the signs differ, or the ray lies in the triangle's plane */
    weights[0] = (REAL)(v / sum), weights[1] = (REAL)(w / sum);
    return true;
}

bool FN(triangle_has_area_wide)(VEC3 a, VEC3 b, VEC3 c) {
    WIDE_VEC3 e = WIDE_FN(sub)(WIDER(b), WIDER(a)), g = WIDE_FN(sub)(WIDER(c), WIDER(a));
    return WIDE_FN(largest)(WIDE_FN(cross)(e, g)) > 8 * WIDE_UNIT * WIDE_FN(largest)(e) * WIDE_FN(largest)(g);
}

REAL FN(plane_wide)(VEC3 point, VEC3 normal, VEC3 org, VEC3 dir) {
    WIDE_VEC3 f = WIDE_FN(sub)(WIDER(point), WIDER(org));
    return (REAL)(WIDE_FN(dot)(f, WIDER(normal)) / WIDE_FN(dot)(WIDER(dir), WIDER(normal)));
}

#undef REAL
#undef VEC3
#undef FN
#undef WIDE
#undef WIDE_VEC3
#undef WIDE_FN
#undef WIDER
#undef WIDE_UNIT
