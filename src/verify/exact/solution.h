/* What either way of computing finds about a ray and a sphere, triangle or plane; oracle.c judges it. */
#ifndef PARITY_SOLUTION_H
#define PARITY_SOLUTION_H

#include "verify/exact/oracle.h"

typedef struct solution {
    bool parallel;  /* nothing else is set */
    unsigned roots; /* 0: a sphere that the line misses; t[0] is the closest approach */
    ball t[2], above_near[2], below_far[2];
    ball weight[3]; /* triangles */
    ball edge;      /* spheres */
} solution;

/* A ray in the space of the instance, or of the world for NULL. */
typedef struct estimate_ray {
    ball3 org, dir;
} estimate_ray;
estimate_ray estimate_ray_of(const oracle_ray *ray, const world_instance *instance);

/* The primitive is a sphere with a radius above 0, a triangle or a plane; everything is finite but the
 * interval's ends. False when some ball is not known well enough. */
bool estimate_solve(const oracle_ray *ray, const oracle_primitive *primitive, solution *out);
/* In whole numbers; always succeeds. */
void exact_solve(const oracle_ray *ray, const oracle_primitive *primitive, solution *out);

#endif
