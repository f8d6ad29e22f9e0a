/* Trees: tapered cones for the wood, and leaves. */
#ifndef READ_GENERATE_TREE_H
#define READ_GENERATE_TREE_H

#include "generate/generate.h"

#define TREE_LEAST_TRIANGLES 24u
/* Trees of fewer triangles have closed crowns instead of single leaves. */
#define TREE_LEAFY_TRIANGLES 400u

typedef struct tree {
    bool conifer;
    uint32_t triangles; /* of wood and leaves together, exactly; >= TREE_LEAST_TRIANGLES */
    uint64_t seed;
    fathom_id bark, leaves; /* materials */
} tree;

/* Adds the tree to the group, standing on the origin, about 1 high. */
fathom_status generate_tree(fathom_scene *scene, fathom_id group, const tree *t);

/* ---- for the two species ---- */

/* A mesh that grows. Wood has normals, leaves are flat. */
typedef struct tree_part {
    ARRAY(float) positions;
    ARRAY(float) normals;
    ARRAY(uint32_t) indices;
    bool failed; /* out of memory: adds nothing more */
} tree_part;

typedef struct tree_maker {
    tree_part wood, leaves;
    noise_random random;
} tree_maker;

void tree_conifer(tree_maker *m, uint32_t triangles);
void tree_broadleaf(tree_maker *m, uint32_t triangles);

uint32_t tree_vertex(tree_part *part, vec3_f64 p);
void tree_triangle(tree_part *part, uint32_t a, uint32_t b, uint32_t c);
void tree_leaf(tree_part *part, vec3_f64 a, vec3_f64 b, vec3_f64 c);
/* A frustum without caps, with normals: 2 triangles a side, or 1 when it ends in a point. */
void tree_cone(tree_part *part, vec3_f64 from, vec3_f64 to, double from_radius, double to_radius,
               uint32_t sides);
/* (cos, 0, sin) of a part of the full turn, any number >= 0. */
vec3_f64 tree_turn(double turns);

#endif
