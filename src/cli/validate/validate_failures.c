/* Writes failing rays as text: tracer, scene and the numbers of the ray as hexadecimal floats, which are
 * exact. Any-hit rays have "any-" before the verdict. Lines that begin with + follow: how the ray was traced
 * and the result, then all rays of the call. */
#include "cli/validate/validate.h"

#include "base/file.h"
#include "cli/validate/ray_line.h"

#include <limits.h>
#include <string.h>

#define LINE_ROOM 512
#define FAILURES_SHOWN 20
static int format_ray(const oracle_ray *r, char *out, size_t room) {
    return snprintf(out, room, "%a %a %a %a %a %a %a %a", (double)r->org.x, (double)r->org.y,
                    (double)r->org.z, (double)r->dir.x, (double)r->dir.y, (double)r->dir.z, (double)r->t_near,
                    (double)r->t_far);
}

/* A whole line except the scene's name, which may be long. */
static void format_line(const char *spec, const compare_failure *f, char line[LINE_ROOM]) {
    int length =
        snprintf(line, LINE_ROOM, "%.100s %s %llu %s%s ", spec, rays_family_name(f->family),
                 (unsigned long long)f->index, f->block.any ? RAY_LINE_ANY : "", verdict_name(f->verdict));
    length += format_ray(&f->block.rays[f->block.lane], line + length, LINE_ROOM - (size_t)length);
    snprintf(line + length, LINE_ROOM - (size_t)length, " ");
}

static const char *way_name(unsigned way) {
    return way == COMPARE_FIRST ? "first" : way == ASK_REPAIRED ? "repaired" : ask_way_name(way);
}

static void put_block(file_writer *writer, const compare_failure *f) {
    char line[LINE_ROOM];
    const ask_block *b = &f->block;
    const verdict_answer *hit = &f->answer.hit;
    file_writer_print(writer, "+ %s %u %u %u %u %u %u %a %u\n", way_name(f->way), (unsigned)b->coherence,
                      b->lane, b->lanes, hit->geometry, hit->primitive, hit->instance, hit->t,
                      (unsigned)f->answer.met);
    for (unsigned i = 0; i < b->lanes; ++i) {
        format_ray(&b->rays[i], line, sizeof line);
        file_writer_print(writer, "+%s\n", line);
    }
}

static void put_line(file_writer *writer, const char *spec, const char *scene, const compare_failure *f) {
    char line[LINE_ROOM];
    format_line(spec, f, line);
    file_writer_print(writer, "%s%s\n", line, scene);
    put_block(writer, f);
}

static void put_extreme(file_writer *writer, const extremes_failure *f) {
    char scene[128];
    snprintf(scene, sizeof scene, VALIDATE_EXTREME "%s:%.17g", f->group, f->parameter);
    put_line(writer, f->spec, scene, &f->failure);
}

json_t *validate_failures_json(const validate_run *run) {
    json_t *lines = json_array();
    for (size_t i = 0; i < run->result.failures.count && json_array_size(lines) < FAILURES_SHOWN; ++i) {
        const compare_failure *f = &run->result.failures.items[i];
        if (f->verdict != VERDICT_WRONG) continue;
        char line[LINE_ROOM + PATH_MAX];
        format_line(run->spec, f, line);
        size_t length = strlen(line);
        snprintf(line + length, sizeof line - length, "%s", run->scene);
        json_array_append_new(lines, json_text(line));
    }
    return lines;
}

fathom_status validate_write_failures(fathom_context *context, const validate_results *results,
                                      const validate_settings *settings) {
    file_writer *writer;
    fathom_status status = file_writer_open(context, settings->failures, &writer);
    if (status != FATHOM_OK) return status;
    file_writer_print(writer,
                      "# fathom failing rays: tracer family index verdict org dir t_near t_far scene\n");
    for (size_t i = 0; i < results->runs.count; ++i) {
        const validate_run *run = &results->runs.items[i];
        for (size_t k = 0; k < run->result.failures.count; ++k)
            put_line(writer, run->spec, run->scene, &run->result.failures.items[k]);
    }
    for (size_t i = 0; i < results->extremes_failures.count; ++i)
        put_extreme(writer, &results->extremes_failures.items[i]);
    return file_writer_commit(writer);
}

/* ---- replay ---- */

typedef struct replay {
    const validate_settings *settings;
    judged_scene stage;
    char scene[4096], spec[128]; /* that are open; "" at the start */
    trace_tracer *tracer;
    compare_subject subject;
    uint64_t rays, wrong, given; /* given: number of results equal to the recorded ones */
} replay;

/* Unlike the command line, a file is not trusted: scenes must lie in the working folder, and no code is run.
 * Names of extreme cases and built-in scenes have no slash, so they pass this check too. */
static fathom_status check_names(fathom_context *context, const replay *r, const ray_line *line) {
    trace_spec spec;
    fathom_status status = FATHOM_OK;
    if (!r->settings->scene) status = file_confine(context, "", line->scene, line->scene);
    if (status != FATHOM_OK || r->settings->tracers.count) return status;
    status = trace_spec_parse(context, line->spec, &spec);
    if (status == FATHOM_BAD_USAGE) return FATHOM_BAD_INPUT; /* the wrong usage is in the file */
    if (status != FATHOM_OK || spec.kind != TRACE_PLUGIN) return status;
    return fail(context, FATHOM_BAD_INPUT,
                "the tracer %s is a library; a file may not choose what code runs: expected --tracer %s",
                line->spec, line->spec);
}

/* Opens the scene and the tracer of the line, unless they are open already. */
static fathom_status open_subject(fathom_context *context, replay *r, const ray_line *line) {
    fathom_status allowed = check_names(context, r, line);
    if (allowed != FATHOM_OK) return allowed;
    const char *scene = r->settings->scene ? r->settings->scene : line->scene;
    const char *spec = r->settings->tracers.count ? r->settings->tracers.items[0] : line->spec;
    bool same = strcmp(scene, r->scene) == 0;
    if (same && strcmp(spec, r->spec) == 0) return FATHOM_OK;
    trace_destroy(r->tracer);
    r->tracer = NULL;
    fathom_status status = FATHOM_OK;
    if (!same) {
        judged_close(&r->stage);
        snprintf(r->scene, sizeof r->scene, "%s", scene);
        status = validate_stage_open(context, scene, &r->stage);
    }
    snprintf(r->spec, sizeof r->spec, "%s", spec);
    if (status == FATHOM_OK) status = validate_subject(context, &r->stage, r->spec, &r->subject, &r->tracer);
    return status;
}

static void print_answer(const verdict_answer *a) {
    if (a->geometry == FATHOM_NONE)
        printf("miss");
    else
        printf("geometry %u primitive %u instance %d t %a", a->geometry, a->primitive, (int)a->instance,
               a->t);
}

static bool print_exact(const replay *r, const ray_line *line) {
    search_result room = {.ties = {.count = 0}};
    bool fine = (line->any ? search_shadow : search_closest)(r->stage.search, &line->ray, &room);
    if (fine && room.ties.count) {
        const search_hit *hit = &room.ties.items[0];
        print_answer(
            &(verdict_answer){hit->geometry, hit->primitive, hit->instance, (double)hit->answer.t, 0});
        if (room.ties.count > 1) printf(" (%zu at this t)", room.ties.count);
    } else {
        printf("miss");
    }
    search_result_free(&room);
    return fine;
}

static void print_head(const replay *r, const ray_line *line, verdict v) {
    print_name(stdout, r->scene);
    printf(" %s %s %llu: %s%s\n  tracer: ", r->spec, line->family, line->index, line->any ? RAY_LINE_ANY : "",
           verdict_name(v));
}

/* The original call; for a line without one, the ray alone. */
static ask_block block_of(const ray_line *line) {
    if (line->has_block) return line->block;
    return (ask_block){.rays = {line->ray}, .lanes = 1, .any = line->any};
}

static void print_given(const ray_line *line, bool again) {
    if (!line->has_block) return;
    printf("\n  given:  ");
    if (line->any)
        printf(line->given.met ? "met" : "miss");
    else
        print_answer(&line->given.hit);
    printf(", by %s%s", line->way, again ? "" : ": no longer");
}

static fathom_status replay_one(fathom_context *context, replay *r, const ray_line *line) {
    const ask_block block = block_of(line);
    const oracle_ray *ray = &block.rays[block.lane];
    const ask_answer answer = ask_block_again(r->subject.tracer, &block);
    verdict_report report;
    error_report errors;
    search_result room = {.ties = {.count = 0}};
    bool judged = compare_judge(&r->subject, ray, &answer, line->any, &room, &report, &errors);
    search_result_free(&room);
    if (!judged) return fail_memory(context, 1);
    const bool again = line->has_block && ask_alike(&line->given, &answer, line->any);
    ++r->rays, r->given += again;
    r->wrong += report.verdict == VERDICT_WRONG;
    if (r->settings->common.quiet) return FATHOM_OK;
    print_head(r, line, report.verdict);
    if (line->any && answer.met)
        printf("met");
    else
        print_answer(line->any ? &(verdict_answer){.geometry = FATHOM_NONE} : &answer.hit);
    print_given(line, again);
    printf("\n  exact:  ");
    bool fine = print_exact(r, line);
    putchar('\n');
    return fine ? FATHOM_OK : fail_memory(context, 1);
}

static fathom_status replay_ray(fathom_context *context, replay *r, const ray_line *line) {
    fathom_status status = open_subject(context, r, line);
    const ask_block block = block_of(line);
    for (unsigned i = 0; i < block.lanes && status == FATHOM_OK; ++i) {
        if (!rays_allowed(r->stage.source, &block.rays[i]))
            return fail(context, FATHOM_BAD_INPUT, "the ray has no direction or is out of range");
    }
    return status == FATHOM_OK ? replay_one(context, r, line) : status;
}

static fathom_status replay_text(fathom_context *context, replay *r, const file_map *map) {
    const char *text = (const char *)map->bytes;
    ray_lines lines = {context, r->settings->replay, text, text + map->size, 0};
    for (;;) {
        ray_line line;
        bool found;
        fathom_status status = ray_lines_next(&lines, &line, &found);
        if (status != FATHOM_OK || !found) return status;
        status = replay_ray(context, r, &line);
        if (status == FATHOM_BAD_INPUT)
            return fail_within(context, status, &(fathom_place){.file = lines.path, .line = lines.number});
        if (status != FATHOM_OK) return status;
    }
}

static void print_sums(const replay *r) {
    printf("%llu rays, %llu wrong", (unsigned long long)r->rays, (unsigned long long)r->wrong);
    if (!r->settings->tracers.count || r->given)
        printf(", %llu with the answer that was given", (unsigned long long)r->given);
    putchar('\n');
}

fathom_status validate_replay(fathom_context *context, const validate_settings *settings) {
    replay r = {.settings = settings};
    file_map map;
    fathom_status status = file_open(context, settings->replay, &map);
    if (status != FATHOM_OK) return status;
    status = replay_text(context, &r, &map);
    status = file_finish(context, &map, status);
    trace_destroy(r.tracer);
    judged_close(&r.stage);
    if (status != FATHOM_OK) return status;
    if (!settings->common.quiet) print_sums(&r);
    return r.wrong ? FATHOM_CHECK_FAILED : FATHOM_OK;
}
