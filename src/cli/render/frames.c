#include "cli/render/frames.h"

#include <stdio.h>
#include <string.h>

#define FPS 24.0

bool take_frames(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_frames *frames = field;
    char end;
    const bool one = sscanf(value, "%6u%c", &frames->first, &end) == 1;
    if (one) frames->last = frames->first;
    const bool plain = strspn(value, "0123456789-") == strlen(value);
    if (plain && (one || sscanf(value, "%6u-%6u%c", &frames->first, &frames->last, &end) == 2) &&
        frames_asked(frames))
        return true;
    return args_wrong(problem, "expected %s with FIRST <= LAST, such as 1-24, found \"%.60s\"", option->value,
                      value);
}

double frames_time(const render_frames *frames, uint32_t frame) {
    return frame / (frames->fps > 0 ? frames->fps : FPS);
}

bool frames_name(const char *path, uint32_t frame, char out[PATH_MAX]) {
    const size_t before = strcspn(path, "#"), width = strspn(path + before, "#");
    if (!width) return false;
    const int length =
        snprintf(out, PATH_MAX, "%.*s%0*u%s", (int)before, path, (int)width, frame, path + before + width);
    return length >= 0 && length < PATH_MAX;
}
