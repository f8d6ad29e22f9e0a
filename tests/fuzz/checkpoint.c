/* Checkpoints of a film of 12 × 12 pixels that lies in four waves. The last eight bytes, a checksum's place,
 * say how: unless bit 0 is set the sum is made right, unless bit 1 is set the key is taken for this render's
 * own, so that all behind them is reached; bit 2 is for records with hits. */
#include "fuzz.h"

#include "base/hash.h"
#include "render/checkpoint_state.h"

#include <stdlib.h>
#include <string.h>

#define SIDE 12
#define CHANNELS 4
#define KEY_AT 12 /* past the magic number and the format */

static void make_film(fathom_film *film) {
    static const char *const names[CHANNELS] = {"R", "G", "B", "A"};
    *film = (fathom_film){.width = SIDE,
                          .height = SIDE,
                          .x = WAVE_SIDE - 6,
                          .y = WAVE_SIDE - 6,
                          .full_width = 2 * WAVE_SIDE,
                          .full_height = 2 * WAVE_SIDE,
                          .channel_count = CHANNELS};
    for (unsigned i = 0; i < CHANNELS; ++i) {
        film->channels[i] = (film_channel){.name = names[i], .data = calloc(SIDE * SIDE, sizeof(float))};
        if (!film->channels[i].data) abort();
    }
}

static void adopt_key(const uint8_t *bytes, size_t size, checkpoint_key *key) {
    const uint8_t *at = bytes + KEY_AT + sizeof(uint32_t);
    if (size < KEY_AT + sizeof(uint32_t) + sizeof *key) return;
    memcpy(key->version, at, sizeof key->version);
    memcpy(key->numbers, at + sizeof key->version + sizeof key->tracer, sizeof key->numbers);
}

static void correct_sum(uint8_t *bytes, size_t size) {
    hash h;
    hash_begin(&h);
    hash_put(&h, bytes, size - sizeof(uint64_t));
    const uint64_t sum = hash_end(&h);
    memcpy(bytes + size - sizeof sum, &sum, sizeof sum);
}

static void read(const uint8_t *bytes, size_t size, unsigned how) {
    fathom_settings settings;
    fathom_film film;
    checkpoint_key key;
    checkpoint_state state;
    char tracer[128] = "";
    fathom_settings_default(&settings);
    make_film(&film);
    checkpoint_key_of(&settings, &film, 7, &key);
    if (!(how & 2)) adopt_key(bytes, size, &key);
    if (!checkpoint_state_create(&settings, &film, how & 4, &state)) abort();
    fuzz_put_file(0, "a.checkpoint", bytes, size);
    fathom_status status =
        checkpoint_read(fuzz_context(), "a.checkpoint", bytes, size, &key, &film, &state, tracer);
    fuzz_judge(status);
    if (status == FATHOM_OK && !memchr(tracer, '\0', sizeof tracer)) fuzz_wrong("a tracer without an end");
    checkpoint_state_destroy(&state);
    for (unsigned i = 0; i < CHANNELS; ++i) free(film.channels[i].data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint8_t *bytes = malloc(size ? size : 1);
    if (!bytes) abort();
    memcpy(bytes, data, size);
    const unsigned how = size < sizeof(uint64_t) ? 1 : data[size - 1];
    if (!(how & 1)) correct_sum(bytes, size);
    fuzz_begin(size, 16);
    read(bytes, size, how);
    fuzz_end();
    free(bytes);
    return 0;
}
