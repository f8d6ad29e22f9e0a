/* Renders scenes whose radiance has a closed form, and tests the result. */
#pragma once

#include "base/array.h"
#include "verify/laws/room.h"

/* ---- statistical tests: the probability that a difference is only random ---- */

/* A mean with its standard error and the degrees of freedom of that error. */
typedef struct sample_mean {
    double mean, error, freedom;
} sample_mean;

/* P(|T| >= |t|) for Student's distribution; freedom: degrees of freedom, > 0. */
double student_p(double t, double freedom);

/* The p-value of the smallest of n independent p-values: 1 - (1-p)^n (Šidák). For positively dependent tests
 * it is an upper bound. */
double sidak(double p, double n);
/* The level of each of n tests for which their joint level is `level`. */
double sidak_level(double level, double n);

/* Probability of a difference from `value` at least as large as this one. Differences up to `allowance` may
 * come from rounding and are ignored. */
double mean_p(sample_mean a, double value, double allowance);
/* Compares two means with unequal errors (Welch 1947). missed: variance that the two errors lack. */
double welch_p(sample_mean a, sample_mean b, double missed, double allowance);

/* ---- laws ---- */

/* Renders a room with `samples` samples in all. out: mean over the image and its standard error, per
 * channel. */
typedef fathom_status laws_render(const law_room *room, uint64_t samples, uint64_t seed, sample_mean out[3]);

typedef struct laws_options {
    laws_render *render;
    double level;     /* probability of a false alarm in all laws together */
    double error;     /* the relative standard error to reach */
    double allowance; /* relative: difference that rounding may cause */
    uint64_t pilot;   /* samples of a first render, which gives the number needed */
    uint64_t samples; /* at most */
    uint64_t seed;
    const char *only;                           /* test only laws whose name contains this; NULL: all */
    bool (*go_on)(void *user, double fraction); /* may be NULL; false stops: FATHOM_INTERRUPTED */
    void *user;
} laws_options;

typedef enum laws_verdict { LAWS_HOLDS, LAWS_BROKEN, LAWS_NOISY, LAWS_REFUSED, LAWS_VERDICTS } laws_verdict;
const char *laws_verdict_name(laws_verdict v);

typedef struct laws_row {
    const law *law;
    double value[3];
    sample_mean found[3];
    double relative; /* the largest relative standard error */
    double p;        /* p-value, the smallest of the three channels */
    int worst;       /* the channel that has it */
    double off;      /* its deviation, in standard errors */
    uint64_t samples;
    double seconds;
    laws_verdict verdict; /* broken: p is below the level of one test; noisy: the error was not reached;
                             refused: the integrator does not support it */
    char refusal[200];
} laws_row;

typedef struct laws_rows {
    ARRAY(laws_row) rows;
    size_t tests;      /* three per row */
    double test_level; /* level of one test (Šidák) */
    double p;          /* corrected p-value of the smallest p */
} laws_rows;

/* Appends a row for each law. Release with laws_rows_free(), also after a failure. */
fathom_status laws_run(fathom_context *context, const laws_options *options, laws_rows *out);
void laws_rows_free(laws_rows *rows);
/* Number of broken or noisy rows. */
size_t laws_failed(const laws_rows *rows);

/* ---- renderers.c ---- */

/* fathom_render() with its path integrator, on the context's threads. Standard errors come from renders with
 * several seeds. */
laws_render laws_path;

/* ---- two renders of one scene ---- */

typedef struct laws_difference {
    size_t tests;
    double p;        /* the smallest p-value, corrected by Šidák */
    size_t worst;    /* index of that mean, three per cell; the last three are those of the whole image */
    double relative; /* relative difference of the sums over all means; and its standard error */
    double relative_error;
} laws_difference;

/* a, b: count means each, of independent samples that are not negative; three channels per cell. Tests each,
 * and for each channel their sum, which shows differences that are small everywhere. */
laws_difference laws_compare(const sample_mean *a, const sample_mean *b, size_t count, double allowance);

typedef struct laws_pair {
    uint32_t across, down; /* cells of 8 x 8 pixels, whose means are compared */
    uint32_t depth;        /* bounces */
    uint64_t samples;      /* per integrator, over the whole image */
    uint64_t seed;
    unsigned threads;
    double allowance; /* relative */
} laws_pair;

/* Renders the scene's own camera view: the path integrator minus the reference. FATHOM_BAD_INPUT if either
 * cannot render it. */
fathom_status laws_pair_run(fathom_context *context, const fathom_scene *scene, const laws_pair *options,
                            laws_difference *out);
