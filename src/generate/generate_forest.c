/* A forest: hilly ground, and a few kinds of trees with many instances.
 *
 * The number of trees is about the number of triangles per tree, so both grow with the requested total. Half
 * of the kinds have one triangle more than the others. The number of trees of these kinds makes the total
 * exact. */
#include "generate/generate.h"

#include <stdlib.h>

#define MOST_TREE_TRIANGLES 150000u
#define KINDS 8u /* bit 0: one of two shapes, bit 1: conifer, bit 2: one more triangle */

typedef struct forest {
    fathom_scene *scene;
    fathom_id group;
    uint64_t seed;
    uint32_t ground_cells, tree_count, tree_triangles, with_one_more;
    fathom_id ground, bark, leaves, needles; /* materials */
    generate_mesh field;
    fathom_id kinds[KINDS]; /* groups; FATHOM_NONE: not needed yet */
} forest;

static void plan_counts(forest *f, uint64_t triangles) {
    double cells = sqrt((double)triangles / 100);
    f->ground_cells = cells < 2 ? 2 : cells > 512 ? 512 : (uint32_t)cells;
    uint64_t ground = 2 * (uint64_t)f->ground_cells * f->ground_cells;
    uint64_t rest =
        triangles > ground + TREE_LEAST_TRIANGLES ? triangles - ground : (uint64_t)TREE_LEAST_TRIANGLES;
    uint64_t count = (uint64_t)sqrt((double)rest);
    if (count > rest / TREE_LEAST_TRIANGLES) count = rest / TREE_LEAST_TRIANGLES;
    if (count < rest / MOST_TREE_TRIANGLES + 1) count = rest / MOST_TREE_TRIANGLES + 1;
    f->tree_count = (uint32_t)count;
    f->tree_triangles = (uint32_t)(rest / count);
    f->with_one_more = (uint32_t)(rest % count);
}

static fathom_status add_material(fathom_scene *scene, const char *name, float r, float g, float b,
                                  bool translucent, fathom_id *out) {
    fathom_material m;
    fathom_material_default(&m);
    m.k_d[0] = r, m.k_d[1] = g, m.k_d[2] = b;
    m.lit_from_behind = translucent;
    return fathom_scene_add_material(scene, name, &m, out);
}

static fathom_status choose_materials(forest *f, fathom_id material) {
    if (material != 0 && material != FATHOM_NONE) {
        f->ground = f->bark = f->leaves = f->needles = material;
        return FATHOM_OK;
    }
    fathom_status status = add_material(f->scene, "ground", 0.24f, 0.21f, 0.10f, false, &f->ground);
    if (status == FATHOM_OK) status = add_material(f->scene, "bark", 0.20f, 0.13f, 0.08f, false, &f->bark);
    if (status == FATHOM_OK) status = add_material(f->scene, "leaves", 0.17f, 0.30f, 0.05f, true, &f->leaves);
    if (status == FATHOM_OK)
        status = add_material(f->scene, "needles", 0.08f, 0.20f, 0.08f, true, &f->needles);
    return status;
}

static fathom_status add_ground(forest *f) {
    terrain t = {.seed = (uint32_t)noise_random_from(f->seed, 4).state,
                 .cells = f->ground_cells,
                 .relief = 0.3,
                 .frequency = 0.8,
                 .roughness = 0.35};
    fathom_status status = generate_height_field(f->scene, &t, &f->field);
    return status == FATHOM_OK ? generate_finish(f->scene, f->group, &f->field, f->ground) : status;
}

static fathom_status need_kind(forest *f, uint32_t kind) {
    if (f->kinds[kind] != FATHOM_NONE) return FATHOM_OK;
    tree t = {.conifer = kind & 2,
              .triangles = f->tree_triangles + (kind & 4 ? 1 : 0),
              .seed = f->seed * KINDS + kind,
              .bark = f->bark};
    t.leaves = t.conifer ? f->needles : f->leaves;
    fathom_status status =
        fathom_scene_add_group(f->scene, t.conifer ? "conifer" : "broadleaf tree", &f->kinds[kind]);
    return status == FATHOM_OK ? generate_tree(f->scene, f->kinds[kind], &t) : status;
}

/* ---- positions of trees ---- */

/* A cell of the grid of positions, with at most one tree. */
typedef struct site {
    double x, z;
    double rank; /* cells of the highest rank get trees: in clumps, and not on steep slopes */
    uint32_t cell;
} site;

static double ground_at(const forest *f, double x, double z) {
    return height_field_at(&f->field, f->ground_cells, x, z);
}

static site make_site(const forest *f, uint32_t side, uint32_t cell) {
    noise_random random = noise_random_from(f->seed ^ 0x7ee5u, cell);
    double spacing = 2.0 / side;
    site s = {.cell = cell};
    s.x = -1 + spacing * (cell % side + random_between(&random, 0.12, 0.88));
    s.z = -1 + spacing * (cell / side + random_between(&random, 0.12, 0.88));
    double step = 0.02, dx = ground_at(f, s.x + step, s.z) - ground_at(f, s.x - step, s.z);
    double dz = ground_at(f, s.x, s.z + step) - ground_at(f, s.x, s.z - step);
    double slope = (dx * dx + dz * dz) / (4 * step * step);
    vec3_f64 p = {2.2 * s.x, 9.5, 2.2 * s.z};
    s.rank = noise_fbm((uint32_t)f->seed, p, 3, 0.5).value - 0.8 * slope + 0.35 * random_unit(&random);
    return s;
}

static int by_rank(const void *a, const void *b) {
    const site *s = a, *t = b;
    if (s->rank != t->rank) return s->rank > t->rank ? -1 : 1;
    return s->cell < t->cell ? -1 : 1;
}

static int by_cell(const void *a, const void *b) {
    const site *s = a, *t = b;
    return s->cell < t->cell ? -1 : 1;
}

/* Conifers grow on high ground, broadleaf trees on low ground, and both in between. */
static bool wants_conifer(const forest *f, const site *s, noise_random *random) {
    vec3_f64 p = {1.3 * s->x, 3.5, 1.3 * s->z};
    double patch = noise_fbm((uint32_t)(f->seed >> 32) ^ 0x5bd1u, p, 2, 0.5).value;
    return 4 * ground_at(f, s->x, s->z) + patch + random_between(random, -0.3, 0.3) > 0;
}

static fathom_status plant(forest *f, const site *s, double spacing, bool one_more) {
    noise_random random = noise_random_from(f->seed ^ 0x91a7u, s->cell);
    uint32_t kind = (wants_conifer(f, s, &random) ? 2u : 0u) + (one_more ? 4u : 0u);
    kind += random_unit(&random) < 0.5;
    fathom_status status = need_kind(f, kind);
    if (status != FATHOM_OK) return status;
    double size = 2.1 * spacing * random_between(&random, 0.7, 1.25);
    if (size > 0.5) size = 0.5;
    double width = size * random_between(&random, 0.85, 1.15);
    vec3_f64 turn = random_turn(&random);
    fathom_instance instance;
    fathom_instance_default(&instance);
    instance.group = f->kinds[kind], instance.parent = f->group;
    double *m = instance.transform;
    m[0] = width * turn.x, m[2] = width * turn.z, m[3] = s->x;
    /* The tree reaches slightly below the ground, because the ground may slope. */
    m[5] = size, m[7] = ground_at(f, s->x, s->z) - 0.025 * size;
    m[8] = -width * turn.z, m[10] = width * turn.x, m[11] = s->z;
    return fathom_scene_add_instance(f->scene, &instance, NULL);
}

static fathom_status plant_all(forest *f) {
    uint32_t side = (uint32_t)sqrt(1.4 * f->tree_count) + 1, count = side * side;
    site *sites = malloc((size_t)count * sizeof *sites);
    if (!sites) return fail_memory(f->scene->context, (size_t)count * sizeof *sites);
    for (uint32_t cell = 0; cell < count; ++cell) sites[cell] = make_site(f, side, cell);
    qsort(sites, count, sizeof *sites, by_rank);
    qsort(sites, f->tree_count, sizeof *sites, by_cell);
    fathom_status status = FATHOM_OK;
    uint64_t more = f->with_one_more;
    for (uint64_t k = 0; k < f->tree_count && status == FATHOM_OK; ++k) {
        /* True for `more` of the trees, distributed uniformly over all trees. */
        bool one_more = k * more / f->tree_count != (k + 1) * more / f->tree_count;
        status = plant(f, &sites[k], 2.0 / side, one_more);
    }
    free(sites);
    return status;
}

fathom_status generate_forest(fathom_scene *scene, fathom_id group, const fathom_generate_options *options) {
    forest f = {.scene = scene, .group = group, .seed = noise_random_from(options->seed, 5).state};
    for (uint32_t k = 0; k < KINDS; ++k) f.kinds[k] = FATHOM_NONE;
    plan_counts(&f, options->triangles);
    fathom_status status = choose_materials(&f, options->material);
    if (status == FATHOM_OK) status = add_ground(&f);
    return status == FATHOM_OK ? plant_all(&f) : status;
}
