/* The library of materials of an OBJ file: the inverse of reading, as far as the format allows.
 *
 * In the format, the classic model has one colour for highlight and mirror, one kind of highlight (Blinn's),
 * and no light from behind. The keys of metallic-roughness materials have few layers and no thin walls; for
 * the latter the classic equivalent is written. A material that only emits is written without these keys.
 * Images have a scale and an offset, and repeat or clamp; v grows upwards. */
#include "read/obj/mtl.h"
#include "write/write_form.h"
#include "write/write_obj.h"

#include <string.h>

static float largest(const float rgb[3]) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

static void give(mtl_entry *e, int kind, double number) {
    *mtl_value(e, kind) = number;
    e->given |= 1u << kind;
}

static void give_color(mtl_entry *e, int kind, const float rgb[3], double factor) {
    for (int k = 0; k < 3; ++k) mtl_value(e, kind)[k] = factor * (double)rgb[k];
    e->given |= 1u << kind;
}

/* ---- the classic model ---- */

/* Without the values that have no effect. */
static fathom_material settled(fathom_material m) {
    if (m.specular == FATHOM_SPECULAR_NONE || write_is_black(m.k_s))
        m.specular = FATHOM_SPECULAR_NONE, m.shininess = 0, memset(m.k_s, 0, sizeof m.k_s);
    if (m.fresnel && m.ior == 1) m.fresnel = false, memset(m.k_r, 0, sizeof m.k_r);
    if (write_is_black(m.k_r) && write_is_black(m.k_t)) m.fresnel = false;
    if (write_is_black(m.k_t) && !m.fresnel) m.ior = 1;
    if (m.k_a[0] < 0) memcpy(m.k_a, m.k_d, sizeof m.k_a);
    return m;
}

/* 1 Lambert, 2 with highlight, 3 with highlight and mirror, 5 the same with Fresnel's law, 6 glass, 7 glass
 * with Fresnel's law, 9 glass without refraction. */
static int illumination(const fathom_material *m) {
    if (!write_is_black(m->k_t)) return m->fresnel ? 7 : m->ior == 1 ? 9 : 6;
    if (!write_is_black(m->k_r)) return m->fresnel ? 5 : 3;
    return m->specular == FATHOM_SPECULAR_NONE ? 1 : 2;
}

static mtl_entry classic_entry(const fathom_material *m) {
    const int illum = illumination(m);
    const bool glass = illum == 6 || illum == 7 || illum == 9;
    /* The reader multiplies the diffuse part of glass by 1 - the maximum of k_t. */
    const double most = (double)largest(m->k_t), left = glass && most < 1 ? 1 - most : 1;
    mtl_entry e = {.d = 1};
    give_color(&e, MTL_KD, m->k_d, 1 / left);
    if (memcmp(m->k_a, m->k_d, sizeof m->k_a) != 0) give_color(&e, MTL_KA, m->k_a, 1 / left);
    give_color(&e, MTL_KS, illum >= 3 ? m->k_r : m->k_s, 1);
    if (!write_is_black(m->k_e)) give_color(&e, MTL_KE, m->k_e, 1);
    if (m->specular != FATHOM_SPECULAR_NONE) give(&e, MTL_NS, (double)(float)write_blinn_exponent(m));
    if (illum >= 5) give(&e, MTL_NI, (double)m->ior);
    if (glass) give_color(&e, MTL_TF, m->k_t, 1);
    give(&e, MTL_ILLUM, illum);
    return e;
}

/* ---- metallic-roughness ---- */

/* In turns, of which the format has at most one. */
static double turns_of(float radians) {
    const double turn = 2 * 3.14159265358979323846;
    return remainder((double)radians, turn) / turn;
}

/* The reader uses Ps as a white sheen of this roughness; the format has no key for another one. */
static bool is_sheen(const fathom_material *m) {
    const float *c = m->sheen_color;
    return c[0] == c[1] && c[0] == c[2] && m->sheen_roughness == 0.5f && c[0] > 0 && c[0] <= 1;
}

static mtl_entry emission_entry(const fathom_material *m) {
    const float black[3] = {0, 0, 0};
    mtl_entry e = {.d = 1};
    give_color(&e, MTL_KD, black, 1);
    give_color(&e, MTL_KS, black, 1);
    give_color(&e, MTL_KE, m->emissive, 1);
    give(&e, MTL_D, (double)m->opacity);
    give(&e, MTL_ILLUM, 1);
    return e;
}

/* flips: the file's v has the other direction, and with it the side to which the rotation turns. */
static mtl_entry metallic_entry(const fathom_material *m, bool flips) {
    mtl_entry e = {.d = 1};
    give_color(&e, MTL_KD, m->base_color, 1);
    if (!write_is_black(m->emissive)) give_color(&e, MTL_KE, m->emissive, 1);
    give(&e, MTL_PR, (double)m->roughness);
    give(&e, MTL_PM, (double)m->metallic);
    give(&e, MTL_PC, (double)m->clearcoat);
    give(&e, MTL_PCR, (double)m->clearcoat_roughness);
    give(&e, MTL_ANISO, (double)m->anisotropy);
    give(&e, MTL_ANISOR, turns_of(flips ? 0 - m->anisotropy_rotation : m->anisotropy_rotation));
    give(&e, MTL_D, (double)m->opacity);
    give(&e, MTL_NI, (double)m->ior);
    if (m->transmission > 0) give_color(&e, MTL_TF, (const float[3]){1, 1, 1}, (double)m->transmission);
    if (is_sheen(m)) give(&e, MTL_PS, (double)m->sheen_color[0]);
    return e;
}

/* ---- either model ---- */

static form_material_values values_of(const fathom_material *m) {
    form_material_values v = {.material = *m};
    for (int k = 0; k < FATHOM_MAPS; ++k) v.textures[k].file = m->maps[k].texture == FATHOM_NONE ? NULL : "";
    return v;
}

/* Notes the parameters that a reader of the file finds changed. `back`: what it reads. */
static void note_changes(const fathom_material *m, fathom_material back, note_list *notes) {
    form_material_values usual = {0};
    fathom_material_default(&usual.material);
    if (m->opacity_cutoff > 0) usual.material.opacity = NAN; /* vertices may have opacities, too */
    if (m->model == FATHOM_MODEL_CLASSIC) back = settled(back);
    back.normal_scale = m->normal_scale, back.bump_scale = m->bump_scale; /* -bm of the images */
    back.anisotropy_rotation = m->anisotropy_rotation;                    /* a whole turn changes nothing */
    back.thickness = m->thickness;                                        /* nor does a number above 0 */
    const form_material_values before = values_of(m), after = values_of(&back);
    form_note_changes(form_variant(&form_material, (int)m->model), &before, &after, &usual, "MTL", notes);
}

static void put_entry(file_writer *file, const mtl_entry *e) {
    for (int kind = 0; kind < MTL_KINDS; ++kind) {
        const mtl_field *field = &mtl_fields[kind];
        if (!mtl_given(e, kind)) continue;
        file_writer_print(file, "%s", field->keyword);
        for (int i = 0; i < field->numbers; ++i)
            file_writer_print(file, " %.9g",
                              ((const double *)(const void *)((const char *)e + field->offset))[i]);
        file_writer_print(file, "\n");
    }
}

static void put_material(const write_library *l, file_writer *file, const scene_named_material *from) {
    const bool thin = from->value.model != FATHOM_MODEL_CLASSIC && from->value.transmission > 0 &&
                      !(from->value.thickness > 0);
    fathom_material m = thin ? from->classic : from->value;
    if (m.model == FATHOM_MODEL_CLASSIC) m = settled(m);
    for (int k = 0; k < 3; ++k) m.emissive[k] *= m.emissive_strength;
    m.emissive_strength = 1;
    if (thin) notes_add(l->notes, 1, "", "a thin wall that light passes becomes its nearest classic glass");
    const bool classic = m.model == FATHOM_MODEL_CLASSIC, emits = !classic && material_only_emits(&m);
    const mtl_entry e = emits     ? emission_entry(&m)
                        : classic ? classic_entry(&m)
                                  : metallic_entry(&m, l->flips);
    fathom_material back = mtl_material_from(&e);
    if (emits) { /* the keys of metallic-roughness would make it shine, so a classic lamp is written */
        back = m;
        back.opacity_cutoff = 0, back.double_sided = true;
    }
    put_entry(file, &e);
    note_changes(&m, back, l->notes);
}

/* ---- images ---- */

static const struct mtl_image_key {
    const char *key;
    fathom_map_kind map;
    bool color;
} images[] = {{"map_Kd", FATHOM_MAP_COLOR, true},
              {"map_Ks", FATHOM_MAP_SPECULAR_COLOR, true},
              {"map_Ke", FATHOM_MAP_EMISSIVE, true},
              {"map_Ns", FATHOM_MAP_SHININESS, false},
              {"map_d", FATHOM_MAP_OPACITY, false},
              {"map_Pr", FATHOM_MAP_ROUGHNESS, false},
              {"map_Pm", FATHOM_MAP_METALLIC, false},
              {"map_Pc", FATHOM_MAP_CLEARCOAT, false},
              {"map_Pcr", FATHOM_MAP_CLEARCOAT_ROUGHNESS, false},
              {"norm", FATHOM_MAP_NORMAL, true},
              {"map_Bump", FATHOM_MAP_BUMP, false}};
enum { IMAGES = sizeof images / sizeof *images };

static const char *name_of(const write_library *l, const fathom_map *map) {
    return l->images->items[l->images->of_texture[map->texture]].name;
}

/* The reader's transform is u' = s0 u + o0 and v' = 1 - o1 - s1 v, for the v of the file. */
static void put_image(const write_library *l, file_writer *t, const struct mtl_image_key *key,
                      const fathom_material *m) {
    const fathom_map *map = &m->maps[key->map];
    const fathom_texture *texture = &l->scene->textures.items[map->texture];
    const double e = (double)map->transform[4], f = (double)map->transform[5], a = (double)map->transform[0],
                 c = (double)map->transform[2], s1 = l->flips ? e : -e, o1 = l->flips ? 1 - e - f : 1 - f;
    file_writer_print(t, "%s", key->key);
    if (a != 1 || s1 != 1) file_writer_print(t, " -s %.9g %.9g 1", a, s1);
    if (c != 0 || o1 != 0) file_writer_print(t, " -o %.9g %.9g 0", c, o1);
    if (texture->wrap_u == FATHOM_WRAP_CLAMP && texture->wrap_v == FATHOM_WRAP_CLAMP)
        file_writer_print(t, " -clamp on");
    if (!key->color) file_writer_print(t, " -imfchan %c", "rgbm"[map->channel]);
    const float bump = key->map == FATHOM_MAP_NORMAL ? m->normal_scale
                       : key->map == FATHOM_MAP_BUMP ? m->bump_scale
                                                     : 1;
    if (bump != 1) file_writer_print(t, " -bm %.9g", (double)bump);
    file_writer_print(t, " %s%s\n", write_before_name(name_of(l, map)), name_of(l, map));
}

/* True if the format can hold the map's transform and channel. */
static bool is_plain(const fathom_map *map, bool color) {
    return map->uv_set == 0 && !map->inverted && map->transform[1] == 0 && map->transform[3] == 0 &&
           (!color || !map->channel);
}

/* Such an image is written all the same: most texture coordinates lie inside it. */
static bool wraps_otherwise(const fathom_scene *scene, const fathom_map *map) {
    const fathom_texture *texture = &scene->textures.items[map->texture];
    return texture->wrap_u != texture->wrap_v || texture->wrap_u == FATHOM_WRAP_MIRROR;
}

/* Readers take Kd 0 or Ke 0 with an image for 1. A factor of 0 leaves nothing of the image, which then needs
 * no place. */
static bool shows(const fathom_material *m, fathom_map_kind kind) {
    const bool classic = m->model == FATHOM_MODEL_CLASSIC;
    if (kind == FATHOM_MAP_EMISSIVE) return !write_is_black(classic ? m->k_e : m->emissive);
    if (kind == FATHOM_MAP_COLOR) return classic ? !write_is_black(m->k_d) : !material_only_emits(m);
    return true;
}

static void put_images(const write_library *l, file_writer *t, const fathom_material *m) {
    size_t left = 0, wrapped = 0;
    for (fathom_map_kind k = 0; k < FATHOM_MAPS; ++k)
        left += m->maps[k].texture != FATHOM_NONE && shows(m, k);
    for (size_t i = 0; i < IMAGES; ++i) {
        const fathom_map *map = &m->maps[images[i].map];
        if (!shows(m, images[i].map)) continue;
        if (map->texture == FATHOM_NONE || !is_plain(map, images[i].color)) continue;
        if (images[i].map == FATHOM_MAP_BUMP && mtl_says_normal(name_of(l, map))) continue;
        put_image(l, t, &images[i], m);
        wrapped += wraps_otherwise(l->scene, map);
        --left;
    }
    if (left)
        notes_add(
            l->notes, left, "",
            "an image that MTL has no place for, by its parameter, its turn or its uv set, is left out");
    notes_add(l->notes, wrapped, "",
              "an image that is mirrored, or clamped in one direction, repeats outside of itself");
}

fathom_status write_mtl(const write_library *l, const char *path) {
    file_writer *file;
    fathom_status status = file_writer_open(l->scene->context, path, &file);
    if (status != FATHOM_OK) return status;
    form_prepare();
    file_writer_print(file, "# Fathom %s\n", fathom_version());
    for (size_t i = 0; i < l->scene->materials.count; ++i) {
        const fathom_material *m = &l->scene->materials.items[i].value;
        file_writer_print(file, "newmtl %s\n", l->names[i]);
        put_material(l, file, &l->scene->materials.items[i]);
        put_images(l, file, m);
    }
    return file_writer_commit(file);
}
