/* Computes surface points for shading from hits. */
#include "surface/kernels/kernel.h"

/* Error of a ray's origin along the normal by rounding. With u = 2^-24 and p accurate in double, each
 * coordinate of the origin p + h n is rounded twice: by u |p_i| when p becomes float, and by u |p_i + h n_i|
 * when the ray is made. The product h n_i and the float normal add 3 u h, with h below about 30 u |p|. So the
 * error along the normal is at most Σ |n_i| 2 u |p_i|. An eighth more covers the second-order terms. */
static const double rounding = 2.25 * 0x1p-24;

/* Flips normals to face the viewer: the geometric normal by the ray, then the shading normal to the same
 * side. */
static void surfaces(const local_block *b, bool automatic, surface_block *restrict s) {
    const double scale = automatic ? 1 : 0;
    s->mapped = s->directed = s->coated = 0;
    for (int i = 0; i < LANES; ++i) {
        double x = b->n[0][i], y = b->n[1][i], z = b->n[2][i], px = b->p[0][i], py = b->p[1][i],
               pz = b->p[2][i];
        float facing =
            (float)(x * (double)b->ray[0][i] + y * (double)b->ray[1][i] + z * (double)b->ray[2][i]);
        double strays = rounding * (fabs(x) * fabs(px) + fabs(y) * fabs(py) + fabs(z) * fabs(pz));
        uint32_t entering = facing < 0 ? ~0u : 0;
        float front = facing < 0 ? 1 : -1;
        float ng[3] = {front * (float)x, front * (float)y, front * (float)z};
        float along = b->ns[0][i] * ng[0] + b->ns[1][i] * ng[1] + b->ns[2][i] * ng[2];
        float turn = along < 0 ? -1 : 1;
        s->p[0][i] = (float)px, s->p[1][i] = (float)py, s->p[2][i] = (float)pz;
        for (int c = 0; c < 3; ++c) {
            s->ng[c][i] = ng[c];
            s->ns[c][i] = turn * b->ns[c][i];
            s->v[c][i] = -b->ray[c][i];
            s->lift[c][i] = b->lift[c][i];
        }
        s->offset[i] = (float)(scale * (strays + b->self_hit[i]));
        s->entering[i] = entering;
        s->smooth[i] = b->smooth[i];
    }
}

static void starts(const surface_block *s, const lanes3 direction, const uint32_t behind[LANES],
                   float (*restrict origin)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float along = 0;
        for (int c = 0; c < 3; ++c) along += direction[c][i] * s->ng[c][i];
        const uint32_t lifted = ~behind[i] & (along < 0 ? ~0u : 0);
        const float off = chosen(behind[i], -s->offset[i], s->offset[i]);
        for (int c = 0; c < 3; ++c)
            origin[c][i] = surface_start(s->p[c][i] + chosen(lifted, s->lift[c][i], 0), off, s->ng[c][i]);
    }
}

const surface_kernels KERNEL(surface_kernels) = {
    .facet_gather = KERNEL(facet_gather),
    .quad_gather = KERNEL(quad_gather),
    .facets = KERNEL(facets),
    .rays_to_object = KERNEL(rays_to_object),
    .hits_to_world = KERNEL(hits_to_world),
    .surfaces = surfaces,
    .starts = starts,
};
