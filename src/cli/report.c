#include "cli/report.h"

#include "cli/fail.h"
#include "cli/json_text.h"
#include "cli/outputs.h"

#include <errno.h>
#include <fathom/file.h>
#include <fcntl.h>
#include <limits.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Marks a page as ours: html_page.py writes it at the beginning. */
#define GENERATOR "<meta name=\"generator\" content=\"fathom"

/* The script's path relative to the program's folder, in the build tree and in installations. */
#define SCRIPT "../share/fathom/report/report.py"

static void report_paths(const char *folder, char *page, char *results) {
    snprintf(page, PATH_MAX, "%s/index.html", folder);
    snprintf(results, PATH_MAX, "%s/results.json", folder);
}

/* ---- the script ---- */

static bool script_path(char path[PATH_MAX]) {
    char program[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", program, sizeof program - sizeof SCRIPT);
    if (length <= 0) return false;
    program[length] = '\0';
    char *slash = strrchr(program, '/');
    memcpy(slash + 1, SCRIPT, sizeof SCRIPT);
    return realpath(program, path) != NULL;
}

/* Returns the script's exit code; -1 if it could not be started. silent: discards its messages, which matter
 * only when it draws. */
static int run_script(char *const arguments[], bool silent) {
    posix_spawn_file_actions_t actions;
    pid_t child;
    int status;
    if (posix_spawn_file_actions_init(&actions) != 0) return -1;
    if (silent) posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    int failed = posix_spawn(&child, FATHOM_PYTHON, &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed) return -1;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/* -E -s: the environment and the user's own packages do not affect the drawing; -B: writes nothing next to
 * the script. */
static fathom_status check_drawable(fathom_context *context) {
    char script[PATH_MAX];
    if (!script_path(script))
        return cli_fail(
            context, FATHOM_OUT_OF_RESOURCES,
            "report: %s was not found from the folder of the program; --json writes the same results",
            SCRIPT);
    char *arguments[] = {(char[]){FATHOM_PYTHON}, (char[]){"-EsB"}, script, (char[]){"--check"}, NULL};
    if (run_script(arguments, true) == 0) return FATHOM_OK;
    return cli_fail(context, FATHOM_OUT_OF_RESOURCES,
                    "report: pages are drawn by %s with matplotlib, and one of them is missing: apt-get "
                    "install python3-matplotlib; --json writes the same results",
                    FATHOM_PYTHON);
}

/* ---- the folder ---- */

static fathom_status check_ours(fathom_context *context, const char *path) {
    char head[512];
    FILE *file = fopen(path, "rb");
    if (!file) {
        if (errno == ENOENT) return FATHOM_OK;
        return cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, path, "cannot be replaced: %s",
                             strerror(errno));
    }
    size_t size = fread(head, 1, sizeof head - 1, file);
    head[size] = '\0';
    fclose(file);
    if (size == 0 || strstr(head, GENERATOR)) return FATHOM_OK;
    return cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, path,
                         "is there already and is no report of fathom; remove it or name another folder");
}

/* A folder that does not exist is checked like a new file in its parent. */
static fathom_status check_new(fathom_context *context, const char *folder) {
    char name[PATH_MAX];
    size_t length = strlen(folder);
    while (length > 1 && folder[length - 1] == '/') --length;
    snprintf(name, sizeof name, "%.*s", (int)length, folder);
    return fathom_file_check(context, name);
}

static fathom_status check_folder(fathom_context *context, const char *folder) {
    struct stat info;
    char page[PATH_MAX], results[PATH_MAX];
    if (stat(folder, &info) != 0) return check_new(context, folder);
    if (!S_ISDIR(info.st_mode))
        return cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, folder,
                             "is a file; expected a folder for the report");
    report_paths(folder, page, results);
    fathom_status status = fathom_file_check(context, page);
    return status == FATHOM_OK ? check_ours(context, page) : status;
}

static fathom_status check_report(fathom_context *context, const char *folder) {
    if (strlen(folder) > PATH_MAX - 32)
        return cli_fail(context, FATHOM_BAD_USAGE, "%.60s…: the name is too long", folder);
    fathom_status status = check_folder(context, folder);
    return status == FATHOM_OK ? check_drawable(context) : status;
}

fathom_status report_check_files(fathom_context *context, const char *const files[2], const char *report,
                                 const char *input) {
    char page[PATH_MAX], results[PATH_MAX];
    const char *paths[4];
    size_t found = 0;
    fathom_status status = standard_output_begin(context, &(args_list){.count = 0}, files, 2);
    for (size_t i = 0; i < 2; ++i)
        if (files[i] && !outputs_is_standard(files[i])) paths[found++] = files[i];
    for (size_t i = 0; i < found && status == FATHOM_OK; ++i) status = fathom_file_check(context, paths[i]);
    if (status == FATHOM_OK && report) status = check_report(context, report);
    if (status != FATHOM_OK) return status;
    if (report) report_paths(report, page, results), paths[found++] = page, paths[found++] = results;
    return outputs_check_distinct(context, paths, found, input);
}

fathom_status report_write(fathom_context *context, const char *folder, const json_t *results) {
    char script[PATH_MAX], page[PATH_MAX], data[PATH_MAX];
    fathom_status status = check_folder(context, folder);
    if (status != FATHOM_OK) return status;
    if (mkdir(folder, 0777) != 0 && errno != EEXIST)
        return cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, folder, "cannot be made: %s", strerror(errno));
    report_paths(folder, page, data);
    status = json_write_file(context, data, results);
    if (status != FATHOM_OK) return status;
    char *arguments[] = {(char[]){FATHOM_PYTHON}, (char[]){"-EsB"}, script, data, page, NULL};
    if (script_path(script) && run_script(arguments, false) == 0) return FATHOM_OK;
    return cli_fail_file(context, FATHOM_OUT_OF_RESOURCES, page, "could not be drawn; the results are in %s",
                         data);
}
