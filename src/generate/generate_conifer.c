/* Conifers: fronds of needles around a straight trunk, or a stack of cones when triangles are few. */
#include "generate/generate_tree.h"

static const vec3_f64 up = {0, 1, 0};

/* ---- few triangles ---- */

/* Tiers overlap, each narrower than the one below; between them they use up all triangles. */
static void make_tiers(tree_maker *m, uint32_t triangles) {
    uint32_t tiers = triangles / 9 < 3 ? 3 : triangles / 9 > 7 ? 7 : triangles / 9;
    for (uint32_t k = 0; k < tiers; ++k) {
        uint32_t sides = triangles / tiers + (k < triangles % tiers);
        double t = k / (double)tiers, rim = 0.12 + 0.88 * t, top = rim + 0.88 * 1.7 / tiers;
        double radius = 0.27 * (1.03 - t), start = random_unit(&m->random);
        if (top > 1 || k + 1 == tiers) top = 1;
        uint32_t tip = tree_vertex(&m->leaves, (vec3_f64){0, top, 0});
        for (uint32_t s = 0; s < sides; ++s) {
            double r = radius * random_between(&m->random, 0.85, 1.15);
            vec3_f64 p = scale_f64(r, tree_turn(start + s / (double)sides));
            p.y = rim + random_between(&m->random, -0.02, 0.02);
            tree_vertex(&m->leaves, p);
        }
        for (uint32_t s = 0; s < sides; ++s)
            tree_triangle(&m->leaves, tip, tip + 1 + (s + 1) % sides, tip + 1 + s);
    }
}

/* ---- many ---- */

typedef struct frond {
    vec3_f64 start, along, aside; /* unit, at right angles */
    double length;
} frond;

static vec3_f64 frond_point(const frond *f, double s) {
    return madd_f64(madd_f64(f->start, f->length * s, f->along), -0.18 * f->length * s * s, up);
}

/* Two rows of needles, shorter towards the tip. */
static void add_needles(tree_maker *m, const frond *f, uint32_t count) {
    for (uint32_t j = 0; j < count; ++j) {
        double side = j & 1 ? -1 : 1, half_width = 1.1 * f->length / count;
        double s = 0.06 + 0.94 * (j / 2 + 0.5) / ((count + 1) / 2);
        vec3_f64 out = madd_f64(scale_f64(side, f->aside), 0.7, f->along);
        out = normalize_f64(madd_f64(out, random_between(&m->random, -0.5, -0.1), up));
        vec3_f64 p = frond_point(f, s);
        double length = f->length * (0.08 + 0.42 * (1 - s)) * random_between(&m->random, 0.8, 1.1);
        tree_leaf(&m->leaves, madd_f64(p, -half_width, f->along), madd_f64(p, half_width, f->along),
                  madd_f64(p, length, out));
    }
}

/* Fronds turn by the golden angle from one to the next, so that none stands above another. */
static void make_fronds(tree_maker *m, uint32_t fronds, uint32_t needles) {
    double start = random_unit(&m->random);
    for (uint32_t k = 0; k < fronds; ++k) {
        vec3_f64 turn = tree_turn(start + k * 0.3819660112501051);
        double t = (k + 0.5) / fronds, y = 0.09 + 0.89 * t * (0.7 + 0.3 * t), taper = 1 - (y - 0.09) / 0.91;
        frond f = {.start = {0, y, 0}, .aside = {-turn.z, 0, turn.x}};
        double rise = 0.4 - 0.8 * taper + random_between(&m->random, -0.12, 0.12);
        f.along = normalize_f64(madd_f64(turn, rise, up));
        f.length = (0.035 + 0.25 * taper) * random_between(&m->random, 0.75, 1.15);
        tree_cone(&m->wood, f.start, frond_point(&f, 0.8), 0.006 * taper + 0.001, 0, 3);
        add_needles(m, &f, needles / fronds + (k < needles % fronds));
    }
}

void tree_conifer(tree_maker *m, uint32_t triangles) {
    uint32_t sides = triangles < 60 ? 3 : 6;
    tree_cone(&m->wood, (vec3_f64){0, 0, 0}, (vec3_f64){0, 0.97, 0}, 0.028, 0, sides);
    if (triangles < TREE_LEAFY_TRIANGLES) {
        make_tiers(m, triangles - sides);
    } else {
        uint32_t fronds = (uint32_t)(2.5 * sqrt(triangles));
        make_fronds(m, fronds, triangles - sides - 3 * fronds);
    }
}
