/* Rank 0 hands out units of work (job/unit.h) on request.
 *
 *     rank 0                                  others
 *       ◀── HELLO: key of the render ────────── once
 *       ◀── DONE: records and pixels ────────── of all finished units, before more are requested, or sooner
 *       ◀── WANT: number of threads ─────────── when fewer units are queued than there are threads
 *       ─── UNITS: these; none: the end ─────▶
 *
 * Ranks that cannot open the scene's files request these first: ranks_files.c.
 *
 * One thread of each rank sends and receives, and sleeps between two polls: MPI's own waiting would keep a
 * processor busy. At first, rank 0 hands out many squares at a time; at the end, as many as one batch of
 * samples needs. If a rank dies, the whole job ends; work that rank 0 has received is in its film and
 * checkpoint. */
#include "job/ranks/ranks.h"

#include "base/clock.h"
#include "base/pool.h"
#include "base/sized.h"
#include "job/checkpoint/checkpoint_state.h"
#include "job/ranks/ranks_files.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

SIZED_DEFAULT_OWN(fathom_ranks, {.count = 1})

/* One thread gets 1 / LEFT_SHARE of its part of the remaining squares, but at least enough for
 * REQUEST_SECONDS (three polls) and until rank 0 has answered all other ranks. A reply has at most MOST_UNITS
 * units. */
#define LEFT_SHARE 4u
#define REQUEST_SECONDS 0.003
#define ANSWER_SECONDS 8e-6
#define MOST_UNITS 1024u

/* Seconds between two polls for messages: LOOK_SECONDS on rank 0 or while a reply is due; otherwise
 * IDLE_SECONDS, only so that MPI continues its sends. */
#define LOOK_SECONDS 0.001
#define IDLE_SECONDS 0.02

/* Finished units are sent at once if they exceed this size or age. */
#define MOST_RESULTS ((size_t)4 << 20)
#define RESULT_SECONDS 1.0

struct ranks {
    fathom_context *context;
    const fathom_ranks *other;
    fathom_film *film;
    checkpoint *saving;
    checkpoint_key key;
    wave_grid grid;
    uint32_t threads; /* of this rank; assumed for every other rank */
    uint32_t least;   /* minimum squares of a unit */
    wave_share share;
    pool_task task;
    bool is_talking;
    char wrong[768];       /* error about another rank; "": none */
    pthread_mutex_t mutex; /* guards the following */
    pthread_cond_t changed;
    unit_queue queue;  /* units to do; other ranks than 0 receive some at a time */
    unit_results done; /* results to send */
    double next_report;
    double seconds;   /* that other ranks spent on `squares` */
    uint64_t squares; /* finished by other ranks */
    uint32_t away;    /* units handed to other ranks */
    uint32_t ended;   /* number of other ranks that were told that no work is left */
    bool asked;       /* a request for more is pending */
    bool no_more;     /* no more units will come */
    bool stop;        /* ends the communication thread */
    bool no_memory;
};

static bool is_root(const ranks *r) { return !r->other->rank; }

/* ---- work ---- */

/* Squares per thread of the requesting rank; runs with the lock held. Fewer towards the end, so that all
 * ranks finish together. */
static uint32_t squares_each(const ranks *r) {
    const double all = (double)r->threads * r->other->count, left = (double)r->queue.squares;
    const double enough = fmax(REQUEST_SECONDS, ANSWER_SECONDS * r->other->count);
    const double lasting = r->seconds > 0 ? enough * (double)r->squares / r->seconds : 0;
    const double each = fmax(left / (LEFT_SHARE * all), fmin(lasting, left / all));
    const uint32_t whole = (uint32_t)fmin(each, MOST_UNITS * WAVE_SQUARES) / r->least * r->least;
    return max_u32(whole, r->least);
}

static work_unit take_unit(ranks *r, uint32_t squares) {
    return unit_queue_take(&r->queue, max_u32(min_u32(squares, WAVE_SQUARES), r->least));
}

static void wait_changed(ranks *r, double seconds) {
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += (long)(seconds * 1e9);
    if (until.tv_nsec >= 1000000000) until.tv_nsec -= 1000000000, ++until.tv_sec;
    pthread_cond_timedwait(&r->changed, &r->mutex, &until);
}

/* Rank 0 must wait until all other ranks' results have arrived and all of them know that no work is left. */
static bool is_waiting(const ranks *r) {
    return !r->queue.squares && (!r->no_more || r->away || (is_root(r) && r->ended + 1 < r->other->count));
}

static bool wants_more(const ranks *r) {
    return !is_root(r) && !r->asked && !r->no_more && r->queue.units.count - r->queue.first < r->threads;
}

static bool next(void *user, const atomic_bool *stop, work_unit *unit) {
    ranks *r = user;
    pthread_mutex_lock(&r->mutex);
    while (!r->stop && !atomic_load(stop) && is_waiting(r)) wait_changed(r, 0.05);
    const bool found = !r->stop && r->queue.squares;
    if (found) *unit = take_unit(r, is_root(r) ? squares_each(r) : WAVE_SQUARES);
    if (wants_more(r)) pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
    return found;
}

/* Rank 0 sends nothing: its pixels are already in the film and the checkpoint. */
static bool take(void *user, const wave_result *w) {
    ranks *r = user;
    if (is_root(r)) return true;
    const unit_record record = {w->unit, w->samples, w->error, w->seconds, w->rays};
    pthread_mutex_lock(&r->mutex);
    char *to = unit_results_add(
        &r->done, sizeof record + checkpoint_pixel_bytes(r->film->channel_count, w->unit.squares));
    if (to) {
        memcpy(to, &record, sizeof record);
        checkpoint_pixels_save(&r->grid, r->film, w->unit.wave, w->unit.squares,
                               (unsigned char *)to + sizeof record);
    }
    r->no_memory |= !to;
    if (r->no_more) pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
    return to;
}

/* ---- on the thread that talks ---- */

static void say(ranks *r, uint32_t to, const void *bytes, size_t size) {
    if (!r->other->send(r->other->user, to, bytes, size)) r->no_memory = r->stop = true;
}

static void stop(ranks *r) {
    pthread_mutex_lock(&r->mutex);
    r->stop = true;
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
}

/* False: the message is not a key. */
static bool compare_key(ranks *r, uint32_t from, const unsigned char *body) {
    checkpoint_key theirs;
    key_difference d;
    memcpy(&theirs, body, sizeof theirs);
    if (!checkpoint_key_is_whole(&theirs)) return false;
    if (!checkpoint_key_differs(&theirs, &r->key, &d)) return true;
    snprintf(r->wrong, sizeof r->wrong,
             "rank %u renders with %s %s, and rank 0 with %s; expected the same program, scene and machines "
             "of one instruction set ($FATHOM_ISA)",
             from, d.name, d.saved, d.now);
    stop(r);
    return true;
}

static void answer(ranks *r, uint32_t from, uint32_t threads) {
    struct {
        message head;
        work_unit units[MOST_UNITS];
    } all = {.head = {UNITS, 0}};
    pthread_mutex_lock(&r->mutex);
    const uint64_t wanted = (uint64_t)squares_each(r) * threads;
    for (uint64_t given = 0; given < wanted && r->queue.squares && all.head.count < MOST_UNITS;) {
        const work_unit u = take_unit(r, squares_each(r));
        given += (uint64_t)__builtin_popcountll(u.squares);
        all.units[all.head.count++] = u;
    }
    r->away += all.head.count;
    r->ended += !all.head.count;
    say(r, from, &all, sizeof all.head + all.head.count * sizeof *all.units);
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
}

static bool makes_sense(const ranks *r, const work_unit *u) {
    return u->wave < r->grid.count && u->squares &&
           !(u->squares & ~wave_region_bits(wave_grid_region(&r->grid, u->wave)));
}

static void count_result(ranks *r, const unit_record *w) {
    wave_result *sum = &r->share.others;
    pthread_mutex_lock(&r->mutex);
    sum->samples += w->samples;
    sum->error = fmax(sum->error, w->error);
    ray_counts_add(&w->rays, 1, &sum->rays);
    r->seconds += w->seconds;
    r->squares += (uint64_t)__builtin_popcountll(w->unit.squares);
    --r->away;
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
}

/* Stores the next record of a message, with its pixels, in the film. */
static bool take_result(ranks *r, const unsigned char **at, size_t *left) {
    unit_record w;
    if (*left < sizeof w) return false;
    memcpy(&w, *at, sizeof w);
    const size_t bytes = checkpoint_pixel_bytes(r->film->channel_count, w.unit.squares);
    if (!makes_sense(r, &w.unit) || *left - sizeof w < bytes || !r->away) return false;
    pthread_mutex_lock(&r->film->lock);
    checkpoint_pixels_load(&r->grid, r->film, w.unit.wave, w.unit.squares, *at + sizeof w);
    pthread_mutex_unlock(&r->film->lock);
    if (r->saving) checkpoint_take(r->saving, w.unit.wave, w.unit.squares, w.samples, w.error);
    atomic_fetch_add(&r->share.others_pixels, checkpoint_pixels(&r->grid, w.unit.wave, w.unit.squares));
    count_result(r, &w);
    *at += sizeof w + bytes, *left -= sizeof w + bytes;
    return true;
}

static bool take_results(ranks *r, uint32_t count, const unsigned char *body, size_t left) {
    while (count && take_result(r, &body, &left)) --count;
    return !count && !left;
}

static bool add_units(ranks *r, uint32_t count, const unsigned char *body) {
    bool fine = true;
    pthread_mutex_lock(&r->mutex);
    r->asked = false;
    r->no_more |= !count;
    for (; count && fine; --count, body += sizeof(work_unit)) {
        work_unit u;
        memcpy(&u, body, sizeof u);
        fine = makes_sense(r, &u);
        if (fine && !unit_queue_add(&r->queue, u)) r->no_memory = r->stop = true;
    }
    pthread_cond_broadcast(&r->changed);
    pthread_mutex_unlock(&r->mutex);
    return fine;
}

static bool understand(ranks *r, uint32_t from, const message *m, const unsigned char *body, size_t size) {
    if (!is_root(r))
        return m->kind == UNITS && size == m->count * sizeof(work_unit) && add_units(r, m->count, body);
    if (m->kind == HELLO) return size == sizeof(checkpoint_key) && compare_key(r, from, body);
    if (m->kind == FILE_WANTED) return ranks_answer_file(r->other, r->context, from, body, size, m->count);
    if (m->kind == DONE) return take_results(r, m->count, body, size);
    if (m->kind == WANT && !size) answer(r, from, m->count);
    return m->kind == WANT && !size;
}

/* True if there was a message. */
static bool hear(ranks *r) {
    uint32_t from;
    size_t size;
    const void *bytes;
    message m = {0, 0};
    if (!r->other->receive(r->other->user, &from, &bytes, &size)) return false;
    if (size >= sizeof m) memcpy(&m, bytes, sizeof m);
    if (size >= sizeof m && understand(r, from, &m, (const unsigned char *)bytes + sizeof m, size - sizeof m))
        return true;
    snprintf(r->wrong, sizeof r->wrong,
             "rank %u sent a message that makes no sense; expected the same program on all machines", from);
    stop(r);
    return true;
}

static void send_results(ranks *r) {
    const message head = {DONE, r->done.count};
    memcpy(r->done.message.items, &head, sizeof head);
    say(r, 0, r->done.message.items, r->done.message.count);
    r->done.message.count = r->done.count = 0;
    r->next_report = clock_seconds() + RESULT_SECONDS;
}

/* Runs with the lock held, on ranks other than 0. Sends results before a request, so that rank 0 knows of
 * them when it hands out more. */
static void report(ranks *r) {
    const bool asks = wants_more(r);
    if (r->done.count && (asks || r->no_more || r->stop || r->done.message.count > MOST_RESULTS ||
                          clock_seconds() > r->next_report))
        send_results(r);
    if (!asks) return;
    say(r, 0, &(message){WANT, r->threads}, sizeof(message));
    r->asked = true;
}

static void talk(void *user) {
    ranks *r = user;
    for (bool heard, done = false; !done;) {
        heard = hear(r);
        pthread_mutex_lock(&r->mutex);
        if (!is_root(r)) report(r);
        done = r->stop && !heard;
        if (!heard && !done) wait_changed(r, is_root(r) || r->asked ? LOOK_SECONDS : IDLE_SECONDS);
        pthread_mutex_unlock(&r->mutex);
    }
}

/* ---- beginning and end ---- */

static bool list_units(ranks *r) {
    for (uint32_t i = 0; is_root(r) && i < r->grid.count; ++i) {
        work_unit u = {.wave = i, .squares = wave_region_bits(wave_grid_region(&r->grid, i))};
        if (r->saving) u.squares &= ~checkpoint_finished(r->saving, i);
        if (u.squares && !unit_queue_add(&r->queue, u)) return false;
    }
    r->no_more = is_root(r);
    return true;
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
    r->context = context, r->other = options, r->film = film;
    r->grid = film_waves(film);
    r->threads = fathom_context_threads(context);
    /* With a target error, all squares of a wave decide together, so a unit is a whole wave. */
    r->least = settings->target_error > 0 ? WAVE_SQUARES : unit_least_squares(settings->spp);
    checkpoint_key_of(settings, film->stats.scene_fingerprint, &r->key);
    pthread_mutex_init(&r->mutex, NULL);
    pthread_cond_init(&r->changed, NULL);
    *out = r;
    return FATHOM_OK;
}

static void say_hello(ranks *r) {
    struct {
        message head;
        checkpoint_key key;
    } hello = {{HELLO, 0}, r->key};
    say(r, 0, &hello, sizeof hello);
}

fathom_status ranks_begin(ranks *r, const char *tracer, checkpoint *saving, wave_share **share) {
    r->saving = saving;
    checkpoint_key_set_tracer(&r->key, tracer);
    if (!list_units(r)) return fail_memory(r->context, r->grid.count * sizeof(work_unit));
    r->share.user = r;
    r->share.pixels = (uint64_t)r->film->width * r->film->height;
    r->share.next = next, r->share.take = take;
    *share = &r->share;
    if (r->other->count == 1) return FATHOM_OK;
    if (!is_root(r)) say_hello(r);
    r->task = (pool_task){.run = talk, .user = r};
    r->is_talking = pool_run(&r->task);
    if (r->is_talking) return FATHOM_OK;
    return fail(r->context, FATHOM_OUT_OF_RESOURCES, "there is no thread to talk to other ranks");
}

static fathom_status status_of(const ranks *r, fathom_status status) {
    if (r->wrong[0]) return fail(r->context, FATHOM_BAD_INPUT, "%s", r->wrong);
    if (r->no_memory)
        return fail(r->context, FATHOM_OUT_OF_RESOURCES, "out of memory for messages between ranks");
    return status;
}

fathom_status ranks_close(ranks *r, fathom_status status) {
    if (!r) return status;
    stop(r);
    if (r->is_talking) pool_wait(&r->task, -1);
    status = status_of(r, status);
    pthread_cond_destroy(&r->changed);
    pthread_mutex_destroy(&r->mutex);
    array_free(&r->queue.units);
    array_free(&r->done.message);
    free(r);
    return status;
}
