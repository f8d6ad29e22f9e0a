/* Traces rays with two tracers, and checks only those with different results. */
#include "verify/compare_inner.h"

#include "base/threads.h"

/* Two tracers' t may differ by this many ulps without a check. An ulp is at least that of the world's size,
 * because errors are relative to it. */
#define SCREEN_ULPS 64
/* t_near of these rays, divided by the world's radius. Differences at the surface on which a ray starts are
 * only rounding, which the families test. */
#define SCREEN_NEAR 0x1p-12
/* A thread that has found this many errors stops for the present SCREEN_BATCH rays. */
#define SCREEN_ENOUGH 100
#define SCREEN_BATCH ((size_t)1 << 17)

static bool agree(const ask_answer *a, const ask_answer *b, double size) {
    if (a->met != b->met || !ask_same_primitive(a, b)) return false;
    return a->hit.geometry == FATHOM_NONE ||
           fabs(a->hit.t - b->hit.t) <= SCREEN_ULPS * error_ulp(fmax(b->hit.t, size));
}

/* The world's radius in units of the ray's t. */
static double size_along(const comparison *c, const oracle_ray *ray) {
    return c->subject->source->radius / length_f64(widen(ray->dir));
}

static void start_off_surfaces(const comparison *c, oracle_ray *ray) {
    oracle_ray off = *ray;
    off.t_near = fmaxf(off.t_near, (float)(SCREEN_NEAR * size_along(c, ray)));
    if (rays_allowed(c->subject->source, &off)) *ray = off;
}

static void screen_call(const comparison *c, compare_worker *w, uint64_t first, size_t count) {
    comparison own = *c;
    own.first = first;
    if (!ask_batch_clear(&w->batch, COMPARE_CALL / LANES) ||
        !ask_batch_add(&w->batch, count, TRACE_COHERENT, true, true)) {
        w->failed = true;
        return;
    }
    own.batch = w->batch;
    ask_answer others[COMPARE_CALL];
    compare_make_rays(&own, 0, count);
    for (size_t i = 0; i < count; ++i) start_off_surfaces(c, &own.batch.rays[i]);
    (void)ask_all(c->options->second, &w->batch, 1);
    for (size_t i = 0; i < count; ++i) others[i] = ask_answer_of(&w->batch, i);
    (void)ask_all(c->subject->tracer, &w->batch, 1);
    own.batch = w->batch;
    for (size_t i = 0; i < count && !w->failed; ++i) {
        const ask_answer a = ask_answer_of(&w->batch, i);
        ++w->screened;
        if (agree(&a, &others[i], size_along(c, &own.batch.rays[i]))) continue;
        ++w->unequal;
        for (int any = 0; any < 2; ++any) {
            const ask_other other = {i, COMPARE_FIRST, any != 0, a};
            compare_judge_other(&own, w, &other);
        }
    }
}

static void screen_calls(void *user, size_t begin, size_t end, unsigned index) {
    const comparison *c = user;
    const compare_worker *w = &c->workers[index];
    bool (*const stopped)(void) = c->options->stopped;
    for (size_t at = begin; at < end && !w->failed && w->family.other_counts[VERDICT_WRONG] < SCREEN_ENOUGH &&
                            !(stopped && stopped());
         at += COMPARE_CALL)
        screen_call(c, &c->workers[index], c->first + at, end - at < COMPARE_CALL ? end - at : COMPARE_CALL);
}

/* The first of these families that is enabled. RAYS_SURFACE comes first: half of its rays miss. */
static rays_family screening_family(unsigned families) {
    static const rays_family usual[] = {RAYS_SURFACE, RAYS_UNIFORM, RAYS_CAMERA, RAYS_INTERVAL, RAYS_FAR};
    for (size_t i = 0; i < sizeof usual / sizeof *usual; ++i) {
        if (families >> usual[i] & 1) return usual[i];
    }
    return RAYS_UNIFORM;
}

fathom_status compare_screen(fathom_context *context, comparison *c, uint64_t done, compare_result *out) {
    const compare_options *o = c->options;
    const size_t family_begin = out->failures.count;
    fathom_status status = FATHOM_OK;
    c->family = screening_family(o->families);
    for (uint64_t at = 0; at < o->screened && status == FATHOM_OK; at += SCREEN_BATCH) {
        const uint64_t left = o->screened - at;
        c->first = o->rays + at;
        loop_workers(o->threads, left < SCREEN_BATCH ? left : SCREEN_BATCH, COMPARE_CALL, screen_calls, c);
        status = compare_join_workers(context, c, out, family_begin);
        if (status == FATHOM_OK) status = compare_tell(context, o, done);
    }
    return status;
}
