/* The processes of the image helper. Each starts on first use, handles one request at a time, and is not used
 * again after a failure. Textures may use several processes in parallel. */
#pragma once

#include "image/helper/wire.h"

#include <limits.h>
#include <sys/types.h>

/* Maximum seconds for the helper's start and for each request (16 MB of rows, or an image to read), long
 * enough for a slow disk. $FATHOM_IMAGE_SECONDS overrides it. */
#define HELPER_SECONDS 300

/* A request and its reply. */
typedef struct helper_exchange {
    wire_request request;
    const void *bytes; /* request.size bytes, copied to the shared memory; NULL: none */
    int descriptor;    /* sent with the request; -1: none */
    uint64_t process;  /* the helper that owns request.object; 0: any */
    unsigned helpers;  /* if process is 0: the number of helpers to choose from; 0: the first */
    wire_reply reply;
    /* Called with reply.size bytes of shared memory if the reply is FATHOM_OK, before the next request; may
     * be NULL. */
    fathom_status (*take)(void *user, const unsigned char *bytes, const wire_reply *reply);
    void *user;
} helper_exchange;

/* Waits for other threads' requests, for the helper's start, and for the reply. Thread-safe. On failure
 * e->reply.text is the reason. FATHOM_OUT_OF_RESOURCES: the helper is missing, ended, or took too long. In
 * the last case it is killed. The next call starts a new one. Sets e->process. */
fathom_status helper_ask(helper_exchange *e);

#define HELPERS_MOST 64u
/* Starts this many helpers, except those that run already. Does not wait for them. */
void helper_prefetch(unsigned count);

/* The path of a file in the installation's library folder, such as "fathom/fathom_mpi.so". */
bool helper_find_file(const char *name, char path[PATH_MAX]);

/* Starts a program with these descriptors as its numbers 0, 1…; -1: /dev/null. It inherits no others: with a
 * copy of a pipe's end in it, the pipe's reader would never see its end. Returns 0, or the error number. */
int helper_spawn(const char *path, const int descriptors[], int count, pid_t *child);

/* FATHOM_OUT_OF_RESOURCES, with a message, if the helper's program is missing. Does not start a helper. */
fathom_status helper_find(fathom_context *context);

/* The calls of module.h, each run in the helper. Thread-safe. If a call crashes the helper, it fails with
 * FATHOM_OUT_OF_RESOURCES. So do all later calls on objects that were open in the helper then. */
extern const image_module image_calls;
