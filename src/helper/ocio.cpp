/* Displays and views of OpenColorIO. */
#include "helper/guard.h"

extern "C" {
#include "base/hash.h"
}

#include <OpenColorIO/OpenColorIO.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <future>
#include <sstream>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace OCIO = OCIO_NAMESPACE;

/* The default config; OpenColorIO 2.1 has no built-in one. The sRGB curve is that of IEC 61966-2-1, but the
 * slope of its linear part is not rounded to 12.92: the maximum difference is 1e-5. */
static const char built_in_config[] = R"(ocio_profile_version: 2
name: fathom
description: Linear Rec.709 for sRGB screens.
environment: {}
strictparsing: true
roles:
  default: Linear Rec.709
  scene_linear: Linear Rec.709
file_rules:
  - !<Rule> {name: Default, colorspace: default}
displays:
  sRGB:
    - !<View> {name: sRGB, colorspace: sRGB}
    - !<View> {name: ACES 1.0 SDR, colorspace: sRGB ACES 1.0 SDR}
    - !<View> {name: Raw, colorspace: Raw}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: Linear Rec.709
    isdata: false
  - !<ColorSpace>
    name: sRGB
    isdata: false
    from_scene_reference: !<ExponentWithLinearTransform>
      {gamma: 2.4, offset: 0.055, style: mirror, direction: inverse}
  - !<ColorSpace>
    name: sRGB ACES 1.0 SDR
    isdata: false
    from_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD, direction: inverse}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD, direction: inverse}
        - !<BuiltinTransform> {style: ACES-OUTPUT - ACES2065-1_to_CIE-XYZ-D65 - SDR-VIDEO_1.0}
        - !<BuiltinTransform> {style: DISPLAY - CIE-XYZ-D65_to_sRGB}
  - !<ColorSpace>
    name: ACEScg
    isdata: false
    to_scene_reference: !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD}
  - !<ColorSpace>
    name: ACES2065-1
    isdata: false
    to_scene_reference: !<GroupTransform>
      children:
        - !<BuiltinTransform> {style: UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD, direction: inverse}
        - !<BuiltinTransform> {style: UTILITY - ACES-AP1_to_LINEAR-REC709_BFD}
  - !<ColorSpace>
    name: Raw
    isdata: true
)";

struct image_view {
    OCIO::ConstCPUProcessorRcPtr processor;
};

static OCIO::ConstConfigRcPtr load_config(const char *path) {
    /* The library reports by exceptions and must not print. */
    OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);
    if (!path) {
        std::istringstream text(built_in_config);
        return OCIO::Config::CreateFromStream(text);
    }
    struct stat info;
    bool file = std::strncmp(path, "ocio://", 7) != 0; /* else a config built into newer libraries */
    if (file && (stat(path, &info) != 0 || access(path, R_OK) != 0)) {
        throw failure(FATHOM_BAD_INPUT, std::string("cannot be read: ") + std::strerror(errno));
    }
    if (file && S_ISDIR(info.st_mode)) throw failure(FATHOM_BAD_INPUT, "cannot be read: is a folder");
    if (file && !S_ISREG(info.st_mode)) {
        /* Reading a pipe may block, and some devices have no end. */
        throw failure(FATHOM_BAD_INPUT, "cannot be read: is not a regular file");
    }
    return OCIO::Config::CreateFromFile(path);
}

/* The entry of a list with the name `wanted`, ignoring case. If there is none, throws a failure that lists
 * the entries, after the `others` that are names without a config. */
template <class Name>
static std::string choose(const char *wanted, const std::string &what, int count, Name name,
                          const std::string &others = "") {
    std::string list;
    for (int i = 0; i < count; ++i) {
        if (strcasecmp(name(i), wanted) == 0) return name(i);
        list += std::string(i ? ", " : "") + "\"" + name(i) + "\"";
    }
    throw failure(FATHOM_BAD_USAGE, "no " + what + " \"" + wanted + "\"; expected " + others +
                                        "one of: " + (count ? list : "(none)"));
}

static std::string choose_display(const OCIO::ConstConfigRcPtr &config, const char *wanted) {
    if (wanted) {
        return choose(wanted, "display", config->getNumDisplays(),
                      [&](int i) { return config->getDisplay(i); });
    }
    std::string display = config->getDefaultDisplay();
    if (display.empty()) throw failure(FATHOM_BAD_INPUT, "the config has no display");
    return display;
}

static std::string choose_view(const OCIO::ConstConfigRcPtr &config, const std::string &display,
                               const char *wanted) {
    const char *d = display.c_str();
    if (wanted) {
        return choose(wanted, "view of display \"" + display + "\" is", config->getNumViews(d),
                      [&](int i) { return config->getView(d, i); });
    }
    std::string view = config->getDefaultView(d);
    if (view.empty()) throw failure(FATHOM_BAD_INPUT, "display \"" + display + "\" has no view");
    return view;
}

/* The config's name of linear Rec.709: one of the names in published configs, including Blender's. */
static std::string linear_rec709(const OCIO::ConstConfigRcPtr &config) {
    static const char *const names[] = {"lin_rec709_scene",
                                        "lin_rec709",
                                        "Linear Rec.709 (sRGB)",
                                        "Linear Rec.709",
                                        "lin_srgb",
                                        "Utility - Linear - sRGB",
                                        "Utility - Linear - Rec.709"};
    for (const char *name : names) {
        if (OCIO::ConstColorSpaceRcPtr space = config->getColorSpace(name)) return space->getName();
    }
    return "";
}

static void append_builtin(const OCIO::GroupTransformRcPtr &group, const char *style,
                           OCIO::TransformDirection direction) {
    OCIO::BuiltinTransformRcPtr transform = OCIO::BuiltinTransform::Create();
    transform->setStyle(style);
    transform->setDirection(direction);
    group->appendTransform(transform);
}

/* The name of a view's output space. *data: whether it is for data, which is not transformed. */
static std::string last_space(const OCIO::ConstConfigRcPtr &config, const std::string &display,
                              const std::string &view, bool *data) {
    std::string name = config->getDisplayViewColorSpaceName(display.c_str(), view.c_str());
    if (name.empty() || name == "<USE_DISPLAY_NAME>") name = display;
    OCIO::ConstColorSpaceRcPtr space = config->getColorSpace(name.c_str());
    *data = space && space->isData();
    return name;
}

/* The transform from linear Rec.709 to the view; through ACES2065-1 if the config has only that. */
static OCIO::ConstTransformRcPtr whole_way(const OCIO::ConstConfigRcPtr &config, const std::string &display,
                                           const std::string &view) {
    OCIO::DisplayViewTransformRcPtr last = OCIO::DisplayViewTransform::Create();
    last->setDisplay(display.c_str());
    last->setView(view.c_str());
    std::string source = linear_rec709(config);
    if (!source.empty()) {
        last->setSrc(source.c_str());
        return last;
    }
    bool data = false;
    last_space(config, display, view, &data);
    if (config->hasRole(OCIO::ROLE_INTERCHANGE_SCENE) && !data) {
        OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
        append_builtin(group, "UTILITY - ACES-AP1_to_LINEAR-REC709_BFD", OCIO::TRANSFORM_DIR_INVERSE);
        append_builtin(group, "UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD", OCIO::TRANSFORM_DIR_FORWARD);
        append_builtin(group, "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD", OCIO::TRANSFORM_DIR_INVERSE);
        last->setSrc(OCIO::ROLE_INTERCHANGE_SCENE);
        group->appendTransform(last);
        return group;
    }
    if (!config->hasRole(OCIO::ROLE_SCENE_LINEAR)) {
        throw failure(FATHOM_BAD_INPUT, "the config has no color space for linear Rec.709, no role "
                                        "aces_interchange and no role scene_linear");
    }
    last->setSrc(OCIO::ROLE_SCENE_LINEAR);
    return last;
}

static bool is_srgb(const OCIO::ConstConfigRcPtr &config, const std::string &display,
                    const std::string &view) {
    bool data = false;
    std::string space = last_space(config, display, view, &data);
    return !data && (strcasestr(space.c_str(), "srgb") || strcasestr(display.c_str(), "srgb"));
}

static OCIO::ConstProcessorRcPtr view_processor(const OCIO::ConstConfigRcPtr &config,
                                                const std::string &display, const std::string &view) {
    return config->getProcessor(whole_way(config, display, view), OCIO::TRANSFORM_DIR_FORWARD);
}

fathom_status image_view_open(const image_view_request *request, image_view **out, bool *srgb,
                              image_message *message) noexcept {
    return guarded(message, FATHOM_BAD_INPUT, [&] {
        OCIO::ConstConfigRcPtr config = load_config(request->config);
        std::string display = choose_display(config, request->display);
        std::string view = choose_view(config, display, request->view);
        OCIO::ConstCPUProcessorRcPtr cpu = view_processor(config, display, view)->getDefaultCPUProcessor();
        *srgb = is_srgb(config, display, view);
        *out = new image_view{cpu};
    });
}

using pixels_of = std::pair<float *, std::size_t>;

static void apply(const image_view *view, pixels_of part) {
    OCIO::PackedImageDesc pixels(part.first, static_cast<long>(part.second), 1, 4);
    view->processor->apply(pixels);
}

/* Pixels are independent, so the result does not depend on the number of threads. */
fathom_status image_view_apply(const image_view *view, unsigned threads, float *rgba, size_t count,
                               image_message *message) noexcept {
    return guarded(message, FATHOM_INTERNAL, [&] {
        const std::size_t each = std::max<std::size_t>((count + threads) / std::max(threads, 1u), 4096);
        std::vector<std::future<void>> others;
        for (std::size_t first = each; first < count; first += each)
            others.push_back(std::async(std::launch::async, apply, view,
                                        pixels_of(rgba + 4 * first, std::min(each, count - first))));
        apply(view, pixels_of(rgba, std::min(each, count)));
        for (std::future<void> &other : others) other.get();
    });
}

void image_view_close(image_view *view) noexcept { delete view; }

/* ---- spaces of textures ---- */

struct ocio_space final : image_space {
    OCIO::ConstCPUProcessorRcPtr processor;
    void apply(float *pixels, size_t count, unsigned channels) const override {
        OCIO::PackedImageDesc packed(pixels, static_cast<long>(count), 1, static_cast<long>(channels));
        processor->apply(packed);
    }
};

/* To linear Rec.709, through ACES2065-1 if the config has only that. */
static OCIO::ConstTransformRcPtr way_from(const OCIO::ConstConfigRcPtr &config, const char *space) {
    OCIO::ColorSpaceTransformRcPtr first = OCIO::ColorSpaceTransform::Create();
    first->setSrc(space);
    std::string goal = linear_rec709(config);
    if (goal.empty() && config->hasRole(OCIO::ROLE_INTERCHANGE_SCENE)) {
        OCIO::GroupTransformRcPtr group = OCIO::GroupTransform::Create();
        first->setDst(OCIO::ROLE_INTERCHANGE_SCENE);
        group->appendTransform(first);
        append_builtin(group, "UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD", OCIO::TRANSFORM_DIR_FORWARD);
        append_builtin(group, "UTILITY - ACES-AP1_to_CIE-XYZ-D65_BFD", OCIO::TRANSFORM_DIR_INVERSE);
        append_builtin(group, "UTILITY - ACES-AP1_to_LINEAR-REC709_BFD", OCIO::TRANSFORM_DIR_FORWARD);
        return group;
    }
    if (goal.empty()) goal = OCIO::ROLE_SCENE_LINEAR;
    first->setDst(goal.c_str());
    return first;
}

static OCIO::ConstProcessorRcPtr space_processor(const OCIO::ConstConfigRcPtr &config, const char *name) {
    std::string space = config->getColorSpace(name) ? name : "";
    if (space.empty()) {
        space = choose(
            name, "color space", config->getNumColorSpaces(),
            [&](int i) { return config->getColorSpaceNameByIndex(i); }, "srgb, linear or ");
    }
    return config->getProcessor(way_from(config, space.c_str()), OCIO::TRANSFORM_DIR_FORWARD);
}

std::unique_ptr<image_space> space_open(const char *config, const char *name) {
    const std::string at = config ? std::string("OpenColorIO config ") + config + ": " : "";
    try {
        auto out = std::make_unique<ocio_space>();
        out->processor = space_processor(load_config(config), name)->getDefaultCPUProcessor();
        return out;
    } catch (const failure &e) {
        throw failure(e.status, at + e.what());
    } catch (const OCIO::Exception &e) {
        throw failure(FATHOM_BAD_INPUT, at + e.what());
    }
}

/* ---- files of configs ---- */

/* A file inside an archive cannot be opened here; the archive is the config itself. */
static void put_file(hash *h, const char *path) {
    std::ifstream file(path, std::ios::binary);
    char bytes[1 << 14];
    while (file.read(bytes, sizeof bytes), file.gcount() > 0)
        hash_put(h, bytes, static_cast<std::size_t>(file.gcount()));
}

static std::uint64_t hash_files(const OCIO::ConstProcessorRcPtr &processor) {
    OCIO::ConstProcessorMetadataRcPtr names = processor->getProcessorMetadata();
    const int count = names->getNumFiles();
    hash h;
    hash_begin(&h);
    for (int i = 0; i < count; ++i) put_file(&h, names->getFile(i));
    return count ? hash_end(&h) : 0;
}

fathom_status image_view_files(const image_view_request *request, const char *space, uint64_t *out,
                               image_message *message) noexcept {
    return guarded(message, FATHOM_BAD_INPUT, [&] {
        OCIO::ConstConfigRcPtr config = load_config(request->config);
        if (space) {
            *out = hash_files(space_processor(config, space));
        } else {
            const std::string display = choose_display(config, request->display);
            *out = hash_files(view_processor(config, display, choose_view(config, display, request->view)));
        }
    });
}
