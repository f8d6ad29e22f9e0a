#include "base/pool.h"
#include "film/film.h"
#include "job/render.h"

#include <fathom/session.h>

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

struct fathom_session {
    fathom_context *context;
    const fathom_scene *scene;
    fathom_settings settings;
    char *tracer; /* the settings' */
    pool_task task;
    bool on_thread;       /* the task is the pool's */
    pthread_mutex_t lock; /* of the following */
    fathom_progress progress;
    const fathom_film *film; /* while it is being rendered, and from the end on */
    bool stop;

    /* The result. */
    fathom_status status;
    fathom_stats stats;
    fathom_film *result;
};

static bool on_progress(void *user, const fathom_progress *progress) {
    fathom_session *s = user;
    pthread_mutex_lock(&s->lock);
    s->progress = *progress;
    bool stop = s->stop;
    pthread_mutex_unlock(&s->lock);
    return !stop;
}

static void on_film(void *user, const fathom_film *film) {
    fathom_session *s = user;
    pthread_mutex_lock(&s->lock);
    s->film = film;
    pthread_mutex_unlock(&s->lock);
}

static void run(void *user) {
    fathom_session *s = user;
    s->status =
        render_watched(s->context, s->scene, &s->settings, on_film, on_progress, s, &s->stats, &s->result);
    on_film(s, s->result);
}

static void destroy(fathom_session *s) {
    pthread_mutex_destroy(&s->lock);
    free(s->tracer);
    free(s);
}

fathom_status fathom_session_start(fathom_context *context, const fathom_scene *scene,
                                   const fathom_settings *settings, fathom_session **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !scene) return fail_null(context, "scene");
    if (!settings) return fail_null(context, "settings");
    fathom_session *s = calloc(1, sizeof *s);
    if (!s) return fail_memory(context, sizeof *s);
    if (settings->tracer && !(s->tracer = strdup(settings->tracer))) {
        free(s);
        return fail_memory(context, strlen(settings->tracer) + 1);
    }
    s->context = context, s->scene = scene;
    s->settings = *settings;
    s->settings.tracer = s->tracer;
    s->progress.phase = FATHOM_PHASE_BUILD;
    pthread_mutex_init(&s->lock, NULL);
    s->task = (pool_task){.run = run, .user = s};
    s->on_thread = pool_run(&s->task);
    if (!s->on_thread) run(s);
    *out = s;
    return FATHOM_OK;
}

void fathom_session_progress(fathom_session *session, fathom_progress *out) {
    if (!session || !out) return;
    pthread_mutex_lock(&session->lock);
    *out = session->progress;
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

/* The lock keeps the film from being destroyed meanwhile. */
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
    if (stats) *stats = (fathom_stats){0};
    if (!session) return FATHOM_BAD_USAGE;
    fathom_session_wait(session, -1);
    const fathom_status status = session->status;
    if (stats) *stats = session->stats;
    if (out)
        *out = session->result;
    else
        fathom_film_destroy(session->result);
    destroy(session);
    return status;
}
