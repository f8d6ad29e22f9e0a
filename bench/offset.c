/* Counts what rays that leave surfaces do wrong: see offset.sh and tests/offset.h. */
#include "offset.h"

static const char *const names[OFFSET_SHAPES] = {"sphere", "quad", "triangle", "plane"};

/* The least number of units that this share of the points stays below. */
static int quantile(const offset_counts *c, double share) {
    uint64_t all = 0, below = 0;
    for (int i = 0; i < OFFSET_BINS; ++i) all += c->histogram[i];
    for (int i = 0; i < OFFSET_BINS; ++i) {
        below += c->histogram[i];
        if ((double)below >= share * (double)all) return i + 1;
    }
    return OFFSET_BINS;
}

static void print(const char *shape, const char *where, const offset_counts *c) {
    printf(
        "| %s, %s | %.2f M | %llu / %llu | %llu / %llu of %.2f M | %llu / %llu | %llu | %d / %d / %.1f |\n",
        shape, where, (double)c->rays * 1e-6, (unsigned long long)c->self[0], (unsigned long long)c->self[1],
        (unsigned long long)c->lost[0], (unsigned long long)c->lost[1], (double)c->contacts * 1e-6,
        (unsigned long long)c->phantom[0], (unsigned long long)c->phantom[1],
        (unsigned long long)c->wrong_side, quantile(c, 0.5), quantile(c, 0.999), c->most);
    fflush(stdout);
}

/* offset RAYS [STRETCH [SHAPE]]: so many for each shape, half of them in instances; planes have none. With a
 * shape only that one, and failures are told. */
int main(int argc, char **argv) {
    uint64_t rays = argc > 1 ? (uint64_t)strtod(argv[1], NULL) : 100000;
    double stretch = argc > 2 ? strtod(argv[2], NULL) : 4;
    double thin = argc > 3 ? strtod(argv[3], NULL) : 1;
    fathom_context *context;
    fathom_scene *scene;
    if (fathom_context_create(&context) != FATHOM_OK || fathom_scene_create(context, &scene) != FATHOM_OK)
        return 4;
    printf("| shape | rays | self-hits | missed contacts | false hits | wrong side | distance in ulps, "
           "median / 99.9 %% / max |\n");
    printf("|---|---|---|---|---|---|---|\n");
    for (int shape = 0; shape < OFFSET_SHAPES; ++shape) {
        if (argc > 4 && strcmp(argv[4], names[shape]) != 0) continue;
        for (int instance = 0; instance < (shape == OFFSET_PLANE ? 1 : 2); ++instance) {
            random_state r = {(uint64_t)(100 + 2 * shape + instance)};
            offset_counts counts = {0};
            uint64_t want = shape == OFFSET_PLANE ? rays : rays / 2;
            while (counts.rays < want) {
                offset_case c = offset_case_of(&r, (offset_shape)shape, instance, stretch, thin);
                if (offset_run(context, scene, &c, &r, argc > 4 ? stderr : NULL, &counts) != FATHOM_OK) {
                    fprintf(stderr, "%s\n", fathom_context_message(context));
                    return 70;
                }
            }
            print(names[shape], instance ? "instance" : "root", &counts);
        }
    }
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return 0;
}
