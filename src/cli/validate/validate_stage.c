#include "cli/validate/validate.h"

#include "verify/builtin.h"

#include <stdio.h>
#include <string.h>

static fathom_status open_scene(fathom_context *context, const char *name, fathom_scene **out) {
    for (unsigned i = 0; builtin_name(i); ++i) {
        if (strcmp(name, builtin_name(i)) == 0) return builtin_create(context, i, out);
    }
    return fathom_scene_read(context, name, out);
}

static fathom_status open_extreme(fathom_context *context, const char *name, validate_stage *out) {
    char group[64];
    double number;
    if (sscanf(name, "%63[^:]:%lf", group, &number) != 2)
        return fail(context, FATHOM_BAD_INPUT,
                    "%s%.80s: expected a group of extreme cases, a colon and a number", VALIDATE_EXTREME,
                    name);
    fathom_status status = extremes_open(context, group, number, &out->extreme);
    if (status != FATHOM_OK) return status;
    out->world = extremes_world(out->extreme), out->search = extremes_search(out->extreme);
    out->source = extremes_source(out->extreme);
    return FATHOM_OK;
}

fathom_status validate_stage_open(fathom_context *context, const char *name, validate_stage *out) {
    memset(out, 0, sizeof *out);
    size_t prefix = strlen(VALIDATE_EXTREME);
    if (strncmp(name, VALIDATE_EXTREME, prefix) == 0) return open_extreme(context, name + prefix, out);
    fathom_status status = open_scene(context, name, &out->scene);
    if (status == FATHOM_OK) status = world_create(out->scene, &out->world);
    if (status == FATHOM_OK) status = search_create(context, out->world, &out->search);
    if (status == FATHOM_OK) status = rays_create(context, out->world, &out->source);
    return status;
}

void validate_stage_close(validate_stage *stage) {
    if (stage->extreme) {
        extremes_close(stage->extreme);
        memset(stage, 0, sizeof *stage);
        return;
    }
    rays_destroy(stage->source);
    search_destroy(stage->search);
    world_destroy(stage->world);
    fathom_scene_destroy(stage->scene);
    memset(stage, 0, sizeof *stage);
}

fathom_status validate_subject(fathom_context *context, const validate_stage *stage, const char *text,
                               compare_subject *out, trace_tracer **tracer) {
    trace_spec spec;
    *tracer = NULL;
    fathom_status status = trace_spec_parse(context, text, &spec);
    if (status != FATHOM_OK) return status;
    trace_options options = {.spec = &spec, .width = LANES};
    status = trace_create(context, stage->world, &options, tracer);
    if (status != FATHOM_OK) return status;
    *out = (compare_subject){stage->world, stage->search, stage->source, *tracer,
                             verdict_tracer_of(&spec, trace_unit(*tracer))};
    return FATHOM_OK;
}
