/* The Draco helper: a process that decompresses one mesh. It reads Draco data from standard input. It writes
 * the output that src/read/gltf/gltf_draco.h describes to standard output, or a message and then exits with
 * status 1. If the library crashes, hangs or takes too much memory, the renderer's process continues and
 * reports the failure. */
#include "read/gltf/gltf_draco.h"

#include <draco/compression/decode.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <string>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

/* The message replaces what was already written. */
static int fail(const char *text) {
    std::rewind(stdout);
    if (ftruncate(STDOUT_FILENO, 0) == 0) std::fprintf(stdout, "%s", text);
    return 1;
}

static std::vector<char> read_all() {
    std::vector<char> bytes;
    char block[65536];
    for (size_t n; (n = std::fread(block, 1, sizeof block, stdin)) > 0;)
        bytes.insert(bytes.end(), block, block + n);
    return bytes;
}

static void put(const void *bytes, size_t size) { std::fwrite(bytes, 1, size, stdout); }

/* Writes all numbers as floats; meshes in glTF have no integers above 2^24. */
static bool put_attribute(const draco::PointAttribute &a, uint32_t points) {
    const auto count = static_cast<uint32_t>(a.num_components());
    float values[DRACO_COMPONENTS_MAX];
    const draco_attribute head = {a.unique_id(), count, a.normalized() ? 1u : 0u};
    put(&head, sizeof head);
    for (draco::PointIndex p(0); p < points; ++p) {
        if (!a.ConvertValue<float>(a.mapped_index(p), static_cast<int8_t>(count), values)) return false;
        put(values, count * sizeof *values);
    }
    return true;
}

static int unpack(const std::vector<char> &bytes) {
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;
    buffer.Init(bytes.data(), bytes.size());
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) return fail(decoded.status().error_msg());
    const draco::Mesh &mesh = *decoded.value();
    std::vector<const draco::PointAttribute *> attributes;
    for (int i = 0; i < mesh.num_attributes(); ++i) {
        if (mesh.attribute(i)->num_components() <= DRACO_COMPONENTS_MAX)
            attributes.push_back(mesh.attribute(i));
    }
    const draco_head head = {DRACO_MAGIC, mesh.num_points(), mesh.num_faces(),
                             static_cast<uint32_t>(attributes.size())};
    put(&head, sizeof head);
    for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
        for (const draco::PointIndex &p : mesh.face(f)) {
            const uint32_t index = p.value();
            put(&index, sizeof index);
        }
    }
    for (const draco::PointAttribute *a : attributes) {
        if (!put_attribute(*a, mesh.num_points())) return fail("an attribute cannot be converted");
    }
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return 0;
    return fail(("what it unpacks to cannot be kept: " + std::string(std::strerror(errno))).c_str());
}

static void limit(int resource, rlim_t most) {
    const struct rlimit limits = {most, most};
    setrlimit(static_cast<__rlimit_resource_t>(resource), &limits);
}

int main() {
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, DRACO_SECONDS);
#ifndef FATHOM_SANITIZED
    limit(RLIMIT_AS, DRACO_MEMORY);
#endif
    try {
        return unpack(read_all());
    } catch (const std::exception &e) {
        return fail(e.what());
    }
}
