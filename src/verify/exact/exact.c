#include "verify/exact/exact.h"
#include "verify/exact/solution.h"

/* A ray in the primitive's space, and the primitive's points seen from its origin. */
typedef struct exact_view {
    integer dir[3], from_org[3][3]; /* from_org: the corners; of spheres and planes only the first */
    int point_exponent, dir_exponent;
} exact_view;

/* Up to four terms that make up one coordinate. */
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
    for (int i = 0; i < sum->count; ++i) {
        integer_set(&term, sign * sum->term[i].m, (unsigned)(sum->term[i].e - exponent));
        integer_add(r, r, &term);
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

/* The radius of a sphere, which must be whole in the scale of points; else 0. */
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
    if (pe == 1000) pe = 0; /* nothing but zeros */
    if (de == 1000) de = 0;
    for (int i = 0; i < 3; ++i) {
        out->dir[i].size = 0;
        accumulate(&out->dir[i], &dir[i], de, 1);
        for (int k = 0; k < points; ++k) {
            out->from_org[k][i].size = 0;
            accumulate(&out->from_org[k][i], &point[k][i], pe, 1);
            accumulate(&out->from_org[k][i], &org[i], pe, -1);
        }
    }
    out->point_exponent = pe, out->dir_exponent = de;
}

/* ---- spheres ---- */

typedef struct exact_sphere {
    integer a, b, D, r2; /* |d|², f·d, b² - a (|f|² - R²) with f = E - C; R² */
    int scale;           /* t = 2^scale (-b ± √D) / a */
} exact_sphere;

static void sphere_of(const oracle_ray *ray, const oracle_primitive *sphere, exact_sphere *out) {
    exact_view v;
    view(ray, sphere, 1, &v);
    integer radius, c, product;
    dyadic_sum r = radius_of(sphere);
    radius.size = 0;
    accumulate(&radius, &r, v.point_exponent, 1);
    integer_mul(&out->r2, &radius, &radius);
    integer_dot(&out->a, v.dir, v.dir);
    integer_dot(&out->b, v.from_org[0], v.dir);
    integer_negate(&out->b); /* from_org is C - E */
    integer_dot(&c, v.from_org[0], v.from_org[0]);
    integer_sub(&c, &c, &out->r2);
    integer_mul(&product, &out->a, &c);
    integer_mul(&out->D, &out->b, &out->b);
    integer_sub(&out->D, &out->D, &product);
    out->scale = v.point_exponent - v.dir_exponent;
}

/* s = 0: the closest approach. */
static void root_of_sphere(const exact_sphere *sphere, int s, exact_root *out) {
    integer_copy(&out->p, &sphere->b);
    integer_negate(&out->p);
    integer_copy(&out->q, &sphere->a);
    integer_copy(&out->d, &sphere->D);
    out->s = s;
    exact_root_scale(out, sphere->scale);
}

/* ---- triangles and planes ---- */

typedef struct exact_plane {
    integer edge[3];  /* triangles: d·(b×c) and so on */
    integer n, along; /* t = 2^scale n / along; along may have either sign */
    int scale;
} exact_plane;

/* Corners a, b, c as seen from the origin: t = a·(b×c) / (d·(b×c) + d·(c×a) + d·(a×b)). */
static void triangle_of(const oracle_ray *ray, const oracle_primitive *triangle, exact_plane *out) {
    exact_view v;
    view(ray, triangle, 3, &v);
    out->along.size = 0;
    for (int k = 0; k < 3; ++k) {
        integer cross[3];
        integer_cross(cross, v.from_org[(k + 1) % 3], v.from_org[(k + 2) % 3]);
        integer_dot(&out->edge[k], v.dir, cross);
        integer_add(&out->along, &out->along, &out->edge[k]);
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
        integer_set(&normal[i], d.m, (unsigned)(d.e + 149)); /* its length does not count */
    }
    integer_dot(&out->n, v.from_org[0], normal);
    integer_dot(&out->along, v.dir, normal);
    out->scale = v.point_exponent - v.dir_exponent;
}

static void root_of_plane(const exact_plane *plane, exact_root *out) {
    integer_copy(&out->p, &plane->n);
    integer_copy(&out->q, &plane->along);
    if (out->q.size < 0) {
        integer_negate(&out->p);
        integer_negate(&out->q);
    }
    out->s = 0;
    exact_root_scale(out, plane->scale);
}

/* ---- both ---- */

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

static ball from_end(const exact_root *root, float end, int sign) {
    if (isinf(end)) return (ball){sign * (end < 0 ? HUGE_VAL : -HUGE_VAL), 0};
    exact_root difference;
    integer_copy(&difference.p, &root->p);
    integer_copy(&difference.q, &root->q);
    if (root->s) integer_copy(&difference.d, &root->d);
    difference.s = root->s;
    exact_root_subtract(&difference, dyadic_of(end));
    ball distance = exact_root_ball(&difference);
    return sign < 0 ? ball_neg(distance) : distance;
}

static void set_root(const oracle_ray *ray, const exact_root *root, unsigned i, solution *out) {
    out->t[i] = exact_root_ball(root);
    out->above_near[i] = from_end(root, ray->t_near, 1);
    out->below_far[i] = from_end(root, ray->t_far, -1);
}

static void solve_sphere(const oracle_ray *ray, const oracle_primitive *primitive, solution *out) {
    exact_sphere sphere;
    exact_root root;
    sphere_of(ray, primitive, &sphere);
    out->parallel = sphere.a.size == 0;
    if (out->parallel) return;
    integer whole;
    integer_mul(&whole, &sphere.a, &sphere.r2);
    out->edge = ball_div(integer_ball(&sphere.D), integer_ball(&whole));
    out->roots = integer_sign(&sphere.D) < 0 ? 0 : 2;
    if (!out->roots) {
        root_of_sphere(&sphere, 0, &root);
        out->t[0] = exact_root_ball(&root);
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
    out->parallel = plane.along.size == 0;
    if (out->parallel) return;
    out->roots = 1;
    root_of_plane(&plane, &root);
    set_root(ray, &root, 0, out);
    if (primitive->shape == ORACLE_PLANE) return;
    ball along = integer_ball(&plane.along);
    for (int k = 0; k < 3; ++k) out->weight[k] = ball_div(integer_ball(&plane.edge[k]), along);
}
