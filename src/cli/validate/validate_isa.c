/* Embree once with each instruction set: its kernels do not leak alike. */
#include "base/isa.h"
#include "cli/validate/validate.h"

#include <string.h>

/* True when the words leave the instruction set open. */
static bool is_open(const char *spec) {
    if (strncmp(spec, "embree", 6) != 0) return false;
    for (isa_set set = ISA_SSE2; set <= ISA_AVX512; ++set) {
        const char *found = strstr(spec, isa_word(set));
        char after = '\0';
        if (found) after = found[strlen(isa_word(set))];
        if (found && found[-1] == ':' && (after == '\0' || after == ':')) return false;
    }
    return true;
}

static bool put(validate_isas *room, args_list *out, const char *spec, const char *word) {
    if (out->count == ARGS_LIST_MAX) return false;
    char *text = room->text[out->count];
    int size = snprintf(text, sizeof room->text[0], "%s%s%s", spec, *word ? ":" : "", word);
    if (size < 0 || (size_t)size >= sizeof room->text[0]) return false;
    out->items[out->count++] = text;
    return true;
}

fathom_status validate_each_isa(fathom_context *context, validate_settings *settings, validate_isas *room) {
    args_list out = {.count = 0};
    bool fits = true;
    for (size_t i = 0; i < settings->tracers.count; ++i) {
        const char *spec = settings->tracers.items[i];
        bool open = isa_usable(ISA_SSE2) && is_open(spec);
        if (!open) fits = put(room, &out, spec, "") && fits;
        for (isa_set set = ISA_SSE2; open && set <= ISA_AVX512; ++set)
            fits = (!isa_usable(set) || put(room, &out, spec, isa_word(set))) && fits;
    }
    if (!fits)
        return fail(context, FATHOM_BAD_USAGE,
                    "--isa all: that makes more than %d tracers, or names too long; give fewer of --tracer",
                    ARGS_LIST_MAX);
    settings->tracers = out;
    return FATHOM_OK;
}

const char *validate_isa_of(const validate_run *run) {
    const char *comma = strchr(run->tracer, ',');
    return strncmp(run->tracer, "Embree ", 7) == 0 && comma ? comma + 2 : NULL;
}

/* ---- leaks by set ---- */

static void print_counts(const char *spec, const char *name, const compare_family families[RAYS_FAMILIES]) {
    uint64_t rays = 0, closest = 0, any = 0;
    for (int f = 0; f < RAYS_FAMILIES; ++f) {
        rays += families[f].rays;
        closest += families[f].counts[VERDICT_LEAK], any += families[f].any_counts[VERDICT_LEAK];
    }
    const compare_family *edge = &families[RAYS_EDGE], *vertex = &families[RAYS_VERTEX];
    printf("%-28s %-8s %9llu %8llu %8llu   %7llu of %-8llu %7llu of %llu\n", spec, name,
           (unsigned long long)rays, (unsigned long long)closest, (unsigned long long)any,
           (unsigned long long)edge->counts[VERDICT_LEAK], (unsigned long long)edge->rays,
           (unsigned long long)vertex->counts[VERDICT_LEAK], (unsigned long long)vertex->rays);
}

/* Runs of one tracer follow each other. */
void validate_print_isas(const validate_runs *runs) {
    printf("\n%-28s %-8s %9s %8s %8s   %-19s %s\n", "tracer leaks", "", "rays", "closest", "any", "at edges",
           "at vertices");
    for (size_t i = 0; i < runs->count;) {
        const validate_run *first = &runs->items[i];
        compare_family families[RAYS_FAMILIES];
        memset(families, 0, sizeof families);
        for (; i < runs->count && strcmp(runs->items[i].spec, first->spec) == 0; ++i) {
            for (int f = 0; f < RAYS_FAMILIES; ++f)
                compare_family_join(&families[f], &runs->items[i].result.families[f]);
        }
        const char *name = validate_isa_of(first);
        print_counts(first->spec, name ? name : "-", families);
    }
}
