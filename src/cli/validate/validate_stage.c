#include "cli/validate/validate.h"

#include "verify/builtin.h"

#include "base/threads.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* More than one thread even on one processor: an error of parallel builds could appear in any build. */
#define BUILD_THREADS 4

static fathom_status open_extreme(fathom_context *context, const char *name, judged_scene *out) {
    char group[64];
    double number;
    if (sscanf(name, "%63[^:]:%lf", group, &number) == 2) return extremes_open(context, group, number, out);
    return fail(context, FATHOM_BAD_INPUT, "%s%.80s: expected a group of extreme cases, a colon and a number",
                VALIDATE_EXTREME, name);
}

fathom_status validate_stage_open(fathom_context *context, const char *name, judged_scene *out) {
    memset(out, 0, sizeof *out);
    size_t prefix = strlen(VALIDATE_EXTREME);
    if (strncmp(name, VALIDATE_EXTREME, prefix) == 0) return open_extreme(context, name + prefix, out);
    fathom_scene *scene;
    const bool is_file = strpbrk(name, "./");
    fathom_status status = (is_file ? fathom_scene_read : builtin_create)(context, name, &scene);
    return status == FATHOM_OK ? judged_open(context, scene, out) : status;
}

fathom_status validate_subject(fathom_context *context, const judged_scene *stage, const char *text,
                               compare_subject *out, trace_tracer **tracer) {
    trace_spec spec;
    *tracer = NULL;
    fathom_status status = trace_spec_parse(context, text, &spec);
    if (status != FATHOM_OK) return status;
    trace_options options = {.spec = &spec, .width = LANES, .threads = BUILD_THREADS};
    status = trace_create(context, stage->world, &options, tracer);
    if (status != FATHOM_OK) return status;
    *out = (compare_subject){stage->world, stage->search, stage->source, *tracer,
                             verdict_tracer_of(&spec, trace_unit(*tracer))};
    return FATHOM_OK;
}

/* ---- decoys ---- */

struct validate_decoys {
    const char *text;
    fathom_scene *scene;
    world *world;
    trace_tracer *tracers[2];
    fathom_context *context; /* context of the thread */
    pthread_t thread;
    bool started;
    atomic_bool stop;
};

/* Number of builds, and the pause between them in nanoseconds; a build takes far less. */
#define DECOY_BUILDS 40
#define DECOY_PAUSE 2000000

static fathom_status decoy(fathom_context *context, const validate_decoys *d, trace_tracer **out) {
    const trace_options options = {.words = d->text, .width = LANES, .threads = 1};
    return trace_create(context, d->world, &options, out);
}

static void *build_again(void *user) {
    validate_decoys *d = user;
    const struct timespec pause = {.tv_nsec = DECOY_PAUSE};
    for (int k = 0; k < DECOY_BUILDS && !atomic_load(&d->stop); ++k) {
        trace_tracer *tracer = NULL;
        (void)decoy(d->context, d, &tracer); /* an error here also occurs for the checked tracer */
        trace_destroy(tracer);
        nanosleep(&pause, NULL);
    }
    return NULL;
}

fathom_status validate_decoys_begin(fathom_context *context, const char *text, validate_decoys **out) {
    validate_decoys *d = *out = calloc(1, sizeof *d);
    if (!d) return fail_memory(context, sizeof *d);
    d->text = text;
    /* Decoys need a second thread to build at the same time. */
    if (threads_granted(1) == 0) return FATHOM_OK;
    fathom_status status = fathom_context_create(&d->context);
    if (status == FATHOM_OK) status = builtin_create(context, "masks", &d->scene);
    if (status == FATHOM_OK) status = world_create(d->scene, &d->world);
    return status == FATHOM_OK ? decoy(context, d, &d->tracers[0]) : status;
}

fathom_status validate_decoys_add(fathom_context *context, validate_decoys *d) {
    if (!d->world) return FATHOM_OK;
    fathom_status status = decoy(context, d, &d->tracers[1]);
    d->started = status == FATHOM_OK && pthread_create(&d->thread, NULL, build_again, d) == 0;
    return status;
}

void validate_decoys_end(validate_decoys *d) {
    if (!d) return;
    atomic_store(&d->stop, true);
    if (d->started) pthread_join(d->thread, NULL);
    trace_destroy(d->tracers[1]), trace_destroy(d->tracers[0]);
    world_destroy(d->world);
    fathom_scene_destroy(d->scene);
    fathom_context_destroy(d->context);
    free(d);
}
