/* Closed forms of light, rendered and judged. */
#ifndef VERIFY_LAWS_LAWS_H
#define VERIFY_LAWS_LAWS_H

#include "base/array.h"
#include "verify/laws/room.h"
#include "verify/laws/statistics.h"

/* Renders a room: the mean over the image of so many samples in all, and its standard error. */
typedef struct laws_render {
    const char *name;
    fathom_status (*render)(void *user, const law_room *room, uint64_t samples, uint64_t seed,
                            sample_mean out[3]);
    void *user;
} laws_render;

typedef struct laws_options {
    laws_render render;
    double level;     /* of a false alarm in all laws together */
    double error;     /* the relative standard error to reach */
    double allowance; /* relative: what rounding may take away or add */
    uint64_t pilot;   /* samples that tell how many are needed */
    uint64_t samples; /* at most */
    uint64_t seed;
    const char *only;                           /* part of the names of the laws to test; NULL: all */
    bool (*go_on)(void *user, double fraction); /* NULL, or false to stop: FATHOM_INTERRUPTED */
    void *user;
} laws_options;

typedef enum laws_verdict { LAWS_HOLDS, LAWS_BROKEN, LAWS_NOISY, LAWS_REFUSED, LAWS_VERDICTS } laws_verdict;
const char *laws_verdict_name(laws_verdict v);

typedef struct laws_row {
    const law *law;
    double value[3];
    sample_mean found[3];
    double off;      /* the largest deviation, in standard errors */
    double relative; /* the largest relative standard error */
    double p;        /* the smallest of the three channels */
    uint64_t samples;
    double seconds;
    laws_verdict verdict; /* broken: p is below the level of one test; noisy: the error was not reached;
                             refused: the integrator does not do it */
    char refusal[200];
} laws_row;

typedef struct laws_rows {
    ARRAY(laws_row) rows;
    size_t tests;      /* three a row */
    double test_level; /* of one test (Šidák) */
    double p;          /* of the smallest p-value, corrected */
} laws_rows;

/* Appends a row for each law. Release with laws_rows_free() whatever comes back. */
fathom_status laws_run(fathom_context *context, const laws_options *options, laws_rows *out);
void laws_rows_free(laws_rows *rows);
/* Broken or noisy. */
size_t laws_failed(const laws_rows *rows);

/* ---- renderers.c ---- */

/* The reference integrator; *threads: how many. */
laws_render laws_reference(unsigned *threads);
/* fathom_render() with its path integrator, on the context's threads. Errors come from renders of several
 * seeds. */
laws_render laws_path(void);

/* ---- two renders of one scene ---- */

typedef struct laws_difference {
    size_t tests;
    double p;        /* the smallest, corrected by Šidák */
    size_t worst;    /* where: the index of the mean, three to a cell */
    double relative; /* of the sums over all means; its standard error */
    double relative_error;
} laws_difference;

/* Raises errors of means, each of so many samples, to what one sample more can change. */
void laws_least_error(sample_mean *means, size_t count, double samples);
/* count means of each, three channels of one cell after another. */
laws_difference laws_compare(const sample_mean *a, const sample_mean *b, size_t count, double allowance);

typedef struct laws_pair {
    uint32_t across, down; /* cells of 8 x 8 pixels, whose means are compared */
    uint32_t depth;        /* bounces */
    uint64_t samples;      /* of each integrator, over the whole image */
    uint64_t seed;
    unsigned threads;
    double allowance; /* relative */
} laws_pair;

/* The path integrator less the reference: the scene as its camera sees it. FATHOM_BAD_INPUT where either does
 * not render it. */
fathom_status laws_pair_run(fathom_context *context, const fathom_scene *scene, const laws_pair *options,
                            laws_difference *out);

#endif
