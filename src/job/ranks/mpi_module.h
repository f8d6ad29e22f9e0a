/* The interface between the library and fathom_mpi.so. */
#pragma once

#include <fathom/ranks.h>

/* Increase with every change of this file: the library refuses a module of another version. */
#define MPI_MODULE_VERSION 1u
#define MPI_MODULE_SYMBOL "fathom_mpi_module"

typedef struct mpi_module {
    uint32_t version;
    const char *(*open)(fathom_ranks *out); /* returns NULL, or why it failed */
    void (*close)(void);
} mpi_module;

extern const mpi_module fathom_mpi_module;
