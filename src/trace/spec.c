#include "trace/spec.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

/* ---- the words ---- */

#define LINEAR (1u << TRACE_LINEAR)
#define BVH (1u << TRACE_BVH)
#define EMBREE (1u << TRACE_EMBREE)

typedef struct word {
    const char *text;
    size_t field; /* offset in trace_spec; options with the same field exclude each other */
    unsigned value;
    unsigned kinds;
} word;

#define FIELD(name) offsetof(trace_spec, name)

static const word words[] = {
    {"f32", FIELD(precision), TRACE_F32, LINEAR | BVH},
    {"f64", FIELD(precision), TRACE_F64, LINEAR | BVH},
    {"f128", FIELD(precision), TRACE_F128, LINEAR | BVH},
    {"triangles", FIELD(shapes), TRACE_SHAPES_TRIANGLES, EMBREE},
    {"user", FIELD(shapes), TRACE_SHAPES_USER, EMBREE},
    {"robust", FIELD(flags), TRACE_SCENE_ROBUST, EMBREE},
    {"default", FIELD(flags), TRACE_SCENE_DEFAULT, EMBREE},
    {"compact", FIELD(flags), TRACE_SCENE_COMPACT, EMBREE},
    {"auto", FIELD(quality), TRACE_QUALITY_AUTO, EMBREE},
    {"low", FIELD(quality), TRACE_QUALITY_LOW, EMBREE},
    {"medium", FIELD(quality), TRACE_QUALITY_MEDIUM, EMBREE},
    {"high", FIELD(quality), TRACE_QUALITY_HIGH, EMBREE},
    {"1", FIELD(calls), TRACE_CALLS_1, EMBREE},
    {"4", FIELD(calls), TRACE_CALLS_4, EMBREE},
    {"8", FIELD(calls), TRACE_CALLS_8, EMBREE},
    {"16", FIELD(calls), TRACE_CALLS_16, EMBREE},
    {"settled", FIELD(ties), TRACE_SETTLED, EMBREE},
    {"raw", FIELD(ties), TRACE_RAW, EMBREE},
    {"sse2", FIELD(isa), ISA_SSE2, EMBREE},
    {"sse4.2", FIELD(isa), ISA_SSE42, EMBREE},
    {"avx", FIELD(isa), ISA_AVX, EMBREE},
    {"avx2", FIELD(isa), ISA_AVX2, EMBREE},
    {"avx512", FIELD(isa), ISA_AVX512, EMBREE},
};
#define WORDS (sizeof words / sizeof *words)

static const struct {
    const char *text;
    trace_kind kind;
} kinds[] = {
    {"linear", TRACE_LINEAR}, {"bvh", TRACE_BVH}, {"embree", TRACE_EMBREE}, {"reference", TRACE_LINEAR}};
#define KINDS (sizeof kinds / sizeof *kinds)

_Static_assert(sizeof(trace_precision) == sizeof(unsigned) && sizeof(isa_set) == sizeof(unsigned),
               "fields are written as numbers");

/* ---- from text ---- */

typedef struct reader {
    fathom_context *context;
    const char *text;
    unsigned kinds; /* the bit of its kind */
    trace_spec *out;
    const word *given[WORDS];
    size_t count; /* of words given */
} reader;

/* "robust, default, compact; low, medium": the options of a kind. */
static void list_options(unsigned bit, char *out, size_t size) {
    size_t used = 0;
    const word *last = NULL;
    out[0] = '\0';
    for (size_t i = 0; i < WORDS && used < size; ++i) {
        if (!(words[i].kinds & bit)) continue;
        const char *between = !last ? "" : (last->field == words[i].field ? ", " : "; ");
        used += (size_t)snprintf(out + used, size - used, "%s%s", between, words[i].text);
        last = &words[i];
    }
}

static fathom_status unknown_kind(const reader *r, size_t length) {
    char options[3][200];
    for (int i = 0; i < 3; ++i) list_options(1u << kinds[i].kind, options[i], sizeof options[i]);
    return fail(r->context, FATHOM_BAD_USAGE,
                "no tracer is called \"%.*s\"; expected reference, a shared library FILE.so, linear (options "
                "%s), bvh (%s) or embree (%s), such as embree:user:high",
                (int)(length < 99 ? length : 99), r->text, options[0], options[1], options[2]);
}

static fathom_status read_option(reader *r, const char *text, size_t length) {
    const word *found = NULL;
    for (size_t i = 0; i < WORDS && !found; ++i) {
        const word *w = &words[i];
        if (w->kinds & r->kinds && strlen(w->text) == length && strncmp(w->text, text, length) == 0)
            found = w;
    }
    if (!found) {
        char options[200];
        list_options(r->kinds, options, sizeof options);
        return fail(r->context, FATHOM_BAD_USAGE,
                    "tracers of this kind have no option \"%.*s\"; expected %s, found \"%.99s\"",
                    (int)(length < 40 ? length : 40), text, options, r->text);
    }
    for (size_t i = 0; i < r->count; ++i) {
        if (r->given[i]->field != found->field) continue;
        const bool flags = found->field == FIELD(flags);
        return fail(r->context, FATHOM_BAD_USAGE,
                    "options \"%s\" and \"%s\" exclude each other%s, found \"%.99s\"", r->given[i]->text,
                    found->text, flags ? ": with both, some of Embree's kernels never return" : "", r->text);
    }
    r->given[r->count++] = found;
    memcpy((char *)r->out + found->field, &found->value, sizeof found->value);
    return FATHOM_OK;
}

fathom_status trace_spec_parse(fathom_context *context, const char *text, trace_spec *out) {
    if (!text) text = "embree";
    *out = (trace_spec){.kind = TRACE_PLUGIN, .path = text};
    size_t length = strlen(text);
    if (length > 3 && strcmp(text + length - 3, ".so") == 0) return FATHOM_OK;
    reader r = {.context = context, .text = text, .out = out};
    length = strcspn(text, ":");
    for (size_t i = 0; i < KINDS && !r.kinds; ++i) {
        if (strlen(kinds[i].text) != length || strncmp(kinds[i].text, text, length) != 0) continue;
        *out = (trace_spec){.kind = kinds[i].kind};
        r.kinds = 1u << kinds[i].kind;
    }
    if (!r.kinds) return unknown_kind(&r, length);
    for (const char *at = text + length; *at; at += length) {
        ++at;
        length = strcspn(at, ":");
        fathom_status status = read_option(&r, at, length);
        if (status != FATHOM_OK) return status;
    }
    return FATHOM_OK;
}
