/* The tables of settings and of material parameters. To add one, add a row here and a member to the
 * struct. */
#include "base/sized.h"
#include "scene/scene.h"
#include "scene/settings.h"

#include <stdio.h>
#include <string.h>

#define SETTING(member) offsetof(fathom_settings, member)
#define MATERIAL(member) offsetof(fathom_material, member)

#define BOOL FATHOM_PARAMETER_BOOL
#define U32 FATHOM_PARAMETER_U32
#define U64 FATHOM_PARAMETER_U64
#define F32 FATHOM_PARAMETER_F32
#define F64 FATHOM_PARAMETER_F64
#define WORD FATHOM_PARAMETER_WORD
#define WORDS FATHOM_PARAMETER_WORDS
#define TEXT FATHOM_PARAMETER_TEXT

#define PIXELS FATHOM_PARAMETER_PIXELS
#define SWITCH FATHOM_PARAMETER_SWITCH
#define IN_FILE FATHOM_PARAMETER_FILE
#define COMMAND FATHOM_PARAMETER_COMMAND
#define ABOVE FATHOM_PARAMETER_OPEN_LOW
#define BELOW FATHOM_PARAMETER_OPEN_HIGH
#define HARD (PIXELS | IN_FILE)
#define SOFT (HARD | FATHOM_PARAMETER_SOFT)

#define SAMPLING "Sampling to an error or a time (with the pattern sobol)"
/* The maximum of radiances and of other values without a natural limit. */
#define RADIANCE 1e30

/* clang-format off */
static const fathom_parameter setting_rows[] = {
    /* name, type, member, flags, low, high, default, unit, group, help */
    {"width", U32, SETTING(width), PIXELS | IN_FILE, 1, 65536, 1280, "PIXELS", "Image",
     .help = "Pixels across. If absent, it follows from `height` and the camera's `w` and `h`."},
    {"height", U32, SETTING(height), PIXELS | IN_FILE, 1, 65536, 720, "PIXELS", "Image",
     .help = "Pixels down. If absent, it follows from `width` and the camera's `w` and `h`."},
    {"integrator", WORD, SETTING(integrator), PIXELS | IN_FILE | COMMAND, 0, 0, FATHOM_INTEGRATOR_PATH, NULL, "Light transport",
     .help = "`classic`: recursive ray tracing with point and directional lights, mirrors and glass. `path`: global "
     "illumination by path tracing. `reference`: a second, simple path tracer in double precision.", .words = "classic|path|reference"},
    {"spp", U32, SETTING(spp), PIXELS | IN_FILE | COMMAND, 1, 65536, 1024, "N", "Image",
     .help = "Samples per pixel. Default: up to 1024, until `targetError` is reached; with `classic` 1, or 16 for a "
     "model on the command line. Must be a square number unless `pattern` is `sobol`."},
    {"pattern", WORD, SETTING(pattern), PIXELS | IN_FILE | COMMAND, 0, 0, FATHOM_PATTERN_SOBOL, NULL, "Image",
     .help = "Positions of the samples in a pixel: `grid` n x n, regular; `stratified` n x n, jittered; `sobol` an "
     "Owen-scrambled Sobol sequence. Default with `classic`: `grid`.", .words = "grid|stratified|sobol"},
    {"filter", WORD, SETTING(filter), PIXELS | IN_FILE | COMMAND, 0, 0, FATHOM_FILTER_BOX, NULL, "Image",
     .help = "Pixel filter, by importance sampling: `box`, `gaussian` or `blackmanHarris`. See `filterWidth`.", .words = "box|gaussian|blackmanHarris"},
    {"filter_width", F64, SETTING(filter_width), PIXELS | IN_FILE | COMMAND, 0.01, 16, 0, "PIXELS", "Image",
     .help = "Width of the filter; 0: 1 for `box`, 3 for `gaussian` and 4 for `blackmanHarris`.", .zero = "auto"},
    {"seed", U64, SETTING(seed), PIXELS | IN_FILE | COMMAND, 0, INFINITY, 0, "N", "Image",
     .help = "Seed of the random numbers. With `grid` it does not move the samples in a pixel, but changes lenses, "
     "lights and bounces."},
    {"crop", U32, SETTING(crop), PIXELS | IN_FILE | COMMAND, 0, 65536, 0, "X0,Y0,X1,Y1", "Image",
     .help = "Region to render: x0, y0, x1, y1 in pixels from the upper left corner; x1 and y1 are exclusive. All 0: "
     "the whole image.", .count = 4},
    {"target_error", F64, SETTING(target_error), PIXELS | IN_FILE | COMMAND | ABOVE, 0, INFINITY, 0.02, "E", SAMPLING,
     .help = "Adaptive sampling: each tile of 32 x 32 pixels gets samples until its estimated error is at most this; "
     "tiles where a few samples lower the error much get more. 0: every pixel gets `spp` samples. The unit is "
     "that of Cycles' noise threshold: 0.01 is about 1 of 255 display levels. Needs `pattern` `sobol`. `spp` "
     "is then the maximum per pixel, a power of two and at least 4. Off if only `spp` is given, with another "
     "pattern, and with `classic`.", .zero = "off"},
    {"max_time", F64, SETTING(max_time), PIXELS | SWITCH | COMMAND | ABOVE, 0, INFINITY, 0, "SECONDS", SAMPLING,
     .help = "Time for the whole command, from reading to writing, or for each frame of an animation. Samples go where "
     "they lower the error most.",
     .zero = "off"},
    {"min_spp", U32, SETTING(min_spp), PIXELS | IN_FILE | COMMAND, 4, 65536, 0, "N", SAMPLING,
     .help = "Minimum samples per pixel with adaptive sampling: a power of two and at least 4; 0: 4.", .zero = "auto"},
    {"max_depth", U32, SETTING(max_depth), PIXELS | IN_FILE | COMMAND, 0, 1024, 16, "N", "Light transport",
     .help = "Maximum number of bounces. `classic` follows mirror reflections and refractions only; its default is 8."},
    {"min_weight", F32, SETTING(min_weight), PIXELS | IN_FILE | COMMAND | BELOW, 0, 1, 1.0 / 65536, "W", "Light transport",
     .help = "Only `classic`: a path ends when no channel of its pixel can change by more than this. `path` uses "
     "Russian roulette instead, from the fourth vertex on."},
    {"max_loss", F32, SETTING(max_loss), PIXELS, 0, 1, 0, NULL, NULL, .help = "Light that a pixel may lose."},
    {"max_relative_loss", F32, SETTING(max_relative_loss), PIXELS, 0, 1, 0, NULL, NULL,
     .help = "Share of its light that a pixel may lose."},
    {"epsilon", F64, SETTING(epsilon), PIXELS | IN_FILE | COMMAND | ABOVE, 0, INFINITY, 0, "E", "Light transport",
     .help = "Fixed ray offset: rays start at this distance along their direction. 0: the offset follows from error "
     "bounds, which works at any scale.",
     .zero = "auto"},
    {"terminator_fix", BOOL, SETTING(terminator_fix), PIXELS | IN_FILE | COMMAND, 0, 1, true, NULL, "Light transport",
     .help = "Shadow terminator fix (Hanika 2021): a smooth mesh is lit wherever its normals face the light. Rays to "
     "below a facet's horizon start above it, on the round surface. Without it, black triangles appear near the "
     "terminator of coarse meshes."},
    {"photons", BOOL, SETTING(photons), PIXELS | IN_FILE | COMMAND, 0, 1, true, NULL, "Light transport",
     .help = "Photons for caustics, with `path`: light that smooth mirrors and glass throw onto other surfaces. No "
     "expected value depends on it. Without it, paths alone find this light, and small lamps make speckles. A "
     "camera inside glass, or very far away, has none."},
    {"aovs", WORDS, SETTING(aovs), PIXELS | IN_FILE, 0, FATHOM_AOVS & ~(unsigned)(FATHOM_AOV_ALPHA | FATHOM_AOV_ERROR), 0, "LIST", "Output",
     .help = "More outputs in an EXR file: coverage; depth; shading normal; world position; `kd` + `ks`; the ids of "
     "object, primitive and instance; samples of the pixel; standard error of each channel; light scattered "
     "once, more often, and not at all; light of each light group; Cryptomatte of objects and of materials; "
     "motion vectors. `error` makes images of a fixed number of samples noisier, because it divides the "
     "samples into four independent groups.",
     .words = "alpha|Z|N|P|albedo|id|samples|error|direct|indirect|emission|lightGroups|cryptoObject|cryptoMaterial|motion"},
    {"tracer", TEXT, SETTING(tracer), COMMAND, 0, 0, 0, "SPEC|FILE.so", "Light transport",
     .help = "Tracer: embree, bvh, linear or reference (short for linear:f32), with options such as bvh:f64, "
     "linear:f64 or embree:user:high:16; or a shared library as in fathom/plugin.h."},
    {"block_width", U32, SETTING(block_width), COMMAND, 1, 16, 16, "N", "Running",
     .help = "Rays in one call of Embree; no pixel depends on it.", .words = "1|4|8|16"},
    {"tile_size", U32, SETTING(tile_size), COMMAND, 32, 65536, 32, "N", "Running",
     .help = "Pixels along a tile's side; no pixel depends on it.", .step = 32},
    {"memory_limit", U64, SETTING(memory_limit), COMMAND, 1e6, 1e15, 0, "BYTES", "Running",
     .help = "Maximum memory, such as 8G; auto: what is free. If only Embree's compact structures fit, Fathom uses "
     "them; if not even these fit, it does not start. Other tracers ignore it.", .zero = "auto"},
    {"texture_memory", U64, SETTING(texture_memory), COMMAND, 1e6, 1e15, 1e9, "BYTES", "Running",
     .help = "Maximum memory for texture tiles, such as 512M; the others go to a temporary file. No pixel depends on "
     "it."},
    {"fireflies", WORD, SETTING(fireflies), PIXELS | COMMAND, 0, 0, FATHOM_FIREFLIES_KEEP, NULL, "Output",
     .help = "Rare bright samples: `keep`; or `reweight` to write a second image, NAME.reweighted.EXT, in which they count "
     "less (Zirr et al. 2018). The first image is the same.", .words = "keep|reweight"},
    {"motion_blur", BOOL, SETTING(motion_blur), PIXELS | IN_FILE | COMMAND, 0, 1, true, NULL, "Light transport",
     .help = "Motion blur: samples cover the time that the shutter is open. If off, all samples are at the middle of "
     "that time, for programs that add the blur from the AOV `motion`."},
};

static const fathom_parameter classic_rows[] = {
    /* name, type, member, flags, low, high, default, unit, group, help */
    {"k_d", F32, MATERIAL(k_d), SOFT, 0, 1, 0.5, "R,G,B", "Surface", .help = "Diffuse reflectance (Lambert).", .count = 3},
    {"k_s", F32, MATERIAL(k_s), SOFT, 0, RADIANCE, 0, "R,G,B", "Surface",
     .help = "Specular reflectance; needs `specular`. White for plastic, coloured for metal.", .count = 3},
    {"specular", WORD, MATERIAL(specular), HARD, 0, 0, FATHOM_SPECULAR_NONE, NULL, "Surface",
     .help = "Shape of the highlight: `phong` max(0, v·r)ⁿ, `blinn` max(0, n·h)ⁿ.", .words = "none|phong|blinn"},
    {"shininess", F32, MATERIAL(shininess), HARD, 0, 1e9, 32, "N", "Surface",
     .help = "The exponent n of the highlight; higher is smaller and sharper. Needs `specular`."},
    {"k_r", F32, MATERIAL(k_r), SOFT, 0, 1, 0, "R,G,B", "Surface", .help = "Mirror reflectance.", .count = 3},
    {"k_t", F32, MATERIAL(k_t), SOFT, 0, 1, 0, "R,G,B", "Surface",
     .help = "Transmittance: how much passes through, refracted by `ior`.", .count = 3},
    {"ior", F32, MATERIAL(ior), SOFT, 1e-3, 1e3, 1.5, NULL, "Surface",
     .help = "Index of refraction of the inside over the outside: 1.33 water, 1.5 glass, 2.42 diamond."},
    {"fresnel", BOOL, MATERIAL(fresnel), HARD, 0, 1, false, NULL, "Surface",
     .help = "Divides light between reflection and refraction by angle: `kr` is multiplied by Fresnel's F and `kt` by "
     "1 − F. On total internal reflection F is 1, so only `kr` remains; without `fresnel` the reflected ray "
     "then carries `kr` + `kt`."},
    {"k_a", F32, MATERIAL(k_a), SOFT, 0, 1, -1, "R,G,B", "Surface", .help = "Reflectance for `ambient` light. Default: `kd`.",
     .count = 3},
    {"k_e", F32, MATERIAL(k_e), SOFT, 0, RADIANCE, 0, "R,G,B", "Surface",
     .help = "Radiance emitted by both sides, measured outside any glass around the surface. Lights other surfaces "
     "under path tracing.", .count = 3},
    {"normal_scale", F32, MATERIAL(normal_scale), HARD, -1e3, 1e3, 1, NULL, "Surface",
     .help = "Multiplies the slopes of `normalTexture`."},
    {"bump_scale", F32, MATERIAL(bump_scale), SOFT, -1e6, 1e6, 1, "LENGTH", "Surface",
     .help = "Height of the surface in units of length where `bumpTexture` is 1."},
    {"lit_from_behind", BOOL, MATERIAL(lit_from_behind), HARD, 0, 1, false, NULL, "Surface",
     .help = "Lights behind the surface light its front too, as on thin cloth or paper."},
};

static const fathom_parameter metallic_rows[] = {
    {"base_color", F32, MATERIAL(base_color), SOFT, 0, 1, 1, "R,G,B", "Surface",
     .help = "Colour of the metal, or of the base under the dielectric.", .count = 3},
    {"metallic", F32, MATERIAL(metallic), HARD, 0, 1, 0, NULL, "Surface",
     .help = "0: dielectric, 1: metal; values between mix both."},
    {"roughness", F32, MATERIAL(roughness), HARD, 0, 1, 0.5, NULL, "Surface",
     .help = "Roughness; its square is GGX's alpha. Below an alpha of 2⁻¹³ the surface is a mirror."},
    {"emissive", F32, MATERIAL(emissive), SOFT, 0, RADIANCE, 0, "R,G,B", "Surface",
     .help = "Radiance emitted by both sides, times `emissiveStrength`, measured outside any glass around the surface.", .count = 3},
    {"emissive_strength", F32, MATERIAL(emissive_strength), SOFT, 0, RADIANCE, 1, NULL, "Surface",
     .help = "Factor of `emissive`."},
    {"ior", F32, MATERIAL(ior), SOFT, 0, 1e3, 1.5, NULL, "Surface",
     .help = "Index of refraction of the dielectric; 0: it reflects all of `specularColor`."},
    {"specular", F32, MATERIAL(specular_factor), HARD, 0, 1, 1, NULL, "Surface",
     .help = "Strength of the dielectric's reflection."},
    {"specular_color", F32, MATERIAL(specular_color), SOFT, 0, 1e6, 1, "R,G,B", "Surface",
     .help = "Factor of the dielectric's reflectance at normal incidence. Its product with the reflectance of `ior` is "
     "at most 1.", .count = 3},
    {"transmission", F32, MATERIAL(transmission), HARD, 0, 1, 0, NULL, "Surface",
     .help = "Fraction of the dielectric's base that transmits light, tinted by `baseColor`, instead of scattering it."},
    {"thickness", F32, MATERIAL(thickness), SOFT, 0, RADIANCE, 0, NULL, "Surface",
     .help = "Above 0: the surface bounds a volume, and light refracts; 0: it is a thin wall. The number itself does not matter."},
    {"attenuation_color", F32, MATERIAL(attenuation_color), SOFT, 0, 1, 1, "R,G,B", "Surface",
     .help = "Colour of white light after `attenuationDistance` in the volume.", .count = 3},
    {"attenuation_distance", F32, MATERIAL(attenuation_distance), SOFT, 0, RADIANCE, 0, NULL, "Surface",
     .help = "Distance of `attenuationColor`; 0: nothing is absorbed."},
    {"clearcoat", F32, MATERIAL(clearcoat), HARD, 0, 1, 0, NULL, "Surface",
     .help = "Strength of a clear layer over everything, of index 1.5."},
    {"clearcoat_roughness", F32, MATERIAL(clearcoat_roughness), HARD, 0, 1, 0, NULL, "Surface",
     .help = "The layer's `roughness`."},
    {"sheen_color", F32, MATERIAL(sheen_color), SOFT, 0, 1, 0, "R,G,B", "Surface",
     .help = "Colour of the sheen, from fibres on the surface as on velvet; black: none.", .count = 3},
    {"sheen_roughness", F32, MATERIAL(sheen_roughness), HARD, 0, 1, 0, NULL, "Surface",
     .help = "Roughness of the sheen: how far the fibres lean. Values below 0.07 count as 0.07."},
    {"anisotropy", F32, MATERIAL(anisotropy), HARD, 0, 1, 0, NULL, "Surface",
     .help = "Stretches reflections along the tangent (direction of u). The grooves of brushed metal run across it."},
    {"anisotropy_rotation", F32, MATERIAL(anisotropy_rotation), SOFT, -1e6, 1e6, 0, "RADIANS", "Surface",
     .help = "Rotation of that direction in radians, from the tangent towards the bitangent (against v)."},
    {"iridescence", F32, MATERIAL(iridescence), HARD, 0, 1, 0, NULL, "Surface",
     .help = "Strength of a thin film, as of oil or soap."},
    {"iridescence_ior", F32, MATERIAL(iridescence_ior), SOFT, 1, 5, 1.3, NULL, "Surface",
     .help = "Index of refraction of the film."},
    {"iridescence_thickness_min", F32, MATERIAL(iridescence_thickness_min), SOFT, 0, 1e6, 100, "NANOMETRES", "Surface",
     .help = "Thickness of the film in nanometres where `iridescenceThicknessTexture` is 0."},
    {"iridescence_thickness_max", F32, MATERIAL(iridescence_thickness_max), SOFT, 0, 1e6, 400, "NANOMETRES", "Surface",
     .help = "Thickness of the film in nanometres where `iridescenceThicknessTexture` is 1, or without that texture."},
    {"dispersion", F32, MATERIAL(dispersion), SOFT, 0, 1e3, 0, NULL, "Surface",
     .help = "Dispersion of a volume: 20 divided by the Abbe number; 0.36 for diamond. More than 40 counts as 40."},
    {"diffuse_transmission", F32, MATERIAL(diffuse_transmission), HARD, 0, 1, 0, NULL, "Surface",
     .help = "Fraction of the diffuse light that leaves on the other side, as through leaves."},
    {"diffuse_transmission_color", F32, MATERIAL(diffuse_transmission_color), SOFT, 0, 1, 1, "R,G,B", "Surface",
     .help = "Colour of that light.", .count = 3},
    {"priority", U32, MATERIAL(priority), HARD, 0, 255, 0, "N", "Surface",
     .help = "Where volumes overlap, the one of highest priority fills the space. Give a glass 2 and the drink in it "
     "1, for example. 0: no priority; `ior` is then relative to empty space, even inside another volume."},
    {"opacity", F32, MATERIAL(opacity), HARD, 0, 1, 1, NULL, "Surface",
     .help = "Coverage: the fraction of rays that hit the surface. The others pass through."},
    {"opacity_cutoff", F32, MATERIAL(opacity_cutoff), HARD, 0, 1e3, 0, NULL, "Surface",
     .help = "Alpha cutoff. Above 0: the surface is absent where `opacity` is below it, and fully opaque elsewhere."},
    {"normal_scale", F32, MATERIAL(normal_scale), HARD, -1e3, 1e3, 1, NULL, "Surface",
     .help = "Multiplies the slopes of `normalTexture`."},
    {"clearcoat_normal_scale", F32, MATERIAL(clearcoat_normal_scale), HARD, -1e3, 1e3, 1, NULL, "Surface",
     .help = "Multiplies the slopes of `clearcoatNormalTexture`."},
    {"bump_scale", F32, MATERIAL(bump_scale), SOFT, -1e6, 1e6, 1, "LENGTH", "Surface",
     .help = "Height of the surface in units of length where `bumpTexture` is 1."},
    {"double_sided", BOOL, MATERIAL(double_sided), HARD, 0, 1, true, NULL, "Surface",
     .help = "`false`: the camera looks through the back of the surface; shadows and other rays still hit it. Volumes "
     "have two sides."},
    {"multiscatter", BOOL, MATERIAL(multiscatter), HARD, 0, 1, true, NULL, "Surface",
     .help = "Adds the energy that rough surfaces lose without multiple scattering between microfacets. `false`: glTF's "
     "formulas alone."},
};
/* clang-format on */

#define TABLE(rows)                                                                                          \
    { rows, sizeof(rows) / sizeof *(rows) }
const parameter_table settings_table = TABLE(setting_rows), classic_table = TABLE(classic_rows),
                      metallic_table = TABLE(metallic_rows);

parameter_table material_table(fathom_model model) {
    return model == FATHOM_MODEL_CLASSIC ? classic_table : metallic_table;
}

const fathom_parameter *fathom_settings_parameters(size_t *count) {
    if (count) *count = settings_table.count;
    return settings_table.rows;
}

const fathom_parameter *fathom_material_parameters(fathom_model model, size_t *count) {
    const parameter_table table = material_table(model);
    if (count) *count = table.count;
    return table.rows;
}

void fathom_settings_default_sized(fathom_settings *out, size_t size) {
    fathom_settings settings = {.size = size};
    parameters_default(settings_table, &settings);
    sized_give(out, size, &settings, sizeof settings);
}

void fathom_material_default_sized(fathom_material *out, size_t size) {
    fathom_material material;
    memset(&material, 0, sizeof material);
    parameters_default(classic_table, &material);
    parameters_default(metallic_table, &material);
    for (int k = 0; k < FATHOM_MAPS; ++k)
        material.maps[k] = (fathom_map){.texture = FATHOM_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    sized_give(out, size, &material, sizeof material);
}

static fathom_status check_maps(fathom_context *context, const fathom_material *m) {
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        const fathom_map *map = &m->maps[k];
        bool fine = map->uv_set <= 1 && map->channel <= 3;
        if (map->texture == FATHOM_NONE) continue;
        for (int i = 0; i < 6; ++i) fine &= isfinite(map->transform[i]) != 0;
        if (!fine)
            return fail(context, FATHOM_BAD_INPUT,
                        "maps[%d]: expected uv_set 0 or 1, channel 0 to 3 and a finite transform; found %u "
                        "and %u",
                        k, map->uv_set, map->channel);
    }
    return FATHOM_OK;
}

/* Checks only the members of the material's model. A negative first entry of k_a means k_d. */
fathom_status scene_check_material(fathom_context *context, const fathom_material *material) {
    fathom_material m = *material;
    if ((unsigned)m.model > FATHOM_MODEL_METALLIC_ROUGHNESS)
        return fail_field(context, FATHOM_BAD_USAGE, "model", "expected a fathom_model, found %u",
                          (unsigned)m.model);
    if (m.k_a[0] < 0) memcpy(m.k_a, m.k_d, sizeof m.k_a);
    fathom_status status = parameters_check(context, material_table(m.model), &m);
    return status == FATHOM_OK ? check_maps(context, &m) : status;
}

void settings_print(const fathom_settings *settings, char out[SETTINGS_TEXT]) {
    memset(out, 0, SETTINGS_TEXT);
    for (size_t i = 0, used = 0; i < settings_table.count; ++i) {
        const fathom_parameter *p = &settings_table.rows[i];
        char name[PARAMETER_NAME], value[PARAMETER_TEXT];
        if (!(p->flags & PIXELS)) continue;
        parameter_name(p, ' ', name);
        parameter_print(p, settings, value, sizeof value);
        const bool on = p->flags & SWITCH && parameter_number(p, settings, 0) != 0;
        used += (size_t)snprintf(out + used, SETTINGS_TEXT - used, "%s=%s; ", name, on ? "on" : value);
    }
}
