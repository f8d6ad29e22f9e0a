/* A wave between two passes, as bytes: the state that the next pass needs. */
#pragma once

#include "job/adaptive.h"

size_t adaptive_record_bytes(film_parts parts);
/* a: after adaptive_pass() returned ADAPTIVE_PASSED. */
void adaptive_record_save(const adaptive_wave *a, unsigned char *out);
/* True if the bytes can be a wave whose pixels have at most `spp` samples. Such bytes are safe to load,
 * whatever they contain. */
bool adaptive_record_check(const unsigned char *record, uint32_t spp);
/* a: after adaptive_begin(). */
void adaptive_record_load(const fathom_settings *settings, const unsigned char *record, adaptive_wave *a);
