#include "camera/camera.h"

#include "base/kernel.h"

void camera_extent(const fathom_camera *camera, uint32_t width, uint32_t height, double *w, double *h) {
    *h = camera->h / camera->d;
    *w = camera->w > 0 ? camera->w / camera->d : *h * width / height;
}

/* Q(u,v) = O + (u-0.5) w x + (v-0.5) h y - d z with u = X/W and v = 1 - Y/H: image files have the top row
 * first. All is divided by d, which changes no direction and keeps squares in range. */
void camera_prepare(const fathom_camera *camera, uint32_t width, uint32_t height, vec3_f64 origin,
                    shade_camera *out) {
    vec3_f64 x = load_f64(camera->x), y = load_f64(camera->y), z = load_f64(camera->z);
    double w, h;
    camera_extent(camera, width, height, &w, &h);
    out->eye = narrow(sub_f64(load_f64(camera->origin), origin));
    out->corner = madd_f64(madd_f64(neg_f64(z), -0.5 * w, x), 0.5 * h, y);
    out->across = scale_f64(w / width, x);
    out->down = scale_f64(-h / height, y);
    out->view = neg_f64(z);
}

KERNEL_CHOICE(camera_kernels)
