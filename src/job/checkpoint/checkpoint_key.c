/* The settings that must be the same for a render to be continued. */
#include "job/checkpoint/checkpoint_state.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

typedef enum kind { KIND_COUNT, KIND_REAL, KIND_BITS, KIND_PATTERN, KIND_YES } kind;

static const struct {
    const char *name;
    kind kind;
} fields[CHECKPOINT_NUMBERS] = {
    [CHECKPOINT_SCENE] = {"a scene of contents", KIND_BITS},
    [CHECKPOINT_WIDTH] = {"width", KIND_COUNT},
    [CHECKPOINT_HEIGHT] = {"height", KIND_COUNT},
    [CHECKPOINT_CROP_X0] = {"crop x0", KIND_COUNT},
    [CHECKPOINT_CROP_Y0] = {"crop y0", KIND_COUNT},
    [CHECKPOINT_CROP_X1] = {"crop x1", KIND_COUNT},
    [CHECKPOINT_CROP_Y1] = {"crop y1", KIND_COUNT},
    [CHECKPOINT_SPP] = {"spp", KIND_COUNT},
    [CHECKPOINT_PATTERN] = {"pattern", KIND_PATTERN},
    [CHECKPOINT_SEED] = {"seed", KIND_COUNT},
    [CHECKPOINT_TARGET_ERROR] = {"target error", KIND_REAL},
    [CHECKPOINT_TIMED] = {"max time:", KIND_YES},
    [CHECKPOINT_MIN_SPP] = {"min spp", KIND_COUNT},
    [CHECKPOINT_MAX_DEPTH] = {"max depth", KIND_COUNT},
    [CHECKPOINT_MIN_WEIGHT] = {"min weight", KIND_REAL},
    [CHECKPOINT_MAX_LOSS] = {"max loss", KIND_REAL},
    [CHECKPOINT_MAX_RELATIVE_LOSS] = {"max relative loss", KIND_REAL},
    [CHECKPOINT_EPSILON] = {"epsilon", KIND_REAL},
    [CHECKPOINT_TERMINATOR_FIX] = {"terminator fix:", KIND_YES},
    [CHECKPOINT_AOVS] = {"AOVs", KIND_BITS},
};

static uint64_t bits_of(double real) {
    uint64_t bits;
    memcpy(&bits, &real, sizeof bits);
    return bits;
}

void checkpoint_key_of(const fathom_settings *s, const fathom_film *film, uint64_t scene,
                       checkpoint_key *out) {
    const bool timed = s->max_time > 0, adaptive = timed || s->target_error > 0;
    *out = (checkpoint_key){.version = ""};
    snprintf(out->version, sizeof out->version, "%s", fathom_version());
    uint64_t *n = out->numbers;
    n[CHECKPOINT_SCENE] = scene;
    n[CHECKPOINT_WIDTH] = s->width, n[CHECKPOINT_HEIGHT] = s->height;
    n[CHECKPOINT_CROP_X0] = film->x, n[CHECKPOINT_CROP_X1] = (uint64_t)film->x + film->width;
    n[CHECKPOINT_CROP_Y0] = film->y, n[CHECKPOINT_CROP_Y1] = (uint64_t)film->y + film->height;
    n[CHECKPOINT_SPP] = s->spp;
    n[CHECKPOINT_PATTERN] = s->pattern;
    n[CHECKPOINT_SEED] = s->seed;
    n[CHECKPOINT_TARGET_ERROR] = bits_of(s->target_error);
    n[CHECKPOINT_TIMED] = timed;
    n[CHECKPOINT_MIN_SPP] = adaptive && !s->min_spp ? ADAPTIVE_MIN_SPP : s->min_spp;
    n[CHECKPOINT_MAX_DEPTH] = s->max_depth;
    n[CHECKPOINT_MIN_WEIGHT] = bits_of((double)s->min_weight);
    n[CHECKPOINT_MAX_LOSS] = bits_of((double)s->max_loss);
    n[CHECKPOINT_MAX_RELATIVE_LOSS] = bits_of((double)s->max_relative_loss);
    n[CHECKPOINT_EPSILON] = bits_of(s->epsilon);
    n[CHECKPOINT_TERMINATOR_FIX] = s->terminator_fix;
    n[CHECKPOINT_AOVS] = s->aovs;
}

static const char *pattern_name(uint64_t number) {
    static const char *const names[] = {"grid", "stratified", "sobol"};
    return number < sizeof names / sizeof *names ? names[number] : "unknown";
}

static void print_number(kind how, uint64_t number, char out[32]) {
    double real;
    switch (how) {
    case KIND_COUNT: snprintf(out, 32, "%" PRIu64, number); break;
    case KIND_BITS: snprintf(out, 32, "%#" PRIx64, number); break;
    case KIND_PATTERN: snprintf(out, 32, "%s", pattern_name(number)); break;
    case KIND_YES: snprintf(out, 32, "%s", number ? "yes" : "no"); break;
    case KIND_REAL:
        memcpy(&real, &number, sizeof real);
        snprintf(out, 32, "%.9g", real);
        break;
    }
}

static fathom_status differs(fathom_context *context, const char *path, const char *name, const char *saved,
                             const char *now) {
    return fail_file(context, FATHOM_BAD_INPUT, path,
                     "the checkpoint was saved with %s %s, and this render has %s; expected the same render, "
                     "or another checkpoint file",
                     name, saved, now);
}

fathom_status checkpoint_key_compare(fathom_context *context, const char *path, const checkpoint_key *saved,
                                     const checkpoint_key *now) {
    if (strcmp(saved->version, now->version) != 0)
        return differs(context, path, "Fathom", saved->version, now->version);
    for (size_t i = 0; i < CHECKPOINT_NUMBERS; ++i) {
        if (saved->numbers[i] == now->numbers[i]) continue;
        char texts[2][32];
        print_number(fields[i].kind, saved->numbers[i], texts[0]);
        print_number(fields[i].kind, now->numbers[i], texts[1]);
        return differs(context, path, fields[i].name, texts[0], texts[1]);
    }
    return FATHOM_OK;
}

fathom_status checkpoint_tracer_compare(fathom_context *context, const char *path, const char *saved,
                                        const char *now) {
    return strcmp(saved, now) == 0 ? FATHOM_OK : differs(context, path, "the tracer", saved, now);
}
