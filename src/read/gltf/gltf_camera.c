/* Cameras. The walk over the hierarchy notes the nodes with a camera; the
 * chosen one is read when all are known. It looks along its node's -z axis; the node's scale only affects the
 * position.
 *
 * yfov applies to any aspect ratio of the image, as in Blender's importer: pixels are square. aspectRatio
 * sets the image's aspect ratio if no size is requested. The specification (2.0, Projection Matrices) says
 * that a view should be neither cropped nor stretched when the aspect ratios differ. Here, nothing is
 * stretched; an image narrower than the camera's view crops its sides, with a warning. */
#include "math/frame.h"
#include "read/gltf/gltf_pose.h"
#include "read/gltf/gltf_tree.h"
#include "scene/camera/camera.h"

#include <math.h>
#include <string.h>

/* Charges the camera's memory: many nodes may have the same camera, so its name may be copied often. */
static void charge(gltf *g, const gltf_value *node, const char *own_name) {
    const size_t kept = sizeof(gltf_camera) + sizeof(scene_camera);
    gltf_charge(g, node, "camera", 3 * kept + (own_name ? strlen(own_name) : 0));
}

void gltf_camera_note(gltf *g, const gltf_value *node, uint32_t link) {
    gltf_value camera;
    gltf_camera noted = {.link = link, .index = GLTF_ABSENT};
    gltf_index(g, node, "camera", &g->cameras, &noted.index);
    if (noted.index == GLTF_ABSENT) return;
    gltf_item(g, &g->cameras, noted.index, &camera);
    const bool orthographic =
        gltf_word(g, &camera, "type", "perspective|orthographic", "perspective or orthographic", 0);
    charge(g, node, gltf_name(camera.json));
    if (!gltf_fine(g)) return;
    if (array_push(&g->seen_cameras, noted))
        g->status = scene_note_camera(g->scene, gltf_name(node->json), gltf_name(camera.json), orthographic);
    else
        gltf_fail_memory(g, sizeof noted);
}

/* Without zfar, the view has no end. */
static void read_planes(gltf *g, const gltf_value *projection, fathom_camera *camera) {
    double near = 0, far = 0;
    gltf_number(g, projection, "znear", -INFINITY, INFINITY, &near);
    gltf_number(g, projection, "zfar", -INFINITY, INFINITY, &far);
    if (!(near >= 0 && (far > near || far == 0))) {
        gltf_note(g, projection, "zfar", "expected 0 <= znear < zfar; nothing is clipped");
        return;
    }
    camera->near_clip = near * gltf_unit(g), camera->far_clip = far * gltf_unit(g);
}

/* xmag and ymag are half the width and height of the view; their signs are ignored. */
static void read_orthographic(gltf *g, const gltf_value *value, fathom_camera *camera, double *aspect) {
    gltf_value orthographic;
    double across = 0, up = 0;
    gltf_object(g, value, "orthographic", &orthographic);
    gltf_number(g, &orthographic, "xmag", -1e30, 1e30, &across);
    gltf_number(g, &orthographic, "ymag", -1e30, 1e30, &up);
    if (across == 0 || up == 0)
        gltf_fail(g, &orthographic, NULL, "has xmag %g and ymag %g; expected numbers other than 0", across,
                  up);
    read_planes(g, &orthographic, camera);
    camera->h = 2 * fabs(up) * gltf_unit(g);
    *aspect = fabs(across / up);
}

static void read_perspective(gltf *g, const gltf_value *value, fathom_camera *camera, double *aspect) {
    gltf_value perspective;
    double fovy = 0;
    *aspect = 0;
    gltf_object(g, value, "perspective", &perspective);
    gltf_number(g, &perspective, "yfov", 0, INFINITY, &fovy);
    gltf_number(g, &perspective, "aspectRatio", 0, INFINITY, aspect);
    if (!(fovy > 0 && fovy < M_PI)) {
        gltf_note(g, &perspective, "yfov", "expected radians between 0 and pi; 45 degrees are taken");
        fovy = M_PI / 4;
    }
    read_planes(g, &perspective, camera);
    camera->h = 2 * tan(fovy / 2);
}

/* The camera's frame; scale affects only its position. */
static affine_f64 frame_of(const gltf *g, const affine_f64 *to_world) {
    const frame_f64 frame = frame_from(scale_f64(gltf_unit(g), affine_point(to_world, (vec3_f64){0, 0, 0})),
                                       affine_vector(to_world, (vec3_f64){0, 0, 1}),
                                       affine_vector(to_world, (vec3_f64){0, 1, 0}));
    return frame_affine(&frame);
}

static void set_camera(gltf *g, const gltf_value *node, fathom_camera camera, gltf_way *way) {
    for (size_t k = 0; k < way->count; ++k) way->at[k] = frame_of(g, &way->at[k]);
    for (int i = 0; i < 3; ++i) {
        const double *row = way->at[0].m[i];
        camera.x[i] = row[0], camera.y[i] = row[1], camera.z[i] = row[2], camera.origin[i] = row[3];
    }
    if (gltf_way_moves(way)) {
        camera.shutter[0] = g->key_times[0], camera.shutter[1] = g->key_times[way->count - 1];
        camera.key_count = (uint32_t)way->count, camera.key_times = g->key_times;
        camera.key_frames = &way->at[0].m[0][0];
    }
    gltf_within(g, node, NULL, fathom_scene_set_camera(g->scene, &camera));
}

void gltf_camera_take(gltf *g) {
    g->status = scene_choose_camera(g->scene, g->path);
    if (!gltf_fine(g) || g->scene->camera_taken == FATHOM_NONE) return;
    const gltf_camera *taken = &g->seen_cameras.items[g->scene->camera_taken];
    gltf_value node, at;
    gltf_way way;
    fathom_camera camera = {.d = 1,
                            .orthographic = g->scene->cameras.items[g->scene->camera_taken].orthographic};
    double aspect;
    gltf_item(g, &g->nodes, g->links.items[taken->link].node, &node);
    gltf_item(g, &g->cameras, taken->index, &at);
    if (camera.orthographic)
        read_orthographic(g, &at, &camera, &aspect);
    else
        read_perspective(g, &at, &camera, &aspect);
    gltf_node_way(g, taken->link, &way);
    if (!gltf_fine(g)) return;
    g->scene->camera_aspect = aspect;
    if (aspect > 0) image_size_follow(&g->scene->settings, aspect, false, false);
    set_camera(g, &node, camera, &way);
}
