/* The image helper's process: started on its first use, asked one thing at a time, given up when it fails. */
#ifndef IMAGE_HELPER_H
#define IMAGE_HELPER_H

#include "image/helper/wire.h"

#include <fathom/base.h>

/* Seconds that the helper may take for its start, and for each request: large enough for a slow disk. A
 * request is some 16 MB of rows, or an image that is read. $FATHOM_IMAGE_SECONDS stands for it. */
#define HELPER_SECONDS 300

/* A request with what goes along, and its answer. */
typedef struct helper_exchange {
    wire_request request;
    const void *bytes; /* request.size of them are put into the shared memory; NULL: nothing */
    int descriptor;    /* sent along; -1: none */
    uint64_t process;  /* of request.object: which helper made it; 0: any */
    wire_reply reply;
    /* Called with the shared memory once the reply is there and OK, before anybody else's request; NULL:
     * nothing is taken. bytes: reply.size of them. */
    fathom_status (*take)(void *user, const unsigned char *bytes, const wire_reply *reply);
    void *user;
} helper_exchange;

/* Waits for its turn, for the helper's start, and for the answer; any thread. Whatever it returns,
 * e->reply.text says why it failed. FATHOM_OUT_OF_RESOURCES: there is no helper, or it ended, or took too
 * long; it is then ended, and the next call starts another one. Sets e->process on FATHOM_OK. */
fathom_status helper_ask(helper_exchange *e);

/* Starts it unless it runs; does not wait. */
void helper_prefetch(void);
/* Why the last start failed, in `text`; FATHOM_OK while it is under way. Does not wait. */
fathom_status helper_look(char text[1024]);
/* What it works with, in `text`, or why it cannot be started; waits for its start. */
fathom_status helper_libraries(char text[1024]);
/* Whether the program is there; else why not. */
bool helper_find(char text[1024]);

#endif
