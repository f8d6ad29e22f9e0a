#include "report/validate_parts.h"

#include <math.h>
#include <string.h>

double number_at(const json_t *object, const char *key) {
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

uint64_t count_at(const json_t *object, const char *key) {
    json_int_t value = json_integer_value(json_object_get(object, key));
    return value > 0 ? (uint64_t)value : 0;
}

const char *text_at(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

uint64_t verdicts_of(const json_t *run, const char *verdict, bool any) {
    const json_t *whole = any ? json_object_get(run, "any") : NULL;
    if (whole) return count_at(json_object_get(whole, "verdicts"), verdict);
    uint64_t sum = 0;
    size_t i;
    json_t *family;
    json_array_foreach(json_object_get(run, "families"), i, family) {
        const json_t *from = any ? json_object_get(family, "any") : family;
        sum += count_at(json_object_get(from, "verdicts"), verdict);
    }
    return sum;
}

uint64_t case_verdicts(const json_t *item, const char *verdict) {
    const json_t *any = json_object_get(item, "any");
    return count_at(json_object_get(item, "verdicts"), verdict) +
           count_at(json_object_get(any, "verdicts"), verdict);
}

uint64_t rays_of(const json_t *run) {
    uint64_t sum = 0;
    size_t i;
    json_t *family;
    json_array_foreach(json_object_get(run, "families"), i, family) sum += count_at(family, "rays");
    return sum;
}

bool same_tracer(const json_t *runs, size_t i, size_t k) {
    return strcmp(text_at(json_array_get(runs, i), "spec"), text_at(json_array_get(runs, k), "spec")) == 0;
}

/* ---- errors ---- */

void spread_add(spread *s, const json_t *error) {
    double most = number_at(json_object_get(error, "max"), "value");
    if (most > s->most) s->most = most;
    const json_t *h = json_object_get(error, "histogram"), *bins = json_object_get(h, "bins");
    if (!h) return;
    s->first = (int)json_integer_value(json_object_get(h, "first"));
    s->per_octave = (unsigned)count_at(h, "perOctave");
    s->zeros += count_at(h, "zeros"), s->total += count_at(h, "zeros");
    for (size_t i = 0; i < json_array_size(bins) && i < SPREAD_BINS; ++i) {
        uint64_t count = (uint64_t)json_integer_value(json_array_get(bins, i));
        s->bins[i] += count, s->total += count;
    }
}

double spread_quantile(const spread *s, double q) {
    if (!s->total) return (double)NAN;
    double wanted = q * (double)s->total, below = (double)s->zeros;
    if (below >= wanted) return 0;
    size_t i = 0;
    while (i + 1 < SPREAD_BINS && (below += (double)s->bins[i]) < wanted) ++i;
    /* The end of a bin may be past the largest value in it. */
    return fmin(s->most, exp2((double)(i + 1) / s->per_octave + s->first));
}

static unsigned kind_of(const char *spec) {
    if (strncmp(spec, "embree", 6) == 0) return 0;
    if (strncmp(spec, "bvh", 3) == 0) return 1;
    if (strncmp(spec, "linear", 6) == 0 || strncmp(spec, "reference", 9) == 0) return 2;
    return 3;
}

static void add_run(tracer_sum *sum, const json_t *run) {
    double rays = (double)rays_of(run);
    sum->nanoseconds =
        (sum->nanoseconds * sum->rays + number_at(run, "nsPerRay") * rays) / (sum->rays + rays);
    sum->rays += rays;
    size_t i;
    json_t *family;
    json_array_foreach(json_object_get(run, "families"), i, family) {
        const char *name = text_at(family, "family");
        bool ordinary = strcmp(name, "camera") == 0 || strcmp(name, "uniform") == 0;
        const json_t *error = json_object_get(family, "tUlps");
        spread_add(ordinary ? &sum->ordinary : &sum->hard, error);
        spread_add(&sum->all, error);
    }
}

static tracer_sum *sum_of(tracer_sums *sums, const json_t *run) {
    const char *spec = text_at(run, "spec");
    for (size_t i = 0; i < sums->count; ++i) {
        if (strcmp(sums->items[i].spec, spec) == 0) return &sums->items[i];
    }
    if (!array_room(sums, 1)) return NULL;
    tracer_sum *sum = &sums->items[sums->count++];
    memset(sum, 0, sizeof *sum);
    sum->spec = spec, sum->tracer = text_at(run, "tracer"), sum->kind = kind_of(spec);
    return sum;
}

bool tracer_sums_of(const json_t *results, tracer_sums *out) {
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(results, "runs"), i, run) {
        tracer_sum *sum = sum_of(out, run);
        if (!sum) return false;
        if (rays_of(run)) add_run(sum, run);
    }
    return true;
}

void put_absent(page *p, const char *sentence) {
    page_put(p, "<p class=\"absent\">");
    page_text(p, sentence);
    page_put(p, "</p>\n");
}
