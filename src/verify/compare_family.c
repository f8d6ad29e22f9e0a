#include "verify/compare_family.h"

static void keep_most(compare_most *most, double value, uint64_t index, const oracle_ray *ray) {
    if (value > most->value || (value == most->value && value > 0 && index < most->index))
        *most = (compare_most){value, index, *ray};
}

static void add_error(compare_error *e, double value, uint64_t index, const oracle_ray *ray) {
    histogram_add(&e->counts, value);
    keep_most(&e->most, value, index, ray);
}

/* Errors are clamped to 1024 units, because larger ones are no better evidence of a bias. */
static void add_bias(compare_bias *b, double signed_units) {
    int64_t steps = (int64_t)(fmax(-1024, fmin(1024, signed_units)) * 1024);
    b->sum += steps, b->squares += (uint64_t)(steps * steps), ++b->count;
}

void compare_family_measure(compare_family *f, const oracle_ray *ray, uint64_t index,
                            const verdict_report *report, const error_report *errors, double unit,
                            double radius) {
    const double t = fabs(report->exact_t);
    double relative = report->t_error * length_f64(widen(ray->dir)) / radius;
    add_error(&f->errors[COMPARE_T_ULPS], report->t_error / error_ulp(report->exact_t), index, ray);
    add_error(&f->errors[COMPARE_T_RELATIVE], relative, index, ray);
    add_error(&f->errors[COMPARE_POSITION], errors->position, index, ray);
    add_error(&f->errors[COMPARE_NORMAL], errors->normal, index, ray);
    if (errors->uv >= 0) add_error(&f->errors[COMPARE_UV], errors->uv, index, ray);
    if (t > 0 && isfinite(report->bound)) keep_most(&f->widest, report->bound / (unit * t), index, ray);
    if (!(report->condition > 0)) return;
    if (!(report->bound <= COMPARE_SHAPED * unit * report->condition)) return;
    double constant = report->t_error / (unit * report->condition);
    keep_most(&f->constant, constant, index, ray);
    histogram_add(&f->constants, constant);
    if (report->condition <= COMPARE_WELL * t) add_bias(&f->bias, report->t_signed / (unit * t));
}

void compare_family_join(compare_family *to, const compare_family *from) {
    to->rays += from->rays, to->any_rays += from->any_rays, to->others += from->others;
    to->repaired += from->repaired;
    for (int i = 0; i < VERDICT_COUNT; ++i) {
        to->counts[i] += from->counts[i];
        to->any_counts[i] += from->any_counts[i];
        to->other_counts[i] += from->other_counts[i];
    }
    for (int i = 0; i < COMPARE_MEASURES; ++i) {
        const compare_error *e = &from->errors[i];
        histogram_join(&to->errors[i].counts, &e->counts);
        keep_most(&to->errors[i].most, e->most.value, e->most.index, &e->most.ray);
    }
    histogram_join(&to->constants, &from->constants);
    keep_most(&to->constant, from->constant.value, from->constant.index, &from->constant.ray);
    keep_most(&to->widest, from->widest.value, from->widest.index, &from->widest.ray);
    to->bias.sum += from->bias.sum, to->bias.squares += from->bias.squares,
        to->bias.count += from->bias.count;
}
