#include "shade/kernels.h"

extern const shade_kernels shade_kernels_plain;
#if SHADE_WIDE_KERNELS
extern const shade_kernels shade_kernels_avx2, shade_kernels_avx512;
#endif

static unsigned levels(void) {
#if SHADE_WIDE_KERNELS
    if (!__builtin_cpu_supports("avx2")) return 1;
    bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw");
    return wide ? 3 : 2;
#else
    return 1;
#endif
}

const shade_kernels *shade_kernels_at(unsigned index) {
    static const shade_kernels *const all[] = {
        &shade_kernels_plain,
#if SHADE_WIDE_KERNELS
        &shade_kernels_avx2,
        &shade_kernels_avx512,
#endif
    };
    return index < levels() ? all[index] : NULL;
}

const shade_kernels *shade_kernels_best(void) { return shade_kernels_at(levels() - 1); }
