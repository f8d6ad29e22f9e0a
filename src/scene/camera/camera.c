#include "scene/camera/camera.h"

#include "base/sized.h"
#include "math/rgb.h"
#include "scene/motion/motion.h"

static const double default_fovy = 0.78539816339744831; /* 45 degrees */

static void set_frame(fathom_camera *camera, const frame_f64 *frame) {
    store_f64(camera->origin, frame->origin);
    store_f64(camera->x, frame->x);
    store_f64(camera->y, frame->y);
    store_f64(camera->z, frame->z);
}

void fathom_camera_look_at_sized(const double eye[3], const double target[3], const double up[3], double fovy,
                                 fathom_camera *out, size_t size) {
    if (!eye || !target || !up) return;
    vec3_f64 e = load_f64(eye);
    frame_f64 frame = frame_from(e, sub_f64(e, load_f64(target)), load_f64(up));
    fathom_camera camera = {.d = 1, .h = 2 * tan(fovy / 2)};
    set_frame(&camera, &frame);
    sized_give(out, size, &camera, sizeof camera);
}

void fathom_camera_default_sized(fathom_camera *camera, size_t size) {
    fathom_camera_look_at_sized((double[3]){0, 0, 0}, (double[3]){0, 0, -1}, (double[3]){0, 1, 0},
                                default_fovy, camera, size);
}

static bool is_frame(const fathom_camera *camera) {
    vec3_f64 x = load_f64(camera->x), y = load_f64(camera->y), z = load_f64(camera->z);
    /* Frames may come from float (glTF) or decimal text, so axes count as orthonormal if they are accurate to
     * 1e-4. */
    const double slack = 1e-4;
    return finite_f64(load_f64(camera->origin)) && fabs(dot_f64(x, x) - 1) < slack &&
           fabs(dot_f64(y, y) - 1) < slack && fabs(dot_f64(z, z) - 1) < slack &&
           fabs(dot_f64(x, y)) < slack && fabs(dot_f64(x, z)) < slack && fabs(dot_f64(y, z)) < slack &&
           dot_f64(cross_f64(x, y), z) > 0;
}

static fathom_status check_camera(fathom_context *context, const fathom_camera *camera) {
    if (!is_frame(camera)) {
        return fail_field(
            context, FATHOM_BAD_INPUT, "camera",
            "the axes are not a right-handed frame of unit vectors at right angles, or not finite");
    }
    if (!(camera->d > 0 && camera->h > 0 && camera->w >= 0) || !isfinite(camera->d + camera->h + camera->w)) {
        return fail_field(
            context, FATHOM_BAD_INPUT, "camera",
            "expected d > 0, h > 0 and w >= 0, found d %g, h %g and w %g; a field of view must lie "
            "between 0 and 180 degrees",
            camera->d, camera->h, camera->w);
    }
    const bool lens = camera->lens_radius != 0;
    if (camera->orthographic && (lens || camera->w > 0))
        return fail_field(
            context, FATHOM_BAD_INPUT, "camera",
            "expected neither a lens nor w of an orthographic one, found a lens radius of %g and "
            "w %g; it has no plane of focus, and its pixels are square",
            camera->lens_radius, camera->w);
    if (!(camera->lens_radius >= 0) || isinf(camera->lens_radius) ||
        (lens && !(camera->focus_distance > 0 && isfinite(camera->focus_distance)))) {
        return fail_field(context, FATHOM_BAD_INPUT, "camera",
                          "expected a lens radius of at least 0, and with a lens a focus distance above 0; "
                          "found %g and %g",
                          camera->lens_radius, camera->focus_distance);
    }
    if (camera->blades && (camera->blades < 3 || camera->blades > 64 || !isfinite(camera->blade_rotation)))
        return fail_field(context, FATHOM_BAD_INPUT, "camera",
                          "expected no blades or 3 to 64, and a finite rotation; found %u and %g",
                          camera->blades, camera->blade_rotation);
    if (!(camera->near_clip >= 0 && isfinite(camera->near_clip) && isfinite(camera->far_clip)) ||
        !(camera->far_clip == 0 || camera->far_clip > camera->near_clip))
        return fail_field(context, FATHOM_BAD_INPUT, "camera",
                          "expected a near plane at 0 or farther, and a far plane behind it or none (0); "
                          "found %g and %g",
                          camera->near_clip, camera->far_clip);
    if (!isfinite(camera->shutter[0]) || !isfinite(camera->shutter[1]) ||
        camera->shutter[1] < camera->shutter[0])
        return fail_field(
            context, FATHOM_BAD_INPUT, "shutter",
            "expected a time when it opens, and then one when it closes, both finite; found %g and %g",
            camera->shutter[0], camera->shutter[1]);
    return FATHOM_OK;
}

/* Each key must be a valid frame, as the camera's own. */
static fathom_status check_keys(fathom_context *context, const fathom_camera *camera) {
    fathom_status status = motion_check_keys(context, camera->key_times, camera->key_count);
    if (status == FATHOM_OK && !camera->key_frames) status = fail_null(context, "key_frames");
    for (uint32_t k = 0; k < camera->key_count && status == FATHOM_OK; ++k) {
        const fathom_camera at = motion_camera(camera, camera->key_times[k]);
        if (!is_frame(&at))
            status = fail_item(context, FATHOM_BAD_INPUT, "key_frames", k,
                               "expected a right-handed frame of unit vectors at right angles");
    }
    return status;
}

static fathom_status adopt_keys(fathom_scene *scene, fathom_camera *camera) {
    fathom_status status = check_keys(scene->context, camera);
    if (status == FATHOM_OK)
        status = motion_copy_keys(scene, camera->key_count, 12, &camera->key_times, &camera->key_frames);
    return status;
}

/* The camera as it is when the shutter opens, with all keys. Code that ignores motion uses this frame. */
static fathom_camera camera_when_open(const fathom_camera *camera) {
    fathom_camera out = motion_camera(camera, camera->shutter[0]);
    out.key_count = camera->key_count;
    out.key_times = camera->key_times, out.key_frames = camera->key_frames;
    return out;
}

fathom_status fathom_scene_set_camera_sized(fathom_scene *scene, const fathom_camera *camera, size_t size) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_camera item;
    fathom_status status = SIZED_ITEM(scene->context, fathom_camera, camera, size, &item);
    if (status == FATHOM_OK) status = check_camera(scene->context, &item);
    if (status == FATHOM_OK && item.key_count) status = adopt_keys(scene, &item);
    if (status != FATHOM_OK) return status;
    if (item.key_count) item = camera_when_open(&item);
    scene->camera = item;
    frame_f64 frame = frame_from(load_f64(item.origin), load_f64(item.z), load_f64(item.y));
    set_frame(&scene->camera, &frame);
    scene->has_camera = true, scene->made.camera = false;
    scene->framing = (fathom_framing){.made = false};
    return FATHOM_OK;
}

/* ---- completing ---- */

/* The scene fills this fraction of the image in the tighter direction. */
static const double filled = 0.9;

bool scene_framing_asked(const fathom_scene *scene) {
    return scene->asked && scene->asked->framing && scene->asked->framing->made;
}

static fathom_up asked_up(const fathom_scene *scene) { return scene->asked ? scene->asked->up : FATHOM_UP_Y; }

vec3_f64 scene_way_up(const fathom_scene *scene) {
    return asked_up(scene) == FATHOM_UP_Z ? vec_f64(0, 0, 1) : vec_f64(0, 1, 0);
}

/* The axes of the automatic camera. By default it looks at the front of the scene from slightly right and
 * above. From straight above it keeps the front below. */
static frame_f64 view_of(const fathom_scene *scene) {
    static const double right = 0.45, above = 0.35;
    const fathom_read_options *asked = scene->asked;
    const vec3_f64 origin = {0, 0, 0}, up = scene_way_up(scene);
    const bool z_up = asked_up(scene) == FATHOM_UP_Z;
    vec3_f64 back = z_up ? vec_f64(right, -1, above) : vec_f64(right, above, 1);
    if (!asked || !(asked->choose_azimuth || asked->choose_elevation)) return frame_from(origin, back, up);
    const double a = asked->choose_azimuth ? asked->azimuth : atan(right),
                 e = asked->choose_elevation ? asked->elevation : atan(above / hypot(right, 1));
    const vec3_f64 front = z_up ? vec_f64(0, -1, 0) : vec_f64(0, 0, 1),
                   level = madd_f64(scale_f64(cos(a), front), sin(a), vec_f64(1, 0, 0));
    back = madd_f64(scale_f64(cos(e), level), sin(e), up);
    return frame_from(origin, back, madd_f64(scale_f64(cos(e), up), -sin(e), level));
}

static void keep_axes(const frame_f64 *view, fathom_framing *out) {
    store_f64(out->axes[0], view->x), store_f64(out->axes[1], view->y), store_f64(out->axes[2], view->z);
}

static fathom_status frame_everything(fathom_scene *scene) {
    const image_size size = scene_image_size(scene);
    frame_f64 view = view_of(scene);
    const double up = filled * tan(default_fovy / 2);
    fathom_framing found = {
        .made = true, .up = asked_up(scene), .slopes = {up * size.width / size.height, up}};
    bool empty = false;
    fathom_status status = FATHOM_OK;
    if (scene_framing_asked(scene))
        found = *scene->asked->framing;
    else
        status = scene_frame_all(scene, &view, &empty, &found);
    if (status != FATHOM_OK || empty) return status;
    keep_axes(&view, &found);
    scene->framing = found;
    view.origin = load_f64(found.eye);
    const double *shutter = scene->camera.shutter;
    scene->camera =
        (fathom_camera){.d = 1, .h = 2 * tan(default_fovy / 2), .shutter = {shutter[0], shutter[1]}};
    set_frame(&scene->camera, &view);
    scene->has_camera = scene->made.camera = true;
    return FATHOM_OK;
}

/* Adds a key light from the camera's upper left, and a weak one from its right that keeps shadowed sides
 * visible. Both are directional, so they work at any scale. Adds some ambient light and a dark grey
 * background, unless the file has its own; they separate the shadowed side from the background. Path tracing
 * uses the studio instead (light/studio.h). */
static fathom_status light_everything(fathom_scene *scene) {
    vec3_f64 x = load_f64(scene->camera.x), y = load_f64(scene->camera.y), z = load_f64(scene->camera.z);
    const struct {
        double right, up, back;
        float rgb[3];
    } rig[] = {{-0.6, 0.9, 0.7, {0.85f, 0.82f, 0.78f}}, {0.9, 0.25, 0.5, {0.18f, 0.2f, 0.24f}}};
    for (size_t i = 0; i < sizeof rig / sizeof *rig; ++i) {
        fathom_light light;
        fathom_light_default(&light);
        light.type = FATHOM_LIGHT_DIRECTIONAL;
        vec3_f64 to_light = madd_f64(madd_f64(scale_f64(rig[i].right, x), rig[i].up, y), rig[i].back, z);
        store_f64(light.direction, neg_f64(to_light));
        for (int c = 0; c < 3; ++c) light.intensity[c] = rig[i].rgb[c];
        fathom_status status = fathom_scene_add_light(scene, &light, NULL);
        if (status != FATHOM_OK) return status;
    }
    fathom_status status = FATHOM_OK;
    const bool background = !scene->has_background, ambient = !scene->has_ambient;
    if (background) status = fathom_scene_set_background(scene, (float[3]){0.05f, 0.055f, 0.065f});
    if (status == FATHOM_OK && ambient)
        status = fathom_scene_set_ambient(scene, (float[3]){0.12f, 0.13f, 0.15f});
    scene->made.lights = true, scene->made.background = background, scene->made.ambient = ambient;
    scene->in_studio = background && ambient;
    scene->studio_up = scene_way_up(scene);
    return status;
}

static bool background_shines(const fathom_scene *scene) {
    const float *behind = scene->background;
    return scene->has_background && rgb_any(behind);
}

bool scene_replaces_lights(const fathom_scene *scene) {
    return scene->in_studio || (scene->made.ambient && background_shines(scene));
}

/* *out: true if, under path tracing, the background or the emissive surfaces light the scene. Emissive
 * surfaces that leave the rest of the scene dark, such as displays and signals, do not count. */
static fathom_status lights_itself(const fathom_scene *scene, bool *out) {
    *out = false;
    if (scene->settings.integrator == FATHOM_INTEGRATOR_CLASSIC) return FATHOM_OK;
    double irradiance = 0;
    fathom_status status = scene_measure_lamps(scene, &irradiance);
    *out = background_shines(scene) || irradiance >= LAMPS_SHARE * STUDIO_LUMINANCE * 3.14159265358979324;
    return status;
}

fathom_status fathom_scene_complete(fathom_scene *scene) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_status status = scene_check_cycles(scene);
    if (status != FATHOM_OK) return status;
    if (!scene->has_camera) {
        status = frame_everything(scene);
        if (status != FATHOM_OK) return status;
    }
    bool lit = scene->lights.count || scene->environments.count || scene->has_lights ||
               (scene->asked && scene->asked->no_studio);
    if (!lit) status = lights_itself(scene, &lit);
    return lit || status != FATHOM_OK ? status : light_everything(scene);
}
