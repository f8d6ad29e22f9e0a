/* Converts Wavefront MTL to Fathom's materials.
 *
 *   Kd      k_d, at most 1; 0 next to map_Kd means 1
 *   Ka      k_a; if missing or white, k_d is used: exporters without an ambient colour write white, and
 *           every material would reflect the same ambient light
 *   Ks, Ns  k_s and shininess of Blinn's highlight, as the format defines it ((N·H)^Ns). Ns < 1 means no
 *           highlight: exporters write it for rough surfaces, and it would add Ks to all lit surfaces
 *   Ke      k_e; 0 next to map_Ke means 1
 *   Ni      ior for refraction and Fresnel's law; missing or 0: 1.5
 *   d, Tr   opacity and 1 - opacity; the last one in the file is used. Tr 1 means opaque, as does d 0 with
 *           map_d, except for glass
 *   Tf      filter of the glass models; other models ignore it, because exporters always write white
 *
 *   illum   if missing: 2 if Ks is given and not black, else 1
 *   0       Lambert without ambient light
 *   1       Lambert
 *   2, 10   Lambert with highlights
 *   3, 8    the same with a mirror: k_r = Ks
 *   5       the same with a mirror by Fresnel's law
 *   4, 9    glass that does not refract (ior 1): k_t, k_r
 *   6       glass: k_t, k_r, ior
 *   7       glass by Fresnel's law
 *
 * Blender writes opacity as 9 with d < 1 and no Tf; this is read as 2. Maya writes all materials as 4 with Tf
 * and Ni, but without d; Tf is then d, and 4 is read as 2, or as 7 if Ni is not 1. Cinema 4D writes them as 7
 * without Ni, Tf and d; this is read as 2.
 *
 * Models other than glass are partly transparent if d < 1: their light is multiplied by d, and k_t = 1 - d
 * passes straight through (ior 1). Authors mean this by "illum 2, d 0.3, Ni 1.45". Glass has k_t = 1 - d if
 * d < 1, times Tf if given; else Tf; else 1 - Ks, the format's own formula. Its diffuse part is multiplied by
 * d if d < 1, else by 1 - the maximum of k_t; its highlights are not. Without Fresnel's law k_r is limited to
 * 1 - k_t, which conserves energy. Fresnel's law needs ior != 1; with Ni 1 the mirror does not use it.
 *
 * Pr, Pm, Pc, Ps and aniso (roughness, metalness, clear coat, sheen, anisotropy) select metallic-roughness.
 * Kd is then the base colour, d the opacity, Ni the ior, and Tf the transmission of the solid: Blender writes
 * Tf only for such materials. Pcr is the clear coat's roughness. Ps is a white sheen. Its roughness is
 * 0.5, because the format has no key for it. Blender's sheen of 1 is (1 - l·h)^5 (Burley 2012). Its albedo,
 * 0.077 to 0.001 from a cosine of 0.05 to one of 0.9, is that of a Ps of 0.104 within 0.008. anisor is a
 * fraction of a full turn. Ke is the emission. Other values above have no effect.
 *
 * Images (map_Kd map_Ks map_Ke map_Ns map_d map_Pr map_Pm map_Pc map_Ps norm) multiply their values, which
 * default to 1 if there is an image. A single number is the image's red channel; for map_d it is alpha if
 * map_Kd has the same image; -imfchan selects another channel. -s, -o and -clamp are used; v grows upwards in
 * this format. map_Bump and bump are heights; -bm is the height of value 1 in units of length. If the name of
 * a bump image says that it is a normal map, or Blender 2.8 or later wrote the file, it is one, and -bm its
 * factor.
 *
 * Blender 2.8 and later write the values of its Principled BSDF, also without Pr: Ns is 1000 (1 -
 * roughness)^2, Ka the metalness if illum is 3 or 6, and 0.08 Ks the reflectance at normal incidence, which
 * Ni is not; Ks 0 is no reflection at any angle. (The first versions had 900 in place of 1000: the roughness
 * changes by at most 0.052.) map_Ns and map_refl, or refl, are images of roughness and metalness. In 3ds Max,
 * AliceVision and Blender before 3.2, map_Kd replaces Kd, which they write all the same. */
#include "read/obj/mtl.h"

#include <stdlib.h>

static void set(float out[3], const double rgb[3], double factor) {
    for (int k = 0; k < 3; ++k) out[k] = (float)(factor * rgb[k]);
}

static double largest(const float rgb[3]) {
    return fmax((double)rgb[0], fmax((double)rgb[1], (double)rgb[2]));
}

/* Sets k_t and k_r of the glass models; returns the factor of the diffuse part. */
static double make_glass(const mtl_entry *m, bool fresnel, fathom_material *out) {
    const double white[3] = {1, 1, 1}, clear[3] = {1 - m->ks[0], 1 - m->ks[1], 1 - m->ks[2]};
    bool dissolves = m->d < 1, filters = mtl_given(m, MTL_TF);
    set(out->k_t, filters ? m->tf : dissolves || fresnel ? white : clear, dissolves ? 1 - m->d : 1);
    for (int k = 0; k < 3; ++k) {
        if (out->k_t[k] < 0) out->k_t[k] = 0;
        float left = out->k_t[k] < 1 ? 1 - out->k_t[k] : 0;
        if (!fresnel && out->k_r[k] > left) out->k_r[k] = left;
    }
    return dissolves ? m->d : fmax(0, 1 - largest(out->k_t));
}

int mtl_illum(const mtl_entry *m) {
    return mtl_given(m, MTL_ILLUM) ? (int)m->illum : mtl_is_black(m->ks) ? 1 : 2;
}

bool mtl_is_glass(const mtl_entry *m) {
    const int illum = mtl_illum(m);
    if (illum == 9 && m->d < 1 && !mtl_given(m, MTL_TF)) return false;
    return illum == 4 || illum == 6 || illum == 7 || illum == 9;
}

static void make_surface(const mtl_entry *m, int illum, fathom_material *out) {
    const double black[3] = {0, 0, 0};
    set(out->k_d, m->kd, 1);
    if (mtl_given(m, MTL_KA) && !mtl_is_white(m->ka)) set(out->k_a, m->ka, 1);
    if (illum == 0) set(out->k_a, black, 1);
    set(out->k_e, m->ke, 1);
    if (illum >= 2 && m->ns >= 1) {
        out->specular = FATHOM_SPECULAR_BLINN;
        out->shininess = (float)m->ns;
        set(out->k_s, m->ks, 1);
    }
    if (illum >= 3 && (illum < 9 || (illum == 9 && mtl_is_glass(m)))) set(out->k_r, m->ks, 1);
}

static void scale(float rgb[3], double factor) {
    for (int k = 0; k < 3; ++k) rgb[k] = (float)(factor * (double)rgb[k]);
}

bool mtl_is_metallic(const mtl_entry *m) {
    return mtl_given(m, MTL_PR) || mtl_given(m, MTL_PM) || mtl_given(m, MTL_PC) || mtl_given(m, MTL_PS) ||
           mtl_given(m, MTL_ANISO);
}

static fathom_material metallic_from(const mtl_entry *m) {
    fathom_material out;
    fathom_material_default(&out);
    out.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    set(out.base_color, m->kd, 1);
    for (int k = 0; k < 3; ++k) out.base_color[k] = out.base_color[k] < 1 ? out.base_color[k] : 1;
    set(out.emissive, m->ke, 1);
    if (mtl_given(m, MTL_PR)) out.roughness = (float)m->pr;
    out.metallic = (float)m->pm;
    out.clearcoat = (float)m->pc, out.clearcoat_roughness = (float)m->pcr;
    out.anisotropy = (float)m->aniso, out.anisotropy_rotation = (float)(2 * 3.14159265358979 * m->anisor);
    for (int k = 0; k < 3; ++k) out.sheen_color[k] = (float)m->ps;
    out.sheen_roughness = m->ps > 0 ? 0.5f : 0;
    out.opacity = (float)m->d;
    out.transmission = (float)((m->tf[0] + m->tf[1] + m->tf[2]) / 3);
    out.thickness = out.transmission > 0 ? 1 : 0;
    if (m->ni >= 1) out.ior = (float)m->ni;
    if (m->ni == 1) out.specular_factor = 0; /* Schlick's formula alone would reflect at grazing angles */
    return out;
}

static fathom_material classic_from(const mtl_entry *m) {
    fathom_material out;
    fathom_material_default(&out);
    int illum = mtl_illum(m);
    bool glass = mtl_is_glass(m), dissolves = !glass && m->d < 1;
    bool straight = illum == 4 || illum == 9 || dissolves;
    make_surface(m, illum, &out);
    out.ior = straight ? 1 : m->ni > 0 ? (float)m->ni : 1.5f;
    out.fresnel = (illum == 5 || illum == 7) && out.ior != 1;
    double left = glass ? make_glass(m, out.fresnel, &out) : m->d;
    scale(out.k_d, left);
    if (out.k_a[0] >= 0) scale(out.k_a, left);
    if (dissolves) {
        const double white[3] = {1, 1, 1};
        set(out.k_t, white, 1 - m->d);
        scale(out.k_s, left);
        scale(out.k_r, left);
        scale(out.k_e, left);
    }
    return out;
}

fathom_material mtl_material_from(const mtl_entry *m) {
    return mtl_is_metallic(m) ? metallic_from(m) : classic_from(m);
}

/* ---- images ---- */

fathom_status mtl_open_images(fathom_scene *scene, const mtl_material *material, size_t *lost,
                              fathom_material *out) {
    fathom_status status = FATHOM_OK;
    for (int k = 0; k < FATHOM_MAPS && status == FATHOM_OK; ++k) {
        const mtl_image *image = &material->images[k];
        char *path = NULL;
        fathom_texture t;
        if (!image->file) continue;
        fathom_texture_default(&t);
        status = read_image_beside(scene, material->library, image->file, &path);
        if (status == FATHOM_OK && !path) {
            if (++*lost <= MTL_LOST_IMAGES)
                warn(
                    scene->context,
                    read_is_outside(scene, material->library, image->file)
                        ? "%s: material \"%.80s\": the image \"%.200s\" " READ_OUTSIDE
                        : "%s: material \"%.80s\": there is no image \"%.200s\" that may be read; it is left "
                          "out",
                    material->library, material->name, image->file);
            read_without_image(k, out);
            continue;
        }
        if (status != FATHOM_OK) return status;
        t.file = path;
        const bool color = material_map_is_color(k) && k != FATHOM_MAP_SHEEN_COLOR; /* Ps is a number */
        t.color_space = color ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR;
        if (image->clamp) t.wrap_u = t.wrap_v = FATHOM_WRAP_CLAMP;
        out->maps[k] = image->map;
        status = fathom_scene_add_texture(scene, &t, &out->maps[k].texture);
        free(path);
    }
    return status;
}
