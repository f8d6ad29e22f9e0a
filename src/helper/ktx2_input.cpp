/* KTX 2.0 files (ktx2/) as an input of OpenImageIO, so that they are read as any other image. */
#include "helper/ktx2_input.h"

#include "helper/guard.h"
#include "helper/ktx2/ktx2.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

/* A file in memory. If another program shortens it meanwhile, only the helper ends. */
class mapped_file {
  public:
    ~mapped_file() {
        if (m_bytes) munmap(m_bytes, m_size);
    }
    bool open(const char *name) {
        struct stat facts;
        if (stat(name, &facts) != 0 || !S_ISREG(facts.st_mode)) return false;
        const int file = ::open(name, O_RDONLY | O_CLOEXEC);
        if (file < 0) return false;
        if (fstat(file, &facts) == 0 && facts.st_size > 0) {
            m_size = static_cast<size_t>(facts.st_size);
            m_bytes = mmap(nullptr, m_size, PROT_READ, MAP_PRIVATE, file, 0);
            if (m_bytes == MAP_FAILED) m_bytes = nullptr;
        }
        close(file);
        return m_bytes != nullptr;
    }
    const uint8_t *bytes() const { return static_cast<const uint8_t *>(m_bytes); }
    size_t size() const { return m_size; }

  private:
    void *m_bytes = nullptr;
    size_t m_size = 0;
};

class ktx2_input final : public OIIO::ImageInput {
  public:
    ~ktx2_input() override { ktx2_rows_close(m_rows); }
    const char *format_name() const override { return "ktx2"; }
    bool upwards() const { return m_image.upwards; }

    /* False if it is not a KTX 2.0 file. Throws `failure` if it cannot be read. */
    bool open(const std::string &name, OIIO::ImageSpec &spec) override {
        if (!m_file.open(name.c_str()) || !ktx2_is(m_file.bytes(), m_file.size())) return false;
        image_message why = {""};
        const fathom_status status = ktx2_open(m_file.bytes(), m_file.size(), &m_image, &why);
        if (status != FATHOM_OK) throw failure(status, why.text);
        describe();
        spec = m_spec;
        return true;
    }

    bool close() override {
        ktx2_rows_close(m_rows);
        m_rows = nullptr;
        return true;
    }

    bool read_native_scanline(int subimage, int miplevel, int y, int, void *data) override {
        lock_guard lock(*this);
        if (!seek_subimage(subimage, miplevel) || y < 0 || y >= m_spec.height) return false;
        return read_row(static_cast<uint32_t>(y), data);
    }

  private:
    void describe() {
        static const std::vector<std::string> names[] = {
            {"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
        const auto channels = static_cast<int>(m_image.channels);
        m_spec = OIIO::ImageSpec(static_cast<int>(std::min(m_image.width, uint32_t{INT32_MAX})),
                                 static_cast<int>(std::min(m_image.height, uint32_t{INT32_MAX})), channels,
                                 OIIO::TypeDesc::UINT8);
        m_spec.channelnames = names[channels - 1];
        m_spec.alpha_channel = channels % 2 == 0 ? channels - 1 : -1;
        m_spec.attribute("oiio:UnassociatedAlpha", m_image.premultiplied ? 0 : 1);
        m_spec.attribute(IMAGE_INPUT_TRANSFER, static_cast<int>(m_image.transfer));
    }

    bool check(fathom_status status, const image_message &why) {
        if (status == FATHOM_OUT_OF_RESOURCES) throw std::bad_alloc();
        if (status != FATHOM_OK) errorfmt("{}", why.text);
        return status == FATHOM_OK;
    }

    /* Rows are decoded in the order of the file. */
    bool read_row(uint32_t y, void *data) {
        image_message why = {""};
        if (m_rows && y < m_next) close();
        if (!m_rows) {
            m_next = 0;
            if (!check(ktx2_rows_open(&m_image, &m_rows, &why), why)) return false;
        }
        for (; m_next <= y; ++m_next) {
            if (!check(ktx2_rows_next(m_rows, static_cast<uint8_t *>(data), &why), why)) {
                close();
                return false;
            }
        }
        return true;
    }

    mapped_file m_file;
    ktx2_image m_image = {};
    ktx2_rows *m_rows = nullptr;
    uint32_t m_next = 0; /* the row that m_rows decodes next */
};

/* A file that begins with the image's lowest row. The top row comes last, so the first request decodes the
 * whole image. */
class upwards_input final : public OIIO::ImageInput {
  public:
    explicit upwards_input(std::unique_ptr<OIIO::ImageInput> file) : m_file(std::move(file)) {
        m_spec = m_file->spec();
    }
    const char *format_name() const override { return m_file->format_name(); }
    bool open(const std::string &, OIIO::ImageSpec &) override { return false; } /* it is open */
    bool close() override { return m_file->close(); }

    bool read_native_scanline(int, int, int y, int, void *data) override {
        lock_guard lock(*this);
        const size_t row = m_spec.scanline_bytes(true);
        if (m_all.empty()) {
            std::vector<uint8_t> all(m_spec.image_bytes(true));
            if (!m_file->read_image(0, 0, 0, m_spec.nchannels, OIIO::TypeDesc::UNKNOWN, all.data())) {
                errorfmt("{}", m_file->geterror());
                return false;
            }
            m_all.swap(all);
        }
        std::copy_n(m_all.data() + row * static_cast<size_t>(m_spec.height - 1 - y), row,
                    static_cast<uint8_t *>(data));
        return true;
    }

  private:
    std::unique_ptr<OIIO::ImageInput> m_file;
    std::vector<uint8_t> m_all;
};

/* A Radiance file says so by +Y in its header. In other formats, the orientation is that of a camera, which
 * textures ignore. */
static bool is_upwards(const OIIO::ImageInput &file) {
    return std::strcmp(file.format_name(), "hdr") == 0 && file.spec().get_int_attribute("Orientation") == 4;
}

/* With a config, OpenImageIO asks each reader whether the file is valid, and the reader of SGI files denies
 * its own. Without one, it opens the file by each reader. */
static std::unique_ptr<OIIO::ImageInput> open_any(const std::string &name, const OIIO::ImageSpec &config,
                                                  std::string *why) {
    OIIO::ImageSpec spec;
    auto file = OIIO::ImageInput::open(name, &config);
    if (file) return file;
    *why = OIIO::geterror();
    file = OIIO::ImageInput::open(name);
    if (file && file->close() && file->open(name, spec, config)) return file;
    OIIO::geterror(); /* clears it */
    return nullptr;
}

std::unique_ptr<OIIO::ImageInput> image_input_open(const std::string &name, const OIIO::ImageSpec &config,
                                                   std::string *why) {
    auto ktx2 = std::make_unique<ktx2_input>();
    OIIO::ImageSpec spec;
    std::unique_ptr<OIIO::ImageInput> file;
    bool upwards = false;
    if (ktx2->open(name, spec)) {
        upwards = ktx2->upwards();
        file = std::move(ktx2);
    } else {
        file = open_any(name, config, why);
        upwards = file && is_upwards(*file);
    }
    return upwards ? std::make_unique<upwards_input>(std::move(file)) : std::move(file);
}
