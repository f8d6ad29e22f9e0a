/* Files of the scene for ranks that cannot open them. */
#ifndef JOB_RANKS_FILES_H
#define JOB_RANKS_FILES_H

#include "base/opened.h"
#include "job/ranks/unit_queue.h"

#include <fathom/ranks.h>

/* Answers a message FILE_WANTED, of which `body` is what follows the head. False: it makes no sense, or the
 * answer cannot be sent. */
bool ranks_answer_file(const fathom_ranks *ranks, const fathom_context *context, uint32_t from,
                       const unsigned char *body, size_t size, uint32_t index);

#endif
