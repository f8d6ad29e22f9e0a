#include "cli/render/part_options.h"

#include "base/file_name.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* "3/16". */
bool part_options_take(const args_option *option, const char *value, void *field, args_problem *problem) {
    fathom_part *part = field;
    char end;
    if (strspn(value, "0123456789/") == strlen(value) &&
        sscanf(value, "%9u/%9u%c", &part->index, &part->count, &end) == 2 && part->index &&
        part->index <= part->count && part->count <= 65536)
        return true;
    return args_wrong(problem, "expected %s with 1 <= K <= N <= 65536, such as 3/16, found \"%.60s\"",
                      option->value, value);
}

static bool number_of(const char *variable, uint32_t *out) {
    const char *text = getenv(variable);
    char end;
    return text && sscanf(text, "%9u%c", out, &end) == 1;
}

/* Finds the position of this task among the tasks least, least + step, …. */
static bool take_slurm(fathom_part *part, args_problem *problem) {
    uint32_t task, least = 0, step = 1;
    if (!number_of("SLURM_ARRAY_TASK_ID", &task) || !number_of("SLURM_ARRAY_TASK_COUNT", &part->count))
        return args_wrong(problem,
                          "-o %.300s: --part K/N is missing, and there is no SLURM_ARRAY_TASK_ID with "
                          "SLURM_ARRAY_TASK_COUNT",
                          part->path);
    number_of("SLURM_ARRAY_TASK_MIN", &least);
    number_of("SLURM_ARRAY_TASK_STEP", &step);
    part->index = step && task >= least ? (task - least) / step + 1 : 0;
    if (part->index && part->index <= part->count && part->count <= 65536 && (task - least) % step == 0)
        return true;
    return args_wrong(problem,
                      "-o %.300s: task %u is none of an array of %u tasks from %u on in steps of %u; "
                      "expected such an array, or --part K/N",
                      part->path, task, part->count, least, step);
}

static bool is_part(const char *path) {
    char extension[16];
    file_extension(path, extension);
    return strcmp(extension, "part") == 0;
}

bool part_options_finish(render_options *options, args_problem *problem) {
    fathom_part *part = &options->part;
    args_list *outputs = &options->outputs;
    if (part->path) return true;
    size_t i = 0;
    while (i < outputs->count && !is_part(outputs->items[i])) ++i;
    if (i == outputs->count) {
        return (!part->count && part->split == FATHOM_SPLIT_AUTO) ||
               args_wrong(problem, "--%s: only with -o FILE.part", part->count ? "part" : "split");
    }
    if (outputs->count > 1)
        return args_wrong(problem,
                          "-o %.300s: a part must be the only output; fathom merge writes the images",
                          outputs->items[i]);
    if (options->mpi)
        return args_wrong(problem,
                          "--mpi: one process renders a part; expected either --mpi or -o FILE.part");
    if (options->checkpoint)
        return args_wrong(problem, "--checkpoint: a part is its own checkpoint; leave this option out");
    part->path = outputs->items[i];
    outputs->count = 0;
    return part->count || take_slurm(part, problem);
}
