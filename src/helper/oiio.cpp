/* Image files through OpenImageIO, and the table of the module's calls. */
#include "helper/guard.h"
#include "helper/ktx2_input.h"

#include <OpenColorIO/OpenColorABI.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <iterator>
#include <memory>
#include <unistd.h>
#include <vector>

/* Writes to the descriptor by offset and keeps the first error. With files of their own, libjpeg ends the
 * process when a write fails, and other libraries lose the error. */
class descriptor_output final : public OIIO::Filesystem::IOProxy {
  public:
    descriptor_output(const std::string &name, int descriptor)
        : IOProxy(name, Write), m_descriptor(descriptor) {}
    const char *proxytype() const override { return "descriptor"; }
    size_t size() const override { return m_size; }
    size_t write(const void *bytes, size_t count) override {
        size_t done = pwrite(bytes, count, m_pos);
        m_pos += static_cast<int64_t>(done);
        return done;
    }
    size_t pwrite(const void *bytes, size_t count, int64_t offset) override {
        const char *from = static_cast<const char *>(bytes);
        size_t done = 0;
        while (done < count) {
            ssize_t n = ::pwrite(m_descriptor, from + done, count - done, offset + static_cast<off_t>(done));
            if (n < 0 && errno == EINTR) continue;
            if (n <= 0) {
                if (!failed) failed = n < 0 ? errno : ENOSPC;
                break;
            }
            done += static_cast<size_t>(n);
        }
        m_size = std::max(m_size, static_cast<size_t>(offset) + done);
        return done;
    }
    int failed = 0;

  private:
    int m_descriptor;
    size_t m_size = 0;
};

struct image_writer {
    descriptor_output proxy;
    std::unique_ptr<OIIO::ImageOutput> output;
    uint32_t next_row = 0;
    std::string name;
    OIIO::ImageSpec next_level; /* of a mip-mapped file */
    const int descriptor;
    image_writer(const image_target &target)
        : proxy(target.path, target.descriptor), name(target.path), descriptor(target.descriptor) {}
    ~image_writer() { close(descriptor); }
};

static void check(const image_writer &writer, bool ok) {
    std::string reason = writer.output->geterror();
    if (writer.proxy.failed) throw failure(FATHOM_OUT_OF_RESOURCES, std::strerror(writer.proxy.failed));
    if (!ok || !reason.empty())
        throw failure(FATHOM_OUT_OF_RESOURCES, reason.empty() ? "unknown error" : reason);
}

static OIIO::ImageSpec describe(const image_target &target) {
    const image &img = *target.img;
    OIIO::ImageSpec spec(static_cast<int>(img.width), static_cast<int>(img.height),
                         static_cast<int>(img.channel_count), image_type_of(target.texel));
    spec.x = static_cast<int>(img.x);
    spec.y = static_cast<int>(img.y);
    spec.full_width = static_cast<int>(img.full_width);
    spec.full_height = static_cast<int>(img.full_height);
    for (size_t i = 0; i < img.channel_count; ++i) {
        spec.channelnames[i] = img.channels[i].name;
        if (spec.channelnames[i] == "A") spec.alpha_channel = static_cast<int>(i);
    }
    /* Without a date, OpenImageIO writes the current time. */
    if (target.date) spec.attribute("DateTime", target.date);
    for (size_t i = 0; i < img.attribute_count; ++i) {
        const image_attribute &a = img.attributes[i];
        if (a.text) spec.attribute(a.name, a.text);
    }
    return spec;
}

/* An ICC profile of sRGB (ICC.1:2004-10, version 4.2) as big-endian words: a header, ten tags, their data. It
 * has the primaries of BT.709 and D65, adapted to D50 by Bradford's matrix, and the curve of IEC 61966-2-1.
 */
static const uint32_t srgb_profile[] = {
    0x000001f0, 0,          0x04200000, 0x6d6e7472, 0x52474220, 0x58595a20, 0x07e80001, 0x00010000,
    0,          0x61637370, 0,          0,          0,          0,          0,          0,
    0,          0x0000f6d6, 0x00010000, 0x0000d32d, 0,          0,          0,          0,
    0,          0,          0,          0,          0,          0,          0,          0,
    0x0000000a, 0x64657363, 0x000000fc, 0x00000024, 0x63707274, 0x00000120, 0x00000034, 0x77747074,
    0x00000154, 0x00000014, 0x63686164, 0x00000168, 0x0000002c, 0x7258595a, 0x00000194, 0x00000014,
    0x6758595a, 0x000001a8, 0x00000014, 0x6258595a, 0x000001bc, 0x00000014, 0x72545243, 0x000001d0,
    0x00000020, 0x67545243, 0x000001d0, 0x00000020, 0x62545243, 0x000001d0, 0x00000020, 0x6d6c7563,
    0,          1,          0x0000000c, 0x656e5553, 8,          0x0000001c, 0x00730052, 0x00470042,
    0x6d6c7563, 0,          1,          0x0000000c, 0x656e5553, 0x00000018, 0x0000001c, 0x004e006f,
    0x00200063, 0x006f0070, 0x00790072, 0x00690067, 0x00680074, 0x58595a20, 0,          0x0000f6d6,
    0x00010000, 0x0000d32d, 0x73663332, 0,          0x00010c42, 0x000005de, 0xfffff325, 0x00000793,
    0x0000fd90, 0xfffffba1, 0xfffffda2, 0x000003dc, 0x0000c06e, 0x58595a20, 0,          0x00006fa0,
    0x000038f5, 0x00000390, 0x58595a20, 0,          0x00006297, 0x0000b787, 0x000018d9, 0x58595a20,
    0,          0x0000249f, 0x00000f84, 0x0000b6c3, 0x70617261, 0,          0x00030000, 0x00026666,
    0x0000f2a7, 0x00000d59, 0x000013d0, 0x00000a5b};

static void add_profile(OIIO::ImageSpec &spec) {
    uint32_t bytes[std::size(srgb_profile)];
    std::transform(std::begin(srgb_profile), std::end(srgb_profile), bytes,
                   [](uint32_t word) { return __builtin_bswap32(word); });
    spec.attribute("ICCProfile", OIIO::TypeDesc(OIIO::TypeDesc::UINT8, static_cast<int>(sizeof bytes)),
                   bytes);
}

/* Adds each format's own attributes. */
static void add_format(OIIO::ImageSpec &spec, const image_target &target) {
    switch (target.format) {
    case IMAGE_JPEG:
        /* No chroma subsampling: it blurs the edges of shadows and of coloured objects. */
        spec.attribute("compression", "jpeg:95");
        spec.attribute("jpeg:subsampling", "4:4:4");
        break;
    case IMAGE_TIFF:
        spec.attribute("compression", "zip");
        spec.attribute("tiff:zipquality", 4);
        /* Before 2.5.13 an EXIF directory, which could also mark the file as sRGB, corrupts files that are
         * not written by name. */
        spec.attribute("tiff:write_exif", 0);
        if (target.srgb) add_profile(spec);
        if (target.mipmapped) {
            spec.tile_width = spec.tile_height = static_cast<int>(IMAGE_TILE);
            spec.attribute("textureformat", "Plain Texture");
            OIIO::attribute("tiff:half", 1);
        }
        break;
    case IMAGE_EXR: break; /* write_exr.c */
    case IMAGE_PNG: break; /* write_png.c */
    }
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (target.srgb && target.format != IMAGE_TIFF) spec.attribute("oiio:ColorSpace", "sRGB");
}

/* The reason why an image writer could not be made. Without a reason, threads or memory are lacking. */
static failure no_writer() {
    std::string reason = OIIO::geterror();
    if (reason.empty()) return failure(FATHOM_OUT_OF_RESOURCES, "out of memory or threads");
    return failure(FATHOM_INTERNAL, reason);
}

static fathom_status writer_open(const image_target *target, image_writer **out,
                                 image_message *message) noexcept {
    return guarded(message, FATHOM_OUT_OF_RESOURCES, [&] {
        auto writer = std::make_unique<image_writer>(*target);
        writer->output = OIIO::ImageOutput::create(target->format == IMAGE_JPEG ? "jpeg" : "tiff");
        if (!writer->output) throw no_writer();
        if (!writer->output->supports("ioproxy")) {
            throw failure(FATHOM_INTERNAL, "this OpenImageIO writes the format to named files only");
        }
        OIIO::ImageSpec spec = describe(*target);
        add_format(spec, *target);
        writer->output->threads(static_cast<int>(target->threads));
        /* TIFF can add further levels only to files with a name. */
        if (target->mipmapped) {
            writer->name = "/proc/self/fd/" + std::to_string(target->descriptor);
            writer->next_level = spec;
        } else {
            writer->output->set_ioproxy(&writer->proxy);
        }
        check(*writer, writer->output->open(writer->name, spec));
        *out = writer.release();
    });
}

static fathom_status writer_rows(image_writer *writer, uint32_t count, const void *pixels,
                                 image_message *message) noexcept {
    return guarded(message, FATHOM_OUT_OF_RESOURCES, [&] {
        const OIIO::ImageSpec &spec = writer->output->spec();
        int begin = spec.y + static_cast<int>(writer->next_row), end = begin + static_cast<int>(count);
        check(*writer, spec.tile_width ? writer->output->write_tiles(spec.x, spec.x + spec.width, begin, end,
                                                                     0, 1, spec.format, pixels)
                                       : writer->output->write_scanlines(begin, end, 0, spec.format, pixels));
        writer->next_row += count;
    });
}

static fathom_status writer_level(image_writer *writer, uint32_t width, uint32_t height,
                                  image_message *message) noexcept {
    return guarded(message, FATHOM_OUT_OF_RESOURCES, [&] {
        OIIO::ImageSpec &spec = writer->next_level;
        spec.width = spec.full_width = static_cast<int>(width);
        spec.height = spec.full_height = static_cast<int>(height);
        writer->next_row = 0;
        /* Each level of a TIFF texture is a separate image of the file. */
        check(*writer, writer->output->open(writer->name, spec, OIIO::ImageOutput::AppendSubimage));
    });
}

static fathom_status writer_close(image_writer *writer, bool finish, image_message *message) noexcept {
    return guarded(message, FATHOM_OUT_OF_RESOURCES, [&] {
        std::unique_ptr<image_writer> owner(writer);
        bool ok = owner->output->close();
        if (!finish) {
            owner->output->geterror();
            return;
        }
        check(*owner, ok);
    });
}

/* An image that was read, with the memory that it points to. */
struct file_image : image {
    OIIO::ImageSpec spec;
    std::vector<image_channel> channel_list;
    std::vector<uint32_t> values; /* interleaved; also for floats: both have 32 bits */
};

static bool is_whole(OIIO::TypeDesc stored) { return stored == OIIO::TypeDesc(OIIO::TypeDesc::UINT32); }

/* True if the reader reports no error; some return success for a truncated file and only store the error. */
static bool read_as(OIIO::ImageInput &input, OIIO::TypeDesc type, void *values) {
    return input.read_image(0, 0, 0, input.spec().nchannels, type, values) && !input.has_error();
}

/* Reads channels of several types, and converts them one by one. */
static bool read_mixed(OIIO::ImageInput &input, uint32_t *values) {
    const OIIO::ImageSpec &spec = input.spec();
    std::vector<unsigned char> pixels(spec.image_bytes(true));
    const unsigned char *from = pixels.data();
    const auto bytes = static_cast<OIIO::stride_t>(spec.pixel_bytes(true)),
               wide = static_cast<OIIO::stride_t>(4) * spec.nchannels;
    bool fine = read_as(input, OIIO::TypeDesc::UNKNOWN, pixels.data());
    for (int c = 0; c < spec.nchannels && fine; ++c) {
        const OIIO::TypeDesc stored = spec.channelformat(c);
        fine = OIIO::convert_image(1, spec.width, spec.height, 1, from, stored, bytes, bytes * spec.width,
                                   OIIO::AutoStride, values + c,
                                   is_whole(stored) ? OIIO::TypeDesc::UINT32 : OIIO::TypeDesc::FLOAT, wide,
                                   wide * spec.width, OIIO::AutoStride);
        from += stored.size();
    }
    return fine;
}

/* False: the reader says why. */
static bool read_channels(OIIO::ImageInput &input, file_image &file) {
    const OIIO::ImageSpec &spec = file.spec;
    const auto count = static_cast<size_t>(spec.nchannels);
    file.values.resize(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) * count);
    for (size_t c = 0; c < count; ++c) {
        const OIIO::TypeDesc stored = spec.channelformat(static_cast<int>(c));
        file.channel_list.push_back(
            {spec.channelnames[c].c_str(), is_whole(stored) ? IMAGE_UINT : IMAGE_FLOAT,
             stored == OIIO::TypeDesc(OIIO::TypeDesc::HALF), &file.values[c], 4 * count});
    }
    if (!spec.channelformats.empty()) return read_mixed(input, file.values.data());
    return read_as(input, is_whole(spec.format) ? OIIO::TypeDesc::UINT32 : OIIO::TypeDesc::FLOAT,
                   file.values.data());
}

static void fill(file_image &file) {
    const OIIO::ImageSpec &spec = file.spec;
    file.width = static_cast<uint32_t>(spec.width), file.height = static_cast<uint32_t>(spec.height);
    file.x = static_cast<uint32_t>(spec.x - spec.full_x);
    file.y = static_cast<uint32_t>(spec.y - spec.full_y);
    file.full_width = static_cast<uint32_t>(spec.full_width);
    file.full_height = static_cast<uint32_t>(spec.full_height);
    file.channels = file.channel_list.data(), file.channel_count = file.channel_list.size();
    file.bits = static_cast<uint32_t>(8 * spec.format.size());
}

static fathom_status image_file_read(const char *path, unsigned threads, const image **out,
                                     image_message *message) noexcept {
    return guarded(message, FATHOM_BAD_INPUT, [&] {
        OIIO::attribute("exr_threads", static_cast<int>(threads));
        OIIO::ImageSpec config;
        config.attribute("oiio:UnassociatedAlpha", 1);
        std::string why;
        auto input = image_input_open(path, config, &why);
        if (!input) throw unreadable(why);
        input->threads(static_cast<int>(threads));
        auto file = std::make_unique<file_image>();
        file->spec = input->spec();
        const OIIO::ImageSpec &spec = file->spec;
        if (spec.depth != 1 || spec.deep) throw failure(FATHOM_BAD_INPUT, "is not a flat image");
        if (!read_channels(*input, *file)) throw unreadable(input->geterror());
        fill(*file);
        *out = file.release();
    });
}

static void image_file_release(const image *img) noexcept { delete static_cast<const file_image *>(img); }

extern "C" __attribute__((visibility("default"))) const image_module fathom_image_module = {
    IMAGE_MODULE_VERSION,
    {writer_open, writer_rows, writer_close},
    image_file_read,
    image_file_release,
    image_view_open,
    image_view_apply,
    image_view_close,
    image_view_files,
    image_texture_table,
    writer_level,
    "OpenImageIO " OIIO_VERSION_STRING ", OpenColorIO " OCIO_VERSION_FULL_STR};
