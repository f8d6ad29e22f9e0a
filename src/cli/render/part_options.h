/* The options of a render of one part: --part and --split, or the task of a Slurm array. */
#pragma once

#include "cli/render/render_options.h"

/* Takes K/N into a fathom_part. */
bool part_options_take(const args_option *option, const char *value, void *field, args_problem *problem);
/* Turns an output whose name ends in .part into the part's file. False: wrong usage. */
bool part_options_finish(render_options *options, args_problem *problem);
