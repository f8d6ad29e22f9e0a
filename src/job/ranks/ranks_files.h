/* Sends files of the scene to ranks that cannot open them. */
#pragma once

#include "base/opened.h"
#include "job/ranks/unit_queue.h"

#include <fathom/ranks.h>

/* Replies to a message FILE_WANTED. `body` follows the head of the message. False: the message is invalid, or
 * the reply cannot be sent. */
bool ranks_answer_file(const fathom_ranks *ranks, const fathom_context *context, uint32_t from,
                       const unsigned char *body, size_t size, uint32_t index);
