/* fathom_mpi.so: sends and receives messages by MPI, for fathom/ranks.h. No call waits inside MPI, because
 * that would keep a processor busy: later calls complete a send, and receive polls once. */
#include "job/ranks/mpi_module.h"

#include <mpi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct sending {
    struct sending *next;
    MPI_Request request;
    char bytes[];
} sending;

static struct {
    sending *first;
    char *message;
    size_t room;
} state;

static void complete_sends(void) {
    for (sending **at = &state.first; *at;) {
        sending *s = *at;
        int done = 0;
        MPI_Test(&s->request, &done, MPI_STATUS_IGNORE);
        if (!done) {
            at = &s->next;
            continue;
        }
        *at = s->next;
        free(s);
    }
}

static bool send_message(void *user, uint32_t to, const void *bytes, size_t size) {
    (void)user;
    sending *s = size <= INT32_MAX ? malloc(sizeof *s + size) : NULL;
    if (!s) return false;
    memcpy(s->bytes, bytes, size);
    if (MPI_Isend(s->bytes, (int)size, MPI_BYTE, (int)to, 0, MPI_COMM_WORLD, &s->request) != MPI_SUCCESS) {
        free(s);
        return false;
    }
    s->next = state.first;
    state.first = s;
    return true;
}

/* Without the message, rank 0 would wait for its units for ever. */
static void make_room(size_t size) {
    if (size <= state.room) return;
    char *more = realloc(state.message, size);
    if (!more) {
        fprintf(stderr, "fathom: out of memory for a message of %zu bytes from another rank\n", size);
        MPI_Abort(MPI_COMM_WORLD, FATHOM_OUT_OF_RESOURCES);
    }
    state.message = more, state.room = size;
}

static bool receive_message(void *user, uint32_t *from, const void **bytes, size_t *size) {
    (void)user;
    MPI_Status status;
    int there = 0, count = 0;
    complete_sends();
    if (MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status) != MPI_SUCCESS || !there) return false;
    MPI_Get_count(&status, MPI_BYTE, &count);
    make_room((size_t)count);
    if (MPI_Recv(state.message, count, MPI_BYTE, status.MPI_SOURCE, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE) !=
        MPI_SUCCESS)
        return false;
    *from = (uint32_t)status.MPI_SOURCE;
    *bytes = state.message;
    *size = (size_t)count;
    return true;
}

/* MPI errors end the process, and so the job: finished work that rank 0 has saved is kept. */
static const char *open_mpi(fathom_ranks *out) {
    int provided = 0, rank = 0, count = 0;
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS)
        return "MPI_Init_thread() failed";
    if (provided < MPI_THREAD_SERIALIZED) return "this MPI cannot be called from several threads in turn";
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    out->rank = (uint32_t)rank, out->count = (uint32_t)count;
    out->send = send_message, out->receive = receive_message;
    return NULL;
}

/* MPI_Finalize() would wait for the other ranks, one of which writes the image, and keep a processor busy. */
static void wait_for_others(void) {
    const struct timespec pause = {0, 1000000};
    MPI_Request all;
    int there = MPI_Ibarrier(MPI_COMM_WORLD, &all) != MPI_SUCCESS;
    while (!there || state.first) {
        complete_sends();
        if (!there) MPI_Test(&all, &there, MPI_STATUS_IGNORE);
        nanosleep(&pause, NULL);
    }
}

static void close_mpi(void) {
    wait_for_others();
    free(state.message);
    MPI_Finalize();
}

__attribute__((visibility("default")))
const mpi_module fathom_mpi_module = {MPI_MODULE_VERSION, open_mpi, close_mpi};
