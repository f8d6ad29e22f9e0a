/* Points are computed in double, so that what is left of their error is a matter of how they are used: see
 * surface_point.c. `beside` is what an intersector itself may be wrong about. */
#include "render/local_hit.h"

#include "reference/reference.h"

/* Near its plane a triangle of side L and normal n is told from a ray by t = n·v / n·d, the corners v seen
 * from the start: each is off by u L, each term of n and of the two products by some units of L², L³. Were
 * all roundings at their worst and of one sign, 26 u L² / |n| sides of distance could be lost
 * (parity/verdict_bound.c), 30 u L for an equilateral one. They are not: of 1e7 rays from triangles up to
 * four times as long as wide none needs more than 2 u L, neither by our form nor by Embree's
 * (bench/offset.sh). Six times that is taken; and all of it, with the point's own rounding, stays below 32
 * units. Slivers would need more, as the inverse of their width: bench/README.md says how many of their rays
 * meet them again. */
static const double face_beside = 12 * 0x1p-24;

static double largest3(double a, double b, double c) { return fmax(fabs(a), fmax(fabs(b), fabs(c))); }

static double largest(vec3_f64 v) { return largest3(v.x, v.y, v.z); }

/* v / |v|: the squares of what is computed of floats stay in the range of double. */
static vec3_f64 unit_of(vec3_f64 v) {
    double square = dot_f64(v, v);
    return square > 0 ? scale_f64(1 / sqrt(square), v) : v;
}

/* The same in float. Where the square would leave its range, v is first multiplied by a power of two, which
 * is exact: a scene of another size gets the same bits. */
static vec3_f32 unit_of_f32(vec3_f32 v) {
    float square = dot_f32(v, v);
    if (!(square > 0x1p-100f && square < 0x1p100f)) {
        int exponent;
        frexpf(largest_f32(v), &exponent);
        /* In two halves: the whole power may itself be out of range. */
        v = scale_f32(ldexpf(1, -exponent / 2), scale_f32(ldexpf(1, -exponent - (-exponent / 2)), v));
        square = dot_f32(v, v);
    }
    return square > 0 ? scale_f32(1 / sqrtf(square), v) : v;
}

/* Whether a ray starts inside is decided in double wherever float is in doubt, and for split spheres
 * (sphere_text.h), by c = |f|² - R²: near the surface it is off by 6 (|f|² + R²) 2^-53, which is 6 R 2^-53 of
 * distance. f and the point here are off by a few 2^-53 of |C| + R more. */
void local_sphere(const world_sphere *sphere, const local_ray *ray, local_hit *out) {
    vec3_f64 c = world_sphere_center(sphere);
    double radius = world_sphere_radius(sphere), roots[2];
    bool sure;
    vec3_f64 from = sub_f64(ray->org, c);
    /* A ray that, recomputed, just misses: the point nearest to the centre. */
    double t = -dot_f64(from, ray->dir) / dot_f64(ray->dir, ray->dir);
    if (sphere_plain_f64(c, radius, ray->org, ray->dir, roots, &sure)) {
        t = roots[0] > (double)ray->t_near ? roots[0] : roots[1];
    }
    vec3_f64 n = unit_of(madd_f64(from, t, ray->dir));
    *out = (local_hit){
        .p = madd_f64(c, radius, n), .n = n, .ns = narrow(n), .beside = 16 * 0x1p-53 * (largest(c) + radius)};
}

static double clamp_unit(double x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* The corner-weighted point of a face, and how far from its plane a ray that starts there may seem to start.
 */
static void set_face(vec3_f64 a, vec3_f64 ab, vec3_f64 ac, double u, double v, local_hit *out) {
    vec3_f64 n = unit_of(cross_f64(ab, ac));
    double extent = fmax(largest(sub_f64(ac, ab)), fmax(largest(ab), largest(ac)));
    *out = (local_hit){
        .p = madd_f64(madd_f64(a, u, ab), v, ac), .n = n, .ns = narrow(n), .beside = face_beside * extent};
}

/* A half of the quad is a triangle of its own, with a plane of its own where rounding has bent the quad. */
void local_quad(const world_quad *quad, const local_ray *ray, local_hit *out) {
    vec3_f32 org = narrow(ray->org), dir = narrow(ray->dir);
    const vec3_f32 *c = quad->corner;
    reference_hit_f32 hit = {0};
    if (!quad_robust_f32(c[0], c[1], c[2], c[3], org, dir, ray->t_near, INFINITY, &hit) &&
        !quad_textbook_f32(c[0], c[1], c[2], c[3], org, dir, ray->t_near, INFINITY, &hit)) {
        hit.u = (float)clamp_unit((double)hit.u), hit.v = (float)clamp_unit((double)hit.v);
    }
    double u = (double)hit.u, v = (double)hit.v;
    bool second = hit.u + hit.v > 1;
    if (second) u = 1 - u, v = 1 - v;
    vec3_f64 a = widen(c[second ? 2 : 0]), b = widen(c[second ? 3 : 1]), d = widen(c[second ? 1 : 3]);
    set_face(a, sub_f64(b, a), sub_f64(d, a), u, v, out);
}

static vec3_f32 vector_at(const float *base, size_t stride, uint32_t i) {
    return load_f32((const float *)(const void *)((const char *)base + stride * i));
}

/* Weights of the second and third corner (Möller and Trumbore 1997), clamped into the triangle: a tracer with
 * other arithmetic may have found a point that falls a rounding outside. */
static void triangle_weights(vec3_f64 a, vec3_f64 ab, vec3_f64 ac, const local_ray *ray, double *u,
                             double *v) {
    vec3_f64 from_a = sub_f64(ray->org, a), across = cross_f64(ray->dir, ac), along = cross_f64(from_a, ab);
    double determinant = dot_f64(ab, across);
    if (determinant == 0) {
        *u = *v = 1 / 3.0;
        return;
    }
    *u = clamp_unit(dot_f64(from_a, across) / determinant);
    *v = clamp_unit(dot_f64(ray->dir, along) / determinant);
    double sum = *u + *v;
    if (sum > 1) *u /= sum, *v /= sum;
}

/* Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II (2021): p plus the weighted mean of its
 * distances to the tangent planes at the corners, where those lie above it. side: 1 for a viewer outside, -1
 * inside. */
static vec3_f32 lifted(vec3_f32 p, const vec3_f32 corner[3], const vec3_f32 normal[3], const float weight[3],
                       float side) {
    vec3_f32 lift = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        float above = side * dot_f32(sub_f32(p, corner[k]), normal[k]);
        if (above < 0) lift = madd_f32(lift, -weight[k] * above * side, normal[k]);
    }
    return lift;
}

static void smooth_normals(const fathom_mesh *mesh, uint32_t triangle, const vec3_f32 corner[3],
                           const float weight[3], bool lift, local_hit *out) {
    const uint32_t *index =
        (mesh->normal_indices ? mesh->normal_indices : mesh->indices) + 3 * (size_t)triangle;
    vec3_f32 normal[3], sum = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
        normal[k] = unit_of_f32(vector_at(mesh->normals, mesh->normal_stride, index[k]));
        sum = madd_f32(sum, weight[k], normal[k]);
    }
    /* Normals that cancel say nothing: the facet is then as flat as it looks. */
    if (!(dot_f32(sum, sum) > 0x1p-40f)) return;
    out->ns = unit_of_f32(sum);
    if (!lift) return;
    out->smooth = true;
    /* Windings and normals may disagree on the outside: the normals' own side counts here. */
    float side = dot_f64(widen(out->ns), out->n) < 0 ? -1.0f : 1.0f;
    vec3_f32 p = narrow(out->p);
    out->lift = lifted(p, corner, normal, weight, side);
    out->lift_inside = lifted(p, corner, normal, weight, -side);
}

void local_triangle(const fathom_mesh *mesh, uint32_t triangle, const local_ray *ray, bool lift,
                    local_hit *out) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    vec3_f32 c[3];
    for (int k = 0; k < 3; ++k) c[k] = vector_at(mesh->positions, mesh->position_stride, index[k]);
    vec3_f64 a = widen(c[0]), ab = sub_f64(widen(c[1]), a), ac = sub_f64(widen(c[2]), a);
    double u, v;
    triangle_weights(a, ab, ac, ray, &u, &v);
    set_face(a, ab, ac, u, v, out);
    const float weight[3] = {(float)(1 - u - v), (float)u, (float)v};
    if (mesh->normals) smooth_normals(mesh, triangle, c, weight, lift, out);
}

/* On which side of a plane a ray starts is decided in double wherever float is in doubt (quad_text.h). */
void local_plane(const world_plane *plane, const local_ray *ray, local_hit *out) {
    vec3_f64 n = widen(plane->normal), point = widen(plane->point);
    double along = dot_f64(n, ray->dir), t = dot_f64(n, sub_f64(point, ray->org)) / along;
    vec3_f64 p = madd_f64(ray->org, along != 0 ? t : 0, ray->dir);
    p = madd_f64(p, dot_f64(n, sub_f64(point, p)) / dot_f64(n, n), n);
    *out = (local_hit){
        .p = p, .n = unit_of(n), .ns = plane->normal, .beside = 16 * 0x1p-53 * (largest(point) + largest(p))};
}
