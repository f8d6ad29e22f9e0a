/* Linear search: every ray against every primitive, in world order, in any precision and form. Robust and in
 * float it is the reference tracer, whose answers define closest hit and any hit. Nothing is culled before
 * the intersectors: no cull could be trusted more than they are. */
#include "trace/search.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct linear_tracer {
    trace_tracer base;
    trace_form form;
} linear_tracer;

static trace_form form_of(const trace_tracer *tracer) { return ((const linear_tracer *)tracer)->form; }

#define REAL float
#define VEC3 vec3_f32
#define FN(name) name##_f32
#define FROM same_f32
#include "trace/linear/linear_text.h"

#define REAL double
#define VEC3 vec3_f64
#define FN(name) name##_f64
#define FROM widen
#include "trace/linear/linear_text.h"

#define REAL real_f128
#define VEC3 vec3_f128
#define FN(name) name##_f128
#define FROM quadruple_f32
#include "trace/linear/linear_text.h"

static void linear_destroy(trace_tracer *tracer) { free(tracer); }

fathom_status linear_create(fathom_context *context, const world *w, const trace_spec *spec,
                            trace_tracer **out) {
    static const struct {
        trace_ops ops;
        double unit;
        const char *name;
    } precisions[] = {
        [TRACE_F32] = {{linear_destroy, linear_closest_f32, linear_any_f32, true, true}, 0x1p-24, "f32"},
        [TRACE_F64] = {{linear_destroy, linear_closest_f64, linear_any_f64, true, true}, 0x1p-53, "f64"},
        [TRACE_F128] = {{linear_destroy, linear_closest_f128, linear_any_f128, true, true}, 0x1p-113, "f128"},
    };
    linear_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = &precisions[spec->precision].ops;
    tracer->base.world = w;
    tracer->base.unit = precisions[spec->precision].unit;
    tracer->base.slow = true;
    tracer->form = spec->form;
    if (spec->form == TRACE_ROBUST && spec->precision == TRACE_F32)
        snprintf(tracer->base.name, sizeof tracer->base.name, "reference");
    else
        snprintf(tracer->base.name, sizeof tracer->base.name, "linear search, %s, %s",
                 spec->form == TRACE_ROBUST ? "robust" : "textbook", precisions[spec->precision].name);
    *out = &tracer->base;
    return FATHOM_OK;
}
