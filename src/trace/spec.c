#include "trace/spec.h"

#include <stdio.h>
#include <string.h>

/* ---- the words ---- */

/* Sorts of options: one field of trace_spec each. */
typedef enum sort {
    SORT_FORM,
    SORT_PRECISION,
    SORT_SHAPES,
    SORT_FLAGS,
    SORT_QUALITY,
    SORT_CALLS,
    SORT_TIES,
    SORT_ISA,
    SORT_COUNT
} sort;

#define LINEAR (1u << TRACE_LINEAR)
#define BVH (1u << TRACE_BVH)
#define EMBREE (1u << TRACE_EMBREE)

typedef struct word {
    const char *text;
    sort sort;
    unsigned value;
    unsigned kinds;
} word;

static const word words[] = {
    {"robust", SORT_FORM, TRACE_ROBUST, LINEAR | BVH},
    {"textbook", SORT_FORM, TRACE_TEXTBOOK, LINEAR},
    {"f32", SORT_PRECISION, TRACE_F32, LINEAR | BVH},
    {"f64", SORT_PRECISION, TRACE_F64, LINEAR | BVH},
    {"f128", SORT_PRECISION, TRACE_F128, LINEAR | BVH},
    {"triangles", SORT_SHAPES, TRACE_SHAPES_TRIANGLES, EMBREE},
    {"user", SORT_SHAPES, TRACE_SHAPES_USER, EMBREE},
    {"quad", SORT_SHAPES, TRACE_SHAPES_QUAD, EMBREE},
    {"sphere", SORT_SHAPES, TRACE_SHAPES_SPHERE, EMBREE},
    {"robust", SORT_FLAGS, TRACE_SCENE_ROBUST, EMBREE},
    {"default", SORT_FLAGS, TRACE_SCENE_DEFAULT, EMBREE},
    {"compact", SORT_FLAGS, TRACE_SCENE_COMPACT, EMBREE},
    {"auto", SORT_QUALITY, TRACE_QUALITY_AUTO, EMBREE},
    {"low", SORT_QUALITY, TRACE_QUALITY_LOW, EMBREE},
    {"medium", SORT_QUALITY, TRACE_QUALITY_MEDIUM, EMBREE},
    {"high", SORT_QUALITY, TRACE_QUALITY_HIGH, EMBREE},
    {"1", SORT_CALLS, TRACE_CALLS_1, EMBREE},
    {"4", SORT_CALLS, TRACE_CALLS_4, EMBREE},
    {"8", SORT_CALLS, TRACE_CALLS_8, EMBREE},
    {"16", SORT_CALLS, TRACE_CALLS_16, EMBREE},
    {"settled", SORT_TIES, TRACE_SETTLED, EMBREE},
    {"raw", SORT_TIES, TRACE_RAW, EMBREE},
    {"sse2", SORT_ISA, ISA_SSE2, EMBREE},
    {"sse4.2", SORT_ISA, ISA_SSE42, EMBREE},
    {"avx", SORT_ISA, ISA_AVX, EMBREE},
    {"avx2", SORT_ISA, ISA_AVX2, EMBREE},
    {"avx512", SORT_ISA, ISA_AVX512, EMBREE},
};
#define WORDS (sizeof words / sizeof *words)

static const struct {
    const char *text;
    trace_kind kind;
} kinds[] = {
    {"linear", TRACE_LINEAR}, {"bvh", TRACE_BVH}, {"embree", TRACE_EMBREE}, {"reference", TRACE_LINEAR}};
#define KINDS (sizeof kinds / sizeof *kinds)

/* ---- options as numbers, by sort ---- */

static void spec_set(trace_spec *spec, const unsigned value[SORT_COUNT]) {
    spec->form = (trace_form)value[SORT_FORM];
    spec->precision = (trace_precision)value[SORT_PRECISION];
    spec->shapes = (trace_shapes)value[SORT_SHAPES];
    spec->flags = (trace_scene_flags)value[SORT_FLAGS];
    spec->quality = (trace_quality)value[SORT_QUALITY];
    spec->calls = (trace_calls)value[SORT_CALLS];
    spec->ties = (trace_ties)value[SORT_TIES];
    spec->isa = (isa_set)value[SORT_ISA];
}

/* ---- from text ---- */

typedef struct reader {
    fathom_context *context;
    const char *text;
    unsigned kinds; /* the bit of its kind */
    unsigned value[SORT_COUNT];
    const char *given[SORT_COUNT]; /* the word that set it */
} reader;

/* "robust, textbook; f32, f64, f128": the options of a kind. */
static void list_options(unsigned bit, char *out, size_t size) {
    size_t used = 0;
    int last = -1;
    out[0] = '\0';
    for (size_t i = 0; i < WORDS && used < size; ++i) {
        if (!(words[i].kinds & bit)) continue;
        const char *between = last < 0 ? "" : (last == (int)words[i].sort ? ", " : "; ");
        used += (size_t)snprintf(out + used, size - used, "%s%s", between, words[i].text);
        last = (int)words[i].sort;
    }
}

static fathom_status unknown_kind(const reader *r, size_t length) {
    char options[3][200];
    for (int i = 0; i < 3; ++i) list_options(1u << kinds[i].kind, options[i], sizeof options[i]);
    return fail(r->context, FATHOM_BAD_USAGE,
                "no tracer is called \"%.*s\"; expected reference, a shared library FILE.so, linear (options "
                "%s), bvh (%s) or embree (%s), such as embree:user:high, found \"%.99s\"",
                (int)(length < 40 ? length : 40), r->text, options[0], options[1], options[2], r->text);
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
    if (r->given[found->sort]) {
        return fail(
            r->context, FATHOM_BAD_USAGE, "options \"%s\" and \"%s\" exclude each other%s, found \"%.99s\"",
            r->given[found->sort], found->text,
            found->sort == SORT_FLAGS ? ": with both, some of Embree's kernels never return" : "", r->text);
    }
    r->given[found->sort] = found->text;
    r->value[found->sort] = found->value;
    return FATHOM_OK;
}

fathom_status trace_spec_parse(fathom_context *context, const char *text, trace_spec *out) {
    if (!text) text = "embree";
    *out = (trace_spec){.kind = TRACE_PLUGIN, .path = text};
    size_t length = strlen(text);
    if (length > 3 && strcmp(text + length - 3, ".so") == 0) return FATHOM_OK;
    reader r = {.context = context, .text = text};
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
    spec_set(out, r.value);
    return FATHOM_OK;
}
