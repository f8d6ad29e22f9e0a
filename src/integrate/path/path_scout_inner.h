/* Internals of scouts, shared by path_scout*.c. */
#pragma once

#include "base/array.h"
#include "integrate/path/path.h"

/* Light samples of a class that could bring light: their number, the sum of the fractions that arrived, and
 * that of the light. */
typedef struct scout_sum {
    double asked, seen, light;
} scout_sum;

/* The findings of a batch of paths. */
typedef struct scout_report {
    ARRAY(sky_ray) rays;
    ARRAY(emitter_glance) glances;
    scout_sum sums[EMITTER_PARTS];
} scout_report;

/* A light sample that waits for its shadow ray. */
typedef struct scout_question {
    uint32_t slot;
    emitter_part part; /* if EMITTER_OUTSIDE, it is the next one of the report's rays */
    uint32_t glance;   /* of the report's; FATHOM_NONE: it has none */
    double weight;     /* of the path */
    double possible;   /* its light if nothing hides it, */
    double before;     /* and the light of its slot before */
} scout_question;

/* The state of one thread. */
struct path_scout {
    path_wave *wave;
    scout_report report;
    bool glances;                         /* the report has them */
    scout_question questions[WAVE_SLOTS]; /* of this step */
    size_t count, answered;               /* of these, and of the report's rays */
    bool fails;                           /* out of memory */
};

/* Adds the rays and glances of all reports to the first one, and frees the others'. False: out of memory. */
bool scout_collect(scout_report *reports, uint32_t count);
