/* The calls between the library and fathom_mpi.so. */
#ifndef JOB_RANKS_MPI_MODULE_H
#define JOB_RANKS_MPI_MODULE_H

#include <fathom/ranks.h>

/* Grows with every change of this file: a module of another build is refused, not called. */
#define MPI_MODULE_VERSION 1u
#define MPI_MODULE_SYMBOL "fathom_mpi_module"

typedef struct mpi_module {
    uint32_t version;
    const char *(*open)(fathom_ranks *out); /* NULL, or why it failed */
    void (*close)(void);
} mpi_module;

extern const mpi_module fathom_mpi_module;

#endif
