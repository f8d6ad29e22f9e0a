#include "verify/laws/common.h"

#include "base/status.h"
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

fathom_status law_open(fathom_context *context, const law *made, law_room *out) {
    *out = (law_room){.depth = 64, .number = made->number};
    build_open(context, &out->b);
    if (out->b.status == FATHOM_OK) made->make(out);
    if (out->b.status == FATHOM_OK) out->b.status = fathom_scene_check(out->b.scene);
    return out->b.status;
}

void law_close(law_room *room) {
    fathom_scene_destroy(room->b.scene);
    if (room->sky[0]) unlink(room->sky);
}

fathom_material law_metallic(void) {
    fathom_material m;
    fathom_material_default(&m);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = m.roughness = m.specular_factor = 0;
    m.multiscatter = false;
    return m;
}

void law_fan(law_room *room, const vec3_f64 *corners, uint32_t count, fathom_material m) {
    uint32_t *indices = malloc(3 * (size_t)count * sizeof *indices);
    if (!indices) room->b.status = fail_memory(room->b.context, 12 * (size_t)count);
    for (uint32_t i = 0; i < 3 * (count - 2) && indices; ++i) indices[i] = i % 3 ? i / 3 + i % 3 : 0;
    build_triangles(&room->b, origin, corners, count, indices, count - 2, build_material(&room->b, m));
    free(indices);
}

void law_box(law_room *room, bool meshes, fathom_material m) {
    for (int i = 0; i < 6; ++i) {
        const double side = i % 2 ? 1 : -1;
        double axis[3][3] = {{0}};
        for (int k = 0; k < 3; ++k) axis[k][(i / 2 + k) % 3] = 1;
        const vec3_f64 c = scale_f64(side, load_f64(axis[0])), u = load_f64(axis[1]), v = load_f64(axis[2]);
        const vec3_f64 corners[4] = {sub_f64(sub_f64(c, u), v), sub_f64(add_f64(c, u), v),
                                     add_f64(add_f64(c, u), v), add_f64(sub_f64(c, u), v)};
        if (meshes)
            law_fan(room, corners, 4, m);
        else
            paint_quad(&room->b, c, u, v, m);
    }
}

static vec3_f64 sky_direction(uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
    const double turn = 2 * M_PI * ((x + 0.5) / width - 0.5), rise = M_PI * (0.5 - (y + 0.5) / height);
    return vec_f64(sin(turn) * cos(rise), sin(rise), -cos(turn) * cos(rise));
}

static fathom_status write_sky(const law_room *room, vec3_f64 (*radiance)(vec3_f64 direction)) {
    enum { WIDTH = 1024, HEIGHT = 512 };
    float(*pixels)[3] = malloc((size_t)WIDTH * HEIGHT * sizeof *pixels);
    if (!pixels) return fail_memory(room->b.context, (size_t)WIDTH * HEIGHT * sizeof *pixels);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i)
        build_rgb(pixels[i], radiance(sky_direction(i % WIDTH, i / WIDTH, WIDTH, HEIGHT)));
    static const char *const names[3] = {"R", "G", "B"};
    image_channel channels[3];
    for (int c = 0; c < 3; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, false, &pixels[0][c], sizeof *pixels};
    const image sky = {.width = WIDTH,
                       .height = HEIGHT,
                       .full_width = WIDTH,
                       .full_height = HEIGHT,
                       .channels = channels,
                       .channel_count = 3};
    const fathom_status status = exr_write_plain(room->b.context, &sky, room->sky);
    free(pixels);
    return status;
}

void law_sky(law_room *room, vec3_f64 (*radiance)(vec3_f64 direction)) {
    const char *folder = getenv("TMPDIR");
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = room->sky;
    snprintf(room->sky, sizeof room->sky, "%.200s/fathom-sky-XXXXXX.exr",
             folder && *folder ? folder : "/tmp");
    const int file = mkstemps(room->sky, 4);
    if (file >= 0) close(file);
    if (file < 0 && room->b.status == FATHOM_OK) {
        room->b.status = fail_file(room->b.context, FATHOM_OUT_OF_RESOURCES, room->sky, "cannot be created");
        room->sky[0] = 0;
    }
    if (room->b.status == FATHOM_OK) room->b.status = write_sky(room, radiance);
    build_light(&room->b, &light);
}

static void set_camera(law_room *room, vec3_f64 eye, vec3_f64 target, double slope) {
    fathom_camera camera = build_view(eye, target, 1);
    camera.d = 1, camera.h = slope;
    build_camera(&room->b, camera);
}

void law_look(law_room *room, vec3_f64 eye, vec3_f64 target) { set_camera(room, eye, target, 1.0 / 4096); }

void law_look_down(law_room *room, double eye_z, double side) {
    set_camera(room, (vec3_f64){0, 0, eye_z}, origin, side / eye_z);
}

void law_value(law_room *room, vec3_f64 value) { store_f64(room->value, value); }

double law_powers(double x, int from, int to) {
    double sum = 0;
    for (int k = from; k <= to; ++k) sum += pow(x, k);
    return sum;
}

vec3_f64 law_each(vec3_f64 rho, double (*of)(double rho, const double *numbers), const double *numbers) {
    return vec_f64(of(rho.x, numbers), of(rho.y, numbers), of(rho.z, numbers));
}

/* The part of the polygon with z > 0; `out` has room for twice as many corners. */
static uint32_t above_floor(const vec3_f64 *p, uint32_t count, vec3_f64 *out) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const vec3_f64 a = p[i], b = p[(i + 1) % count];
        if (a.z > 0) out[kept++] = a;
        if ((a.z > 0) != (b.z > 0)) out[kept++] = madd_f64(a, a.z / (a.z - b.z), sub_f64(b, a));
    }
    return kept;
}

/* Lambert's sum over edges, for the origin with the normal z. */
static double edge_sum(const vec3_f64 *p, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const vec3_f64 a = normalize_f64(p[i]), b = normalize_f64(p[(i + 1) % count]), c = cross_f64(a, b);
        const double sine = length_f64(c);
        if (sine > 0) sum += atan2(sine, dot_f64(a, b)) * c.z / sine;
    }
    return fabs(sum) / (2 * M_PI);
}

double law_polygon(const vec3_f64 *corners, uint32_t count) {
    vec3_f64 kept[LAW_CORNERS * 2];
    return edge_sum(kept, above_floor(corners, count, kept));
}

void law_lobe(law_room *room, fathom_material m, vec3_f64 from, vec3_f64 value) {
    paint_quad(&room->b, origin, vec_f64(9, 0, 0), vec_f64(0, 9, 0), m);
    build_background(&room->b, white);
    law_look(room, from, origin);
    law_value(room, value);
}

double law_ball(law_room *room, fathom_material m) {
    const double R = 0.5, d = 2, angle = 0.6;
    paint_sphere(&room->b, vec_f64(d * sin(angle), 0, d * cos(angle)), R, m);
    return R / d * (R / d) * cos(angle);
}

void law_unseen_ball(law_room *room, fathom_material m) {
    paint_sphere(&room->b, origin, 1, m);
    build_background(&room->b, white);
    law_look(room, vec_f64(0, 0.3, 3), vec_f64(0.5, 0.3, 0));
    law_value(room, white);
}

fathom_material law_clear(double thickness) {
    fathom_material m = law_metallic();
    m.transmission = m.specular_factor = 1, m.thickness = (float)thickness;
    return m;
}

fathom_material law_tinted(fathom_material m) {
    m.attenuation_distance = 1;
    build_rgb(m.attenuation_color, law_left);
    return m;
}

/* Integrates ∫ D G₂ v·h / n·v dh by the midpoint rule over half vectors h whose reflected direction leaves
 * the surface. Accurate to 1e-6 for alphas from 0.3. */
double law_ggx_albedo(double ax, double ay, vec3_f64 v) {
    enum { RINGS = 1500, AROUND = 1000 };
    double sum = 0;
    const double lv = sqrt(square(ax * v.x) + square(ay * v.y) + square(v.z));
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double theta = M_PI / 2 * (i / AROUND + 0.5) / RINGS,
                     phi = 2 * M_PI * (i % AROUND + 0.5) / AROUND;
        const vec3_f64 h = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
        const double vh = dot_f64(v, h);
        const vec3_f64 l = sub_f64(scale_f64(2 * vh, h), v);
        if (!(vh > 0 && l.z > 0)) continue;
        const double ll = sqrt(square(ax * l.x) + square(ay * l.y) + square(l.z));
        const double d = 1 / (M_PI * ax * ay * square(square(h.x / ax) + square(h.y / ay) + square(h.z)));
        sum += d * 2 * l.z / (l.z * lv + v.z * ll) * vh * sin(theta);
    }
    return sum * (M_PI / 2 / RINGS) * (2 * M_PI / AROUND);
}
