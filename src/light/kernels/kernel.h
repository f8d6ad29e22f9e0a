/* Shared by the kernel files of this folder. */
#pragma once

#include "base/kernel.h"
#include "light/shape_block.h"

uint32_t KERNEL(face)(const shape_face_f32 *f, const lanes3 p, const lanes3 u, float *density,
                      float (*direction)[LANES], float *distance);
