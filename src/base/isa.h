/* The instruction sets that kernels and Embree may use: those of the processor, limited by $FATHOM_ISA if it
 * is set. */
#pragma once

#include <stdbool.h>

/* Each set includes those before it. */
typedef enum isa_set { ISA_BEST, ISA_SSE2, ISA_SSE42, ISA_AVX, ISA_AVX2, ISA_AVX512 } isa_set;

/* "sse4.2"; "" for ISA_BEST and invalid values. */
const char *isa_word(isa_set set);
/* The smaller of `most` and $FATHOM_ISA. ISA_BEST means no limit. */
isa_set isa_limit(isa_set most);
/* True if the processor has the set and $FATHOM_ISA allows it. */
bool isa_usable(isa_set set);
/* The value of $FATHOM_ISA if it is set but names no known set, else NULL. */
const char *isa_unknown(void);
