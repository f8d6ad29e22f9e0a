/* Runs a command once for every place that asks for memory, which fails there, and judges how it ends.
 * usage: each [-1] [-s STEP[/OF]] [-o OUTPUT]... LIBRARY COMMAND ARGUMENT...
 *   LIBRARY  oom.so, loaded into the command; see oom.c
 *   -o FILE  is written by the command: where it ends with 0, it must hold what it holds without faults
 *   -w FILE  is written too, and may hold anything
 *   -k TEXT  who ends badly with it, on stderr, among the calls or in the verdict, is known to: counted, no
 * failure -c PROGRAM  files that differ are the same where PROGRAM compare -q says so: images hold the hour
 *   -r FILE  pixels that were saved elsewhere are those of this image (without: of an output)
 *   -t       standard output too is the same each time
 *   -a       from the place on, all requests fail (without: that one)
 *   -n       every request by its number (without: places by the calls that lead there)
 *   -s K/N   every N-th of them alone, from the K-th
 *   -x TEXT  leaves out places that calls lead to in which the text occurs; may be given several times
 *   -i TEXT  leaves out all others
 *   -l FILE  appends what ended badly, with the calls that led there
 * Works in the current folder, which must hold nothing that the command does not read.
 *
 * A run is refused: exit code 4, a message, no file left; or unharmed: exit code 0 and the same output, since
 * what asked could do without. Anything else is bad. Prints one line of counts; exit code 1 if any was bad.
 */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define TIMES_MAX 8 /* how often an option may be given */
#define SECONDS_MAX 60

static struct {
    const char *outputs[TIMES_MAX], *expected[TIMES_MAX];
    unsigned expected_count;
    bool varies[TIMES_MAX];
    unsigned output_count;
    bool same_stdout, all_after, by_number;
    unsigned long step, of;
    const char *without[TIMES_MAX];
    unsigned without_count;
    const char *log, *library, *only, *comparing, *rescued;
    char **command;
} options = {.of = 1};

static _Noreturn void stop(const char *what, const char *name) {
    fprintf(stderr, "each: %s: %s\n", name, what);
    exit(2);
}

/* ---- files ---- */

typedef struct bytes {
    char *data;
    size_t size;
} bytes;

static bytes contents(const char *path) {
    bytes b = {NULL, 0};
    FILE *file = fopen(path, "rb");
    if (!file) return b;
    size_t room = 0, got;
    do {
        if (b.size == room) b.data = realloc(b.data, room = room ? 2 * room : 65536);
        if (!b.data) stop("out of memory", path);
        b.size += got = fread(b.data + b.size, 1, room - b.size, file);
    } while (got);
    fclose(file);
    return b;
}

static bool same(bytes a, bytes b) {
    return a.data && b.data && a.size == b.size && memcmp(a.data, b.data, a.size) == 0;
}

#define FILES_MAX 64
static char known[FILES_MAX][256];
static unsigned known_count;

static bool is_known(const char *name) {
    for (unsigned i = 0; i < known_count; ++i) {
        if (strcmp(known[i], name) == 0) return true;
    }
    return false;
}

static bool is_output(const char *name) {
    for (unsigned i = 0; i < options.output_count; ++i) {
        if (strcmp(options.outputs[i], name) == 0) return true;
    }
    return false;
}

static bool holds_image(const char *name);

/* Learns the names of all files there are; or removes those that are new and no output: true if there were
 * any, but for pixels that were saved where an image could not be written. */
static bool files(bool learn_them) {
    bool any = false;
    DIR *folder = opendir(".");
    if (!folder) stop(strerror(errno), ".");
    for (const struct dirent *entry; (entry = readdir(folder));) {
        if (is_known(entry->d_name) || is_output(entry->d_name)) continue;
        if (!learn_them) {
            any |= !(strstr(entry->d_name, ".rescue.") && holds_image(entry->d_name));
            unlink(entry->d_name);
        }
        if (learn_them && known_count < FILES_MAX)
            strcpy(known[known_count++], entry->d_name);
        else if (learn_them)
            stop("too many files", ".");
    }
    closedir(folder);
    return any;
}

/* ---- a run ---- */

#define OUT "each.out"
#define ERR "each.err"
#define REPORT "each.report"

typedef struct ending {
    int status; /* as waitpid() tells it */
    bool late;
} ending;

static void redirect(const char *path, int to) {
    int descriptor = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    if (descriptor < 0 || dup2(descriptor, to) < 0) _exit(126);
    close(descriptor);
}

static ending run(const char *fault) {
    unlink(REPORT);
    for (unsigned i = 0; i < options.output_count; ++i) unlink(options.outputs[i]);
    redirect(REPORT, 9); /* so that these files are there before the run and after it */
    close(9);
    pid_t child = fork();
    if (child < 0) stop(strerror(errno), "fork");
    if (child == 0) {
        redirect(OUT, STDOUT_FILENO), redirect(ERR, STDERR_FILENO);
        setenv("LD_PRELOAD", options.library, 1);
        setenv("FATHOM_OOM", fault, 1);
        setenv("FATHOM_OOM_REPORT", REPORT, 1);
        execvp(options.command[0], options.command);
        _exit(126);
    }
    ending e = {0, false};
    struct timespec pause = {0, 2000000};
    for (unsigned waited = 0; waitpid(child, &e.status, WNOHANG) == 0; ++waited) {
        if (waited == SECONDS_MAX * 500) e.late = kill(child, SIGKILL) == 0;
        nanosleep(&pause, NULL);
    }
    return e;
}

/* ---- the verdict ---- */

static bytes good[TIMES_MAX], good_stdout;

/* The good one beside the outputs, under a name with the same extension. */
static const char *good_name(unsigned i) {
    static char name[256];
    snprintf(name, sizeof name, "good.%u.%.200s", i, options.outputs[i]);
    return name;
}

static bool seem_same(const char *good_one, const char *name, const char *tolerance) {
    if (!options.comparing) return false;
    pid_t child = fork();
    if (child == 0) {
        execlp(options.comparing, options.comparing, "compare", "-q", good_one, name, "--tolerance",
               tolerance, NULL);
        _exit(126);
    }
    int status = -1;
    waitpid(child, &status, 0);
    return status == 0;
}

/* Saved pixels are floats where the image has halves, which are rounded by up to 2^-12 of a value: 2^-8 does
 * for values up to 16. */
static bool holds_image(const char *name) {
    static const char tolerance[] = "0.00390625";
    bool found = options.rescued && seem_same(options.rescued, name, tolerance);
    for (unsigned i = 0; i < options.output_count && !options.rescued; ++i)
        found |= seem_same(good_name(i), name, tolerance);
    return found;
}

static const char *judge_done(void) {
    for (unsigned i = 0; i < options.output_count; ++i) {
        bytes now = contents(options.outputs[i]);
        bool fits = same(now, good[i]) || (options.varies[i] && now.data) ||
                    seem_same(good_name(i), options.outputs[i], "0");
        free(now.data);
        if (!fits) return "exit code 0 and another output";
    }
    bytes now = contents(OUT);
    bool fits = !options.same_stdout || same(now, good_stdout);
    free(now.data);
    return fits ? NULL : "exit code 0 and other words";
}

static const char *judge_refused(bool left) {
    static char text[400];
    bytes said = contents(ERR);
    bool told = said.size && memmem(said.data, said.size, "fathom: ", 8);
    free(said.data);
    if (!told) return "exit code 4 without a message";
    for (unsigned i = 0; i < options.output_count; ++i) {
        snprintf(text, sizeof text, "exit code 4 and %s is there", options.outputs[i]);
        if (access(options.outputs[i], F_OK) == 0) return text;
    }
    return left ? "exit code 4 and a file is left" : NULL;
}

/* NULL: it ended as it should. */
static const char *judge(ending e, bool left, bool *refused) {
    static char text[80];
    *refused = false;
    if (e.late) return "it hangs";
    int code = WIFEXITED(e.status) ? WEXITSTATUS(e.status) : -1;
    if (code == 0) return judge_done();
    *refused = code == 4;
    if (code == 4) return judge_refused(left);
    if (code >= 0)
        snprintf(text, sizeof text, "exit code %d", code);
    else
        snprintf(text, sizeof text, "ended by signal %d", WTERMSIG(e.status));
    return text;
}

/* ---- all places ---- */

typedef struct tally {
    unsigned long places, reached, refused, unharmed, known, bad;
} tally;

static void tell_bad(const char *what, const char *fault, const char *place) {
    FILE *log = options.log ? fopen(options.log, "a") : stdout;
    if (!log) stop(strerror(errno), options.log);
    bytes said = contents(ERR);
    fprintf(log, "BAD %s: %s\n  %s\n  stderr: %.*s\n", fault, what, place,
            (int)(said.size < 600 ? said.size : 600), said.data ? said.data : "");
    free(said.data);
    if (options.log)
        fclose(log);
    else
        fflush(log);
}

static bool is_expected(const char *what, const char *place) {
    bool found = false;
    bytes said = contents(ERR);
    for (unsigned i = 0; i < options.expected_count; ++i) {
        const char *text = options.expected[i];
        found |= strstr(what, text) || strstr(place, text) ||
                 (said.size && memmem(said.data, said.size, text, strlen(text)));
    }
    free(said.data);
    return found;
}

static void try_one(const char *fault, const char *place, tally *t) {
    ++t->places;
    ending e = run(fault);
    bool refused, reached;
    bytes report = contents(REPORT);
    reached = report.size >= 6 && memmem(report.data, report.size, "failed", 6);
    free(report.data);
    const char *what = judge(e, files(false), &refused);
    t->reached += reached;
    if (!what) {
        t->refused += refused;
        t->unharmed += !refused;
        return;
    }
    if (is_expected(what, place)) {
        ++t->known;
        return;
    }
    ++t->bad;
    tell_bad(what, fault, place);
}

static void learn(void) {
    ending e = run("count");
    if (e.late || !WIFEXITED(e.status) || WEXITSTATUS(e.status) != 0)
        stop("does not end with exit code 0 without any fault; see " ERR, options.command[0]);
    for (unsigned i = 0; i < options.output_count; ++i) {
        good[i] = contents(options.outputs[i]);
        if (!good[i].data || rename(options.outputs[i], good_name(i)) != 0)
            stop("was not written", options.outputs[i]);
    }
    good_stdout = contents(OUT);
}

static bool is_chosen(unsigned long index) { return index % options.of == options.step; }

static bool is_left_out(const char *place) {
    bool out = options.only && !strstr(place, options.only);
    for (unsigned i = 0; i < options.without_count; ++i) out |= strstr(place, options.without[i]) != NULL;
    return out;
}

static void try_numbers(const char *report, tally *t) {
    const char *total = strstr(report, "total ");
    unsigned long count = total ? strtoul(total + 6, NULL, 10) : 0;
    for (unsigned long n = 1; n <= count; ++n) {
        char fault[64];
        snprintf(fault, sizeof fault, "%s:%lu", options.all_after ? "from" : "once", n);
        if (is_chosen(n)) try_one(fault, "", t);
    }
}

static void try_sites(char *report, tally *t) {
    unsigned long index = 0;
    for (char *line = report, *end; (end = strchr(line, '\n')); line = end + 1) {
        *end = '\0';
        if (strncmp(line, "site ", 5) != 0 || is_left_out(line)) continue;
        char fault[64];
        snprintf(fault, sizeof fault, "%s:%.16s", options.all_after ? "after" : "at", line + 5);
        if (is_chosen(index++)) try_one(fault, line, t);
    }
}

static void parse(int argc, char **argv) {
    int letter;
    while ((letter = getopt(argc, argv, "+o:w:k:tans:l:x:i:c:r:")) != -1) {
        switch (letter) {
        case 'o':
        case 'w':
            if (options.output_count == TIMES_MAX) stop("too many outputs", optarg);
            options.varies[options.output_count] = letter == 'w';
            options.outputs[options.output_count++] = optarg;
            break;
        case 'k':
            if (options.expected_count < TIMES_MAX) options.expected[options.expected_count++] = optarg;
            break;
        case 't': options.same_stdout = true; break;
        case 'a': options.all_after = true; break;
        case 'n': options.by_number = true; break;
        case 's':
            if (sscanf(optarg, "%lu/%lu", &options.step, &options.of) != 2 || !options.of)
                stop("expected -s K/N", argv[0]);
            break;
        case 'c': options.comparing = optarg; break;
        case 'r': options.rescued = optarg; break;
        case 'x':
            if (options.without_count == TIMES_MAX) stop("too many of -x", optarg);
            options.without[options.without_count++] = optarg;
            break;
        case 'i': options.only = optarg; break;
        case 'l': options.log = optarg; break;
        default: stop("wrong usage; see each.c", argv[0]);
        }
    }
    if (optind + 1 >= argc) stop("expected a library and a command", argv[0]);
    options.library = argv[optind];
    options.command = argv + optind + 1;
}

int main(int argc, char **argv) {
    parse(argc, argv);
    learn();
    bytes report = contents(REPORT);
    char *text = calloc(report.size + 1, 1);
    if (!text) stop("out of memory", REPORT);
    memcpy(text, report.data, report.size);
    files(true);
    tally t = {0};
    if (options.by_number)
        try_numbers(text, &t);
    else
        try_sites(text, &t);
    printf("%lu places, %lu failed, %lu refused, %lu unharmed, %lu known to end badly, %lu bad\n", t.places,
           t.reached, t.refused, t.unharmed, t.known, t.bad);
    free(report.data), free(text);
    for (unsigned i = 0; i < options.output_count; ++i) unlink(good_name(i));
    return t.bad ? 1 : 0;
}
