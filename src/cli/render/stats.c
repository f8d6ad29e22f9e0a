#include "cli/render/stats.h"

#include "cli/command.h"
#include "cli/json_text.h"
#include "cli/provenance.h"
#include "cli/render/left_out.h"
#include "cli/standard_output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

uint64_t report_rays(const render_report *report) {
    const fathom_stats *s = &report->stats;
    return s->camera_rays + s->shadow_rays + s->reflection_rays + s->refraction_rays;
}

double report_rays_per_second(const render_report *report) {
    double seconds = report->stats.render_seconds;
    return seconds > 0 ? (double)report_rays(report) / seconds : 0;
}

double report_mean_spp(const render_report *r) {
    return (double)r->stats.samples / ((double)r->width * r->height);
}

uint64_t report_peak_bytes(void) {
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024 : 0;
}

uint64_t report_needed_bytes(const render_report *r) {
    return r->stats.mesh_bytes + r->stats.bvh_bytes + r->stats.film_bytes;
}

static json_t *count_or_null(uint64_t bytes) { return bytes ? json_count(bytes) : json_null(); }

static json_t *pack_memory(const render_report *r) {
    const fathom_stats *s = &r->stats;
    uint64_t peak = report_peak_bytes();
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:f, s:o}", "peakBytes", json_count(peak), "meshBytes",
                     json_count(s->mesh_bytes), "bvhBytes", json_count(s->bvh_bytes), "filmBytes",
                     json_count(s->film_bytes), "bvhPeakBytes", json_count(s->bvh_peak_bytes), "peakToNeeded",
                     (double)peak / (double)report_needed_bytes(r), "foreseenBytes",
                     count_or_null(s->foreseen_bytes));
}

/* "Embree 3.13.5, AVX-512" -> "3.13.5" and "AVX-512"; the reference tracer has neither. */
static void set_embree(json_t *root, const char *tracer) {
    char version[64] = "", isa[64] = "";
    bool embree = sscanf(tracer, "Embree %63[^,], %63[^\n]", version, isa) == 2;
    json_object_set_new(root, "tracer", json_string(tracer));
    json_object_set_new(root, "embreeVersion", embree ? json_string(version) : json_null());
    json_object_set_new(root, "isa", embree ? json_string(isa) : json_null());
}

static json_t *pack_seconds(const render_report *r) {
    return json_pack("{s:f, s:f, s:f, s:f, s:f}", "read", r->read_seconds, "build", r->stats.build_seconds,
                     "render", r->stats.render_seconds, "write", r->write_seconds, "total", r->total_seconds);
}

static json_t *pack_rays(const render_report *r) {
    const fathom_stats *s = &r->stats;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "camera", json_count(s->camera_rays),
                     "shadow", json_count(s->shadow_rays), "reflection", json_count(s->reflection_rays),
                     "refraction", json_count(s->refraction_rays), "total", json_count(report_rays(r)),
                     "repaired", json_count(s->repaired_rays), "unlitShadow",
                     json_count(s->unlit_shadow_rays), "faintShadow", json_count(s->faint_shadow_rays));
}

/* The spp asked for is the most of a pixel when samples follow the error. */
static json_t *pack_image(const render_report *r, const render_options *options) {
    double error = r->stats.error_estimate;
    return json_pack("{s:i, s:i, s:i, s:f, s:o}", "width", (int)r->width, "height", (int)r->height, "spp",
                     (int)options->settings.spp, "meanSpp", report_mean_spp(r), "errorEstimate",
                     error > 0 && isfinite(error) ? json_real(error) : json_null());
}

static json_t *pack_checkpoint(const fathom_stats *s, const char *path) {
    if (!path) return json_null();
    return json_pack("{s:o, s:o, s:f, s:b, s:f, s:o}", "file", json_text(path), "saved",
                     json_count(s->checkpoints), "seconds", s->checkpoint_seconds, "resumed",
                     s->resumed_seconds > 0, "resumedSeconds", s->resumed_seconds, "resumedSamples",
                     json_count(s->resumed_samples));
}

static json_t *pack_outputs(const args_list *outputs) {
    json_t *array = json_array();
    for (size_t i = 0; i < outputs->count; ++i)
        json_array_append_new(array, json_text(standard_output_shown(outputs, i)));
    return array;
}

/* Text: a number of 64 bits is more than most readers of JSON keep. */
static json_t *pack_fingerprint(uint64_t fingerprint) {
    char text[24];
    snprintf(text, sizeof text, "%016llx", (unsigned long long)fingerprint);
    return json_string(text);
}

static json_t *pack(const render_report *r, const render_options *options) {
    json_t *root = json_object();
    const fathom_stats *s = &r->stats;
    json_object_set_new(root, "fathom", json_string(fathom_version()));
    json_object_set_new(root, "commit", *fathom_commit() ? json_string(fathom_commit()) : json_null());
    json_object_set_new(root, "command", provenance_arguments());
    json_object_set_new(root, "scene", json_text(r->scene));
    json_object_set_new(root, "sceneFingerprint", pack_fingerprint(s->scene_fingerprint));
    json_object_set_new(root, "image", pack_image(r, options));
    json_object_set_new(root, "outputs", pack_outputs(&options->outputs));
    json_object_set_new(root, "exposure", json_real((double)options->write.exposure));
    json_object_set_new(root, "interrupted", json_boolean(r->interrupted));
    json_object_set_new(root, "checkpoint", pack_checkpoint(s, options->checkpoint));
    json_object_set_new(root, "triangles", json_count(s->triangles));
    json_object_set_new(root, "placedTriangles", json_count(s->placed_triangles));
    json_object_set_new(root, "primitives", json_count(s->primitives));
    json_object_set_new(root, "instances", json_count(s->instances));
    json_object_set_new(root, "degenerateTriangles", json_count(s->degenerate_triangles));
    json_object_set_new(root, "seconds", pack_seconds(r));
    json_object_set_new(root, "rays", pack_rays(r));
    json_object_set_new(root, "raysPerSecond", json_real(report_rays_per_second(r)));
    json_object_set_new(root, "peakMemoryBytes", json_count(report_peak_bytes()));
    json_object_set_new(root, "bvhBytes", json_count(s->bvh_bytes));
    json_object_set_new(root, "memory", pack_memory(r));
    json_object_set_new(root, "leftOut", left_out_json(r->left_out.items, (uint32_t)r->left_out.count));
    json_object_set_new(root, "warnings", warnings_json(&r->warnings));
    set_embree(root, s->tracer);
    json_object_set_new(root, "threads", json_count(s->threads));
    return root;
}

fathom_status stats_write(fathom_context *context, const render_report *report,
                          const render_options *options) {
    json_t *root = pack(report, options);
    fathom_status status = json_write_file(context, options->stats, root);
    json_decref(root);
    return status;
}

static double megabytes(uint64_t bytes) { return 1e-6 * (double)bytes; }

static void print_memory(const render_report *r) {
    const fathom_stats *s = &r->stats;
    uint64_t peak = report_peak_bytes();
    printf("memory   %.1f MB at most, %.3g times meshes %.1f, BVH %.1f (at most %.1f) and film %.1f",
           megabytes(peak), (double)peak / (double)report_needed_bytes(r), megabytes(s->mesh_bytes),
           megabytes(s->bvh_bytes), megabytes(s->bvh_peak_bytes), megabytes(s->film_bytes));
    if (s->foreseen_bytes) printf("; %.0f were foreseen", megabytes(s->foreseen_bytes));
    putchar('\n');
}

static void print_checkpoint(const fathom_stats *s, const char *path) {
    if (!path) return;
    printf("saved    %u times to ", s->checkpoints);
    print_name(stdout, path);
    printf(", in %.3f s beside rendering", s->checkpoint_seconds);
    if (s->resumed_seconds > 0) printf("; resumed after %.1f s of rendering", s->resumed_seconds);
    putchar('\n');
}

static void print_details(const render_report *r, const render_options *options) {
    const fathom_stats *s = &r->stats;
    fputs("scene    ", stdout);
    print_name(stdout, r->scene);
    printf(": %llu primitives, of them %llu triangles; %llu instances", (unsigned long long)s->primitives,
           (unsigned long long)s->triangles, (unsigned long long)s->instances);
    if (s->placed_triangles != s->triangles)
        printf(", %llu triangles with them", (unsigned long long)s->placed_triangles);
    putchar('\n');
    printf("tracer   %s, %u threads\n", s->tracer, s->threads);
    printf("seconds  read %.3f, build %.3f, render %.3f, write %.3f, total %.3f\n", r->read_seconds,
           s->build_seconds, s->render_seconds, r->write_seconds, r->total_seconds);
    printf("rays     camera %llu, shadow %llu, reflection %llu, refraction %llu; of them repaired %llu\n",
           (unsigned long long)s->camera_rays, (unsigned long long)s->shadow_rays,
           (unsigned long long)s->reflection_rays, (unsigned long long)s->refraction_rays,
           (unsigned long long)s->repaired_rays);
    printf("         shadow rays not cast: %llu for nothing, %llu too faint\n",
           (unsigned long long)s->unlit_shadow_rays, (unsigned long long)s->faint_shadow_rays);
    print_memory(r);
    print_checkpoint(s, options->checkpoint);
    left_out_print(r->left_out.items, (uint32_t)r->left_out.count, "left out ");
}

static void print_sampling(const render_report *r, const render_options *options) {
    double error = r->stats.error_estimate;
    if (!(error > 0)) {
        printf("%u spp", options->settings.spp);
    } else if (isfinite(error)) {
        printf("%.1f spp, error %.2g", report_mean_spp(r), error);
        if (options->settings.target_error > 0 && error > options->settings.target_error)
            printf(" (above the target)");
    } else {
        printf("%.1f spp, error unknown", report_mean_spp(r));
    }
}

void stats_print(const render_report *report, const render_options *options) {
    if (options->quiet) return;
    if (options->verbose) print_details(report, options);
    for (size_t i = 0; i < options->outputs.count; ++i) {
        if (i) fputs(", ", stdout);
        print_name(stdout, standard_output_shown(&options->outputs, i));
    }
    printf(": %ux%u, ", report->width, report->height);
    print_sampling(report, options);
    if (options->exposure_auto) printf(", exposure %g", (double)options->write.exposure);
    printf(", %.2f s, %.1f Mrays/s", report->total_seconds, 1e-6 * report_rays_per_second(report));
    if (report->interrupted) printf(", interrupted at %u %%", (unsigned)(100 * report->finished));
    putchar('\n');
}
