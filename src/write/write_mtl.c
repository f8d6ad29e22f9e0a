/* The library of materials of an OBJ file: the inverse of reading, as far as the format allows.
 *
 * In the format, the classic model has one colour for highlight and mirror, one kind of highlight (Blinn's),
 * and no light from behind. The keys of metallic-roughness materials have few layers and no thin walls; for
 * the latter the classic equivalent is written. A material that only emits is written without these keys.
 * Images have a scale and an offset, and repeat or clamp; v grows upwards. */
#include "read/obj/mtl.h"
#include "write/write_obj.h"

static float largest(const float rgb[3]) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

static void put_color(file_writer *file, const char *key, const float rgb[3], float factor) {
    file_writer_print(file, "%s", key);
    for (int k = 0; k < 3; ++k) file_writer_print(file, " %.9g", (double)(factor * rgb[k]));
    file_writer_print(file, "\n");
}

/* ---- the classic model ---- */

/* 1 Lambert, 2 with highlight, 3 with highlight and mirror, 5 the same with Fresnel's law, 6 glass, 7 glass
 * with Fresnel's law, 9 glass without refraction. */
static int illumination(const fathom_material *m) {
    if (largest(m->k_t) > 0) return m->fresnel ? 7 : m->ior == 1 ? 9 : 6;
    if (largest(m->k_r) > 0) return m->fresnel ? 5 : 3;
    return m->specular == FATHOM_SPECULAR_NONE ? 1 : 2;
}

static void note_classic(const fathom_material *m, note_list *notes) {
    const bool shines = m->specular != FATHOM_SPECULAR_NONE && largest(m->k_s) > 0;
    if (shines && illumination(m) >= 3)
        notes_add(notes, 1, "", "a highlight on a mirror or on glass has no place in MTL");
    else if (shines && m->specular == FATHOM_SPECULAR_PHONG)
        notes_add(notes, 1, "", "a Phong highlight becomes a Blinn one of the same width");
    if (largest(m->k_t) >= 1 && largest(m->k_d) > 0)
        notes_add(notes, 1, "", "diffuse light of glass that lets all light through has no place in MTL");
    if (m->lit_from_behind) notes_add(notes, 1, "", "light from behind a surface has no place in MTL");
}

static void put_classic(file_writer *t, const fathom_material *m, note_list *notes) {
    int illum = illumination(m);
    bool glass = illum == 6 || illum == 7 || illum == 9;
    /* The reader multiplies the diffuse part of glass by 1 - the maximum of k_t. */
    float left = glass && largest(m->k_t) < 1 ? 1 - largest(m->k_t) : 1;
    put_color(t, "Kd", m->k_d, 1 / left);
    if (m->k_a[0] >= 0) put_color(t, "Ka", m->k_a, 1 / left);
    put_color(t, "Ks",
              illum >= 3                            ? m->k_r
              : m->specular == FATHOM_SPECULAR_NONE ? (const float[3]){0}
                                                    : m->k_s,
              1);
    if (largest(m->k_e) > 0) put_color(t, "Ke", m->k_e, 1);
    file_writer_print(t, "Ns %.9g\n", (double)(float)write_blinn_exponent(m));
    if (illum >= 5) file_writer_print(t, "Ni %.9g\n", (double)m->ior);
    if (glass) put_color(t, "Tf", m->k_t, 1);
    file_writer_print(t, "illum %d\n", illum);
    note_classic(m, notes);
}

/* ---- metallic-roughness ---- */

static const struct mtl_number {
    const char *key;
    size_t offset;
} numbers[] = {{"Pr", offsetof(fathom_material, roughness)},
               {"Pm", offsetof(fathom_material, metallic)},
               {"Pc", offsetof(fathom_material, clearcoat)},
               {"Pcr", offsetof(fathom_material, clearcoat_roughness)},
               {"aniso", offsetof(fathom_material, anisotropy)},
               {"d", offsetof(fathom_material, opacity)},
               {"Ni", offsetof(fathom_material, ior)}};

/* In turns, of which the format has at most one. */
static double turns_of(float radians) {
    const double turn = 2 * 3.14159265358979323846;
    return remainder((double)radians, turn) / turn;
}

static bool is_black(const float rgb[3]) { return !(largest(rgb) > 0); }

static bool is_white(const float rgb[3]) { return rgb[0] == 1 && rgb[1] == 1 && rgb[2] == 1; }

/* The reader uses Ps as a white sheen of this roughness; the format has no key for another one. */
static bool is_sheen(const fathom_material *m) {
    const float *c = m->sheen_color;
    return c[0] == c[1] && c[0] == c[2] && m->sheen_roughness == 0.5f && c[0] > 0 && c[0] <= 1;
}

static void put_emission(file_writer *t, const fathom_material *m, note_list *notes) {
    const float black[3] = {0, 0, 0};
    put_color(t, "Kd", black, 1);
    put_color(t, "Ks", black, 1);
    put_color(t, "Ke", m->emissive, m->emissive_strength);
    file_writer_print(t, "d %.9g\nillum 1\n", (double)m->opacity);
    if (m->opacity_cutoff > 0) notes_add(notes, 1, "", "a material has a cutoff that MTL has no place for");
}

static void put_metallic(file_writer *t, const fathom_material *m, note_list *notes) {
    put_color(t, "Kd", m->base_color, 1);
    if (!is_black(m->emissive)) put_color(t, "Ke", m->emissive, m->emissive_strength);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
        const float value = *(const float *)(const void *)((const char *)m + numbers[i].offset);
        file_writer_print(t, "%s %.9g\n", numbers[i].key, (double)value);
    }
    file_writer_print(t, "anisor %.9g\n", turns_of(m->anisotropy_rotation));
    if (m->transmission > 0) put_color(t, "Tf", (const float[3]){1, 1, 1}, m->transmission);
    if (is_sheen(m)) file_writer_print(t, "Ps %.9g\n", (double)m->sheen_color[0]);
    if (m->specular_factor != 1 || !is_white(m->specular_color) ||
        (!is_sheen(m) && !is_black(m->sheen_color)) || m->iridescence > 0 || m->diffuse_transmission > 0 ||
        m->opacity_cutoff > 0 || !(m->ior >= 1) || m->priority || !m->multiscatter || !m->double_sided ||
        (m->transmission > 0 && (m->attenuation_distance > 0 || m->dispersion > 0)))
        notes_add(
            notes, 1, "",
            "a material has layers, a tint, a cutoff, a volume, one side or a setting that MTL has no place "
            "for");
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
    if (texture->wrap_u == FATHOM_WRAP_CLAMP) file_writer_print(t, " -clamp on");
    if (!key->color) file_writer_print(t, " -imfchan %c", "rgbm"[map->channel]);
    const float bump = key->map == FATHOM_MAP_NORMAL ? m->normal_scale
                       : key->map == FATHOM_MAP_BUMP ? m->bump_scale
                                                     : 1;
    if (bump != 1) file_writer_print(t, " -bm %.9g", (double)bump);
    file_writer_print(t, " %s%s\n", write_before_name(name_of(l, map)), name_of(l, map));
}

/* True if the format can hold the map's transform, wrap mode and channel. */
static bool is_plain(const fathom_scene *scene, const fathom_map *map, bool color) {
    const fathom_texture *texture = &scene->textures.items[map->texture];
    return map->uv_set == 0 && !map->inverted && map->transform[1] == 0 && map->transform[3] == 0 &&
           texture->wrap_u == texture->wrap_v && texture->wrap_u != FATHOM_WRAP_MIRROR &&
           (!color || !map->channel);
}

/* Readers take Kd 0 with an image for 1. A factor of 0 leaves nothing of the image, which then needs no
 * place.
 */
static bool shows_color(const fathom_material *m) {
    return m->model == FATHOM_MODEL_CLASSIC ? !is_black(m->k_d) : !write_only_emits(m);
}

static void put_images(const write_library *l, file_writer *t, const fathom_material *m) {
    size_t left = 0;
    const bool has_color = shows_color(m);
    for (int k = 0; k < FATHOM_MAPS; ++k)
        left += m->maps[k].texture != FATHOM_NONE && (k != FATHOM_MAP_COLOR || has_color);
    for (size_t i = 0; i < IMAGES; ++i) {
        const fathom_map *map = &m->maps[images[i].map];
        if (images[i].map == FATHOM_MAP_COLOR && !has_color) continue;
        if (map->texture == FATHOM_NONE || !is_plain(l->scene, map, images[i].color)) continue;
        if (images[i].map == FATHOM_MAP_BUMP && mtl_says_normal(name_of(l, map))) continue;
        put_image(l, t, &images[i], m);
        --left;
    }
    if (left)
        notes_add(l->notes, left, "",
                  "an image that MTL has no place for, by its parameter, its turn, its uv set "
                  "or its wrapping, is left out");
}

/* ---- file ---- */

bool write_mtl_flips(const fathom_scene *scene) {
    for (size_t i = 0; i < scene->materials.count; ++i) {
        for (int k = 0; k < FATHOM_MAPS; ++k) {
            const fathom_map *map = &scene->materials.items[i].value.maps[k];
            if (map->texture != FATHOM_NONE) return map->transform[4] > 0;
        }
    }
    return false;
}

fathom_status write_mtl(const write_library *l, const char *path) {
    file_writer *file;
    fathom_status status = file_writer_open(l->scene->context, path, &file);
    if (status != FATHOM_OK) return status;
    file_writer_print(file, "# Fathom %s\n", fathom_version());
    for (size_t i = 0; i < l->scene->materials.count; ++i) {
        const fathom_material *m = &l->scene->materials.items[i].value;
        file_writer_print(file, "newmtl %s\n", l->names[i]);
        const bool thin = m->model != FATHOM_MODEL_CLASSIC && m->transmission > 0 && !(m->thickness > 0);
        if (thin)
            notes_add(l->notes, 1, "", "a thin wall that light passes becomes its nearest classic glass");
        if (write_only_emits(m)) /* the keys of metallic-roughness would make it shine */
            put_emission(file, m, l->notes);
        else if (m->model == FATHOM_MODEL_CLASSIC || thin)
            put_classic(file, &l->scene->materials.items[i].classic, l->notes);
        else
            put_metallic(file, m, l->notes);
        put_images(l, file, m);
    }
    return file_writer_commit(file);
}
