#include "base/kernel.h"
#include "camera/lens.h"

static inline void directions(const shade_camera *camera, uint32_t left, uint32_t top,
                              const square_samples *at, bool alike, trace_rays *restrict out) {
    const shade_camera c = *camera;
    for (uint32_t i = 0; i < LANES; ++i) {
        double x = (double)(int32_t)(left + i % 4) + at->x[alike ? 0 : i];
        double y = (double)(int32_t)(top + i / 4) + at->y[alike ? 0 : i];
        vec3_f32 d = camera_direction(&c, x, y);
        out->dir_x[i] = d.x, out->dir_y[i] = d.y, out->dir_z[i] = d.z;
    }
}

static void parallel_rays(const shade_camera *camera, uint32_t left, uint32_t top, const square_samples *at,
                          trace_rays *restrict out) {
    for (uint32_t i = 0; i < LANES; ++i) {
        const uint32_t from = at->alike ? 0 : i;
        vec3_f32 org, dir;
        camera_ray(camera, (double)(int32_t)(left + i % 4) + at->x[from],
                   (double)(int32_t)(top + i / 4) + at->y[from], &org, &dir);
        out->org_x[i] = org.x, out->org_y[i] = org.y, out->org_z[i] = org.z;
        out->dir_x[i] = dir.x, out->dir_y[i] = dir.y, out->dir_z[i] = dir.z;
    }
}

/* Samples that are alike are read as two numbers: loading sixteen that were just stored one by one would
 * stall. */
static void rays(const shade_camera *camera, float t_near, uint32_t left, uint32_t top,
                 const square_samples *at, trace_rays *restrict out) {
    if (at->alike)
        directions(camera, left, top, at, true, out);
    else
        directions(camera, left, top, at, false, out);
    for (uint32_t i = 0; i < LANES; ++i) {
        out->org_x[i] = camera->eye.x, out->org_y[i] = camera->eye.y, out->org_z[i] = camera->eye.z;
        out->t_near[i] = t_near, out->t_far[i] = INFINITY;
    }
    if (camera->parallel) parallel_rays(camera, left, top, at, out);
}

static void lens(const shade_camera *camera, const double u[LANES], const double v[LANES],
                 trace_rays *restrict out) {
    const shade_camera c = *camera;
    const vec3_f64 eye = widen(c.eye);
    double x[LANES], y[LANES];
    for (int i = 0; i < LANES && c.blades; ++i) camera_lens_point(camera, u[i], v[i], &x[i], &y[i]);
    for (int i = 0; i < LANES && !c.blades; ++i) lens_disc(u[i], v[i], &x[i], &y[i]);
    for (int i = 0; i < LANES; ++i) {
        vec3_f64 on, d;
        lens_ray(&c, x[i], y[i], (vec3_f64){out->dir_x[i], out->dir_y[i], out->dir_z[i]}, &on, &d);
        const vec3_f32 org = narrow(add_f64(eye, on)), dir = narrow(d);
        out->org_x[i] = org.x, out->org_y[i] = org.y, out->org_z[i] = org.z;
        out->dir_x[i] = dir.x, out->dir_y[i] = dir.y, out->dir_z[i] = dir.z;
    }
}

const camera_kernels KERNEL(camera_kernels) = {.rays = rays, .lens = lens};
