/* The grid of stiff and extreme cases. A case is a small scene with rays that are hard in one respect; its
 * answers are judged by the exact oracle as any other's. A group is a line of cases along one number. */
#ifndef EXTREMES_EXTREMES_H
#define EXTREMES_EXTREMES_H

#include "verify/compare.h"

#define EXTREMES_WORDS 120

/* One case asked of one tracer. */
typedef struct extremes_row {
    const char *group, *spec; /* borrowed; spec from the options */
    double parameter;
    char words[EXTREMES_WORDS]; /* what the case is, for a person */
    uint64_t rays, counts[VERDICT_COUNT];
    uint64_t any_rays, any_counts[VERDICT_COUNT]; /* of the same rays, asked for any hit */
    double constant;                              /* as in compare_family */
} extremes_row;

typedef ARRAY(extremes_row) extremes_rows;

/* A leak or a wrong answer, and where. */
typedef struct extremes_failure {
    const char *group, *spec; /* borrowed, as of a row */
    double parameter;
    compare_failure failure;
} extremes_failure;

typedef ARRAY(extremes_failure) extremes_failures;

typedef struct extremes_options {
    const char *const *specs; /* tracers, as in trace/spec.h */
    size_t spec_count;
    uint64_t rays; /* of each case and tracer, about: families of rays share them */
    uint64_t seed;
    unsigned threads;
    size_t kept;                 /* failures of each family of a case and tracer: the first ones */
    extremes_failures *failures; /* appended; NULL where kept is 0 */
    /* From the calling thread, with the rays done of the case. False stops it. May be NULL. */
    bool (*progress)(void *user, uint64_t rays);
    void *user;
} extremes_options;

/* Groups in the table's order, and the cases of each. */
unsigned extremes_groups(void);
const char *extremes_name(unsigned group);
const char *extremes_meaning(unsigned group); /* of the number; "": one of a list */
unsigned extremes_cases(unsigned group);
double extremes_parameter(unsigned group, unsigned index);

/* Appends a row for each tracer that takes such scenes; a library's takes triangles alone. Cases of the
 * public calls are asked once for each of their own tracers, whatever the options name. FATHOM_INTERRUPTED
 * when progress said stop. */
fathom_status extremes_run(fathom_context *context, unsigned group, unsigned index,
                           const extremes_options *options, extremes_rows *rows);

/* ---- one scene ---- */

typedef struct judged_scene judged_scene; /* case.h */
/* Takes a scene that is checked, in any case. Release with judged_close() whatever comes back. */
fathom_status judged_open(fathom_context *context, fathom_scene *scene, judged_scene *out);
/* The scene of a case of rays, by its group and number, to ask one ray again. FATHOM_BAD_INPUT when there is
 * no such group; release it likewise. */
fathom_status extremes_open(fathom_context *context, const char *group, double parameter, judged_scene *out);
void judged_close(judged_scene *scene);

#endif
