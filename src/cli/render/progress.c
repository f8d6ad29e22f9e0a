#include "cli/render/progress.h"

#include "base/clock.h"
#include "cli/log.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

typedef enum display { DISPLAY_NONE, DISPLAY_LINES, DISPLAY_BAR, DISPLAY_JSON } display;

/* Global, because a process has one stderr. */
static struct {
    display display;
    bool drawn;      /* the terminal shows a bar */
    unsigned tenths; /* last tenth printed in this phase */
    fathom_phase phase;
    double seconds;   /* time of the last JSON line of this phase; < 0: none yet */
    const char *work; /* name of the rendering phase */
} state = {.work = "render"};

/* Shorter runs print no lines. */
#define LINES_AFTER_SECONDS 1.0
/* Seconds between JSON lines of one phase. */
#define JSON_EVERY_SECONDS 1.0
/* Shorter work needs no estimate. */
#define ESTIMATE_FROM_SECONDS 10.0

static display choose_display(bool quiet) {
    const char *terminal = getenv("TERM");
    bool dumb = !terminal || strcmp(terminal, "dumb") == 0;
    if (quiet) return DISPLAY_NONE;
    if (log_is_json()) return DISPLAY_JSON;
    return isatty(STDERR_FILENO) && !dumb ? DISPLAY_BAR : DISPLAY_LINES;
}

static void begin_phase(fathom_phase phase) {
    state.phase = phase;
    state.tenths = 0;
    state.seconds = -1;
}

void progress_begin(bool quiet, const char *work) {
    state.display = choose_display(quiet);
    state.drawn = false;
    state.work = work;
    begin_phase(FATHOM_PHASE_READ);
}

static const char *phase_name(fathom_phase phase) {
    switch (phase) {
    case FATHOM_PHASE_READ: return "read";
    case FATHOM_PHASE_BUILD: return "build";
    case FATHOM_PHASE_RENDER: return state.work;
    case FATHOM_PHASE_WRITE: return "write";
    case FATHOM_PHASE_PHOTONS: return "photons";
    }
    return "";
}

static unsigned columns(void) {
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
    return 80;
}

const char *progress_clear_text(void) { return state.display == DISPLAY_BAR ? "\r\033[K" : ""; }

void progress_clear_line(void) {
    if (!state.drawn) return;
    fputs(progress_clear_text(), stderr);
    state.drawn = false;
}

static double clamp_fraction(double fraction) { return fraction > 0 ? fraction < 1 ? fraction : 1 : 0; }

/* Rounded down: 100 means done. */
static unsigned percent(const fathom_progress *p) { return (unsigned)(100 * clamp_fraction(p->fraction)); }

static double rays_per_second(const fathom_progress *p) {
    return p->seconds > 0 ? (double)p->rays / p->seconds : 0;
}

/* Estimated from the progress so far; < 0: unknown. */
static double seconds_left(const fathom_progress *p) {
    double fraction = clamp_fraction(p->fraction);
    return fraction > 0 && p->seconds > 0.2 ? p->seconds * (1 - fraction) / fraction : -1;
}

/* "0:12", "1:00:12" */
static void put_clock(double seconds, char *out, size_t size) {
    unsigned whole = seconds < 359998 ? (unsigned)(seconds + 0.5) : 359999;
    if (whole < 3600)
        snprintf(out, size, "%u:%02u", whole / 60, whole % 60);
    else
        snprintf(out, size, "%u:%02u:%02u", whole / 3600, whole / 60 % 60, whole % 60);
}

/* ", 45.2 Mrays/s, 0:12 left, error 0.019"; each part only if it is known. */
static void put_rate(const fathom_progress *p, char *out, size_t size) {
    char rate[32] = "", clock[16], left[32] = "", error[32] = "";
    if (p->rays && p->seconds > 0) {
        double rays = rays_per_second(p);
        bool many = rays >= 1e5; /* 0.1 M */
        snprintf(rate, sizeof rate, ", %.1f %crays/s", rays * (many ? 1e-6 : 1e-3), many ? 'M' : 'k');
    }
    if (seconds_left(p) >= 0) {
        put_clock(seconds_left(p), clock, sizeof clock);
        snprintf(left, sizeof left, ", %s left", clock);
    }
    if (p->error > 0 && isfinite(p->error)) snprintf(error, sizeof error, ", error %.2g", p->error);
    snprintf(out, size, "%s%s%s", rate, left, error);
}

void progress_line(const fathom_progress *p, char *out, size_t size) {
    char rate[96];
    put_rate(p, rate, sizeof rate);
    snprintf(out, size, "%s %u %%%s", phase_name(p->phase), percent(p), rate);
}

/* "render  47% [=======>        ] 45.2 Mrays/s, 0:12 left". The line is cut at the right edge. The length of
 * the bar depends only on the number of columns, so that it stays constant. */
#define BAR_LEAST 10u
#define BAR_MOST 50u
#define BAR_OTHERS 46u /* length of the other text, up to "render 100% [] 12345.6 Mrays/s, 10:00:00 left" */

void progress_bar(const fathom_progress *p, unsigned width, char *out, size_t size) {
    char rate[96], cells[BAR_MOST + 1];
    put_rate(p, rate, sizeof rate);
    size_t room = width ? width - 1 : 0;
    if (room >= size) room = size - 1;
    size_t bar = room > BAR_OTHERS + BAR_LEAST ? room - BAR_OTHERS : BAR_LEAST;
    if (bar > BAR_MOST) bar = BAR_MOST;
    size_t full = (size_t)(clamp_fraction(p->fraction) * (double)bar);
    for (size_t i = 0; i < bar; ++i) cells[i] = i < full ? '=' : i == full ? '>' : ' ';
    cells[bar] = '\0';
    snprintf(out, room + 1, "%-6s %3u%% [%s] %s", phase_name(p->phase), percent(p), cells,
             *rate ? rate + 2 : rate);
}

static void print_line(const fathom_progress *p) {
    unsigned tenths = (unsigned)(10 * clamp_fraction(p->fraction));
    if (p->seconds < LINES_AFTER_SECONDS || tenths <= state.tenths) return;
    char text[160];
    progress_line(p, text, sizeof text);
    log_line(LOG_INFO, text);
    state.tenths = tenths;
}

static void print_json(const fathom_progress *p) {
    const bool ends = p->fraction >= 1 && state.tenths < 10;
    if (state.seconds >= 0 && p->seconds < state.seconds + JSON_EVERY_SECONDS && !ends) return;
    char text[160], members[320], left[48] = "", error[48] = "";
    progress_line(p, text, sizeof text);
    if (seconds_left(p) >= 0) snprintf(left, sizeof left, ", \"secondsLeft\": %.3g", seconds_left(p));
    if (p->error > 0 && isfinite(p->error)) snprintf(error, sizeof error, ", \"error\": %.3g", p->error);
    snprintf(members, sizeof members,
             "\"phase\": \"%s\", \"fraction\": %.4f, \"seconds\": %.3f, \"raysPerSecond\": %.4g%s%s",
             phase_name(p->phase), clamp_fraction(p->fraction), p->seconds, rays_per_second(p), left, error);
    log_line_with(LOG_INFO, text, members);
    state.seconds = p->seconds;
    state.tenths = (unsigned)(10 * clamp_fraction(p->fraction));
}

static void draw_bar(const fathom_progress *p) {
    char text[256];
    progress_bar(p, columns(), text, sizeof text);
    fprintf(stderr, "\r%s\033[K", text);
    fflush(stderr);
    state.drawn = true;
}

void progress_update(const fathom_progress *p) {
    if (p->phase != state.phase) begin_phase(p->phase);
    switch (state.display) {
    case DISPLAY_NONE: break;
    case DISPLAY_LINES: print_line(p); break;
    case DISPLAY_BAR: draw_bar(p); break;
    case DISPLAY_JSON: print_json(p); break;
    }
}

void progress_work(double began, double fraction, uint64_t rays) {
    progress_update(&(fathom_progress){.phase = FATHOM_PHASE_RENDER,
                                       .fraction = fraction,
                                       .rays = rays,
                                       .seconds = clock_seconds() - began});
}

void progress_phase(fathom_phase phase) {
    begin_phase(phase);
    if (state.display == DISPLAY_JSON) print_json(&(fathom_progress){.phase = phase});
    if (state.display != DISPLAY_BAR) return;
    char text[64];
    snprintf(text, sizeof text, "%s ...", phase_name(phase));
    fprintf(stderr, "\r%.*s\033[K", (int)(columns() - 1), text);
    fflush(stderr);
    state.drawn = true;
}

void progress_estimate(double seconds) {
    if (state.display == DISPLAY_NONE || seconds < ESTIMATE_FROM_SECONDS) return;
    char clock[16], text[64], members[64];
    put_clock(seconds, clock, sizeof clock);
    snprintf(text, sizeof text, "takes about %s", clock);
    snprintf(members, sizeof members, "\"estimatedSeconds\": %.4g", seconds);
    log_line_with(LOG_INFO, text, members);
}
