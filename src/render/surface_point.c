/* Where a ray that leaves may start.
 *
 * With u = 2^-24 and the point known to the last digits of double, the start p + h n of a ray has each
 * coordinate rounded twice, by u |p_i| when p becomes float and by u |p_i + h n_i| when the ray is made; the
 * product h n_i and the float normal add 3 u h, and h is no more than some 30 u |p|. So the start strays by
 * at most Σ |n_i| 2 u |p_i| along the normal, and an eighth more covers what is of second order. To this
 * comes `beside`, how wrong the intersector may be about a start that it knows exactly.
 *
 * In an instance the start is carried to object space, o_i = Σ A_ij s_j + T_i, and rounded there. Our own
 * tracers do that with A and T = to_object as given and one rounding, u |o_i|. Embree inverts to_world in
 * float: its A is off by E_ij (to_object_error), and its T = -A t, with t the translation of to_world, by
 * that and by three roundings of its products; three more enter when the start is carried. As A s + T = A (s
 * - t), E counts by |s - t|: in all Σ_j E_ij |s_j - t_j| + 6 u Σ_j |A_ij| (|s_j| + |t_j|) on axis i. A
 * distance e along the object's normal n is e / |Aᵀn| in the world, whose normal is Aᵀn / |Aᵀn|. */
#include "render/surface_point.h"

static const double unit_round = 0x1p-24;

ray_hit ray_hit_load(const trace_block *b, size_t i) {
    return (ray_hit){.org = {b->rays.org_x[i], b->rays.org_y[i], b->rays.org_z[i]},
                     .dir = {b->rays.dir_x[i], b->rays.dir_y[i], b->rays.dir_z[i]},
                     .t_near = b->rays.t_near[i],
                     .geometry = b->hits.geometry[i],
                     .primitive = b->hits.primitive[i],
                     .instance = b->hits.instance[i]};
}

/* ---- maps in double ---- */

static vec3_f64 map_vector(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[0][1] * v.y + (double)m[0][2] * v.z,
                      (double)m[1][0] * v.x + (double)m[1][1] * v.y + (double)m[1][2] * v.z,
                      (double)m[2][0] * v.x + (double)m[2][1] * v.y + (double)m[2][2] * v.z};
}

static vec3_f64 translation(const float m[3][4]) {
    return (vec3_f64){(double)m[0][3], (double)m[1][3], (double)m[2][3]};
}

static vec3_f64 map_point(const float m[3][4], vec3_f64 p) {
    return add_f64(map_vector(m, p), translation(m));
}

/* Mᵀ v */
static vec3_f64 map_normal(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[1][0] * v.y + (double)m[2][0] * v.z,
                      (double)m[0][1] * v.x + (double)m[1][1] * v.y + (double)m[2][1] * v.z,
                      (double)m[0][2] * v.x + (double)m[1][2] * v.y + (double)m[2][2] * v.z};
}

static vec3_f64 absolute(vec3_f64 v) { return (vec3_f64){fabs(v.x), fabs(v.y), fabs(v.z)}; }

/* How far rounding takes the start of a ray along a normal n of unit length. */
static double rounding_along(vec3_f64 n, vec3_f64 p) {
    return 2.25 * unit_round * dot_f64(absolute(n), absolute(p));
}

/* How far a tracer may carry a point of the world wrong along the normal n of the object. */
static double carried_along(const world_instance *instance, vec3_f64 n, vec3_f64 p) {
    vec3_f64 shift = translation(instance->to_world);
    vec3_f64 from = absolute(sub_f64(p, shift)), sum = add_f64(absolute(p), absolute(shift));
    const double along[3] = {fabs(n.x), fabs(n.y), fabs(n.z)};
    double error = 0;
    for (int i = 0; i < 3; ++i) {
        const float *a = instance->to_object[i], *e = instance->to_object_error[i];
        double products =
            fabs((double)a[0]) * sum.x + fabs((double)a[1]) * sum.y + fabs((double)a[2]) * sum.z;
        double map = (double)e[0] * from.x + (double)e[1] * from.y + (double)e[2] * from.z;
        error += along[i] * (map + 6 * unit_round * products);
    }
    return error;
}

static vec3_f32 unit_of(vec3_f64 v) { return narrow(scale_f64(1 / sqrt(dot_f64(v, v)), v)); }

/* Object to world: to the point that to_object, as it was rounded, carries to the object's: to_world is its
 * inverse but for some u, so what is left after one step of Newton's is of the order u². */
static void to_world(const world_instance *instance, local_hit *hit) {
    const float(*m)[4] = instance->to_world, (*inverse)[4] = instance->to_object;
    vec3_f64 p = map_point(m, hit->p), n = map_normal(inverse, hit->n);
    p = add_f64(p, map_vector(m, sub_f64(hit->p, map_point(inverse, p))));
    double length = sqrt(dot_f64(n, n));
    hit->beside = (hit->beside + carried_along(instance, hit->n, p)) / length;
    hit->p = p;
    hit->n = scale_f64(1 / length, n);
    hit->ns = unit_of(map_normal(inverse, widen(hit->ns)));
    hit->lift = narrow(map_vector(m, widen(hit->lift)));
    hit->lift_inside = narrow(map_vector(m, widen(hit->lift_inside)));
}

/* ---- hits ---- */

static void evaluate_primitive(const world *scene, const ray_hit *ray, const local_ray *local, bool lift,
                               local_hit *out) {
    const world_geometry *geometry = &scene->geometries.items[ray->geometry];
    switch (geometry->kind) {
    case WORLD_SPHERES:
        local_sphere(&scene->spheres.items[geometry->first + ray->primitive], local, out);
        break;
    case WORLD_QUADS: local_quad(&scene->quads.items[geometry->first + ray->primitive], local, out); break;
    case WORLD_MESH:
        local_triangle(&scene->meshes.items[geometry->first], ray->primitive, local, lift, out);
        break;
    }
}

void surface_point(const world *scene, const ray_hit *ray, bool lift, local_hit *out) {
    local_ray local = {widen(ray->org), widen(ray->dir), ray->t_near};
    if (ray->geometry == TRACE_PLANE) {
        local_plane(&scene->planes.items[ray->primitive], &local, out);
        return;
    }
    if (ray->instance == FATHOM_NONE) {
        evaluate_primitive(scene, ray, &local, lift, out);
        return;
    }
    const world_instance *instance = &scene->instances.items[ray->instance];
    local.org = map_point(instance->to_object, local.org);
    local.dir = map_vector(instance->to_object, local.dir);
    evaluate_primitive(scene, ray, &local, lift, out);
    to_world(instance, out);
}

static void put(lanes3 to, size_t i, vec3_f32 v) { to[0][i] = v.x, to[1][i] = v.y, to[2][i] = v.z; }

/* n turns to the viewer: the geometric normal decides, and takes the shading normal with it. */
void surface_set(surface_block *s, size_t i, const ray_hit *ray, const local_hit *hit, bool automatic) {
    bool outside = dot_f64(hit->n, widen(ray->dir)) < 0;
    vec3_f32 n = narrow(hit->n), ng = outside ? n : neg_f32(n);
    vec3_f32 ns = dot_f32(hit->ns, ng) < 0 ? neg_f32(hit->ns) : hit->ns;
    put(s->p, i, narrow(hit->p));
    put(s->ng, i, ng);
    put(s->ns, i, ns);
    put(s->v, i, neg_f32(ray->dir));
    put(s->lift, i, outside ? hit->lift : hit->lift_inside);
    s->offset[i] = automatic ? (float)(rounding_along(hit->n, hit->p) + hit->beside) : 0;
    s->entering[i] = outside ? ~0u : 0;
    s->smooth[i] = hit->smooth ? ~0u : 0;
}
