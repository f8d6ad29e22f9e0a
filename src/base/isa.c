#include "base/isa.h"

#include <stdlib.h>
#include <string.h>

static const char *const words[] = {"", "sse2", "sse4.2", "avx", "avx2", "avx512"};
#define SETS (sizeof words / sizeof *words)

const char *isa_word(isa_set set) { return set < SETS ? words[set] : ""; }

static isa_set named(const char *text) {
    for (size_t i = 1; text && i < SETS; ++i)
        if (strcmp(text, words[i]) == 0) return (isa_set)i;
    return ISA_BEST;
}

isa_set isa_limit(isa_set most) {
    isa_set allowed = named(getenv("FATHOM_ISA"));
    return most == ISA_BEST || (allowed != ISA_BEST && allowed < most) ? allowed : most;
}

const char *isa_unknown(void) {
    const char *text = getenv("FATHOM_ISA");
    return text && *text && named(text) == ISA_BEST ? text : NULL;
}

#if defined(__x86_64__)
#include <cpuid.h>

/* __builtin_cpu_supports() of clang 14 does not know this feature. The instruction is executed once: in
 * virtual machines it takes tens of microseconds, and kernels are chosen for each mesh. */
static bool has_f16c(void) {
    enum { UNKNOWN, LACKING, PRESENT };
    static _Atomic int known;
    unsigned a, b, c, d;
    if (known == UNKNOWN) known = __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C) ? PRESENT : LACKING;
    return known == PRESENT;
}

static bool processor_has(isa_set set) {
    switch (set) {
    case ISA_BEST: return false;
    case ISA_SSE2: return true;
    case ISA_SSE42: return __builtin_cpu_supports("sse4.2");
    case ISA_AVX: return __builtin_cpu_supports("avx");
    case ISA_AVX2: return __builtin_cpu_supports("avx2") && has_f16c();
    case ISA_AVX512:
        return processor_has(ISA_AVX2) && __builtin_cpu_supports("avx512f") &&
               __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
               __builtin_cpu_supports("avx512bw");
    }
    return false;
}
#else
static bool processor_has(isa_set set) {
    (void)set;
    return false;
}
#endif

bool isa_usable(isa_set set) { return isa_limit(set) == set && processor_has(set); }
