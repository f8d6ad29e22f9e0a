/* Error bounds below count roundings of u = 2^-24. For flat primitives two things keep a leaving ray from
 * meeting its own surface again. First, p is off the plane by the roundings of the weighted sum of the
 * corners: at most 6 u of the largest corner coordinate on each axis. Second, an intersector that starts
 * beside the surface sees the corners relative to the origin, each rounded, and takes dot products of them:
 * the plane's distance comes out wrong by up to 8 u of the primitive's extent. Both are doubled for the
 * products of errors left out, and for the addition that moves the origin. */
#include "render/local_hit.h"

#include "reference/reference.h"

static const float unit_round = 0x1p-24f;

static float largest3(float a, float b, float c) {
    a = fabsf(a), b = fabsf(b), c = fabsf(c);
    return a > b ? (a > c ? a : c) : (b > c ? b : c);
}

static float largest(vec3_f32 v) { return largest3(v.x, v.y, v.z); }

/* v / |v|. Where the square would leave the range of float, v is first multiplied by a power of two, which is
 * exact: a scene of another size gets the same bits. */
static vec3_f32 unit_of(vec3_f32 v) {
    float square = dot_f32(v, v);
    if (!(square > 0x1p-100f && square < 0x1p100f)) {
        int exponent;
        frexpf(largest(v), &exponent);
        /* In two halves: the whole power may itself be out of range. */
        v = scale_f32(ldexpf(1, -exponent / 2), scale_f32(ldexpf(1, -exponent - (-exponent / 2)), v));
        square = dot_f32(v, v);
    }
    return square > 0 ? scale_f32(1 / sqrtf(square), v) : v;
}

static vec3_f32 flat_error(vec3_f32 corner_size, float extent) {
    float beside = 16 * unit_round * extent;
    return (vec3_f32){12 * unit_round * corner_size.x + beside, 12 * unit_round * corner_size.y + beside,
                      12 * unit_round * corner_size.z + beside};
}

/* The point nearest to the centre on a ray that, recomputed, just misses: its tangent point. */
static float tangent_t(const world_sphere *sphere, const local_ray *ray) {
    return dot_f32(sub_f32(sphere->center, ray->org), ray->dir) / dot_f32(ray->dir, ray->dir);
}

/* p = C + R n with n the unit vector to the hit: 4 roundings of R, one of the sum; an intersector's c = |f|^2
 * - R^2 loses 8 u R^2, which is 4 u R of distance. */
void local_sphere(const world_sphere *sphere, const local_ray *ray, local_hit *out) {
    float t;
    if (!sphere_robust_f32(sphere->center, sphere->radius, ray->org, ray->dir, ray->t_near, INFINITY, &t)) {
        t = tangent_t(sphere, ray);
    }
    vec3_f32 n = unit_of(madd_f32(sub_f32(ray->org, sphere->center), t, ray->dir));
    float own = 16 * unit_round * sphere->radius;
    vec3_f32 c = sphere->center;
    *out = (local_hit){.p = madd_f32(c, sphere->radius, n),
                       .ng = n,
                       .ns = n,
                       .error = {own + 4 * unit_round * fabsf(c.x), own + 4 * unit_round * fabsf(c.y),
                                 own + 4 * unit_round * fabsf(c.z)}};
}

static float clamp_unit(float x) { return x > 0 ? (x < 1 ? x : 1) : 0; }

/* The half of the quad on this side of the diagonal is a triangle: corner + weights times its two sides. */
static vec3_f32 quad_point(const world_quad *q, float u, float v) {
    const vec3_f32 *c = q->corner;
    if (u + v <= 1) return madd_f32(madd_f32(scale_f32(1 - u - v, c[0]), u, c[1]), v, c[3]);
    return madd_f32(madd_f32(scale_f32(u + v - 1, c[2]), 1 - u, c[3]), 1 - v, c[1]);
}

void local_quad(const world_quad *quad, const local_ray *ray, local_hit *out) {
    const vec3_f32 *c = quad->corner;
    reference_hit_f32 hit = {0};
    if (!quad_robust_f32(c[0], c[1], c[2], c[3], ray->org, ray->dir, ray->t_near, INFINITY, &hit) &&
        !quad_textbook_f32(c[0], c[1], c[2], c[3], ray->org, ray->dir, ray->t_near, INFINITY, &hit)) {
        hit.u = clamp_unit(hit.u), hit.v = clamp_unit(hit.v);
    }
    vec3_f32 side = sub_f32(c[1], c[0]), other = sub_f32(c[3], c[0]), diagonal = sub_f32(c[2], c[0]);
    vec3_f32 n = unit_of(cross_f32(side, other));
    vec3_f32 size = {fmaxf(largest3(c[0].x, c[1].x, c[2].x), fabsf(c[3].x)),
                     fmaxf(largest3(c[0].y, c[1].y, c[2].y), fabsf(c[3].y)),
                     fmaxf(largest3(c[0].z, c[1].z, c[2].z), fabsf(c[3].z))};
    float extent = largest3(largest(side), largest(other), largest(diagonal));
    *out =
        (local_hit){.p = quad_point(quad, hit.u, hit.v), .ng = n, .ns = n, .error = flat_error(size, extent)};
}

static vec3_f32 vector_at(const float *base, size_t stride, uint32_t i) {
    return load_f32((const float *)(const void *)((const char *)base + stride * i));
}

/* Weights of the second and third corner (Möller and Trumbore 1997), clamped into the triangle: a tracer with
 * other arithmetic may have found a point that falls a rounding outside. */
static void triangle_weights(vec3_f32 a, vec3_f32 ab, vec3_f32 ac, const local_ray *ray, float *u, float *v) {
    vec3_f32 from_a = sub_f32(ray->org, a), across = cross_f32(ray->dir, ac), along = cross_f32(from_a, ab);
    float determinant = dot_f32(ab, across);
    if (determinant == 0) {
        *u = *v = 1 / 3.0f;
        return;
    }
    *u = clamp_unit(dot_f32(from_a, across) / determinant);
    *v = clamp_unit(dot_f32(ray->dir, along) / determinant);
    float sum = *u + *v;
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
        normal[k] = unit_of(vector_at(mesh->normals, mesh->normal_stride, index[k]));
        sum = madd_f32(sum, weight[k], normal[k]);
    }
    /* Normals that cancel say nothing: the facet is then as flat as it looks. */
    if (!(dot_f32(sum, sum) > 0x1p-40f)) return;
    out->ns = unit_of(sum);
    if (!lift) return;
    out->smooth = true;
    /* Windings and normals may disagree on the outside: the normals' own side counts here. */
    float side = dot_f32(out->ns, out->ng) < 0 ? -1.0f : 1.0f;
    out->lift = lifted(out->p, corner, normal, weight, side);
    out->lift_inside = lifted(out->p, corner, normal, weight, -side);
}

void local_triangle(const fathom_mesh *mesh, uint32_t triangle, const local_ray *ray, bool lift,
                    local_hit *out) {
    const uint32_t *index = mesh->indices + 3 * (size_t)triangle;
    vec3_f32 c[3];
    for (int k = 0; k < 3; ++k) c[k] = vector_at(mesh->positions, mesh->position_stride, index[k]);
    vec3_f32 ab = sub_f32(c[1], c[0]), ac = sub_f32(c[2], c[0]);
    float weight[3];
    triangle_weights(c[0], ab, ac, ray, &weight[1], &weight[2]);
    weight[0] = 1 - weight[1] - weight[2];
    vec3_f32 n = unit_of(cross_f32(ab, ac));
    vec3_f32 size = {largest3(c[0].x, c[1].x, c[2].x), largest3(c[0].y, c[1].y, c[2].y),
                     largest3(c[0].z, c[1].z, c[2].z)};
    *out = (local_hit){.p = madd_f32(madd_f32(scale_f32(weight[0], c[0]), weight[1], c[1]), weight[2], c[2]),
                       .ng = n,
                       .ns = n,
                       .error = flat_error(size, fmaxf(largest(ab), largest(ac)))};
    if (mesh->normals) smooth_normals(mesh, triangle, c, weight, lift, out);
}

/* The point is put back on the plane: what is left is the rounding of normal·p and of the offset. */
void local_plane(const world_plane *plane, const local_ray *ray, local_hit *out) {
    vec3_f32 n = plane->normal;
    float t = (plane->offset - dot_f32(n, ray->org)) / dot_f32(n, ray->dir);
    vec3_f32 p = madd_f32(ray->org, t, ray->dir);
    p = madd_f32(p, plane->offset - dot_f32(n, p), n);
    float own = 16 * unit_round * (fabsf(plane->offset) + largest(p));
    *out = (local_hit){.p = p, .ng = n, .ns = n, .error = {own, own, own}};
}
