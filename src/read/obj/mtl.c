/* Reads MTL: fills in the values of statements. mtl_material.c converts the values to materials. */
#include "read/obj/mtl.h"
#include "math/rgb.h"
#include "read/mesh/number.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef struct mtl_reader {
    text_file file;
    text_fault fault;
    mtl_library *library;
    mtl_entry entry;
    size_t current; /* index of the material being read */
    bool begun;
    mtl_writer writer;
    note_list notes;
} mtl_reader;

static void note_at(mtl_reader *r, const char *at, const char *text) {
    notes_add_at(&r->notes, 1, &r->file, at, false, "%s", text);
}
/* Adds a note that quotes the word at `at`, for texts that do not contain it. */
static void note_word(mtl_reader *r, const char *at, const char *text) {
    notes_add_at(&r->notes, 1, &r->file, at, true, "%s", text);
}

/* Notes values of a material that have no effect here. */
static void note_unused(mtl_reader *r, const fathom_material *value) {
    const mtl_entry *m = &r->entry;
    const int illum = mtl_illum(m);
    const bool mirrors = rgb_any(value->k_r);
    if (mtl_is_metallic(m)) {
        if (mtl_given(m, MTL_TF) && !mtl_is_black(m->tf))
            note_at(r, m->at[MTL_TF], "Tf next to Pr, Pm, Pc, Ps or aniso is read as transmission");
        return;
    }
    if (mtl_given(m, MTL_KA) && mtl_is_white(m->ka) && illum != 0)
        note_at(r, m->at[MTL_KA], "a white Ka is left out; the surface reflects ambient light by its Kd");
    if (mtl_given(m, MTL_KS) && !mtl_is_black(m->ks) && illum >= 2 && m->ns < 1 && !mirrors)
        note_at(r, m->at[MTL_KS], "there is no highlight where Ns is missing or less than 1");
    if (mtl_given(m, MTL_TF) && !mtl_is_white(m->tf) && !mtl_is_glass(m))
        note_at(r, m->at[MTL_TF], "Tf is left out where illum is not glass (4, 6, 7 or 9)");
    if (illum == 10) note_at(r, m->at[MTL_ILLUM], "illum 10 is read as 2");
}

/* Maya and Google Poly write opaque surfaces as glass with a filter of 1: there, Tf is 1 - transparency.
 * Their Ni is 1 unless the material refracts. Cinema 4D writes them as glass of which nothing else is said.
 */
static void settle_glass(mtl_reader *r) {
    mtl_entry *m = &r->entry;
    const unsigned filters = 1u << MTL_TF | 1u << MTL_NI, fades = 1u << MTL_D | 1u << MTL_TR;
    if (!mtl_is_glass(m) || mtl_is_metallic(m)) return;
    if (!(m->given & (filters | fades))) {
        note_at(r, m->at[MTL_ILLUM],
                "illum 4, 6, 7 and 9 without Ni, Tf and d are read as 2, as Cinema 4D means them");
        m->illum = 2;
    } else if (m->illum == 4 && (m->given & (filters | fades)) == filters) {
        note_at(r, m->at[MTL_TF],
                "illum 4 with Tf and Ni, but without d, is read as Maya means it: Tf 1 is opaque");
        m->d = (m->tf[0] + m->tf[1] + m->tf[2]) / 3;
        m->illum = m->ni == 1 || m->d == 1 ? 2 : 7;
        m->given = (m->given | 1u << MTL_D) & ~(1u << MTL_TF);
        m->at[MTL_D] = m->at[MTL_TF];
    }
}

/* Tr 1 would make a surface invisible. MeshLab writes it for opaque surfaces, and old Blender d 0 next to an
 * image. */
static void settle_opacity(mtl_reader *r, bool has_image) {
    mtl_entry *m = &r->entry;
    if (m->d > 0 || mtl_is_glass(m)) return;
    if (has_image) {
        note_at(r, m->at[mtl_given(m, MTL_D) ? MTL_D : MTL_TR],
                "d 0 with map_d is read as 1; else nothing of the surface would be seen");
        m->d = 1;
    } else if (mtl_given(m, MTL_TR) && !(mtl_given(m, MTL_D) && m->at[MTL_D] > m->at[MTL_TR])) {
        note_at(r, m->at[MTL_TR], "Tr 1 is read as opaque, as MeshLab means it; else nothing would be seen");
        m->d = 1;
    } else {
        note_at(r, m->at[MTL_D], "surfaces of d 0 are not seen");
    }
}

/* Old Blender writes Kd 0, and 3ds Max Ke 0, next to an image that it means as it is. Whoever wants black
 * needs no image. */
static void settle_color(mtl_reader *r, const mtl_image images[FATHOM_MAPS]) {
    mtl_entry *m = &r->entry;
    const bool black = mtl_is_black(m->kd) && !mtl_is_metallic(m),
               replaced = r->writer >= MTL_BY_OLDER_BLENDER && !mtl_is_white(m->kd);
    if (images[FATHOM_MAP_COLOR].file && (black || replaced)) {
        note_at(r, m->at[MTL_KD],
                black ? "Kd 0 with map_Kd is read as 1, as other programs do; else the image is black"
                      : "Kd with map_Kd is read as 1: the image replaces it in the program that wrote it");
        for (int k = 0; k < 3; ++k) m->kd[k] = 1;
    }
    if (images[FATHOM_MAP_EMISSIVE].file && mtl_is_black(m->ke)) {
        note_at(r, m->at[MTL_KE], "Ke 0 with map_Ke is read as 1; else the image is black");
        for (int k = 0; k < 3; ++k) m->ke[k] = 1;
    }
    /* That of glass is scaled by what does not pass. */
    if (!mtl_is_glass(m) && fmax(m->kd[0], fmax(m->kd[1], m->kd[2])) > 1) {
        note_at(r, m->at[MTL_KD], "Kd above 1 would reflect more light than arrives, and is read as 1");
        for (int k = 0; k < 3; ++k) m->kd[k] = fmin(m->kd[k], 1);
    }
}

static void finish_material(mtl_reader *r) {
    if (!r->begun) return;
    mtl_material *m = &r->library->materials.items[r->current];
    mtl_image *opacity = &m->images[FATHOM_MAP_OPACITY], *color = &m->images[FATHOM_MAP_COLOR];
    if (opacity->file && color->file && opacity->map.channel > 3)
        opacity->map.channel = strcmp(opacity->file, color->file) == 0 ? 3 : 0;
    for (int k = 0; k < FATHOM_MAPS; ++k) m->images[k].map.channel %= 4;
    if (mtl_is_principled(r->writer, &r->entry)) mtl_settle_principled(&r->entry);
    settle_glass(r);
    settle_opacity(r, opacity->file);
    settle_color(r, m->images);
    m->value = mtl_material_from(&r->entry);
    m->hidden = r->writer == MTL_BY_BLENDER && m->value.model == FATHOM_MODEL_METALLIC_ROUGHNESS &&
                !color->file && m->value.base_color[0] == 0.8f && m->value.base_color[1] == 0.8f &&
                m->value.base_color[2] == 0.8f;
    note_unused(r, &m->value);
    if (m->images[FATHOM_MAP_NORMAL].file) m->value.normal_scale = (float)m->images[FATHOM_MAP_NORMAL].bump;
    if (m->images[FATHOM_MAP_BUMP].file) m->value.bump_scale = (float)m->images[FATHOM_MAP_BUMP].bump;
}

static void free_images(mtl_material *m) {
    for (int k = 0; k < FATHOM_MAPS; ++k) free(m->images[k].file);
    memset(m->images, 0, sizeof m->images);
}

static bool begin_material(mtl_reader *r, const char *p) {
    finish_material(r);
    size_t length = text_rest(&p, r->file.end);
    if (!length) note_at(r, p, "newmtl: expected a name; only usemtl without a name finds this material");
    uint32_t known = names_find(&r->library->names, p, length);
    if (known == UINT32_MAX) {
        mtl_material material = {.name = strndup(p, length), .library = strdup(r->file.path)};
        if (!material.name || !material.library || !array_push(&r->library->materials, material)) {
            free(material.name);
            free(material.library);
            return text_no_memory(&r->fault);
        }
        known = names_add(&r->library->names, material.name, length);
        if (known == UINT32_MAX) return text_no_memory(&r->fault);
    }
    r->current = known;
    r->begun = true;
    fathom_material plain;
    fathom_material_default(&plain);
    free_images(&r->library->materials.items[known]);
    r->entry = (mtl_entry){.ns = 0, .d = 1};
    for (int k = 0; k < 3; ++k) r->entry.kd[k] = (double)plain.k_d[k];
    return true;
}

const mtl_field mtl_fields[MTL_KINDS] = {
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
    [MTL_PR] = {"Pr", offsetof(mtl_entry, pr), 1, 0, 1},
    [MTL_PM] = {"Pm", offsetof(mtl_entry, pm), 1, 0, 1},
    [MTL_PC] = {"Pc", offsetof(mtl_entry, pc), 1, 0, 1},
    [MTL_PCR] = {"Pcr", offsetof(mtl_entry, pcr), 1, 0, 1},
    [MTL_PS] = {"Ps", offsetof(mtl_entry, ps), 1, 0, 1},
    [MTL_ANISO] = {"aniso", offsetof(mtl_entry, aniso), 1, 0, 1},
    [MTL_ANISOR] = {"anisor", offsetof(mtl_entry, anisor), 1, -1, 1},
};

/* Images: the map of each keyword, and the kind of value that an image sets to 1. -1: none. */
static const struct mtl_map {
    const char *keyword;
    int map, kind;
    const char *text; /* why the image is not used */
} mtl_maps[] = {
    {"map_Kd", FATHOM_MAP_COLOR, MTL_KD, NULL},
    {"map_Ks", FATHOM_MAP_SPECULAR_COLOR, MTL_KS, NULL},
    {"map_Ke", FATHOM_MAP_EMISSIVE, MTL_KE, NULL},
    {"map_Ns", FATHOM_MAP_SHININESS, -1, NULL},
    {"map_d", FATHOM_MAP_OPACITY, -1, NULL},
    {"map_Pr", FATHOM_MAP_ROUGHNESS, MTL_PR, NULL},
    {"map_Pm", FATHOM_MAP_METALLIC, MTL_PM, NULL},
    {"map_Pc", FATHOM_MAP_CLEARCOAT, MTL_PC, NULL},
    {"map_Pcr", FATHOM_MAP_CLEARCOAT_ROUGHNESS, MTL_PCR, NULL},
    {"map_Ps", FATHOM_MAP_SHEEN_COLOR, MTL_PS, NULL},
    {"norm", FATHOM_MAP_NORMAL, -1, NULL},
    {"map_Kn", FATHOM_MAP_NORMAL, -1, NULL},
    {"map_bump", FATHOM_MAP_BUMP, -1, NULL},
    {"bump", FATHOM_MAP_BUMP, -1, NULL},
    {"map_Ka", -1, -1, "map_Ka is not read; ambient light is reflected as by Kd"},
    {"disp", -1, -1, "disp is not read; the surface is not displaced"},
    {"map_refl", -1, -1, "refl is not read; mirrors show the scene alone"},
    {"refl", -1, -1, "refl is not read; mirrors show the scene alone"},
};

/* Blender's images of roughness and metalness, unless it writes map_Pr and map_Pm. */
static const struct mtl_map blender_maps[] = {
    {"map_Ns", FATHOM_MAP_ROUGHNESS, MTL_PR, NULL},
    {"map_refl", FATHOM_MAP_METALLIC, MTL_PM, NULL},
    {"refl", FATHOM_MAP_METALLIC, MTL_PM, NULL}, /* of the older exporter */
};

/* The value, clamped to the field's range; `before` for NaN. */
static double limited(mtl_reader *r, const mtl_field *field, const char *at, double value, double before) {
    if (value >= field->lowest && value <= field->highest) return value;
    notes_add_at(&r->notes, 1, &r->file, at, true, "%s: expected a number in [%g, %g]; %s is taken",
                 field->keyword, field->lowest, field->highest, isnan(value) ? "none" : "the nearest");
    return isnan(value) ? before : value > field->highest ? field->highest : field->lowest;
}

/* A single number is used for all three channels of a colour. False, with a note, if the text is not a
 * number: some programs write "1.#QNAN". */
static bool read_numbers(mtl_reader *r, const mtl_field *field, const char *p, double *out) {
    for (int i = 0; i < field->numbers; ++i) {
        const char *at = text_skip(p);
        double value;
        p = at;
        if (i == 1 && (text_is_end(*at) || *at == '#')) {
            out[1] = out[2] = out[0];
            return true;
        }
        if (!number_read(&p, &value) || !text_is_break(*p)) {
            notes_add_at(&r->notes, 1, &r->file, at, true, "%s: expected %s; it is left out", field->keyword,
                         field->numbers == 3 ? "three numbers" : "a number");
            return false;
        }
        out[i] = limited(r, field, at, value, out[i]);
    }
    return true;
}

/* Exporters do not agree on letter case: map_Bump, map_bump, map_D. */
static bool is_word(const char *p, const char *word) {
    size_t length = strlen(word);
    return strncasecmp(p, word, length) == 0 && text_is_break(p[length]);
}

static void read_field(mtl_reader *r, int kind, const char *at) {
    const mtl_field *field = &mtl_fields[kind];
    if (!r->begun) {
        note_word(r, at, "expected newmtl first; statements before it are left out");
        return;
    }
    const char *p = text_skip(at + strlen(field->keyword));
    if (is_word(p, "spectral") || is_word(p, "xyz")) {
        note_word(r, at, "colours as spectra or in xyz are not read");
        return;
    }
    /* A halo would fade towards the outline; the number has the same meaning. */
    if (kind == MTL_D && is_word(p, "-halo")) {
        note_at(r, p, "d -halo is read as d");
        p += 5;
    }
    double *out = mtl_value(&r->entry, kind);
    const mtl_entry before = r->entry;
    if (kind == MTL_TR) *out = 1 - *out; /* a NaN keeps the value, and so d */
    if (!read_numbers(r, field, p, out)) {
        r->entry = before;
        return;
    }
    if (kind == MTL_TR) *out = 1 - *out;
    if (kind == MTL_ILLUM && *out != floor(*out)) {
        note_word(r, p, "illum: expected a whole number from 0 to 10; its fraction is left out");
        *out = floor(*out);
    }
    r->entry.given |= 1u << kind;
    r->entry.at[kind] = at;
}

/* Options such as "-s 2 2": reads up to three numbers; missing ones leave `out` unchanged. */
static const char *read_option_numbers(const char *p, double out[3]) {
    for (int i = 0; i < 3; ++i) {
        const char *next = text_skip(p);
        double value;
        if (!number_read(&next, &value) || !text_is_break(*next) || !isfinite(value)) break;
        out[i] = value;
        p = next;
    }
    return p;
}

static const char *skip_word(const char *p) {
    while (!text_is_break(*p)) ++p;
    return p;
}

/* Reads the options before the name of a file. */
static const char *read_options(mtl_reader *r, const char *p, mtl_image *image) {
    double offset[3] = {0, 0, 0}, size[3] = {1, 1, 1}, unused[3];
    for (p = text_skip(p); *p == '-'; p = text_skip(p)) {
        const char *at = p, *value = text_skip(skip_word(p));
        p = skip_word(value);
        if (is_word(at, "-o")) {
            p = read_option_numbers(value, offset);
        } else if (is_word(at, "-s")) {
            p = read_option_numbers(value, size);
        } else if (is_word(at, "-bm")) {
            p = number_read(&value, &image->bump) ? value : p;
        } else if (is_word(at, "-clamp")) {
            image->clamp = is_word(value, "on");
        } else if (is_word(at, "-imfchan")) {
            image->map.channel = *value == 'g' ? 1 : *value == 'b' ? 2 : *value == 'm' ? 3 : 0;
        } else if (is_word(at, "-mm") || is_word(at, "-t")) {
            p = read_option_numbers(value, unused);
            note_at(r, at, "the options -mm and -t of images are not read");
        }
    }
    const float transform[6] = {(float)size[0],        0, (float)offset[0], 0, (float)-size[1],
                                (float)(1 - offset[1])};
    memcpy(image->map.transform, transform, sizeof transform);
    return p;
}

static bool is_letter(char c) { return isalpha((unsigned char)c); }

/* True if `norm` stands alone in the name: "rock_norm.png" and "rockNorm2.png", but not "enormous.png". */
static bool says_norm(const char *name) {
    for (const char *at = name; (at = strcasestr(at, "norm")) != NULL; ++at) {
        const bool begins = at == name || !is_letter(at[-1]) || *at == 'N';
        if (begins && !is_letter(at[4])) return true;
    }
    return false;
}

bool mtl_says_normal(const char *path) {
    static const char *const words[] = {"normal", "nrm", "_nor", "_n."};
    const char *slash = strrchr(path, '/'), *back = strrchr(path, '\\');
    const char *last = slash > back ? slash : back, *name = last ? last + 1 : path;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) {
        if (strcasestr(name, words[i])) return true;
    }
    return says_norm(name);
}

/* Sets a value to 1 unless the file gave it before; a later statement replaces the 1. */
static void set_one(mtl_reader *r, int kind, const char *at) {
    if (kind < 0 || mtl_given(&r->entry, kind)) return;
    const mtl_field *field = &mtl_fields[kind];
    double *out = mtl_value(&r->entry, kind);
    for (int k = 0; k < field->numbers; ++k) out[k] = 1;
    r->entry.given |= 1u << kind;
    r->entry.at[kind] = at;
}

static bool read_image(mtl_reader *r, const struct mtl_map *map, const char *at) {
    mtl_image image = {.bump = 1,
                       .map = {.texture = FATHOM_NONE, .channel = map->map == FATHOM_MAP_OPACITY ? 4 : 0}};
    const char *p = read_options(r, at + strlen(map->keyword), &image);
    size_t length = text_rest(&p, r->file.end);
    image.file = strndup(p, length);
    if (!image.file) return text_no_memory(&r->fault);
    if (!length) {
        note_at(r, at, "an image without the name of a file is left out");
        free(image.file);
        return true;
    }
    const bool blender = mtl_is_principled(r->writer, &r->entry); /* it has no bump maps under this key */
    const bool normals = map->map == FATHOM_MAP_BUMP && (blender || mtl_says_normal(image.file));
    mtl_image *to = &r->library->materials.items[r->current].images[normals ? FATHOM_MAP_NORMAL : map->map];
    free(to->file);
    *to = image;
    set_one(r, map->kind, at);
    return true;
}

/* *known: whether the statement is an image. False when out of memory. */
static bool read_map(mtl_reader *r, const char *at, bool *known) {
    const size_t own =
        mtl_is_principled(r->writer, &r->entry) ? sizeof blender_maps / sizeof *blender_maps : 0;
    for (size_t i = 0; i < own + sizeof mtl_maps / sizeof *mtl_maps; ++i) {
        const struct mtl_map *map = i < own ? &blender_maps[i] : &mtl_maps[i - own];
        if (!is_word(at, map->keyword)) continue;
        *known = true;
        if (map->map >= 0 && r->begun) return read_image(r, map, at);
        note_at(r, at, map->map < 0 ? map->text : "expected newmtl first; statements before it are left out");
        return true;
    }
    return true;
}

static bool read_line(mtl_reader *r, const char *at) {
    if (text_is_end(*at) && at >= r->file.end) return true;
    if (is_word(at, "newmtl")) return begin_material(r, at + strlen("newmtl"));
    for (int kind = 0; kind < MTL_KINDS; ++kind) {
        if (!is_word(at, mtl_fields[kind].keyword)) continue;
        read_field(r, kind, at);
        return true;
    }
    bool known = false;
    if (!read_map(r, at, &known)) return false;
    if (!known)
        note_word(r, at,
                  strncasecmp(at, "map_", 4) == 0 ? "images of unknown keys are left out"
                                                  : "statements that are not read are left out");
    return true;
}

static fathom_status read_lines(mtl_reader *r) {
    r->writer = mtl_writer_of(&r->file);
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
    for (size_t i = 0; i < library->materials.count; ++i) {
        free(library->materials.items[i].name);
        free(library->materials.items[i].library);
        free_images(&library->materials.items[i]);
    }
    array_free(&library->materials);
    names_free(&library->names);
    *library = (mtl_library){0};
}
