/* Texture lookups a second, by Fathom and by OpenImageIO's TextureSystem: texture THREADS LIMIT FILE.tx...
 *
 * Both filter the same places of the same files alike: trilinear, with a round footprint. Fathom decodes sRGB
 * besides. Each pattern runs once to read the tiles, then for two seconds. Prints rows of a table. */
#include <OpenImageIO/texture.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <thread>
#include <vector>

extern "C" {
#include "texture/texture.h"
}

struct place {
    unsigned texture;
    float u, v, width;
};

enum { BLOCK = TEXTURE_BLOCK, PLACES = 1 << 18 };

static unsigned next(unsigned &state) { return state = state * 1664525u + 1013904223u; }
static float uniform(unsigned &state) { return static_cast<float>(next(state) >> 8) * 0x1p-24f; }

/* Neighbouring pixels of squares of 64 × 64, each square somewhere in one texture. A step is 2^-finest or up
 * to 2^range as wide. */
static std::vector<place> squares(unsigned textures, unsigned seed, size_t count, float finest, float range) {
    std::vector<place> list(count);
    for (size_t i = 0; i < count; i += 4096) {
        const unsigned t = (next(seed) >> 8) % textures;
        const float u = uniform(seed), v = uniform(seed), step = std::exp2(range * uniform(seed) - finest);
        for (unsigned k = 0; k < 4096; ++k)
            list[i + k] = {t, u + step * static_cast<float>(k % 64), v + step * static_cast<float>(k / 64),
                           step};
    }
    return list;
}

/* Small parts again and again, as a close surface shows; and parts at full resolution all over the textures.
 */
static std::vector<place> coherent(unsigned textures, unsigned seed) {
    return squares(textures, seed, PLACES, 11, 3);
}
static std::vector<place> spread(unsigned textures, unsigned seed) {
    return squares(textures, seed, 16 * PLACES, 12, 0);
}

static std::vector<place> incoherent(unsigned textures, unsigned seed) {
    std::vector<place> list(PLACES);
    for (place &p : list)
        p = {(next(seed) >> 8) % textures, uniform(seed), uniform(seed), std::exp2(-4 - 7 * uniform(seed))};
    return list;
}

static float look_fathom(texture_cache *cache, const std::vector<place> &places) {
    texture_queries q = {};
    float rgba[4][BLOCK], sum = 0;
    q.count = BLOCK;
    for (size_t i = 0; i < places.size(); i += BLOCK) {
        for (unsigned k = 0; k < BLOCK; ++k) {
            const place &p = places[i + k];
            q.texture[k] = p.texture, q.u[k] = p.u, q.v[k] = p.v, q.width[k] = p.width;
        }
        texture_lookup(cache, &q, rgba);
        for (unsigned k = 0; k < BLOCK; ++k) sum += rgba[0][k];
    }
    return sum;
}

struct system_files {
    OIIO::TextureSystem *system;
    std::vector<OIIO::TextureSystem::TextureHandle *> handles;
};

static float look_system(const system_files &files, const std::vector<place> &places) {
    OIIO::TextureSystem::Perthread *own = files.system->get_perthread_info();
    OIIO::TextureOpt options;
    options.swrap = options.twrap = OIIO::TextureOpt::WrapPeriodic;
    options.mipmode = OIIO::TextureOpt::MipModeTrilinear;
    options.interpmode = OIIO::TextureOpt::InterpBilinear;
    float sum = 0;
    for (const place &p : places) {
        float rgb[3];
        files.system->texture(files.handles[p.texture], own, options, p.u, p.v, p.width, 0, 0, p.width, 3,
                              rgb);
        sum += rgb[0];
    }
    return sum;
}

/* Millions of lookups a second, after one round. */
template <class Look>
static double rate(unsigned threads, const std::vector<std::vector<place>> &places, Look look) {
    auto all = [&] {
        std::vector<std::thread> list;
        for (unsigned t = 0; t < threads; ++t)
            list.emplace_back([&, t] {
                volatile float sum = look(places[t]);
                (void)sum;
            });
        for (std::thread &t : list) t.join();
    };
    /* Of the processor, all threads together: other programs do not count. */
    auto seconds = [](std::clock_t since) {
        return static_cast<double>(std::clock() - since) / CLOCKS_PER_SEC;
    };
    all();
    unsigned rounds = 0;
    const std::clock_t start = std::clock();
    do all(), ++rounds;
    while (seconds(start) < 2);
    return 1e-6 * rounds * threads * threads * static_cast<double>(places[0].size()) / seconds(start);
}

static texture_cache *open_cache(fathom_context *context, fathom_scene *scene, double limit, int count,
                                 char **files) {
    texture_cache *cache = nullptr;
    for (int i = 0; i < count; ++i) {
        fathom_texture t;
        fathom_texture_default(&t);
        t.file = files[i];
        if (fathom_scene_add_texture(scene, &t, nullptr) != FATHOM_OK) return nullptr;
    }
    texture_cache_open(context, scene, static_cast<uint64_t>(limit), &cache);
    return cache;
}

int main(int argc, char **argv) {
    if (argc < 4) return 2;
    const unsigned threads = static_cast<unsigned>(std::atoi(argv[1]));
    const int count = argc - 3;
    const double limit = std::atof(argv[2]);
    fathom_context *context;
    fathom_scene *scene;
    if (fathom_context_create(&context) != FATHOM_OK || fathom_scene_create(context, &scene) != FATHOM_OK)
        return 4;
    texture_cache *cache = open_cache(context, scene, limit, count, argv + 3);
    if (!cache) return std::fprintf(stderr, "%s\n", fathom_context_message(context)), 3;
    system_files files{OIIO::TextureSystem::create(false), {}};
    files.system->attribute("max_memory_MB", static_cast<float>(limit * 1e-6));
    for (int i = 0; i < count; ++i)
        files.handles.push_back(files.system->get_texture_handle(OIIO::ustring(argv[3 + i])));
    const struct {
        const char *name;
        std::vector<place> (*make)(unsigned textures, unsigned seed);
    } patterns[] = {{"coherent", coherent}, {"spread", spread}, {"incoherent", incoherent}};
    for (const auto &pattern : patterns) {
        std::vector<std::vector<place>> places;
        for (unsigned t = 0; t < threads; ++t)
            places.push_back(pattern.make(static_cast<unsigned>(count), t));
        const double ours = rate(threads, places, [&](auto &list) { return look_fathom(cache, list); });
        const double theirs = rate(threads, places, [&](auto &list) { return look_system(files, list); });
        std::printf("| %s | %u | %.0f MB | %.1f | %.1f | %.1f |\n", pattern.name, threads, limit * 1e-6, ours,
                    theirs, ours / theirs);
    }
    const fathom_status status = texture_cache_check(cache, context);
    if (status != FATHOM_OK) std::fprintf(stderr, "%s\n", fathom_context_message(context));
    texture_cache_close(cache);
    fathom_scene_destroy(scene);
    fathom_context_destroy(context);
    return status;
}
