/* Transforms of nodes, and their poses while the shutter is open. */
#pragma once

#include "read/gltf/gltf.h"

/* The components of a node's transform. */
enum { GLTF_TRANSLATION, GLTF_ROTATION, GLTF_SCALE, GLTF_PARTS };
extern const char *const gltf_part_names[GLTF_PARTS];

/* The pose that an animation gives a node. */
typedef struct gltf_pose {
    double parts[GLTF_PARTS][4];
    bool given[GLTF_PARTS];
    double *weights; /* of morph targets; NULL: not animated */
    size_t weight_count;
} gltf_pose;

typedef struct gltf_world {
    bool known;
    affine_f64 to_world;
} gltf_world;

#define GLTF_MOMENTS 65 /* at most */

/* A transform at each moment. */
struct gltf_way {
    size_t count;
    affine_f64 at[GLTF_MOMENTS];
};

/* The state of the nodes at one time. */
struct gltf_moment {
    double time; /* seconds */
    ARRAY(gltf_pose) poses;
    uint32_t *pose_of;  /* for each node, its index in poses plus 1; NULL: no animation is posed */
    gltf_world *worlds; /* for each link */
    gltf_joints *skins; /* two for each skin, the second mirrored; NULL: none is made yet */
};

/* ---- gltf_transform.c ---- */

/* The pose of a node; NULL: no animation poses it. */
const gltf_pose *gltf_pose_of(const gltf_moment *m, uint32_t node);
affine_f64 gltf_node_world(gltf *g, gltf_moment *m, uint32_t link);
/* True if the node's matrix replaces the components of its transform. */
bool gltf_has_matrix(const gltf_value *node);
affine_f64 gltf_compose(double parts[GLTF_PARTS][4]);
/* Checks that the last row of a matrix is 0 0 0 1, up to rounding error. */
void gltf_check_row(gltf *g, const gltf_value *at, const char *key, const double row[4]);
/* True when a quaternion is not zero. */
bool gltf_is_rotation(const double r[4]);

/* ---- gltf_animation.c ---- */

/* Sets g->playing to the requested animations. */
void gltf_animation_choose(gltf *g);
/* Poses the nodes by g->playing at the moment's time. */
void gltf_animation_pose(gltf *g, gltf_moment *m);
/* The value of samplers[index], `components` numbers, at a time. False: reading has failed. */
bool gltf_sampler_value(gltf *g, const gltf_value *samplers, uint32_t index, unsigned components, double time,
                        double out[4]);

/* ---- gltf_pointer.c ---- */

/* Replaces the value that a JSON pointer names by the sampler's of the middle of the shutter time: the
 * nearest to a mean, and to an image without blur. Adds a note if no reader would use the value. */
void gltf_pointer_pose(gltf *g, const gltf_value *target, const char *pointer, const gltf_value *samplers,
                       uint32_t sampler);

/* ---- gltf_motion.c ---- */

/* How long the shutter is open, in seconds; 0 if no animation is posed. */
double gltf_shutter(const gltf *g);
/* Fills in g->moments and g->key_times. */
void gltf_moments_open(gltf *g);
void gltf_moments_close(gltf *g);
/* True when the `count` shapes of one node at the moments differ. */
bool gltf_shapes_move(const gltf_shape *shapes, size_t count);
/* The link's transforms to the world, at all moments. */
void gltf_node_way(gltf *g, uint32_t link, gltf_way *out);
/* The motion of an object with the transform `inner` inside a parent with the motion `way`. */
void gltf_way_of(const gltf_way *way, const affine_f64 *inner, gltf_way *out);
bool gltf_way_moves(const gltf_way *way);
/* The transform in the middle of the shutter time: that of everything that is not blurred. */
affine_f64 gltf_way_middle(const gltf_way *way);
#define GLTF_HELD "it is shown as it is in the middle of the shutter time"
/* True if the first transform mirrors. */
bool gltf_way_mirrors(const gltf_way *way);
/* True if the first transform leaves a plane, and no volume. */
bool gltf_way_flattens(const gltf_way *way);
/* True if no transform is singular, and no axis passes through zero from one to the next. */
bool gltf_way_can_blur(const gltf_way *way);
