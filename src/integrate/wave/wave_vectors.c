/* Motion vectors: how far the surface point that a sample shows moves in the image, from the middle of the
 * shutter's time to its end and to its beginning. */
#include "integrate/wave/wave.h"

#include <stdlib.h>

/* The times when the shutter opens, is halfway, and closes. */
enum { OPEN, MIDDLE, CLOSE, TIMES };
static const float times[TIMES] = {0, 0.5f, 1};

bool wave_create_vectors(wave *w) {
    const render_plan *plan = w->run.plan;
    if (!plan->moves || !(plan->settings.aovs & FATHOM_AOV_MOTION)) return true;
    w->cameras = malloc(TIMES * sizeof *w->cameras);
    for (int k = 0; w->cameras && k < TIMES; ++k) wave_camera_when(plan, times[k], &w->cameras[k]);
    return w->cameras;
}

/* u increases to the right and v upwards, in pixels. A point that is behind the camera at one of the times
 * does not move. */
static void keep(first_hits *f, uint32_t slot, const shade_camera *cameras, const vec3_f64 from_eye[TIMES]) {
    double x[TIMES], y[TIMES];
    for (int c = 0; c < 4; ++c) f->motion[c][slot] = 0;
    for (int k = 0; k < TIMES; ++k) {
        if (!camera_place(&cameras[k], from_eye[k], &x[k], &y[k])) return;
    }
    f->motion[0][slot] = (float)(x[CLOSE] - x[MIDDLE]), f->motion[1][slot] = (float)(y[MIDDLE] - y[CLOSE]);
    f->motion[2][slot] = (float)(x[OPEN] - x[MIDDLE]), f->motion[3][slot] = (float)(y[MIDDLE] - y[OPEN]);
}

static vec3_f64 map_point(const float m[3][4], vec3_f64 p) {
    const double at[3] = {p.x, p.y, p.z};
    double to[3];
    for (int i = 0; i < 3; ++i) {
        to[i] = (double)m[i][3];
        for (int k = 0; k < 3; ++k) to[i] += (double)m[i][k] * at[k];
    }
    return vec_f64(to[0], to[1], to[2]);
}

/* The point of a mesh with moving vertices, from its weights of the corners, in the mesh's own space. */
static vec3_f64 shaped_point(const wave *w, unsigned i, float time) {
    const world *scene = w->run.plan->world;
    const surface_gather *g = w->gather;
    vec3_f32 corner[3];
    vec3_f64 p = {0, 0, 0};
    world_corners_when(scene, &scene->geometries.items[g->geometry[i]], g->primitive[i], time, corner, NULL);
    for (int k = 0; k < 3; ++k) p = madd_f64(p, (double)g->local.weight[k][i], widen(corner[k]));
    return p;
}

void wave_keep_vectors(wave *w, unsigned i, uint32_t slot) {
    const world *scene = w->run.plan->world;
    const surface_gather *g = w->gather;
    const vec3_f64 p = vec_f64(g->local.p[0][i], g->local.p[1][i], g->local.p[2][i]);
    const bool placed = g->geometry[i] != TRACE_PLANE && g->instance[i] != FATHOM_NONE,
               travels = placed && scene->instances.items[g->instance[i]].moving, bends = g->shaped >> i & 1;
    vec3_f64 from_eye[TIMES];
    for (int k = 0; k < TIMES; ++k) {
        vec3_f64 at =
            bends ? shaped_point(w, i, times[k]) : (travels ? map_point(g->placed[i]->to_object, p) : p);
        if (travels || (bends && placed)) {
            world_instance moved;
            at = map_point(world_instance_when(scene, g->instance[i], times[k], &moved)->to_world, at);
        }
        from_eye[k] = sub_f64(at, plan_eye(w->run.plan, &w->cameras[k]));
    }
    keep(w->run.samples.first, slot, w->cameras, from_eye);
}

/* For an orthographic camera, points at infinity have no position in the image: the background does not
 * move. */
void wave_keep_far_vectors(wave *w, vec3_f32 direction, uint32_t slot) {
    const vec3_f64 d = widen(direction);
    if (!w->cameras->parallel) keep(w->run.samples.first, slot, w->cameras, (vec3_f64[TIMES]){d, d, d});
}
