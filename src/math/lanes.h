/* Blocks of sixteen lanes, as structures of arrays. */
#pragma once

#define LANES 16

typedef float lanes3[3][LANES];
typedef double lanes3_f64[3][LANES];
