/* Directional albedo of the first scattering by a rough surface's facets. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

/* Curves over the cosine mu have nodes at mu = (k / ENERGY_STEPS)^4 and are linear in the fourth root of
 * mu between nodes. */
enum { ENERGY_STEPS = 64, ENERGY_NODES = ENERGY_STEPS + 1 };

/* A node of the curves of two neighbouring roughnesses: the values at the lower one, and the differences
 * to the higher one. */
typedef struct energy_node {
    float all, edge, all_step, edge_step;
} energy_node;

/* Albedos of the GGX lobe with this alpha: `all` is the albedo E(mu) for a reflectance of 1, `edge` the
 * albedo for Schlick's (1 - v·h)^5. `nodes` are ENERGY_NODES nodes of a table with static lifetime; `part`
 * scales their steps. A reflectance f0 + (f90 - f0) (1 - v·h)^5 has the albedo f0 (all - edge) + f90 edge.
 * The error is at most 5e-4 for roughnesses of 0.03 and more; below SHADER_SMOOTH_ALPHA the albedos are those
 * of a mirror. */
typedef struct energy_curve {
    const energy_node *nodes;
    float part;
} energy_curve;
energy_curve energy_curve_of(float alpha);
/* A curve of zeros, which needs no tables. */
extern const energy_curve energy_none;

static inline float energy_all(const energy_curve *c, int k) {
    return c->nodes[k].all + c->part * c->nodes[k].all_step;
}
static inline float energy_edge(const energy_curve *c, int k) {
    return c->nodes[k].edge + c->part * c->nodes[k].edge_step;
}

/* The means of these curves over a hemisphere, weighted by the cosine. */
void energy_means(const energy_curve *c, float *all, float *edge);

/* The same for lobes with two alphas, over the cosine and the azimuth: nodes at |sin| / (|sin| + |cos|) =
 * j / ENERGY_TURNS of the angle to the axis of the larger alpha, linear between nodes. A table is computed on
 * first use and kept. */
enum { ENERGY_TURNS = 16 };
typedef struct energy_table {
    float albedo[2][ENERGY_TURNS + 1][ENERGY_NODES]; /* all and edge */
    float around[2][ENERGY_NODES];                   /* their means over the azimuth */
} energy_table;
/* The four tables around a pair of alphas, and their weights. The error is at most 3e-3. */
typedef struct energy_stretch {
    const energy_table *table[4];
    float weight[4];
} energy_stretch;
/* along >= across. */
void energy_stretched(float along, float across, energy_stretch *out);
/* Their means over the azimuth. */
void energy_stretched_curves(const energy_stretch *s, float all[ENERGY_NODES], float edge[ENERGY_NODES]);

/* The fractions of a quarter turn that the nodes of azimuths represent. */
void energy_turn_parts(float parts[ENERGY_TURNS + 1]);

/* The albedo of facets with the reflectance `curve` over the cosine between viewer and facet, whose nodes are
 * at cosines (k / steps)^2; `out` has its nodes at the same cosines of the viewer. It is the mean over the
 * azimuth if the alphas differ. along >= across. Adds to `out`. The error is at most 3e-3 of the largest
 * reflectance. */
enum { ENERGY_FACETS_STEPS = 64 };
void energy_facets(float along, float across, const float curve[ENERGY_FACETS_STEPS + 1],
                   float out[ENERGY_FACETS_STEPS + 1]);

/* The light that remains between the facets of rough glass after the first scattering: 1 - albedo, with
 * reflected and transmitted light together, for a viewer outside ([0]) and inside ([1]). eta: index inside
 * divided by outside; f0 and f90 of Schlick's reflectance, with f90 at total reflection; what is not
 * reflected is transmitted. The error is at most 3e-3, or 6e-3 for roughnesses above 0.9. */
void energy_glass(float alpha, float eta, float f0, float f90, float missing[2][ENERGY_NODES]);

/* The same for two alphas, over the cosine and the azimuth: nodes at cosines (k / ENERGY_GLASS_STEPS)^4, and
 * at azimuths as above. Tables are computed on first use and kept; each holds the parts of albedos f0 [0] +
 * f90 [1] + [2], times 32767. */
enum { ENERGY_GLASS_STEPS = ENERGY_STEPS / 2 };
typedef struct energy_glass_table {
    int16_t part[2][ENERGY_TURNS + 1][ENERGY_GLASS_STEPS + 1][3];
} energy_glass_table;
/* The tables around a pair of alphas and an index, and their weights. turned: the table's axes are exchanged;
 * swapped: its sides are. The error is at most 8e-3, and 1.2e-3 in the
 * root mean square. */
typedef struct energy_glass_stretch {
    const energy_glass_table *table[8];
    float weight[8], f0, f90;
    bool turned[8], swapped;
} energy_glass_stretch;
/* along >= across. */
void energy_glass_stretched(float along, float across, float eta, float f0, float f90,
                            energy_glass_stretch *out);
/* The means over the azimuth. */
void energy_glass_stretched_curves(const energy_glass_stretch *g, float missing[2][ENERGY_NODES]);
static inline float energy_glass_node(const energy_glass_stretch *g, int side, int turn, int node) {
    float parts[3] = {0, 0, 0};
    for (int r = 0; r < 8; ++r) {
        const int16_t *at =
            g->table[r]->part[side ^ (int)g->swapped][g->turned[r] ? ENERGY_TURNS - turn : turn][node];
        for (int c = 0; c < 3; ++c) parts[c] += g->weight[r] * (float)at[c];
    }
    const float missing = 1 - (g->f0 * parts[0] + g->f90 * parts[1] + parts[2]);
    return missing > 0 ? missing : 0;
}

/* The mean over a hemisphere, weighted by the cosine: 2 ∫ f mu dmu. */
float energy_mean(const float curve[ENERGY_NODES]);
/* The parts of that mean that come from below each node, as fractions of it. A curve of zeros has 0 below all
 * but the last. */
void energy_sums(const float curve[ENERGY_NODES], float sums[ENERGY_NODES]);
