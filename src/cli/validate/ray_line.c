#include "cli/validate/ray_line.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_ROOM 4608

/* Reads a number that ends at the next space; accepts hexadecimal floats and rejects numbers that are not
 * exact in float. */
static bool take_number(const char **text, float *out) {
    char *end;
    double x = strtod(*text, &end);
    if (end == *text || *end != ' ' || (isfinite(x) && (double)(float)x != x)) return false;
    *out = (float)x;
    *text = end + 1;
    return true;
}

static bool take_ray(const char **text, oracle_ray *ray) {
    float *numbers[8] = {&ray->org.x, &ray->org.y, &ray->org.z,  &ray->dir.x,
                         &ray->dir.y, &ray->dir.z, &ray->t_near, &ray->t_far};
    for (int i = 0; i < 8; ++i) {
        if (!take_number(text, numbers[i])) return false;
    }
    return true;
}

static bool parse(const char *text, ray_line *out) {
    int used = 0;
    char was[16];
    memset(out, 0, sizeof *out);
    if (sscanf(text, "%127s %31s %llu %15s %n", out->spec, out->family, &out->index, was, &used) != 4)
        return false;
    out->any = strncmp(was, RAY_LINE_ANY, strlen(RAY_LINE_ANY)) == 0;
    text += used;
    if (!take_ray(&text, &out->ray)) return false;
    snprintf(out->scene, sizeof out->scene, "%s", text);
    return *text != '\0';
}

static fathom_status fail_line(const ray_lines *lines, const char *what) {
    const fathom_place place = {.file = lines->path, .line = lines->number};
    return fail_at(lines->context, FATHOM_BAD_INPUT, &place, "%s", what);
}

/* The text up to the end of the line; accepts the line ends of all systems. */
static size_t take_line(ray_lines *lines, const char **text) {
    const char *at = *text = lines->at;
    while (at < lines->end && *at != '\n' && *at != '\r') ++at;
    size_t length = (size_t)(at - *text);
    if (at + 1 < lines->end && at[0] == '\r' && at[1] == '\n') ++at;
    lines->at = at < lines->end ? at + 1 : at;
    ++lines->number;
    return length;
}

static fathom_status copy_line(const ray_lines *lines, const char *text, size_t length,
                               char copy[LINE_ROOM]) {
    if (length > LINE_ROOM - 8 || memchr(text, '\0', length))
        return fail_line(lines, "the line holds a zero byte or more than 4600 characters; expected text as "
                                "--failures writes it");
    snprintf(copy, LINE_ROOM, "%.*s", (int)length, text);
    return FATHOM_OK;
}

/* "+ way coherence lane lanes geometry primitive instance t met" */
static bool parse_block(const char *text, ray_line *out) {
    unsigned coherence, met;
    verdict_answer *hit = &out->given.hit;
    ask_block *block = &out->block;
    bool read = sscanf(text, "+ %31s %u %u %u %u %u %u %lf %u", out->way, &coherence, &block->lane,
                       &block->lanes, &hit->geometry, &hit->primitive, &hit->instance, &hit->t, &met) == 9;
    block->coherence = (trace_coherence)coherence, block->any = out->any, out->given.met = met != 0;
    return read && coherence <= TRACE_COHERENT && block->lanes <= LANES && block->lane < block->lanes;
}

/* Reads the lines of the call after a ray's line, if there are any. */
static fathom_status read_block(ray_lines *lines, ray_line *out) {
    char copy[LINE_ROOM];
    const char *text;
    if (lines->at >= lines->end || *lines->at != '+') return FATHOM_OK;
    size_t length = take_line(lines, &text);
    fathom_status status = copy_line(lines, text, length, copy);
    if (status != FATHOM_OK) return status;
    if (!parse_block(copy, out))
        return fail_line(lines, "not a call as --failures writes it; expected + and nine fields");
    for (unsigned i = 0; i < out->block.lanes; ++i) {
        length = take_line(lines, &text);
        status = copy_line(lines, text, length, copy);
        if (status != FATHOM_OK) return status;
        const char *at = copy + 1;
        strcat(copy, " ");
        if (*copy != '+' || !take_ray(&at, &out->block.rays[i]))
            return fail_line(lines,
                             "not a ray of a call as --failures writes it; expected + and eight numbers");
    }
    out->has_block = true;
    return FATHOM_OK;
}

static fathom_status read_line(ray_lines *lines, const char *text, size_t length, ray_line *out) {
    char copy[LINE_ROOM];
    fathom_status status = copy_line(lines, text, length, copy);
    if (status != FATHOM_OK) return status;
    if (parse(copy, out)) return read_block(lines, out);
    return fail_line(lines, "not a ray as --failures writes it; expected tracer, family, number, verdict, "
                            "origin, direction, t_near, t_far and scene");
}

fathom_status ray_lines_next(ray_lines *lines, ray_line *out, bool *found) {
    *found = false;
    while (lines->at < lines->end) {
        const char *text;
        size_t length = take_line(lines, &text);
        if (!length || *text == '#') continue;
        *found = true;
        return read_line(lines, text, length, out);
    }
    return FATHOM_OK;
}
