#include "verify/extremes/case.h"

#include "scene/scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void *case_memory(extremes_case *c, size_t bytes) {
    /* Embree reads vertices 16 bytes at a time. */
    void *memory = c->status == FATHOM_OK ? calloc(1, bytes + 16) : NULL;
    if (memory && array_push(&c->owned, memory)) return memory;
    free(memory);
    if (c->status == FATHOM_OK) c->status = fail_memory(c->context, bytes);
    return NULL;
}

void case_say(extremes_case *c, const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(c->words, sizeof c->words, format, list);
    va_end(list);
}

static fathom_status open_all(extremes_case *c) {
    if (c->status == FATHOM_OK) c->status = fathom_scene_complete(c->scene);
    if (c->status == FATHOM_OK) c->status = fathom_scene_check(c->scene);
    if (c->status == FATHOM_OK) c->status = world_create(c->scene, &c->world);
    if (c->status == FATHOM_OK && c->patch) {
        c->patch(c);
        c->status = world_survey(c->world);
    }
    if (c->status == FATHOM_OK) c->status = search_create(c->context, c->world, &c->search);
    if (c->status == FATHOM_OK) c->status = rays_create(c->context, c->world, &c->source);
    if (c->status == FATHOM_OK && c->maker) rays_set_maker(c->source, c->maker, c);
    return c->status;
}

fathom_status case_open(fathom_context *context, void (*make)(extremes_case *c, double parameter),
                        double parameter, extremes_case *out) {
    memset(out, 0, sizeof *out);
    out->context = context, out->families = CASE_FAMILIES;
    out->status = fathom_scene_create(context, &out->scene);
    if (out->status == FATHOM_OK) make(out, parameter);
    return open_all(out);
}

void case_close(extremes_case *c) {
    rays_destroy(c->source);
    search_destroy(c->search);
    world_destroy(c->world);
    fathom_scene_destroy(c->scene);
    for (size_t i = 0; i < c->owned.count; ++i) free(c->owned.items[i]);
    array_free(&c->owned);
    memset(c, 0, sizeof *c);
}
