/* The tiles of a render ("waves", film/squares.h) handed out by need.
 *
 *     rank 0                                  others
 *       ◀── HELLO: what I render ───────────── once
 *       ◀── WANT: so many threads ──────────── when fewer tiles wait than there are threads
 *       ─── WAVES: these, or none: the end ──▶
 *       ◀── DONE: a tile's record and pixels ─ each
 *
 * One thread of each rank talks, and sleeps between two looks: MPI's own waiting would keep a processor busy.
 * So tiles are asked for ahead. Rank 0 hands out many at a time while there are many, and single ones in the
 * end. A rank that dies takes the whole job with it; what came before is in the film and the checkpoint of
 * rank 0. */
#include "job/ranks/ranks.h"

#include "base/pool.h"
#include "base/sized.h"
#include "job/part/part_file.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

SIZED_DEFAULT_OWN(fathom_ranks, {.count = 1})

enum { HELLO = 1, WANT, WAVES, DONE };

/* Waves of a unit of work for each thread, at most; and the part of all that is left that one request gets.
 */
#define MOST_WAVES 64u
#define LEFT_SHARE 4u

/* Between two looks for messages. */
#define SLEEP_NANOSECONDS 1000000

typedef struct message {
    uint32_t kind, count;
    /* the key; nothing; `count` waves; a part_record and pixels */
} message;

typedef struct outgoing {
    struct outgoing *next;
    size_t size;
    char bytes[];
} outgoing;

struct ranks {
    fathom_context *context;
    const fathom_ranks *other;
    fathom_film *film;
    checkpoint *saving;
    checkpoint_key key;
    part_shape shape;
    uint32_t threads; /* of this rank, and as a guess of each */
    wave_share share;
    pool_task task;
    bool is_talking;
    pthread_mutex_t mutex; /* of the following */
    pthread_cond_t changed;
    uint32_t *waves; /* to do; others than rank 0 get some at a time */
    uint32_t first, end, room;
    uint32_t away;  /* handed to other ranks */
    uint32_t ended; /* other ranks that were told that there is no more */
    bool asked;     /* for more */
    bool no_more;   /* to come */
    bool stop;      /* talking */
    bool no_memory;
    char differs[768]; /* what another rank renders; "": nothing else */
    outgoing *out, **out_end;
};

static bool is_root(const ranks *r) { return !r->other->rank; }

/* ---- work ---- */

/* Under the lock. How many at once: guided by how many are left. */
static uint32_t hand_out(ranks *r, uint32_t threads, uint32_t *to) {
    const uint32_t left = r->end - r->first, all = r->threads * r->other->count;
    uint32_t each = left / (LEFT_SHARE * all), count = 0;
    each = each < 1 ? 1 : each > MOST_WAVES ? MOST_WAVES : each;
    while (count < each * threads && r->first < r->end) to[count++] = r->waves[r->first++];
    return count;
}

static void wait_changed(ranks *r) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += 50000000;
    if (until.tv_nsec >= 1000000000) until.tv_nsec -= 1000000000, ++until.tv_sec;
    pthread_cond_timedwait(&r->changed, &r->mutex, &until);
}

/* Rank 0 is done when all others' tiles are there, and all others know that there are no more. */
static bool is_waiting(const ranks *r) {
    return r->first == r->end && (!r->no_more || r->away || (is_root(r) && r->ended + 1 < r->other->count));
}

static bool next(void *user, const atomic_bool *stop, uint32_t *wave) {
    ranks *r = user;
    pthread_mutex_lock(&r->mutex);
    while (!r->stop && !atomic_load(stop) && is_waiting(r)) wait_changed(r);
    const bool found = !r->stop && r->first < r->end;
    if (found) *wave = r->waves[r->first++];
    pthread_mutex_unlock(&r->mutex);
    return found;
}

/* Under the lock. The message goes when the talking thread comes to it. */
static bool put(ranks *r, uint32_t kind, uint32_t count, const void *a, size_t a_size, size_t more,
                char **rest) {
    const message head = {kind, count};
    outgoing *o = malloc(sizeof *o + sizeof head + a_size + more);
    if (!o) return false;
    o->next = NULL, o->size = sizeof head + a_size + more;
    memcpy(o->bytes, &head, sizeof head);
    if (a_size) memcpy(o->bytes + sizeof head, a, a_size);
    *rest = o->bytes + sizeof head + a_size;
    *r->out_end = o;
    r->out_end = &o->next;
    return true;
}

/* Rank 0 has its own pixels in the film, and the checkpoint knows. */
static bool take(void *user, const wave_result *w) {
    ranks *r = user;
    if (is_root(r)) return true;
    const size_t bytes = part_wave_bytes(&r->shape, w->wave);
    const part_record record = {PART_RECORD, w->wave, w->samples, bytes, w->error, w->seconds, w->rays};
    char *pixels;
    pthread_mutex_lock(&r->mutex);
    const bool fine = put(r, DONE, 1, &record, sizeof record, bytes, &pixels);
    if (fine) part_pixels_save(&r->shape.grid, r->film, w->wave, (unsigned char *)pixels);
    r->no_memory |= !fine;
    pthread_mutex_unlock(&r->mutex);
    return fine;
}

/* ---- messages to rank 0 ---- */

static void compare_key(ranks *r, uint32_t from, const checkpoint_key *theirs) {
    key_difference d;
    if (!checkpoint_key_differs(theirs, &r->key, &d)) return;
    snprintf(r->differs, sizeof r->differs,
             "rank %u renders with %s %s, and rank 0 with %s; expected the same program, scene and machines "
             "of one "
             "instruction set ($FATHOM_ISA)",
             from, d.name, d.saved, d.now);
    r->stop = true;
}

static void answer(ranks *r, uint32_t from, uint32_t threads) {
    uint32_t *waves = malloc((size_t)threads * MOST_WAVES * sizeof *waves);
    const message head = {WAVES, waves ? hand_out(r, threads, waves) : 0};
    const size_t bytes = head.count * sizeof *waves;
    char *all = malloc(sizeof head + bytes);
    if (waves && all) {
        memcpy(all, &head, sizeof head);
        memcpy(all + sizeof head, waves, bytes);
        r->away += head.count;
        r->ended += !head.count;
    }
    r->no_memory |= !waves || !all || !r->other->send(r->other->user, from, all, sizeof head + bytes);
    r->stop |= r->no_memory;
    pthread_cond_broadcast(&r->changed);
    free(all);
    free(waves);
}

static void count_others(ranks *r, const part_record *w, uint64_t pixels) {
    wave_result *sum = &r->share.others;
    sum->error = fmax(sum->error, w->error);
    sum->rays.camera += w->rays.camera;
    sum->rays.shadow += w->rays.shadow;
    sum->rays.reflection += w->rays.reflection;
    sum->rays.refraction += w->rays.refraction;
    sum->rays.repaired += w->rays.repaired;
    sum->rays.unlit += w->rays.unlit;
    sum->rays.faint += w->rays.faint;
    atomic_fetch_add(&r->share.others_pixels, pixels);
}

/* Squares that an earlier call has finished keep their pixels, which are the same, and their count. */
static void take_pixels(ranks *r, const part_record *w, const unsigned char *pixels) {
    const uint64_t finished = r->saving ? checkpoint_finished(r->saving, w->wave) : 0;
    const uint64_t count = checkpoint_pixels(&r->shape.grid, w->wave, ~finished);
    const uint64_t samples = finished ? count * r->film->settings.spp : w->samples;
    pthread_mutex_lock(&r->film->lock);
    part_pixels_load(&r->shape.grid, r->film, w->wave, pixels);
    pthread_mutex_unlock(&r->film->lock);
    if (r->saving) checkpoint_take(r->saving, w->wave, samples, w->error);
    r->share.others.samples += samples;
    count_others(r, w, count);
    --r->away;
    pthread_cond_broadcast(&r->changed);
}

static void on_message_to_root(ranks *r, uint32_t from, const message *m, const unsigned char *body,
                               size_t size) {
    part_record record;
    checkpoint_key key;
    if (m->kind == HELLO && size == sizeof key) {
        memcpy(&key, body, sizeof key);
        compare_key(r, from, &key);
    } else if (m->kind == WANT) {
        answer(r, from, m->count);
    } else if (m->kind == DONE && size > sizeof record) {
        memcpy(&record, body, sizeof record);
        if (record.wave < r->shape.grid.count &&
            size == sizeof record + part_wave_bytes(&r->shape, record.wave))
            take_pixels(r, &record, body + sizeof record);
    }
}

/* ---- messages to others ---- */

static void add_waves(ranks *r, uint32_t count, const void *waves) {
    const uint32_t left = r->end - r->first;
    r->asked = false;
    r->no_more |= !count;
    if (left + count > r->room) {
        uint32_t *more = malloc((left + count) * sizeof *more);
        if (!more) {
            r->no_memory = r->stop = true;
            return;
        }
        memcpy(more, r->waves + r->first, left * sizeof *more);
        free(r->waves);
        r->waves = more, r->room = left + count;
    } else {
        memmove(r->waves, r->waves + r->first, left * sizeof *r->waves);
    }
    memcpy(r->waves + left, waves, count * sizeof *r->waves);
    r->first = 0, r->end = left + count;
    pthread_cond_broadcast(&r->changed);
}

static void ask_for_more(ranks *r) {
    char *rest;
    if (is_root(r) || r->asked || r->no_more || r->end - r->first >= r->threads) return;
    r->asked = put(r, WANT, r->threads, NULL, 0, 0, &rest);
}

/* ---- talking ---- */

static void on_message(ranks *r, uint32_t from, const void *bytes, size_t size) {
    message m;
    if (size < sizeof m) return;
    memcpy(&m, bytes, sizeof m);
    const unsigned char *body = (const unsigned char *)bytes + sizeof m;
    if (is_root(r))
        on_message_to_root(r, from, &m, body, size - sizeof m);
    else if (m.kind == WAVES && size - sizeof m == m.count * sizeof(uint32_t))
        add_waves(r, m.count, body);
}

/* True when anything was sent. */
static bool send_waiting(ranks *r) {
    bool any = false;
    while (r->out) {
        outgoing *o = r->out;
        if (!r->other->send(r->other->user, 0, o->bytes, o->size)) r->no_memory = r->stop = true;
        r->out = o->next;
        if (!r->out) r->out_end = &r->out;
        free(o);
        any = true;
    }
    return any;
}

static void talk(void *user) {
    ranks *r = user;
    const struct timespec pause = {0, SLEEP_NANOSECONDS};
    for (bool busy, done = false; !done;) {
        uint32_t from;
        size_t size;
        const void *bytes;
        pthread_mutex_lock(&r->mutex);
        ask_for_more(r);
        busy = send_waiting(r);
        if (r->other->receive(r->other->user, &from, &bytes, &size)) {
            on_message(r, from, bytes, size);
            busy = true;
        }
        done = r->stop && !busy;
        pthread_mutex_unlock(&r->mutex);
        if (!busy) nanosleep(&pause, NULL);
    }
}

/* ---- beginning and end ---- */

static bool list_waves(ranks *r) {
    r->room = r->shape.grid.count;
    r->waves = malloc(r->room * sizeof *r->waves);
    for (uint32_t i = 0; r->waves && is_root(r) && i < r->room; ++i) {
        if (!r->saving || !checkpoint_is_finished(r->saving, i)) r->waves[r->end++] = i;
    }
    r->no_more = is_root(r);
    return r->waves;
}

fathom_status ranks_open(fathom_context *context, const fathom_ranks *options,
                         const fathom_settings *settings, fathom_film *film, ranks **out) {
    *out = NULL;
    if (settings->max_time > 0) {
        return fail(
            context, FATHOM_BAD_USAGE,
            "a render to a time is one process's work: the clock decides which samples are taken; expected a "
            "target error, or a number of samples");
    }
    ranks *r = calloc(1, sizeof *r);
    if (!r) return fail_memory(context, sizeof *r);
    part_head head = {.index = 1,
                      .count = 1,
                      .split = FATHOM_SPLIT_TILES,
                      .settings = *settings,
                      .light_groups = film->light_groups};
    r->context = context, r->other = options, r->film = film;
    r->shape = part_shape_of(&head);
    r->threads = fathom_context_threads(context);
    checkpoint_key_of(settings, film->stats.scene_fingerprint, &r->key);
    pthread_mutex_init(&r->mutex, NULL);
    pthread_cond_init(&r->changed, NULL);
    *out = r;
    return FATHOM_OK;
}

fathom_status ranks_begin(ranks *r, const char *tracer, checkpoint *saving, wave_share **share) {
    char *rest;
    r->saving = saving;
    r->out_end = &r->out;
    checkpoint_key_set_tracer(&r->key, tracer);
    bool fine = list_waves(r);
    if (fine && !is_root(r)) fine = put(r, HELLO, 0, &r->key, sizeof r->key, 0, &rest);
    if (!fine) return fail_memory(r->context, r->room * sizeof *r->waves);
    r->share.user = r;
    r->share.pixels = (uint64_t)r->film->width * r->film->height;
    r->share.next = next, r->share.take = take;
    r->task = (pool_task){.run = talk, .user = r};
    r->is_talking = pool_run(&r->task);
    if (!r->is_talking)
        return fail(r->context, FATHOM_OUT_OF_RESOURCES, "there is no thread to talk to other ranks");
    *share = &r->share;
    return FATHOM_OK;
}

static fathom_status status_of(const ranks *r, fathom_status status) {
    if (r->differs[0]) return fail(r->context, FATHOM_BAD_INPUT, "%s", r->differs);
    if (r->no_memory)
        return fail(r->context, FATHOM_OUT_OF_RESOURCES, "out of memory for messages between ranks");
    return status;
}

fathom_status ranks_close(ranks *r, fathom_status status) {
    if (!r) return status;
    pthread_mutex_lock(&r->mutex);
    r->stop = true;
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
    if (r->is_talking) pool_wait(&r->task, -1);
    status = status_of(r, status);
    while (r->out) {
        outgoing *o = r->out;
        r->out = o->next;
        free(o);
    }
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->mutex);
    free(r->waves);
    free(r);
    return status;
}
