/* Answers of the image helper, as the library takes them: any numbers in the reply, any bytes in the shared
 * memory. The linker hands the library's questions to the helper below (--wrap). The input is the number of
 * the call, the reply's status, where an image's planes begin, and the memory. */
#include "fuzz.h"

#include "image/helper/helper.h"

#include <stdlib.h>
#include <string.h>

enum { HEAD = 4 };

static const uint8_t *answer;
static size_t answer_size;

fathom_status __wrap_helper_ask(helper_exchange *e);

/* The memory ends where the helper says: AddressSanitizer sees a read beyond. It is never smaller than the
 * request. */
fathom_status __wrap_helper_ask(helper_exchange *e) {
    const size_t said = answer_size - HEAD, size = said > e->request.size ? said : e->request.size;
    unsigned char *memory = calloc(size + 1, 1);
    if (!memory) abort();
    memcpy(memory + 1, answer + HEAD, said);
    e->reply = (wire_reply){.version = WIRE_VERSION, .status = answer[1], .size = said, .flag = answer[2]};
    e->reply.object = answer[2] + 256u * answer[3];
    memcpy(e->reply.text, answer,
           answer_size < sizeof e->reply.text ? answer_size : sizeof e->reply.text - 1);
    e->process = 1;
    fathom_status status = (fathom_status)e->reply.status;
    if (status == FATHOM_OK && e->take) status = e->take(e->user, memory + 1, &e->reply);
    free(memory);
    return status;
}

/* Reads all that an image points to. */
static void read_image(void) {
    image_message message = {""};
    const image *img;
    if (image_calls.read("a.exr", 1, &img, &message) != FATHOM_OK) return;
    size_t sum = 0;
    for (size_t i = 0; i < img->channel_count; ++i) {
        const char *plane = img->channels[i].data;
        const size_t last = (size_t)img->width * img->height * sizeof(float) - 1;
        sum += strlen(img->channels[i].name) + (plane[0] == plane[last]);
    }
    for (size_t i = 0; i < img->attribute_count; ++i) sum += strlen(img->attributes[i].name);
    if (sum > answer_size) fuzz_wrong("%zu bytes of texts and channels in %zu bytes", sum, answer_size);
    image_calls.release(img);
}

static void read_texture(void) {
    const image_texture_request request = {.path = "a.png", .descriptor = -1, .most_side = 65536};
    const image_region region = {0, 0, 0, 2, 2};
    image_message message = {""};
    image_texture_info info;
    image_texture *texture;
    unsigned char texels[16];
    if (image_calls.texture.open(&request, &texture, &info, &message) != FATHOM_OK) return;
    if (!info.width || !info.height || info.channels < 1 || info.channels > 4 || !info.band)
        fuzz_wrong("%u x %u texels of %u channels, %u rows at once", info.width, info.height, info.channels,
                   info.band);
    if (!memchr(info.format, '\0', sizeof info.format)) fuzz_wrong("a format without an end");
    image_calls.texture.read(texture, &region, texels, sizeof texels, &message);
    image_calls.texture.close(texture);
}

static void show_pixels(void) {
    const image_view_request request = {.display = "sRGB", .view = "Film"};
    image_message message = {""};
    image_view *view;
    bool srgb;
    float rgba[8] = {0};
    if (image_calls.view_open(&request, &view, &srgb, &message) != FATHOM_OK) return;
    image_calls.view_apply(view, 1, rgba, 2, &message);
    uint64_t files;
    image_calls.view_files(&request, "Film", &files, &message);
    image_calls.view_close(view);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size < HEAD) return 0;
    answer = data, answer_size = size;
    fuzz_begin(size, 16);
    switch (data[0] % 3) {
    case 0: read_image(); break;
    case 1: read_texture(); break;
    case 2: show_pixels(); break;
    }
    fuzz_end();
    return 0;
}
