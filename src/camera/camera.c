#include "camera/camera.h"

#include "base/kernel.h"
#include "camera/lens.h"

#include <math.h>

void camera_extent(const fathom_camera *camera, uint32_t width, uint32_t height, double *w, double *h) {
    const double d = camera->orthographic ? 1 : camera->d;
    *h = camera->h / d;
    *w = camera->w > 0 ? camera->w / d : *h * width / height;
}

/* Q(u,v) = O + (u-0.5) w x + (v-0.5) h y - d z with u = X/W and v = 1 - Y/H: image files have the top row
 * first. All terms are divided by d, which changes no direction and keeps squares in range. */
void camera_prepare(const fathom_camera *camera, uint32_t width, uint32_t height, vec3_f64 origin,
                    shade_camera *out) {
    vec3_f64 x = load_f64(camera->x), y = load_f64(camera->y), z = load_f64(camera->z);
    double w, h;
    camera_extent(camera, width, height, &w, &h);
    out->exact_eye = sub_f64(load_f64(camera->origin), origin);
    out->eye = narrow(out->exact_eye);
    out->parallel = camera->orthographic;
    out->corner = madd_f64(madd_f64(scale_f64(out->parallel ? 0 : -1, z), -0.5 * w, x), 0.5 * h, y);
    out->across = scale_f64(w / width, x);
    out->down = scale_f64(-h / height, y);
    out->view = neg_f64(z);
    out->right = x, out->up = y;
    out->lens_radius = camera->lens_radius, out->focus_distance = camera->focus_distance;
    out->blades = camera->blades, out->blade_rotation = camera->blade_rotation;
    out->near_clip = camera->near_clip;
    out->far_clip = camera->far_clip > 0 ? camera->far_clip : (double)INFINITY;
    out->clips = camera->near_clip > 0 || camera->far_clip > 0;
}

/* A uniform point in a regular polygon with corners at radius 1: picks one of its triangles, then a point in
 * it by the square-root mapping. */
static void polygon_point(uint32_t blades, double rotation, double u, double v, double *x, double *y) {
    const double step = 6.283185307179586 / blades, at = u * blades, r = sqrt(v);
    const double first = rotation + floor(at) * step, part = at - floor(at);
    *x = r * ((1 - part) * cos(first) + part * cos(first + step));
    *y = r * ((1 - part) * sin(first) + part * sin(first + step));
}

void camera_lens_point(const shade_camera *c, double u, double v, double *x, double *y) {
    if (c->blades)
        polygon_point(c->blades, c->blade_rotation, u, v, x, y);
    else
        lens_disc(u, v, x, y);
}

void camera_lane_through_lens(const shade_camera *c, double u, double v, trace_rays *rays, uint32_t i) {
    vec3_f64 on, d;
    double x, y;
    camera_lens_point(c, u, v, &x, &y);
    lens_ray(c, x, y, widen(trace_dir(rays, (size_t)i)), &on, &d);
    const vec3_f32 org = narrow(add_f64(widen(c->eye), on)), dir = narrow(d);
    rays->org_x[i] = org.x, rays->org_y[i] = org.y, rays->org_z[i] = org.z;
    rays->dir_x[i] = dir.x, rays->dir_y[i] = dir.y, rays->dir_z[i] = dir.z;
}

void camera_exact_ray(const shade_camera *c, double x, double y, double u, double v, vec3_f64 *org,
                      vec3_f64 *dir) {
    const vec3_f64 d = camera_towards(c, x, y);
    vec3_f64 on = vec_f64(0, 0, 0);
    if (!c->parallel && c->lens_radius > 0) {
        double lens[2];
        camera_lens_point(c, u, v, &lens[0], &lens[1]);
        lens_ray(c, lens[0], lens[1], d, &on, dir);
    } else {
        *dir = c->parallel ? c->view : normalize_f64(d);
    }
    *org = add_f64(c->exact_eye, c->parallel ? d : on);
}

KERNEL_BEST(camera_kernels)
