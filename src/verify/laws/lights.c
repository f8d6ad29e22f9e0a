/* A floor z = 0 under lights of many shapes; the camera looks at the origin. */
#include "verify/laws/common.h"

static const vec3_f64 albedo = {1, 0.5, 0.2};

/* Adds the floor and sets its radiance: albedo times `share`, the irradiance divided by pi. */
static void floor_under(law_room *room, double share) {
    room->depth = 4;
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    law_look(room, vec_f64(-1, -0.8, 0.7), origin);
    law_value(room, scale_f64(share, albedo));
}

static fathom_material lamp(void) { return build_emitter(white); }

/* ---- polygons ---- */

static double rectangle_half(double a, double b) { return a / sqrt(1 + a * a) * atan(b / sqrt(1 + a * a)); }

static void rectangle(law_room *room) {
    const double a = 1, b = 2, h = 1.5;
    paint_quad(&room->b, vec_f64(a / 2, b / 2, h), vec_f64(a / 2, 0, 0), vec_f64(0, b / 2, 0), lamp());
    floor_under(room, (rectangle_half(a / h, b / h) + rectangle_half(b / h, a / h)) / (2 * M_PI));
}

static void polygon(law_room *room, const vec3_f64 *corners, uint32_t count) {
    law_fan(room, corners, count, lamp());
    floor_under(room, law_polygon(corners, count));
}

static void tilted_triangle(law_room *room) {
    const vec3_f64 corners[] = {{1, -0.5, 0.25}, {1.5, 1, 1}, {0.75, 0.25, 2}};
    polygon(room, corners, 3);
}

static void cut_pentagon(law_room *room) {
    const vec3_f64 corners[] = {
        {1, -1, -0.5}, {1, 0.5, -0.75}, {1, 1.5, 0.25}, {1, 0.5, 1.25}, {1, -0.75, 0.5}};
    polygon(room, corners, 5);
}

/* The mean over the lower square is the form factor of two parallel unit squares at distance 1. The image
 * shows the whole lower square. */
static void under_square(law_room *room) {
    const double x = 1, root = sqrt(1 + x * x);
    const double factor =
        2 / (M_PI * x * x) *
        (log((1 + x * x) / sqrt(1 + 2 * x * x)) + 2 * x * root * atan(x / root) - 2 * x * atan(x));
    paint_quad(&room->b, origin, vec_f64(0.5, 0, 0), vec_f64(0, 0.5, 0), build_lambert(albedo));
    law_look_down(room, 0.5, 1);
    law_value(room, scale_f64(factor, albedo));
    room->depth = 4;
}

static void parallel_squares(law_room *room) {
    under_square(room);
    paint_quad(&room->b, up, vec_f64(0.5, 0, 0), vec_f64(0, 0.5, 0), lamp());
}

/* ---- an image of a sky through a square hole in the roof of a black room ---- */

/* The hole shows directions with a z of at least 1/sqrt(3). */
static vec3_f64 sky_over_hole(vec3_f64 direction) { return gray(direction.z > 0.5 ? 1 : 30); }

static void sky_through_hole(law_room *room) {
    const double wide = 1.25, far = 1.75, side = 3; /* the roof's parts reach from 0.5 to 3 */
    under_square(room);
    law_sky(room, sky_over_hole);
    for (int sign = -1; sign <= 1; sign += 2) {
        paint_quad(&room->b, vec_f64(sign * far, 0, 1), vec_f64(wide, 0, 0), vec_f64(0, side, 0),
                   build_black());
        paint_quad(&room->b, vec_f64(0, sign * far, 1), vec_f64(0.5, 0, 0), vec_f64(0, wide, 0),
                   build_black());
        paint_quad(&room->b, vec_f64(sign * side, 0, 0), up, vec_f64(0, side, 0), build_black());
        paint_quad(&room->b, vec_f64(0, sign * side, 0), up, vec_f64(side, 0, 0), build_black());
    }
    paint_quad(&room->b, down, vec_f64(side, 0, 0), vec_f64(0, side, 0), build_black());
}

/* The sun lights a quarter of the floor. Regions are halves: in one of them all light is from the sky, in the
 * other one light samples prefer the sun. */
static void sun_through_hole(law_room *room) {
    const double cosine = 1 / sqrt(1.5);
    sky_through_hole(room);
    build_directional_light(&room->b, vec_f64(0.5, 0.5, -1), gray(0.8), 0);
    room->depth = 1; /* the walls are black */
    law_value(room, scale_f64(room->value[0] / albedo.x + 0.8 * cosine * 0.25, albedo));
}

/* ---- disks: radius 1, offset 0.7, height 1.3 ---- */

static const vec3_f64 disk_center = {0.7, 0, 1.3};

static double under_disk(void) {
    const double H = disk_center.z / disk_center.x, R = 1 / disk_center.x, Z = 1 + H * H + R * R;
    return (1 - (1 + H * H - R * R) / sqrt(Z * Z - 4 * R * R)) / 2;
}

/* A polygon with N corners on the circle has the fraction 1 - 2π²/3N² of the disk's area. */
static void disk_of_triangles(law_room *room) {
    enum { CORNERS = 2000 };
    vec3_f64 p[CORNERS];
    for (int i = 0; i < CORNERS; ++i) {
        const double angle = 2 * M_PI * i / CORNERS;
        p[i] = add_f64(disk_center, vec_f64(cos(angle), sin(angle), 0));
    }
    law_fan(room, p, CORNERS, lamp());
    floor_under(room, under_disk());
}

/* A sphere scaled by 1/1000 along z. Its outline differs from the disk's only by the square of that. */
static void disk_squeezed(law_room *room) {
    const affine_f64 squeeze = {
        {{1, 0, 0, disk_center.x}, {0, 1, 0, disk_center.y}, {0, 0, 1e-3, disk_center.z}}};
    const fathom_id group = room->b.group = build_group(&room->b);
    paint_sphere(&room->b, origin, 1, lamp());
    room->b.group = FATHOM_ROOT;
    build_place(&room->b, group, FATHOM_ROOT, &squeeze);
    floor_under(room, under_disk());
}

/* ---- spheres ---- */

static void sphere_above(law_room *room) { floor_under(room, law_ball(room, lamp())); }

/* A ray from the floor crosses half of the surface twice; scattered rays alone find the far side. */
static void sphere_half_there(law_room *room) {
    fathom_material m = law_metallic();
    for (int c = 0; c < 3; ++c) m.base_color[c] = 0, m.emissive[c] = 1;
    m.specular_factor = 0, m.opacity = 0.5f;
    floor_under(room, 0.75 * law_ball(room, m));
}

static void sphere_cut(law_room *room) {
    const double angle = room->number, area = 0.3, x = sqrt(1 / area - 1), y = -x / tan(angle),
                 q = sin(angle) * sqrt(1 - y * y);
    paint_sphere(&room->b, vec_f64(sin(angle), 0, cos(angle)), sqrt(area), lamp());
    floor_under(room, ((cos(angle) * acos(y) - x * q) * area + atan(q / x)) / M_PI);
}

/* A black wall hides nearly all lamps from the floor. */
static void sphere_before_wall(law_room *room) {
    sphere_above(room);
    paint_quad(&room->b, vec_f64(0, 1.5, 0), vec_f64(4, 0, 0), vec_f64(0, 0, 4), build_black());
    for (int i = 0; i < 20; ++i)
        paint_sphere(&room->b, vec_f64(0.25 * (i - 10), 4, 0.5 + 0.25 * (i % 5)), 0.1,
                     build_emitter(gray(500)));
}

/* ---- lights without a surface: k_l cos θ, divided by the squared distance ---- */

static void point_over_floor(law_room *room) {
    const vec3_f64 at = {1, 0.5, 2};
    const double d2 = dot_f64(at, at);
    build_point_light(&room->b, at, gray(5), room->number);
    floor_under(room, 5 * at.z / (d2 * sqrt(d2)));
}

static void sun_over_floor(law_room *room) {
    build_directional_light(&room->b, vec_f64(-1, -2, -2), gray(1.5), room->number);
    floor_under(room, 1.5 * 2 / 3);
}

/* A disc of half the angle a has the irradiance pi L sin² a = pi k_l. */
static void sun_in_mirror(law_room *room) {
    const double sine = sin((double)(float)room->number);
    fathom_material mirror = build_black();
    build_rgb(mirror.k_r, albedo);
    sun_over_floor(room);
    paint_plane(&room->b, vec_f64(0, 0, 0.25), up, mirror);
    law_look(room, vec_f64(-1, -2, 2.25), vec_f64(0, 0, 0.25));
    law_value(room, scale_f64(1.5 / (sine * sine), albedo));
}

/* ---- lamps with a radius, as a mirror shows them: the radiance k_l/R² ---- */

/* The camera looks at a mirror from the distance 1, and the mirrored ray at the centre of a lamp at the
 * distance 2. value: the lamp's radiance as the camera sees it. */
static void lamp_in_mirror(law_room *room, fathom_light_type type, vec3_f64 value) {
    const vec3_f64 from = {-0.48, -0.64, 0.6}, to = {0.48, 0.64, 0.6}, at = {0, 0, 0.25};
    fathom_material mirror = build_black();
    fathom_light light = build_light_of(type, madd_f64(at, 2, to), down, gray(1.5));
    light.radius = 0.5f;
    light.inner_angle = 0.2f, light.outer_angle = 1.2f;
    build_light(&room->b, &light);
    build_rgb(mirror.k_r, albedo);
    paint_plane(&room->b, at, up, mirror);
    law_look(room, add_f64(at, from), at);
    law_value(room, vec_f64(albedo.x * value.x, albedo.y * value.y, albedo.z * value.z));
}

static void ball_in_mirror(law_room *room) { lamp_in_mirror(room, FATHOM_LIGHT_POINT, gray(1.5 / 0.25)); }

/* The light leaves at the cosine 0.6 to the cone's axis. */
static void spot_in_mirror(law_room *room) {
    const double inner = cos((double)0.2f), outer = cos((double)1.2f);
    const double falloff = pow(fmin((0.6 - outer) / (inner - outer), 1), 2);
    lamp_in_mirror(room, FATHOM_LIGHT_SPOT, gray(falloff * 1.5 / 0.25));
}

/* In a volume: 1 to the mirror, and 2 - R to the lamp's sphere. */
static void ball_in_coloured_mirror(law_room *room) {
    const vec3_f64 left = law_left;
    fathom_material m = law_tinted(law_clear(1));
    m.specular_factor = 0, m.ior = 1;
    paint_sphere(&room->b, origin, 16, m);
    lamp_in_mirror(room, FATHOM_LIGHT_POINT,
                   scale_f64(1.5 / 0.25, vec_f64(pow(left.x, 2.5), pow(left.y, 2.5), pow(left.z, 2.5))));
}

/* ---- a caustic: a lamp that also shines by a mirror, as by its image behind it ---- */

/* (R/d)² cos θ of a ball, in the mean over the square of this side around the origin, by the midpoint rule:
 * its error is below 1e-6. */
static double ball_over_square(vec3_f64 center, double radius, double side) {
    enum { STEPS = 512 };
    double sum = 0;
    for (int k = 0; k < STEPS * STEPS; ++k) {
        const double x = ((k % STEPS + 0.5) / STEPS - 0.5) * side,
                     y = ((k / STEPS + 0.5) / STEPS - 0.5) * side;
        const vec3_f64 way = sub_f64(center, vec_f64(x, y, 0));
        const double d2 = dot_f64(way, way);
        sum += radius * radius * way.z / (d2 * sqrt(d2));
    }
    return sum / (STEPS * STEPS);
}

/* The mirror at x = 1.2 shows the whole lamp to each point of the square, and to few others. Two bounces: its
 * light from the floor does not come back. The lamp is so small that photons bring the mirror's light. */
static void lamp_by_mirror(law_room *room) {
    const double side = 2, radius = 0.05, back = 0.9;
    const vec3_f64 at = vec_f64(-0.9, 0, 1), image = vec_f64(3.3, 0, 1);
    fathom_material mirror = build_black();
    build_rgb(mirror.k_r, gray(back));
    paint_plane(&room->b, origin, up, build_lambert(albedo));
    paint_quad(&room->b, vec_f64(1.2, 0, 0.3), vec_f64(0, 1, 0), vec_f64(0, 0, 0.29), mirror);
    paint_sphere(&room->b, at, radius, lamp());
    law_look_down(room, 3, side);
    law_value(
        room,
        scale_f64(ball_over_square(at, radius, side) + back * ball_over_square(image, radius, side), albedo));
    room->depth = 2;
}

static void many_points(law_room *room) {
    double sum = 0;
    for (int i = 0; i < 40; ++i) {
        const vec3_f64 at = {1 + 0.25 * i, 0.5 * (i % 5), 1 + 0.5 * (i % 3)};
        const double d2 = dot_f64(at, at), k = i % 7 ? 0.1 : 4;
        build_point_light(&room->b, at, gray(k), 0);
        sum += k * at.z / (d2 * sqrt(d2));
    }
    floor_under(room, sum);
}

/* The light of several kinds of lights adds up. */
static void several(law_room *room) {
    const double R = 0.5, d = 2, angle = 0.6;
    sun_over_floor(room);
    paint_sphere(&room->b, vec_f64(0, d * sin(angle), d * cos(angle)), R, lamp());
    build_point_light(&room->b, vec_f64(1, 0, 1), gray(2), 0);
    build_background(&room->b, gray(0.25));
    law_value(room, scale_f64(1 + 0.75 * R / d * (R / d) * cos(angle) + 2 / sqrt(8) + 0.25, albedo));
}

const law laws_of_lights[] = {{"rectangle over a floor", "configuration factor", rectangle, 0},
                              {"tilted triangle over a floor", "Lambert's edge sum", tilted_triangle, 0},
                              {"pentagon cut by the horizon", "Lambert's edge sum", cut_pentagon, 0},
                              {"parallel squares", "form factor", parallel_squares, 0},
                              {"sky through a hole", "form factor", sky_through_hole, 0},
                              {"sun and sky through a hole", "form factor, k_l cos θ", sun_through_hole, 0},
                              {"disk of 1,998 triangles", "½(1-(1+H²-R²)/√(Z²-4R²))", disk_of_triangles, 0},
                              {"disk, a squeezed sphere", "½(1-(1+H²-R²)/√(Z²-4R²))", disk_squeezed, 0},
                              {"sphere above the horizon", "(R/d)² cos θ", sphere_above, 0},
                              {"sphere of half a surface", "¾ (R/d)² cos θ", sphere_half_there, 0},
                              {"sphere before a wall", "(R/d)² cos θ", sphere_before_wall, 0},
                              {"sphere cut by the horizon", "configuration factor", sphere_cut, 1.3},
                              {"sphere mostly below the horizon", "configuration factor", sphere_cut, 1.8},
                              {"point light", "k_l cos θ/d²", point_over_floor, 0},
                              {"point light with a radius", "k_l cos θ/d²", point_over_floor, 0.75},
                              {"directional light", "k_l cos θ", sun_over_floor, 0},
                              {"directional light with a radius", "k_l cos θ", sun_over_floor, 0.3},
                              {"sun in a mirror", "k_l/sin²a", sun_in_mirror, 0.3},
                              {"lamp in a mirror", "k_l/R²", ball_in_mirror, 0},
                              {"spot light in a mirror", "k_l f/R²", spot_in_mirror, 0},
                              {"lamp in a mirror and a volume", "k_l c^(d-R)/R²", ball_in_coloured_mirror, 0},
                              {"lamp by a mirror", "mean of Σ (R/d)² cos θ", lamp_by_mirror, 0},
                              {"forty point lights", "Σ k_l cos θ/d²", many_points, 0},
                              {"lights of four kinds", "sum", several, 0},
                              {NULL, NULL, NULL, 0}};
