/* Loaded before Embree: one fault in its answers, chosen by $FATHOM_MUTANT. mutants.tsv names the faults and
 * says what the validator must find. Packets are structures of arrays of 1, 4, 8 or 16 rays in either version
 * of Embree: rays first, then hits. */
#include <dlfcn.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#if FATHOM_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#define NONE RTC_INVALID_GEOMETRY_ID

static const char *name;
static bool is(const char *fault) {
    if (!name) name = getenv("FATHOM_MUTANT") ? getenv("FATHOM_MUTANT") : "none";
    return strcmp(name, fault) == 0;
}

/* A packet of n rays: fields as Embree orders them. */
typedef struct packet {
    unsigned n;
    float *org[3], *near, *dir[3], *far;
    uint32_t *mask;
    float *ng[3], *u, *v; /* closest hits alone, as what follows */
    uint32_t *primitive, *geometry, *instance;
} packet;

static packet packet_of(void *memory, unsigned n) {
    float *f = memory;
    uint32_t *i = memory;
    float *hit = f + 12 * (n > 1 ? n : 1);
    uint32_t *ids = i + 12 * (n > 1 ? n : 1);
    return (packet){n,
                    {f, f + n, f + 2 * n},
                    f + 3 * n,
                    {f + 4 * n, f + 5 * n, f + 6 * n},
                    f + 8 * n,
                    i + 9 * n,
                    {hit, hit + n, hit + 2 * n},
                    hit + 3 * n,
                    hit + 4 * n,
                    ids + 5 * n,
                    ids + 6 * n,
                    ids + 7 * n};
}

static double random_of(const packet *p, unsigned i) {
    uint32_t h = 2166136261u;
    for (int k = 0; k < 6; ++k) {
        uint32_t x;
        memcpy(&x, k < 3 ? &p->org[k][i] : &p->dir[k - 3][i], 4);
        h = (h ^ x) * 16777619u, h ^= h >> 15;
    }
    h *= 0x2c1b3c6du, h ^= h >> 12, h *= 0x297a2d39u, h ^= h >> 15;
    return h * 0x1p-32;
}

static unsigned active(const int *valid, unsigned n) {
    unsigned count = 0;
    for (unsigned i = 0; i < n; ++i) count += valid[i] != 0;
    return count;
}

static unsigned last_active(const int *valid, unsigned n) {
    unsigned last = 0;
    for (unsigned i = 0; i < n; ++i) last = valid[i] ? i : last;
    return last;
}

/* ---- before the call ---- */

static float shared_far;

static void before(packet *p, const int *valid, bool any) {
    for (unsigned i = 0; i < p->n; ++i) {
        if (!valid[i]) continue;
        if (any && is("mask_ignored")) p->mask[i] = ~0u;
        if (is("mask_narrow") && any) p->mask[i] &= 2u;
        if (any && is("any_far_ignored")) p->far[i] = INFINITY;
        if (any && is("any_near_ignored")) p->near[i] = 0;
        if (is("near_ignored")) p->near[i] = 0;
        if (is("far_1e3") && p->far[i] > 1e3f) p->far[i] = 1e3f;
        if (is("near_epsilon")) p->near[i] = p->near[i] + 1e-3f;
        if (is("tiny_direction"))
            for (int k = 0; k < 3; ++k) p->dir[k][i] = fabsf(p->dir[k][i]) < 1e-6f ? 0 : p->dir[k][i];
    }
}

/* ---- after the call ---- */

static bool loses(const packet *p, const int *valid, bool any, bool coherent, unsigned i) {
    if (is("coherent_all") && coherent) return true;
    if (is("coherent_16") && coherent && p->n >= 8) return true;
    if (is("coherent_lane") && coherent && i == 3) return true;
    if (is("coherent_any") && coherent && any) return true;
    if (is("coherent_any_lane") && coherent && any && i == 5) return true;
    if (is("coherent_partial") && coherent && active(valid, p->n) < p->n && active(valid, p->n) > p->n / 2 &&
        i == last_active(valid, p->n))
        return true;
    if (is("incoherent_any") && !coherent && any && random_of(p, i) < 0.01) return true;
    if (is("any_lost") && any && random_of(p, i) < 0.003) return true;
    if (is("alone") && active(valid, p->n) == 1) return true;
    if (is("last_lane") && active(valid, p->n) < p->n && i == last_active(valid, p->n)) return true;
    if (is("half") && p->n >= 8 && i >= p->n / 2 && active(valid, p->n) == p->n) return true;
    if (is("miss_1e-3") && random_of(p, i) < 1e-3) return true;
    if (any) return false;
    if (is("instances_lost") && p->instance[i] != NONE && random_of(p, i) < 0.02) return true;
    float edge = fminf(p->u[i], fminf(p->v[i], 1 - p->u[i] - p->v[i]));
    if (is("leaky_edges") && edge < 1e-5f && random_of(p, i) < 0.3) return true;
    return is("leaky_all") && edge < 1e-3f;
}

static void spoil(packet *p, unsigned i, bool coherent) {
    float u = p->u[i];
    if (is("bias_coherent") && coherent) p->far[i] *= 1 + 3e-6f;
    if (is("bias")) p->far[i] *= 1 + 2e-6f;
    if (is("uv_swapped")) p->u[i] = p->v[i], p->v[i] = u;
    if (is("u_nan")) p->u[i] = NAN;
    if (is("normal_zero")) p->ng[0][i] = p->ng[1][i] = p->ng[2][i] = 0;
    if (is("normal_nan")) p->ng[1][i] = NAN;
    if (is("normal_tilted")) p->ng[0][i] += 0.01f * fabsf(p->ng[1][i]) + 1e-3f * fabsf(p->ng[2][i]);
    if (is("normal_flipped"))
        for (int k = 0; k < 3; ++k) p->ng[k][i] = -p->ng[k][i];
    if (is("primitive_off") && p->u[i] < 0.02f && p->primitive[i] > 0) --p->primitive[i];
}

static void after(void *memory, const int *valid, unsigned n, bool any, bool coherent, const float *given,
                  const uint32_t *masks, const float *nears) {
    packet p = packet_of(memory, n);
    for (unsigned i = 0; i < n; ++i) {
        if (!valid[i]) continue;
        p.mask[i] = masks[i], p.near[i] = nears[i];
        bool met = any ? p.far[i] == -INFINITY : p.geometry[i] != NONE;
        if (!met) {
            p.far[i] = given[i];
            if (any && is("any_phantom") && random_of(&p, i) < 0.003) p.far[i] = -INFINITY;
            continue;
        }
        if (loses(&p, valid, any, coherent, i)) {
            p.far[i] = given[i];
            if (!any) p.geometry[i] = NONE;
        } else if (!any) {
            spoil(&p, i, coherent);
        }
    }
    if (is("race")) {
        ((volatile float *)&shared_far)[0] = p.far[0];
        for (volatile int wait = 0; wait < 400; ++wait) {
        }
        p.far[0] = ((volatile float *)&shared_far)[0];
    }
}

static void *real(const char *symbol) { return dlsym(RTLD_NEXT, symbol); }

#if FATHOM_EMBREE_MAJOR == 3
#define HOW_COHERENT (how->flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT)
#define ORDER(memory) scene, how, memory
#define PARAMETERS(type) RTCScene scene, struct RTCIntersectContext *how, type *memory
#else
#define HOW_COHERENT (how && how->flags & RTC_RAY_QUERY_FLAG_COHERENT)
#define ORDER(memory) scene, memory, how
#define PARAMETERS(type) RTCScene scene, type *memory, ARGUMENTS *how
#endif

#define WITH(call, n, any, valid)                                                                            \
    packet p = packet_of(memory, n);                                                                         \
    float given[n], nears[n], directions[3][n];                                                              \
    uint32_t masks[n];                                                                                       \
    memcpy(given, p.far, sizeof given), memcpy(nears, p.near, sizeof nears);                                 \
    memcpy(masks, p.mask, sizeof masks);                                                                     \
    for (int k = 0; k < 3; ++k) memcpy(directions[k], p.dir[k], sizeof directions[k]);                       \
    before(&p, valid, any);                                                                                  \
    call;                                                                                                    \
    for (int k = 0; k < 3; ++k) memcpy(p.dir[k], directions[k], sizeof directions[k]);                       \
    after(memory, valid, n, any, HOW_COHERENT, given, masks, nears)

#define PACKET(symbol, type, n, any)                                                                         \
    void symbol(const int *valid, PARAMETERS(type)) {                                                        \
        static void (*call)(const int *, PARAMETERS(type));                                                  \
        if (!call) *(void **)(void *)&call = real(#symbol);                                                  \
        WITH(call(valid, ORDER(memory)), n, any, valid);                                                     \
    }
#define SINGLE(symbol, type, any)                                                                            \
    void symbol(PARAMETERS(type)) {                                                                          \
        static void (*call)(PARAMETERS(type));                                                               \
        static const int valid[1] = {-1};                                                                    \
        if (!call) *(void **)(void *)&call = real(#symbol);                                                  \
        WITH(call(ORDER(memory)), 1, any, valid);                                                            \
    }

#define ARGUMENTS struct RTCIntersectArguments
SINGLE(rtcIntersect1, struct RTCRayHit, false)
PACKET(rtcIntersect4, struct RTCRayHit4, 4, false)
PACKET(rtcIntersect8, struct RTCRayHit8, 8, false)
PACKET(rtcIntersect16, struct RTCRayHit16, 16, false)
#undef ARGUMENTS
#define ARGUMENTS struct RTCOccludedArguments
SINGLE(rtcOccluded1, struct RTCRay, true)
PACKET(rtcOccluded4, struct RTCRay4, 4, true)
PACKET(rtcOccluded8, struct RTCRay8, 8, true)
PACKET(rtcOccluded16, struct RTCRay16, 16, true)

/* ---- what scenes are made of ---- */

void rtcSetGeometryMask(RTCGeometry geometry, unsigned mask) {
    static void (*call)(RTCGeometry, unsigned);
    if (!call) *(void **)(void *)&call = real("rtcSetGeometryMask");
    call(geometry, is("masks_unset") ? ~0u : mask);
}

void rtcSetGeometryTransform(RTCGeometry geometry, unsigned step, enum RTCFormat format, const void *xfm) {
    static void (*call)(RTCGeometry, unsigned, enum RTCFormat, const void *);
    if (!call) *(void **)(void *)&call = real("rtcSetGeometryTransform");
    float m[12];
    memcpy(m, xfm, sizeof m);
    float det = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
                m[2] * (m[3] * m[7] - m[4] * m[6]);
    if (is("mirror_lost") && det < 0)
        for (int k = 0; k < 9; ++k) m[k] = fabsf(m[k]);
    call(geometry, step, format, m);
}
