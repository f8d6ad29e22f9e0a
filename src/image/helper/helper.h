/* The image helper's processes: each is started on first use, serves one request at a time, and is abandoned
 * when it fails. Textures may use several at once. */
#ifndef IMAGE_HELPER_H
#define IMAGE_HELPER_H

#include "image/helper/wire.h"

#include <limits.h>

/* The most seconds for the helper's start and for each request (16 MB of rows, or an image to read), enough
 * for a slow disk. $FATHOM_IMAGE_SECONDS overrides it. */
#define HELPER_SECONDS 300

/* A request and its answer. */
typedef struct helper_exchange {
    wire_request request;
    const void *bytes; /* request.size bytes for the shared memory; NULL: none */
    int descriptor;    /* sent with it; -1: none */
    uint64_t process;  /* the helper that owns request.object; 0: any */
    unsigned helpers;  /* of process 0: how many it may choose from; 0: the first */
    wire_reply reply;
    /* Called with reply.size bytes of shared memory when the reply is OK, before the next request; or NULL.
     */
    fathom_status (*take)(void *user, const unsigned char *bytes, const wire_reply *reply);
    void *user;
} helper_exchange;

/* Waits for its turn, for the helper's start, and for the answer; any thread. On failure e->reply.text is the
 * reason. FATHOM_OUT_OF_RESOURCES: there is no helper, or it ended, or took too long; then it is ended, and
 * the next call starts a new one. Sets e->process on FATHOM_OK. */
fathom_status helper_ask(helper_exchange *e);

#define HELPERS_MOST 64u
/* Starts so many helpers, unless they were; waits for none. */
void helper_prefetch(unsigned count);

/* The path of a file of the installation's library folder, "fathom/fathom_mpi.so". */
bool helper_find_file(const char *name, char path[PATH_MAX]);

/* FATHOM_OUT_OF_RESOURCES when the helper's program is missing, with a message. Starts nothing. */
fathom_status helper_find(fathom_context *context);

/* The calls of module.h, each made in the helper; any thread. A call that the helper does not survive fails
 * with FATHOM_OUT_OF_RESOURCES, and so does each later call on what was open then. */
extern const image_module image_calls;

#endif
