/* How much of the light a rough surface's facets send back at their first scattering. */
#ifndef MATERIAL_ENERGY_H
#define MATERIAL_ENERGY_H

/* Curves over the cosine mu are given at mu = (k / ENERGY_STEPS)^4, and are linear in its fourth root
 * between. */
enum { ENERGY_STEPS = 64, ENERGY_NODES = ENERGY_STEPS + 1 };

/* A node of the curves between two roughnesses: at the lower one, and how far it is to the other. */
typedef struct energy_node {
    float all, edge, all_step, edge_step;
} energy_node;

/* Albedos of the GGX lobe of this alpha: `all`, the albedo E(mu) for a reflectance of 1, and `edge`, for
 * Schlick's (1 - v·h)^5, as ENERGY_NODES nodes of tables that stay, and the part of the steps. A reflectance
 * f0 + (f90 - f0) (1 - v·h)^5 has the albedo f0 (all - edge) + f90 edge. Within 5e-4 for roughnesses from
 * 0.03 on; below SHADER_SMOOTH_ALPHA those of a mirror. */
typedef struct energy_curve {
    const energy_node *nodes;
    float part;
} energy_curve;
energy_curve energy_curve_of(float alpha);
/* One of zeros, which needs no tables. */
extern const energy_curve energy_none;

static inline float energy_all(const energy_curve *c, int k) {
    return c->nodes[k].all + c->part * c->nodes[k].all_step;
}
static inline float energy_edge(const energy_curve *c, int k) {
    return c->nodes[k].edge + c->part * c->nodes[k].edge_step;
}

/* The means of these curves. */
void energy_means(const energy_curve *c, float *all, float *edge);

/* The same of lobes with two alphas, over the cosine and the turn about the normal: nodes at |sin| / (|sin| +
 * |cos|) = j / ENERGY_TURNS of the angle to the larger alpha's way, linear between. Tables are made when they
 * are first asked for, and stay. */
enum { ENERGY_TURNS = 16 };
typedef struct energy_table {
    float albedo[2][ENERGY_TURNS + 1][ENERGY_NODES]; /* all, and edge */
    float around[2][ENERGY_NODES];                   /* their means about the normal */
} energy_table;
/* The four tables around a pair of alphas, and their parts. Within 3e-3. */
typedef struct energy_stretch {
    const energy_table *table[4];
    float weight[4];
} energy_stretch;
/* along >= across. */
void energy_stretched(float along, float across, energy_stretch *out);
/* Their means about the normal. */
void energy_stretched_curves(const energy_stretch *s, float all[ENERGY_NODES], float edge[ENERGY_NODES]);

/* The mean over a hemisphere, weighted by the cosine: 2 ∫ f mu dmu. */
float energy_mean(const float curve[ENERGY_NODES]);

#endif
