/* One framing for the frames of an animation. */
#include "base/sized.h"
#include "scene/camera/camera.h"

#include <math.h>

fathom_status fathom_scene_framing(const fathom_scene *scene, fathom_framing *out) {
    const fathom_framing none = {.made = false};
    const fathom_status status = sized_check(NULL, "out", out, sizeof none);
    if (status == FATHOM_OK) sized_write(out, scene ? &scene->framing : &none, sizeof none);
    return status;
}

static void add_times(const double *times, uint32_t count, double out[2]) {
    for (uint32_t k = 0; k < count; ++k) out[0] = fmin(out[0], times[k]), out[1] = fmax(out[1], times[k]);
}

bool fathom_scene_framed_times(const fathom_scene *scene, double out[2]) {
    if (!scene || !out || (scene->has_camera && !scene->made.camera)) return false;
    out[0] = scene->played[0], out[1] = scene->played[1];
    /* The keys of a posed animation are times while the shutter is open. */
    for (size_t i = 0; i < scene->instances.count && !scene->has_animations; ++i)
        add_times(scene->instances.items[i].key_times, scene->instances.items[i].key_count, out);
    for (size_t i = 0; i < scene->meshes.count && !scene->has_animations; ++i)
        add_times(scene->meshes.items[i].key_times, scene->meshes.items[i].key_count, out);
    return out[0] < out[1];
}

/* An eye at e sees points up to e.x + s e.z on each side (framing.c). The new eye is at least as far away as
 * both. */
static vec3_f64 unite_eyes(const fathom_framing *f, const fathom_framing *other) {
    const vec3_f64 z = load_f64(f->axes[2]);
    double back = fmax(dot_f64(load_f64(f->eye), z), dot_f64(load_f64(other->eye), z)), middle[2];
    for (int i = 0; i < 2; ++i) {
        back = fmax(back, (f->reach[2 * i] + f->reach[2 * i + 1]) / (2 * f->slopes[i]));
        middle[i] = (f->reach[2 * i] - f->reach[2 * i + 1]) / 2;
    }
    return madd_f64(madd_f64(scale_f64(back, z), middle[0], load_f64(f->axes[0])), middle[1],
                    load_f64(f->axes[1]));
}

/* The common foot is as low as the lower one and lies between the two. The radius includes both. */
static void unite_feet(fathom_framing *f, const fathom_framing *other) {
    if (!(f->radius > 0) || !(other->radius > 0)) return;
    const vec3_f64 up = f->up == FATHOM_UP_Z ? vec_f64(0, 0, 1) : vec_f64(0, 1, 0), a = load_f64(f->foot),
                   b = load_f64(other->foot);
    const vec3_f64 d = sub_f64(b, a);
    const double rise = dot_f64(d, up);
    const vec3_f64 level = madd_f64(d, -rise, up);
    const double apart = length_f64(level);
    if (apart + other->radius <= f->radius) {
        store_f64(f->foot, madd_f64(a, fmin(rise, 0), up));
        return;
    }
    const double radius = fmax((apart + f->radius + other->radius) / 2, other->radius),
                 share = apart > 0 ? fmin((radius - f->radius) / apart, 1) : 0;
    store_f64(f->foot, madd_f64(madd_f64(a, share, level), fmin(rise, 0), up));
    f->radius = radius;
}

void fathom_framing_unite(fathom_framing *framing, const fathom_framing *other) {
    if (!framing || !other || !framing->made || !other->made) return;
    bool beyond = false;
    for (int i = 0; i < 4; ++i) {
        beyond |= other->reach[i] > framing->reach[i];
        framing->reach[i] = fmax(framing->reach[i], other->reach[i]);
    }
    if (beyond) store_f64(framing->eye, unite_eyes(framing, other));
    unite_feet(framing, other);
}
