/* Plans of images of stages. */
#pragma once

#include "integrate/plan.h"
#include "render.h"
#include "worlds.h"

/* Plans an image of 256 × 256 pixels and 64 samples, looks at the plan, and releases it. */
static inline void look_at_plan(stage s, double expected, void (*look)(const render_plan *, double)) {
    const trace_options options = {.timed = true, .threads = 2, .expected_rays = 1000000};
    trace_tracer *tracer;
    render_plan *plan;
    s.settings.width = s.settings.height = 256, s.settings.spp = 64;
    world *w = new_world(s.scene);
    assert_ok(s.context, trace_create(s.context, w, &options, &tracer));
    assert_ok(s.context, plan_create(s.context, w, tracer, &s.settings, NULL, NULL, &plan));
    look(plan, expected);
    plan_destroy(plan);
    trace_destroy(tracer);
}
