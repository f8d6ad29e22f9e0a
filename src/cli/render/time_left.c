#include "cli/render/time_left.h"

#include "base/status.h"
#include "film/film.h"

fathom_status time_left(fathom_context *context, double elapsed, render_options *options) {
    if (!(options->max_time > 0)) return FATHOM_OK;
    options->settings.max_time = options->max_time - elapsed;
    if (options->settings.max_time > 0) return FATHOM_OK;
    return fail(context, FATHOM_BAD_USAGE,
                "--max-time: %g s are too short: reading alone took %.2f s; give more time",
                options->max_time, elapsed);
}

/* Of the time that is left, what finding out may take. */
#define REHEARSAL 0.03

static double seconds_to_write(void *user, const fathom_film *film, double left) {
    const time_outputs *o = user;
    const film_outputs outputs = {o->options->outputs.items, o->options->outputs.count, &o->options->write};
    return film_write_seconds(o->context, film, &outputs, REHEARSAL * left);
}

job_reserve time_to_write(const time_outputs *outputs) {
    return (job_reserve){seconds_to_write, (void *)(uintptr_t)outputs};
}
