/* Images whose pixels a formula knows. Each test runs with every tracer. */
#include "render.h"

static const char *const tracers[] = {"embree", "reference"};
#define EACH_TRACER(s) for (size_t k = 0; k < 2 && ((s).settings.tracer = tracers[k], true); ++k)

static const double pi = 3.14159265358979324;
static const double origin[3] = {0, 0, 0}, up[3] = {0, 1, 0};

/* A sphere of radius R at distance D is seen as a disc of angular radius asin(R/D). */
UNIT_TEST(sphere_silhouette) {
    stage s = stage_open(200, 200);
    s.settings.spp = 16;
    stage_camera(&s, origin, (double[3]){0, 0, -1}, up, pi / 2);
    stage_sphere(&s, 0, 0, -5, 2, stage_emitter(&s, 1));
    EACH_TRACER(s) {
        fathom_film *film = stage_render(&s);
        const float *red = fathom_film_channel(film, "R");
        double area = 0;
        for (int i = 0; i < 200 * 200; ++i) area += (double)red[i];
        double radius = tan(asin(2.0 / 5)) * 100; /* pixels: 90 degrees are 100 to each side */
        /* A row of samples has two ends, each off by at most one of the 4 samples a pixel has across; 8
         * radius rows. */
        assert_near(area, pi * radius * radius, 2 * 8 * radius / 16);
    }
}

/* A diffuse plane at z = -2 under a point light: k_d I cos/d^2 at every pixel. */
UNIT_TEST(lit_plane_radiance) {
    stage s = stage_open(64, 48);
    stage_camera(&s, origin, (double[3]){0, 0, -1}, up, pi / 3);
    stage_plane(&s, (double[3]){0, 0, -2}, (double[3]){0, 0, 3}, stage_lambert(&s, 0.75f));
    stage_point_light(&s, 0.5, 0.25, -0.5, 4);
    assert_ok(s.context, fathom_scene_set_ambient(s.scene, (float[3]){0.125f, 0.125f, 0.125f}));
    EACH_TRACER(s) {
        fathom_film *film = stage_render(&s);
        const float *red = fathom_film_channel(film, "R");
        for (int y = 0; y < 48; ++y) {
            for (int x = 0; x < 64; ++x) {
                double half = tan(pi / 6), px = ((x + 0.5) / 48 * 2 - 64.0 / 48) * half * 2,
                       py = (1 - (y + 0.5) / 48 * 2) * half * 2;
                double dx = 0.5 - px, dy = 0.25 - py, dz = 1.5, d2 = dx * dx + dy * dy + dz * dz;
                double expected = 0.75 * (0.125 + 4 * dz / sqrt(d2) / d2);
                /* The point is good to 16 u of its coordinates, below 4, and the radiance changes by less
                 * than itself times 3 over the distance, above 1.5; some 20 roundings follow. */
                assert_near(red[y * 64 + x], expected, expected * (16 * 4 * 3 / 1.5 + 20) * 0x1p-24);
            }
        }
    }
}

/* Where along a row of pixels the red channel first rises above 1/2. */
static int edge_of_row(stage *s) {
    fathom_film *film = stage_render(s);
    const float *red = fathom_film_channel(film, "R");
    int x = 0;
    while (x < (int)s->settings.width && red[x] < 0.5f) ++x;
    return x;
}

/* Through a glass surface at z = -1 to an emitter at z = -2 that begins at X: tan(i) + tan(t) = X with sin(i)
 * = ior sin(t). */
UNIT_TEST(snell_edge) {
    const float iors[] = {1.5f, 1.0f, 2.5f, 0.8f};
    for (size_t n = 0; n < 4; ++n) {
        stage s = stage_open(4096, 1);
        fathom_camera camera = default_camera();
        camera.w = 4, camera.h = 4.0 / 4096;
        assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
        fathom_material glass = default_material();
        for (int c = 0; c < 3; ++c) glass.k_d[c] = 0, glass.k_t[c] = 1;
        glass.ior = iors[n];
        stage_plane(&s, (double[3]){0, 0, -1}, (double[3]){0, 0, 1}, stage_material(&s, &glass));
        stage_quad(&s, (double[3]){50.75, 0, -2}, (double[3]){50, 0, 0}, (double[3]){0, 9, 0},
                   stage_emitter(&s, 1));
        double low = 0, high = 0.75;
        for (int i = 0; i < 100; ++i) {
            double mid = (low + high) / 2, sine = mid / sqrt(1 + mid * mid) / (double)iors[n];
            double reach = sine < 1 ? mid + sine / sqrt(1 - sine * sine) : 1e9;
            if (reach < 0.75)
                low = mid;
            else
                high = mid;
        }
        double expected = (low + 2) / 4 * 4096 - 0.5;
        /* The first pixel whose centre lies beyond; float directions are good to a fraction of these pixels.
         */
        EACH_TRACER(s)
        assert_near(edge_of_row(&s), ceil(expected), 0.5 + (fabs(ceil(expected) - expected) < 0.01));
    }
}

/* From inside glass, light gets in only where sin < 1/ior; beyond, the surface mirrors what is inside. */
UNIT_TEST(total_internal_reflection) {
    stage s = stage_open(4096, 1);
    fathom_camera camera = default_camera();
    camera.w = 4, camera.h = 4.0 / 4096;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    fathom_material glass = default_material();
    for (int c = 0; c < 3; ++c) glass.k_d[c] = 0, glass.k_t[c] = 1;
    /* The normal points away from the camera: the camera is inside. */
    stage_plane(&s, (double[3]){0, 0, -1}, (double[3]){0, 0, -1}, stage_material(&s, &glass));
    stage_plane(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, 1},
                stage_emitter(&s, 1)); /* behind the camera, inside */
    EACH_TRACER(s) {
        fathom_film *film = stage_render(&s);
        const float *red = fathom_film_channel(film, "R");
        double critical = tan(asin(1 / 1.5));
        for (int x = 0; x < 4096; ++x) {
            double at = fabs((x + 0.5) / 4096 * 4 - 2);
            if (fabs(at - critical) < 4.0 / 4096) continue; /* within one pixel of the edge */
            assert_near(red[x], at > critical ? 1 : 0, 0);
        }
    }
}

/* F from inside glass of this index, 1 beyond the critical angle. */
static double reflectance_inside(double ior, double sine) {
    double in = sqrt(1 - sine * sine), cos2 = 1 - ior * ior * sine * sine;
    if (cos2 <= 0) return 1;
    double out = sqrt(cos2), parallel = (in - ior * out) / (in + ior * out),
           across = (ior * in - out) / (ior * in + out);
    return (parallel * parallel + across * across) / 2;
}

/* From inside glass with k_r = 0.25 and k_t = 0.75, a red surface is mirrored and a green one shines through.
 * Snell's squared cosine is known to 16 u, so the cosine c to the smaller of 16 u / c and sqrt(16 u); and
 * 1 - F <= 2 c (ior + 1 / ior) / cos, with `cos` that of the ray inside. */
UNIT_TEST(fresnel_shares_do_not_jump_at_the_critical_angle) {
    const double ior = 1.5, error = 16 * 0x1p-24;
    stage s = stage_open(4096, 1);
    fathom_camera camera = default_camera();
    camera.w = 4, camera.h = 4.0 / 4096;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    fathom_material glass = default_material(), red, green;
    for (int c = 0; c < 3; ++c) glass.k_d[c] = 0, glass.k_r[c] = 0.25f, glass.k_t[c] = 0.75f;
    glass.fresnel = true, red = green = glass;
    for (int c = 0; c < 3; ++c) red.k_r[c] = green.k_r[c] = red.k_t[c] = green.k_t[c] = 0;
    red.k_e[0] = green.k_e[1] = 1;
    /* The normal points away from the camera: the camera is inside. */
    stage_plane(&s, (double[3]){0, 0, -1}, (double[3]){0, 0, -1}, stage_material(&s, &glass));
    stage_plane(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, 1}, stage_material(&s, &red));
    stage_plane(&s, (double[3]){0, 0, -3}, (double[3]){0, 0, 1}, stage_material(&s, &green));
    EACH_TRACER(s) {
        fathom_film *film = stage_render(&s);
        for (int x = 0; x < 4096; ++x) {
            double at = (x + 0.5) / 4096 * 4 - 2, in = 1 / sqrt(1 + at * at), sine = fabs(at) * in;
            double f = reflectance_inside(ior, sine), cos2 = fabs(1 - ior * ior * sine * sine);
            double off = fmin(error / sqrt(cos2), sqrt(error)) * 2 * (ior + 1 / ior) / in + error;
            assert_near(fathom_film_channel(film, "R")[x], 0.25 * f, 0.25 * off);
            assert_near(fathom_film_channel(film, "G")[x], 0.75 * (1 - f), 0.75 * off);
        }
    }
}

/* A light at height 2 over an occluder at height 1 whose edge is at x = 0.25: the shadow on the ground ends
 * at x = 0.5. */
UNIT_TEST(shadow_edge) {
    stage s = stage_open(4096, 1);
    fathom_camera camera = default_camera();
    camera.origin[2] = 0.5;
    camera.w = 4, camera.h = 4.0 / 4096; /* the ground at z = -0.5 is seen from x = -2 to 2 */
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    fathom_id white = stage_lambert(&s, 1);
    stage_plane(&s, (double[3]){0, 0, -0.5}, (double[3]){0, 0, 1}, white);
    stage_quad(&s, (double[3]){-49.75, 0, 0.6}, (double[3]){50, 0, 0}, (double[3]){0, 9, 0}, white);
    fathom_light light = default_light();
    light.position[2] = 1.7;
    for (int c = 0; c < 3; ++c) light.intensity[c] = 100;
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    double shadow_end = 0.25 * 2.2 / 1.1;
    EACH_TRACER(s) assert_near(edge_of_row(&s), ceil((shadow_end + 2) / 4 * 4096 - 0.5), 1);
}

/* The mirror reflects the view, not the light: an emitter to the right is seen where the angles are equal,
 * wherever the light stands. Camera at z = 1 over a mirror at z = 0, emitter in the plane x = 1 from z = 0.5
 * up: x = 1/(1 + z/1) ... at mirror point m the ray rises by slope 1/m: z = (1 - m)/m >= 0.5 for m <= 2/3. */
UNIT_TEST(mirror_geometry) {
    const double lights[][3] = {{0, 0, 3}, {-5, 2, 1}};
    for (int n = 0; n < 2; ++n) {
        stage s = stage_open(4096, 1);
        fathom_camera camera = default_camera();
        camera.origin[2] = 1;
        camera.w = 1.9, camera.h = 1.9 / 4096;
        assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
        fathom_material mirror = default_material();
        for (int c = 0; c < 3; ++c) mirror.k_d[c] = 0, mirror.k_r[c] = 1;
        stage_plane(&s, origin, (double[3]){0, 0, 1}, stage_material(&s, &mirror));
        stage_quad(&s, (double[3]){1, 0, 50.5}, (double[3]){0, 0, 50}, (double[3]){0, 9, 0},
                   stage_emitter(&s, 1));
        stage_point_light(&s, lights[n][0], lights[n][1], lights[n][2], 1);
        EACH_TRACER(s) {
            fathom_film *film = stage_render(&s);
            const float *red = fathom_film_channel(film, "R");
            for (int x = 0; x < 4096; ++x) {
                double m = ((x + 0.5) / 4096 - 0.5) * 1.9;
                if (fabs(m - 2.0 / 3) < 2 * 1.9 / 4096 || fabs(m) < 2 * 1.9 / 4096) continue;
                /* At slope below 1/100.5 the ray passes over the emitter's upper end. */
                if (m > 0 && m < 0.02) continue;
                assert_near(red[x], m > 0 && m < 2.0 / 3 ? 1 : 0, 0);
            }
        }
    }
}

/* Two facing mirrors, each sending out 1 and reflecting a half: 1 + 1/2 + 1/4 + … up to the depth limit. */
UNIT_TEST(mirror_corridor) {
    stage s = stage_open(4, 4);
    stage_camera(&s, origin, (double[3]){0, 0, -1}, up, 0.1);
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_r[c] = 0.5f, m.k_e[c] = 1;
    fathom_id mirror = stage_material(&s, &m);
    stage_plane(&s, (double[3]){0, 0, -1}, (double[3]){0, 0, 1}, mirror);
    stage_plane(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, -1}, mirror);
    for (uint32_t depth = 0; depth < 12; depth += 3) {
        s.settings.max_depth = depth;
        EACH_TRACER(s) {
            fathom_film *film = stage_render(&s);
            /* Powers of two add without rounding. */
            for (int i = 0; i < 16; ++i)
                assert_near(fathom_film_channel(film, "G")[i], 2 - pow(0.5, depth), 0);
        }
    }
}

/* One pixel of a plane seen at a slant: Phong's and Blinn's highlight by their formulas. */
UNIT_TEST(highlights) {
    const fathom_specular kinds[] = {FATHOM_SPECULAR_PHONG, FATHOM_SPECULAR_BLINN};
    const float exponents[] = {0, 1, 12.5f, 400};
    for (int k2 = 0; k2 < 2; ++k2) {
        for (int e = 0; e < 4; ++e) {
            stage s = stage_open(1, 1);
            stage_camera(&s, (double[3]){1, 0, 2}, origin, up, 0.01);
            fathom_material m = default_material();
            for (int c = 0; c < 3; ++c) m.k_d[c] = 0.25f, m.k_s[c] = 0.5f;
            m.specular = kinds[k2], m.shininess = exponents[e];
            stage_plane(&s, origin, (double[3]){0, 0, 1}, stage_material(&s, &m));
            fathom_light light = default_light();
            light.type = FATHOM_LIGHT_DIRECTIONAL;
            light.direction[0] = 1, light.direction[1] = 0.1, light.direction[2] = -2.5;
            assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
            double l[3], v[3] = {1 / sqrt(5), 0, 2 / sqrt(5)}, length = sqrt(1 + 0.01 + 6.25);
            for (int c = 0; c < 3; ++c) l[c] = -light.direction[c] / length;
            double r[3] = {-l[0], -l[1], l[2]}, h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
            double phong = r[0] * v[0] + r[1] * v[1] + r[2] * v[2];
            double blinn = h[2] / sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
            double expected = (0.25 + 0.5 * pow(k2 ? blinn : phong, (double)exponents[e])) * l[2];
            EACH_TRACER(s) {
                fathom_film *film = stage_render(&s);
                /* The cosine is good to 8 u, its power to as many more as the exponent says. */
                assert_near(fathom_film_channel(film, "B")[0], expected,
                            expected * (24 + 8 * (double)exponents[e]) * 0x1p-24);
            }
        }
    }
}

/* Straight down onto a plane from a spot at height 1: full within 20 degrees, none beyond 40, between them
 * ((cos - cos 40)/(cos 20 - cos 40))^2. */
UNIT_TEST(spot_falloff) {
    stage s = stage_open(256, 1);
    fathom_camera camera = default_camera();
    camera.origin[2] = 1;
    camera.w = 2, camera.h = 2.0 / 256;
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    stage_plane(&s, origin, (double[3]){0, 0, 1}, stage_lambert(&s, 1));
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_SPOT;
    light.position[2] = 1;
    light.direction[1] = 0, light.direction[2] = -7;
    light.inner_angle = (float)(pi / 9), light.outer_angle = (float)(2 * pi / 9);
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    EACH_TRACER(s) {
        fathom_film *film = stage_render(&s);
        for (int x = 0; x < 256; ++x) {
            double at = ((x + 0.5) / 256 - 0.5) * 2, cosine = 1 / sqrt(1 + at * at);
            double t = (cosine - cos(2 * pi / 9)) / (cos(pi / 9) - cos(2 * pi / 9));
            t = t < 0 ? 0 : (t > 1 ? 1 : t);
            /* cos is good to 8 u and stretched by 1/(cos 20 - cos 40) = 5.8. */
            assert_near(fathom_film_channel(film, "R")[x], t * t * cosine * cosine * cosine, 128 * 0x1p-24);
        }
    }
}

/* The camera's origin is part of Q: moved far away with the scene, P and Z are what they were, moved. */
UNIT_TEST(camera_origin_counts) {
    const double shift[3] = {3, -7, 11};
    stage s = stage_open(16, 16);
    s.settings.aovs = FATHOM_AOV_P | FATHOM_AOV_Z | FATHOM_AOV_N;
    stage_camera(&s, shift, (double[3]){shift[0], shift[1], shift[2] - 1}, up, pi / 2);
    stage_plane(&s, (double[3]){0, 0, shift[2] - 2}, (double[3]){0, 0, 1}, stage_lambert(&s, 1));
    EACH_TRACER(s) {
        fathom_film *film = stage_render(&s);
        for (int y = 0; y < 16; ++y) {
            for (int x = 0; x < 16; ++x) {
                int i = y * 16 + x;
                /* Left is -x and the top row is +y; 16 u of coordinates below 16. */
                assert_near(fathom_film_channel(film, "P.X")[i], shift[0] + ((x + 0.5) / 8 - 1) * 2,
                            256 * 0x1p-24);
                assert_near(fathom_film_channel(film, "P.Y")[i], shift[1] + (1 - (y + 0.5) / 8) * 2,
                            256 * 0x1p-24);
                assert_near(fathom_film_channel(film, "Z")[i], 2, 256 * 0x1p-24);
                assert_near(fathom_film_channel(film, "N.Z")[i], 1, 0);
            }
        }
    }
}

/* A surface lit only from the viewer's far side is black, unless it says otherwise. */
UNIT_TEST(far_side_light) {
    for (int from_behind = 0; from_behind < 2; ++from_behind) {
        stage s = stage_open(1, 1);
        stage_camera(&s, (double[3]){0, 0, 2}, origin, up, 0.01);
        fathom_material m = default_material();
        m.lit_from_behind = from_behind;
        stage_plane(&s, origin, (double[3]){0, 0, 1}, stage_material(&s, &m));
        stage_point_light(&s, 0, 0, -2, 4);
        EACH_TRACER(s) {
            fathom_film *film = stage_render(&s);
            assert_near(fathom_film_channel(film, "R")[0], from_behind ? 0.5 : 0, 4 * 0x1p-24);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
