#include "cli/validate/ray_line.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A field up to the next space, by its own reading of hexadecimal floats. */
static bool take_number(const char **text, float *out) {
    char *end;
    double x = strtod(*text, &end);
    if (end == *text || *end != ' ' || (isfinite(x) && (double)(float)x != x)) return false;
    *out = (float)x;
    *text = end + 1;
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
    float *numbers[8] = {&out->ray.org.x, &out->ray.org.y, &out->ray.org.z,  &out->ray.dir.x,
                         &out->ray.dir.y, &out->ray.dir.z, &out->ray.t_near, &out->ray.t_far};
    for (int i = 0; i < 8; ++i) {
        if (!take_number(&text, numbers[i])) return false;
    }
    snprintf(out->scene, sizeof out->scene, "%s", text);
    return *text != '\0';
}

static fathom_status fail_line(const ray_lines *lines, const char *what) {
    const fathom_place place = {.file = lines->path, .line = lines->number};
    return fail_at(lines->context, FATHOM_BAD_INPUT, &place, "%s", what);
}

static fathom_status read_line(const ray_lines *lines, const char *text, size_t length, ray_line *out) {
    char copy[4608];
    if (length > 4600 || memchr(text, '\0', length))
        return fail_line(lines, "the line holds a zero byte or more than 4600 characters; expected text as "
                                "--failures writes it");
    snprintf(copy, sizeof copy, "%.*s", (int)length, text);
    if (parse(copy, out)) return FATHOM_OK;
    return fail_line(lines, "not a ray as --failures writes it; expected tracer, family, number, verdict, "
                            "origin, direction, t_near, t_far and scene");
}

fathom_status ray_lines_next(ray_lines *lines, ray_line *out, bool *found) {
    *found = false;
    while (lines->at < lines->end) {
        const char *text = lines->at, *newline = memchr(text, '\n', (size_t)(lines->end - text));
        size_t length = (size_t)((newline ? newline : lines->end) - text);
        lines->at = newline ? newline + 1 : lines->end;
        ++lines->number;
        if (!length || *text == '#') continue;
        *found = true;
        return read_line(lines, text, length, out);
    }
    return FATHOM_OK;
}
