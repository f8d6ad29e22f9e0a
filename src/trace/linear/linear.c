/* Linear search: every ray against every primitive, in world order, in any precision. In float it is the
 * reference tracer, whose results define closest hit and any hit. It culls nothing before the intersectors,
 * because a cull would not be more reliable than they are. */
#include "trace/search.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    trace_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->ops = &precisions[spec->precision].ops;
    tracer->world = w;
    tracer->unit = precisions[spec->precision].unit;
    tracer->slow = true;
    if (spec->precision == TRACE_F32)
        snprintf(tracer->name, sizeof tracer->name, "reference");
    else
        snprintf(tracer->name, sizeof tracer->name, "linear search, %s", precisions[spec->precision].name);
    *out = tracer;
    return FATHOM_OK;
}
