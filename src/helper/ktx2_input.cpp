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
        const auto row = static_cast<uint32_t>(y);
        return m_image.upwards ? read_upwards(row, data) : read_row(row, data);
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

    /* For files that begin with the image's lowest row. The top row comes last, so the first request
     * decodes the whole image. */
    bool read_upwards(uint32_t y, void *data) {
        const size_t row = static_cast<size_t>(m_image.width) * m_image.channels;
        if (m_all.empty()) {
            std::vector<uint8_t> all(row * m_image.height);
            for (uint32_t i = 0; i < m_image.height; ++i)
                if (!read_row(i, all.data() + row * (m_image.height - 1 - i))) return false;
            m_all.swap(all);
        }
        std::copy_n(m_all.data() + row * y, row, static_cast<uint8_t *>(data));
        return true;
    }

    mapped_file m_file;
    ktx2_image m_image = {};
    ktx2_rows *m_rows = nullptr;
    uint32_t m_next = 0; /* the row that m_rows decodes next */
    std::vector<uint8_t> m_all;
};

std::unique_ptr<OIIO::ImageInput> image_input_open(const std::string &name, const OIIO::ImageSpec &config) {
    auto ktx2 = std::make_unique<ktx2_input>();
    OIIO::ImageSpec spec;
    if (ktx2->open(name, spec)) return ktx2;
    return OIIO::ImageInput::open(name, &config);
}
