/* Shared by the generators. */
#pragma once

#include "base/threads.h"
#include "generate/generate_noise.h"
#include "scene/scene.h"

/* A mesh with arrays that the scene owns; fill them, then call generate_finish(). */
typedef struct generate_mesh {
    float *positions;  /* x y z */
    float *normals;    /* x y z; NULL for a flat mesh */
    float *uvs;        /* u v; NULL for none */
    uint32_t *indices; /* 3 per triangle */
    uint32_t vertex_count, triangle_count;
} generate_mesh;

enum { GENERATE_NORMALS = 1, GENERATE_UVS = 2 };

/* FATHOM_OUT_OF_RESOURCES when the arrays do not fit into free memory. */
fathom_status generate_allocate(fathom_scene *scene, uint32_t vertices, uint32_t triangles, unsigned arrays,
                                generate_mesh *out);
fathom_status generate_finish(fathom_scene *scene, fathom_id group, const generate_mesh *mesh,
                              fathom_id material);

/* Calls body() for the rows of a grid in parallel, in pieces of about equal work. */
void generate_rows(const fathom_scene *scene, size_t rows, size_t row_size, loop_body body, void *job);

/* A height field over [-1,1]² in x and z: `cells` × `cells` squares of two triangles, y up. */
typedef struct terrain {
    uint32_t seed, cells;
    double relief;    /* approximate height of the highest peaks above the middle */
    double frequency; /* approximate number of hills per unit length */
    double roughness; /* height of an octave divided by that of the one before, (0,1) */
} terrain;

fathom_status generate_height_field(fathom_scene *scene, const terrain *t, generate_mesh *out);
/* Height of the field's triangles (not of the noise) at (x,z) inside the square. */
double height_field_at(const generate_mesh *field, uint32_t cells, double x, double z);

#define TREE_LEAST_TRIANGLES 24u

typedef struct tree {
    bool conifer;
    uint32_t triangles; /* exact total of wood and leaves; >= TREE_LEAST_TRIANGLES */
    uint64_t seed;
    fathom_id bark, leaves; /* materials */
} tree;

/* Adds the tree to the group. It stands on the origin, and is about 1 high. */
fathom_status generate_tree(fathom_scene *scene, fathom_id group, const tree *t);
/* (cos, 0, sin) of the angle 2π · `turns`; turns >= 0. */
vec3_f64 tree_turn(double turns);

/* The n >= 1 for which `factor` n² is closest to `triangles`. */
uint32_t generate_nearest_square(uint64_t triangles, uint32_t factor);

fathom_status generate_sphere(fathom_scene *scene, fathom_id group, const fathom_generate_options *options);
fathom_status generate_terrain(fathom_scene *scene, fathom_id group, const fathom_generate_options *options);
fathom_status generate_sponge(fathom_scene *scene, fathom_id group, const fathom_generate_options *options);
fathom_status generate_forest(fathom_scene *scene, fathom_id group, const fathom_generate_options *options);
