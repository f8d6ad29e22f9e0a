/* How libFuzzer changes binary glTF: most often the text or the data alone, with the lengths written anew,
 * since a container whose lengths do not fit is refused before its text is looked at. */
#include "fuzz.h"

#include <string.h>

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);

enum { HEADER = 12, CHUNK_HEADER = 8, BEFORE_TEXT = HEADER + CHUNK_HEADER, LONGEST = 65536 };

static size_t length_at(const uint8_t *data, size_t at) {
    uint32_t length;
    memcpy(&length, data + at, sizeof length);
    return length;
}

static void put_length(uint8_t *data, size_t at, size_t length) {
    const uint32_t word = (uint32_t)length;
    memcpy(data + at, &word, sizeof word);
}

/* Where the text's chunk ends; 0 for what is no container of a text and, if there is more, data. */
static size_t end_of_text(const uint8_t *data, size_t size) {
    if (size < BEFORE_TEXT || memcmp(data, "glTF", 4) != 0 || length_at(data, 8) != size) return 0;
    const size_t text = length_at(data, HEADER);
    if (text > size - BEFORE_TEXT) return 0;
    const size_t end = BEFORE_TEXT + text, left = size - end;
    return !left || (left >= CHUNK_HEADER && length_at(data, end) == left - CHUNK_HEADER) ? end : 0;
}

/* Changes the chunk between its header and `end`, and pads it to words. Returns the size of it all. */
static size_t mutate_chunk(uint8_t *data, size_t size, size_t max_size, size_t header, size_t end, int pad) {
    static uint8_t chunk[LONGEST];
    const size_t begin = header + CHUNK_HEADER, rest = size - end, room = max_size - begin - rest;
    size_t length = end - begin;
    if (!room) return size;
    memcpy(chunk, data + begin, length);
    while (length && chunk[length - 1] == pad) --length;
    length = LLVMFuzzerMutate(chunk, length, room);
    while (length % 4 && length < room) chunk[length++] = (uint8_t)pad;
    memmove(data + begin + length, data + end, rest);
    memcpy(data + begin, chunk, length);
    put_length(data, header, length);
    put_length(data, 8, begin + length + rest);
    return begin + length + rest;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    const size_t end = end_of_text(data, size);
    if (!end || size > max_size || max_size > LONGEST || seed % 8 == 0)
        return LLVMFuzzerMutate(data, size, max_size);
    if (end < size && seed % 8 == 1) return mutate_chunk(data, size, max_size, end, size, 0);
    return mutate_chunk(data, size, max_size, HEADER, end, ' ');
}
