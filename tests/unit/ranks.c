/* A render by several ranks, here threads of one process that hand each other messages, is that of one; and a
 * rank that renders something else is told of. */
#include "film/film.h"

#include "render.h"

#include <pthread.h>

#define RANKS 3

/* ---- messages in memory ---- */

typedef struct letter {
    struct letter *next;
    uint32_t from;
    size_t size;
    char bytes[];
} letter;

typedef struct post post;

typedef struct desk {
    post *all;
    fathom_ranks ranks;
    letter *waiting, **end;
    letter *read; /* until the next call */
} desk;

struct post {
    pthread_mutex_t lock;
    desk desks[RANKS];
};

static bool send_letter(void *user, uint32_t to, const void *bytes, size_t size) {
    const desk *d = user;
    letter *l = malloc(sizeof *l + size);
    if (!l) return false;
    l->next = NULL, l->from = d->ranks.rank, l->size = size;
    memcpy(l->bytes, bytes, size);
    pthread_mutex_lock(&d->all->lock);
    desk *other = &d->all->desks[to];
    *other->end = l;
    other->end = &l->next;
    pthread_mutex_unlock(&d->all->lock);
    return true;
}

static bool receive_letter(void *user, uint32_t *from, const void **bytes, size_t *size) {
    desk *d = user;
    pthread_mutex_lock(&d->all->lock);
    letter *l = d->waiting;
    if (l && !(d->waiting = l->next)) d->end = &d->waiting;
    pthread_mutex_unlock(&d->all->lock);
    if (!l) return false;
    free(d->read);
    d->read = l;
    *from = l->from, *bytes = l->bytes, *size = l->size;
    return true;
}

static void open_post(post *p, uint32_t count) {
    memset(p, 0, sizeof *p);
    pthread_mutex_init(&p->lock, NULL);
    for (uint32_t i = 0; i < count; ++i) {
        desk *d = &p->desks[i];
        d->all = p, d->end = &d->waiting;
        fathom_ranks_default(&d->ranks);
        d->ranks.rank = i, d->ranks.count = count, d->ranks.user = d;
        d->ranks.send = send_letter, d->ranks.receive = receive_letter;
    }
}

static void close_post(post *p) {
    for (uint32_t i = 0; i < RANKS; ++i) {
        desk *d = &p->desks[i];
        free(d->read);
        for (letter *l = d->waiting, *next; l; l = next) next = l->next, free(l);
    }
    pthread_mutex_destroy(&p->lock);
}

/* ---- a rank ---- */

typedef struct rank {
    stage s;
    const fathom_ranks *ranks;
    fathom_stats stats;
    fathom_film *film;
    fathom_status status;
    pthread_t thread;
} rank;

static void make_scene(stage *s) {
    static const double eye[3] = {0, 1, 4}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0}, center[3] = {0, -1, 0},
                        u[3] = {3, 0, 0}, v[3] = {0, 0, -3};
    *s = stage_open(170, 100);
    stage_camera(s, eye, target, up, 0.8);
    stage_sphere(s, 0, 0, 0, 0.8, stage_lambert(s, 0.5f));
    stage_quad(s, center, u, v, stage_lambert(s, 0.7f));
    stage_point_light(s, 2, 4, 3, 20);
    s->settings.pattern = FATHOM_PATTERN_SOBOL;
    s->settings.spp = 16;
    s->settings.aovs = FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
}

static void *run_rank(void *user) {
    rank *r = user;
    fathom_session_options options = default_session_options();
    options.ranks = r->ranks;
    fathom_context_set_threads(r->s.context, 1 + r->ranks->rank % 2);
    r->stats.size = sizeof r->stats;
    r->status = fathom_session_run(r->s.context, r->s.scene, &r->s.settings, &options, &r->stats, &r->film);
    return NULL;
}

typedef void (*change_fn)(uint32_t place, stage *s);

static void run_all(post *p, rank ranks[RANKS], uint32_t count, change_fn change) {
    open_post(p, count);
    for (uint32_t i = 0; i < count; ++i) {
        ranks[i] = (rank){.ranks = &p->desks[i].ranks};
        make_scene(&ranks[i].s);
        if (change) change(i, &ranks[i].s);
    }
    for (uint32_t i = 0; i < count; ++i)
        assert_int_equal(pthread_create(&ranks[i].thread, NULL, run_rank, &ranks[i]), 0);
    for (uint32_t i = 0; i < count; ++i) pthread_join(ranks[i].thread, NULL);
    close_post(p);
}

static void close_all(rank ranks[RANKS], uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) fathom_film_destroy(ranks[i].film);
}

static void assert_ranks_make_the_whole(change_fn change) {
    stage s;
    post p;
    rank ranks[RANKS];
    make_scene(&s);
    if (change) change(0, &s);
    fathom_film *whole = stage_render(&s);
    for (uint32_t count = 1; count <= RANKS; ++count) {
        run_all(&p, ranks, count, change);
        for (uint32_t i = 0; i < count; ++i) assert_int_equal(ranks[i].status, FATHOM_OK);
        const size_t bytes = (size_t)whole->width * whole->height * sizeof(float);
        for (uint32_t i = 0; i < whole->channel_count; ++i)
            assert_memory_equal(whole->channels[i].data, ranks[0].film->channels[i].data, bytes);
        assert_int_equal(ranks[0].stats.samples, whole->stats.samples);
        assert_int_equal(ranks[0].stats.camera_rays, whole->stats.camera_rays);
        assert_int_equal(ranks[0].stats.shadow_rays, whole->stats.shadow_rays);
        assert_true(ranks[0].stats.error_estimate == whole->stats.error_estimate);
        close_all(ranks, count);
    }
}

UNIT_TEST(ranks_make_the_whole) { assert_ranks_make_the_whole(NULL); }

static void to_an_error(uint32_t place, stage *s) {
    (void)place;
    s->settings.target_error = 0.03;
    s->settings.crop[0] = 7, s->settings.crop[1] = 9, s->settings.crop[2] = 140, s->settings.crop[3] = 71;
}

UNIT_TEST(ranks_to_an_error_make_the_whole) { assert_ranks_make_the_whole(to_an_error); }

static void another_seed(uint32_t place, stage *s) { s->settings.seed = place == 1 ? 5 : 0; }

/* Rank 1 alone: with a third, others would wait for work for ever, until what started them ends them. */
UNIT_TEST(another_render_is_told_of) {
    post p;
    rank ranks[RANKS];
    open_post(&p, 2);
    for (uint32_t i = 0; i < 2; ++i) {
        ranks[i] = (rank){.ranks = &p.desks[i].ranks};
        make_scene(&ranks[i].s);
        another_seed(i, &ranks[i].s);
    }
    /* Rank 1 has sent who it is and what it wants, and is told that there is no more. */
    const struct { uint32_t kind, count; } none = {3, 0};
    send_letter(&p.desks[0], 1, &none, sizeof none);
    run_rank(&ranks[1]);
    assert_int_equal(ranks[1].status, FATHOM_OK);
    run_rank(&ranks[0]);
    assert_fails(ranks[0].s.context, ranks[0].status, FATHOM_BAD_INPUT,
                 "rank 1 renders with --seed 5, and rank 0 with 0");
    assert_null(ranks[0].film);
    close_all(ranks, 2);
    close_post(&p);
}

static void at_once(uint32_t place, stage *s) {
    (void)place;
    s->settings.max_time = 1;
}

UNIT_TEST(a_time_is_refused) {
    post p;
    rank ranks[RANKS];
    run_all(&p, ranks, 1, at_once);
    assert_fails(ranks[0].s.context, ranks[0].status, FATHOM_BAD_USAGE,
                 "a render to a time is one process's work");
    close_all(ranks, 1);
}

int main(void) { return unit_main(NULL, NULL); }
