/* Files of parts, merged. Their head is larger than the inputs are, so it is made here, and changed:
 *
 *     u8 how, u8 count, count times (u16 place, u8 value), then the records
 *
 * `how`: see below. Heads of large images are not tried: they would take memory that no input pays for. */
#include "fuzz.h"

#include "base/hash.h"
#include "job/part/part_file.h"

#include <fathom/part.h>
#include <string.h>

#define MOST_PIXELS 4096u
#define INPUT_MOST ((size_t)1 << 20)

enum { AS_HASHED = 1, BY_TILES = 2, TWO = 4, WITH_AOVS = 8, ANY_HEAD = 16 };

typedef struct input {
    const uint8_t *at, *end;
} input;

static unsigned take(input *in) { return in->at < in->end ? *in->at++ : 0; }

static part_head make_head(unsigned how) {
    part_head h = {.format = PART_FORMAT, .bytes = sizeof h, .index = 1, .count = how & TWO ? 2 : 1};
    memcpy(h.magic, PART_MAGIC, sizeof h.magic);
    h.split = how & BY_TILES ? FATHOM_SPLIT_TILES : FATHOM_SPLIT_SAMPLES;
    fathom_settings_default(&h.settings);
    fathom_settings_set_integrator(&h.settings, FATHOM_INTEGRATOR_CLASSIC);
    h.settings.width = h.settings.height = 64;
    h.settings.spp = 9;
    h.settings.tracer = NULL;
    h.settings.aovs = how & WITH_AOVS ? FATHOM_AOV_ALPHA | FATHOM_AOV_Z : 0;
    for (int k = 0; k < 4; ++k) h.settings.crop[k] = k < 2 ? 26 : 38;
    checkpoint_key_of(&h.settings, 7, &h.key);
    return h;
}

static bool is_small(const part_head *h) {
    const settings_region r = settings_region_of(&h->settings);
    return (uint64_t)h->settings.width * h->settings.height <= MOST_PIXELS && h->settings.spp <= 64 &&
           r.width <= h->settings.width && r.height <= h->settings.height && part_head_bytes(h) == sizeof *h;
}

/* The hash of each record whose bytes are all there. */
static void correct_hashes(uint8_t *at, const uint8_t *end) {
    part_record r;
    while ((size_t)(end - at) >= sizeof r + sizeof(uint64_t)) {
        memcpy(&r, at, sizeof r);
        if (r.bytes > (size_t)(end - at) - sizeof r - sizeof(uint64_t)) return;
        const uint64_t sum = hash_of(at, sizeof r + r.bytes);
        memcpy(at + sizeof r + r.bytes, &sum, sizeof sum);
        at += sizeof r + r.bytes + sizeof sum;
    }
}

static size_t make_file(const part_head *head, unsigned how, input in, uint8_t *out) {
    static const char *const no_manifests[MATTE_KINDS];
    const uint64_t sum = how & ANY_HEAD ? 0 : part_head_hash(head, no_manifests);
    const size_t records = (size_t)(in.end - in.at);
    uint8_t *at = out + sizeof *head + sizeof sum;
    memcpy(out, head, sizeof *head);
    memcpy(out + sizeof *head, &sum, sizeof sum);
    memcpy(at, in.at, records);
    if (!(how & AS_HASHED)) correct_hashes(at, at + records);
    return sizeof *head + sizeof sum + records;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static uint8_t rooms[2][sizeof(part_head) + sizeof(uint64_t) + INPUT_MOST];
    static const char *const paths[] = {"a.part", "b.part"};
    if (size > INPUT_MOST) return 0;
    input in = {data, data + size};
    const unsigned how = take(&in), changes = take(&in), parts = how & TWO ? 2 : 1;
    part_head head = make_head(how);
    for (unsigned i = 0; i < changes; ++i) {
        const unsigned place = take(&in) | take(&in) << 8;
        ((uint8_t *)&head)[place % sizeof head] = (uint8_t)take(&in);
    }
    if (!is_small(&head)) return 0;
    fathom_film *film;
    /* A list of all parts that there may be is allowed. */
    fuzz_begin(size + parts * sizeof head + PART_MOST * sizeof(void *) / 64, 64);
    for (unsigned i = 0; i < parts; ++i, ++head.index)
        fuzz_put_file(i, paths[i], rooms[i], make_file(&head, how, in, rooms[i]));
    fuzz_judge(fathom_parts_merge(fuzz_context(), paths, parts, NULL, &film));
    fathom_film_destroy(film);
    fuzz_end();
    return 0;
}
