/* The model's materials as an OBJ material library: the inverse of reading, as far as the format allows. It
 * has one colour for highlight and mirror, one kind of highlight (Blinn's), and no light from behind. */
#include "write/write.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- names ---- */

/* Whether the name is one word, which any reader takes whole, and not one that a nameless material gets. */
static bool is_word(const char *name) {
    if (!name || !*name || strncmp(name, "material_", 9) == 0) return false;
    for (; *name; ++name) {
        if ((unsigned char)*name <= ' ' || *name == '#') return false;
    }
    return true;
}

/* Two materials with the same name would be one in the file. */
static bool is_first(const fathom_scene *scene, size_t material) {
    return scene_find_material(scene, scene->materials.items[material].name) == material;
}

fathom_status write_names(const fathom_scene *scene, char ***out) {
    size_t count = scene->materials.count;
    char **names = *out = calloc(count, sizeof *names);
    if (!names) return fail_memory(scene->context, count * sizeof *names);
    for (size_t i = 0; i < count; ++i) {
        const char *name = scene->materials.items[i].name;
        char numbered[32];
        snprintf(numbered, sizeof numbered, "material_%zu", i);
        names[i] = strdup(is_word(name) && is_first(scene, i) ? name : numbered);
        if (!names[i]) return fail_memory(scene->context, sizeof numbered);
    }
    return FATHOM_OK;
}

void write_names_free(const fathom_scene *scene, char **names) {
    for (size_t i = 0; names && i < scene->materials.count; ++i) free(names[i]);
    free(names);
}

/* ---- materials ---- */

double write_blinn_exponent(const fathom_material *m) {
    switch (m->specular) {
    case FATHOM_SPECULAR_NONE: return 0;
    case FATHOM_SPECULAR_PHONG: return 4 * (double)m->shininess;
    case FATHOM_SPECULAR_BLINN: return (double)m->shininess;
    }
    return 0;
}

static float largest(const float rgb[3]) { return fmaxf(rgb[0], fmaxf(rgb[1], rgb[2])); }

static void put_color(file_writer *file, const char *key, const float rgb[3], float factor) {
    file_writer_print(file, "%s", key);
    for (int k = 0; k < 3; ++k) file_writer_print(file, " %.9g", (double)(factor * rgb[k]));
    file_writer_print(file, "\n");
}

/* 1 Lambert, 2 with highlight, 3 and a mirror, 5 the same by Fresnel's law, 6 glass, 7 glass by Fresnel's
 * law, 9 glass that does not refract. */
static int illumination(const fathom_material *m) {
    if (largest(m->k_t) > 0) return m->fresnel ? 7 : m->ior == 1 ? 9 : 6;
    if (largest(m->k_r) > 0) return m->fresnel ? 5 : 3;
    return m->specular == FATHOM_SPECULAR_NONE ? 1 : 2;
}

static void put_material(file_writer *t, const char *name, const fathom_material *m) {
    int illum = illumination(m);
    bool glass = illum == 6 || illum == 7 || illum == 9, mirror = illum >= 3 && largest(m->k_r) > 0;
    /* Reading scales the diffuse part of glass by 1 - k_t. */
    float left = glass && largest(m->k_t) < 1 ? 1 - largest(m->k_t) : 1;
    file_writer_print(t, "newmtl %s\n", name);
    put_color(t, "Kd", m->k_d, 1 / left);
    if (m->k_a[0] >= 0) put_color(t, "Ka", m->k_a, 1 / left);
    put_color(t, "Ks",
              mirror                                ? m->k_r
              : m->specular == FATHOM_SPECULAR_NONE ? (const float[3]){0}
                                                    : m->k_s,
              1);
    if (largest(m->k_e) > 0) put_color(t, "Ke", m->k_e, 1);
    file_writer_print(t, "Ns %.9g\n", (double)(float)write_blinn_exponent(m));
    if (illum >= 5) file_writer_print(t, "Ni %.9g\n", (double)m->ior);
    if (glass) put_color(t, "Tf", m->k_t, 1);
    file_writer_print(t, "illum %d\n", illum);
}

fathom_status write_mtl(const fathom_scene *scene, const char *path, char **names) {
    file_writer *file;
    fathom_status status = file_writer_open(scene->context, path, &file);
    if (status != FATHOM_OK) return status;
    file_writer_print(file, "# Fathom %s\n", fathom_version());
    for (size_t i = 0; i < scene->materials.count; ++i)
        put_material(file, names[i], &scene->materials.items[i].classic);
    return file_writer_commit(file);
}
