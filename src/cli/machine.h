/* What figures were measured on, for results that are kept. */
#ifndef CLI_MACHINE_H
#define CLI_MACHINE_H

#include <stdbool.h>
#include <stddef.h>

/* The processor's name as the system has it; "unknown". */
void machine_cpu(char *out, size_t size);
/* The instruction set of our own loops: "AVX2". Embree's is in its tracer's name. */
const char *machine_kernels(void);
/* "gcc 12.2.0" */
const char *machine_compiler(void);
/* How the program was compiled: "Release -O3 -DNDEBUG". */
const char *machine_flags(void);
/* Today, as 2026-11-21 in universal time. */
void machine_date(char out[16]);

#endif
