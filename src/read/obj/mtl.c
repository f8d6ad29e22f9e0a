/* Wavefront MTL to Fathom's materials.
 *
 *   Kd      k_d
 *   Ka      k_a; none, or white, means k_d: exporters without an ambient colour write white, which would make
 *           every material reflect the ambient light alike
 *   Ks, Ns  k_s and shininess of Blinn's highlight, as the format defines it ((N·H)^Ns); no highlight if Ns <
 * 1, which exporters write for rough surfaces and which would add Ks to everything that faces a light Ke k_e
 *   Ni      ior for refraction and Fresnel's law; none or 0: 1.5
 *   d, Tr   opacity and 1 - opacity; the last one in the file counts
 *   Tf      filter of the glass models; the others ignore it, because exporters write white everywhere
 *
 *   illum   none: 2 if there is a Ks that is not black, else 1
 *   0       Lambert without ambient light
 *   1       Lambert
 *   2, 10   with highlights
 *   3, 8    and a mirror: k_r = Ks
 *   5       and a mirror by Fresnel's law
 *   4, 9    glass that does not refract (ior 1): k_t, k_r
 *   6       glass: k_t, k_r, ior
 *   7       glass by Fresnel's law
 *
 * Models other than glass dissolve if d < 1: their light is scaled by d, and k_t = 1 - d passes straight on
 * (ior 1). Authors mean this by "illum 2, d 0.3, Ni 1.45". Glass has k_t = 1 - d if d < 1, times Tf if given;
 * else Tf; else 1 - Ks, the format's own formula. Its diffuse part fades as it clears: times d if d < 1, else
 * times 1 - the largest of k_t; highlights stay. Without Fresnel's law k_r is limited to 1 - k_t, which
 * conserves energy. Fresnel's law needs ior != 1; with Ni 1 the mirror is a plain one.
 *
 * Textures are not read. Each is replaced by the least wrong even colour: map_Kd by grey 0.5, because its
 * factor is mostly white; map_Ks and map_Ke by black, because a highlight, mirror or emission everywhere
 * hides the model; map_d by opaque. */
#include "read/mesh/number.h"
#include "read/obj/obj.h"

#include <stdlib.h>
#include <string.h>

/* A material's values as the file gives them. */
typedef struct mtl_entry {
    double ka[3], kd[3], ks[3], ke[3], tf[3], ns, ni, d, illum;
    unsigned given;  /* bits of the kinds below */
    unsigned mapped; /* the same bits: kinds with a texture */
    const char *at[10];
} mtl_entry;

enum { MTL_KA, MTL_KD, MTL_KS, MTL_KE, MTL_TF, MTL_NS, MTL_NI, MTL_D, MTL_TR, MTL_ILLUM, MTL_KINDS };
_Static_assert(sizeof(((mtl_entry *)0)->at) == MTL_KINDS * sizeof(char *), "a place for each kind");

static bool given(const mtl_entry *m, int kind) { return m->given >> kind & 1; }

static void set(float out[3], const double rgb[3], double factor) {
    for (int k = 0; k < 3; ++k) out[k] = (float)(factor * rgb[k]);
}

static double largest(const float rgb[3]) {
    return fmax((double)rgb[0], fmax((double)rgb[1], (double)rgb[2]));
}

/* Sets k_t and k_r of the glass models; returns the factor of the diffuse part. */
static double make_glass(const mtl_entry *m, bool fresnel, fathom_material *out) {
    const double white[3] = {1, 1, 1}, clear[3] = {1 - m->ks[0], 1 - m->ks[1], 1 - m->ks[2]};
    bool dissolves = m->d < 1, filters = given(m, MTL_TF);
    set(out->k_t, filters ? m->tf : dissolves || fresnel ? white : clear, dissolves ? 1 - m->d : 1);
    for (int k = 0; k < 3; ++k) {
        if (out->k_t[k] < 0) out->k_t[k] = 0;
        float left = out->k_t[k] < 1 ? 1 - out->k_t[k] : 0;
        if (!fresnel && out->k_r[k] > left) out->k_r[k] = left;
    }
    return dissolves ? m->d : fmax(0, 1 - largest(out->k_t));
}

static bool is_white(const double rgb[3]) { return rgb[0] == 1 && rgb[1] == 1 && rgb[2] == 1; }
static bool is_black(const double rgb[3]) { return rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0; }

static int illum_of(const mtl_entry *m) {
    return given(m, MTL_ILLUM) ? (int)m->illum : is_black(m->ks) ? 1 : 2;
}
static bool is_glass(int illum) { return illum == 4 || illum == 6 || illum == 7 || illum == 9; }

static void make_surface(const mtl_entry *m, int illum, fathom_material *out) {
    const double black[3] = {0, 0, 0};
    set(out->k_d, m->kd, 1);
    if (given(m, MTL_KA) && !is_white(m->ka)) set(out->k_a, m->ka, 1);
    if (illum == 0) set(out->k_a, black, 1);
    set(out->k_e, m->ke, 1);
    if (illum >= 2 && m->ns >= 1) {
        out->specular = FATHOM_SPECULAR_BLINN;
        out->shininess = (float)m->ns;
        set(out->k_s, m->ks, 1);
    }
    if (illum >= 3 && illum <= 9) set(out->k_r, m->ks, 1);
}

static void scale(float rgb[3], double factor) {
    for (int k = 0; k < 3; ++k) rgb[k] = (float)(factor * (double)rgb[k]);
}

static fathom_material material_from(const mtl_entry *m) {
    fathom_material out;
    fathom_material_default(&out);
    int illum = illum_of(m);
    bool glass = is_glass(illum), dissolves = !glass && m->d < 1;
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

typedef struct mtl_reader {
    text_file file;
    text_fault fault;
    mtl_library *library;
    mtl_entry entry;
    size_t current; /* index of the material that is being read */
    bool begun;
    note_list notes;
} mtl_reader;

static void note_at(mtl_reader *r, const char *at, const char *text) {
    notes_add_at(&r->notes, 1, &r->file, at, false, "%s", text);
}
/* With the word at that place, if the text does not name it. */
static void note_word(mtl_reader *r, const char *at, const char *text) {
    notes_add_at(&r->notes, 1, &r->file, at, true, "%s", text);
}

/* Notes values of a material that have no effect here. */
static void note_unused(mtl_reader *r) {
    const mtl_entry *m = &r->entry;
    const int illum = illum_of(m);
    if (given(m, MTL_KA) && is_white(m->ka) && illum != 0)
        note_at(r, m->at[MTL_KA], "a white Ka is left out; the surface reflects ambient light by its Kd");
    if (given(m, MTL_KS) && !is_black(m->ks) && illum >= 2 && m->ns < 1)
        note_at(r, m->at[MTL_KS], "there is no highlight where Ns is missing or less than 1");
    if (given(m, MTL_TF) && !is_white(m->tf) && !is_glass(illum))
        note_at(r, m->at[MTL_TF], "Tf is left out where illum is not glass (4, 6, 7 or 9)");
    if (illum == 10) note_at(r, m->at[MTL_ILLUM], "illum 10 is read as 2");
}

static void without_textures(mtl_entry *m) {
    if (m->mapped >> MTL_KA & 1) m->given &= ~(1u << MTL_KA);
    if (m->mapped >> MTL_KS & 1) memset(m->ks, 0, sizeof m->ks);
    if (m->mapped >> MTL_KE & 1) memset(m->ke, 0, sizeof m->ke);
    for (int k = 0; k < 3 && m->mapped >> MTL_KD & 1; ++k) m->kd[k] *= 0.5;
}

static void finish_material(mtl_reader *r) {
    if (!r->begun) return;
    without_textures(&r->entry);
    note_unused(r);
    r->library->materials.items[r->current].value = material_from(&r->entry);
}

static bool begin_material(mtl_reader *r, const char *p) {
    finish_material(r);
    size_t length = text_rest(&p, r->file.end);
    if (!length) note_at(r, p, "newmtl: expected a name; only usemtl without a name finds this material");
    uint32_t known = names_find(&r->library->names, p, length);
    if (known == UINT32_MAX) {
        mtl_material material = {.name = strndup(p, length)};
        if (!material.name || !array_push(&r->library->materials, material)) {
            free(material.name);
            return text_no_memory(&r->fault);
        }
        known = names_add(&r->library->names, material.name, length);
        if (known == UINT32_MAX) return text_no_memory(&r->fault);
    }
    r->current = known;
    r->begun = true;
    fathom_material plain;
    fathom_material_default(&plain);
    r->entry = (mtl_entry){.ns = 0, .d = 1};
    for (int k = 0; k < 3; ++k) r->entry.kd[k] = (double)plain.k_d[k];
    return true;
}

static const struct mtl_field {
    const char *keyword;
    size_t offset;
    int numbers;
    double lowest, highest;
} mtl_fields[MTL_KINDS] = {
    [MTL_KA] = {"Ka", offsetof(mtl_entry, ka), 3, 0, 1e9},
    [MTL_KD] = {"Kd", offsetof(mtl_entry, kd), 3, 0, 1e9},
    [MTL_KS] = {"Ks", offsetof(mtl_entry, ks), 3, 0, 1e9},
    [MTL_KE] = {"Ke", offsetof(mtl_entry, ke), 3, 0, 1e9},
    [MTL_TF] = {"Tf", offsetof(mtl_entry, tf), 3, 0, 1},
    [MTL_NS] = {"Ns", offsetof(mtl_entry, ns), 1, 0, 1e9},
    [MTL_NI] = {"Ni", offsetof(mtl_entry, ni), 1, 0, 1e9},
    [MTL_D] = {"d", offsetof(mtl_entry, d), 1, 0, 1},
    [MTL_TR] = {"Tr", offsetof(mtl_entry, d), 1, 0, 1},
    [MTL_ILLUM] = {"illum", offsetof(mtl_entry, illum), 1, 0, 10},
};

/* Textures: the kind whose value they change, and what is said. */
static const struct mtl_map {
    const char *keyword;
    int kind; /* -1: nothing changes */
    const char *text;
} mtl_maps[] = {
    {"map_Kd", MTL_KD, "map_Kd is not read; the texture is taken as an even grey of 0.5"},
    {"map_Ka", MTL_KA, "map_Ka is not read; Ka is left out with it"},
    {"map_Ks", MTL_KS, "map_Ks is not read; Ks is left out with it: no highlight, no mirror"},
    {"map_Ke", MTL_KE, "map_Ke is not read; Ke is left out with it: nothing is emitted"},
    {"map_d", -1, "map_d is not read; d applies alone"},
    {"map_Ns", -1, "map_Ns is not read; Ns applies alone"},
    {"map_bump", -1, "map_bump is not read; the surface is smooth"},
    {"map_Bump", -1, "map_bump is not read; the surface is smooth"},
    {"bump", -1, "map_bump is not read; the surface is smooth"},
    {"norm", -1, "norm is not read; the surface is smooth"},
    {"disp", -1, "disp is not read; the surface is not displaced"},
    {"refl", -1, "refl is not read; mirrors show the scene alone"},
};

/* The value, or the nearest one in the field's range; `before` for NaN. */
static double limited(mtl_reader *r, const struct mtl_field *field, const char *at, double value,
                      double before) {
    if (value >= field->lowest && value <= field->highest) return value;
    notes_add_at(&r->notes, 1, &r->file, at, true, "%s: expected a number in [%g, %g]; %s is taken",
                 field->keyword, field->lowest, field->highest, isnan(value) ? "none" : "the nearest");
    return isnan(value) ? before : value > field->highest ? field->highest : field->lowest;
}

/* One number stands for all three of a colour. */
static bool read_numbers(mtl_reader *r, const struct mtl_field *field, const char *p, double *out) {
    for (int i = 0; i < field->numbers; ++i) {
        const char *at = text_skip(p);
        double value;
        p = at;
        if (i == 1 && (text_is_end(*at) || *at == '#')) {
            out[1] = out[2] = out[0];
            return true;
        }
        if (!number_read(&p, &value) || !text_is_break(*p)) {
            return text_found(&r->fault, at, field->keyword, "expected %s",
                              field->numbers == 3 ? "three numbers" : "a number");
        }
        out[i] = limited(r, field, at, value, out[i]);
    }
    return true;
}

static bool is_word(const char *p, const char *word) {
    size_t length = strlen(word);
    return strncmp(p, word, length) == 0 && text_is_break(p[length]);
}

static bool read_field(mtl_reader *r, int kind, const char *at) {
    const struct mtl_field *field = &mtl_fields[kind];
    if (!r->begun) {
        note_word(r, at, "expected newmtl first; statements before it are left out");
        return true;
    }
    const char *p = text_skip(at + strlen(field->keyword));
    if (is_word(p, "spectral") || is_word(p, "xyz")) {
        note_word(r, at, "colours as spectra or in xyz are not read");
        return true;
    }
    /* A halo would fade towards the outline; the number means the same. */
    if (kind == MTL_D && is_word(p, "-halo")) {
        note_at(r, p, "d -halo is read as d");
        p += 5;
    }
    double *out = (double *)(void *)((char *)&r->entry + field->offset);
    if (!read_numbers(r, field, p, out)) return false;
    if (kind == MTL_TR) *out = 1 - *out;
    if (kind == MTL_ILLUM && *out != floor(*out)) {
        note_word(r, p, "illum: expected a whole number from 0 to 10; its fraction is left out");
        *out = floor(*out);
    }
    r->entry.given |= 1u << kind;
    r->entry.at[kind] = at;
    return true;
}

static bool read_map(mtl_reader *r, const char *at) {
    for (size_t i = 0; i < sizeof mtl_maps / sizeof *mtl_maps; ++i) {
        const struct mtl_map *map = &mtl_maps[i];
        if (!is_word(at, map->keyword)) continue;
        note_at(r, at, map->text);
        if (map->kind >= 0) r->entry.mapped |= 1u << map->kind;
        return true;
    }
    return false;
}

static bool read_line(mtl_reader *r, const char *at) {
    if (text_is_end(*at) && at >= r->file.end) return true;
    if (is_word(at, "newmtl")) return begin_material(r, at + strlen("newmtl"));
    for (int kind = 0; kind < MTL_KINDS; ++kind) {
        if (is_word(at, mtl_fields[kind].keyword)) return read_field(r, kind, at);
    }
    if (!read_map(r, at)) note_word(r, at, "statements that are not read are left out");
    return true;
}

static fathom_status read_lines(mtl_reader *r) {
    for (const char *p = r->file.begin; p < r->file.end;) {
        p = text_skip(p);
        bool empty = *p == '\n' || *p == '#';
        if (!empty && !read_line(r, p)) return text_status(&r->file, &r->fault);
        const char *newline = memchr(p, '\n', (size_t)(r->file.end - p));
        p = !empty ? text_next(p, r->file.end) : newline ? newline + 1 : r->file.end;
    }
    finish_material(r);
    return FATHOM_OK;
}

fathom_status mtl_read(fathom_context *context, const char *path, mtl_library *library) {
    file_map map;
    fathom_status status = file_open(context, path, &map);
    if (status == FATHOM_BAD_INPUT) {
        warn(context, "%s; materials named from it get the default", fathom_context_message(context));
        return FATHOM_OK;
    }
    if (status != FATHOM_OK) return status;
    mtl_reader r = {.library = library};
    status = text_open(context, path, &map, &r.file);
    if (status == FATHOM_OK) {
        text_has_no_zeros(&r.fault, r.file.begin, r.file.end);
        status = text_status(&r.file, &r.fault);
    }
    if (status == FATHOM_OK) status = read_lines(&r);
    if (status == FATHOM_OK) notes_tell(&r.notes, context, path);
    text_close(&r.file);
    return file_finish(context, &map, status);
}

void mtl_free(mtl_library *library) {
    for (size_t i = 0; i < library->materials.count; ++i) free(library->materials.items[i].name);
    array_free(&library->materials);
    names_free(&library->names);
    *library = (mtl_library){0};
}
