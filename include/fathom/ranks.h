/* One render by several processes at the same time: rank 0 hands out tiles to whoever needs some, and gets
 * their pixels. The image is the one that a single process renders, to the last bit. */
#ifndef FATHOM_RANKS_H
#define FATHOM_RANKS_H

#include <fathom/base.h>
#include <fathom/read.h>

#ifdef __cplusplus
extern "C" {
#endif

/* How the processes of a render reach each other. All of them call fathom_session_run() with the same scene
 * and settings. Between its beginning and end, one thread at a time makes these calls. Messages between two
 * ranks arrive in the order in which they were sent. */
typedef struct fathom_ranks {
    size_t size;
    uint32_t rank, count; /* this process, from 0; how many there are */
    void *user;
    /* Takes a copy of the message, and returns at once. False: it cannot be sent. */
    bool (*send)(void *user, uint32_t to, const void *bytes, size_t size);
    /* The next message to this rank. The callee owns the bytes; they are valid until the next call. Returns
     * at once; false: there is no message. */
    bool (*receive)(void *user, uint32_t *from, const void **bytes, size_t *size);
} fathom_ranks;

FATHOM_DEFAULT(fathom_ranks)

/* fathom_scene_read_with() on all ranks at the same time. If a rank cannot read the scene, rank 0 sends it
 * all files that rank 0 has read, once rank 0 renders. They must be in or below the scene's folder. *folder
 * is the private folder of these copies, in $TMPDIR or /var/tmp, or NULL; pass it to fathom_ranks_remove()
 * after the scene is destroyed, also after a failure. stopped (may be NULL): returns true to stop waiting;
 * the call then returns FATHOM_INTERRUPTED. */
FATHOM_API fathom_status fathom_ranks_read(fathom_context *context, const fathom_ranks *ranks,
                                           const char *path, const fathom_read_options *options,
                                           bool (*stopped)(void), fathom_scene **out, char **folder);
/* Removes the folder with all that is in it. NULL is fine. */
FATHOM_API void fathom_ranks_remove(char *folder);

/* The processes that mpirun started with this one, by the module fathom_mpi.so, which is loaded now: nothing
 * else of Fathom knows MPI. Once in a process. FATHOM_OUT_OF_RESOURCES: the module was not built, cannot be
 * loaded, or MPI fails. End with fathom_mpi_close(). */
FATHOM_API fathom_status fathom_mpi_open(fathom_context *context, fathom_ranks *out);
/* finished: waits until all ranks have called it. Otherwise returns at once; the process should end then,
 * with an exit code that tells mpirun to end the others. */
FATHOM_API void fathom_mpi_close(bool finished);

#ifdef __cplusplus
}
#endif
#endif
