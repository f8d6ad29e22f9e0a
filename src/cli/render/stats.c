#include "cli/render/stats.h"

#include "cli/command.h"
#include "cli/json_text.h"
#include "cli/machine.h"
#include "cli/provenance.h"
#include "cli/render/brightness.h"
#include "cli/render/images.h"

#include <math.h>
#include <stdio.h>
#include <sys/resource.h>

static uint64_t rays(const render_report *report) {
    const fathom_stats *s = &report->stats;
    return s->camera_rays + s->shadow_rays + s->reflection_rays + s->refraction_rays;
}

static double rays_per_second(const render_report *report) {
    double seconds = report->stats.render_seconds;
    return seconds > 0 ? (double)rays(report) / seconds : 0;
}

static double mean_spp(const render_report *r) {
    return (double)r->stats.samples / ((double)r->width * r->height);
}

static uint64_t peak_bytes(void) {
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (uint64_t)usage.ru_maxrss * 1024 : 0;
}

static uint64_t needed_bytes(const render_report *r) {
    return r->stats.mesh_bytes + r->stats.bvh_bytes + r->stats.film_bytes + r->stats.image_bytes;
}

static json_t *pack_memory(const render_report *r) {
    const fathom_stats *s = &r->stats;
    const uint64_t peak = peak_bytes();
    return json_of(JSON("peakBytes", peak), JSON("meshBytes", s->mesh_bytes), JSON("bvhBytes", s->bvh_bytes),
                   JSON("filmBytes", s->film_bytes), JSON("imageBytes", s->image_bytes),
                   JSON("bvhPeakBytes", s->bvh_peak_bytes),
                   JSON("peakToNeeded", (double)peak / (double)needed_bytes(r)),
                   JSON("foreseenBytes", s->foreseen_bytes ? json_count(s->foreseen_bytes) : json_null()));
}

static void add_tracer(json_t *root, const char *tracer) {
    char version[64], isa[64];
    const bool embree = machine_embree(tracer, version, isa);
    json_add(root, JSON("tracer", tracer), JSON("embreeVersion", embree ? version : NULL),
             JSON("isa", embree ? isa : NULL));
}

static json_t *pack_seconds(const render_report *r) {
    return json_of(JSON("read", r->read_seconds), JSON("build", r->stats.build_seconds),
                   JSON("photons", r->stats.photon_seconds), JSON("render", r->stats.render_seconds),
                   JSON("write", r->write_seconds), JSON("total", r->total_seconds));
}

static json_t *pack_rays(const render_report *r) {
    const fathom_stats *s = &r->stats;
    return json_of(JSON("camera", s->camera_rays), JSON("shadow", s->shadow_rays),
                   JSON("reflection", s->reflection_rays), JSON("refraction", s->refraction_rays),
                   JSON("total", rays(r)), JSON("repaired", s->repaired_rays),
                   JSON("unlitShadow", s->unlit_shadow_rays), JSON("faintShadow", s->faint_shadow_rays));
}

/* "spp": the requested number; with sampling to an error, the maximum of a pixel. */
static json_t *pack_image(const render_report *r, const render_options *options) {
    const double error = r->stats.error_estimate;
    return json_of(JSON("width", r->width), JSON("height", r->height), JSON("spp", options->settings.spp),
                   JSON("meanSpp", mean_spp(r)),
                   JSON("errorEstimate", error > 0 ? json_number(error) : json_null()));
}

static const char *saved_to(const render_options *options) {
    return options->part.path ? options->part.path : options->checkpoint;
}

static json_t *pack_checkpoint(const fathom_stats *s, const char *path) {
    if (!path) return json_null();
    return json_of(JSON("file", path), JSON("saved", s->checkpoints), JSON("seconds", s->checkpoint_seconds),
                   JSON("resumed", (bool)(s->resumed_seconds > 0)),
                   JSON("resumedSeconds", s->resumed_seconds), JSON("resumedSamples", s->resumed_samples));
}

static json_t *pack_part(const fathom_part *part) {
    if (!part->path) return json_null();
    return json_of(JSON("index", part->index), JSON("count", part->count));
}

static json_t *pack_outputs(const render_options *options) {
    char room[PATH_MAX];
    const char *name;
    json_t *array = json_array();
    for (size_t i = 0; (name = images_shown(options, i, room)); ++i)
        json_array_append_new(array, json_text(name));
    return array;
}

static json_t *pack(const render_report *r, const render_options *options) {
    const fathom_stats *s = &r->stats;
    char fingerprint[24]; /* text, because most JSON readers cannot hold numbers of 64 bits */
    snprintf(fingerprint, sizeof fingerprint, "%016llx", (unsigned long long)s->scene_fingerprint);
    json_t *root = json_of(
        JSON("fathom", fathom_version()), JSON("commit", machine_commit()),
        JSON("command", provenance_arguments()), JSON("scene", r->scene),
        JSON("sceneFingerprint", fingerprint), JSON("image", pack_image(r, options)),
        JSON("outputs", pack_outputs(options)), JSON("exposure", options->write.exposure),
        JSON("interrupted", r->interrupted), JSON("checkpoint", pack_checkpoint(s, saved_to(options))),
        JSON("part", pack_part(&options->part)), JSON("triangles", s->triangles),
        JSON("placedTriangles", s->placed_triangles), JSON("primitives", s->primitives),
        JSON("instances", s->instances), JSON("degenerateTriangles", s->degenerate_triangles),
        JSON("seconds", pack_seconds(r)), JSON("rays", pack_rays(r)),
        JSON("raysPerSecond", rays_per_second(r)), JSON("peakMemoryBytes", peak_bytes()),
        JSON("bvhBytes", s->bvh_bytes), JSON("memory", pack_memory(r)),
        JSON("leftOut", left_out_json(&r->left_out)), JSON("warnings", warnings_json(&r->warnings)));
    add_tracer(root, s->tracer);
    return json_add(root, JSON("threads", s->threads));
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
    uint64_t peak = peak_bytes();
    printf("memory   %.1f MB at most, %.3g times meshes %.1f, BVH %.1f (at most %.1f), film %.1f and images "
           "%.1f",
           megabytes(peak), (double)peak / (double)needed_bytes(r), megabytes(s->mesh_bytes),
           megabytes(s->bvh_bytes), megabytes(s->bvh_peak_bytes), megabytes(s->film_bytes),
           megabytes(s->image_bytes));
    if (s->foreseen_bytes) printf("; %.0f were foreseen", megabytes(s->foreseen_bytes));
    putchar('\n');
}

static void print_checkpoint(const fathom_stats *s, const char *path) {
    if (!path) return;
    fputs("saved    to ", stdout);
    print_name(stdout, path);
    if (s->checkpoints)
        printf(", %u times, in %.3f s, while rendering went on", s->checkpoints, s->checkpoint_seconds);
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
    printf("seconds  read %.3f, build %.3f, photons %.3f, render %.3f, write %.3f, total %.3f\n",
           r->read_seconds, s->build_seconds, s->photon_seconds, s->render_seconds, r->write_seconds,
           r->total_seconds);
    printf("rays     camera %llu, shadow %llu, reflection %llu, refraction %llu; of them repaired %llu\n",
           (unsigned long long)s->camera_rays, (unsigned long long)s->shadow_rays,
           (unsigned long long)s->reflection_rays, (unsigned long long)s->refraction_rays,
           (unsigned long long)s->repaired_rays);
    printf("         shadow rays not cast: %llu unlit, %llu too faint\n",
           (unsigned long long)s->unlit_shadow_rays, (unsigned long long)s->faint_shadow_rays);
    print_memory(r);
    print_checkpoint(s, saved_to(options));
    left_out_print(&r->left_out, "left out ");
}

/* Prints whether the target is reached. A tile may also end above it because the samples that decide are not
 * those of the image (job/adaptive.h). With a time limit, or for a part of the image, this is not known. */
static void print_why_it_ended(const render_report *r, const fathom_settings *s) {
    if (!(s->target_error > 0) || r->stats.finished < 1) return;
    if (r->stats.error_estimate <= s->target_error)
        printf(" (target %g reached)", s->target_error);
    else if (s->max_time > 0)
        fputs(" (above the target when time was up)", stdout);
    else
        printf(" (above the target of %g: a tile may end a little above it, and has at most %u spp)",
               s->target_error, s->spp);
}

static void print_sampling(const render_report *r, const render_options *options) {
    double error = r->stats.error_estimate;
    if (!(error > 0)) {
        printf("%.5g spp", r->interrupted ? mean_spp(r) : options->settings.spp);
    } else if (isfinite(error)) {
        printf("%.1f spp, error %.2g", mean_spp(r), error);
        print_why_it_ended(r, &options->settings);
    } else {
        printf("%.1f spp, error unknown", mean_spp(r));
    }
}

void stats_print(const render_report *report, const render_options *options) {
    if (options->common.quiet) return;
    if (options->verbose) print_details(report, options);
    images_print(options);
    if (options->part.path) {
        print_name(stdout, options->part.path);
        printf(": part %u of %u", options->part.index, options->part.count);
    }
    printf(": %ux%u, ", report->width, report->height);
    print_sampling(report, options);
    brightness_print(options);
    printf(", %.2f s, %.1f Mrays/s", report->total_seconds, 1e-6 * rays_per_second(report));
    if (report->interrupted) printf(", interrupted at %u %%", (unsigned)(100 * report->finished));
    putchar('\n');
}
