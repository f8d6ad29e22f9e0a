/* Textures: images that are read in parts. */
#include "helper/guard.h"
#include "helper/ktx2_input.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <unistd.h>
#include <vector>

using OIIO::TypeDesc;

/* Closes the descriptor on destruction. */
struct owned_descriptor {
    int number;
    ~owned_descriptor() {
        if (number >= 0) close(number);
    }
};

struct image_texture {
    owned_descriptor descriptor{-1}; /* outlives `input` */
    std::unique_ptr<OIIO::ImageInput> input;
    std::vector<OIIO::ImageSpec> levels; /* one, unless the file is mip-mapped */
    image_texture_info info{};
    int first_channel = 0;
    bool premultiplied = false;
    bool windowed = false; /* the data lie in another window than the display's, which is the texture */
    std::vector<unsigned char> data; /* all of it, if windowed */
    std::unique_ptr<image_space> space;
};

static std::string names_of(const OIIO::ImageSpec &spec) {
    std::string list;
    for (const std::string &name : spec.channelnames) list += (list.empty() ? "" : ", ") + name;
    return list;
}

/* Chooses R, G, B and optionally A, which OpenImageIO sorts to be adjacent; otherwise all channels, if there
 * are at most four. */
static void choose_channels(image_texture &t, const OIIO::ImageSpec &spec) {
    const std::vector<std::string> &names = spec.channelnames;
    const auto count = static_cast<uint32_t>(spec.nchannels); /* of FITS files, only one has a name */
    auto is = [&](size_t i, const char *name) { return i < names.size() && names[i] == name; };
    for (size_t i = 0; i < names.size(); ++i) {
        if (!is(i, "R") || !is(i + 1, "G") || !is(i + 2, "B")) continue;
        t.first_channel = static_cast<int>(i);
        t.info.channels = is(i + 3, "A") ? 4 : 3;
        return;
    }
    /* OpenImageIO calls grey and alpha of a TGA file R and G. */
    const bool alpha = count == 2 && (is(1, "A") || spec.alpha_channel == 1 ||
                                      std::strcmp(t.input->format_name(), "targa") == 0);
    if (count > 4 || (count == 2 && !alpha)) {
        throw failure(FATHOM_BAD_INPUT,
                      "expected the channels R, G and B, or one, three or four, or grey and A; found " +
                          names_of(spec));
    }
    t.info.channels = count;
}

static TypeDesc widest(const OIIO::ImageSpec &spec, int first, int end) {
    TypeDesc type = spec.channelformat(first);
    for (int c = first + 1; c < end; ++c) {
        TypeDesc other = spec.channelformat(c);
        if (other != type) type = TypeDesc(TypeDesc::FLOAT);
    }
    return type;
}

static image_texel texel_of(TypeDesc type) {
    switch (type.basetype) {
    case TypeDesc::UINT8: return IMAGE_TEXEL_U8;
    case TypeDesc::UINT16: return IMAGE_TEXEL_U16;
    case TypeDesc::HALF: return IMAGE_TEXEL_HALF;
    default: return IMAGE_TEXEL_FLOAT;
    }
}

/* read() gives the texels of an OpenEXR file's display window. Other formats only have places on a page,
 * which do not matter. */
static OIIO::ImageSpec shown(const OIIO::ImageInput &input) {
    OIIO::ImageSpec spec = input.spec();
    if (std::strcmp(input.format_name(), "openexr") == 0) {
        spec.x = spec.full_x, spec.y = spec.full_y;
        spec.width = spec.full_width, spec.height = spec.full_height;
    }
    return spec;
}

static bool fits_tiles(const OIIO::ImageSpec &spec) {
    auto fits = [](int side) { return side > 0 && static_cast<int>(IMAGE_TILE) % side == 0; };
    return fits(spec.tile_width) && fits(spec.tile_height) && spec.tile_depth <= 1;
}

/* If the file has all levels down to one texel, t.levels gets them; otherwise only level 0. */
static void find_levels(image_texture &t) {
    OIIO::ImageSpec level = shown(*t.input);
    t.levels = {level};
    if (t.windowed) return;
    while (fits_tiles(level) && (level.width > 1 || level.height > 1)) {
        const int width = std::max(level.width / 2, 1), height = std::max(level.height / 2, 1);
        level = t.input->spec(0, static_cast<int>(t.levels.size()));
        if (level.width != width || level.height != height) break;
        t.levels.push_back(level);
    }
    t.input->geterror(); /* clears the error about the missing level */
    t.info.mipmapped = fits_tiles(level) && level.width == 1 && level.height == 1;
    if (!t.info.mipmapped) t.levels.resize(1);
}

static void check_size(const OIIO::ImageSpec &spec, const image_texture_request &request) {
    const uint64_t width = static_cast<uint64_t>(spec.width), height = static_cast<uint64_t>(spec.height);
    if (spec.depth > 1 || spec.deep) throw failure(FATHOM_BAD_INPUT, "expected a flat image");
    if (spec.width < 1 || spec.height < 1) throw failure(FATHOM_BAD_INPUT, "expected at least one texel");
    if (std::max(width, height) > request.most_side || width * height > request.most_texels) {
        throw failure(FATHOM_BAD_INPUT, "expected at most " + std::to_string(request.most_side) +
                                            " texels on a side and " + std::to_string(request.most_texels) +
                                            " in all, found " + std::to_string(width) + " x " +
                                            std::to_string(height));
    }
}

/* Files of other formats are not premultiplied, by their definition or by the option passed to OpenImageIO.
 * Its versions before 3 multiply WebP's colours by alpha in spite of the option. */
static bool is_premultiplied(const image_texture &t, const OIIO::ImageSpec &spec) {
    const std::string format = t.input->format_name();
    const bool may = format == "openexr" || format == "tiff" || format == "ktx2" ||
                     (format == "webp" && OIIO_VERSION_MAJOR < 3);
    return may && t.info.channels % 2 == 0 && !spec.get_int_attribute("oiio:UnassociatedAlpha");
}

/* KTX 2.0 files say how they are encoded, and so do those of `fathom texture`. So do PNGs whose gamma is 1;
 * no program means other gammas. */
static image_transfer transfer_of(const image_texture &t) {
    const OIIO::ImageSpec &spec = t.input->spec();
    const std::string text = spec.get_string_attribute("ImageDescription");
    if (text == IMAGE_SAYS_LINEAR) return IMAGE_TRANSFER_LINEAR;
    if (text == IMAGE_SAYS_SRGB) return IMAGE_TRANSFER_SRGB;
    if (std::strcmp(t.input->format_name(), "png") == 0 && spec.get_float_attribute("oiio:Gamma") == 1)
        return IMAGE_TRANSFER_LINEAR;
    return static_cast<image_transfer>(spec.get_int_attribute(IMAGE_INPUT_TRANSFER));
}

static void describe(image_texture &t, const image_texture_request &request) {
    const OIIO::ImageSpec spec = shown(*t.input);
    check_size(t.input->spec(), request);
    check_size(spec, request);
    t.windowed = spec.roi() != t.input->spec().roi();
    choose_channels(t, spec);
    t.info.width = static_cast<uint32_t>(spec.width), t.info.height = static_cast<uint32_t>(spec.height);
    const TypeDesc type = widest(spec, t.first_channel, t.first_channel + static_cast<int>(t.info.channels));
    const image_texel texel = texel_of(type);
    t.info.sent = t.info.kept = texel;
    t.info.integers = !type.is_floating_point();
    t.info.transfer = transfer_of(t);
    std::snprintf(t.info.format, sizeof t.info.format, "%s", t.input->format_name());
    t.info.band = static_cast<uint32_t>(std::max(spec.tile_height, 1));
    t.premultiplied = is_premultiplied(t, spec);
    if (t.premultiplied && texel == IMAGE_TEXEL_HALF) t.info.sent = IMAGE_TEXEL_FLOAT;
    if (!request.space) return;
    t.info.sent = IMAGE_TEXEL_FLOAT;
    t.info.kept = texel == IMAGE_TEXEL_U8 || texel == IMAGE_TEXEL_HALF ? IMAGE_TEXEL_HALF : IMAGE_TEXEL_FLOAT;
    if (t.info.channels < 3) {
        throw failure(FATHOM_BAD_INPUT, std::string("expected the channels R, G and B for the color space ") +
                                            request.space + ", found " + names_of(spec));
    }
    t.space = space_open(request.config, request.space);
}

/* A reason that does not quote a name that its reader has never seen. */
static std::string without(std::string reason, const std::string &name) {
    const std::string quoted = '"' + name + '"';
    for (size_t at; (at = reason.find(quoted)) != std::string::npos;)
        reason.replace(at, quoted.size(), "its bytes");
    return reason;
}

static fathom_status texture_open(const image_texture_request *request, image_texture **out,
                                  image_texture_info *info, image_message *message) noexcept {
    auto t = std::unique_ptr<image_texture>(new (std::nothrow) image_texture);
    if (t) t->descriptor.number = request->path ? -1 : request->descriptor;
    return guarded(message, FATHOM_BAD_INPUT, [&] {
        if (!t) throw std::bad_alloc();
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        OIIO::attribute("exr_threads", static_cast<int>(request->threads));
        /* A name without an extension: OpenImageIO tries all formats. */
        const std::string name =
            request->path ? request->path : "/proc/self/fd/" + std::to_string(request->descriptor);
        std::string why;
        t->input = image_input_open(name, config, &why);
        if (!t->input) throw unreadable(request->path ? why : without(why, name));
        /* OpenImageIO opens a truncated progressive JPEG file, of which it decodes every scan, and stores the
         * error. */
        if (t->input->has_error()) throw unreadable(t->input->geterror());
        t->input->threads(static_cast<int>(request->threads));
        describe(*t, *request);
        find_levels(*t);
        *info = t->info;
        *out = t.release();
    });
}

static bool read_native(image_texture &t, const image_region &r, const OIIO::ImageSpec &spec, void *texels) {
    const int level = static_cast<int>(r.level), end = t.first_channel + static_cast<int>(t.info.channels);
    const int x0 = spec.x + static_cast<int>(r.x0), x1 = spec.x + static_cast<int>(r.x1);
    const int y0 = spec.y + static_cast<int>(r.y0), y1 = spec.y + static_cast<int>(r.y1);
    const TypeDesc type = image_type_of(t.info.sent);
    if (!spec.tile_width)
        return t.input->read_scanlines(0, level, y0, y1, 0, t.first_channel, end, type, texels);
    return t.input->read_tiles(0, level, x0, x1, y0, y1, 0, 1, t.first_channel, end, type, texels);
}

/* Rows of the display window. Black and clear where there is no data. */
static bool read_window(image_texture &t, const image_region &r, const OIIO::ImageSpec &window,
                        unsigned char *texels) {
    const OIIO::ImageSpec &spec = t.input->spec();
    const size_t size = t.info.channels * image_texel_size(t.info.sent);
    auto width = static_cast<size_t>(spec.width), row = static_cast<size_t>(window.width);
    if (t.data.empty()) {
        t.data.resize(width * static_cast<size_t>(spec.height) * size);
        if (!t.input->read_image(0, 0, t.first_channel, t.first_channel + static_cast<int>(t.info.channels),
                                 image_type_of(t.info.sent), t.data.data()))
            return false;
    }
    const int y0 = window.y + static_cast<int>(r.y0), y1 = window.y + static_cast<int>(r.y1);
    const int x0 = std::max(window.x, spec.x), x1 = std::min(window.x + window.width, spec.x + spec.width);
    std::fill(texels, texels + row * (r.y1 - r.y0) * size, 0);
    for (int y = std::max(y0, spec.y); x0 < x1 && y < std::min(y1, spec.y + spec.height); ++y) {
        auto to = static_cast<size_t>(y - y0) * row + static_cast<size_t>(x0 - window.x);
        auto from = static_cast<size_t>(y - spec.y) * width + static_cast<size_t>(x0 - spec.x);
        std::copy_n(t.data.data() + from * size, static_cast<size_t>(x1 - x0) * size, texels + to * size);
    }
    return true;
}

static float quotient(float color, float alpha) { return color / alpha; }

/* Rounded, and at most 1, which is `One`. */
template <uint32_t One> static uint32_t whole_quotient(uint32_t color, uint32_t alpha) {
    return std::min((color * One + alpha / 2) / alpha, One);
}
static uint8_t quotient(uint8_t color, uint8_t alpha) {
    return static_cast<uint8_t>(whole_quotient<UINT8_MAX>(color, alpha));
}
static uint16_t quotient(uint16_t color, uint16_t alpha) {
    return static_cast<uint16_t>(whole_quotient<UINT16_MAX>(color, alpha));
}

/* Divides colours by alpha. */
template <typename Number> static void divide(void *texels, size_t count, size_t channels) {
    Number *t = static_cast<Number *>(texels);
    for (Number *end = t + count * channels; t != end; t += channels) {
        const Number alpha = t[channels - 1];
        for (size_t c = 0; c + 1 < channels && alpha != 0; ++c) t[c] = quotient(t[c], alpha);
    }
}

static void divide_texels(const image_texture &t, void *texels, size_t count) {
    switch (t.info.sent) {
    case IMAGE_TEXEL_U8: divide<uint8_t>(texels, count, t.info.channels); break;
    case IMAGE_TEXEL_U16: divide<uint16_t>(texels, count, t.info.channels); break;
    case IMAGE_TEXEL_HALF: break; /* describe() asks for floats */
    case IMAGE_TEXEL_FLOAT: divide<float>(texels, count, t.info.channels); break;
    }
}

static fathom_status texture_read(image_texture *t, const image_region *region, void *texels, size_t bytes,
                                  image_message *message) noexcept {
    return guarded(message, FATHOM_BAD_INPUT, [&] {
        const image_region &r = *region;
        if (r.level >= t->levels.size()) throw failure(FATHOM_INTERNAL, "there is no such level");
        const OIIO::ImageSpec &spec = t->levels[r.level];
        const size_t count = static_cast<size_t>(r.x1 - r.x0) * (r.y1 - r.y0);
        if (r.x0 >= r.x1 || r.y0 >= r.y1 || r.x1 > static_cast<uint32_t>(spec.width) ||
            r.y1 > static_cast<uint32_t>(spec.height) ||
            bytes != count * t->info.channels * image_texel_size(t->info.sent)) {
            throw failure(FATHOM_INTERNAL, "there is no such region");
        }
        /* Some readers return success for a truncated file and only store the error. */
        if (!(t->windowed ? read_window(*t, r, spec, static_cast<unsigned char *>(texels))
                          : read_native(*t, r, spec, texels)) ||
            t->input->has_error())
            throw unreadable(t->input->geterror());
        if (t->premultiplied) divide_texels(*t, texels, count);
        if (t->space) t->space->apply(static_cast<float *>(texels), count, t->info.channels);
    });
}

static void texture_close(image_texture *t) noexcept { delete t; }

const image_texture_calls image_texture_table = {texture_open, texture_read, texture_close};
