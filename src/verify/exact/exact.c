#include "verify/exact/exact.h"

/* A ray in the primitive's space, and the primitive's points relative to the ray's origin. */
typedef struct exact_view {
    integer dir[3], from_org[3][3]; /* from_org: the corners; of spheres and planes only the first */
    int point_exponent, dir_exponent;
} exact_view;

/* One coordinate, as a sum of up to four terms. */
typedef struct dyadic_sum {
    dyadic term[4];
    int count;
} dyadic_sum;

static void add_term(dyadic_sum *sum, dyadic a, dyadic b) {
    if (a.m != 0 && b.m != 0) sum->term[sum->count++] = (dyadic){a.m * b.m, a.e + b.e};
}

static dyadic_sum coordinate(const world_instance *instance, int row, vec3_f32 v, float w) {
    dyadic_sum sum = {.count = 0};
    const float p[4] = {v.x, v.y, v.z, w};
    const dyadic one = {1, 0};
    if (!instance) {
        add_term(&sum, dyadic_of(p[row]), one);
        return sum;
    }
    for (int i = 0; i < 4; ++i) add_term(&sum, dyadic_of(instance->to_object[row][i]), dyadic_of(p[i]));
    return sum;
}

static void lower_exponent(int *exponent, const dyadic_sum *sum) {
    for (int i = 0; i < sum->count; ++i) {
        if (sum->term[i].e < *exponent) *exponent = sum->term[i].e;
    }
}

/* *r += sign 2^-exponent sum */
static void accumulate(integer *r, const dyadic_sum *sum, int exponent, int sign) {
    integer term;
    integer_init(&term);
    for (int i = 0; i < sum->count; ++i) {
        mpz_set_si(term.z, sign * sum->term[i].m);
        mpz_mul_2exp(term.z, term.z, (mp_bitcnt_t)(sum->term[i].e - exponent));
        mpz_add(r->z, r->z, term.z);
    }
}

/* A coordinate of point k; the centre of a sphere has two terms. */
static dyadic_sum point_of(const oracle_primitive *primitive, int k, int row) {
    dyadic_sum sum = coordinate(NULL, row, primitive->v[k], 0);
    if (primitive->shape == ORACLE_SPHERE) {
        const float rest[3] = {primitive->rest.x, primitive->rest.y, primitive->rest.z};
        add_term(&sum, dyadic_of(rest[row]), (dyadic){1, 0});
    }
    return sum;
}

/* The radius of a sphere, which must be an integer in the scale of points; 0 for other shapes. */
static dyadic_sum radius_of(const oracle_primitive *primitive) {
    dyadic_sum sum = {.count = 0};
    if (primitive->shape != ORACLE_SPHERE) return sum;
    add_term(&sum, dyadic_of(primitive->radius), (dyadic){1, 0});
    add_term(&sum, dyadic_of(primitive->radius_rest), (dyadic){1, 0});
    return sum;
}

static void view(const oracle_ray *ray, const oracle_primitive *primitive, int points, exact_view *out) {
    dyadic_sum org[3], dir[3], point[3][3], radius = radius_of(primitive);
    int pe = 1000, de = 1000;
    lower_exponent(&pe, &radius);
    for (int i = 0; i < 3; ++i) {
        org[i] = coordinate(primitive->instance, i, ray->org, 1);
        dir[i] = coordinate(primitive->instance, i, ray->dir, 0);
        lower_exponent(&pe, &org[i]);
        lower_exponent(&de, &dir[i]);
        for (int k = 0; k < points; ++k) {
            point[k][i] = point_of(primitive, k, i);
            lower_exponent(&pe, &point[k][i]);
        }
    }
    if (pe == 1000) pe = 0; /* only zeros */
    if (de == 1000) de = 0;
    for (int i = 0; i < 3; ++i) {
        integer_init(&out->dir[i]);
        accumulate(&out->dir[i], &dir[i], de, 1);
        for (int k = 0; k < points; ++k) {
            integer_init(&out->from_org[k][i]);
            accumulate(&out->from_org[k][i], &point[k][i], pe, 1);
            accumulate(&out->from_org[k][i], &org[i], pe, -1);
        }
    }
    out->point_exponent = pe, out->dir_exponent = de;
}

/* ---- spheres ---- */

typedef struct exact_sphere {
    integer a, b, D, r2; /* |d|², -f·d, b² - a (|f|² - R²) with f = E - C; R² */
    int scale;           /* t = 2^scale (b ± √D) / a */
} exact_sphere;

static void sphere_of(const oracle_ray *ray, const oracle_primitive *sphere, exact_sphere *out) {
    exact_view v;
    view(ray, sphere, 1, &v);
    integer radius, c, product;
    dyadic_sum r = radius_of(sphere);
    integer_init(&radius), integer_init(&product), integer_init(&out->r2), integer_init(&out->D);
    accumulate(&radius, &r, v.point_exponent, 1);
    mpz_mul(out->r2.z, radius.z, radius.z);
    integer_dot(&out->a, v.dir, v.dir);
    integer_dot(&out->b, v.from_org[0], v.dir); /* from_org is C - E */
    integer_dot(&c, v.from_org[0], v.from_org[0]);
    mpz_sub(c.z, c.z, out->r2.z);
    mpz_mul(product.z, out->a.z, c.z);
    mpz_mul(out->D.z, out->b.z, out->b.z);
    mpz_sub(out->D.z, out->D.z, product.z);
    out->scale = v.point_exponent - v.dir_exponent;
}

/* s = 0: the closest approach. */
static void root_of_sphere(const exact_sphere *sphere, int s, exact_root *out) {
    exact_root_set(out, &sphere->b, s, &sphere->D, &sphere->a, sphere->scale);
}

/* ---- triangles and planes ---- */

typedef struct exact_plane {
    integer edge[3];  /* triangles: d·(b×c) and so on */
    integer n, along; /* t = 2^scale n / along; along may have either sign */
    int scale;
} exact_plane;

/* With corners a, b, c relative to the origin: t = a·(b×c) / (d·(b×c) + d·(c×a) + d·(a×b)). */
static void triangle_of(const oracle_ray *ray, const oracle_primitive *triangle, exact_plane *out) {
    exact_view v;
    view(ray, triangle, 3, &v);
    integer_init(&out->along);
    for (int k = 0; k < 3; ++k) {
        integer cross[3];
        integer_cross(cross, v.from_org[(k + 1) % 3], v.from_org[(k + 2) % 3]);
        integer_dot(&out->edge[k], v.dir, cross);
        mpz_add(out->along.z, out->along.z, out->edge[k].z);
        if (k == 0) integer_dot(&out->n, v.from_org[0], cross);
    }
    out->scale = v.point_exponent - v.dir_exponent;
}

static void plane_of(const oracle_ray *ray, const oracle_primitive *plane, exact_plane *out) {
    exact_view v;
    view(ray, plane, 1, &v);
    const float n[3] = {plane->v[1].x, plane->v[1].y, plane->v[1].z};
    integer normal[3];
    for (int i = 0; i < 3; ++i) {
        dyadic d = dyadic_of(n[i]);
        integer_init(&normal[i]);
        mpz_set_si(normal[i].z, d.m);
        mpz_mul_2exp(normal[i].z, normal[i].z, (mp_bitcnt_t)(d.e + 149)); /* its length does not matter */
    }
    integer_dot(&out->n, v.from_org[0], normal);
    integer_dot(&out->along, v.dir, normal);
    out->scale = v.point_exponent - v.dir_exponent;
}

static void root_of_plane(const exact_plane *plane, exact_root *out) {
    exact_root_set(out, &plane->n, 0, NULL, &plane->along, plane->scale);
    if (mpz_sgn(out->q.z) > 0) return;
    mpz_neg(out->p.z, out->p.z);
    mpz_neg(out->q.z, out->q.z);
}

void exact_root_of(const oracle_ray *ray, const oracle_primitive *primitive, unsigned which,
                   exact_root *out) {
    if (primitive->shape == ORACLE_SPHERE) {
        exact_sphere sphere;
        sphere_of(ray, primitive, &sphere);
        root_of_sphere(&sphere, which ? 1 : -1, out);
        return;
    }
    exact_plane plane;
    (primitive->shape == ORACLE_PLANE ? plane_of : triangle_of)(ray, primitive, &plane);
    root_of_plane(&plane, out);
}

static real_f128 from_end(const exact_root *root, float end, int sign) {
    if (isinf(end)) return sign * (end < 0 ? HUGE_VAL : -HUGE_VAL);
    exact_root difference;
    exact_root_set(&difference, &root->p, root->s, &root->d, &root->q, 0);
    exact_root_subtract(&difference, dyadic_of(end));
    return sign * exact_root_real(&difference);
}

static void set_root(const oracle_ray *ray, const exact_root *root, unsigned i, solution *out) {
    out->t[i] = exact_root_real(root);
    out->above_near[i] = from_end(root, ray->t_near, 1);
    out->below_far[i] = from_end(root, ray->t_far, -1);
}

static void solve_sphere(const oracle_ray *ray, const oracle_primitive *primitive, solution *out) {
    exact_sphere sphere;
    exact_root root;
    sphere_of(ray, primitive, &sphere);
    out->parallel = mpz_sgn(sphere.a.z) == 0;
    if (out->parallel) return;
    integer whole;
    integer_init(&whole);
    mpz_mul(whole.z, sphere.a.z, sphere.r2.z);
    out->edge = integer_real(&sphere.D) / integer_real(&whole);
    out->roots = mpz_sgn(sphere.D.z) < 0 ? 0 : 2;
    if (!out->roots) {
        root_of_sphere(&sphere, 0, &root);
        out->t[0] = exact_root_real(&root);
        return;
    }
    for (unsigned i = 0; i < 2; ++i) {
        root_of_sphere(&sphere, i ? 1 : -1, &root);
        set_root(ray, &root, i, out);
    }
}

void exact_solve(const oracle_ray *ray, const oracle_primitive *primitive, solution *out) {
    if (primitive->shape == ORACLE_SPHERE) {
        solve_sphere(ray, primitive, out);
        return;
    }
    exact_plane plane;
    exact_root root;
    (primitive->shape == ORACLE_PLANE ? plane_of : triangle_of)(ray, primitive, &plane);
    out->parallel = mpz_sgn(plane.along.z) == 0;
    if (out->parallel) return;
    out->roots = 1;
    root_of_plane(&plane, &root);
    set_root(ray, &root, 0, out);
    if (primitive->shape == ORACLE_PLANE) return;
    const real_f128 along = integer_real(&plane.along);
    for (int k = 0; k < 3; ++k) out->weight[k] = integer_real(&plane.edge[k]) / along;
}
