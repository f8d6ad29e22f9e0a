/* Shared by the sources in this folder; see base/kernel.h. */
#pragma once

#include "base/kernel.h"

void KERNEL(append)(const void *from, unsigned rows, uint32_t lanes, void *to, unsigned at);
