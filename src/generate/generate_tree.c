/* Trees: tapered cones for the wood, and leaves. */
#include "generate/generate.h"
#include "math/frame.h"

#include <stdlib.h>

/* Trees with fewer triangles have closed crowns instead of single leaves. */
#define TREE_LEAFY_TRIANGLES 400u

/* A mesh under construction. Wood has normals, leaves are flat. */
typedef ARRAY(float) tree_numbers;
typedef struct tree_part {
    tree_numbers positions, normals;
    ARRAY(uint32_t) indices;
    bool failed; /* out of memory: later calls add nothing */
} tree_part;

typedef struct tree_maker {
    tree_part wood, leaves;
    noise_random random;
} tree_maker;

static const vec3_f64 up = {0, 1, 0};

static void push_vector(tree_part *part, tree_numbers *list, vec3_f64 v) {
    if (!array_room(list, 3)) part->failed = true;
    if (part->failed) return;
    store_f32(list->items + list->count, narrow(v));
    list->count += 3;
}

static uint32_t tree_vertex(tree_part *part, vec3_f64 p) {
    push_vector(part, &part->positions, p);
    return (uint32_t)(part->positions.count / 3 - 1);
}

static void tree_triangle(tree_part *part, uint32_t a, uint32_t b, uint32_t c) {
    const uint32_t corners[3] = {a, b, c};
    for (int k = 0; k < 3; ++k) part->failed |= !array_push(&part->indices, corners[k]);
}

static void tree_leaf(tree_part *part, vec3_f64 a, vec3_f64 b, vec3_f64 c) {
    uint32_t first = tree_vertex(part, a);
    tree_vertex(part, b);
    tree_vertex(part, c);
    tree_triangle(part, first, first + 1, first + 2);
}

/* Taylor series within an eighth of a turn; the error is below 2^-41. */
vec3_f64 tree_turn(double turns) {
    turns -= (double)(uint64_t)turns;
    int quarter = (int)(turns * 4 + 0.5);
    double x = (turns - quarter * 0.25) * 6.283185307179586, y = x * x;
    double s = x * (1 - y / 6 * (1 - y / 20 * (1 - y / 42 * (1 - y / 72 * (1 - y / 110 * (1 - y / 156))))));
    double c = 1 - y / 2 * (1 - y / 12 * (1 - y / 30 * (1 - y / 56 * (1 - y / 90 * (1 - y / 132)))));
    switch (quarter & 3) {
    case 0: return (vec3_f64){c, 0, s};
    case 1: return (vec3_f64){-s, 0, c};
    case 2: return (vec3_f64){-c, 0, -s};
    default: return (vec3_f64){s, 0, -c};
    }
}

/* A frustum without caps, with normals: 2 triangles per side, or 1 if to_radius is 0. */
static void tree_cone(tree_part *part, vec3_f64 from, vec3_f64 to, double from_radius, double to_radius,
                      uint32_t sides) {
    vec3_f64 axis = sub_f64(to, from);
    frame_f64 f = frame_from(from, axis, (vec3_f64){0, 0, 0});
    double lean = (from_radius - to_radius) / length_f64(axis);
    uint32_t first = (uint32_t)(part->positions.count / 3);
    for (uint32_t k = 0; k < sides; ++k) {
        vec3_f64 c = tree_turn(k / (double)sides);
        vec3_f64 out = add_f64(scale_f64(c.x, f.x), scale_f64(c.z, f.y)), normal = madd_f64(out, lean, f.z);
        tree_vertex(part, madd_f64(from, from_radius, out));
        push_vector(part, &part->normals, normalize_f64(normal));
        tree_vertex(part, madd_f64(to, to_radius, out));
        push_vector(part, &part->normals, normalize_f64(normal));
    }
    for (uint32_t k = 0; k < sides; ++k) {
        uint32_t a = first + 2 * k, b = first + 2 * ((k + 1) % sides);
        tree_triangle(part, a, b, a + 1);
        if (to_radius > 0) tree_triangle(part, b, b + 1, a + 1);
    }
}

/* ---- conifers: fronds of needles around a straight trunk; with few triangles, a stack of cones ---- */

/* Makes overlapping tiers, each narrower than the one below. Together they use all triangles. */
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

typedef struct frond {
    vec3_f64 start, along, aside; /* `along` and `aside`: unit, perpendicular */
    double length;
} frond;

static vec3_f64 frond_point(const frond *f, double s) {
    return madd_f64(madd_f64(f->start, f->length * s, f->along), -0.18 * f->length * s * s, up);
}

/* Adds two rows of needles, shorter towards the tip. */
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

/* Each frond is rotated by the golden angle from the previous one, so that none is directly above another. */
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

static void tree_conifer(tree_maker *m, uint32_t triangles) {
    uint32_t sides = triangles < 60 ? 3 : 6;
    tree_cone(&m->wood, (vec3_f64){0, 0, 0}, (vec3_f64){0, 0.97, 0}, 0.028, 0, sides);
    if (triangles < TREE_LEAFY_TRIANGLES) {
        make_tiers(m, triangles - sides);
    } else {
        uint32_t fronds = (uint32_t)(2.5 * sqrt(triangles));
        make_fronds(m, fronds, triangles - sides - 3 * fronds);
    }
}

/* ---- broadleaf trees: each branch splits into three, and the last ones end in clusters of leaves; with few
 * triangles, a round crown ---- */

/* A closed, irregular ball from rings of `sides` vertices, each ring rotated by half a side from the previous
 * one: 2 · sides · rings triangles. */
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

/* The trunk gets the remaining triangles, one per side; there are at least 3. */
static void make_round(tree_maker *m, uint32_t triangles) {
    uint32_t rings = triangles < 60 ? 2 : triangles < 150 ? 4 : 6;
    uint32_t sides = (triangles - 3) / (2 * rings);
    tree_cone(&m->wood, (vec3_f64){0, 0, 0}, (vec3_f64){0, 0.7, 0}, 0.045, 0, triangles - 2 * rings * sides);
    make_crown(m, sides, rings);
}

typedef struct foliage {
    uint32_t leaves, twigs, next_twig; /* leaves are distributed over the twigs */
} foliage;

static void add_twig_leaves(tree_maker *m, foliage *all, vec3_f64 end, vec3_f64 along, double spread) {
    uint32_t k = all->next_twig++, count = all->leaves / all->twigs + (k < all->leaves % all->twigs);
    /* The total area of all leaves is about three times that of the crown's silhouette. */
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

/* levels: remaining levels of branches, this one included. The first of the three branches continues in about
 * the same direction, the others turn to the side. */
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

/* The number of triangles that add_branch() makes. */
static uint32_t branch_triangles(unsigned levels, uint32_t sides) {
    if (levels <= 1) return 2 * sides;
    return 2 * sides + 3 * branch_triangles(levels - 1, next_sides(levels, sides));
}

/* Uses at most a third of the triangles for branches. */
static void make_branching(tree_maker *m, uint32_t triangles) {
    unsigned levels = 1;
    while (branch_triangles(levels + 1, 6) <= triangles / 3) ++levels;
    foliage all = {.leaves = triangles - branch_triangles(levels, 6), .twigs = 1};
    for (unsigned l = 1; l < levels; ++l) all.twigs *= 3;
    add_branch(m, &all, (vec3_f64){0, 0, 0}, up, 0.23 + 0.18 / levels, 0.035, levels, 6);
}

static void tree_broadleaf(tree_maker *m, uint32_t triangles) {
    if (triangles < TREE_LEAFY_TRIANGLES)
        make_round(m, triangles);
    else
        make_branching(m, triangles);
}

/* ---- the tree ---- */

static fathom_status finish_part(fathom_scene *scene, fathom_id group, const tree_part *part,
                                 fathom_id material) {
    if (part->failed) return fail_memory(scene->context, part->indices.capacity * sizeof(uint32_t));
    fathom_mesh mesh;
    fathom_mesh_default(&mesh);
    mesh.positions = part->positions.items, mesh.vertex_count = (uint32_t)(part->positions.count / 3);
    mesh.normals = part->normals.items, mesh.normal_count = (uint32_t)(part->normals.count / 3);
    mesh.indices = part->indices.items, mesh.triangle_count = (uint32_t)(part->indices.count / 3);
    mesh.material = material;
    return fathom_scene_add_mesh(scene, group, &mesh, NULL);
}

static void free_part(tree_part *part) {
    array_free(&part->positions);
    array_free(&part->normals);
    array_free(&part->indices);
}

fathom_status generate_tree(fathom_scene *scene, fathom_id group, const tree *t) {
    tree_maker m = {.random = noise_random_from(t->seed, t->conifer ? 3 : 2)};
    if (t->conifer)
        tree_conifer(&m, t->triangles);
    else
        tree_broadleaf(&m, t->triangles);
    fathom_status status = finish_part(scene, group, &m.wood, t->bark);
    if (status == FATHOM_OK) status = finish_part(scene, group, &m.leaves, t->leaves);
    free_part(&m.wood);
    free_part(&m.leaves);
    return status;
}
