#include "base/pool.h"
#include "base/sized.h"
#include "image/image.h"
#include "job/checkpoint/checkpoint.h"
#include "job/render.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

SIZED_DEFAULT_OWN(fathom_session_options, {.progress = NULL})

struct fathom_session {
    fathom_context *context;
    const fathom_scene *scene;
    fathom_settings settings;
    fathom_session_options options;
    fathom_checkpoint saving;
    fathom_part part;
    fathom_ranks ranks;
    fathom_write_options write;
    char *tracer; /* copy of the settings' text; NULL: the caller's is used */
    pool_task task;
    bool in_background, on_thread; /* on_thread: the task runs in the pool */
    pthread_mutex_t lock;          /* guards the following */
    fathom_progress progress;
    const fathom_film *film; /* set during the render and after its end */
    bool stop;

    /* The result. */
    fathom_status helper; /* status of starting the image helper that the outputs need */
    fathom_status status;
    fathom_stats stats;
    fathom_film *result;
};

/* ---- the options ---- */

static fathom_status read_checkpoint(fathom_context *context, const fathom_checkpoint *from,
                                     fathom_checkpoint *out) {
    fathom_checkpoint_default(out);
    fathom_status status = sized_read_own(context, "checkpoint", from, out, sizeof *out);
    return status == FATHOM_OK && !out->path ? fail_null(context, "checkpoint: path") : status;
}

static fathom_status read_options(fathom_session *s, const fathom_session_options *options) {
    fathom_context *context = s->context;
    fathom_status status = SIZED_OWN(context, fathom_session_options, options, &s->options);
    if (status != FATHOM_OK) return status;
    if (s->options.checkpoint) status = read_checkpoint(context, s->options.checkpoint, &s->saving);
    if (status == FATHOM_OK && s->options.part)
        status = SIZED_OWN(context, fathom_part, s->options.part, &s->part);
    if (status == FATHOM_OK && s->options.part && s->options.checkpoint)
        status = fail(context, FATHOM_BAD_USAGE, "a part is its own checkpoint; expected one of the two");
    if (status == FATHOM_OK && s->options.ranks)
        status = SIZED_OWN(context, fathom_ranks, s->options.ranks, &s->ranks);
    if (status == FATHOM_OK && s->options.part && s->options.ranks)
        status = fail(context, FATHOM_BAD_USAGE, "one process renders a part; expected no other ranks");
    const fathom_write_options *write = s->options.write;
    if (status == FATHOM_OK && write) status = SIZED_OWN(context, fathom_write_options, write, &s->write);
    if (status == FATHOM_OK && !s->options.outputs && s->options.output_count)
        status = fail_null(context, "outputs");
    return status;
}

static fathom_status prepare(fathom_session *s, fathom_context *context, const fathom_scene *scene,
                             const fathom_settings *settings, const fathom_session_options *options) {
    if (!context || !scene) return fail_null(context, "scene");
    *s = (fathom_session){.context = context, .scene = scene, .progress = {.phase = FATHOM_PHASE_BUILD}};
    fathom_session_options_default(&s->options);
    fathom_write_options_default(&s->write);
    fathom_status status = SIZED_OWN(context, fathom_settings, settings, &s->settings);
    if (status == FATHOM_OK && options) status = read_options(s, options);
    if (status == FATHOM_OK) pthread_mutex_init(&s->lock, NULL);
    return status;
}

/* ---- rendering ---- */

/* The first output that the image helper writes, or NULL. */
static const char *output_with_helper(const fathom_session *s) {
    for (size_t i = 0; i < s->options.output_count; ++i) {
        if (image_needs_module(s->options.outputs[i], &s->write)) return s->options.outputs[i];
    }
    return NULL;
}

/* A render of hours must not end in a file that cannot be written. */
static bool outputs_are_lost(fathom_session *s) {
    if (output_with_helper(s)) s->helper = image_prefetch_status(s->context);
    return s->helper != FATHOM_OK;
}

static bool on_progress(void *user, const fathom_progress *progress) {
    fathom_session *s = user;
    pthread_mutex_lock(&s->lock);
    s->progress = *progress;
    bool stop = s->stop;
    pthread_mutex_unlock(&s->lock);
    const fathom_session_options *o = &s->options;
    if (o->progress && !o->progress(o->user, progress)) stop = true;
    return !outputs_are_lost(s) && !stop;
}

static void on_film(void *user, const fathom_film *film) {
    fathom_session *s = user;
    pthread_mutex_lock(&s->lock);
    s->film = film;
    pthread_mutex_unlock(&s->lock);
}

/* The fraction of the remaining time that may be used to measure the duration of writing. */
#define REHEARSAL 0.03

static double seconds_to_write(void *user, const fathom_film *film, double left) {
    const fathom_session *s = user;
    const film_outputs outputs = {s->options.outputs, s->options.output_count, &s->write};
    /* The second image takes at most as long as the first. */
    const int images = s->settings.fireflies == FATHOM_FIREFLIES_REWEIGHT ? 2 : 1;
    return images * film_write_seconds(s->context, film, &outputs, REHEARSAL * left);
}

static void run(void *user) {
    fathom_session *s = user;
    const job_reserve writing = {seconds_to_write, s};
    const render_request request = {.progress = on_progress,
                                    .on_film = s->in_background ? on_film : NULL,
                                    .user = s,
                                    .reserve = s->options.output_count ? &writing : NULL,
                                    .saving = s->options.checkpoint && !s->ranks.rank ? &s->saving : NULL,
                                    .part = s->options.part ? &s->part : NULL,
                                    .ranks = s->options.ranks ? &s->ranks : NULL,
                                    .keep_changed = s->options.keep_changed};
    s->status = render_film(s->context, s->scene, &s->settings, &request, &s->stats, &s->result);
    if (s->status == FATHOM_INTERRUPTED && s->helper != FATHOM_OK) {
        fathom_film_destroy(s->result);
        s->result = NULL;
        s->status = image_prefetch_status(s->context);
        fail_within(s->context, s->status, &(fathom_place){.file = output_with_helper(s)});
    }
    on_film(s, s->result);
}

/* Passes the result to the caller. */
static fathom_status end(fathom_session *s, fathom_stats *stats, fathom_film **out) {
    if (stats) sized_write(stats, &s->stats, sizeof s->stats);
    if (out)
        *out = s->result;
    else
        fathom_film_destroy(s->result);
    pthread_mutex_destroy(&s->lock);
    free(s->tracer);
    return s->status;
}

fathom_status fathom_session_run(fathom_context *context, const fathom_scene *scene,
                                 const fathom_settings *settings, const fathom_session_options *options,
                                 fathom_stats *stats, fathom_film **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    fathom_session s;
    fathom_status status = stats ? sized_check(context, "stats", stats, sizeof *stats) : FATHOM_OK;
    if (status == FATHOM_OK) status = prepare(&s, context, scene, settings, options);
    if (status != FATHOM_OK) return status;
    run(&s);
    return end(&s, stats, out);
}

fathom_status fathom_render(fathom_context *context, const fathom_scene *scene,
                            const fathom_settings *settings, fathom_progress_fn progress, void *user,
                            fathom_stats *stats, fathom_film **out) {
    fathom_session_options options;
    fathom_session_options_default(&options);
    options.progress = progress, options.user = user;
    return fathom_session_run(context, scene, settings, &options, stats, out);
}

/* ---- in the background ---- */

fathom_status fathom_session_start(fathom_context *context, const fathom_scene *scene,
                                   const fathom_settings *settings, const fathom_session_options *options,
                                   fathom_session **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    fathom_session *s = malloc(sizeof *s);
    if (!s) return fail_memory(context, sizeof *s);
    fathom_status status = prepare(s, context, scene, settings, options);
    if (status == FATHOM_OK && s->settings.tracer && !(s->tracer = strdup(s->settings.tracer))) {
        pthread_mutex_destroy(&s->lock);
        status = fail_memory(context, strlen(s->settings.tracer) + 1);
    }
    if (status != FATHOM_OK) {
        free(s);
        return status;
    }
    s->settings.tracer = s->tracer;
    s->in_background = true;
    s->task = (pool_task){.run = run, .user = s};
    s->on_thread = pool_run(&s->task);
    if (!s->on_thread) run(s);
    *out = s;
    return FATHOM_OK;
}

void fathom_session_progress_sized(fathom_session *session, fathom_progress *out, size_t size) {
    if (!session || !out) return;
    pthread_mutex_lock(&session->lock);
    sized_give(out, size, &session->progress, sizeof session->progress);
    pthread_mutex_unlock(&session->lock);
}

void fathom_session_stop(fathom_session *session) {
    if (!session) return;
    pthread_mutex_lock(&session->lock);
    session->stop = true;
    pthread_mutex_unlock(&session->lock);
}

bool fathom_session_wait(fathom_session *session, double seconds) {
    return !session || !session->on_thread || pool_wait(&session->task, seconds);
}

/* The lock prevents the destruction of the film during the copy. */
fathom_status fathom_session_snapshot(fathom_context *context, fathom_session *session, fathom_film **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!session) return fail_null(context, "session");
    pthread_mutex_lock(&session->lock);
    fathom_status status = session->film ? film_copy(context, session->film, out) : FATHOM_OK;
    pthread_mutex_unlock(&session->lock);
    return status;
}

fathom_status fathom_session_finish(fathom_session *session, fathom_stats *stats, fathom_film **out) {
    if (out) *out = NULL;
    if (!session || (stats && sized_check(NULL, "stats", stats, sizeof *stats) != FATHOM_OK))
        return FATHOM_BAD_USAGE;
    fathom_session_wait(session, -1);
    const fathom_status status = end(session, stats, out);
    free(session);
    return status;
}

fathom_status fathom_checkpoint_check(fathom_context *context, const fathom_checkpoint *request) {
    fathom_checkpoint asked;
    bool exists;
    if (!context) return FATHOM_BAD_USAGE;
    fathom_status status = read_checkpoint(context, request, &asked);
    return status == FATHOM_OK ? checkpoint_check_path(context, &asked, &exists) : status;
}
