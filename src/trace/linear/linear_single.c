/* Linear search ray by ray, in any precision and form: every ray against every primitive, in world order. The
 * form that renders, robust and in float, has blocks of its own in linear.c. */
#include "trace/search.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct single_tracer {
    trace_tracer base;
    trace_form form;
} single_tracer;

#define REAL float
#define FN(name) name##_f32
#include "trace/linear/linear_single_text.h"

#define REAL double
#define FN(name) name##_f64
#include "trace/linear/linear_single_text.h"

#define REAL real_f128
#define FN(name) name##_f128
#include "trace/linear/linear_single_text.h"

static void single_destroy(trace_tracer *tracer) { free(tracer); }

fathom_status linear_single_create(fathom_context *context, const world *w, const trace_spec *spec,
                                   trace_tracer **out) {
    static const struct {
        trace_ops ops;
        double unit;
        const char *name;
    } precisions[] = {
        [TRACE_F32] = {{single_destroy, single_closest_f32, single_any_f32, true, true}, 0x1p-24, "f32"},
        [TRACE_F64] = {{single_destroy, single_closest_f64, single_any_f64, true, true}, 0x1p-53, "f64"},
        [TRACE_F128] = {{single_destroy, single_closest_f128, single_any_f128, true, true}, 0x1p-113, "f128"},
    };
    single_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = &precisions[spec->precision].ops;
    tracer->base.world = w;
    tracer->base.unit = precisions[spec->precision].unit;
    tracer->base.slow = true;
    tracer->form = spec->form;
    snprintf(tracer->base.name, sizeof tracer->base.name, "linear search, %s, %s",
             spec->form == TRACE_ROBUST ? "robust" : "textbook", precisions[spec->precision].name);
    *out = &tracer->base;
    return FATHOM_OK;
}
