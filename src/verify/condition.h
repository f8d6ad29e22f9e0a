/* Condition numbers of an intersection. */
#ifndef PARITY_CONDITION_H
#define PARITY_CONDITION_H

#include "verify/exact/oracle.h"

/* Of an answer whose t, weights and edge are set; the primitive is no quad but its part. */
void condition_set(const oracle_ray *ray, const oracle_primitive *primitive, oracle_answer *answer);

#endif
