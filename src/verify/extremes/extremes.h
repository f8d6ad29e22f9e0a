/* The grid of extreme cases. A case is a small scene with rays that are difficult in one respect; its hits
 * are checked by the exact oracle as usual. A group is a series of cases with one varying parameter. */
#pragma once

#include "verify/compare.h"

#define EXTREMES_WORDS 120

/* One case with one tracer. */
typedef struct extremes_row {
    const char *group, *spec; /* borrowed; spec from the options */
    const char *meaning;      /* of the parameter; "": index in a list */
    double parameter;
    char words[EXTREMES_WORDS]; /* description of the case for the user */
    uint64_t rays, counts[VERDICT_COUNT];
    uint64_t any_rays, any_counts[VERDICT_COUNT]; /* the same rays, as any-hit queries */
    double constant;                              /* as in compare_family */
} extremes_row;

typedef ARRAY(extremes_row) extremes_rows;

/* A leak or a wrong result, and its case. */
typedef struct extremes_failure {
    const char *group, *spec; /* borrowed, as in a row */
    double parameter;
    compare_failure failure;
} extremes_failure;

typedef ARRAY(extremes_failure) extremes_failures;

typedef struct extremes_options {
    const char *const *specs; /* tracers, as in trace/spec.h */
    size_t spec_count;
    uint64_t rays; /* about this many per case and tracer, divided among the families */
    uint64_t seed;
    unsigned threads;
    size_t kept;                 /* maximum number of failures per family, case and tracer: the first ones */
    extremes_failures *failures; /* failures are appended; NULL if kept is 0 */
    /* Called from the calling thread, with the number of rays done in the case. False stops the run. May be
     * NULL. */
    bool (*progress)(void *user, uint64_t rays);
    void *user;
} extremes_options;

/* Groups in the order of the table, and their cases. */
unsigned extremes_groups(void);
const char *extremes_name(unsigned group);
unsigned extremes_cases(unsigned group);

/* Appends a row for each tracer that supports the scene; plug-ins support only triangles. FATHOM_INTERRUPTED
 * when progress returned false. */
fathom_status extremes_run(fathom_context *context, unsigned group, unsigned index,
                           const extremes_options *options, extremes_rows *rows);

/* ---- one scene ---- */

typedef struct judged_scene judged_scene; /* case.h */
/* Takes ownership of a checked scene, even if it fails. Release with judged_close(), also after a failure. */
fathom_status judged_open(fathom_context *context, fathom_scene *scene, judged_scene *out);
/* Opens the scene of a case by its group and parameter, to trace one ray again. FATHOM_BAD_INPUT when the
 * group does not exist. Release *out with judged_close() too. */
fathom_status extremes_open(fathom_context *context, const char *group, double parameter, judged_scene *out);
void judged_close(judged_scene *scene);
/* True if the tracer supports the scene's shapes. A library supports only triangles. Planes next to a library
 * would be intersected in float, so they count as unsupported. */
bool judged_suits(const judged_scene *scene, const trace_spec *spec);
