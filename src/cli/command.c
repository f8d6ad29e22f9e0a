#include "cli/command.h"

#include "base/clock.h"
#include "base/text.h"
#include "cli/interrupt.h"
#include "cli/log.h"
#include "cli/notes.h"
#include "json/memory.h"

#include <string.h>
#include <sys/stat.h>

const command *const commands[] = {&command_render,
                                   &command_merge,
                                   &command_info,
                                   &command_generate,
                                   &command_convert,
                                   &command_texture,
                                   &command_compare,
                                   &command_validate,
                                   &command_bench,
                                   &command_help,
                                   NULL};

const command *command_find(const command *const *among, const char *name, args_problem *problem) {
    const char *names[sizeof commands / sizeof *commands];
    size_t count = 0;
    for (; among[count]; ++count) {
        const char *space = strchr(among[count]->name, ' ');
        names[count] = space ? space + 1 : among[count]->name;
        if (strcmp(name, names[count]) == 0) return among[count];
    }
    const char *nearest = args_nearest(name, names, count);
    if (nearest)
        args_wrong(problem, "unknown command \"%.60s\"; did you mean \"%s\"?", name, nearest);
    else
        args_wrong(problem, "unknown command \"%.60s\"%s", name,
                   among == commands && strchr(name, '.') ? "; fathom render FILE -o IMAGE renders a file"
                                                          : "");
    return NULL;
}

fathom_read_options command_read_options(const command_model *model) {
    static const double degree = 3.14159265358979323846 / 180;
    static const double metres[] = {0, 1e-3, 1e-2, 1e-1, 1e3, 0.0254, 0.3048}; /* of COMMAND_UNITS */
    return (fathom_read_options){.size = sizeof(fathom_read_options),
                                 .camera = model->camera,
                                 .up = model->up,
                                 .choose_azimuth = model->azimuth.given,
                                 .azimuth = model->azimuth.value * degree,
                                 .choose_elevation = model->elevation.given,
                                 .elevation = model->elevation.value * degree,
                                 .choose_time = model->time.given,
                                 .time = model->time.value,
                                 .shutter = model->shutter.value,
                                 .choose_shutter = model->shutter.given,
                                 .animations = model->animations.count ? model->animations.items : NULL,
                                 .variant = model->variant,
                                 .scene = model->scene,
                                 .unit = metres[model->unit]};
}

void print_name(FILE *out, const char *name) {
    char room[8192];
    snprintf(room, sizeof room, "%s", name);
    text_disarm(room);
    fputs(room, out);
}

void print_file_size(FILE *out, const char *path) {
    struct stat info;
    const double bytes = stat(path, &info) == 0 ? (double)info.st_size : 0;
    if (bytes < 1e6)
        fprintf(out, "%.1f kB", 1e-3 * bytes);
    else
        fprintf(out, "%.1f MB", 1e-6 * bytes);
}

void print_written(const char *path, double start) {
    print_name(stdout, path);
    fputs(": ", stdout);
    print_file_size(stdout, path);
    printf(", written in %.2f s\n", clock_seconds() - start);
}

fathom_status say_usage(const command *c, const char *text) {
    log_say(LOG_ERROR, "%s; see fathom help%s%s", text, c ? " " : "", c ? c->name : "");
    return FATHOM_BAD_USAGE;
}

fathom_status say_status(const command *c, const fathom_context *context, fathom_status status) {
    if (status == FATHOM_BAD_USAGE) return say_usage(c, fathom_context_message(context));
    if (status != FATHOM_OK) log_line(LOG_ERROR, fathom_context_message(context));
    return status;
}

bool command_parse(const command *c, int argc, char **argv, void *settings, fathom_status *status) {
    args_problem problem;
    *status = FATHOM_OK;
    switch (args_parse(&c->args, argc, argv, settings, &problem)) {
    case ARGS_READY: return true;
    case ARGS_HELP: help_command(c, stdout); return false;
    case ARGS_WRONG: *status = say_usage(c, problem.text); return false;
    }
    return false;
}

fathom_status command_context(const command_common *common, fathom_context **out) {
    fathom_status status = fathom_context_create(out);
    if (status != FATHOM_OK) {
        log_line(LOG_ERROR, "out of memory");
        return status;
    }
    json_memory_watch();
    fathom_context_set_threads(*out, common->threads);
    fathom_context_allow_outside(*out, common->allow_outside);
    fathom_context_on_warning(*out, warnings_say, NULL);
    return FATHOM_OK;
}

/* During the body, a signal ends the process. */
fathom_status command_run(const command *c, int argc, char **argv) {
    if (c->run) return c->run(argc, argv);
    _Alignas(max_align_t) char settings[COMMAND_SETTINGS_MOST];
    const command_common *common = (const void *)settings;
    fathom_context *context;
    fathom_status status;
    warning_list said = {.count = 0};
    memcpy(settings, c->defaults, c->size);
    if (!command_parse(c, argc, argv, settings, &status)) return status;
    status = command_context(common, &context);
    if (status != FATHOM_OK) return status;
    /* Some commands render a scene many times, each time with the same warnings. */
    fathom_context_on_warning(context, warnings_say_once, &said);
    interrupt_install();
    status = c->body(context, settings);
    fathom_context_destroy(context);
    warnings_free(&said);
    return status;
}
