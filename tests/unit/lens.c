/* Points on lenses, and rays through them, in closed form and by the kernels of every instruction set. */
#include "camera/camera.h"
#include "defaults.h"
#include "random.h"
#include "unit.h"
#include "variants.h"

VARIANTS(camera_kernels)

static random_state numbers = {3};

static double between(double low, double high) { return random_in(&numbers, low, high); }

static shade_camera any_camera(uint32_t blades) {
    fathom_camera camera = default_camera();
    shade_camera out;
    camera.lens_radius = random_log(&numbers, 1e-9, 1e9),
    camera.focus_distance = random_log(&numbers, 1e-9, 1e9);
    camera.blades = blades, camera.blade_rotation = between(0, 7);
    camera_prepare(&camera, 640, 480, vec_f64(1, 2, 3), &out);
    return out;
}

/* A column of u is a line through the middle or a ring of v, by sine and cosine of the C library: both are
 * right to some roundings of double. */
UNIT_TEST(round_lenses_are_mapped_by_rings) {
    const shade_camera c = any_camera(0);
    for (int k = 0; k < 100000; ++k) {
        const double u = k ? between(0, 1) : 0.5, v = k > 1 ? between(0, 1) : 0.5, a = 2 * u - 1,
                     b = 2 * v - 1;
        const bool wide = fabs(a) > fabs(b);
        const double r = wide ? a : b, of = r != 0 ? M_PI / 4 * (wide ? b : a) / r : 0;
        double x, y;
        camera_lens_point(&c, u, v, &x, &y);
        assert_near(x, r * (wide ? cos(of) : sin(of)), 4 * 0x1p-53);
        assert_near(y, r * (wide ? sin(of) : cos(of)), 4 * 0x1p-53);
    }
}

/* The area of a polygon with corners at radius 1 is n sin(2 pi / n) / 2; a disc of radius r < cos(pi / n)
 * lies in it whole. 5 deviations: level 6e-7 for each of 12. */
UNIT_TEST(lenses_are_even) {
    static const double radii[] = {0.2, 0.35, 0.49};
    for (uint32_t blades = 0; blades < 6; blades += blades ? 1 : 3) {
        const shade_camera c = any_camera(blades);
        const double area = blades ? blades * sin(2 * M_PI / blades) / 2 : M_PI;
        for (int k = 0; k < 3; ++k) {
            const double share = M_PI * radii[k] * radii[k] / area, count = 20000;
            double inside = 0, x, y;
            for (int i = 0; i < count; ++i) {
                camera_lens_point(&c, between(0, 1), between(0, 1), &x, &y);
                inside += x * x + y * y < radii[k] * radii[k];
            }
            assert_near(inside / count, share, 5 * sqrt(share * (1 - share) / count));
        }
    }
}

/* A ray's distance from the point of the plane of focus is off by the rounding of its direction to float, and
 * by that of its origin. */
static void check_ray(const shade_camera *c, vec3_f64 pinhole, const trace_rays *rays, size_t i) {
    const vec3_f64 focus = scale_f64(c->focus_distance / dot_f64(pinhole, c->view), pinhole);
    const vec3_f64 on = sub_f64(widen(trace_org(rays, i)), widen(c->eye)), to = sub_f64(focus, on);
    const double size = fmax(length_f64(widen(trace_org(rays, i))), length_f64(to));
    assert_true(length_f64(cross_f64(to, widen(trace_dir(rays, i)))) <= 4 * 0x1p-24 * size);
    assert_true(length_f64(on) <= c->lens_radius + 2 * 0x1p-24 * size);
}

UNIT_TEST(rays_meet_in_the_plane_of_focus_by_all_kernels) {
    for (int round = 0; round < 2000; ++round) {
        const shade_camera c = any_camera(round % 3 ? 0 : 3 + (uint32_t)round % 7);
        trace_rays pinhole, single, block;
        double u[LANES], v[LANES];
        memset(&pinhole, 0, sizeof pinhole);
        for (size_t i = 0; i < LANES; ++i) {
            const vec3_f32 d = camera_direction(&c, between(0, 640), between(0, 480));
            pinhole.dir_x[i] = d.x, pinhole.dir_y[i] = d.y, pinhole.dir_z[i] = d.z;
            u[i] = between(0, 1), v[i] = between(0, 1);
        }
        single = pinhole;
        for (uint32_t i = 0; i < LANES; ++i) {
            camera_lane_through_lens(&c, u[i], v[i], &single, i);
            check_ray(&c, widen(trace_dir(&pinhole, i)), &single, i);
        }
        for (unsigned k = 0; camera_kernels_at(k); ++k) {
            block = pinhole;
            camera_kernels_at(k)->lens(&c, u, v, &block);
            assert_memory_equal(&block, &single, sizeof block);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
