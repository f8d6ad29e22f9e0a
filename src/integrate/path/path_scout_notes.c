/* Notes the light that the light samples of paths bring. */
#include "integrate/path/path_scout_inner.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- before the shadow rays ---- */

static double sum_of(const lanes3 v, unsigned i) {
    return (double)v[0][i] + (double)v[1][i] + (double)v[2][i];
}

static bool add_ray(scout_report *r, const emitter_query *from, const emitter_sample *light, unsigned i) {
    const sky_ray ray = {
        .p = lane_f32(from->p, i), .n = lane_f32(from->n, i), .direction = lane_f32(light->direction, i)};
    return array_push(&r->rays, ray);
}

static bool add_glance(scout_report *r, const emitter_query *from, const emitter_sample *light, unsigned i) {
    emitter_glance glance = {
        .density = light->density[i], .seen = -1, .part = light->part[i], .emitter = light->emitter[i]};
    for (int c = 0; c < 3; ++c) {
        glance.at[c] = from->p[c][i], glance.at[3 + c] = from->n[c][i];
        glance.direction[c] = light->direction[c][i];
    }
    return array_push(&r->glances, glance);
}

void path_scout_asks(path_scout *s, const vertex_block *v, const emitter_query *from,
                     const emitter_sample *light, const lanes3 gain) {
    scout_report *r = &s->report;
    for (unsigned i = 0; i < v->surface.count && !s->fails; ++i) {
        scout_question q = {.slot = v->path.slot[i], .glance = FATHOM_NONE};
        q.possible = sum_of(gain, i), q.weight = sum_of(v->path.weight, i);
        if (s->glances && light->part[i] < EMITTER_PARTS && q.weight > 0) {
            q.glance = (uint32_t)r->glances.count;
            s->fails |= !add_glance(r, from, light, i);
        }
        if (!(light->density[i] > 0 && q.possible > 0 && isfinite(q.possible))) continue;
        q.part = light->part[i];
        if (q.part == EMITTER_OUTSIDE) s->fails |= !add_ray(r, from, light, i);
        s->questions[s->count++] = q;
    }
}

static double light_of(const wave *w, uint32_t slot) {
    float *const *rgb = w->run.samples.radiance;
    return (double)rgb[0][slot] + (double)rgb[1][slot] + (double)rgb[2][slot];
}

void path_scout_waits(path_scout *s, const wave *w) {
    for (size_t k = 0; k < s->count; ++k) s->questions[k].before = light_of(w, s->questions[k].slot);
}

/* ---- after them ---- */

void path_scout_sees(path_scout *s, const wave *w) {
    scout_report *r = &s->report;
    for (size_t k = 0; k < s->count && !s->fails; ++k) {
        const scout_question *q = &s->questions[k];
        const double seen = fmin(fmax((light_of(w, q->slot) - q->before) / q->possible, 0), 1),
                     light = seen * q->possible;
        scout_sum *sum = &r->sums[q->part];
        ++sum->asked, sum->seen += seen, sum->light += light;
        if (q->part == EMITTER_OUTSIDE) r->rays.items[s->answered++].seen = (float)seen;
        if (q->glance == FATHOM_NONE) continue;
        emitter_glance *glance = &r->glances.items[q->glance];
        glance->light = (float)(light / q->weight), glance->seen = (float)seen;
    }
    s->count = 0;
}

/* ---- all of them ---- */

static void append(void *to, size_t *count, void *from, size_t more, size_t size) {
    if (more) memcpy((char *)to + *count * size, from, more * size);
    *count += more;
    free(from);
}

bool scout_collect(scout_report *reports, uint32_t count) {
    scout_report *to = &reports[0];
    size_t rays = 0, glances = 0;
    for (uint32_t b = 1; b < count; ++b) rays += reports[b].rays.count, glances += reports[b].glances.count;
    if (!array_room(&to->rays, rays) || !array_room(&to->glances, glances)) return false;
    for (uint32_t b = 1; b < count; ++b) {
        scout_report *from = &reports[b];
        append(to->rays.items, &to->rays.count, from->rays.items, from->rays.count, sizeof *to->rays.items);
        append(to->glances.items, &to->glances.count, from->glances.items, from->glances.count,
               sizeof *to->glances.items);
        from->rays.items = NULL, from->glances.items = NULL;
    }
    return true;
}
