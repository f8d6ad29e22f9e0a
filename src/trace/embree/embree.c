/* The Embree tracer: the device, its settings and its callbacks. */
#include "trace/embree/embree.h"

#include "base/threads.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- the device's callbacks; from any thread ---- */

static void on_error(void *user, enum RTCError code, const char *text) {
    embree_tracer *tracer = user;
    int none = RTC_ERROR_NONE;
    if (code == RTC_ERROR_NONE || !atomic_compare_exchange_strong(&tracer->error, &none, (int)code)) return;
    snprintf(tracer->error_text, sizeof tracer->error_text, "%s", text ? text : "");
}

/* False if the limit would be exceeded; Embree then stops with an error. */
static bool on_memory(void *user, ssize_t bytes, bool post) {
    embree_tracer *tracer = user;
    int64_t held = atomic_fetch_add(&tracer->bytes, (int64_t)bytes) + (int64_t)bytes;
    int64_t peak = atomic_load(&tracer->peak);
    while (held > peak && !atomic_compare_exchange_weak(&tracer->peak, &peak, held)) continue;
    (void)post;
    return bytes <= 0 || !tracer->most_bytes || held <= (int64_t)tracer->most_bytes;
}

/* ---- choices ---- */

/* Low quality saves build time and costs tracing time: it pays up to this number of rays for a million
 * primitives, and for others in proportion to the root of their number. Scenes differ: displaced spheres are
 * traced nearly as fast, most others take 1.1 to 1.3 times as long (bench/README.md). With this limit either
 * kind of scene loses at most a quarter. More threads reduce both times equally. */
#define LOW_QUALITY_RAYS 20e6

trace_quality trace_quality_auto(uint64_t expected_rays, const world *w) {
    double primitives = (double)w->instances.count;
    for (size_t i = 0; i < w->geometries.count; ++i) primitives += w->geometries.items[i].count;
    bool few = expected_rays > 0 && (double)expected_rays < LOW_QUALITY_RAYS * sqrt(primitives * 1e-6);
    return few ? TRACE_QUALITY_LOW : TRACE_QUALITY_MEDIUM;
}

static enum RTCBuildQuality build_quality(const trace_spec *spec, const trace_options *options,
                                          const world *w) {
    trace_quality quality = spec->quality;
    if (quality == TRACE_QUALITY_AUTO) quality = trace_quality_auto(options->expected_rays, w);
    switch (quality) {
    case TRACE_QUALITY_LOW: return RTC_BUILD_QUALITY_LOW;
    case TRACE_QUALITY_AUTO:
    case TRACE_QUALITY_MEDIUM: break;
    case TRACE_QUALITY_HIGH: return RTC_BUILD_QUALITY_HIGH;
    }
    return RTC_BUILD_QUALITY_MEDIUM;
}

/* Embree 3 splits a packet that is wider than its kernels. It then also traces invalid lanes and can abort on
 * their numbers. So calls are never wider than the kernels. */
unsigned embree_call_width(const embree_tracer *tracer, unsigned asked) {
    RTCDevice device = tracer->device;
    if (asked >= 16 && rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return 16;
    if (asked >= 8 && rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED)) return 8;
    if (asked >= 4 && rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED)) return 4;
    return 1;
}

/* Embree does not report its instruction set. The packet widths narrow it down to two; the processor and
 * `most` decide between these. */
static const char *isa_name(RTCDevice device, isa_set most) {
#if defined(__x86_64__)
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)) return "AVX-512";
    if (rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED))
        return most != ISA_AVX && isa_usable(ISA_AVX2) ? "AVX2" : "AVX";
    return most != ISA_SSE2 && isa_usable(ISA_SSE42) ? "SSE4.2" : "SSE2";
#elif defined(__aarch64__)
    (void)device, (void)most;
    return "NEON";
#else
    (void)device, (void)most;
    return "unknown instruction set";
#endif
}

/* ---- threads ----
 * Embree's scheduler ends the process if it cannot start an expected thread, also when the last device is
 * released. So Embree gets only as many threads as the system grants. If these are fewer than wanted, devices
 * are never released. */

static atomic_bool scarce;

static unsigned build_threads(unsigned wanted) {
    unsigned granted = 1 + threads_granted(wanted - 1);
    if (granted < wanted) atomic_store(&scarce, true);
    return granted;
}

static void release_device(RTCDevice device) {
    if (device && !atomic_load(&scarce)) rtcReleaseDevice(device);
}

/* ---- life ---- */

static void destroy(trace_tracer *base) {
    embree_tracer *tracer = (embree_tracer *)base;
    for (size_t g = 0; tracer->scenes && g < base->world->groups.count; ++g)
        if (tracer->scenes[g]) rtcReleaseScene(tracer->scenes[g]);
    for (size_t g = 0; tracer->clusters && g < base->world->geometries.count; ++g)
        free(tracer->clusters[g].items);
    free(tracer->scenes);
    free(tracer->clusters);
    free(tracer->halved);
    free(tracer->few);
    free(tracer->passing);
    free(tracer->clear);
    release_device(tracer->device);
    free(tracer);
}

/* If Embree was built without a kind of geometry, it reports no error, and every ray misses. */
static fathom_status check_device(const embree_tracer *tracer) {
    static const struct {
        enum RTCDeviceProperty property;
        const char *name;
    } wanted[] = {{RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED, "ray masks"},
                  {RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED, "filter functions"},
                  {RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED, "triangles"},
                  {RTC_DEVICE_PROPERTY_USER_GEOMETRY_SUPPORTED, "user geometry"}};
    for (size_t i = 0; i < sizeof wanted / sizeof *wanted; ++i) {
        if (!rtcGetDeviceProperty(tracer->device, wanted[i].property))
            return fail(tracer->context, FATHOM_INTERNAL,
                        "this Embree was built without %s, which Fathom needs; install another",
                        wanted[i].name);
    }
    return FATHOM_OK;
}

static RTCDevice new_device(isa_set most, unsigned threads) {
    const char *isa = isa_word(isa_limit(most));
    char config[64];
    snprintf(config, sizeof config, "threads=%u%s%s", threads, *isa ? ",isa=" : "", isa);
    return rtcNewDevice(config);
}

static fathom_status open_device(embree_tracer *tracer) {
    unsigned threads = tracer->options->threads;
    if (!threads) threads = fathom_context_threads(tracer->context);
    tracer->device = new_device(tracer->spec.isa, build_threads(threads));
    if (!tracer->device) {
        enum RTCError error = rtcGetDeviceError(NULL);
        return fail(tracer->context,
                    error == RTC_ERROR_OUT_OF_MEMORY ? FATHOM_OUT_OF_RESOURCES : FATHOM_INTERNAL,
                    "Embree cannot be started: error %d%s", (int)error,
                    error == RTC_ERROR_UNSUPPORTED_CPU ? ": the processor lacks SSE2" : "");
    }
    rtcSetDeviceErrorFunction(tracer->device, on_error, tracer);
    rtcSetDeviceMemoryMonitorFunction(tracer->device, on_memory, tracer);
    return check_device(tracer);
}

/* The filter must match the packet width: it uses the same instructions as the kernels of that width. */
static void choose_calls(embree_tracer *tracer) {
    static const unsigned widths[] = {0, 1, 4, 8, 16};
    unsigned asked = widths[tracer->spec.calls];
    /* Embree's packets and single rays interpolate transforms with different instructions, and packets split
     * depending on the other rays. So only single rays give reproducible hits. */
    if (tracer->base.world->moves) asked = 1;
    tracer->width = embree_call_width(tracer, asked ? asked : tracer->options->width);
    if (tracer->spec.ties == TRACE_SETTLED) tracer->filter = embree_filter(tracer->width);
}

static void put_name(RTCDevice device, isa_set most, char *out, size_t size) {
    snprintf(out, size, "Embree %d.%d.%d, %s",
             (int)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR),
             (int)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MINOR),
             (int)rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_PATCH), isa_name(device, most));
}

void trace_embree_name(char *out, size_t size) {
    RTCDevice device = new_device(ISA_BEST, 1);
    snprintf(out, size, "Embree %s cannot be started", RTC_VERSION_STRING);
    if (device) put_name(device, isa_limit(ISA_BEST), out, size);
    release_device(device);
}

static void describe(embree_tracer *tracer) {
    put_name(tracer->device, tracer->spec.isa, tracer->base.name, sizeof tracer->base.name);
    static const char *const shapes[] = {"triangles", "user"};
    static const char *const flags[] = {"robust", "default", "compact"};
    snprintf(tracer->base.way, sizeof tracer->base.way, "%s, %s, %s", shapes[tracer->spec.shapes],
             flags[tracer->spec.flags], tracer->spec.ties == TRACE_SETTLED ? "settled" : "raw");
    tracer->base.bvh_bytes = (uint64_t)atomic_load(&tracer->bytes);
    tracer->base.peak_bytes = (uint64_t)atomic_load(&tracer->peak);
}

fathom_status embree_create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out) {
    static const trace_ops ops = {destroy, embree_closest, embree_any, false, false};
    *out = NULL;
    embree_tracer *tracer = calloc(1, sizeof *tracer);
    if (!tracer) return fail_memory(context, sizeof *tracer);
    tracer->base.ops = &ops;
    tracer->kernels = embree_kernels_best();
    tracer->base.retry = w->moves ? NULL : embree_retry(spec); /* it does not support motion */
    tracer->base.self = &tracer->base;
    tracer->base.world = w;
    tracer->base.unit = 0x1p-24;
    tracer->spec = *spec;
    tracer->context = context;
    tracer->options = options;
    fathom_status status = embree_fit_memory(tracer);
    if (status == FATHOM_OK) status = open_device(tracer);
    if (status == FATHOM_OK) {
        choose_calls(tracer);
        tracer->quality = build_quality(&tracer->spec, options, w);
        /* At low quality trees depend on the threads, and Embree's hits on moving shapes depend on the tree
         * by a rounding. */
        if (w->moves && tracer->quality == RTC_BUILD_QUALITY_LOW) tracer->quality = RTC_BUILD_QUALITY_MEDIUM;
        status = embree_build(tracer);
    }
    if (status != FATHOM_OK) {
        destroy(&tracer->base);
        return status;
    }
    describe(tracer);
    tracer->context = NULL, tracer->options = NULL;
    *out = &tracer->base;
    return FATHOM_OK;
}
