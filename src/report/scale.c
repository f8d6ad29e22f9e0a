#include "report/scale.h"

#include <math.h>

static const double steps[4] = {1, 2, 5, 10};

/* The largest 1, 2 or 5 times a power of ten at or below x, or the smallest at or above. */
static double round_down(double x) {
    double power = pow(10, floor(log10(x) + 1e-12));
    int i = 3;
    while (i > 0 && steps[i] * power > x * (1 + 1e-12)) --i;
    return steps[i] * power;
}
static double round_up(double x) {
    double power = pow(10, floor(log10(x) + 1e-12));
    int i = 0;
    while (i < 3 && steps[i] * power < x * (1 - 1e-12)) ++i;
    return steps[i] * power;
}

/* Between the ticks of a linear axis with at most `most` of them. */
static double linear_step(double width, size_t most) { return round_up(width / (double)(most - 1)); }

scale scale_over(bool log, double least, double most, double from, double to) {
    scale s = {log, least, most, from, to, from};
    if (log) {
        s.low = round_down(least), s.high = round_up(most);
        if (!(s.high > s.low)) s.low /= 2, s.high *= 2;
        s.low = round_down(s.low), s.high = round_up(s.high);
        return s;
    }
    if (!(most > least)) s.low -= 1, s.high += 1;
    double step = linear_step(s.high - s.low, 6);
    s.low = step * floor(s.low / step + 1e-9), s.high = step * ceil(s.high / step - 1e-9);
    return s;
}

double scale_at(const scale *s, double x) {
    if (s->log && !(x > 0)) return s->zero;
    double place = s->log ? log(x / s->low) / log(s->high / s->low) : (x - s->low) / (s->high - s->low);
    return s->from + (s->to - s->from) * fmin(1, fmax(0, place));
}

/* Every nth power of ten. */
static size_t powers(const scale *s, int nth, double out[SCALE_TICKS]) {
    int first = (int)ceil(log10(s->low) - 1e-9), last = (int)floor(log10(s->high) + 1e-9);
    size_t count = 0;
    for (int e = first; e <= last; ++e) {
        /* Multiples of n, so that axes beside each other agree. */
        if (e % nth == 0 && count < SCALE_TICKS) out[count++] = pow(10, e);
    }
    return count;
}

/* 1, 2 and 5 times powers of ten. */
static size_t fifths(const scale *s, double out[SCALE_TICKS]) {
    size_t count = 0;
    for (double x = round_up(s->low); x <= s->high * (1 + 1e-9) && count < SCALE_TICKS; x = round_up(x * 1.5))
        out[count++] = x;
    return count;
}

static size_t log_ticks(const scale *s, size_t most, double out[SCALE_TICKS]) {
    double decades = log10(s->high / s->low);
    if (decades < 2.5) {
        size_t count = fifths(s, out);
        if (count <= most) return count;
    }
    for (int nth = 1;; ++nth) {
        if (decades / nth + 1 > (double)most) continue;
        size_t count = powers(s, nth, out);
        if (count >= 2) return count;
        out[0] = s->low, out[1] = s->high;
        return 2;
    }
}

size_t scale_ticks(const scale *s, size_t most, double out[SCALE_TICKS]) {
    if (most > SCALE_TICKS) most = SCALE_TICKS;
    if (s->log) return log_ticks(s, most, out);
    double step = linear_step(s->high - s->low, most);
    size_t count = 0;
    for (double i = ceil(s->low / step - 1e-9); i * step <= s->high + 1e-9 * step; ++i)
        out[count++] = i * step;
    return count;
}
