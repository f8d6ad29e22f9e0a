#include "verify/laws/laws.h"

#include <math.h>

/* The continued fraction of the incomplete beta function (DLMF 8.17.22), by Lentz's method. It converges in
 * about sqrt(max(a, b)) steps. */
static double beta_fraction(double a, double b, double x) {
    const double tiny = 1e-300;
    double c = 1, d = 1 - (a + b) * x / (a + 1);
    d = 1 / (fabs(d) < tiny ? tiny : d);
    double product = d;
    for (int m = 1; m < 4096; ++m) {
        const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
        const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        const double before = product;
        for (int k = 0; k < 2; ++k) {
            const double term = k ? odd : even;
            d = 1 + term * d, c = 1 + term / c;
            d = 1 / (fabs(d) < tiny ? tiny : d), c = fabs(c) < tiny ? tiny : c;
            product *= c * d;
        }
        if (fabs(product - before) <= 1e-15 * fabs(product)) break;
    }
    return product;
}

/* I_x(a, b). */
static double incomplete_beta(double a, double b, double x) {
    if (!(x > 0)) return 0;
    if (x >= 1) return 1;
    const double front = exp(lgamma(a + b) - lgamma(a) - lgamma(b) + a * log(x) + b * log1p(-x));
    if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
    return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

/* Above 1e6 degrees of freedom it uses the normal distribution, with a relative error of 1e-5 at 6 standard
 * errors. */
double student_p(double t, double freedom) {
    if (isinf(t)) return 0;
    if (freedom > 1e6) return erfc(fabs(t) / sqrt(2));
    return incomplete_beta(freedom / 2, 0.5, freedom / (freedom + t * t));
}

double sidak(double p, double n) { return p >= 1 ? 1 : -expm1(n * log1p(-p)); }

double sidak_level(double level, double n) { return -expm1(log1p(-level) / n); }

static double difference_p(double difference, double error, double freedom, double allowance) {
    const double beyond = fabs(difference) - allowance;
    if (!isfinite(difference) || !isfinite(error)) return 0;
    if (!(beyond > 0)) return 1;
    return error > 0 ? student_p(beyond / error, freedom) : 0;
}

double mean_p(sample_mean a, double value, double allowance) {
    return difference_p(a.mean - value, a.error, a.freedom, allowance);
}

double welch_p(sample_mean a, sample_mean b, double missed, double allowance) {
    const double x = a.error * a.error, y = b.error * b.error, sum = x + y + missed;
    const double freedom = sum * sum / (x * x / a.freedom + y * y / b.freedom);
    return difference_p(a.mean - b.mean, sqrt(sum), freedom, allowance);
}
