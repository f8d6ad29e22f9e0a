#include "cli/render/frames.h"

#include "base/parameter.h"

#include <stdio.h>
#include <string.h>

#define FPS 24.0
#define FRAME_MOST 999999u

bool take_frames(const args_option *option, const char *value, void *field, args_problem *problem) {
    const char *text = value;
    uint64_t first = 0, last;
    bool fine = text_read_u64(&text, strchr(value, '-') ? '-' : '\0', &first);
    last = first;
    if (fine && strchr(value, '-')) fine = text_read_u64(&text, '\0', &last);
    if (!fine || first > last || last > FRAME_MOST)
        return args_wrong(problem, "expected %s with FIRST <= LAST <= %u, such as 1-24, found \"%.60s\"",
                          option->value, FRAME_MOST, value);
    render_frames *frames = field;
    frames->first = (uint32_t)first, frames->last = (uint32_t)last;
    return true;
}

double frames_time(const render_frames *frames, uint32_t frame) {
    return frame / (frames->fps > 0 ? frames->fps : FPS);
}

bool frames_name(const char *path, uint32_t frame, char out[PATH_MAX]) {
    const char *begin = strrchr(path, '#');
    if (!begin) return false;
    const char *end = begin + 1;
    while (begin > path && begin[-1] == '#') --begin;
    const int length =
        snprintf(out, PATH_MAX, "%.*s%0*u%s", (int)(begin - path), path, (int)(end - begin), frame, end);
    return length >= 0 && length < PATH_MAX;
}
