/* Broadleaf trees: each branch ends in three, the last ones in clouds of leaves; or a round crown when
 * triangles are few. */
#include "generate/generate_tree.h"
#include "math/frame.h"

static const vec3_f64 up = {0, 1, 0};

/* ---- few triangles ---- */

/* A closed, uneven ball of rings of `sides` vertices, each turned by half a side: 2 sides rings triangles. */
static void make_crown(tree_maker *m, uint32_t sides, uint32_t rings) {
    const vec3_f64 center = {0, 0.66, 0}, half = {0.31, 0.34, 0.31};
    uint32_t first = tree_vertex(&m->leaves, madd_f64(center, -half.y, up));
    double start = random_unit(&m->random);
    for (uint32_t r = 1; r <= rings; ++r) {
        vec3_f64 polar = tree_turn(0.5 * r / (rings + 1));
        for (uint32_t s = 0; s < sides; ++s) {
            vec3_f64 p = scale_f64(polar.z * half.x, tree_turn(start + (s + 0.5 * r) / sides));
            p.y = -polar.x * half.y;
            tree_vertex(&m->leaves, madd_f64(center, random_between(&m->random, 0.85, 1.15), p));
        }
    }
    uint32_t last = tree_vertex(&m->leaves, madd_f64(center, half.y, up));
    for (uint32_t s = 0; s < sides; ++s) {
        uint32_t a = first + 1 + s, b = first + 1 + (s + 1) % sides, below = (rings - 1) * sides;
        tree_triangle(&m->leaves, first, a, b);
        for (uint32_t r = 0; r + 1 < rings; ++r) {
            uint32_t low = r * sides, high = low + sides;
            tree_triangle(&m->leaves, a + low, a + high, b + low);
            tree_triangle(&m->leaves, b + low, a + high, b + high);
        }
        tree_triangle(&m->leaves, a + below, last, b + below);
    }
}

/* The trunk has as many sides as the crown leaves over: at least 3. */
static void make_round(tree_maker *m, uint32_t triangles) {
    uint32_t rings = triangles < 60 ? 2 : triangles < 150 ? 4 : 6;
    uint32_t sides = (triangles - 3) / (2 * rings);
    tree_cone(&m->wood, (vec3_f64){0, 0, 0}, (vec3_f64){0, 0.7, 0}, 0.045, 0, triangles - 2 * rings * sides);
    make_crown(m, sides, rings);
}

/* ---- many ---- */

typedef struct foliage {
    uint32_t leaves, twigs, next_twig; /* leaves are dealt out over the twigs */
} foliage;

/* Evenly in the unit ball. */
static vec3_f64 random_in_ball(noise_random *random) {
    for (;;) {
        vec3_f64 p;
        p.x = random_between(random, -1, 1);
        p.y = random_between(random, -1, 1);
        p.z = random_between(random, -1, 1);
        if (dot_f64(p, p) <= 1) return p;
    }
}

static void add_twig_leaves(tree_maker *m, foliage *all, vec3_f64 end, vec3_f64 along, double spread) {
    uint32_t k = all->next_twig++, count = all->leaves / all->twigs + (k < all->leaves % all->twigs);
    /* All leaves together have about the area of three crowns' silhouettes. */
    double size = sqrt(2.6 / all->leaves);
    vec3_f64 center = madd_f64(end, 0.4 * spread, along);
    for (uint32_t j = 0; j < count; ++j) {
        vec3_f64 p = madd_f64(center, spread, random_in_ball(&m->random));
        frame_f64 f = frame_from(p, add_f64(random_direction(&m->random), scale_f64(0.5, up)),
                                 random_direction(&m->random));
        double length = size * random_between(&m->random, 0.75, 1.2), half = 0.36 * length;
        tree_leaf(&m->leaves, madd_f64(p, -half, f.x), madd_f64(p, half, f.x), madd_f64(p, length, f.y));
    }
}

static uint32_t next_sides(unsigned levels, uint32_t sides) { return levels > 3 ? sides : 3; }

/* levels: branchings still to come, this branch included. The first of the three goes on, the others turn
 * off. */
static void add_branch(tree_maker *m, foliage *all, vec3_f64 from, vec3_f64 along, double length,
                       double radius, unsigned levels, uint32_t sides) {
    vec3_f64 to = madd_f64(from, length, along);
    tree_cone(&m->wood, from, to, radius, 0.7 * radius, sides);
    if (levels <= 1) {
        add_twig_leaves(m, all, to, along, 0.9 * length);
        return;
    }
    frame_f64 f = frame_from(to, along, random_direction(&m->random));
    for (int k = 0; k < 3; ++k) {
        vec3_f64 c = tree_turn(k / 3.0), out = add_f64(scale_f64(c.x, f.x), scale_f64(c.z, f.y));
        double open = k == 0 ? random_between(&m->random, 0.1, 0.45) : random_between(&m->random, 0.7, 1.15);
        vec3_f64 next = madd_f64(madd_f64(along, open, out), 0.15, up);
        next = normalize_f64(madd_f64(next, 0.2, random_direction(&m->random)));
        double shrink =
            k == 0 ? random_between(&m->random, 0.74, 0.86) : random_between(&m->random, 0.64, 0.8);
        add_branch(m, all, to, next, length * shrink, (k == 0 ? 0.68 : 0.55) * radius, levels - 1,
                   next_sides(levels, sides));
    }
}

/* The frusta of add_branch(): what is counted here is what is made there. */
static uint32_t branch_triangles(unsigned levels, uint32_t sides) {
    if (levels <= 1) return 2 * sides;
    return 2 * sides + 3 * branch_triangles(levels - 1, next_sides(levels, sides));
}

/* As many branchings as a third of the triangles pays for. */
static void make_branching(tree_maker *m, uint32_t triangles) {
    unsigned levels = 1;
    while (branch_triangles(levels + 1, 6) <= triangles / 3) ++levels;
    foliage all = {.leaves = triangles - branch_triangles(levels, 6), .twigs = 1};
    for (unsigned l = 1; l < levels; ++l) all.twigs *= 3;
    add_branch(m, &all, (vec3_f64){0, 0, 0}, up, 0.23 + 0.18 / levels, 0.035, levels, 6);
}

void tree_broadleaf(tree_maker *m, uint32_t triangles) {
    if (triangles < TREE_LEAFY_TRIANGLES)
        make_round(m, triangles);
    else
        make_branching(m, triangles);
}
